//! Two tetrahedra and a triangle in every layout, and what is wrong with bad files.

use std::fmt::Write;

use super::*;

const PLACES: [[f64; 3]; 6] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 9.0]];
/// Numbers with gaps, not in order.
const TAGS: [u64; 6] = [10, 3, 7, 8, 100, 1];

pub(in super::super) const TWO: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"a $ b\"\n\
    $EndPhysicalNames\n$Nodes\n6\n10 0 0 0\n3 1 0 0\n7 0 1 0\n8 0 0 1\n100 1 1 1\n1 9 9 9\n$EndNodes\n$Elements\n3\n\
    1 2 2 0 1 10 3 7\n2 4 2 1 1 10 3 7 8\n5 4 3 1 1 0 3 7 8 100\n$EndElements\n\
    $NodeData\n1\n\"x\"\n$EndNodeData\n";

pub(in super::super) const FOUR: &str = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 1 1 1 0 0\n\
    $EndEntities\n$Nodes\n2 6 1 100\n2 1 1 3\n10\n3\n7\n0 0 0 0.5 0.5\n1 0 0 0.5 0.5\n0 1 0 0.5 0.5\n3 1 0 3\n8\n100\n\
    1\n0 0 1\n1 1 1\n9 9 9\n$EndNodes\n$Elements\n2 3 1 5\n2 1 2 1\n1 10 3 7\n3 1 4 2\n2 10 3 7 8\n5 3 7 8 100\n\
    $EndElements\n";

fn int(big: bool, n: i32) -> Vec<u8> {
    if big { n.to_be_bytes().to_vec() } else { n.to_le_bytes().to_vec() }
}

fn size(big: bool, n: u64) -> Vec<u8> {
    if big { n.to_be_bytes().to_vec() } else { n.to_le_bytes().to_vec() }
}

fn double(big: bool, x: f64) -> Vec<u8> {
    if big { x.to_be_bytes().to_vec() } else { x.to_le_bytes().to_vec() }
}

/// The sample in bytes.
pub(in super::super) fn binary(version: &str, big: bool) -> Vec<u8> {
    let ints = |all: &[i32]| all.iter().flat_map(|n| int(big, *n)).collect::<Vec<u8>>();
    let sizes = |all: &[u64]| all.iter().flat_map(|n| size(big, *n)).collect::<Vec<u8>>();
    let place = |i: usize| PLACES[i].iter().flat_map(|x| double(big, *x)).collect::<Vec<u8>>();
    let mut f = format!("$MeshFormat\n{version} 1 8\n").into_bytes();
    f.extend(int(big, 1));
    f.extend(b"\n$EndMeshFormat\n$Nodes\n");
    if version.starts_with('2') {
        f.extend(b"6\n");
        for (i, tag) in TAGS.iter().enumerate() {
            f.extend(int(big, *tag as i32));
            f.extend(place(i));
        }
        f.extend(b"\n$EndNodes\n$Elements\n3\n");
        f.extend(ints(&[2, 1, 2, 1, 0, 1, 10, 3, 7]));
        f.extend(ints(&[4, 2, 1, 2, 1, 10, 3, 7, 8, 5, 1, 3, 7, 8, 100]));
    } else {
        f.extend(sizes(&[2, 6, 1, 100]));
        for (head, nodes, extra) in [([2, 1, 1], 0..3, 2), ([3, 1, 0], 3..6, 0)] {
            f.extend(ints(&head));
            f.extend(size(big, nodes.len() as u64));
            f.extend(sizes(&TAGS[nodes.clone()]));
            for i in nodes {
                f.extend(place(i));
                f.extend((0..extra).flat_map(|_| double(big, 0.5)));
            }
        }
        f.extend(b"\n$EndNodes\n$Elements\n");
        f.extend(sizes(&[2, 3, 1, 5]));
        f.extend(ints(&[2, 1, 2]));
        f.extend(sizes(&[1, 1, 10, 3, 7]));
        f.extend(ints(&[3, 1, 4]));
        f.extend(sizes(&[2, 2, 10, 3, 7, 8, 5, 3, 7, 8, 100]));
    }
    f.extend(b"\n$EndElements\n");
    f
}

#[test]
fn every_layout_is_read() {
    let mut files = vec![TWO.as_bytes().to_vec(), FOUR.into(), TWO.replace('\n', "\r\n").into_bytes()];
    for big in [false, true] {
        files.extend([binary("2.2", big), binary("4.1", big)]);
    }
    for (i, file) in files.iter().enumerate() {
        let soup = read(file).unwrap_or_else(|e| panic!("file {i}: {}{}", e.place, e.what));
        assert_eq!(soup.points, PLACES.map(DVec3::from_array), "file {i}");
        assert_eq!(soup.tets, [[0, 1, 2, 3], [1, 2, 3, 4]], "file {i}");
    }
}

#[test]
fn of_quadratic_tetrahedra_the_corners_are_taken() {
    let mut file = String::from("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n");
    for (i, p) in PLACES.iter().chain(&PLACES[..4]).enumerate() {
        writeln!(file, "{} {} {} {}", i + 1, p[0], p[1], p[2]).unwrap();
    }
    file += "$EndNodes\n$Elements\n2\n1 15 0 1\n2 11 1 9 1 2 3 4 5 6 7 8 9 10\n$EndElements\n";
    assert_eq!(read(file.as_bytes()).unwrap().tets, [[0, 1, 2, 3]]);
}

#[test]
fn faults_are_located_and_say_what_helps() {
    let message = |file: &[u8]| {
        let f = read(file).unwrap_err();
        format!("{}{}", f.place, f.what)
    };
    let two = |from: &str, to: &str| {
        assert!(TWO.contains(from), "{from}");
        message(TWO.replacen(from, to, 1).as_bytes())
    };
    let four = |from: &str, to: &str| {
        assert!(FOUR.contains(from), "{from}");
        message(FOUR.replacen(from, to, 1).as_bytes())
    };
    let bytes = binary("4.1", false);
    let said = [
        (two("$MeshFormat\n2.2", "$NOD\n2.2"), "line 1: MSH version 1 is not read; convert it by `gmsh"),
        (two("$MeshFormat\n2.2", "solid\n2.2"), "no Gmsh file"),
        (two("2.2 0 8", "4.0 0 8"), "line 2: MSH version 4 is not read"),
        (two("2.2 0 8", "2.2 0 4"), "4 bytes"),
        (two("2.2 0 8", "2.2 7 8"), "file type 7"),
        (two("3 1 0 0", "3 1 x 0"), "line 11: \"x\" where y belongs"),
        (two("3 1 0 0", "3 1 nan 0"), "node 3 has a coordinate"),
        (two("3 1 0 0", "10 1 0 0"), "two nodes have the number 10"),
        (two("3 1 0 0", "-3 1 0 0"), "-3 is no node's number"),
        (two("$Nodes\n6", "$Nodes\n5000000000"), "too short for the 5000000000 nodes"),
        (two("$Nodes\n6", "$Nodes\n5"), "$Nodes is longer than it says"),
        (two("$Elements\n3", "$Elements\n2"), "$Elements is longer than it says"),
        (two("$Elements\n3", "$Elements\n4"), "where an element's number belongs"),
        (two("$Elements\n3", "$Elements\n900000000000"), "too short for the 900000000000 elements"),
        (two("7 8 100\n", "7 8 101\n"), "element 5 names node 101, which does not exist"),
        (two("2 4 2 1 1", "2 5 2 1 1"), "element 2 is a hexahedron (type 5)"),
        (two("2 4 2 1 1", "2 140 2 1 1"), "element 2 is of type 140"),
        (two("2 4 2 1 1", "2 4 -2 1 1"), "-2 tags"),
        (two("$EndPhysicalNames", "$EndPhysical"), "ends before $EndPhysicalNames"),
        (two("$Nodes", "$Noddies"), "ends before $EndNoddies"),
        (two("$NodeData\n", "$Elements\n"), "two sections $Elements"),
        (four("2 6 1 100", "2 7 1 100"), "6 nodes where 7 are promised"),
        (four("2 6 1 100", "2 5 1 100"), "more than the 5 nodes promised"),
        (four("3 1 4 2", "3 1 6 2"), "element 2 is a prism (type 6)"),
        (four("3 1 4 2", "3 1 4 20"), "block 1 has 20 elements where 2 are left"),
        (four("2 3 1 5", "2 4 1 5"), "3 elements where 4 are promised"),
        (
            four("3 1 4 2\n2 10 3 7 8\n5 3 7 8 100\n", "1 1 1 2\n2 10 3\n5 7 8\n"),
            "3 elements of lower dimension",
        ),
        (message(&bytes[..bytes.len() - 30]), "byte "),
        (message(b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"), "no sections $Nodes and $Elements"),
        (message(b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Elements\n"), "$Elements come before $Nodes"),
    ];
    for (message, words) in said {
        assert!(message.contains(words), "{message}\nhas nothing of {words}");
    }
}
