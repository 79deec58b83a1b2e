//! Gaussian smoothing.

use crate::kit::blur;
use crate::prelude::*;

/// Smooths a field with a Gaussian.
///
/// Each value becomes the mean of its surroundings, weighted by `exp(−d² / 2 radius²)` with the distance `d`. Flat
/// parts stay flat, and heights that rise evenly stay as they are.
///
/// # Differs from the paper
/// Radii above six cells are taken on a lattice that is coarser by a power of two \[burt1983\], with cubic B-splines
/// on the way there and back; the result lies within 1e-4 of the field's range of the direct sum.
///
/// # Limits
/// A radius far below a cell does nothing.
///
/// # See also
/// `median` removes spikes and keeps edges, `sharpen` does the opposite.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Blur {
    /// Standard deviation of the Gaussian.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 500.0]))]
    pub radius: Metres,
}

impl Default for Blur {
    fn default() -> Self {
        Self { radius: Metres(50.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Field to smooth.
        field: Field,
    }
    pub struct Outputs {
        /// Smoothed field, in the unit of the input.
        field: Field = Meaning::like("field"),
    }
}

impl Node for Blur {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["burt1983"])
        .mixes(&[("field", "field")])
        .keywords(&["smooth", "gaussian", "soften"]);

    fn reach(&self) -> Reach {
        Reach::local(self.radius.0 * 5.0)
    }

    fn footprint(&self, _: &str, window: &Grid, _: &Terrain) -> Grid {
        blur::footprint(*window, self.radius.0)
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let bytes = blur::scratch(grid, self.radius.0);
        Cost { bytes, ..Cost::per_sample(grid, blur::nanoseconds(grid, self.radius.0)) }
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        Ok(Outputs { field: blur::gaussian(&cx.work, &input.field, cx.grid, self.radius.0)? })
    }
}
