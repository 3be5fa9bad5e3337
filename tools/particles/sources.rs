//! The photographs, and how their particles are found.

use lapis::colour::Colour;
use lapis::particles::{ClassParams, MaskParams, Phase, Tiling};

/// A photograph, and its settings.
pub(crate) struct Source {
    pub(crate) name: &'static str,
    pub(crate) file: &'static str,
    /// Slices across x, y and z that it is for.
    pub(crate) axes: [bool; 3],
    pub(crate) mask: MaskParams,
    pub(crate) classes: ClassParams,
}

const ALL: [bool; 3] = [true; 3];
/// Upright in the photograph: y is down, and what lies across it is left to itself.
const UPRIGHT: [bool; 3] = [true, false, true];

fn tiling() -> MaskParams {
    MaskParams { tiles: Tiling::Both, ..MaskParams::default() }
}

fn source(name: &'static str, file: &'static str, axes: [bool; 3], mask: MaskParams) -> Source {
    Source { name, file, axes, mask, classes: ClassParams::default() }
}

/// All eight.
pub(crate) fn all() -> Vec<Source> {
    vec![
        source("bricks", "acg_brick_Bricks006.png", UPRIGHT, tiling()),
        source("cobbles", "acg_cobble_PavingStones010.png", ALL, tiling()),
        source(
            "stone-wall",
            "acg_stonewall_Rocks004.png",
            UPRIGHT,
            MaskParams {
                even: Some(5.0),
                threshold: Some(-0.015),
                particles: Phase::Light,
                smooth: 0.5,
                ..tiling()
            },
        ),
        source("pebbles-dense", "acg_pebbles_in_matrix_Rocks023.png", ALL, tiling()),
        source(
            "rocks-sparse",
            "acg_rocks_in_matrix_Rocks019.png",
            ALL,
            MaskParams { smooth: 0.5, split: 0.95, fill_holes: 0.01, ..tiling() },
        ),
        Source {
            classes: ClassParams { classes: 6, ..ClassParams::default() },
            ..source(
                "terrazzo",
                "acg_terrazzo_Terrazzo009.png",
                ALL,
                MaskParams {
                    matrix: Some(Colour([0xec, 0xe6, 0xde, 255])),
                    smooth: 0.3,
                    least: 6,
                    ..tiling()
                },
            )
        },
        source(
            "cells",
            "morpholibj_plantcells_apple_parenchyma.png",
            ALL,
            MaskParams { split: 0.85, smooth: 2.0, least: 250, ..MaskParams::default() },
        ),
        source("paving", "acg_block_PavingStones006.png", UPRIGHT, tiling()),
    ]
}
