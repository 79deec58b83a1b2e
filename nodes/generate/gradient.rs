//! Ramps, cones and domes.

use crate::prelude::*;

/// Makes a ramp, a bell, a cone or a dome.
///
/// The height is `foot + (top − foot) · p`, with the profile `p` from 0 to 1 of the form; beyond the form it stays
/// at its last value. Distances are taken from a center given relative to the middle of the terrain.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Gradient {
    /// How the values run over the terrain.
    pub form: Form,
    /// Middle of the form: metres east and metres south of the middle of the terrain.
    #[schemars(extend("x-widget" = Widget::Point, "x-items" = ["east", "south"]))]
    pub center: [Metres; 2],
    /// Height where the form begins: at the low end of a ramp, around a cone or dome.
    #[schemars(range(min = -1.0e5, max = 1.0e5), extend("x-soft" = [-1000.0, 3000.0]))]
    pub foot: Metres,
    /// Height where the form ends: at the high end of a ramp, in the middle of a cone or dome.
    #[schemars(range(min = -1.0e5, max = 1.0e5), extend("x-soft" = [-1000.0, 3000.0]))]
    pub top: Metres,
}

/// The form of a gradient, with `r` the distance from the center in parts of the radius.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Form {
    /// An even ramp.
    Linear {
        /// Compass direction in which it rises: 0 north, 90 east.
        #[serde(default = "north")]
        direction: Degrees,
        /// Length of the ramp; half of it lies on each side of the center.
        #[serde(default = "length")]
        #[schemars(range(min = 0.01, max = 2.0e7), extend("x-soft" = [100.0, 20_000.0], "x-log" = true))]
        length: Metres,
    },
    /// A bell, level in the middle and at the foot: `1 − 3 r² + 2 r³`.
    Radial {
        /// Radius of the foot.
        #[serde(default = "radius")]
        #[schemars(range(min = 0.01, max = 2.0e7), extend("x-soft" = [100.0, 20_000.0], "x-log" = true))]
        radius: Metres,
    },
    /// A cone: `1 − r`.
    Cone {
        /// Radius of the foot.
        #[serde(default = "radius")]
        #[schemars(range(min = 0.01, max = 2.0e7), extend("x-soft" = [100.0, 20_000.0], "x-log" = true))]
        radius: Metres,
    },
    /// Half an ellipsoid, upright at the foot: `√(1 − r²)`.
    Dome {
        /// Radius of the foot.
        #[serde(default = "radius")]
        #[schemars(range(min = 0.01, max = 2.0e7), extend("x-soft" = [100.0, 20_000.0], "x-log" = true))]
        radius: Metres,
    },
}

fn north() -> Degrees {
    Degrees(0.0)
}

fn length() -> Metres {
    Metres(8000.0)
}

fn radius() -> Metres {
    Metres(4000.0)
}

impl Default for Gradient {
    fn default() -> Self {
        Self {
            form: Form::Linear { direction: north(), length: length() },
            center: [Metres(0.0), Metres(0.0)],
            foot: Metres(0.0),
            top: Metres(1000.0),
        }
    }
}

ports! {
    pub struct Inputs {}
    pub struct Outputs {
        /// Height, in metres.
        field: Field = Meaning::Fixed(Quantity::Elevation),
    }
}

impl Node for Gradient {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .keywords(&["ramp", "slope", "linear", "radial", "cone", "dome", "hill", "island", "volcano"])
        .reads(Reads::TERRAIN);

    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        Cost { bytes: 8 * grid.cols as u64, ..Cost::per_sample(grid, 6.0) }
    }

    fn run(&self, cx: &Context<'_>, _: Inputs) -> Result<Outputs> {
        let bounds = cx.terrain()?.bounds();
        let middle = |axis: usize| (bounds.min[axis] + bounds.max[axis]) / 2.0 + self.center[axis].0;
        let center = [middle(0), middle(1)];
        let field = match self.form {
            Form::Linear { direction, length } => {
                let (sin, cos) = libm::sincos(direction.0.to_radians());
                self.fill(cx, center, |x, y| 0.5 + (x * sin - y * cos) / length.0)
            }
            Form::Radial { radius } => self.fill(cx, center, |x, y| {
                let r = (distance(x, y) / radius.0).min(1.0);
                1.0 - r * r * (3.0 - 2.0 * r)
            }),
            Form::Cone { radius } => self.fill(cx, center, |x, y| 1.0 - distance(x, y) / radius.0),
            Form::Dome { radius } => self.fill(cx, center, |x, y| {
                let r = (distance(x, y) / radius.0).min(1.0);
                (1.0 - r * r).sqrt()
            }),
        };
        Ok(Outputs { field: field? })
    }
}

impl Gradient {
    /// Heights from a profile of the position relative to the center; the profile is cut to 0 to 1.
    fn fill(
        &self,
        cx: &Context<'_>,
        [east, south]: [f64; 2],
        profile: impl Fn(f64, f64) -> f64 + Sync,
    ) -> Result<Field> {
        let xs = cx.grid.xs();
        let (foot, rise) = (self.foot.0, self.top.0 - self.foot.0);
        cx.fill(Quantity::Elevation, |row, out| {
            for (o, x) in out.iter_mut().zip(&xs) {
                *o = (foot + rise * profile(x - east, row.y - south).clamp(0.0, 1.0)) as f32;
            }
        })
    }
}

fn distance(x: f64, y: f64) -> f64 {
    (x * x + y * y).sqrt()
}
