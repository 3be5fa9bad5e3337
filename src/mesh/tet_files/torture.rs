//! No bytes may bring a reader down: files cut at every length, with changed bytes, and noise.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::{Fault, Soup, msh, vtu};

type Reader = fn(&[u8]) -> Result<Soup, Fault>;

fn samples() -> Vec<(Reader, Vec<u8>)> {
    let vtu =
        vtu::tests::styles().into_iter().step_by(3).map(|s| (vtu::read as Reader, vtu::tests::sample(s)));
    let msh = [msh::tests::TWO.into(), msh::tests::FOUR.into()]
        .into_iter()
        .chain([("2.2", false), ("4.1", false), ("4.1", true)].map(|(v, big)| msh::tests::binary(v, big)))
        .map(|bytes| (msh::read as Reader, bytes));
    vtu.chain(msh).collect()
}

/// Reads, and checks what a reader promises of tetrahedra that it gives.
fn reads(reader: Reader, bytes: &[u8]) -> bool {
    match reader(bytes) {
        Ok(soup) => {
            assert!(!soup.tets.is_empty());
            assert!(soup.points.iter().all(|p| p.is_finite()));
            assert!(soup.tets.iter().flatten().all(|&v| (v as usize) < soup.points.len()));
            // Whatever they are, the mesh made of them is a mesh or an error.
            let _ = soup.mesh();
            true
        }
        Err(fault) => {
            assert!(fault.what.len() < 1000 && !fault.what.is_empty(), "{}", fault.what);
            false
        }
    }
}

#[test]
fn no_cut_brings_a_reader_down() {
    for (reader, bytes) in samples() {
        assert!(reads(reader, &bytes));
        let whole = (0..bytes.len()).filter(|&n| reads(reader, &bytes[..n])).count();
        // Only the last line's end, and sections after the elements, can be missed.
        assert!(whole <= 4, "{whole} cuts were read of\n{}", String::from_utf8_lossy(&bytes));
    }
}

#[test]
fn changed_bytes_bring_no_reader_down() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for (reader, bytes) in samples() {
        for _ in 0..1500 {
            let mut bytes = bytes.clone();
            for _ in 0..1 + rng.next_u32() % 4 {
                let at = rng.next_u32() as usize % bytes.len();
                bytes[at] = match rng.next_u32() % 3 {
                    0 => rng.next_u32() as u8,
                    1 => b"0123456789-.e/\n \"<>$="[rng.next_u32() as usize % 21],
                    _ => bytes[at] ^ (1 << (rng.next_u32() % 8)),
                };
            }
            reads(reader, &bytes);
        }
    }
}

#[test]
fn noise_brings_no_reader_down() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let heads = [
        &b""[..],
        b"<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"9\" NumberOfCells=\"9\">",
        b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n",
        b"$MeshFormat\n2.2 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n9\n",
        b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n",
    ];
    for reader in [vtu::read as Reader, msh::read] {
        for head in heads {
            for length in 1..300 {
                let mut bytes = head.to_vec();
                bytes.extend((0..length).map(|_| rng.next_u32() as u8));
                reads(reader, &bytes);
            }
        }
    }
}
