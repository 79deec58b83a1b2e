//! Limits.

use crate::kit::rows::map;
use crate::prelude::*;

/// Keeps values between two limits.
///
/// With a knee the limit is reached along a parabola that starts `knee` before it and ends `knee` after it, so that no
/// edge shows; without, values stop at the limit.
///
/// # See also
/// `remap` stretches what is between two limits.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Clamp {
    /// Lowest value, in the unit of the field.
    #[schemars(range(min = -1.0e9, max = 1.0e9), extend("x-soft" = [0.0, 1000.0]))]
    pub low: Number,
    /// Highest value, in the unit of the field.
    #[schemars(range(min = -1.0e9, max = 1.0e9), extend("x-soft" = [0.0, 1000.0]))]
    pub high: Number,
    /// How far before a limit values begin to bend, in the unit of the field; at most half the way between the limits.
    #[schemars(range(min = 0.0, max = 1.0e6), extend("x-soft" = [0.0, 100.0]))]
    pub knee: Number,
}

impl Default for Clamp {
    fn default() -> Self {
        Self { low: Number(0.0), high: Number(1000.0), knee: Number(0.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Field to limit.
        field: Field,
    }
    pub struct Outputs {
        /// Limited field, in the unit of the input.
        field: Field = Meaning::like("field"),
    }
}

impl Node for Clamp {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().mixes(&[("field", "field")]).keywords(&[
        "limit",
        "minimum",
        "maximum",
        "cut",
        "flatten",
        "soft clip",
    ]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn check(&self) -> Result<()> {
        if self.low.0 <= self.high.0 {
            return Ok(());
        }
        let message = format!("must be at most `high`, {}, got {}", self.high.0, self.low.0);
        Err(Error::Parameter { name: "low".into(), message })
    }

    fn run(&self, cx: &Context<'_>, Inputs { field }: Inputs) -> Result<Outputs> {
        self.check()?;
        let (low, high) = (self.low.0, self.high.0);
        let knee = self.knee.0.min(0.5 * (high - low));
        let (lowest, highest) = (low as f32, high as f32);
        let quantity = field.quantity();
        let field = if knee <= 0.0 {
            map(&cx.work, &cx.grid, &field, quantity, |x| x.max(lowest).min(highest))
        } else {
            map(&cx.work, &cx.grid, &field, quantity, |x| {
                let soft = high - raised(high - f64::from(x), knee);
                ((low + raised(soft - low, knee)) as f32).max(lowest).min(highest)
            })
        };
        Ok(Outputs { field: field? })
    }
}

/// The higher of `x` and 0, a parabola where `x` lies within `knee` of 0.
fn raised(x: f64, knee: f64) -> f64 {
    let near = (knee - x.abs()).max(0.0);
    x.max(0.0) + 0.25 * near * near / knee
}
