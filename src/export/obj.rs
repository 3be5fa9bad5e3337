//! Wavefront OBJ with a material and its picture.

use std::fmt::Write;

use super::textured::Textured;
use super::{AtlasParams, ExportError};
use crate::exec::Exec;
use crate::lap::LappedSolid;
use crate::mesh::Shortest;
use crate::render::{DisplaceParams, Shell, Surface};

/// The three files of an OBJ.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObjFiles {
    /// The shape: positions with every bit, texture coordinates, normals, faces.
    pub obj: Vec<u8>,
    /// The material.
    pub mtl: Vec<u8>,
    /// The atlas, a PNG.
    pub atlas: Vec<u8>,
}

/// A lapped solid as a Wavefront OBJ, its MTL and a baked atlas; outside and cut faces alike, in the mesh's own axes
/// and units. `names` are those of the MTL and of the atlas, as the other files shall name them: relative to the OBJ.
///
/// Positions are shared by all faces around a vertex, so that the surface is closed; texture coordinates are doubled
/// along the borders of charts and normals at creases.
///
/// # Errors
/// [`ExportError`]: bad settings or names, no surface, more charts than the atlas holds, cancelled.
pub fn obj(
    solid: &LappedSolid,
    names: [&str; 2],
    params: &AtlasParams,
    displace: &DisplaceParams,
    exec: &Exec,
) -> Result<ObjFiles, ExportError> {
    let [mtl_name, atlas_name] = names;
    if let Some(bad) = names.into_iter().find(|n| n.chars().any(char::is_control)) {
        return Err(ExportError::Name(bad.to_owned()));
    }
    let surface = Surface::new(solid);
    let shell = Shell::new(&surface, displace, exec)?;
    let textured = Textured::new(&surface, &shell, params, exec)?;
    // A name in an OBJ ends at white space.
    let name = params.name.as_deref().unwrap_or("lapis");
    let name: String =
        name.chars().map(|c| if c.is_whitespace() || c.is_control() { '_' } else { c }).collect();

    // Only vertices that the surface has.
    let mut number = vec![0usize; shell.places.len()];
    let mut text = format!("# made by lapis\nmtllib {mtl_name}\no {name}\n");
    let mut count = 0;
    for p in &shell.points {
        let v = p.vertex as usize;
        if number[v] == 0 {
            count += 1;
            number[v] = count;
            let p = shell.places[v];
            // Writing to a string cannot fail.
            let _ = writeln!(text, "v {} {} {}", Shortest(p.x), Shortest(p.y), Shortest(p.z));
        }
    }
    exec.check()?;
    for uv in &textured.uv {
        // OBJ's v runs up from the picture's bottom. A millionth is a hundredth of a texel.
        let _ = writeln!(text, "vt {:.6} {:.6}", uv.x, 1.0 - uv.y);
    }
    for p in &shell.points {
        let n = p.normal;
        let _ = writeln!(text, "vn {:.5} {:.5} {:.5}", n.x, n.y, n.z);
    }
    exec.check()?;
    let _ = writeln!(text, "usemtl {name}");
    for (points, vertices) in shell.faces.iter().zip(&textured.faces) {
        text.push('f');
        for (p, v) in points.iter().zip(vertices) {
            let place = number[shell.points[*p as usize].vertex as usize];
            let _ = write!(text, " {place}/{}/{}", u64::from(*v) + 1, u64::from(*p) + 1);
        }
        text.push('\n');
    }

    let mut material = format!(
        "# made by lapis\nnewmtl {name}\nKa 0 0 0\nKd 1 1 1\nKs 0 0 0\nd 1\nillum 1\nmap_Kd {atlas_name}\n"
    );
    if !textured.opaque {
        let _ = writeln!(material, "map_d -imfchan m {atlas_name}");
    }
    Ok(ObjFiles { obj: text.into_bytes(), mtl: material.into_bytes(), atlas: textured.picture.png(false) })
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::colour::encode;
    use crate::render::{Picture, testing};

    fn lines<'a>(text: &'a str, key: &'a str) -> impl Iterator<Item = Vec<f64>> + 'a {
        text.lines()
            .filter_map(move |l| l.strip_prefix(key)?.strip_prefix(' '))
            .map(|l| l.split(' ').map(|w| w.parse().unwrap()).collect())
    }

    #[test]
    fn shape_and_colours_come_back() {
        let half = testing::half_ball(8);
        let params = AtlasParams { size: 512, name: Some("half ball".into()) };
        let made =
            obj(&half, ["a.mtl", "a-atlas.png"], &params, &DisplaceParams::default(), &Exec::default())
                .unwrap();
        let text = String::from_utf8(made.obj).unwrap();
        assert!(text.contains("mtllib a.mtl\n") && text.contains("usemtl half_ball\n"));
        let material = String::from_utf8(made.mtl).unwrap();
        assert!(material.contains("newmtl half_ball\n") && material.contains("map_Kd a-atlas.png\n"));
        assert!(!material.contains("map_d"), "it is opaque");
        let picture = Picture::from_png(&made.atlas).unwrap();

        let places: Vec<DVec3> = lines(&text, "v").map(|x| DVec3::from_slice(&x)).collect();
        let coordinates: Vec<DVec2> = lines(&text, "vt").map(|x| DVec2::from_slice(&x)).collect();
        let normals: Vec<DVec3> = lines(&text, "vn").map(|x| DVec3::from_slice(&x)).collect();
        // Positions are exact, and each is there once.
        assert!(places.iter().all(|p| half.mesh.vertices.contains(p)));
        let mut bits: Vec<_> = places.iter().map(|p| p.to_array().map(f64::to_bits)).collect();
        bits.sort_unstable();
        bits.dedup();
        assert_eq!(bits.len(), places.len());

        let mut volume = 0.0;
        let mut edges = Vec::new();
        let faces: Vec<&str> = text.lines().filter_map(|l| l.strip_prefix("f ")).collect();
        assert_eq!(faces.len(), half.mesh.boundary.len());
        for face in faces {
            let corners: Vec<Vec<usize>> = face
                .split(' ')
                .map(|c| c.split('/').map(|n| n.parse::<usize>().unwrap() - 1).collect())
                .collect();
            let [a, b, c] = [0, 1, 2].map(|k| places[corners[k][0]]);
            volume += a.dot(b.cross(c)) / 6.0;
            let out = (b - a).cross(c - a).normalize();
            assert!(corners.iter().all(|c| normals[c[2]].dot(out) > 0.7));
            edges.extend([0, 1, 2].map(|k| (corners[k][0], corners[(k + 1) % 3][0])));
            let uv = corners.iter().map(|c| coordinates[c[1]]).sum::<DVec2>() / 3.0 * 512.0;
            let texel = picture.pixel(uv.x as u32, (512.0 - uv.y) as u32);
            let expected = encode(testing::colour_at(&half, (a + b + c) / 3.0));
            for n in 0..4 {
                assert!(texel[n].abs_diff(expected[n]) <= 3, "{texel:?} {expected:?}");
            }
        }
        assert!((volume - half.mesh.volume()).abs() < 1e-12);
        // Closed: every edge is there once each way.
        edges.sort_unstable();
        assert!(edges.iter().all(|(a, b)| edges.binary_search(&(*b, *a)).is_ok()));
    }

    #[test]
    fn clear_colours_and_bad_names_are_told() {
        let mut cube = testing::cube(1);
        let clear = crate::volume::SolidTexture::new([1; 3], vec![[255, 0, 0, 128]], [false; 3]).unwrap();
        cube.exemplars = vec![std::sync::Arc::new(clear)];
        let made = obj(
            &cube,
            ["a.mtl", "a.png"],
            &AtlasParams::default(),
            &DisplaceParams::default(),
            &Exec::default(),
        )
        .unwrap();
        assert!(String::from_utf8(made.mtl).unwrap().contains("map_d"));
        let bad = obj(
            &cube,
            ["a\n.mtl", "a.png"],
            &AtlasParams::default(),
            &DisplaceParams::default(),
            &Exec::default(),
        );
        assert!(matches!(bad, Err(ExportError::Name(_))));
    }

    #[test]
    fn the_same_bytes_at_any_thread_count() {
        let half = testing::lively(4, 16, 2);
        let params = AtlasParams { size: 256, name: None };
        let with = |n| {
            obj(
                &half,
                ["a.mtl", "a.png"],
                &params,
                &DisplaceParams::default(),
                &Exec::with_threads(n).unwrap(),
            )
            .unwrap()
        };
        assert_eq!(with(1), with(2));
    }
}
