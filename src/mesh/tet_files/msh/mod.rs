//! Gmsh's mesh files, versions 2 and 4.1, ASCII and binary
//! (<https://gmsh.info/doc/texinfo/gmsh.html#MSH-file-format>).

mod elements;
mod scan;

use elements::{Element, Shape, element};
use glam::DVec3;
use scan::Scan;

use super::{Fault, Soup};
use crate::mesh::tetrahedralise::MAX_TETS;
use crate::mesh::{MAX_MESH_ELEMENTS, index};

/// Which of the two layouts a file has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

/// The nodes read so far, and their tags, which may leave gaps.
#[derive(Debug, Default)]
struct Nodes {
    points: Vec<DVec3>,
    /// The tag of each node, and its index; sorted once all are read.
    tags: Vec<(u64, u32)>,
}

/// Reads the tetrahedra of a `.msh` file.
pub(super) fn read(bytes: &[u8]) -> Result<Soup, Fault> {
    let mut scan = Scan::new(bytes);
    let version = head(&mut scan)?;
    let mut nodes: Option<Nodes> = None;
    let mut tets = None;
    let mut passed = 0;
    while let Some(name) = scan.section()? {
        match (name, &nodes) {
            (b"Nodes", None) => nodes = Some(read_nodes(&mut scan, version)?),
            (b"Elements", Some(nodes)) if tets.is_none() => {
                let mut found = Vec::new();
                passed = match version {
                    Version::Two => elements_two(&mut scan, nodes, &mut found)?,
                    Version::Four => elements_four(&mut scan, nodes, &mut found)?,
                };
                scan.end("Elements")?;
                tets = Some(found);
            }
            (b"Elements", None) => return Err(scan.fault("$Elements come before $Nodes")),
            (b"Nodes" | b"Elements", _) => {
                let name = String::from_utf8_lossy(name).into_owned();
                return Err(scan.fault(format!("there are two sections ${name}")));
            }
            (other, _) => scan.skip_section(other)?,
        }
    }
    let Some(tets) = tets else {
        return Err(Fault::whole("the file has no sections $Nodes and $Elements"));
    };
    if tets.is_empty() {
        return Err(Fault::whole(format!(
            "it has no tetrahedra ({passed} elements of lower dimension); mesh the volume in Gmsh (-3), or let \
             `lapis tetrahedralise` fill a surface"
        )));
    }
    Ok(Soup { points: nodes.unwrap_or_default().points, tets })
}

/// Reads `$MeshFormat`.
fn head(scan: &mut Scan<'_>) -> Result<Version, Fault> {
    const CONVERT: &str = "convert it by `gmsh -save -format msh41 IN.msh -o OUT.msh`";
    match scan.word() {
        Some(b"$MeshFormat") => {}
        Some(b"$NOD") => return Err(scan.fault(format!("MSH version 1 is not read; {CONVERT}"))),
        _ => return Err(scan.fault("this is no Gmsh file: it does not begin with $MeshFormat")),
    }
    let number: f64 = scan.parsed("the format's version")?;
    let version = if (2.0..3.0).contains(&number) {
        Version::Two
    } else if number == 4.1 {
        Version::Four
    } else {
        return Err(scan.fault(format!("MSH version {number} is not read; 2.2 and 4.1 are: {CONVERT}")));
    };
    let binary: u32 = scan.parsed("0 (text) or 1 (binary)")?;
    let bytes: u32 = scan.parsed("the size of its numbers")?;
    if bytes != 8 {
        return Err(scan.fault(format!("its numbers have {bytes} bytes; only 8 are read: {CONVERT}")));
    }
    if binary == 1 {
        scan.end_of_line();
        scan.binary = true;
        match scan.int("the number 1, which tells the order of bytes")? {
            1 => {}
            0x0100_0000 => scan.big_endian = true,
            other => return Err(scan.fault(format!("{other} where the number 1 tells the order of bytes"))),
        }
    } else if binary != 0 {
        return Err(scan.fault(format!("the file type {binary}; it is 0 (text) or 1 (binary)")));
    }
    scan.end("MeshFormat")?;
    Ok(version)
}

/// A count of things that take at least `bytes` bytes each.
fn checked(scan: &Scan<'_>, count: u64, bytes: usize, things: &str, most: usize) -> Result<usize, Fault> {
    let count = usize::try_from(count).unwrap_or(usize::MAX);
    if count > scan.left() / bytes {
        return Err(scan.fault(format!("the file is too short for the {count} {things} that it promises")));
    }
    if count > most {
        return Err(scan.fault(format!("{count} {things}; at most {most} are read")));
    }
    Ok(count)
}

fn count(n: i32, scan: &Scan<'_>, things: &str) -> Result<u64, Fault> {
    u64::try_from(n).map_err(|_| scan.fault(format!("{n} {things}")))
}

/// The number of things in a section of version 2: a word, even in binary files.
fn count_line(scan: &mut Scan<'_>, things: &str) -> Result<u64, Fault> {
    let n = scan.parsed(&format!("the number of {things}"))?;
    if scan.binary {
        scan.end_of_line();
    }
    Ok(n)
}

fn read_nodes(scan: &mut Scan<'_>, version: Version) -> Result<Nodes, Fault> {
    let mut nodes = Nodes::default();
    match version {
        Version::Two => {
            let n = count_line(scan, "nodes")?;
            // A tag and three numbers: as bytes, or as words with white space.
            let n = checked(scan, n, if scan.binary { 28 } else { 8 }, "nodes", MAX_MESH_ELEMENTS)?;
            nodes.reserve(n);
            for _ in 0..n {
                let tag = scan.int("a node's number")?;
                let tag = count(tag, scan, "is no node's number")?;
                let p = point(scan, tag, 0)?;
                nodes.add(tag, p);
            }
        }
        Version::Four => {
            let blocks = scan.size("the number of blocks")?;
            let n = scan.size("the number of nodes")?;
            let n = checked(scan, n, if scan.binary { 32 } else { 8 }, "nodes", MAX_MESH_ELEMENTS)?;
            skip_range(scan)?;
            nodes.reserve(n);
            let mut tags = Vec::new();
            for _ in 0..blocks {
                let dimension = scan.int("an entity's dimension")?;
                scan.int("an entity's number")?;
                let parametric = scan.int("0 or 1 (parametric)")?;
                let here = scan.size("a block's number of nodes")?;
                if here > (n - nodes.points.len()) as u64 {
                    return Err(scan.fault(format!("the blocks have more than the {n} nodes promised")));
                }
                let extra = if parametric == 0 { 0 } else { dimension.clamp(0, 3) };
                tags.clear();
                for _ in 0..here {
                    tags.push(scan.size("a node's number")?);
                }
                for &tag in &tags {
                    let p = point(scan, tag, extra)?;
                    nodes.add(tag, p);
                }
            }
            if nodes.points.len() != n {
                let have = nodes.points.len();
                return Err(scan.fault(format!("{have} nodes where {n} are promised")));
            }
        }
    }
    scan.end("Nodes")?;
    nodes.tags.sort_unstable();
    match nodes.tags.windows(2).find(|w| w[0].0 == w[1].0) {
        Some(w) => Err(Fault::whole(format!("two nodes have the number {}", w[0].0))),
        None => Ok(nodes),
    }
}

/// The least and the greatest number of a section of version 4; they are not needed.
fn skip_range(scan: &mut Scan<'_>) -> Result<(), Fault> {
    scan.size("the least number")?;
    scan.size("the greatest number")?;
    Ok(())
}

fn point(scan: &mut Scan<'_>, tag: u64, extra: i32) -> Result<DVec3, Fault> {
    let mut p = DVec3::ZERO;
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        p[k] = scan.double(name)?;
    }
    for _ in 0..extra {
        scan.double("a parametric coordinate")?;
    }
    if p.is_finite() {
        Ok(p)
    } else {
        Err(scan.fault(format!("node {tag} has a coordinate that is not a finite number")))
    }
}

impl Nodes {
    fn reserve(&mut self, n: usize) {
        self.points.reserve_exact(n);
        self.tags.reserve_exact(n);
    }

    fn add(&mut self, tag: u64, p: DVec3) {
        self.tags.push((tag, index(self.points.len())));
        self.points.push(p);
    }

    /// The index of the node with this tag.
    fn find(&self, tag: u64) -> Option<u32> {
        // Most files number from 1 without gaps.
        let first = self.tags.first()?.0;
        let guess = usize::try_from(tag.checked_sub(first)?).ok()?;
        if let Some(&(found, index)) = self.tags.get(guess)
            && found == tag
        {
            return Some(index);
        }
        let at = self.tags.binary_search_by_key(&tag, |t| t.0).ok()?;
        Some(self.tags[at].1)
    }
}

/// The kind of an element, if it may stand in the file.
fn known(scan: &Scan<'_>, kind: i32, number: impl std::fmt::Display) -> Result<Element, Fault> {
    let Some(found) = element(kind) else {
        let what =
            format!("element {number} is of type {kind}, which is not known here; save the mesh without it");
        return Err(scan.fault(what));
    };
    if let Shape::Other(name) = found.shape {
        return Err(scan.fault(format!(
            "element {number} is a {name} (type {kind}); only tetrahedra can be filled: mesh without recombining, \
             or split it into tetrahedra"
        )));
    }
    Ok(found)
}

/// Takes a tetrahedron; what else there is is passed over.
fn take(
    scan: &Scan<'_>,
    number: impl std::fmt::Display,
    names: &[u64],
    nodes: &Nodes,
    tets: &mut Vec<[u32; 4]>,
) -> Result<(), Fault> {
    if tets.len() == MAX_TETS {
        return Err(scan.fault(format!("more than {MAX_TETS} tetrahedra; at most so many are read")));
    }
    let mut tet = [0; 4];
    for (corner, &name) in tet.iter_mut().zip(names) {
        *corner = nodes
            .find(name)
            .ok_or_else(|| scan.fault(format!("element {number} names node {name}, which does not exist")))?;
    }
    tets.push(tet);
    Ok(())
}

/// `$Elements` of version 2. Returns how many elements were passed over.
fn elements_two(scan: &mut Scan<'_>, nodes: &Nodes, tets: &mut Vec<[u32; 4]>) -> Result<usize, Fault> {
    let n = count_line(scan, "elements")?;
    let n = checked(scan, n, if scan.binary { 8 } else { 6 }, "elements", usize::MAX)?;
    let (mut read, mut passed) = (0, 0);
    let mut names = Vec::new();
    while read < n {
        // Text has a head for each element, bytes have one for several.
        let first = if scan.binary { 0 } else { scan.int("an element's number")? };
        let kind = scan.int("an element's type")?;
        let here = if scan.binary { scan.int("a block's number of elements")? } else { 1 };
        let tags = scan.int("an element's number of tags")?;
        let tags = count(tags, scan, "tags")?;
        let here = usize::try_from(here)
            .ok()
            .filter(|h| (1..=n - read).contains(h))
            .ok_or_else(|| scan.fault(format!("a block of {here} elements where {} are left", n - read)))?;
        for _ in 0..here {
            let number = if scan.binary { scan.int("an element's number")? } else { first };
            let found = known(scan, kind, number)?;
            for _ in 0..tags {
                scan.int("a tag")?;
            }
            names.clear();
            for _ in 0..found.nodes {
                let name = scan.int("a node's number")?;
                names.push(count(name, scan, "is no node's number")?);
            }
            if found.shape == Shape::Tetrahedron {
                take(scan, number, &names, nodes, tets)?;
            } else {
                passed += 1;
            }
        }
        read += here;
    }
    Ok(passed)
}

/// `$Elements` of version 4.1. Returns how many elements were passed over.
fn elements_four(scan: &mut Scan<'_>, nodes: &Nodes, tets: &mut Vec<[u32; 4]>) -> Result<usize, Fault> {
    let blocks = scan.size("the number of blocks")?;
    let n = scan.size("the number of elements")?;
    let n = checked(scan, n, if scan.binary { 16 } else { 4 }, "elements", usize::MAX)?;
    skip_range(scan)?;
    let (mut read, mut passed) = (0, 0);
    let mut names = Vec::new();
    for block in 0..blocks {
        scan.int("an entity's dimension")?;
        scan.int("an entity's number")?;
        let kind = scan.int("an element's type")?;
        let here = scan.size("a block's number of elements")?;
        if here > (n - read) as u64 {
            return Err(scan.fault(format!("block {block} has {here} elements where {} are left", n - read)));
        }
        for _ in 0..here {
            let number = scan.size("an element's number")?;
            let found = known(scan, kind, number)?;
            names.clear();
            for _ in 0..found.nodes {
                names.push(scan.size("a node's number")?);
            }
            if found.shape == Shape::Tetrahedron {
                take(scan, number, &names, nodes, tets)?;
            } else {
                passed += 1;
            }
            read += 1;
        }
    }
    if read == n { Ok(passed) } else { Err(scan.fault(format!("{read} elements where {n} are promised"))) }
}

#[cfg(test)]
pub(super) mod tests;
