//! The measures as Markdown.

use std::fmt::Write as _;

use super::Made;

const HEAD: &str = "\
| | profiles (whole) | particles | overlap | lattice | fraction, photograph | placed | in the end | nearest, x | y | z | largest component | wrap seam (largest inside) | s: masks | shapes | placing | pushing | cells | matrix | all |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|
";

/// The table.
pub(crate) fn table(made: &[Made]) -> String {
    made.iter().fold(HEAD.to_owned(), |mut text, one| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", row(one));
        text
    })
}

/// One row.
pub(crate) fn row(one: &Made) -> String {
    let r = &one.report;
    let number = |n: Option<f64>| n.map_or_else(|| "–".to_owned(), |n| format!("{n:.2}"));
    let [x, y, z] = r.nearest.map(number);
    let took = |name: &str| one.stages.iter().filter(|s| s.0.contains(name)).map(|s| s.1).sum::<f64>();
    let stages = ["shapes", "belong", "arrangement", "lattice", "push", "cells"];
    let [swept, belong, arranged, lattice, pushed, cells] = stages.map(took);
    let shapes = swept + belong;
    format!(
        "| {} | {} ({}) | {} | {} | {} | {:.3} | {:.3} | {:.3} | {x} | {y} | {z} | {:.2} | {} ({}) | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} | {:.1} |",
        one.name,
        one.profiles[0],
        one.profiles[1],
        r.particles,
        r.overlap,
        number(r.lattice),
        r.fraction_photographs,
        r.fraction_placed,
        r.fraction,
        r.largest_component,
        number(r.wrap_seam),
        number(r.wrap_seam_inside),
        one.analysis,
        shapes,
        arranged + lattice,
        pushed,
        cells,
        one.seconds - shapes - arranged - lattice - pushed - cells,
        one.seconds,
    )
}
