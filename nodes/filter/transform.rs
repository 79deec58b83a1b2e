//! Moving, turning, scaling, mirroring.

use crate::kit::derivative;
use crate::kit::math::nearest_whole;
use crate::kit::sample::{Interpolation, Sampler, method_for};
use crate::prelude::*;
use crate::value::Bounds;

/// Moves, turns, scales and mirrors a field.
///
/// About a centre, the field is mirrored, scaled, turned and then moved. Values stay as they are. The input goes on
/// beyond the terrain's edge, so no border shows unless the input has one.
/// A build coarser than the base grid reads the field on a finer grid, so that it shows the same forms.
///
/// # Limits
/// Enlarging reads the input as much finer, up to 16 times, and smooths it between its samples beyond that. Shrinking
/// reads one point for each sample, so fine detail may alias: `blur` it first. More than half a terrain outside the
/// edge, what is there continues. Compass directions in the values of a field are not turned. Between samples the
/// field is interpolated, so that detail of one or two cells is a matter of the size of the build.
///
/// # See also
/// `warp` for displacement that varies from place to place.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Transform {
    /// Distance moved to the east.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [-4000.0, 4000.0]))]
    pub move_east: Metres,
    /// Distance moved to the south.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [-4000.0, 4000.0]))]
    pub move_south: Metres,
    /// Angle turned, clockwise as seen on a map.
    #[schemars(range(min = -360.0, max = 360.0), extend("x-soft" = [-180.0, 180.0]))]
    pub rotate: Degrees,
    /// Factor on horizontal lengths: above 1 enlarges.
    #[schemars(range(min = 0.01, max = 100.0), extend("x-soft" = [0.25, 4.0], "x-log" = true))]
    pub scale: Number,
    /// Whether the field is mirrored.
    pub mirror: Mirror,
    /// East of the terrain's middle, the point about which it is turned, scaled and mirrored.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [-4000.0, 4000.0]))]
    pub center_east: Metres,
    /// South of the terrain's middle, the point about which it is turned, scaled and mirrored.
    #[schemars(range(min = -1.0e6, max = 1.0e6), extend("x-soft" = [-4000.0, 4000.0]))]
    pub center_south: Metres,
    /// How the field is read between its samples.
    pub interpolation: Interpolation,
}

/// How [`Transform`] mirrors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Mirror {
    /// Not at all.
    #[default]
    Off,
    /// East and west change places.
    EastWest,
    /// North and south change places.
    NorthSouth,
}

impl Default for Transform {
    fn default() -> Self {
        Self {
            move_east: Metres(0.0),
            move_south: Metres(0.0),
            rotate: Degrees(0.0),
            scale: Number(1.0),
            mirror: Mirror::Off,
            center_east: Metres(0.0),
            center_south: Metres(0.0),
            interpolation: Interpolation::Cubic,
        }
    }
}

ports! {
    pub struct Inputs {
        /// Field to move.
        field: Field,
    }
    pub struct Outputs {
        /// Moved field, in the unit of the input.
        field: Field = Meaning::like("field"),
    }
}

impl Node for Transform {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["catmull1974"])
        .reads(Reads::TERRAIN.and(Reads::BASE))
        .migrations(&[|_| ()])
        .mixes(&[("field", "field")])
        .keywords(&["move", "translate", "rotate", "scale", "mirror", "flip", "offset", "resize"]);

    fn reach(&self) -> Reach {
        // The footprint says where; a window alone has no terrain to find the centre by.
        Reach::local(0.0)
    }

    /// The window from which the output is fetched; where it is enlarged, on a lattice as much finer, so that it
    /// shows detail and not the steps of the output's lattice.
    fn footprint(&self, _: &str, window: &Grid, terrain: &Terrain) -> Grid {
        let back = Back::new(self, terrain);
        let Bounds { min, max } = window.bounds();
        let corners = [min, [max[0], min[1]], [min[0], max[1]], max].map(|p| back.of(p));
        match Bounds::around(corners) {
            // Cubic reading takes two samples on either side, and one for the rounding of positions.
            Some(bounds) if !self.is_identity() => {
                let finer = self.refinement(window.cell(), terrain.base_cell());
                Grid::covering(window.lattice.refined(finer), bounds).grow_cells(3)
            }
            _ => *window,
        }
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        // Coordinates of the columns.
        let bytes = 8 * grid.cols as u64;
        Cost { bytes, ..Cost::per_sample(grid, 8.0 + self.interpolation.nanoseconds()) }
    }

    fn run(&self, cx: &Context<'_>, Inputs { field }: Inputs) -> Result<Outputs> {
        if self.is_identity() {
            return Ok(Outputs { field: field.crop(&cx.grid) });
        }
        let empty = || Error::Input { port: "field".into(), message: "has no samples".into() };
        let sampler = Sampler::new(&field).ok_or_else(empty)?;
        let back = Back::new(self, cx.terrain()?);
        let quantity = field.quantity();
        let method = method_for(quantity, self.interpolation);
        let (lattice, xs) = (field.grid().lattice, cx.grid.xs());
        let field = cx.fill(quantity, |row, out: &mut [f32]| {
            let places = |first: usize, [us, vs]: [&mut [f64]; 2]| {
                for ((u, v), &x) in us.iter_mut().zip(vs).zip(&xs[first..]) {
                    let [x, y] = back.of([x, row.y]);
                    let [col, line] = lattice.steps(x, y);
                    *u = snapped(col);
                    *v = snapped(line);
                }
            };
            sampler.row(method, quantity, places, out);
        })?;
        Ok(Outputs { field })
    }
}

impl Transform {
    /// How much finer the lattice of the input is.
    fn refinement(&self, cell: f64, base_cell: f64) -> u32 {
        // Up to the next whole number, so that the input has about as many samples as the output.
        let enlarged = (self.scale.0 - 1e-9).ceil().clamp(1.0, FINEST) as u32;
        enlarged * derivative::refinement(cell, base_cell, base_cell)
    }

    fn is_identity(&self) -> bool {
        self.move_east.0 == 0.0
            && self.move_south.0 == 0.0
            && self.rotate.0 % 360.0 == 0.0
            && self.scale.0 == 1.0
            && self.mirror == Mirror::Off
    }
}

/// Input is asked for on a lattice at most this much finer: beyond, enlarged detail is smoothed.
const FINEST: f64 = 16.0;

/// A position that is a sample's but for rounding becomes that sample's: whole steps and quarter turns are exact.
#[inline(always)]
fn snapped(at: f64) -> f64 {
    let whole = nearest_whole(at);
    if (at - whole).abs() < 1e-7 { whole } else { at }
}

/// From a place of the output back to the place of the input that went there.
struct Back {
    /// Where the centre went.
    to: [f64; 2],
    from: [f64; 2],
    /// Rows of the matrix.
    east: [f64; 2],
    south: [f64; 2],
}

impl Back {
    fn new(node: &Transform, terrain: &Terrain) -> Self {
        let from = [
            terrain.origin[0] + 0.5 * terrain.width + node.center_east.0,
            terrain.origin[1] + 0.5 * terrain.depth + node.center_south.0,
        ];
        let (cos, sin) = turn(node.rotate.0);
        let [flip_x, flip_y] = match node.mirror {
            Mirror::Off => [1.0, 1.0],
            Mirror::EastWest => [-1.0, 1.0],
            Mirror::NorthSouth => [1.0, -1.0],
        };
        let (x, y) = (flip_x / node.scale.0, flip_y / node.scale.0);
        Self {
            to: [from[0] + node.move_east.0, from[1] + node.move_south.0],
            from,
            east: [cos * x, sin * x],
            south: [-sin * y, cos * y],
        }
    }

    #[inline(always)]
    fn of(&self, p: [f64; 2]) -> [f64; 2] {
        let (u, v) = (p[0] - self.to[0], p[1] - self.to[1]);
        [
            self.from[0] + (self.east[0] * u + self.east[1] * v),
            self.from[1] + (self.south[0] * u + self.south[1] * v),
        ]
    }
}

/// Cosine and sine of an angle in degrees, exact at quarter turns.
fn turn(degrees: f64) -> (f64, f64) {
    let quarters = (degrees / 90.0).round();
    let rest = (degrees - 90.0 * quarters).to_radians();
    let (c, s) = (libm::cos(rest), libm::sin(rest));
    match (quarters as i64).rem_euclid(4) {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    }
}
