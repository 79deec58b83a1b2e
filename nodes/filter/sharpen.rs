//! Unsharp masking.

use crate::kit::blur;
use crate::kit::rows::zip;
use crate::kit::sample::fit;
use crate::prelude::*;

/// Brings out detail: adds to a field what a Gaussian takes from it.
///
/// `field = x + amount · d`, where `d = x − blur(x)`, shortened by `threshold` towards zero. A small radius sharpens
/// ridges, a large one raises mountains over their surroundings.
///
/// # See also
/// `blur`, with the same radius.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Sharpen {
    /// Standard deviation of the Gaussian: detail of about this size comes out.
    #[schemars(range(min = 0.0, max = 10_000.0), extend("x-soft" = [0.0, 500.0]))]
    pub radius: Metres,
    /// How much of the detail is added; 0 changes nothing.
    #[schemars(range(min = 0.0, max = 20.0), extend("x-soft" = [0.0, 3.0]))]
    pub amount: Number,
    /// Detail lower than this stays as it is, in the unit of the field.
    #[schemars(range(min = 0.0, max = 1.0e6), extend("x-soft" = [0.0, 20.0]))]
    pub threshold: Number,
}

impl Default for Sharpen {
    fn default() -> Self {
        Self { radius: Metres(40.0), amount: Number(0.6), threshold: Number(0.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Field to sharpen.
        field: Field,
    }
    pub struct Outputs {
        /// Sharpened field, in the unit of the input.
        field: Field = Meaning::like("field"),
    }
}

impl Node for Sharpen {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta =
        Meta::new().mixes(&[("field", "field")]).keywords(&["unsharp", "detail", "contrast", "enhance"]);

    fn reach(&self) -> Reach {
        Reach::local(self.radius.0 * 5.0)
    }

    fn footprint(&self, _: &str, window: &Grid, _: &Terrain) -> Grid {
        blur::footprint(*window, self.radius.0)
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let bytes = blur::scratch(grid, self.radius.0);
        let blurring = Cost { bytes, ..Cost::per_sample(grid, 2.0 + blur::nanoseconds(grid, self.radius.0)) };
        blurring.with_fields(grid, 1.0)
    }

    fn run(&self, cx: &Context<'_>, Inputs { field }: Inputs) -> Result<Outputs> {
        let (amount, threshold) = (self.amount.0 as f32, self.threshold.0 as f32);
        if amount == 0.0 {
            return Ok(Outputs { field: field.crop(&cx.grid) });
        }
        let smooth = blur::gaussian(&cx.work.stage(0.0, 0.8), &field, cx.grid, self.radius.0)?;
        let quantity = field.quantity();
        let field = zip(&cx.work.stage(0.8, 1.0), &cx.grid, [&field, &smooth], quantity, |x, s| {
            let d = x - s;
            let kept = (d.abs() - threshold).max(0.0).copysign(d);
            fit(quantity, x + amount * kept)
        })?;
        Ok(Outputs { field })
    }
}
