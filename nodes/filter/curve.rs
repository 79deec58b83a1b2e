//! Transfer curve.

use super::remap::InputRange;
use crate::kit::curve::Monotone;
use crate::kit::rows::map;
use crate::kit::sample::fit;
use crate::prelude::*;

/// Shapes the values of a field by a curve through points.
///
/// With `t = (x − low) / (high − low)` and the curve `c`, the result is `low + c(t) · (high − low)`: the field keeps
/// its range and its unit. The curve is made of cubic pieces that are smooth where they meet and rise and fall only
/// where the points do \[fritsch1984\]. Beyond the first and the last point it goes on straight.
///
/// # See also
/// `remap` to change the range, `terrace` for steps.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Curve {
    /// Points from left to right, each a share of the range and what it becomes.
    #[schemars(length(min = 2, max = 32), extend("x-widget" = Widget::Curve, "x-items" = ["share", "becomes"]))]
    pub points: Vec<[Ratio; 2]>,
    /// The range of values that the curve stands over.
    pub input: InputRange,
}

impl Default for Curve {
    fn default() -> Self {
        let points = [[0.0, 0.0], [0.25, 0.15], [0.75, 0.85], [1.0, 1.0]];
        Self { points: points.map(|p| p.map(Ratio)).to_vec(), input: InputRange::default() }
    }
}

ports! {
    pub struct Inputs {
        /// Field to shape.
        field: Field,
    }
    pub struct Outputs {
        /// Shaped field, in the unit of the input.
        field: Field = Meaning::like("field"),
    }
}

impl Node for Curve {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().cite(&["fritsch1984"]).mixes(&[("field", "field")]).keywords(&[
        "transfer",
        "spline",
        "profile",
        "shape",
        "gradient editor",
    ]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost { bytes: 1 << 12, ..Cost::per_sample(grid, 20.0) }
    }

    fn check(&self) -> Result<()> {
        let bad = |message| Err(Error::Parameter { name: "points".into(), message });
        if self.points.len() < 2 {
            return bad(format!("must have at least 2 points, got {}", self.points.len()));
        }
        match self.points.windows(2).position(|w| w[1][0].0 - w[0][0].0 < CLOSEST) {
            Some(i) => bad(format!(
                "must go from left to right by at least {CLOSEST}, got {} after {} (points {} and {i})",
                self.points[i + 1][0].0,
                self.points[i][0].0,
                i + 1
            )),
            None => Ok(()),
        }
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

    fn run(&self, cx: &Context<'_>, Inputs { field }: Inputs) -> Result<Outputs> {
        self.check()?;
        let [low, high] = self.input.ends(cx)?;
        let points: Vec<_> = self.points.iter().map(|p| p.map(|r| r.0)).collect();
        let quantity = field.quantity();
        let (Some(curve), true) = (Monotone::through(&points), high != low) else {
            return Ok(Outputs { field: field.crop(&cx.grid) });
        };
        let width = high - low;
        let field = map(&cx.work, &cx.grid, &field, quantity, |x| {
            let t = (f64::from(x) - low) / width;
            // What the curve changes, so that a straight one changes nothing.
            fit(quantity, (f64::from(x) + width * (curve.at(t) - t)) as f32)
        })?;
        Ok(Outputs { field })
    }
}

/// Points nearer to each other than this would make a cliff that no f32 can hold.
const CLOSEST: f64 = 1e-6;
