//! What the page says of each model, in the order of the page.

/// One model of the page.
pub(crate) struct Model {
    /// The name of its project file, `meshes/NAME.toml`.
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    /// What it is, and what to look at.
    pub(crate) text: &'static str,
    /// What is still wrong with it.
    pub(crate) weak: &'static str,
    /// Its row of Table 1 of the paper, where it has one.
    pub(crate) paper: Option<Paper>,
}

/// A row of Table 1.
pub(crate) struct Paper {
    pub(crate) tetrahedra: u32,
    /// Seconds that a person took to design the tensor field.
    pub(crate) design_s: f64,
    pub(crate) fill_s: f64,
    pub(crate) cut_ms: f64,
    pub(crate) megabytes: f64,
}

/// All models, in the order of Table 1.
pub(crate) const MODELS: [Model; 7] = [
    Model {
        name: "kiwi",
        title: "Kiwi fruit",
        text: "Skin, flesh, seeds and core follow the depth, which is painted as 0 on the skin and 1 on a stretch \
               of the fruit's axis; strokes from pole to pole turn the texture along the fruit. Seven hundred tufts \
               of hair are pasted on the skin, finer than its voxels. Look at the rays: \
               they run from the core outwards in every section, because the texture's second axis is the depth \
               itself. Look at the ends of the core, too, where all directions meet: there seeds are stretched or \
               blended.",
        weak: "hairs lie flat in the skin, and all tufts are copies of one; seeds at the ends of the core are stretched; the outline shows the mesh's facets.",
        paper: Some(Paper { tetrahedra: 4126, design_s: 29.0, fill_s: 39.0, cut_ms: 78.0, megabytes: 9.1 }),
    },
    Model {
        name: "carrot",
        title: "Carrot",
        text: "From outside in: a thin skin with scars across, the orange bast, the bright ring of the cambium, and \
               the paler wood in rays. One unit of texture is the root's radius, wherever that is: so the ring keeps \
               its place, and everything gets finer towards the tip. Look at how the same texture shows rays in a \
               section across and long fibres in one along the root, and at the side roots that cross the bast to \
               end in a scar on the skin. Where its leaves were cut off, their stubs are pasted on.",
        weak: "the leaves' stubs are painted on a low mound, soft from near; the tip's thread is faceted; sharp edges between patches of the skin.",
        paper: Some(Paper { tetrahedra: 2313, design_s: 38.0, fill_s: 31.0, cut_ms: 63.0, megabytes: 7.1 }),
    },
    Model {
        name: "tree",
        title: "Tree",
        text: "A forked trunk: depth is 0 on the bark, which the mesh file names as a group, and 1 along the pith of \
               trunk and limbs; the sawn ends are left unpainted, so that they show rings. Strokes along the limbs \
               turn the fibres. Look at the fork, where the rings of both limbs become those of the trunk, and at \
               the bark, whose ridges follow the limbs. Where depth and directions of two limbs meet, in the crotch, \
               patches are small and their edges show.",
        weak: "near the piths rings are polygons, as the tetrahedra are; where the two piths run together a brown smear is left; in the crotch patches are small and their edges show.",
        paper: Some(Paper {
            tetrahedra: 5012,
            design_s: 76.0,
            fill_s: 104.0,
            cut_ms: 125.0,
            megabytes: 12.2,
        }),
    },
    Model {
        name: "watermelon",
        title: "Watermelon",
        text: "Rind and flesh depend on the depth alone; in the two other directions the texture may turn as it \
               likes, and each copy is turned at random. Six hundred seeds are pasted on top, along a layer. Look at \
               the layers, which follow the rind in every section, and at the seeds, whole wherever a cut meets them, \
               which point to the middle.",
        weak: "the flesh is soft from near, without single cells, and plain about the core.",
        paper: Some(Paper { tetrahedra: 2717, design_s: 17.0, fill_s: 25.0, cut_ms: 63.0, megabytes: 9.0 }),
    },
    Model {
        name: "tube",
        title: "Tube",
        text: "Fibres that follow a bent tube: strokes along it set the direction. Copies of the texture agree, so that \
               bundles go on from one end to the other, whole in every section. Look at the same fibres cut across and \
               cut along. The last picture looks through the tube: its pale pith is made nearly clear, the dark fibres \
               are left.",
        weak: "fibres bend in corners, as the few tetrahedra do; they are soft from near.",
        paper: Some(Paper { tetrahedra: 1089, design_s: 27.0, fill_s: 18.0, cut_ms: 31.0, megabytes: 2.7 }),
    },
    Model {
        name: "strata",
        title: "Strata",
        text: "A block of land. Depth follows the beds, not the ground: strokes run along folded layers, an arch, a \
               trough and a step, and the hills and the valley have been worn out of them. Look at how the same beds \
               come to the surface again and again, and at the pebbles, which lie flat in their bed wherever it goes.",
        weak: "soft from near, since 64 voxels span all seventeen beds; the hill has neither soil nor grass.",
        paper: Some(Paper {
            tetrahedra: 2827,
            design_s: 113.0,
            fill_s: 77.0,
            cut_ms: 110.0,
            megabytes: 10.4,
        }),
    },
    Model {
        name: "cake",
        title: "Cake",
        text: "Four parts in one project: the layers, whose depth runs from top to foot; a coat of cream around them; \
               rosettes and strawberries that stand on the coat. Their tetrahedra are made by hand, with as few as the \
               shapes allow. One cut goes through all. Look at the slice: sponge with its pores, cream and jam, and a \
               berry with its white heart.",
        weak: "rosettes and berries are still faceted at their outlines; here and there patches of a berry's skin halve a seed.",
        paper: Some(Paper {
            tetrahedra: 2734,
            design_s: 34.0,
            fill_s: 416.0,
            cut_ms: 187.0,
            megabytes: 14.5,
        }),
    },
];
