use std::collections::BTreeMap;
use std::sync::Arc;

use super::*;
use crate::lap::LappedSolid;
use crate::render::testing;
use crate::volume::SolidTexture;

/// With a displacement that is `value` of the place in texture space, 0 to 255.
fn displaced(mut solid: LappedSolid, height: f32, value: impl Fn([f64; 3]) -> u8) -> LappedSolid {
    for exemplar in &mut solid.exemplars {
        let texture = SolidTexture::clone(exemplar);
        let [nx, ny, nz] = texture.size();
        let mut values = Vec::new();
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let at = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
                    values.push(value([at(i, nx), at(j, ny), at(k, nz)]));
                }
            }
        }
        *exemplar = Arc::new(texture.with_displacement(values, height).unwrap());
    }
    solid
}

fn shell(solid: &LappedSolid, params: &DisplaceParams) -> Shell {
    Shell::new(&Surface::new(solid), params, &Exec::default()).unwrap()
}

/// That the faces close up: each edge, by its places, has a face on both sides.
fn check_closed(shell: &Shell) {
    let mut edges: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for face in &shell.faces {
        let v = face.map(|p| shell.points[p as usize].vertex);
        for k in 0..3 {
            let (a, b) = (v[k], v[(k + 1) % 3]);
            assert_ne!(a, b);
            *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    let open: Vec<_> = edges.iter().filter(|e| *e.1 != 0).collect();
    assert!(open.is_empty(), "{} open edges of {}", open.len(), edges.len());
}

fn volume(shell: &Shell) -> f64 {
    (0..shell.faces.len()).map(|f| shell.corners(f)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

#[test]
fn without_displacement_it_is_the_surface() {
    let ball = testing::ball(4);
    let surface = Surface::new(&ball);
    let plain = shell(&ball, &DisplaceParams::default());
    assert_eq!((&plain.points, &plain.faces), (&surface.points, &surface.faces));
    assert_eq!(plain.places, ball.mesh.vertices);
    let own = [0.25, 0.5, 0.25];
    assert!(plain.parents.iter().enumerate().all(|(f, p)| p.face as usize == f && p.weights(own) == own));
    let flat = displaced(ball.clone(), 0.0, |_| 255);
    assert_eq!(shell(&flat, &DisplaceParams::default()).faces, surface.faces);
}

#[test]
fn an_even_height_moves_the_outside_along_its_normal() {
    let ball = displaced(testing::ball(6), 0.125, |_| 255);
    let scale = ball.frame[0][0].length();
    let moved = shell(&ball, &DisplaceParams::default());
    check_closed(&moved);
    let grown = (volume(&moved) / ball.mesh.volume()).cbrt();
    assert!((grown - (1.0 + 0.125 * scale)).abs() < 0.02, "{grown}");
}

#[test]
fn nothing_opens_at_the_rim_of_a_cut_which_stays_in_its_plane() {
    let bumps = |[x, y, z]: [f64; 3]| {
        let wave = |t: f64| 0.5 + 0.5 * (t * std::f64::consts::TAU).sin();
        (255.0 * wave(x) * wave(y) * wave(z)) as u8
    };
    let half = displaced(testing::half_ball(8), 0.2, bumps);
    let surface = Surface::new(&half);
    let [coarse, fine] =
        [0.6, 0.02].map(|tolerance| shell(&half, &DisplaceParams { tolerance, ..DisplaceParams::default() }));
    for made in [&coarse, &fine] {
        check_closed(made);
        let mut rim = 0;
        for (f, parent) in made.parents.iter().enumerate() {
            if let FaceOrigin::Cut(_) = surface.origin(parent.face as usize) {
                assert!(made.corners(f).iter().all(|p| p.x.abs() < 1e-9));
                rim += 1;
            }
        }
        assert!(rim > 50);
        assert!(volume(made) > half.mesh.volume() * 1.001);
    }
    // Between the vertices of the ball the bumps bend by a 25th of their height.
    assert!(coarse.faces.len() >= surface.faces.len() && fine.faces.len() > coarse.faces.len());
    // The number of faces has its limit.
    let few = shell(&half, &DisplaceParams { faces: surface.faces.len() + 10, ..DisplaceParams::default() });
    assert!(few.faces.len() <= surface.faces.len() + 10);
    check_closed(&few);
}

#[test]
fn colours_stay_where_they_are_on_the_surface() {
    let ball = displaced(testing::ball(4), 0.1, |[x, ..]| (255.0 * x) as u8);
    let surface = Surface::new(&ball);
    let moved = shell(&ball, &DisplaceParams::default());
    for (f, parent) in moved.parents.iter().enumerate().step_by(17) {
        let flat = surface.corners(parent.face as usize);
        let w = parent.weights([1.0 / 3.0; 3]);
        let below = flat[0] * w[0] + flat[1] * w[1] + flat[2] * w[2];
        let [a, b, c] = moved.corners(f);
        // Straight above, within the height.
        let away = (a + b + c) / 3.0 - below;
        assert!(away.length() <= 0.1 * ball.frame[0][0].length() + 1e-9);
        assert!(away.length() < 1e-6 || away.normalize().dot(below.normalize()) > 0.9);
    }
}
