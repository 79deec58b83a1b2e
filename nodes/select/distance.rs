//! The distance to a mask.

use crate::kit::distance;
use crate::kit::math::smooth;
use crate::prelude::*;

/// Measures how far each place is from a mask, in metres.
///
/// A sample belongs to the mask where its value is at least `threshold`; the distance is the exact Euclidean one to
/// the nearest such sample, found by two passes over whole numbers \[meijster2000\]. Beyond `limit` it stays at the
/// limit, which makes the result local: a tile of it equals the whole.
///
/// # Limits
/// Distances are between samples, so that edges are as exact as the cell; the time grows with the limit only as far
/// as the window around a tile does.
/// The mask is what the build's samples say: a finer build of a rough mask has smaller patches and holes, and more of
/// them, so that the distance to the nearest is a matter of the size. A mask without detail near the cell, such as one
/// blurred over some base cells before it is selected, has the same distances at every size but for a cell.
///
/// # See also
/// `expand` for a wider mask, `curve` and `remap` to shape the distance.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Distance {
    /// Value from which on a sample belongs to the mask.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub threshold: Ratio,
    /// Distance from which on nothing is measured.
    #[schemars(range(min = 0.1, max = 50_000.0), extend("x-soft" = [10.0, 2000.0], "x-log" = true))]
    pub limit: Metres,
    /// Where to measure.
    pub side: Side,
    /// How the second output falls off.
    pub shape: Shape,
}

/// On which side of the edge to measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// Outside, to the mask; 0 in it.
    #[default]
    Outside,
    /// Inside, to where the mask ends; 0 outside.
    Inside,
    /// Both, negative inside, and to the edge half a cell before the nearest sample of the other side.
    Signed,
}

/// How the falloff passes from 1 to 0 over the limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// In a straight line.
    Linear,
    /// Gently at both ends, as `1 − 3u² + 2u³`.
    #[default]
    Smooth,
    /// Fast first, as `(1 − u)²`.
    Concave,
    /// Slowly first, as `1 − u²`.
    Convex,
}

impl Default for Distance {
    fn default() -> Self {
        Self { threshold: Ratio(0.5), limit: Metres(500.0), side: Side::Outside, shape: Shape::Smooth }
    }
}

ports! {
    pub struct Inputs {
        /// Mask to measure from.
        mask: Field,
    }
    pub struct Outputs {
        /// Distance in metres, up to the limit.
        field: Field = Meaning::Fixed(Quantity::Length),
        /// 1 where the distance is 0 (signed: the limit inside), falling to 0 at the limit.
        falloff: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for Distance {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta =
        Meta::new().cite(&["meijster2000"]).keywords(&["proximity", "buffer", "falloff", "offset", "sdf"]);

    fn reach(&self) -> Reach {
        Reach::local(self.limit.0)
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let sweeps = if self.side == Side::Signed { 2.0 } else { 1.0 };
        let around = 1.0 + 2.0 * self.limit.0 / grid.cell() / grid.cols.min(grid.rows).max(1) as f64;
        let mut cost = Cost::per_sample(grid, 3.0 + 50.0 * around * sweeps);
        cost.bytes = distance::scratch(grid, self.limit.0);
        if self.side == Side::Signed { cost.with_fields(grid, 2.0) } else { cost }
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let (limit, threshold) = (self.limit.0, self.threshold.0 as f32);
        let measure = |cx: &Context<'_>, side: Side| match side {
            Side::Inside => distance::to_set(&cx.work, &input.mask, &cx.grid, limit, |m| m < threshold),
            _ => distance::to_set(&cx.work, &input.mask, &cx.grid, limit, |m| m >= threshold),
        };
        let (most, limit) = (cx.stage(0.0, 0.9), limit as f32);
        let field = match self.side {
            Side::Outside | Side::Inside => measure(&most, self.side)?,
            Side::Signed => {
                let outside = measure(&most.stage(0.0, 0.45), Side::Outside)?;
                let inside = measure(&most.stage(0.45, 0.9), Side::Inside)?;
                let half = (0.5 * cx.grid.cell()) as f32;
                // One of the two is 0; the other is a cell at least, or the limit.
                let signed = |out: f32, inn: f32| {
                    let edge = |d: f32| if d < limit { (d - half).max(0.0) } else { limit };
                    if out > 0.0 { edge(out) } else { -edge(inn) }
                };
                most.stage(0.9, 1.0).fill(Quantity::Length, |row, out| {
                    let sides = outside.row(row.j).iter().zip(inside.row(row.j));
                    for (o, (&out, &inn)) in out.iter_mut().zip(sides) {
                        *o = signed(out, inn);
                    }
                })?
            }
        };
        let share = |d: f32| match self.side {
            Side::Signed => 0.5 + 0.5 * (d / limit),
            _ => d / limit,
        };
        let falloff =
            cx.stage(0.9, 1.0).map(&field, Quantity::Mask, |d| fall(self.shape, share(d).clamp(0.0, 1.0)))?;
        Ok(Outputs { field, falloff })
    }
}

fn fall(shape: Shape, u: f32) -> f32 {
    match shape {
        Shape::Linear => 1.0 - u,
        Shape::Smooth => 1.0 - smooth(u),
        Shape::Concave => (1.0 - u) * (1.0 - u),
        Shape::Convex => 1.0 - u * u,
    }
}
