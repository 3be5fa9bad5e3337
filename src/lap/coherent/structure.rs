//! Whether a texture's patches should agree.

use crate::lap::params::{Coherent, FillParams};
use crate::volume::SolidTexture;

/// A texture whose patches cannot agree: the axes along which it does not tile.
#[derive(Debug)]
pub(in crate::lap) struct Unfit(pub(in crate::lap) String);

/// Particles count as structure where they fill this part of the volume.
const PARTICLES: std::ops::Range<f64> = 0.02..0.99;
/// A texture has rows where, shifted along an axis, it is this much more like itself than at smaller shifts.
const ROWS: f64 = 0.6;

/// Whether a fill is to be coherent along the `free` axes.
///
/// # Errors
/// [`Unfit`] where it is asked for and the texture does not tile along one of them.
pub(in crate::lap) fn is_wanted(
    texture: &SolidTexture,
    free: [bool; 3],
    params: &FillParams,
) -> Result<bool, Unfit> {
    let lacking: String =
        (0..3).filter(|&n| free[n] && !texture.tiles()[n]).map(|n| ['x', 'y', 'z'][n]).collect();
    let fit = lacking.is_empty() && free.contains(&true);
    match params.coherent {
        Coherent::False => Ok(false),
        Coherent::True if !lacking.is_empty() => Err(Unfit(lacking)),
        Coherent::True => Ok(fit),
        Coherent::Auto => Ok(fit && (has_particles(texture) || has_rows(texture, free))),
    }
}

fn has_particles(texture: &SolidTexture) -> bool {
    texture.particles().is_some_and(|p| p.count > 0 && PARTICLES.contains(&p.share))
}

/// Whether the texture repeats itself along a free axis within its period, as rows of bricks do: shifted, it is first
/// unlike itself and then like itself again.
fn has_rows(texture: &SolidTexture, free: [bool; 3]) -> bool {
    let (size, values) = coarse(texture);
    // What does not change along any free axis, as layers of depth, is no structure of theirs.
    let strides = [1, size[0], size[0] * size[1]];
    let place = |v: usize| -> usize {
        let at = [v % size[0], v / size[0] % size[1], v / size[0] / size[1]];
        (0..3).filter(|&n| !free[n]).map(|n| at[n] * strides[n]).sum()
    };
    let mut layers = vec![(0.0, 0usize); values.len()];
    for (v, value) in values.iter().enumerate() {
        let layer = &mut layers[place(v)];
        layer.0 += value;
        layer.1 += 1;
    }
    let rest: Vec<f64> = values
        .iter()
        .enumerate()
        .map(|(v, value)| value - layers[place(v)].0 / layers[place(v)].1 as f64)
        .collect();
    let power: f64 = rest.iter().map(|r| r * r).sum();
    if power <= 0.0 {
        return false;
    }
    (0..3).filter(|&axis| free[axis]).any(|axis| {
        let side = size[axis];
        let mut least = 1.0f64;
        (1..=side / 2).any(|shift| {
            let sum: f64 = (rest.iter().enumerate())
                .map(|(v, r)| {
                    let at = v / strides[axis] % side;
                    r * rest[v - at * strides[axis] + (at + shift) % side * strides[axis]]
                })
                .sum();
            least = least.min(sum / power);
            sum / power - least > ROWS
        })
    })
}

/// The most cells along a side in which rows are looked for.
const COARSE: usize = 48;

/// The texture's lightness as means over cells: their number along the axes, and each one's.
fn coarse(texture: &SolidTexture) -> ([usize; 3], Vec<f64>) {
    let fine = texture.size().map(|n| n as usize);
    let size = fine.map(|n| n.min(COARSE));
    let mut cells = vec![(0.0, 0usize); size.iter().product()];
    for (v, [r, g, b, _]) in texture.voxels().iter().enumerate() {
        let at = [v % fine[0], v / fine[0] % fine[1], v / fine[0] / fine[1]];
        let [x, y, z] = [0, 1, 2].map(|n| at[n] * size[n] / fine[n]);
        let cell = &mut cells[(z * size[1] + y) * size[0] + x];
        cell.0 += f64::from(*r) * 0.3 + f64::from(*g) * 0.59 + f64::from(*b) * 0.11;
        cell.1 += 1;
    }
    (size, cells.into_iter().map(|(sum, count)| sum / count as f64).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(colour: impl Fn([usize; 3]) -> u8, tiles: [bool; 3]) -> SolidTexture {
        let voxels = (0..16usize.pow(3))
            .map(|v| {
                let c = colour([v % 16, v / 16 % 16, v / 256]);
                [c, c, c, 255]
            })
            .collect();
        SolidTexture::new([16; 3], voxels, tiles).unwrap()
    }

    #[test]
    fn rows_and_particles_are_structure_and_layers_and_noise_are_not() {
        let auto = FillParams::default();
        let wanted = |t: &SolidTexture, free| is_wanted(t, free, &auto).unwrap();
        let rows = texture(|[i, _, k]| if i % 8 < 2 || k % 8 < 2 { 220 } else { 120 }, [true; 3]);
        assert!(wanted(&rows, [true; 3]) && wanted(&rows, [true, false, true]));
        let layers = texture(|[_, j, _]| if j % 8 < 2 { 220 } else { 120 }, [true, false, true]);
        assert!(!wanted(&layers, [true, false, true]));
        let noise = |[i, j, k]: [usize; 3]| crate::lap::seed::mix(i as u64, j as u64, k as u64) as u8;
        assert!(!wanted(&texture(noise, [true; 3]), [true; 3]));
        let labels = (0..4096).map(|v| u32::from(v % 7 > 3)).collect();
        let stones = texture(noise, [true; 3]).with_labels(labels).unwrap();
        assert!(wanted(&stones, [true; 3]));
        // What does not tile cannot agree.
        let open = stones.with_tiles([true, false, true]);
        assert!(!wanted(&open, [true; 3]) && wanted(&open, [true, false, true]));
        let asked = FillParams { coherent: Coherent::True, ..FillParams::default() };
        assert_eq!(is_wanted(&open, [true; 3], &asked).unwrap_err().0, "y");
        assert!(is_wanted(&layers, [true, false, true], &asked).unwrap());
        let never = FillParams { coherent: Coherent::False, ..FillParams::default() };
        assert!(!is_wanted(&rows, [true; 3], &never).unwrap());
    }
}
