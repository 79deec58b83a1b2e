//! Fractal noise whose amplitude and roughness vary from place to place.

use crate::kit::noise::{Form, Fractal, Spectrum};
use crate::prelude::*;

/// Makes fractal noise whose amplitude and roughness vary from place to place.
///
/// `N = A Σ r^(−k (1 − R)) S_k` over the octaves `k` from 0, with amplitude `A` in metres, roughness `R` from 0 to 1,
/// lacunarity `r` and Perlin noise `S_k` from −1 to 1 with features of `feature_size / r^k` [hnaidi2010, section
/// 4.3]. Roughness does not change the octaves, only their shares, so a varying `R` leaves no rings: at 1 all are
/// equally strong, at 0 each is `r` times weaker than the one before.
///
/// # Differs from the paper
/// Each octave has a lattice of its own, turned and shifted by hash, so that none shows; there may be more than four.
///
/// # Limits
/// The sum is not divided by its weights, as in the paper: at roughness 1 heights reach the number of octaves times
/// the amplitude. One octave stays within the amplitude, with a standard deviation of 0.3 of it. Octaves finer than
/// the cell of the grid are computed all the same.
///
/// # See also
/// `fractal_noise` has one amplitude and more forms.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Multifractal {
    /// Size of the largest features: the cell of the first octave.
    #[schemars(range(min = 0.1, max = 1.0e6), extend("x-soft" = [50.0, 10_000.0], "x-log" = true))]
    pub feature_size: Metres,
    /// Number of octaves; the paper has 4.
    #[schemars(range(min = 1, max = 16), extend("x-unit" = "1"))]
    pub octaves: u32,
    /// How much finer each octave is than the one before; the paper has 2.
    #[schemars(range(min = 1.5, max = 4.0))]
    pub lacunarity: Number,
    /// Height that the first octave reaches; the input of this name replaces it.
    #[schemars(range(min = -20_000.0, max = 20_000.0), extend("x-soft" = [0.0, 1000.0]))]
    pub amplitude: Metres,
    /// How strong fine octaves are; the input of this name replaces it.
    pub roughness: Ratio,
    /// Chooses another noise of the same kind.
    pub seed: Seed,
}

impl Default for Multifractal {
    fn default() -> Self {
        Self {
            feature_size: Metres(500.0),
            octaves: 4,
            lacunarity: Number(2.0),
            amplitude: Metres(100.0),
            roughness: Ratio(0.5),
            seed: Seed(0),
        }
    }
}

ports! {
    pub struct Inputs {
        /// Amplitude on each point, in metres; replaces the parameter.
        amplitude: Option<Field>,
        /// Roughness on each point, cut to 0 to 1; replaces the parameter.
        roughness: Option<Field>,
    }
    pub struct Outputs {
        /// Height of the noise, in metres, around 0.
        field: Field = Meaning::Fixed(Quantity::Elevation),
    }
}

impl Node for Multifractal {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["hnaidi2010", "perlin2002"])
        .keywords(&["noise", "fractal", "roughness", "detail", "perlin", "fbm"])
        .reads(Reads::SEED);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let bytes = Fractal::bytes(self.octaves, grid.cols) + 8 * grid.cols as u64;
        Cost { bytes, ..Cost::per_sample(grid, 3.0 + 4.0 * f64::from(self.octaves)) }
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let spectrum = Spectrum {
            feature_size: self.feature_size.0,
            octaves: self.octaves,
            lacunarity: self.lacunarity.0,
            gain: 1.0,
        };
        let noise = Fractal::new(Form::Rough, spectrum, cx.seed(self.seed)?, 0.0, 1.0);
        let rows = noise.over(&cx.grid.xs());
        let amplitude = input.amplitude.map(|f| f.crop(&cx.grid));
        let roughness = input.roughness.map(|f| f.crop(&cx.grid));
        let (height, constant) = (self.amplitude.0 as f32, [self.roughness.0 as f32]);
        let field = cx.fill(Quantity::Elevation, |row, out| {
            let roughness = roughness.as_ref().map_or(constant.as_slice(), |f| f.row(row.j));
            rows.rough_row(row.y, roughness, out);
            match &amplitude {
                Some(amplitude) => {
                    out.iter_mut().zip(amplitude.row(row.j)).for_each(|(o, a)| *o = scale(*o, *a))
                }
                None => out.iter_mut().for_each(|o| *o = scale(*o, height)),
            }
        })?;
        Ok(Outputs { field })
    }
}

/// The product, kept finite whatever the amplitude.
fn scale(noise: f32, amplitude: f32) -> f32 {
    (noise * amplitude).clamp(-f32::MAX, f32::MAX)
}
