//! Shading by the sun.

use crate::kit::derivative::{self, Derivative};
use crate::prelude::*;

/// Shades the ground by the sun, as on a relief map.
///
/// Lambert's law: the shade is the cosine of the angle between the normal of the ground and the direction to the
/// sun, 0 where the ground faces away \[horn1981\]. The gradient comes from the heights `scale` metres to either side.
/// With `multiple` light, the sun shines from four directions 45° apart around `azimuth`, each weighted by the square
/// of the sine between it and the fall of the ground, so that no slope drowns in shadow \[mark1992\].
///
/// # Limits
/// No cast shadows: `occlusion` knows what stands around.
///
/// # See also
/// `occlusion`, `colorize`, which takes the shade as an input.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Hillshade {
    /// Compass direction in which the sun stands: 0 north, 90 east.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-soft" = [0.0, 360.0]))]
    pub azimuth: Degrees,
    /// Height of the sun above the horizon.
    #[schemars(range(min = 0.0, max = 90.0))]
    pub altitude: Degrees,
    /// Factor on the heights.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.0, 10.0]))]
    pub exaggeration: Number,
    /// One sun or several.
    pub light: Light,
    /// Distance to either side over which the slope is taken; none for the base cell.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 500.0], "x-log" = true))]
    pub scale: Option<Metres>,
}

/// From how many directions the sun shines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Light {
    /// From one direction.
    #[default]
    Single,
    /// From four: 90° and 45° to the left, straight on, and 45° to the right.
    Multiple,
}

impl Default for Hillshade {
    fn default() -> Self {
        Self {
            azimuth: Degrees(315.0),
            altitude: Degrees(45.0),
            exaggeration: Number(1.0),
            light: Light::Single,
            scale: None,
        }
    }
}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
    }
    pub struct Outputs {
        /// How bright the ground is, 0 to 1.
        shade: Field = Meaning::Fixed(Quantity::Mask),
    }
}

impl Node for Hillshade {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["horn1981", "mark1992", "zevenbergen1987"])
        .keywords(&["relief", "shading", "lambert", "sun", "light", "map"])
        .reads(Reads::BASE);

    fn reach(&self) -> Reach {
        derivative::reach(self.scale)
    }

    fn footprint(&self, _: &str, window: &Grid, terrain: &Terrain) -> Grid {
        derivative::footprint(window, self.scale, terrain.base_cell())
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        derivative::cost(grid, if self.scale.is_some() { 16.0 } else { 8.0 }, 8)
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let scale = cx.scale(self.scale)?;
        let derivative = Derivative::new("height", &input.height, &cx.grid, scale)?;
        let factor = self.exaggeration.0 as f32;
        let (sun, fan) = (self.sun(0.0), [-90.0, -45.0, 0.0, 45.0].map(|turn| self.sun(turn)));
        let shade = cx.fill(Quantity::Mask, |row, out| {
            let gradient = derivative.gradient(row.j);
            let slopes = gradient.x.iter().zip(&gradient.y).map(|(&x, &y)| [factor * x, factor * y]);
            match self.light {
                Light::Single => out.iter_mut().zip(slopes).for_each(|(o, slope)| *o = sun.shade(slope)),
                Light::Multiple => {
                    out.iter_mut().zip(slopes).for_each(|(o, slope)| *o = oblique(&fan, slope));
                }
            }
        })?;
        Ok(Outputs { shade })
    }
}

impl Hillshade {
    /// The sun, turned clockwise by some degrees.
    fn sun(&self, turn: f64) -> Sun {
        let azimuth = (self.azimuth.0 + turn).to_radians();
        let altitude = self.altitude.0.to_radians();
        Sun {
            level: [libm::sin(azimuth) as f32, -libm::cos(azimuth) as f32],
            across: libm::cos(altitude) as f32,
            up: libm::sin(altitude) as f32,
        }
    }
}

/// The direction to a sun.
struct Sun {
    /// East and south part of the horizontal unit vector.
    level: [f32; 2],
    across: f32,
    up: f32,
}

impl Sun {
    /// Lambert's cosine for a gradient.
    #[inline]
    fn shade(&self, [p, q]: [f32; 2]) -> f32 {
        let facing = self.up - self.across * (p * self.level[0] + q * self.level[1]);
        (facing / (1.0 + p * p + q * q).sqrt()).clamp(0.0, 1.0)
    }

    /// The square of the sine between the sun and the fall of the ground; ½ on the flat.
    #[inline]
    fn weight(&self, [p, q]: [f32; 2]) -> f32 {
        // Adding a trifle to both keeps the sum of four weights at 2 and the flat defined.
        const TRIFLE: f32 = 1e-12;
        let along = p * self.level[0] + q * self.level[1];
        let square = p * p + q * q;
        ((square - along * along).max(0.0) + 0.5 * TRIFLE) / (square + TRIFLE)
    }
}

/// Four suns, each weighted by how obliquely it strikes the slope; the weights sum to 2.
#[inline]
fn oblique(fan: &[Sun; 4], slope: [f32; 2]) -> f32 {
    let sum: f32 = fan.iter().map(|sun| sun.weight(slope) * sun.shade(slope)).sum();
    (0.5 * sum).clamp(0.0, 1.0)
}
