//! Rivers and ridges on the base grid.

use crate::kit::land::{Feature, Line, Skeleton};
use crate::kit::noise::{Form, Fractal, Spectrum};
use crate::prelude::*;
use crate::value::{Ridges, Rivers};

/// Puts rivers and ridges on the base grid, as the heights that land is spread from.
///
/// Lines are drawn without gaps by Bresenham's rule \[bresenham1965\], and their heights run evenly from end to end. Where
/// several lines cross a sample, the lowest river wins, over any ridge, and of ridges the highest. Ridges get the noise of
/// \[zhang2016\] (5): Perlin noise over octaves, at most `amplitude` up and down. It never takes a ridge below a river in one
/// of the eight samples around it.
///
/// # Differs from the paper
/// The paper does not say what a sample has that several lines cross, and lets noise cut a ridge down to a river beside it.
///
/// # Limits
/// It runs on the base grid. Where rivers and ridges lie less than some 8 base cells apart, what comes out is texture.
///
/// # See also
/// `enrich` adds samples beside the lines, `diffuse_points` makes land of them, `carve_rivers` cuts the beds at last.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SkeletonRaster {
    /// Largest height of the noise on ridges, up and down.
    #[schemars(range(min = 0.0, max = 5000.0), extend("x-soft" = [0.0, 100.0]))]
    pub amplitude: Metres,
    /// Size of the largest features of the noise.
    #[schemars(range(min = 0.1, max = 1.0e6), extend("x-soft" = [50.0, 5000.0], "x-log" = true))]
    pub feature_size: Metres,
    /// Number of octaves, each half as large and half as high as the one before.
    #[schemars(range(min = 1, max = 16), extend("x-unit" = "1"))]
    pub octaves: u32,
    /// Chooses another noise of the same kind.
    pub seed: Seed,
}

impl Default for SkeletonRaster {
    fn default() -> Self {
        Self { amplitude: Metres(30.0), feature_size: Metres(400.0), octaves: 4, seed: Seed(0) }
    }
}

ports! {
    pub struct Inputs {
        /// Rivers with the heights of their beds.
        rivers: Rivers,
        /// Ridges between them.
        ridges: Option<Ridges>,
    }
    pub struct Outputs {
        /// Heights of rivers and ridges, in metres; 0 elsewhere.
        height: Field = Meaning::Fixed(Quantity::Elevation),
        /// Where there is either: 1, and 0 elsewhere.
        known: Field = Meaning::Fixed(Quantity::Mask),
        /// Where there is a river.
        river_mask: Field = Meaning::Fixed(Quantity::Mask),
        /// Where there is a ridge and no river.
        ridge_mask: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for SkeletonRaster {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["zhang2016", "bresenham1965"])
        .keywords(&["rasterize", "river", "ridge", "valley", "constraint", "bresenham"])
        .reads(Reads::SEED);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, load: &Load<'_>) -> Cost {
        let links = load.object::<Rivers>("rivers").map_or(0, |rivers| rivers.len());
        let edges = load.object::<Ridges>("ridges").map_or(0, |ridges| ridges.edges().len());
        // A byte for what crosses a sample, and the heights without noise; rows of noise for each thread.
        let cost = Cost::per_sample(&load.grid, 30.0).with_fields(&load.grid, 1.25);
        let threads = rayon::current_num_threads() as u64;
        let rows = threads * (Fractal::bytes(self.octaves, load.grid.cols) + 24 * load.grid.cols as u64);
        Cost { bytes: cost.bytes + rows, seconds: cost.seconds + (links + edges) as f64 * 2e-7 }
    }

    fn run(&self, cx: &Context<'_>, Inputs { rivers, ridges }: Inputs) -> Result<Outputs> {
        let ridges = ridges.unwrap_or_default();
        if rivers.is_empty() && ridges.is_empty() {
            cx.warn("there is no river and no ridge, so no height is known");
        }
        let mut skeleton = Skeleton::new(cx.grid);
        skeleton.rivers(&cx.work.stage(0.0, 0.3), rivers.links().map(|link| river(&rivers, link)))?;
        let edges = ridges.edges().iter().map(|edge| {
            let [a, b] = ridges.ends(edge);
            Line { ends: [a.at, b.at], heights: [a.height, b.height] }
        });
        skeleton.ridges(&cx.work.stage(0.3, 0.6), edges)?;
        let spectrum =
            Spectrum { feature_size: self.feature_size.0, octaves: self.octaves, lacunarity: 2.0, gain: 0.5 };
        let seed = cx.seed(self.seed)?;
        let noise = Fractal::new(Form::Fbm, spectrum, seed, 0.0, self.amplitude.0);
        skeleton.roughen(&cx.work.stage(0.6, 0.8), Some(&noise).filter(|_| self.amplitude.0 > 0.0))?;
        let cols = cx.grid.cols;
        let masked = |from: f32, is: fn(Feature) -> bool| {
            cx.stage(from, from + 0.06).fill(Quantity::Mask, |row, out: &mut [f32]| {
                let features = &skeleton.features[row.j * cols..];
                out.iter_mut().zip(features).for_each(|(o, &f)| *o = f32::from(u8::from(is(f))));
            })
        };
        Ok(Outputs {
            known: masked(0.8, |f| f != Feature::Open)?,
            river_mask: masked(0.86, |f| f == Feature::River)?,
            ridge_mask: masked(0.92, |f| f == Feature::Ridge)?,
            height: Field::new(cx.grid, Quantity::Elevation, skeleton.height),
        })
    }
}

/// A link, the lower end first.
pub(super) fn river(rivers: &Rivers, (upper, lower): (usize, usize)) -> Line {
    let [low, high] = [lower, upper].map(|vertex| rivers.vertices()[vertex]);
    Line { ends: [low.at, high.at], heights: [low.height, high.height] }
}
