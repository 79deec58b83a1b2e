//! Perlin noise over octaves.

use crate::kit::noise::{self, Fractal, Spectrum};
use crate::prelude::*;

/// Sums octaves of Perlin noise into hills, ridges or mountains.
///
/// Octave `k` has features of `feature_size / lacunarity^k` and the weight `gain^k`, divided by the sum of all
/// weights. Each has a lattice of its own, turned and shifted by hash, so that none shows \[perlin2002\]; the forms
/// are those of Musgrave \[ebert2003\]. A rule of thumb: a gain of `lacunarity^-H` gives a surface of roughness `H`, 1
/// smooth, 0.5 rough; real relief has 0.7 to 0.9.
///
/// # Differs from the paper
/// `ridged` and `hybrid` carry their factor from octave to octave before weighting, so that a low gain does not
/// smother it, and cut it to 0 to 1.
///
/// # Limits
/// Octaves finer than the cell of the grid are computed all the same: leaving them out would give another terrain at
/// another size. Keep the finest feature above a cell of the build where aliasing matters.
///
/// # See also
/// `multifractal` varies amplitude and roughness by fields; `cellular_noise` makes cells and cones.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FractalNoise {
    /// How the octaves add up.
    pub form: Form,
    /// Size of the largest features: the cell of the first octave.
    #[schemars(range(min = 0.1, max = 1.0e6), extend("x-soft" = [50.0, 10_000.0], "x-log" = true))]
    pub feature_size: Metres,
    /// Number of octaves.
    #[schemars(range(min = 1, max = 16), extend("x-unit" = "1"))]
    pub octaves: u32,
    /// How much finer each octave is than the one before.
    #[schemars(range(min = 1.5, max = 4.0))]
    pub lacunarity: Number,
    /// How much weaker each octave is than the one before.
    pub gain: Ratio,
    /// Height of one part: `fbm` lies within this above and below `offset`, and two thirds of it within a fifth of
    /// this; the other forms rise from about `offset` to this above it.
    #[schemars(range(min = -20_000.0, max = 20_000.0), extend("x-soft" = [0.0, 2000.0]))]
    pub amplitude: Metres,
    /// Height that the noise is added to.
    #[schemars(range(min = -20_000.0, max = 20_000.0), extend("x-soft" = [-1000.0, 1000.0]))]
    pub offset: Metres,
    /// Chooses another noise of the same kind.
    pub seed: Seed,
}

/// How the octaves of a fractal noise add up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Form {
    /// Plain sum: rolling ground, valleys like tops; −1 to 1 parts.
    #[default]
    Fbm,
    /// Sum of absolute values: round tops and creased valleys; 0 to 1 parts.
    Billow {
        /// 1 leaves a crease in the valleys, less rounds it.
        #[serde(default = "sharp")]
        sharpness: Ratio,
    },
    /// Sharp crests on which finer crests gather; 0 to 1 parts.
    Ridged {
        /// 1 leaves a crease on the crests, less rounds it.
        #[serde(default = "sharp")]
        sharpness: Ratio,
        /// How far fine crests spread from coarse ones: 1 keeps them on the very crest, 4 lets them nearly anywhere.
        #[serde(default = "focus")]
        #[schemars(range(min = 0.0, max = 8.0), extend("x-soft" = [1.0, 4.0]))]
        focus: Number,
    },
    /// Rough heights above smooth valleys; about 0 to 1 parts, valleys to −(1 − base) / (1 + base).
    Hybrid {
        /// How much of the land has detail: 0 only the tops, 1 nearly all.
        #[serde(default = "base")]
        base: Ratio,
    },
}

fn sharp() -> Ratio {
    Ratio(1.0)
}

fn focus() -> Number {
    Number(2.0)
}

fn base() -> Ratio {
    Ratio(0.7)
}

impl From<Form> for noise::Form {
    fn from(form: Form) -> Self {
        match form {
            Form::Fbm => Self::Fbm,
            Form::Billow { sharpness } => Self::Billow { sharpness: sharpness.0 as f32 },
            Form::Ridged { sharpness, focus } => {
                Self::Ridged { sharpness: sharpness.0 as f32, focus: focus.0 as f32 }
            }
            Form::Hybrid { base } => Self::Hybrid { base: base.0 as f32 },
        }
    }
}

impl Default for FractalNoise {
    fn default() -> Self {
        Self {
            form: Form::Fbm,
            feature_size: Metres(2000.0),
            octaves: 8,
            lacunarity: Number(2.0),
            gain: Ratio(0.5),
            amplitude: Metres(600.0),
            offset: Metres(0.0),
            seed: Seed(0),
        }
    }
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// Height, in metres.
        field: Field = Meaning::Fixed(Quantity::Elevation),
    }
}

impl Node for FractalNoise {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["perlin2002", "ebert2003"])
        .keywords(&["perlin", "fbm", "billow", "ridged", "ridge", "hybrid", "mountain", "hills", "octaves"])
        .reads(Reads::SEED);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let bytes = Fractal::bytes(self.octaves, grid.cols) + 8 * grid.cols as u64;
        Cost { bytes, ..Cost::per_sample(grid, 1.0 + 4.0 * f64::from(self.octaves)) }
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        let spectrum = Spectrum {
            feature_size: self.feature_size.0,
            octaves: self.octaves,
            lacunarity: self.lacunarity.0,
            gain: self.gain.0,
        };
        let seed = cx.seed(self.seed)?;
        let noise = Fractal::new(self.form.into(), spectrum, seed, self.offset.0, self.amplitude.0);
        let rows = noise.over(&cx.grid.xs());
        Ok(Outputs { field: cx.fill(Quantity::Elevation, |row, out| rows.row(row.y, out))? })
    }
}
