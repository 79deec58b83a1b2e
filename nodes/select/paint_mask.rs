//! Masks painted by hand.

use crate::kit::paint::{Stroke, nanoseconds};
use crate::prelude::*;

/// Holds a mask that is painted with a brush.
///
/// Strokes lie one over the other in the order they were painted, each a line that a soft round brush follows. They are
/// kept as lines and not as a raster, so that a painted mask is as sharp at any size and takes little room in the graph.
/// The editor paints them onto the terrain; by hand a stroke is written `{ "path": [x, y, …], "radius": 300 }`.
///
/// # See also
/// `select_height` and its kin find places by rules; `combine` puts masks together.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PaintMask {
    /// The strokes, from the lowest to the uppermost.
    #[schemars(
        length(max = 10_000),
        extend(
            "x-widget" = Widget::Strokes,
            "examples" = [[
                { "path": [1500, 2000, 3000, 2400, 4200, 2100], "radius": 450 },
                { "path": [2800, 2300], "radius": 200, "softness": 1, "strength": 0.5, "value": 0 },
            ]],
        )
    )]
    pub strokes: Vec<Stroke>,
    /// Value where nothing is painted and no mask lies below.
    pub ground: Ratio,
}

ports! {
    pub struct Inputs {
        /// Mask that is painted over.
        below: Option<Field>,
    }
    pub struct Outputs {
        /// Painted mask, 0 to 1.
        mask: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for PaintMask {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta =
        Meta::new().keywords(&["brush", "draw", "stroke", "sketch", "hand", "mask", "airbrush"]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        let cost = Cost::per_sample(grid, 3.0);
        // Two rows of scratch for each thread.
        Cost {
            bytes: 16 * 64 * grid.cols as u64,
            seconds: cost.seconds + nanoseconds(&self.strokes, grid) * 1e-9,
        }
    }

    fn check(&self) -> Result<()> {
        match self.strokes.iter().position(|s| !s.path.len().is_multiple_of(2)) {
            None => Ok(()),
            Some(i) => Err(Error::Parameter {
                name: "strokes".into(),
                message: format!(
                    "stroke {i}: `path` must list x, y, x, y, …, got {} numbers",
                    self.strokes[i].path.len()
                ),
            }),
        }
    }

    fn run(&self, cx: &Context<'_>, Inputs { below }: Inputs) -> Result<Outputs> {
        let below = below.map(|b| b.crop(&cx.grid));
        let xs = cx.grid.xs();
        let strokes: Vec<_> = self.strokes.iter().filter_map(|s| Some((s.bounds()?, s))).collect();
        let mask = cx.fill(Quantity::Mask, |row, out: &mut [f32]| {
            let mut values = match &below {
                Some(below) => below.row(row.j).iter().map(|v| f64::from(v.clamp(0.0, 1.0))).collect(),
                None => vec![self.ground.0; xs.len()],
            };
            let mut near = Vec::new();
            for (k, (bounds, stroke)) in strokes.iter().enumerate() {
                // Many strokes make a row long; what is left of it then is thrown away.
                if k % PACE == PACE - 1 && cx.work.is_cancelled() {
                    return;
                }
                stroke.paint(bounds, &xs, row.y, &mut values, &mut near);
            }
            out.iter_mut().zip(&values).for_each(|(o, v)| *o = v.clamp(0.0, 1.0) as f32);
        });
        cx.check()?;
        Ok(Outputs { mask: mask? })
    }
}

/// Strokes of a row after which it is asked whether to stop.
const PACE: usize = 16;
