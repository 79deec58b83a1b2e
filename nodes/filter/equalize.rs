//! Histogram equalisation.

use crate::kit::curve::Monotone;
use crate::kit::rows::map;
use crate::kit::sample::fit;
use crate::kit::stats;
use crate::prelude::*;

/// Spreads values evenly over their range: every band of heights gets the same area.
///
/// A value becomes `low + (high − low) · F(x)`, where `F` is the share of the whole terrain that lies below it: read
/// on the base grid at the heights that cut its area into 128 equal parts, and joined by a curve that rises
/// everywhere \[fritsch1984\]. Values beyond the range of the base grid keep their distance from it.
///
/// # Limits
/// A flat field stays as it is. A flat part, such as a lake, keeps one value, and its shore grows steep.
///
/// # See also
/// `curve` for a transfer drawn by hand.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Equalize {
    /// How much of the change is taken; 0 changes nothing.
    pub strength: Ratio,
}

impl Default for Equalize {
    fn default() -> Self {
        Self { strength: Ratio(1.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Field to spread.
        field: Field,
    }
    pub struct Outputs {
        /// Spread field, in the range and unit of the input.
        field: Field = Meaning::like("field"),
    }
}

/// Bins of the histogram.
const BINS: usize = 1 << 14;
/// Parts of equal area between the points of the transfer.
const PARTS: usize = 128;
/// Least distance between points of the transfer, in bins: limits how steep it can grow over a flat part.
const APART: usize = 8;

impl Node for Equalize {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new().cite(&["fritsch1984"]).mixes(&[("field", "field")]).keywords(&[
        "histogram",
        "balance",
        "distribute",
        "contrast",
    ]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost { bytes: 1 << 14, ..Cost::per_sample(grid, 40.0) }
    }

    /// Lowest and highest value, then the points of the transfer: shares of the range, each with that of the area below.
    fn summary(&self) -> Option<fn(&Self, &Context<'_>, &Inputs) -> Result<Summary>> {
        (self.strength.0 > 0.0).then_some(|_, cx, input| {
            cx.check()?;
            let field = input.field.crop(&cx.grid);
            let range = stats::range(&field, 0.0);
            let points = transfer(&stats::histogram(&field, range, BINS));
            Ok(Summary(range.into_iter().chain(points.into_iter().flatten()).collect()))
        })
    }

    fn run(&self, cx: &Context<'_>, Inputs { field }: Inputs) -> Result<Outputs> {
        let quantity = field.quantity();
        let unchanged = |field: Field| Ok(Outputs { field: field.crop(&cx.grid) });
        if self.strength.0 == 0.0 {
            return unchanged(field);
        }
        let [low, high] = cx.summary_range()?;
        let points = cx.summary()?.0.get(2..).unwrap_or_default().as_chunks::<2>().0;
        let (Some(curve), true) = (Monotone::through(points), high > low) else { return unchanged(field) };
        let (width, strength) = (high - low, self.strength.0);
        let field = map(&cx.work, &cx.grid, &field, quantity, |x| {
            let t = (f64::from(x) - low) / width;
            let change = if (0.0..=1.0).contains(&t) { curve.at(t) - t } else { 0.0 };
            fit(quantity, (f64::from(x) + strength * width * change) as f32)
        })?;
        Ok(Outputs { field })
    }
}

/// Points of the transfer from (0, 0) to (1, 1), between parts of about equal area.
fn transfer(counts: &[u64]) -> Vec<[f64; 2]> {
    let total = counts.iter().sum::<u64>().max(1);
    let (mut below, mut last, mut points) = (0, 0, vec![[0.0, 0.0]]);
    for (i, n) in counts.iter().enumerate() {
        below += n;
        let (edge, parts) = (i + 1, below * PARTS as u64 / total);
        let before = points.last().map_or(0.0, |p| p[1]);
        let passed = parts > (before * PARTS as f64) as u64;
        if passed && edge >= last + APART && edge + APART <= counts.len() {
            points.push([edge as f64 / counts.len() as f64, below as f64 / total as f64]);
            last = edge;
        }
    }
    points.push([1.0, 1.0]);
    points
}
