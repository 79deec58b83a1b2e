//! Levels.

use crate::kit::curve::bias;
use crate::kit::rows::map;
use crate::kit::sample::finite;
use crate::prelude::*;

/// Brings a range of values into another: levels.
///
/// `t = (x − low) / (high − low)`, bent so that `midpoint` becomes 1/2 \[schlick1994\], gives
/// `field = out_low + t · (out_high − out_low)`. Either range may run downwards.
///
/// What comes out within 0 and 1 is a mask. A mask brought into another range becomes an elevation; every other
/// field keeps its quantity.
///
/// # Limits
/// Without `clamp`, values beyond the input range go on straight, as steep as the end of the range.
///
/// # See also
/// `curve` for a transfer of any form, `equalize` for one that follows the histogram.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Remap {
    /// The range that is brought to the output range.
    pub input: InputRange,
    /// The share of the input range that comes out in the middle of the output range: below 1/2 lifts, above lowers.
    #[schemars(range(min = 0.01, max = 0.99))]
    pub midpoint: Ratio,
    /// What the low end of the input range becomes.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [0.0, 1000.0]))]
    pub out_low: Number,
    /// What the high end of the input range becomes.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [0.0, 1000.0]))]
    pub out_high: Number,
    /// Whether values beyond the input range stop at the ends of the output range.
    pub clamp: bool,
}

/// Where a range of input values comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum InputRange {
    /// From the lowest to the highest value of the whole terrain, on the base grid.
    Auto {
        /// Share of the terrain left out at either end, against single spikes.
        #[schemars(range(min = 0.0, max = 0.45), extend("x-soft" = [0.0, 0.05]))]
        clip: Ratio,
    },
    /// From one value to another.
    Fixed {
        /// Low end, in the unit of the field.
        #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [0.0, 1000.0]))]
        low: Number,
        /// High end, in the unit of the field.
        #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [0.0, 1000.0]))]
        high: Number,
    },
}

impl InputRange {
    /// Low and high end.
    ///
    /// # Errors
    /// When it is automatic and the node asked for no summary.
    pub fn ends(self, cx: &Context<'_>) -> Result<[f64; 2]> {
        match self {
            Self::Auto { .. } => cx.summary_range(),
            Self::Fixed { low, high } => Ok([low.0, high.0]),
        }
    }
}

impl Default for InputRange {
    fn default() -> Self {
        Self::Auto { clip: Ratio(0.0) }
    }
}

impl Default for Remap {
    fn default() -> Self {
        Self {
            input: InputRange::default(),
            midpoint: Ratio(0.5),
            out_low: Number(0.0),
            out_high: Number(1.0),
            clamp: true,
        }
    }
}

ports! {
    pub struct Inputs {
        /// Field to bring into another range.
        field: Field,
    }
    pub struct Outputs {
        /// Field in the output range.
        field: Field = Meaning::Chosen,
    }
}

impl Node for Remap {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().cite(&["schlick1994"]).mixes(&[("field", "field")]).keywords(&[
        "levels",
        "range",
        "normalize",
        "scale",
        "gamma",
        "autolevel",
        "contrast",
    ]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost::per_sample(grid, 4.0)
    }

    fn summary(&self) -> Option<fn(&Self, &Context<'_>, &Inputs) -> Result<Summary>> {
        match self.input {
            InputRange::Auto { .. } => Some(|node, cx, input| {
                let InputRange::Auto { clip } = node.input else { return Ok(Summary([].into())) };
                cx.range_summary(&input.field, clip.0)
            }),
            InputRange::Fixed { .. } => None,
        }
    }

    fn quantity(&self, _: &str, inputs: Quantities<'_>) -> Quantity {
        self.quantity_of(inputs("field").unwrap_or(Quantity::Number))
    }

    fn run(&self, cx: &Context<'_>, Inputs { field }: Inputs) -> Result<Outputs> {
        let [low, high] = self.input.ends(cx)?;
        let (from, to) = (self.out_low.0, self.out_high.0);
        let quantity = self.quantity_of(field.quantity());
        let (middle, clamp) = (1.0 - self.midpoint.0, self.clamp);
        let field = if high == low {
            // A range without width is a step.
            map(&cx.work, &cx.grid, &field, quantity, |x| {
                if f64::from(x) < low { from as f32 } else { to as f32 }
            })
        } else {
            let scale = 1.0 / (high - low);
            map(&cx.work, &cx.grid, &field, quantity, |x| {
                let t = (f64::from(x) - low) * scale;
                let t = if clamp { t.clamp(0.0, 1.0) } else { t };
                finite((from + bent(t, middle) * (to - from)) as f32)
            })
        };
        Ok(Outputs { field: field? })
    }
}

impl Remap {
    fn quantity_of(&self, input: Quantity) -> Quantity {
        let unit = 0.0..=1.0;
        let within = self.clamp && unit.contains(&self.out_low.0) && unit.contains(&self.out_high.0);
        match input {
            _ if within => Quantity::Mask,
            Quantity::Mask => Quantity::Elevation,
            other => other,
        }
    }
}

/// [`bias`], going on straight before 0 and after 1.
fn bent(t: f64, middle: f64) -> f64 {
    let steep = 1.0 / middle - 1.0;
    if t < 0.0 {
        t / steep
    } else if t > 1.0 {
        1.0 + (t - 1.0) * steep
    } else {
        bias(t, middle)
    }
}
