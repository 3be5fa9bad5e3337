//! What hangs together on one side of a cut.

use super::curve::Curve;
use super::divide::Divided;
use crate::mesh::{NONE, TetMesh, index};

/// The connected components of both sides.
#[derive(Debug, Default)]
pub(super) struct Connected {
    /// How many cells each has.
    pub(super) sizes: Vec<usize>,
    /// The component of each cell (see [`Divided::cells`]); they are numbered in the order of their first ones.
    pub(super) of: Vec<u32>,
}

impl Connected {
    pub(super) fn new(divided: &Divided, mesh: &TetMesh) -> Self {
        // What is not reached yet, by side; tetrahedra that were divided are no cells.
        const OPEN: [u32; 2] = [NONE - 1, NONE - 2];
        const DIVIDED: u32 = NONE;
        let open = |positive: bool| OPEN[usize::from(positive)];
        let whole = divided.whole.iter().map(|&side| if side == 0 { DIVIDED } else { open(side > 0) });
        let mut of: Vec<u32> = whole.chain(divided.positive.iter().map(|&p| open(p))).collect();
        let mut sizes: Vec<usize> = Vec::new();
        let mut queue: Vec<u32> = Vec::new();
        divided.cells().for_each(|cell| {
            let own = of[cell as usize];
            if !OPEN.contains(&own) {
                return;
            }
            let label = index(sizes.len());
            let reach = |of: &mut [u32], queue: &mut Vec<u32>, n: u32| {
                if let Some(other) = of.get_mut(n as usize).filter(|other| **other == own) {
                    *other = label;
                    queue.push(n);
                }
            };
            queue.clear();
            reach(&mut of, &mut queue, cell);
            let mut at = 0;
            while let Some(&cell) = queue.get(at) {
                at += 1;
                match divided.part(cell) {
                    Some(i) => divided.neighbours[i].into_iter().for_each(|n| reach(&mut of, &mut queue, n)),
                    None => {
                        for n in mesh.neighbours[cell as usize] {
                            let parted = of.get(n as usize).is_some_and(|other| *other == DIVIDED);
                            let n = if parted { divided.across(mesh, cell, n) } else { n };
                            reach(&mut of, &mut queue, n);
                        }
                    }
                }
            }
            sizes.push(queue.len());
        });
        Self { sizes, of }
    }
}

/// A component that nowhere leaves the stroke by more than the tolerance is a chip, such as a stroke leaves
/// where it grazes the outline of the model: it joins the other side. Whether there was one.
pub(super) fn join_chips(divided: &mut Divided, mesh: &TetMesh, curve: &Curve, tolerance: f64) -> bool {
    let connected = &divided.connected;
    let mut chip = vec![true; connected.sizes.len()];
    let mut undecided = connected.sizes.len();
    for cell in divided.cells() {
        let chip = &mut chip[connected.of[cell as usize] as usize];
        if *chip && !divided.corners(mesh, cell).iter().all(|&p| curve.within(p, tolerance)) {
            *chip = false;
            undecided -= 1;
            if undecided == 0 {
                return false;
            }
        }
    }
    // A chip with nothing but chips around it stays.
    let mut joins = vec![false; connected.sizes.len()];
    for cell in divided.cells() {
        let own = connected.of[cell as usize] as usize;
        if chip[own] && !joins[own] {
            let other = |n: u32| n != NONE && !chip[connected.of[n as usize] as usize];
            joins[own] = divided.beside(mesh, cell).into_iter().any(other);
        }
    }
    let found = joins.contains(&true);
    for (t, side) in divided.whole.iter_mut().enumerate() {
        if *side != 0 && joins[connected.of[t] as usize] {
            *side = -*side;
        }
    }
    let tets = mesh.tets.len();
    for (i, positive) in divided.positive.iter_mut().enumerate() {
        *positive ^= joins[connected.of[tets + i] as usize];
    }
    found
}
