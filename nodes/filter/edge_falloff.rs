//! Towards the edge.

use crate::kit::rows::{Rows, lerp};
use crate::kit::sample::finite;
use crate::prelude::*;

/// Fades a field to a level towards the edge of the terrain: makes an island, or a border to blend with.
///
/// A point at the distance `d` from the edge keeps the share `d / distance` of what it has over the level; further
/// inside it stays as it is, outside it has the level.
///
/// # Limits
/// The distance counts as at most half the terrain's shorter side. The corners of a rectangle are rounded.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EdgeFalloff {
    /// Where the fading begins, from the edge inwards.
    #[schemars(range(min = 0.0, max = 1.0e6), extend("x-soft" = [0.0, 4000.0]))]
    pub distance: Metres,
    /// The line at which the level is reached.
    pub shape: Shape,
    /// 0 fades evenly, 1 leaves and arrives gently.
    pub smoothness: Ratio,
    /// What the field fades to, in its unit.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [-500.0, 500.0]))]
    pub level: Number,
}

/// The line at which [`EdgeFalloff`] reaches its level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// The edge of the terrain.
    #[default]
    Rectangle,
    /// The ellipse that touches the edges, a circle on a square terrain.
    Ellipse,
}

impl Default for EdgeFalloff {
    fn default() -> Self {
        Self { distance: Metres(1500.0), shape: Shape::Rectangle, smoothness: Ratio(1.0), level: Number(0.0) }
    }
}

ports! {
    pub struct Inputs {
        /// Field to fade.
        field: Field,
    }
    pub struct Outputs {
        /// Faded field, in the unit of the input.
        field: Field = Meaning::like("field"),
    }
}

impl Node for EdgeFalloff {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .reads(Reads::TERRAIN)
        .mixes(&[("field", "field")])
        .keywords(&["island", "border", "vignette", "fade", "boundary"]);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost { bytes: 8 * grid.cols as u64, ..Cost::per_sample(grid, 14.0) }
    }

    fn run(&self, cx: &Context<'_>, Inputs { field }: Inputs) -> Result<Outputs> {
        let fade = Fade::new(self, cx.terrain()?);
        let (rows, xs) = (Rows::of(&field, &cx.grid), cx.grid.xs());
        let level = self.level.0 as f32;
        let field = cx.fill(field.quantity(), |row, out: &mut [f32]| {
            for ((o, &x), &value) in out.iter_mut().zip(&xs).zip(rows.at(row.row)) {
                *o = finite(lerp(level, value, fade.share(x, row.y) as f32));
            }
        })?;
        Ok(Outputs { field })
    }
}

/// How much of a field is left at a place.
struct Fade {
    shape: Shape,
    center: [f64; 2],
    half: [f64; 2],
    distance: f64,
    smoothness: f64,
}

impl Fade {
    fn new(node: &EdgeFalloff, terrain: &Terrain) -> Self {
        let half = [0.5 * terrain.width, 0.5 * terrain.depth];
        let center = [terrain.origin[0] + half[0], terrain.origin[1] + half[1]];
        let distance = node.distance.0.min(half[0].min(half[1]));
        Self { shape: node.shape, center, half, distance, smoothness: node.smoothness.0 }
    }

    /// The share, 0 outside and 1 far inside.
    fn share(&self, x: f64, y: f64) -> f64 {
        let p = [(x - self.center[0]).abs(), (y - self.center[1]).abs()];
        let inside = match self.shape {
            Shape::Rectangle => self.in_rectangle(p),
            Shape::Ellipse => self.in_ellipse(p),
        };
        if self.distance <= 0.0 {
            return f64::from(inside > 0.0);
        }
        let t = (inside / self.distance).clamp(0.0, 1.0);
        let gentle = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        t + self.smoothness * (gentle - t)
    }

    /// Distance from the edge inwards, along round corners of the radius of the fade.
    fn in_rectangle(&self, p: [f64; 2]) -> f64 {
        let [u, v] = [0, 1].map(|k| p[k] - (self.half[k] - self.distance));
        if u > 0.0 && v > 0.0 {
            return self.distance - libm::sqrt(u * u + v * v);
        }
        self.distance - u.max(v)
    }

    /// Distance from the ellipse inwards, to first order.
    fn in_ellipse(&self, p: [f64; 2]) -> f64 {
        let [a, b] = self.half;
        let (u, v) = (p[0] / a, p[1] / b);
        let r = libm::sqrt(u * u + v * v);
        let steep = libm::sqrt((u / a) * (u / a) + (v / b) * (v / b));
        if r < 1e-9 { a.min(b) } else { (1.0 - r) * r / steep }
    }
}
