//! What TetGen is asked and what it answers, and both as bytes in a file.

use glam::DVec3;

/// One run of TetGen: fill a surface, or, where it has no triangles, connect the points as Delaunay
/// tetrahedra, which knows no hard cases. Coordinates lie in a box about 100 wide around the origin: TetGen's switches have a
/// fixed number of decimals.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Job {
    /// Vertices of the surface, each of which is used; or any points.
    pub(crate) points: Vec<DVec3>,
    /// Triangles of the surface.
    pub(crate) triangles: Vec<[u32; 3]>,
    /// No tetrahedron is larger.
    pub(crate) max_volume: Option<f64>,
    /// Largest ratio of circumradius to shortest edge (TetGen's `q`); above 1.
    pub(crate) ratio: f64,
    /// Leave the surface's triangles whole (TetGen's `Y`), where the mesher can.
    pub(crate) keep_surface: bool,
}

/// Tetrahedra, as TetGen made them.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Answer {
    /// The job's points in their order, then new ones.
    pub(crate) points: Vec<DVec3>,
    /// The tetrahedra; their orientation is not promised.
    pub(crate) tets: Vec<[u32; 4]>,
    /// Faces that lie on the surface: their corners, and the job's triangle that each lies on.
    pub(crate) faces: Vec<([u32; 3], u32)>,
}

impl Job {
    /// Asks for the Delaunay tetrahedra of some points.
    pub(crate) fn delaunay(points: Vec<DVec3>) -> Self {
        Self { points, triangles: Vec::new(), max_volume: None, ratio: 0.0, keep_surface: false }
    }
}

impl Answer {
    /// What is wrong with this as an answer to `job`.
    pub(crate) fn check(&self, job: &Job) -> Result<(), String> {
        let count = self.points.len();
        if count < job.points.len() {
            return Err(format!("{count} vertices come back of the surface's {}", job.points.len()));
        }
        if u32::try_from(count).is_err() || u32::try_from(self.tets.len()).is_err() {
            return Err("the mesh is too large".to_owned());
        }
        // A program writes and reads text of 16 digits; anything worse is another vertex.
        let moved = |(a, b): (&DVec3, &DVec3)| !((*a - *b).abs().max_element() <= 1e-9);
        if let Some(v) = self.points.iter().zip(&job.points).position(moved) {
            return Err(format!("vertex {v} of the surface comes back elsewhere"));
        }
        if let Some(v) = self.points.iter().position(|p| !p.is_finite()) {
            return Err(format!("vertex {v} is not finite"));
        }
        let beyond = |v: &u32| *v as usize >= count;
        if let Some(t) = self.tets.iter().position(|t| t.iter().any(beyond)) {
            return Err(format!("tetrahedron {t} names a vertex past the end"));
        }
        let strange = |(c, t): &([u32; 3], u32)| c.iter().any(beyond) || *t as usize >= job.triangles.len();
        if let Some(f) = self.faces.iter().position(strange) {
            return Err(format!("face {f} names a vertex or a triangle past the end"));
        }
        Ok(())
    }
}

const JOB_MAGIC: u64 = u64::from_le_bytes(*b"LpsJob01");
const ANSWER_MAGIC: u64 = u64::from_le_bytes(*b"LpsTet01");

impl Job {
    pub(super) fn to_bytes(&self, seconds: f64, bytes: u64) -> Vec<u8> {
        let mut out = Vec::with_capacity(80 + self.points.len() * 24 + self.triangles.len() * 12);
        for word in [
            JOB_MAGIC,
            seconds.to_bits(),
            bytes,
            self.max_volume.unwrap_or(f64::INFINITY).to_bits(),
            self.ratio.to_bits(),
            u64::from(self.keep_surface),
            self.points.len() as u64,
            self.triangles.len() as u64,
        ] {
            out.extend(word.to_le_bytes());
        }
        put_points(&mut out, &self.points);
        out.extend(self.triangles.iter().flatten().flat_map(|v| v.to_le_bytes()));
        out
    }

    /// The job, and its limits in seconds and in bytes.
    pub(super) fn from_bytes(bytes: &[u8]) -> Result<(Self, f64, u64), String> {
        let mut rest = Reader { bytes };
        if rest.word()? != JOB_MAGIC {
            return Err("this is no job".to_owned());
        }
        let (seconds, memory) = (f64::from_bits(rest.word()?), rest.word()?);
        let max_volume = Some(f64::from_bits(rest.word()?)).filter(|v| v.is_finite());
        let ratio = f64::from_bits(rest.word()?);
        let keep_surface = rest.word()? != 0;
        let (points, triangles) = (rest.word()?, rest.word()?);
        let points = rest.points(points)?;
        let triangles = rest.indices(triangles)?;
        rest.end()?;
        if triangles.iter().flatten().any(|v| *v as usize >= points.len()) {
            return Err("a triangle names a vertex past the end".to_owned());
        }
        Ok((Self { points, triangles, max_volume, ratio, keep_surface }, seconds, memory))
    }
}

impl Answer {
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let size = 32 + self.points.len() * 24 + self.tets.len() * 16 + self.faces.len() * 16;
        let mut out = Vec::with_capacity(size);
        for word in [ANSWER_MAGIC, self.points.len() as u64, self.tets.len() as u64, self.faces.len() as u64]
        {
            out.extend(word.to_le_bytes());
        }
        put_points(&mut out, &self.points);
        out.extend(self.tets.iter().flatten().flat_map(|v| v.to_le_bytes()));
        for ([a, b, c], triangle) in &self.faces {
            out.extend([a, b, c, triangle].into_iter().flat_map(|v| v.to_le_bytes()));
        }
        out
    }

    pub(super) fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        let mut rest = Reader { bytes };
        if rest.word()? != ANSWER_MAGIC {
            return Err("this is no answer".to_owned());
        }
        let (points, tets, faces) = (rest.word()?, rest.word()?, rest.word()?);
        let points = rest.points(points)?;
        let tets = rest.indices(tets)?;
        let faces = rest.indices::<4>(faces)?.into_iter().map(|[a, b, c, t]| ([a, b, c], t)).collect();
        rest.end()?;
        Ok(Self { points, tets, faces })
    }
}

fn put_points(out: &mut Vec<u8>, points: &[DVec3]) {
    out.extend(points.iter().flat_map(glam::DVec3::to_array).flat_map(f64::to_le_bytes));
}

/// Bytes still to be read.
struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: u64, size: usize) -> Result<&'a [u8], String> {
        let length = usize::try_from(count).ok().and_then(|n| n.checked_mul(size));
        let (taken, rest) = length
            .and_then(|n| self.bytes.split_at_checked(n))
            .ok_or_else(|| "it ends before what it promises".to_owned())?;
        self.bytes = rest;
        Ok(taken)
    }

    fn word(&mut self) -> Result<u64, String> {
        let mut word = [0; 8];
        word.copy_from_slice(self.take(1, 8)?);
        Ok(u64::from_le_bytes(word))
    }

    fn points(&mut self, count: u64) -> Result<Vec<DVec3>, String> {
        let words = self.take(count, 24)?.as_chunks::<8>().0;
        let number = |i: usize| f64::from_le_bytes(words[i]);
        Ok((0..words.len() / 3)
            .map(|p| DVec3::new(number(3 * p), number(3 * p + 1), number(3 * p + 2)))
            .collect())
    }

    fn indices<const N: usize>(&mut self, count: u64) -> Result<Vec<[u32; N]>, String> {
        let words = self.take(count, 4 * N)?.as_chunks::<4>().0;
        Ok((0..words.len() / N)
            .map(|i| std::array::from_fn(|k| u32::from_le_bytes(words[N * i + k])))
            .collect())
    }

    fn end(&self) -> Result<(), String> {
        if self.bytes.is_empty() { Ok(()) } else { Err(format!("{} bytes are left over", self.bytes.len())) }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A cube of edge 100.
    pub(crate) fn cube() -> Job {
        let points = (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        Job {
            points: points.map(|p| 100.0 * p - 50.0).collect(),
            triangles: quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
            max_volume: Some(2000.0),
            ratio: 2.0,
            keep_surface: false,
        }
    }

    #[test]
    fn jobs_and_answers_come_back() {
        let job = cube();
        assert_eq!(Job::from_bytes(&job.to_bytes(1.5, 7)).unwrap(), (job, 1.5, 7));
        let answer = Answer {
            points: vec![DVec3::ONE / 3.0; 4],
            tets: vec![[0, 1, 2, 3]],
            faces: vec![([0, 1, 2], 5), ([1, 2, 3], 6)],
        };
        assert_eq!(Answer::from_bytes(&answer.to_bytes()).unwrap(), answer);
    }

    #[test]
    fn damage_is_found() {
        let bytes = cube().to_bytes(1.0, 1);
        for end in 0..bytes.len() {
            assert!(Job::from_bytes(&bytes[..end]).is_err());
        }
        let mut longer = bytes.clone();
        longer.push(0);
        assert!(Job::from_bytes(&longer).is_err());
        let mut lying = bytes;
        lying[48..56].copy_from_slice(&u64::MAX.to_le_bytes());
        assert!(Job::from_bytes(&lying).is_err());
        assert!(Answer::from_bytes(&cube().to_bytes(1.0, 1)).is_err());
    }

    #[test]
    fn an_answer_to_something_else_is_found() {
        let job = cube();
        let good =
            Answer { points: job.points.clone(), tets: vec![[0, 1, 2, 4]], faces: vec![([0, 1, 2], 3)] };
        good.check(&job).unwrap();
        let wrong = |change: &dyn Fn(&mut Answer)| {
            let mut answer = good.clone();
            change(&mut answer);
            answer.check(&job).unwrap_err()
        };
        assert!(wrong(&|a| a.points.truncate(7)).contains("7 vertices"));
        assert!(wrong(&|a| a.points.swap(1, 2)).contains("vertex 1"));
        assert!(wrong(&|a| a.points[3].x = f64::NAN).contains("vertex 3"));
        assert!(wrong(&|a| a.points.push(DVec3::INFINITY)).contains("vertex 8"));
        assert!(wrong(&|a| a.tets[0][3] = 8).contains("tetrahedron 0"));
        assert!(wrong(&|a| a.faces[0].1 = 12).contains("face 0"));
    }
}
