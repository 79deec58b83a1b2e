//! Histogram equalisation.

use crate::kit::curve::Monotone;
use crate::kit::rows::map;
use crate::kit::sample::fit;
use crate::kit::stats;
use crate::prelude::*;

/// Spreads values evenly over their range: every band of heights gets the same area.
///
/// A value becomes `low + (high − low) · F(x)`, where `F` is the share of the whole terrain that lies below it, from
/// a histogram of 256 bins on the base grid, smoothed a little, and joined by a curve that rises everywhere
/// [fritsch1984]. Values beyond the range of the base grid keep their distance from it.
///
/// # Limits
/// A flat field stays as it is. A flat part, such as a lake, keeps one value, and leaves a gap beside it.
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
        field: Field,
    }
}

const BINS: usize = 256;

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

    fn cost(&self, grid: &Grid) -> Cost {
        Cost { bytes: 1 << 14, ..Cost::per_sample(grid, 25.0) }
    }

    /// Lowest and highest value, then the share below each of the edges between bins.
    fn summary(&self) -> Option<fn(&Self, &Context<'_>, &Inputs) -> Result<Summary>> {
        (self.strength.0 > 0.0).then_some(|_, cx, input| {
            cx.check()?;
            let field = input.field.crop(&cx.grid);
            let range = stats::range(&field, 0.0);
            let shares = shares(&stats::histogram(&field, range, BINS));
            Ok(Summary(range.into_iter().chain(shares).collect()))
        })
    }

    fn run(&self, cx: &Context<'_>, Inputs { field }: Inputs) -> Result<Outputs> {
        let quantity = field.quantity();
        let unchanged = |field: Field| Ok(Outputs { field: field.crop(&cx.grid) });
        if self.strength.0 == 0.0 {
            return unchanged(field);
        }
        let [low, high] = stats::summary_range(cx)?;
        let edges = cx.summary()?.0.iter().skip(2).enumerate();
        let points: Vec<_> = edges.map(|(i, &share)| [i as f64 / BINS as f64, share]).collect();
        let (Some(curve), true) = (Monotone::through(&points), high > low) else { return unchanged(field) };
        let (width, strength) = (high - low, self.strength.0);
        let field = map(cx, &field, quantity, |x| {
            let t = (f64::from(x) - low) / width;
            let change = if (0.0..=1.0).contains(&t) { curve.at(t) - t } else { 0.0 };
            fit(quantity, (f64::from(x) + strength * width * change) as f32)
        })?;
        Ok(Outputs { field })
    }
}

/// The share of samples below each bin edge, from 0 to 1, of counts that two passes of 1 2 1 have smoothed.
fn shares(counts: &[u64]) -> Vec<f64> {
    let smooth = |c: &[f64]| -> Vec<f64> {
        let at = |i: usize| c[i.min(c.len() - 1)];
        (0..c.len()).map(|i| 0.25 * at(i.saturating_sub(1)) + 0.5 * c[i] + 0.25 * at(i + 1)).collect()
    };
    let raw: Vec<f64> = counts.iter().map(|&n| n as f64).collect();
    let smoothed = smooth(&smooth(&raw));
    let total: f64 = smoothed.iter().sum();
    let mut below = 0.0;
    let mut shares = vec![0.0];
    shares.extend(smoothed.iter().map(|n| {
        below += n;
        (below / total.max(1.0)).min(1.0)
    }));
    shares
}
