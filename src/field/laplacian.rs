//! Laplacian smoothing over the vertices of a tetrahedral mesh \[LST 5.2.2; Fu et al. 2007\].

use super::twolevel::TwoLevel;
use crate::exec::Exec;
use crate::field::graph::Graph;
use crate::mesh::TetMesh;
use crate::solve::{Entry, SolveError, SpdFactor, nested_dissection};

/// A point of the mesh whose value is wanted: Σ λₖ x(vₖ).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pin {
    pub(crate) vertices: [u32; 4],
    pub(crate) weights: [f64; 4],
}

impl Pin {
    /// The point with barycentric coordinates `weights` in tetrahedron `tet`.
    pub(crate) fn inside(mesh: &TetMesh, tet: usize, weights: [f64; 4]) -> Self {
        Self { vertices: mesh.tets[tet], weights }
    }

    /// A vertex itself.
    pub(crate) fn vertex(v: u32) -> Self {
        Self { vertices: [v; 4], weights: [1.0, 0.0, 0.0, 0.0] }
    }

    /// The vertex that counts most.
    pub(crate) fn main_vertex(&self) -> u32 {
        let most = (1..4).fold(0, |a, b| if self.weights[b] > self.weights[a] { b } else { a });
        self.vertices[most]
    }
}

/// Weights so small would leave vertices hanging by nothing but rounding errors.
const LEAST_WEIGHT: f64 = 1e-4;

/// σ over the mean difference of depth along the edges. At 1, what was drawn on the skin hardly reaches
/// the core: vectors fade to 4 % there and their directions are noise; at 2 they keep about a third.
const SIGMA: f64 = 2.0;

/// The weight of each edge in the order of the graph's neighbours: 1, or with a depth
/// exp(−((dᵢ − dⱼ)/σ)²), σ twice the mean difference of depth along the mesh's edges, so that values
/// spread along layers rather than across them.
pub(crate) fn weights(graph: &Graph, depth: Option<&[f64]>) -> Vec<f64> {
    let all = 0..graph.len();
    let pairs = all.flat_map(|v| graph.of(v).iter().map(move |&w| (v, w as usize)));
    let Some(depth) = depth else {
        return pairs.map(|_| 1.0).collect();
    };
    let steps: Vec<f64> = pairs.map(|(v, w)| (depth[v] - depth[w]).abs()).collect();
    let mean = steps.iter().sum::<f64>() / steps.len().max(1) as f64;
    if mean <= 0.0 {
        return vec![1.0; steps.len()];
    }
    let sigma = SIGMA * mean;
    steps.iter().map(|step| (-(step / sigma).powi(2)).exp().max(LEAST_WEIGHT)).collect()
}

/// Minimises Σᵢ |xᵢ − Σⱼ wᵢⱼ xⱼ|² + μ Σ_pins |Σₖ λₖ x(vₖ) − c|² + ε Σᵢ |xᵢ − rest|², with the weights of each row
/// made to sum to 1. Made ready once, solved for any number of components: up to [`FACTORED`] vertices by a
/// Cholesky factor, whose cost grows faster than the mesh, and past it by iteration.
///
/// With symmetric edge weights W, D = diag(W·1) and K = D − W, the rows are those of L = D⁻¹K, so
/// the matrix is K D⁻² K + μ ΛᵀΛ + ε.
pub(crate) struct Smoother<'a> {
    solver: Solver<'a>,
    vertices: usize,
    pins: &'a [Pin],
    stiffness: f64,
    pull: f64,
    exec: &'a Exec,
}

enum Solver<'a> {
    Factor(Box<SpdFactor>),
    Iteration(Box<TwoLevel<'a>>),
}

/// The most vertices for which the matrix is factored.
const FACTORED: usize = 12_000;

impl<'a> Smoother<'a> {
    /// `stiffness` is μ; `pull` is ε, which may be 0 where every connected component has a pin.
    pub(crate) fn new(
        mesh: &TetMesh,
        graph: &'a Graph,
        weights: &'a [f64],
        pins: &'a [Pin],
        stiffness: f64,
        pull: f64,
        exec: &'a Exec,
    ) -> Result<Self, SmoothError> {
        let solver = if graph.len() > FACTORED {
            let ready = exec.install(|| TwoLevel::new(mesh, graph, weights, pins, stiffness, pull, exec))?;
            Solver::Iteration(Box::new(ready))
        } else {
            Solver::Factor(Box::new(Self::factor(mesh, graph, weights, pins, stiffness, pull, exec)?))
        };
        Ok(Self { solver, vertices: graph.len(), pins, stiffness, pull, exec })
    }

    fn factor(
        mesh: &TetMesh,
        graph: &Graph,
        weights: &[f64],
        pins: &[Pin],
        stiffness: f64,
        pull: f64,
        exec: &Exec,
    ) -> Result<SpdFactor, SmoothError> {
        let mut lower = squared_laplacian(graph, weights, exec)?;
        for pin in pins {
            for (a, la) in pin.vertices.into_iter().zip(pin.weights) {
                for (b, lb) in pin.vertices.into_iter().zip(pin.weights) {
                    let value = stiffness * la * lb;
                    if a >= b && value != 0.0 {
                        lower.push(Entry::new(a as usize, b as usize, value));
                    }
                }
            }
        }
        if pull > 0.0 {
            lower.extend((0..graph.len()).map(|v| Entry::new(v, v, pull)));
        }
        exec.check().map_err(SmoothError::Cancelled)?;
        let order = nested_dissection(&mesh.vertices, &lower);
        SpdFactor::ordered(&order, &lower).map_err(SmoothError::Solve)
    }

    /// The smooth field with the value `targets[k]` at pin k, drawn to `rest` as much as ε says.
    pub(crate) fn solve<const N: usize>(
        &self,
        targets: &[[f64; N]],
        rest: [f64; N],
    ) -> Result<Vec<[f64; N]>, SmoothError> {
        let rhs = self.right_hand_side(targets, rest);
        match &self.solver {
            Solver::Factor(factor) => {
                let n = self.vertices;
                let mut x: Vec<f64> = (0..N).flat_map(|c| rhs.iter().map(move |r| r[c])).collect();
                factor.solve(&mut x, N);
                Ok((0..n).map(|v| std::array::from_fn(|c| x[c * n + v])).collect())
            }
            Solver::Iteration(ready) => self.exec.install(|| ready.solve(&rhs, self.exec)),
        }
    }

    /// ε rest + μ Λᵀ c.
    pub(super) fn right_hand_side<const N: usize>(
        &self,
        targets: &[[f64; N]],
        rest: [f64; N],
    ) -> Vec<[f64; N]> {
        let mut rhs = vec![rest.map(|r| self.pull * r); self.vertices];
        for (pin, target) in self.pins.iter().zip(targets) {
            for (v, l) in pin.vertices.into_iter().zip(pin.weights) {
                for c in 0..N {
                    rhs[v as usize][c] += self.stiffness * l * target[c];
                }
            }
        }
        rhs
    }
}

/// Why smoothing stopped; callers turn it into their own errors.
#[derive(Debug)]
pub(crate) enum SmoothError {
    Solve(SolveError),
    Cancelled(crate::exec::Cancelled),
}

/// Lower triangle of K D⁻² K, each entry once. Row by row with one dense accumulator: the products
/// themselves would take three times the memory.
fn squared_laplacian(graph: &Graph, weights: &[f64], exec: &Exec) -> Result<Vec<Entry>, SmoothError> {
    let n = graph.len();
    let degree: Vec<f64> = (0..n).map(|v| weights[graph.range(v)].iter().sum()).collect();
    // Entry (v, w) of K, as (column, value) pairs of row v, the diagonal first.
    let row = |v: usize| {
        let edges = graph.of(v).iter().zip(&weights[graph.range(v)]);
        std::iter::once((v, degree[v])).chain(edges.map(|(&w, weight)| (w as usize, -weight)))
    };
    let mut lower = Vec::with_capacity(n * 40);
    let mut sum = vec![0.0; n];
    let mut seen = vec![usize::MAX; n];
    let mut touched = Vec::new();
    for a in 0..n {
        if a % 4096 == 0 {
            exec.check().map_err(SmoothError::Cancelled)?;
        }
        for (i, value) in row(a) {
            if degree[i] <= 0.0 {
                continue;
            }
            let factor = value / (degree[i] * degree[i]);
            for (b, other) in row(i) {
                if b > a {
                    continue;
                }
                if seen[b] != a {
                    seen[b] = a;
                    sum[b] = 0.0;
                    touched.push(b);
                }
                sum[b] += factor * other;
            }
        }
        lower.extend(touched.drain(..).map(|b| Entry::new(a, b, sum[b])));
    }
    Ok(lower)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TetLocator;
    use crate::mesh::shapes::grid;

    /// xᵀ A x by the entries of the lower triangle, and by the definition.
    #[test]
    fn the_matrix_is_the_sum_of_squared_laplacians() {
        let mesh = grid(3);
        let graph = Graph::new(&mesh);
        let depth: Vec<f64> = mesh.vertices.iter().map(|p| p.x + 0.3 * p.y).collect();
        let weights = weights(&graph, Some(&depth));
        assert!(weights.iter().all(|w| *w > 0.0 && *w <= 1.0));
        let x: Vec<f64> = mesh.vertices.iter().map(|p| (5.0 * p.x).sin() + p.z * p.y).collect();
        let lower = squared_laplacian(&graph, &weights, &Exec::default()).unwrap();
        let by_matrix: f64 =
            lower.iter().map(|e| e.val * x[e.row] * x[e.col] * if e.row == e.col { 1.0 } else { 2.0 }).sum();
        let by_definition: f64 = (0..graph.len())
            .map(|v| {
                let w = &weights[graph.range(v)];
                let mean: f64 = graph.of(v).iter().zip(w).map(|(&j, w)| w * x[j as usize]).sum();
                (x[v] - mean / w.iter().sum::<f64>()).powi(2)
            })
            .sum();
        assert!((by_matrix - by_definition).abs() < 1e-10 * by_definition);
        let mut places: Vec<(usize, usize)> = lower.iter().map(|e| (e.row, e.col)).collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), lower.len());
    }

    #[test]
    fn weights_favour_the_layer() {
        let mesh = grid(4);
        let graph = Graph::new(&mesh);
        let depth: Vec<f64> = mesh.vertices.iter().map(|p| p.z).collect();
        let weights = weights(&graph, Some(&depth));
        for v in 0..graph.len() {
            for (&w, weight) in graph.of(v).iter().zip(&weights[graph.range(v)]) {
                let step = (depth[v] - depth[w as usize]).abs();
                assert!(step > 0.15 || *weight > 0.75, "{step} {weight}");
                assert!(step < 0.2 || *weight < 0.75, "{step} {weight}");
            }
        }
    }

    #[test]
    fn one_pin_gives_a_constant_and_stiff_pins_are_met() {
        let mesh = grid(4);
        let graph = Graph::new(&mesh);
        let exec = Exec::default();
        let locator = TetLocator::new(&mesh);
        let pin = |p: [f64; 3]| {
            let (t, b) = locator.find(p.into()).unwrap();
            Pin::inside(&mesh, t, b)
        };
        let weights = weights(&graph, None);
        let pins = [pin([0.31, 0.2, 0.77])];
        let smoother = Smoother::new(&mesh, &graph, &weights, &pins, 10.0, 0.0, &exec).unwrap();
        for x in smoother.solve(&[[2.0, -1.0]], [0.0; 2]).unwrap() {
            assert!((x[0] - 2.0).abs() < 1e-8 && (x[1] + 1.0).abs() < 1e-8);
        }
        let pins = [pin([0.1, 0.5, 0.5]), pin([0.9, 0.5, 0.5])];
        let smoother = Smoother::new(&mesh, &graph, &weights, &pins, 1e5, 0.0, &exec).unwrap();
        let x = smoother.solve(&[[0.0], [1.0]], [0.0]).unwrap();
        for (pin, target) in pins.iter().zip([0.0, 1.0]) {
            let at: f64 = pin.vertices.iter().zip(pin.weights).map(|(&v, l)| l * x[v as usize][0]).sum();
            assert!((at - target).abs() < 1e-3);
        }
        // In between it rises from one to the other.
        let along = |t: f64| {
            let p = pin([t, 0.5, 0.5]);
            p.vertices.iter().zip(p.weights).map(|(&v, l)| l * x[v as usize][0]).sum::<f64>()
        };
        assert!((1..8).all(|k| along(0.1 * f64::from(k)) < along(0.1 * f64::from(k + 1))));
    }
}
