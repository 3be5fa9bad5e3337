//! What hangs together on one side of a cut.

use super::curve::Curve;
use super::divide::Divided;
use crate::mesh::{Merging, NONE, TetMesh, index};

/// The connected components of both sides.
#[derive(Debug, Default)]
pub(super) struct Connected {
    /// How many there are.
    pub(super) count: usize,
    /// The component of each cell (see [`Divided::cells`]); they are numbered in the order of their first ones.
    pub(super) of: Vec<u32>,
}

impl Connected {
    pub(super) fn new(divided: &Divided, mesh: &TetMesh) -> Self {
        let tets = mesh.tets.len();
        let mut sets = Merging::new(tets + divided.parts.parts.len());
        let whole = &divided.whole;
        for (t, beside) in mesh.neighbours.iter().enumerate() {
            let side = whole[t];
            if side == 0 {
                continue;
            }
            for &n in beside {
                // Each face once.
                if (n as usize) < t && whole[n as usize] == side {
                    sets.merge(index(t), n);
                }
            }
        }
        for (i, beside) in divided.neighbours.iter().enumerate() {
            let cell = index(tets + i);
            for &n in beside {
                if n != NONE && n < cell && divided.side(n) == divided.positive[i] {
                    sets.merge(cell, n);
                }
            }
        }
        let mut number = vec![NONE; tets + divided.parts.parts.len()];
        let mut of = vec![NONE; number.len()];
        let mut count = 0;
        for cell in divided.cells() {
            let slot = &mut number[sets.root(cell) as usize];
            if *slot == NONE {
                *slot = count;
                count += 1;
            }
            of[cell as usize] = *slot;
        }
        Self { count: count as usize, of }
    }
}

/// A component that nowhere leaves the stroke by more than the tolerance is a chip, such as a stroke leaves
/// where it grazes the outline of the model: it joins the other side. Whether there was one.
pub(super) fn join_chips(divided: &mut Divided, mesh: &TetMesh, curve: &Curve, tolerance: f64) -> bool {
    let connected = &divided.connected;
    let mut chip = vec![true; connected.count];
    let mut undecided = connected.count;
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
    let mut joins = vec![false; connected.count];
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
