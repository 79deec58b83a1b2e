//! From known samples to a whole field.

use crate::kit::diffusion::{self, Plate, Problem, Quality, bend, solve};
use crate::prelude::*;

/// Fills a field from the samples where it is known, as smoothly as can be: a membrane or a thin plate that meets them.
///
/// A membrane solves Laplace's equation, `Δu = 0`, with a level border, and no value leaves the range of the known
/// ones. A thin plate makes the bending `∫ u_xx² + 2 u_xy² + u_yy²` least, `ΔΔu = 0`, with a free border: slopes go on
/// through the known samples and beyond them, and values may leave the range \[szeliski1990\]. Both are solved to an
/// error of a hundred-thousandth of the range, and known samples stay as they are, to the bit.
///
/// Where `known` says weights `w`, from 0 to 1, a membrane solves `u = w · value + (1 − w) · mean of the four neighbours`: 1
/// holds a sample as it is, less draws the field towards it without making it bend there.
///
/// # Limits
/// It runs on the base grid. Single points pull a membrane to a sharp tip: give them some width with `expand`, or
/// bend a plate. Known samples on one straight line leave the tilt of a plate across it open: it then has none on the
/// whole, so two samples give an even slope from one to the other. One known sample gives a constant, none gives 0. A
/// plate takes about fifteen times as long as a membrane.
///
/// # See also
/// `import_height` fills the voids of a file by itself; `enrich` gives weights beside rivers and ridges.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DiffusePoints {
    /// What hangs from the known samples.
    pub surface: Surface,
    /// What the values of `known` say.
    pub known_as: KnownAs,
    /// Lowest value of a mask at which a sample counts as known; weights have none.
    pub threshold: Ratio,
}

/// What says how far samples are known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum KnownAs {
    /// A sample is known from the threshold on, and else not at all.
    #[default]
    Mask,
    /// How far each sample is known, from 0 to 1; of a membrane alone.
    Weights,
}

/// What hangs from known samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Surface {
    /// As short as can be: flat but for tips at the known samples, and never beyond their range.
    #[default]
    Membrane,
    /// As little bent as can be: round, and even slopes go on.
    ThinPlate,
}

impl Default for DiffusePoints {
    fn default() -> Self {
        Self { surface: Surface::default(), known_as: KnownAs::default(), threshold: Ratio(0.5) }
    }
}

ports! {
    pub struct Inputs {
        /// Field whose values count where they are known.
        field: Field,
        /// Where they are known, or how far.
        known: Field,
    }
    pub struct Outputs {
        /// The whole field.
        field: Field = Meaning::like("field"),
    }
}

impl Node for DiffusePoints {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().cite(&["szeliski1990"]).keywords(&[
        "interpolate",
        "laplace",
        "inpaint",
        "fill",
        "membrane",
        "thin plate",
        "spline",
        "voids",
        "sparse",
        "scatter",
    ]);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let (nanoseconds, fields) = match self.surface {
            Surface::Membrane => (300.0, 24.0),
            Surface::ThinPlate => (2500.0, 21.0),
        };
        let cost = Cost::per_sample(grid, nanoseconds).with_fields(grid, fields);
        Cost { bytes: cost.bytes + diffusion::scratch(), ..cost }
    }

    fn check(&self) -> Result<()> {
        if self.surface == Surface::ThinPlate && self.known_as == KnownAs::Weights {
            let message = "must be `mask` where the surface is a thin plate, got `weights`".into();
            return Err(Error::Parameter { name: "known_as".into(), message });
        }
        Ok(())
    }

    fn run(&self, cx: &Context<'_>, Inputs { field, known }: Inputs) -> Result<Outputs> {
        let (field, known) = (field.crop(&cx.grid), known.crop(&cx.grid));
        let threshold = self.threshold.0 as f32;
        let fixed = match self.known_as {
            KnownAs::Mask => cx.map(&known, Quantity::Mask, |k: f32| f32::from(u8::from(k >= threshold)))?,
            KnownAs::Weights => cx.map(&known, Quantity::Mask, |k: f32| k.clamp(0.0, 1.0))?,
        };
        let (cols, rows) = (cx.grid.cols, cx.grid.rows);
        let solution = match self.surface {
            Surface::Membrane => {
                let (fixed, target) = (fixed.data(), field.data());
                solve(
                    &Problem { cols, rows, fixed, target, guidance: None, source: None },
                    Quality::CONVERGED,
                    &cx.work,
                )
            }
            Surface::ThinPlate => {
                let plate = Plate { cols, rows, known: fixed.data(), value: field.data() };
                bend(&plate, Plate::TOLERANCE, Plate::CYCLES, &cx.work)
            }
        };
        match solution {
            Ok(solution) => Ok(Outputs { field: Field::new(cx.grid, field.quantity(), solution.field) }),
            Err(diffusion::Error::Cancelled) => Err(Error::Cancelled),
            Err(misfit) => Err(Error::Input { port: "field".into(), message: misfit.to_string() }),
        }
    }
}
