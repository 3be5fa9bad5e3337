//! Smoothing of large meshes: conjugate gradients under a two-level preconditioner.
//!
//! The factor of K D⁻² K grows faster than the mesh: at a million tetrahedra it takes gigabytes. Iterations need
//! memory for some vectors only, but hardly get on by themselves: the matrix is a squared Laplacian, and its
//! smooth vectors count for next to nothing. So these are taken from a coarse problem: the vertices are gathered
//! in aggregates, on each of which the field is a linear function; these functions are smoothed to be continuous
//! (smoothed aggregation for fourth order problems; Vaněk, Mandel & Brezina 1996), and the matrix over them is
//! factored. A few steps of a Chebyshev polynomial see to what is rough.

use glam::DVec3;
use rayon::prelude::*;

use super::aggregate::{FUNCTIONS, Rows, Values, aggregates, linear_functions};
use super::graph::Graph;
use super::laplacian::{Pin, SmoothError};
use crate::exec::Exec;
use crate::mesh::{TetMesh, index};
use crate::solve::{Entry, IterationError, SpdFactor, add, conjugate_gradients, nested_dissection};

/// How far one step of smoothing goes, as a part of the way to the neighbours' mean.
const DAMPING: f64 = 0.6;
/// Smoothing steps of the coarse functions: after two, their second differences are moderate.
const SMOOTHINGS: usize = 2;
/// Degree of the Chebyshev polynomial, and the part of the spectrum that it sees to.
const DEGREE: usize = 3;
const SPREAD: f64 = 30.0;
/// Relative error at which a solution is good enough: directions are normalised, scales are shown to a few
/// digits.
const TOLERANCE: f64 = 1e-8;
/// Rows that one thread takes at a time.
const CHUNK: usize = 2048;

/// The matrix K D⁻² K + μ ΛᵀΛ + ε, never written down.
struct Operator<'a> {
    graph: &'a Graph,
    weights: &'a [f64],
    degree: Vec<f64>,
    pins: &'a [Pin],
    stiffness: f64,
    pull: f64,
}

impl Operator<'_> {
    /// (K x)(v).
    fn laplacian<const N: usize>(&self, v: usize, x: &[[f64; N]]) -> [f64; N] {
        let mut sum = x[v].map(|x| self.degree[v] * x);
        for (&w, weight) in self.graph.of(v).iter().zip(&self.weights[self.graph.range(v)]) {
            let other = &x[w as usize];
            for c in 0..N {
                sum[c] -= weight * other[c];
            }
        }
        sum
    }

    fn apply<const N: usize>(&self, x: &[[f64; N]], y: &mut [[f64; N]]) {
        let inner: Vec<[f64; N]> = (0..x.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|v| {
                let d = self.degree[v];
                let part = if d > 0.0 { 1.0 / (d * d) } else { 0.0 };
                self.laplacian(v, x).map(|k| k * part)
            })
            .collect();
        y.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(v, y)| {
            let outer = self.laplacian(v, &inner);
            *y = std::array::from_fn(|c| outer[c] + self.pull * x[v][c]);
        });
        for pin in self.pins {
            let mut at = [0.0; N];
            for (v, l) in pin.vertices.into_iter().zip(pin.weights) {
                for c in 0..N {
                    at[c] += l * x[v as usize][c];
                }
            }
            for (v, l) in pin.vertices.into_iter().zip(pin.weights) {
                for c in 0..N {
                    y[v as usize][c] += self.stiffness * l * at[c];
                }
            }
        }
    }

    /// The matrix's diagonal, and a number that no eigenvalue of the matrix over its diagonal exceeds.
    ///
    /// A power iteration would not do: the largest eigenvalues belong to single tetrahedra with pins, which it
    /// does not find in a large mesh, and the polynomial of the smoother turns negative beyond its range. With
    /// L = D⁻¹K, whose rows have absolute sums of 2, |Lx|² ≤ 2 Σⱼ xⱼ² Σᵢ |Lᵢⱼ|; and a pin of four vertices
    /// has (Σ λₖ xₖ)² ≤ 4 Σ (λₖ xₖ)².
    fn diagonal(&self) -> (Vec<f64>, f64) {
        let (mut diagonal, mut bound): (Vec<f64>, Vec<f64>) = (0..self.graph.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|v| {
                if self.degree[v] <= 0.0 {
                    let own = self.pull.max(1.0);
                    return (own, own);
                }
                let edges = self.graph.of(v).iter().zip(&self.weights[self.graph.range(v)]);
                let (squares, sum) = edges.fold((1.0, 1.0), |(squares, sum), (&w, weight)| {
                    let part = weight / self.degree[w as usize];
                    (squares + part * part, sum + part)
                });
                (squares + self.pull, 2.0 * sum + self.pull)
            })
            .unzip();
        for pin in self.pins {
            for (v, l) in pin.vertices.into_iter().zip(pin.weights) {
                diagonal[v as usize] += self.stiffness * l * l;
                bound[v as usize] += 4.0 * self.stiffness * l * l;
            }
        }
        let largest = diagonal.iter().zip(&bound).map(|(d, b)| b / d).fold(0.0, f64::max);
        (diagonal, largest)
    }
}

/// A sparse symmetric matrix of 4×4 blocks: for each aggregate the blocks of itself and lower ones.
type Blocks = Vec<Vec<(u32, [[f64; FUNCTIONS]; FUNCTIONS])>>;

/// Adds factor · rowᵀ row to the matrix.
fn add_square(blocks: &mut Blocks, row: &[Values], factor: f64) {
    for (n, (i, a)) in row.iter().enumerate() {
        let line = &mut blocks[*i as usize];
        for (j, b) in &row[..=n] {
            let at = match line.binary_search_by_key(j, |e| e.0) {
                Ok(at) => at,
                Err(at) => {
                    line.insert(at, (*j, [[0.0; FUNCTIONS]; FUNCTIONS]));
                    at
                }
            };
            for (sum, a) in line[at].1.iter_mut().zip(a) {
                for (sum, b) in sum.iter_mut().zip(b) {
                    *sum += factor * a * b;
                }
            }
        }
    }
}

/// A smoothing problem of a large mesh, ready for right-hand sides.
pub(super) struct TwoLevel<'a> {
    operator: Operator<'a>,
    inverse_diagonal: Vec<f64>,
    /// No eigenvalue of the matrix over its diagonal is larger.
    largest: f64,
    /// The coarse functions at the vertices.
    functions: Rows,
    coarse: SpdFactor,
}

impl<'a> TwoLevel<'a> {
    pub(super) fn new(
        mesh: &TetMesh,
        graph: &'a Graph,
        weights: &'a [f64],
        pins: &'a [Pin],
        stiffness: f64,
        pull: f64,
        exec: &Exec,
    ) -> Result<Self, SmoothError> {
        let degree: Vec<f64> = (0..graph.len()).map(|v| weights[graph.range(v)].iter().sum()).collect();
        let operator = Operator { graph, weights, degree, pins, stiffness, pull };
        let (diagonal, largest) = operator.diagonal();
        let inverse_diagonal: Vec<f64> = diagonal.into_iter().map(f64::recip).collect();
        exec.check().map_err(SmoothError::Cancelled)?;
        let (aggregate, count) = aggregates(graph, weights);
        let (mut functions, centres) = linear_functions(mesh, &aggregate, count);
        let step = |v: usize, factor: f64, part: &mut dyn FnMut(usize, f64)| {
            let d = operator.degree[v];
            part(v, if d > 0.0 { 1.0 - factor } else { 1.0 });
            for (&w, weight) in graph.of(v).iter().zip(&weights[graph.range(v)]).filter(|_| d > 0.0) {
                part(w as usize, factor * weight / d);
            }
        };
        for _ in 0..SMOOTHINGS {
            functions = functions.combined(graph.len(), |v, part| step(v, DAMPING, part));
            exec.check().map_err(SmoothError::Cancelled)?;
        }
        let coarse = {
            // The rows of L = D⁻¹K over the coarse functions: the matrix over them is a sum of their squares.
            let rows = functions.combined(graph.len(), |v, part| {
                let d = operator.degree[v];
                if d > 0.0 {
                    part(v, 1.0);
                    for (&w, weight) in graph.of(v).iter().zip(&weights[graph.range(v)]) {
                        part(w as usize, -weight / d);
                    }
                }
            });
            let mut blocks: Blocks =
                (0..index(count)).map(|a| vec![(a, [[0.0; FUNCTIONS]; FUNCTIONS])]).collect();
            for v in 0..graph.len() {
                add_square(&mut blocks, rows.of(v), 1.0);
                if pull > 0.0 {
                    add_square(&mut blocks, functions.of(v), pull);
                }
            }
            exec.check().map_err(SmoothError::Cancelled)?;
            let at_pins = functions.combined(pins.len(), |n, part| {
                for (v, l) in pins[n].vertices.into_iter().zip(pins[n].weights).filter(|(_, l)| *l != 0.0) {
                    part(v as usize, l);
                }
            });
            for n in 0..pins.len() {
                add_square(&mut blocks, at_pins.of(n), stiffness);
            }
            factored(&blocks, &centres)?
        };
        exec.check().map_err(SmoothError::Cancelled)?;
        Ok(Self { operator, inverse_diagonal, largest, functions, coarse })
    }

    pub(super) fn solve<const N: usize>(
        &self,
        rhs: &[[f64; N]],
        exec: &Exec,
    ) -> Result<Vec<[f64; N]>, SmoothError> {
        let apply = |x: &[[f64; N]], y: &mut [[f64; N]]| self.operator.apply(x, y);
        let precondition = |r: &[[f64; N]], z: &mut [[f64; N]]| self.precondition(r, z);
        conjugate_gradients(rhs, TOLERANCE, apply, precondition, exec).map_err(|e| match e {
            IterationError::Solve(e) => SmoothError::Solve(e),
            IterationError::Cancelled(e) => SmoothError::Cancelled(e),
        })
    }

    /// One symmetric cycle: what is rough, the coarse problem, what is rough.
    fn precondition<const N: usize>(&self, r: &[[f64; N]], z: &mut [[f64; N]]) {
        z.fill([0.0; N]);
        let mut residual = r.to_vec();
        self.smooth(&mut residual, z);
        self.correct(&mut residual, z);
        self.smooth(&mut residual, z);
    }

    /// Adds to z what a Chebyshev polynomial makes of the residual, and takes it from the residual.
    fn smooth<const N: usize>(&self, residual: &mut [[f64; N]], z: &mut [[f64; N]]) {
        let (low, high) = (self.largest / SPREAD, self.largest);
        let (middle, half) = (0.5 * (high + low), 0.5 * (high - low));
        let sigma = middle / half;
        let mut rho = 1.0 / sigma;
        let scaled = |r: &[[f64; N]], factor: f64| -> Vec<[f64; N]> {
            let rows = r.par_iter().zip(&self.inverse_diagonal).with_min_len(CHUNK);
            rows.map(|(r, d)| r.map(|r| r * d * factor)).collect()
        };
        let mut step = scaled(residual, 1.0 / middle);
        let mut product = vec![[0.0; N]; z.len()];
        for n in 0..DEGREE {
            add(z, &[1.0; N], &step);
            self.operator.apply(&step, &mut product);
            add(residual, &[-1.0; N], &product);
            if n + 1 < DEGREE {
                let next = 1.0 / (2.0 * sigma - rho);
                let fresh = scaled(residual, 2.0 * next / half);
                step.par_iter_mut().zip(&fresh).with_min_len(CHUNK).for_each(|(s, f)| {
                    *s = std::array::from_fn(|c| next * rho * s[c] + f[c]);
                });
                rho = next;
            }
        }
    }

    /// Adds to z the solution of the coarse problem, and takes it from the residual.
    fn correct<const N: usize>(&self, residual: &mut [[f64; N]], z: &mut [[f64; N]]) {
        let size = self.coarse.size();
        // Sums over fixed parts of the vertices, added up in order.
        let parts: Vec<Vec<f64>> = residual
            .par_chunks(residual.len().div_ceil(16).max(1))
            .enumerate()
            .map(|(n, chunk)| {
                let first = n * residual.len().div_ceil(16).max(1);
                let mut sum = vec![0.0; size * N];
                for (v, r) in chunk.iter().enumerate() {
                    for (aggregate, values) in self.functions.of(first + v) {
                        for (k, value) in values.iter().enumerate() {
                            for c in 0..N {
                                sum[c * size + *aggregate as usize * FUNCTIONS + k] += value * r[c];
                            }
                        }
                    }
                }
                sum
            })
            .collect();
        let mut coarse = vec![0.0; size * N];
        for part in parts {
            for (sum, x) in coarse.iter_mut().zip(part) {
                *sum += x;
            }
        }
        self.coarse.solve(&mut coarse, N);
        let step: Vec<[f64; N]> = (0..z.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|v| {
                let mut sum = [0.0; N];
                for (aggregate, values) in self.functions.of(v) {
                    for (k, value) in values.iter().enumerate() {
                        for c in 0..N {
                            sum[c] += value * coarse[c * size + *aggregate as usize * FUNCTIONS + k];
                        }
                    }
                }
                sum
            })
            .collect();
        add(z, &[1.0; N], &step);
        let mut product = vec![[0.0; N]; z.len()];
        self.operator.apply(&step, &mut product);
        add(residual, &[-1.0; N], &product);
    }
}

fn factored(blocks: &Blocks, centres: &[DVec3]) -> Result<SpdFactor, SmoothError> {
    let mut lower = Vec::new();
    for (i, line) in blocks.iter().enumerate() {
        for (j, block) in line {
            let j = *j as usize;
            for (a, row) in block.iter().enumerate() {
                for (b, &value) in row.iter().enumerate() {
                    let (row, column) = (i * FUNCTIONS + a, j * FUNCTIONS + b);
                    if row == column {
                        // A function that is 0 everywhere stays so.
                        lower.push(Entry::new(row, column, if value > 0.0 { value } else { 1.0 }));
                    } else if row > column {
                        lower.push(Entry::new(row, column, value));
                    }
                }
            }
        }
    }
    let places: Vec<DVec3> = centres.iter().flat_map(|c| [*c; FUNCTIONS]).collect();
    let order = nested_dissection(&places, &lower);
    SpdFactor::ordered(&order, &lower).map_err(SmoothError::Solve)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::laplacian::{Smoother, weights};
    use crate::mesh::TetLocator;
    use crate::mesh::shapes::{both, grid, mapped};

    /// Pins along a curve through a box, and one in the corner.
    fn pins(mesh: &TetMesh) -> (Vec<Pin>, Vec<[f64; 2]>) {
        let locator = TetLocator::new(mesh);
        let curve =
            (0..20).map(|k| f64::from(k) / 19.0).map(|t| DVec3::new(t, 0.5 + 0.4 * (5.0 * t).sin(), 0.3));
        let places: Vec<DVec3> = curve.chain([DVec3::splat(0.05)]).collect();
        let pins = places.iter().filter_map(|p| locator.find(*p)).map(|(t, b)| Pin::inside(mesh, t, b));
        (pins.collect(), places.iter().map(|p| [p.x.cos(), p.y * p.x]).collect())
    }

    #[test]
    fn iteration_and_factor_agree() {
        let mesh = mapped(&grid(14), |p| p + 0.1 * DVec3::new(p.y * p.z, p.x * p.x, 0.0));
        let graph = Graph::new(&mesh);
        let depth: Vec<f64> = mesh.vertices.iter().map(|p| p.z * p.z).collect();
        let (pins, targets) = pins(&mesh);
        let exec = Exec::default();
        for (depth, pull) in [(None, 0.0), (Some(&depth[..]), 0.0), (None, 1e-5)] {
            let weights = weights(&graph, depth);
            let factor = Smoother::new(&mesh, &graph, &weights, &pins, 10.0, pull, &exec).unwrap();
            let expected = factor.solve(&targets, [0.3, 0.0]).unwrap();
            let ready = TwoLevel::new(&mesh, &graph, &weights, &pins, 10.0, pull, &exec).unwrap();
            let found = ready.solve(&factor.right_hand_side(&targets, [0.3, 0.0]), &exec).unwrap();
            for (a, b) in expected.iter().zip(&found) {
                assert!((a[0] - b[0]).abs() < 1e-5 && (a[1] - b[1]).abs() < 1e-5, "{a:?} {b:?}");
            }
        }
    }

    /// Σ xᵢ (A x)ᵢ / Σ dᵢ xᵢ² over vectors around single tetrahedra with many pins, where it is largest.
    #[test]
    fn the_bound_holds_where_pins_crowd() {
        let mesh = grid(6);
        let graph = Graph::new(&mesh);
        let weights = weights(&graph, None);
        let pins: Vec<Pin> = (0..30).map(|k| Pin::inside(&mesh, 40 + k / 10, [0.25; 4])).collect();
        let degree: Vec<f64> = (0..graph.len()).map(|v| weights[graph.range(v)].iter().sum()).collect();
        let operator =
            Operator { graph: &graph, weights: &weights, degree, pins: &pins, stiffness: 10.0, pull: 0.0 };
        let (diagonal, bound) = operator.diagonal();
        assert!(bound < 6.0, "{bound}");
        let mut largest = 0.0f64;
        let mut y = vec![[0.0]; graph.len()];
        for tet in &mesh.tets[38..48] {
            let mut x = vec![[0.0]; graph.len()];
            for v in tet {
                x[*v as usize] = [1.0];
            }
            // Some steps of power iteration make the most of it.
            for _ in 0..20 {
                operator.apply(&x, &mut y);
                let energy: f64 = x.iter().zip(&y).map(|(x, y)| x[0] * y[0]).sum();
                let size: f64 = x.iter().zip(&diagonal).map(|(x, d)| d * x[0] * x[0]).sum();
                largest = largest.max(energy / size);
                let norm = y.iter().map(|y| y[0] * y[0]).sum::<f64>().sqrt();
                for ((x, y), d) in x.iter_mut().zip(&y).zip(&diagonal) {
                    *x = [y[0] / d / norm];
                }
            }
        }
        assert!(largest <= bound && largest > 2.0, "{largest} {bound}");
    }

    #[test]
    fn threads_do_not_matter_and_parts_keep_apart() {
        let far = mapped(&grid(8), |p| p + DVec3::X * 5.0);
        let mesh = both(&grid(8), &far);
        let graph = Graph::new(&mesh);
        let weights = weights(&graph, None);
        let first = crate::mesh::index(9 * 9 * 9);
        let pins = [Pin::vertex(0), Pin::vertex(first)];
        let solve = |threads| {
            let exec = Exec::with_threads(threads).unwrap();
            exec.install(|| {
                let ready = TwoLevel::new(&mesh, &graph, &weights, &pins, 10.0, 0.0, &exec).unwrap();
                let mut rhs = vec![[0.0]; mesh.vertices.len()];
                rhs[0] = [10.0];
                rhs[first as usize] = [-20.0];
                ready.solve(&rhs, &exec).unwrap()
            })
        };
        let one = solve(1);
        assert_eq!(one, solve(3));
        // One pin in each part: a constant there.
        for (v, [x]) in one.iter().enumerate() {
            let expected = if v < first as usize { 1.0 } else { -2.0 };
            assert!((x - expected).abs() < 1e-5, "{v}: {x}");
        }
    }
}
