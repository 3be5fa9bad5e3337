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
        let mut labels = Labels::default();
        let mut of = vec![NONE; divided.whole.len() + divided.positive.len()];
        for (t, (&side, beside)) in divided.whole.iter().zip(&mesh.neighbours).enumerate() {
            if side != 0 {
                of[t] = labels.of_cell(&of, side > 0, beside);
            }
        }
        for (i, (&positive, beside)) in divided.positive.iter().zip(&divided.neighbours).enumerate() {
            of[divided.whole.len() + i] = labels.of_cell(&of, positive, beside);
        }
        labels.number(divided, of)
    }
}

/// Labels that cells get one after the other, each from those beside it that have one; where two meet, they are joined.
///
/// The last bit of a label is the side of the cut.
#[derive(Default)]
struct Labels {
    /// By label without the side's bit, another of the same component, of a smaller number; or itself, the smallest.
    joined: Vec<u32>,
}

impl Labels {
    /// A label for a cell on this side with these beside it.
    #[inline(always)]
    fn of_cell(&mut self, of: &[u32], positive: bool, beside: &[u32; 4]) -> u32 {
        let side = u32::from(positive);
        // Which of those beside it have a label yet is as good as random, so this does without branches.
        let around = beside.map(|n| {
            let other = of.get(n as usize).copied().unwrap_or(NONE);
            if other & 1 == side { other } else { NONE }
        });
        let own = around[0].min(around[1]).min(around[2].min(around[3]));
        if own == NONE {
            let new = index(self.joined.len());
            self.joined.push(new);
            return new * 2 + side;
        }
        let differs = |other: u32| (other != own) & (other != NONE);
        if differs(around[0]) | differs(around[1]) | differs(around[2]) | differs(around[3]) {
            for other in around.into_iter().filter(|other| differs(*other)) {
                self.join(own / 2, other / 2);
            }
        }
        own
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.smallest(a), self.smallest(b));
        self.joined[a.max(b) as usize] = a.min(b);
    }

    fn smallest(&mut self, mut label: u32) -> u32 {
        loop {
            let next = self.joined[label as usize];
            if next == label {
                return label;
            }
            // Ways are halved as they are gone.
            let after = self.joined[next as usize];
            self.joined[label as usize] = after;
            label = after;
        }
    }

    /// The components, in the order of their first cells.
    fn number(mut self, divided: &Divided, mut of: Vec<u32>) -> Connected {
        let mut number = vec![NONE; self.joined.len()];
        for label in 0..index(self.joined.len()) {
            number[label as usize] = self.smallest(label);
        }
        // The first tetrahedron and cell of each.
        let mut first = vec![(NONE, NONE); self.joined.len()];
        let mut sizes = vec![0usize; self.joined.len()];
        for (cell, label) in of.iter_mut().enumerate().filter(|(_, label)| **label != NONE) {
            *label = number[*label as usize / 2];
            let size = &mut sizes[*label as usize];
            *size += 1;
            if *size == 1 {
                first[*label as usize] = (cell as u32, cell as u32);
            }
        }
        let tets = divided.whole.len();
        for (i, part) in divided.parts.parts.iter().enumerate() {
            let first = &mut first[of[tets + i] as usize];
            *first = (*first).min((part.parent, index(tets + i)));
        }
        let mut order: Vec<u32> = (0..index(self.joined.len())).filter(|l| sizes[*l as usize] > 0).collect();
        order.sort_unstable_by_key(|l| first[*l as usize]);
        for (n, l) in order.iter().enumerate() {
            number[*l as usize] = index(n);
        }
        for label in of.iter_mut().filter(|label| **label != NONE) {
            *label = number[*label as usize];
        }
        Connected { sizes: order.iter().map(|l| sizes[*l as usize]).collect(), of }
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
