//! From colour to density.

use super::TranslucentParams;
use crate::colour::{Colour, LinearRgba, decode, oklab};
use crate::lap::LappedSolid;

/// About how many voxels of the solid textures are looked at to learn what they look like on average.
const LOOKED_AT: usize = 1 << 16;

/// Textures whose colours stand out by less than this in Oklab are dense all over.
const PLAIN: f32 = 0.01;

/// From how many standard deviations above the mean on something is wholly dense. Less lets too little be seen through.
const DENSE: f32 = 1.5;

/// The transfer of one picture.
pub(super) struct Transfer {
    /// Of what no rule names, in one over the mesh's unit.
    density: f32,
    /// The rules, the weakest first.
    rules: Vec<Rule>,
    /// Without rules: what stands out.
    usual: Option<Usual>,
}

struct Rule {
    lab: [f32; 3],
    within: f32,
    density: f32,
}

/// What the solid textures look like on average.
struct Usual {
    /// Mean of what stands out.
    mean: f32,
    /// Standard deviation of that.
    spread: f32,
}

impl Transfer {
    /// Of solids whose size is `size`, in the mesh's unit.
    #[allow(clippy::cast_possible_truncation)] // far more digits than colours have
    pub(super) fn new<'a>(
        params: &TranslucentParams,
        solids: impl Iterator<Item = &'a LappedSolid>,
        size: f64,
    ) -> Self {
        let rule = |colour: Colour, within: f64, density: f64| Rule {
            lab: oklab(decode(colour.0)),
            within: within as f32,
            density: (density / size) as f32,
        };
        let clear = params.clear.iter().map(|&colour| rule(colour, params.within, 0.0));
        let named = params.rule.iter().map(|r| rule(r.colour, r.within, r.density));
        let mut rules: Vec<Rule> = named.chain(clear).collect();
        rules.reverse();
        let usual = if rules.is_empty() { Usual::of(solids) } else { None };
        Self { density: (params.density / size) as f32, rules, usual }
    }

    /// The density of a colour, in one over the mesh's unit.
    pub(super) fn density(&self, colour: LinearRgba) -> f32 {
        let alpha = colour[3];
        if alpha <= 0.0 {
            return 0.0;
        }
        let lab = oklab(colour);
        let mut density = self.density;
        for rule in &self.rules {
            let far = (0..3).map(|n| (lab[n] - rule.lab[n]).powi(2)).sum::<f32>().sqrt() / rule.within;
            density += (1.0 - smooth(2.0 * far - 1.0)) * (rule.density - density);
        }
        if let Some(usual) = &self.usual {
            density *= smooth((stands_out(lab) - usual.mean) / (DENSE * usual.spread));
        }
        density * alpha
    }

    /// The greatest density that there may be, in one over the mesh's unit.
    pub(super) fn most(&self) -> f32 {
        self.rules.iter().map(|r| r.density).fold(self.density, f32::max)
    }
}

impl Usual {
    /// Of the solid textures; `None` where nothing stands out.
    fn of<'a>(solids: impl Iterator<Item = &'a LappedSolid>) -> Option<Self> {
        // Pieces of one model share their textures: each counts once.
        let mut textures: Vec<&crate::volume::SolidTexture> = Vec::new();
        for exemplar in solids.flat_map(|s| &s.exemplars) {
            if !textures.iter().any(|t| std::ptr::eq(*t, &raw const **exemplar) || **t == **exemplar) {
                textures.push(exemplar);
            }
        }
        let voxels: usize = textures.iter().map(|t| t.voxels().len()).sum();
        // An odd step, so that it runs through all columns.
        let step = (voxels / LOOKED_AT) | 1;
        let (mut weight, mut sum, mut squares) = (0.0f64, 0.0f64, 0.0f64);
        for voxel in textures.iter().flat_map(|t| t.voxels().iter().step_by(step)) {
            let (w, x) = (f64::from(voxel[3]), f64::from(stands_out(oklab(decode(*voxel)))));
            weight += w;
            sum += w * x;
            squares += w * x * x;
        }
        let mean = sum / weight;
        let spread = (squares / weight - mean * mean).max(0.0).sqrt();
        #[allow(clippy::cast_possible_truncation)] // about 0 to 1
        let usual = Self { mean: mean as f32, spread: spread as f32 };
        (usual.spread >= PLAIN).then_some(usual)
    }
}

/// How dark and how colourful a colour is.
fn stands_out([l, a, b]: [f32; 3]) -> f32 {
    a.hypot(b) - l
}

/// From 0 at 0 to 1 at 1, without a corner.
fn smooth(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

#[cfg(test)]
mod tests {
    use super::super::DensityRule;
    use super::*;
    use crate::render::testing;

    fn transfer(params: &TranslucentParams) -> Transfer {
        Transfer::new(params, std::iter::once(&testing::ball(1)), 2.0)
    }

    #[test]
    fn the_first_rule_that_holds_counts() {
        let colour = |text: &str| -> Colour { text.parse().unwrap() };
        let at = |t: &Transfer, text: &str| t.density(decode(colour(text).0));
        let params = TranslucentParams {
            density: 10.0,
            clear: vec![Colour::WHITE, colour("red")],
            rule: vec![DensityRule { colour: colour("red"), within: 0.1, density: 80.0 }],
            ..Default::default()
        };
        let t = transfer(&params);
        assert_eq!(at(&t, "red"), 40.0);
        assert_eq!(at(&t, "white"), 0.0);
        assert_eq!(at(&t, "blue"), 5.0);
        assert_eq!(at(&t, "#ff000080"), 40.0 * 128.0 / 255.0);
        assert_eq!(at(&t, "#ff000000"), 0.0);
        assert_eq!(t.most(), 40.0);
        // From a colour to what is far from it, density never jumps.
        let grey = |x: f32| t.density([x, x, x, 1.0]);
        let all: Vec<f32> = (0..=1000).map(|i| grey(i as f32 / 1000.0)).collect();
        assert!(all.windows(2).all(|w| w[1] <= w[0] + 1e-6 && w[0] - w[1] < 0.1));
    }

    #[test]
    fn without_rules_the_dark_and_the_colourful_are_dense() {
        let t = transfer(&TranslucentParams::default());
        let [dark, pale, red] =
            [[0.03, 0.03, 0.03, 1.0], [0.8, 0.8, 0.8, 1.0], [0.8, 0.03, 0.03, 1.0]].map(|c| t.density(c));
        assert!(pale < 0.2 * dark && red > 2.0 * pale, "{dark} {pale} {red}");
    }
}
