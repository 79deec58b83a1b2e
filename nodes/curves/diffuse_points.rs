//! From known samples to a whole field.

use crate::kit::diffusion::{self, Problem, Quality, solve};
use crate::prelude::*;

/// Fills a field from the samples where it is known: a membrane that hangs from them and is as smooth as can be.
///
/// Solves Laplace's equation with a level border, by the solver of `diffuse`, to an error of a hundred-thousandth of
/// the range of the known values. No value leaves that range, and known samples stay as they are, to the bit.
///
/// # Limits
/// It runs on the base grid. Single points pull the membrane to a sharp tip; give them some width with `expand`.
/// Without any known sample the field is 0.
///
/// # See also
/// `import_height` fills the voids of a file by itself.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DiffusePoints {
    /// Lowest value of the mask at which a sample counts as known.
    pub threshold: Ratio,
}

impl Default for DiffusePoints {
    fn default() -> Self {
        Self { threshold: Ratio(0.5) }
    }
}

ports! {
    pub struct Inputs {
        /// Field whose values count where they are known.
        field: Field,
        /// Where they are known.
        known: Field,
    }
    pub struct Outputs {
        /// The whole field.
        field: Field,
    }
}

impl Node for DiffusePoints {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().keywords(&[
        "interpolate",
        "laplace",
        "inpaint",
        "fill",
        "membrane",
        "voids",
        "sparse",
        "scatter",
    ]);

    fn reach(&self) -> Reach {
        Reach::Global
    }

    fn cost(&self, grid: &Grid) -> Cost {
        let cost = Cost::per_sample(grid, 300.0).with_fields(grid, 24.0);
        Cost { bytes: cost.bytes + diffusion::scratch(), ..cost }
    }

    fn run(&self, cx: &Context<'_>, Inputs { field, known }: Inputs) -> Result<Outputs> {
        let (field, known) = (field.crop(&cx.grid), known.crop(&cx.grid));
        let threshold = self.threshold.0 as f32;
        let fixed = cx.map(&known, Quantity::Mask, |k: f32| f32::from(u8::from(k >= threshold)))?;
        let problem = Problem {
            cols: cx.grid.cols,
            rows: cx.grid.rows,
            fixed: fixed.data(),
            target: field.data(),
            guidance: None,
            source: None,
        };
        match solve(&problem, Quality::CONVERGED, cx) {
            Ok(solution) => Ok(Outputs { field: Field::new(cx.grid, field.quantity(), solution.field) }),
            Err(diffusion::Error::Cancelled) => Err(Error::Cancelled),
            Err(misfit) => Err(Error::Input { port: "field", message: misfit.to_string() }),
        }
    }
}
