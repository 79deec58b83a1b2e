//! Surface normals.

use crate::kit::derivative::{self, Derivative};
use crate::prelude::*;

/// Gives the normals of the ground, as vectors and as a normal map.
///
/// With the gradient `p, q` of the height from the heights `scale` metres to either side \[zevenbergen1987\], the
/// normal is `(−p, −q, 1) / √(1 + p² + q²)`, pointing east, south and up. The vectors hold its horizontal part,
/// whose length is the sine of the slope. The map holds `½ + ½ n` as red, green and blue, as game engines read it:
/// plain numbers, not colours to be decoded.
///
/// # See also
/// `hillshade`, `select_slope`, `select_aspect`.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Normals {
    /// Which way the green of the map points.
    pub green: Green,
    /// Factor on the heights.
    #[schemars(range(min = 0.0, max = 1000.0), extend("x-soft" = [0.0, 10.0]))]
    pub exaggeration: Number,
    /// Distance to either side over which the slope is taken; none for the base cell.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 500.0], "x-log" = true))]
    pub scale: Option<Metres>,
}

/// Which way the green of a normal map points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Green {
    /// Up in the picture, to the north: OpenGL, Unity, Godot, Blender.
    #[default]
    North,
    /// Down in the picture, to the south: DirectX, Unreal.
    South,
}

impl Default for Normals {
    fn default() -> Self {
        Self { green: Green::North, exaggeration: Number(1.0), scale: None }
    }
}

ports! {
    pub struct Inputs {
        /// Heights of the ground.
        height: Field,
    }
    pub struct Outputs {
        /// East and south part of the unit normals.
        vectors: Vectors,
        /// Tangent-space normal map.
        colors: Colors,
    }
}

impl Node for Normals {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["zevenbergen1987"])
        .keywords(&["normal map", "bump", "surface", "opengl", "directx"])
        .reads(Reads::BASE);

    fn reach(&self) -> Reach {
        derivative::reach(self.scale)
    }

    fn footprint(&self, _: &str, window: &Grid, terrain: &Terrain) -> Grid {
        derivative::footprint(window, self.scale, terrain.base_cell())
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        derivative::cost(grid, if self.scale.is_some() { 20.0 } else { 12.0 }, 8)
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let scale = cx.scale(self.scale)?;
        let derivative = Derivative::new("height", &input.height, &cx.grid, scale)?;
        let factor = self.exaggeration.0 as f32;
        let vectors = cx.stage(0.0, 0.6).fill(Quantity::Vector, |row, out: &mut [[f32; 2]]| {
            let gradient = derivative.gradient(row.j);
            for ((o, &x), &y) in out.iter_mut().zip(&gradient.x).zip(&gradient.y) {
                let (p, q) = (factor * x, factor * y);
                let up = 1.0 / (1.0 + p * p + q * q).sqrt();
                *o = [-p * up, -q * up];
            }
        })?;
        let green = if self.green == Green::North { -0.5 } else { 0.5 };
        let colors = cx.stage(0.6, 1.0).map(&vectors, Quantity::Color, |[x, y]| {
            let up = (1.0 - x * x - y * y).max(0.0).sqrt();
            [0.5 + 0.5 * x, 0.5 + green * y, 0.5 + 0.5 * up]
        })?;
        Ok(Outputs { vectors, colors })
    }
}
