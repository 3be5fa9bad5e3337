//! Frames (the paper's tensor field) from the fields that steer a fill \[LST 5.2.2, 5.2.7\].

use glam::{DMat3, DQuat, DVec3};

use super::gradient::tet_gradients;
use super::singular::{FrameAxes, Singularities, singularities};
use crate::mesh::TetMesh;

/// The fields that steer a fill: values at the vertices of the mesh. Each texture type draws on its own; the
/// others must be `None`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fields {
    /// Depth, 0 outside to 1 innermost.
    pub depth: Option<Vec<f64>>,
    /// Unit vectors along texture x.
    pub direction: Option<Vec<DVec3>>,
    /// World length of one unit of texture.
    pub scale: Option<Vec<f64>>,
    /// Texture x itself, 0 to 1.
    pub along: Option<Vec<f64>>,
    /// Texture z itself, 0 to 1.
    pub across: Option<Vec<f64>>,
}

/// Orthogonal vectors R, S and T = R × S in each tetrahedron, as far as fields fix them: unit axes and the world
/// lengths that one unit of texture covers along them.
///
/// S is the direction in which the depth rises; R the given direction, or that in which the field `along` rises,
/// made orthogonal to S. What no field fixes is drawn by each patch.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameField {
    /// Unit R in each tetrahedron; empty where neither a direction nor `along` is given.
    pub r: Vec<DVec3>,
    /// Unit S in each tetrahedron; empty where no depth is given.
    pub s: Vec<DVec3>,
    /// World length of one unit of texture along the axes whose coordinate is solved for, in each tetrahedron.
    pub length: Vec<f64>,
    /// The same along each axis that has lengths of its own: exactly 1/|∇coordinate| where the coordinate is given.
    /// Empty for the others.
    pub(super) own_length: [Vec<f64>; 3],
    /// Which coordinates are given.
    pub(super) given: [bool; 3],
}

/// Lengths 1/|∇depth| beyond this many medians are cut: the gradient vanishes on the innermost set.
const LONGEST: f64 = 3.0;
const SHORTEST: f64 = 1.0 / 4.0;

/// The most that a frame may turn over one unit of texture, in radians.
const TURN: f64 = 2.0;
/// The least length, in medians, that is left where frames turn fast.
const LEAST: f64 = 0.3;

impl FrameField {
    /// The frames that `fields` make. `given` says which of the texture's coordinates x, y, z *are* the fields
    /// `along`, `depth` and `across`.
    ///
    /// # Panics
    /// Where a field has fewer values than the mesh has vertices.
    #[must_use]
    pub fn new(mesh: &TetMesh, fields: &Fields, given: [bool; 3]) -> Self {
        let tets = mesh.tets.len();
        let [along, depth, across] =
            [&fields.along, &fields.depth, &fields.across].map(|f| f.as_ref().map(|f| Rise::new(mesh, f)));
        // Where no scale is given it follows from the coordinate that is given last: z, else the depth.
        let length: Vec<f64> = match (&fields.scale, across.as_ref().or(depth.as_ref())) {
            (Some(scale), _) => (0..tets).map(|t| mean(mesh, scale, t)).collect(),
            (None, Some(rise)) => rise.steady_lengths(mesh),
            (None, None) => vec![1.0; tets],
        };
        let s: Vec<DVec3> = depth.as_ref().map_or_else(Vec::new, |d| d.axes(mesh));
        let wanted: Vec<DVec3> = match (&fields.direction, &along) {
            (Some(direction), _) => (mesh.tets.iter())
                .map(|tet| {
                    let sum: DVec3 = tet.iter().map(|&v| direction[v as usize]).sum();
                    sum.try_normalize().unwrap_or(direction[tet[0] as usize])
                })
                .collect(),
            (None, Some(along)) => along.axes(mesh),
            (None, None) => Vec::new(),
        };
        let across_s = |(t, r): (usize, DVec3)| s.get(t).map_or(r, |s| perpendicular(r, *s));
        let r = wanted.into_iter().enumerate().map(across_s).collect();
        let mut rises = [along, depth, across].into_iter().zip(given);
        let own_length = std::array::from_fn(|_| match rises.next() {
            Some((Some(rise), true)) => rise.lengths(mesh),
            _ => Vec::new(),
        });
        let mut frames = Self { r, s, length, own_length, given };
        if given[1] && !given[0] {
            frames.shorten_where_turning(mesh);
        }
        frames
    }

    /// Where the frames turn fast (around a fruit's axis, at its poles) a patch of the scale that the depth
    /// gives would wrap around what it should follow. There R and T are shortened, so that one unit of texture
    /// turns by at most [`TURN`], down to [`LEAST`] of the median length.
    fn shorten_where_turning(&mut self, mesh: &TetMesh) {
        let frames = self.at_vertices(mesh);
        let mut sorted = self.length.clone();
        sorted.sort_by(f64::total_cmp);
        let least = sorted[sorted.len() / 2] * LEAST;
        let shortened: Vec<DVec3> = (0..mesh.tets.len())
            .map(|t| {
                let gradients = mesh.gradients(t);
                let mut rate = 0.0f64;
                let axes: &[usize] = if self.r.is_empty() { &[1] } else { &[0, 1] };
                for &axis in axes {
                    // The derivative of the unit axis; its norm is the fastest turn, in radians a length.
                    let d = gradients.iter().zip(mesh.tets[t]).fold(DMat3::ZERO, |sum, (g, v)| {
                        let unit = frames[v as usize][axis].normalize_or_zero();
                        sum + DMat3::from_cols(unit * g.x, unit * g.y, unit * g.z)
                    });
                    rate = rate.max(largest_stretch(&d));
                }
                let length = self.length[t];
                DVec3::new((TURN / rate.max(f64::MIN_POSITIVE)).min(length).max(least.min(length)), 0.0, 0.0)
            })
            .collect();
        let smooth = vertex_means(mesh, &shortened);
        for (length, tet) in self.length.iter_mut().zip(&mesh.tets) {
            *length = tet.iter().map(|&v| smooth[v as usize].x).sum::<f64>() / 4.0;
        }
    }

    /// Frames at the vertices, for the record: R, S, T with their lengths, means over the tetrahedra around,
    /// made orthogonal again. What no field fixes is turned from the texture's axis by the smallest rotation:
    /// smooth but for the places where none can be.
    #[must_use]
    pub fn at_vertices(&self, mesh: &TetMesh) -> Vec<[DVec3; 3]> {
        let count = mesh.vertices.len();
        let mut sums = vec![(DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, 0.0); count];
        for t in 0..mesh.tets.len() {
            let volume = mesh.tet_volume(t);
            for &v in &mesh.tets[t] {
                let sum = &mut sums[v as usize];
                sum.0 += self.r.get(t).copied().unwrap_or_default() * volume;
                sum.1 += self.s.get(t).copied().unwrap_or_default() * volume;
                sum.2 += self.lengths(t) * volume;
                sum.3 += volume;
            }
        }
        sums.into_iter()
            .map(|(r, s, lengths, weight)| {
                let lengths = if weight > 0.0 { lengths / weight } else { DVec3::ONE };
                let (r, s) = match (r.try_normalize(), s.try_normalize()) {
                    (Some(r), Some(s)) => (perpendicular(r, s), s),
                    (Some(r), None) => (r, turned(DVec3::X, r, DVec3::Y)),
                    (None, Some(s)) => (turned(DVec3::Y, s, DVec3::X), s),
                    (None, None) => (DVec3::X, DVec3::Y),
                };
                [r * lengths.x, s * lengths.y, r.cross(s) * lengths.z]
            })
            .collect()
    }

    /// Unit T in each tetrahedron of a type that has R and S.
    #[must_use]
    pub(crate) fn thirds(&self) -> Vec<DVec3> {
        self.r.iter().zip(&self.s).map(|(r, s)| r.cross(*s)).collect()
    }

    /// How many coordinates are solved for.
    #[must_use]
    pub(crate) fn free_axes(&self) -> usize {
        self.given.iter().filter(|given| !**given).count()
    }

    /// World lengths of one unit of texture along R, S and T in tetrahedron `t`.
    #[must_use]
    pub fn lengths(&self, t: usize) -> DVec3 {
        DVec3::from_array(self.own_length.each_ref().map(|l| l.get(t).copied().unwrap_or(self.length[t])))
    }

    /// Gives `axis` lengths of its own, one for each tetrahedron.
    pub(crate) fn set_lengths(&mut self, axis: usize, lengths: Vec<f64>) {
        self.own_length[axis] = lengths;
    }

    /// Its singularities; none where no axis is fixed. With `line_field` R has no sense.
    #[must_use]
    pub fn singularities(&self, mesh: &TetMesh, line_field: bool) -> Singularities {
        let axes = match (self.r.is_empty(), self.s.is_empty()) {
            (true, true) => return Singularities::default(),
            (true, false) => FrameAxes::S,
            (false, true) if line_field => FrameAxes::Line,
            (false, true) => FrameAxes::R,
            (false, false) if line_field => FrameAxes::Lines,
            (false, false) => FrameAxes::All,
        };
        let axis = |axes: &[DVec3], t: usize| axes.get(t).copied().unwrap_or_default();
        let frames: Vec<[DVec3; 3]> = (0..mesh.tets.len())
            .map(|t| {
                let (r, s) = (axis(&self.r, t), axis(&self.s, t));
                [r, s, r.cross(s)]
            })
            .collect();
        singularities(mesh, &frames, axes)
    }
}

/// How a field rises over the mesh.
struct Rise {
    /// Its gradient in each tetrahedron.
    slopes: Vec<DVec3>,
    /// Means of it at the vertices.
    smooth: Vec<DVec3>,
}

impl Rise {
    fn new(mesh: &TetMesh, field: &[f64]) -> Self {
        let slopes = tet_gradients(mesh, field);
        let smooth = vertex_means(mesh, &slopes);
        Self { slopes, smooth }
    }

    /// The direction in which it rises in each tetrahedron. A flat one borrows its neighbourhood's.
    fn axes(&self, mesh: &TetMesh) -> Vec<DVec3> {
        (self.slopes.iter().zip(&mesh.tets))
            .map(|(slope, tet)| {
                let around: DVec3 = tet.iter().map(|&v| self.smooth[v as usize]).sum();
                let flat = slope.length() <= 1e-6 * around.length();
                let best = if flat { around } else { *slope };
                best.try_normalize().unwrap_or(DVec3::Y)
            })
            .collect()
    }

    /// A world length of one unit in each tetrahedron: 1/|∇| of the neighbourhood, cut where it is far from
    /// the median.
    fn steady_lengths(&self, mesh: &TetMesh) -> Vec<f64> {
        let sizes: Vec<f64> = self.smooth.iter().map(|s| s.length()).collect();
        let means: Vec<f64> = (0..mesh.tets.len()).map(|t| mean(mesh, &sizes, t)).collect();
        let mut sorted = means.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2].max(f64::MIN_POSITIVE);
        means.iter().map(|m| 1.0 / m.clamp(median / LONGEST, median / SHORTEST)).collect()
    }

    /// 1/|∇| in each tetrahedron; where it is flat, the steady length.
    fn lengths(&self, mesh: &TetMesh) -> Vec<f64> {
        (self.slopes.iter().zip(self.steady_lengths(mesh)))
            .map(|(slope, steady)| {
                let own = slope.length();
                if own * steady > 1e-9 { 1.0 / own } else { steady }
            })
            .collect()
    }
}

/// The mean of a field in tetrahedron `t`.
fn mean(mesh: &TetMesh, values: &[f64], t: usize) -> f64 {
    mesh.tets[t].iter().map(|&v| values[v as usize]).sum::<f64>() / 4.0
}

/// `what`, which is orthogonal to `from`, turned by the smallest rotation that takes `from` to `to`.
pub(crate) fn turned(from: DVec3, to: DVec3, what: DVec3) -> DVec3 {
    perpendicular(DQuat::from_rotation_arc(from, to) * what, to)
}

/// The unit vector nearest to `v` that is perpendicular to the unit vector `axis`; any such where `v` is
/// along it.
pub(crate) fn perpendicular(v: DVec3, axis: DVec3) -> DVec3 {
    let across = v - axis * v.dot(axis);
    // Of a vector along the axis rounding leaves something that is not across it.
    let tells = across.length_squared() > 1e-16 * v.length_squared();
    across.try_normalize().filter(|_| tells).unwrap_or_else(|| axis.any_orthonormal_vector())
}

/// The largest singular value of a matrix, by power iteration on its normal equations.
fn largest_stretch(m: &DMat3) -> f64 {
    let square = m.transpose() * *m;
    let mut v = DVec3::new(0.6, 0.5, 0.62);
    for _ in 0..24 {
        let next = square * v;
        match next.try_normalize() {
            Some(n) => v = n,
            None => return 0.0,
        }
    }
    (m.mul_vec3(v)).length()
}

/// Volume-weighted means at the vertices of a vector per tetrahedron.
pub(super) fn vertex_means(mesh: &TetMesh, values: &[DVec3]) -> Vec<DVec3> {
    let mut sum = vec![DVec3::ZERO; mesh.vertices.len()];
    let mut weight = vec![0.0; mesh.vertices.len()];
    for (t, value) in values.iter().enumerate() {
        let volume = mesh.tet_volume(t);
        for &v in &mesh.tets[t] {
            sum[v as usize] += *value * volume;
            weight[v as usize] += volume;
        }
    }
    sum.iter().zip(weight).map(|(s, w)| if w > 0.0 { *s / w } else { DVec3::ZERO }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::ball;

    fn orthogonal(frames: &[[DVec3; 3]]) -> bool {
        frames.iter().all(|[r, s, t]| {
            let [a, b] = [r.normalize(), s.normalize()];
            a.dot(b).abs() < 1e-9 && (a.cross(b) - t.normalize()).length() < 1e-9
        })
    }

    fn fields(mesh: &TetMesh) -> Fields {
        Fields {
            depth: Some(mesh.vertices.iter().map(|p| 1.0 - p.length().min(1.0)).collect()),
            direction: Some(
                mesh.vertices.iter().map(|p| (DVec3::Z + 0.5 * p.cross(DVec3::X)).normalize()).collect(),
            ),
            scale: Some(mesh.vertices.iter().map(|p| 0.3 + 0.1 * p.x).collect()),
            ..Fields::default()
        }
    }

    #[test]
    fn frames_are_orthogonal_and_as_long_as_asked() {
        let mesh = ball(1, 4);
        let all = fields(&mesh);
        for (direction, depth) in [(true, true), (true, false), (false, true), (false, false)] {
            let some = Fields {
                depth: all.depth.clone().filter(|_| depth),
                direction: all.direction.clone().filter(|_| direction),
                ..all.clone()
            };
            let field = FrameField::new(&mesh, &some, [false; 3]);
            assert_eq!((field.r.is_empty(), field.s.is_empty()), (!direction, !depth));
            let frames = field.at_vertices(&mesh);
            assert!(orthogonal(&frames));
            for (f, s) in frames.iter().zip(all.scale.as_ref().unwrap()) {
                // A mean over the tetrahedra around.
                assert!(f.iter().all(|a| (a.length() - s).abs() < 0.03), "{f:?} {s}");
            }
        }
        let plain = Fields { depth: None, direction: None, ..all };
        let frame = FrameField::new(&mesh, &plain, [false; 3]).at_vertices(&mesh)[3];
        assert!((frame[0].normalize() - DVec3::X).length() < 1e-12);
        assert!((frame[1].normalize() - DVec3::Y).length() < 1e-12);
    }

    #[test]
    fn s_is_the_way_inwards_and_its_length_one_over_the_gradient() {
        let mesh = ball(2, 5);
        let depth = fields(&mesh).depth;
        let some = Fields { depth, ..Fields::default() };
        let field = FrameField::new(&mesh, &some, [false, true, false]);
        let slopes = tet_gradients(&mesh, some.depth.as_ref().unwrap());
        for (t, slope) in slopes.iter().enumerate() {
            assert!((field.lengths(t).y * slope.length() - 1.0).abs() < 1e-9);
            assert!((field.s[t] - slope.normalize()).length() < 1e-9);
        }
        for (p, [_, s, _]) in mesh.vertices.iter().zip(field.at_vertices(&mesh)).skip(1) {
            assert!(s.normalize().dot(-p.normalize()) > 0.9, "{p} {s}");
        }
        // The middle is where it is singular.
        let found = field.singularities(&mesh, false);
        let middle = |t: u32| mesh.corners(t as usize).iter().sum::<DVec3>() / 4.0;
        assert!(found.tets.iter().all(|&t| middle(t).length() < 0.5), "{found:?}");
    }

    #[test]
    fn three_fields_make_frames_of_three_lengths() {
        let mesh = ball(1, 3);
        let coordinate = |slope: DVec3| -> Option<Vec<f64>> {
            Some(mesh.vertices.iter().map(|p| 0.5 + slope.dot(*p)).collect())
        };
        let some = Fields {
            along: coordinate(DVec3::new(0.2, 0.05, 0.0)),
            depth: coordinate(DVec3::Y * 0.4),
            across: coordinate(DVec3::Z * 0.1),
            ..Fields::default()
        };
        let field = FrameField::new(&mesh, &some, [true; 3]);
        for t in 0..mesh.tets.len() {
            assert!((field.lengths(t) - DVec3::new(1.0 / 0.2f64.hypot(0.05), 2.5, 10.0)).length() < 1e-6);
            assert!((field.r[t] - DVec3::X).length() < 1e-9 && (field.s[t] - DVec3::Y).length() < 1e-9);
        }
        assert_eq!(field.singularities(&mesh, false), Singularities::default());
    }

    #[test]
    fn the_smallest_rotation_is_a_perpendicular_everywhere() {
        for s in [DVec3::Y, -DVec3::Y, DVec3::X, DVec3::new(1e-9, -1.0, 0.0).normalize()] {
            let r = turned(DVec3::Y, s, DVec3::X);
            assert!(r.dot(s).abs() < 1e-12 && (r.length() - 1.0).abs() < 1e-12);
        }
    }
}
