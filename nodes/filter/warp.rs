//! Displacement along the ground.

use crate::kit::hash;
use crate::kit::rows::Rows;
use crate::kit::sample::{Interpolation, Sampler, fit, method_for};
use crate::prelude::*;

/// Pulls a field about along the ground: bends straight ridges, lets forms flow.
///
/// The value at `p` is fetched from `p + d(p)`, where `d` comes from the connected displacement fields, times `factor`;
/// those not connected count as zero. Where none is connected, soft noise takes their place.
///
/// # Limits
/// A displacement longer than `limit` is shortened to it. A larger limit makes tiles read more of the input.
///
/// # See also
/// `transform` moves the field as a whole.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Warp {
    /// Longest displacement.
    #[schemars(range(min = 0.0, max = 20_000.0), extend("x-soft" = [0.0, 1000.0]))]
    pub limit: Metres,
    /// Metres of displacement per unit of the connected fields.
    #[schemars(range(min = -1.0e5, max = 1.0e5), extend("x-soft" = [-500.0, 500.0]))]
    pub factor: Number,
    /// Displacement by the built-in noise, about the longest of its largest octave.
    #[schemars(range(min = 0.0, max = 20_000.0), extend("x-soft" = [0.0, 500.0]))]
    pub amplitude: Metres,
    /// Size of the largest forms of the built-in noise.
    #[schemars(range(min = 0.1, max = 1.0e6), extend("x-soft" = [50.0, 4000.0], "x-log" = true))]
    pub feature_size: Metres,
    /// Octaves of the built-in noise; each has half the size and half the height of the one before.
    #[schemars(range(min = 1, max = 12), extend("x-soft" = [1, 6], "x-unit" = "1"))]
    pub octaves: u32,
    /// How the field is read between its samples.
    pub interpolation: Interpolation,
    /// Chooses the built-in noise.
    pub seed: Seed,
}

impl Default for Warp {
    fn default() -> Self {
        Self {
            limit: Metres(200.0),
            factor: Number(1.0),
            amplitude: Metres(80.0),
            feature_size: Metres(800.0),
            octaves: 3,
            interpolation: Interpolation::Cubic,
            seed: Seed(0),
        }
    }
}

ports! {
    pub struct Inputs {
        /// Field to warp.
        field: Field,
        /// Displacement to the east.
        dx: Option<Field>,
        /// Displacement to the south.
        dy: Option<Field>,
        /// Displacement to the east and south, added to the others.
        vectors: Option<Vectors>,
    }
    pub struct Outputs {
        /// Warped field, in the unit of the input.
        field: Field,
    }
}

impl Node for Warp {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["catmull1974", "perlin2002"])
        .reads(Reads::SEED)
        .mixes(&[("field", "field")])
        .keywords(&["distort", "displace", "domain warp", "turbulence", "swirl", "flow"]);

    fn reach(&self) -> Reach {
        // Cubic reading takes two samples on either side.
        Reach::local(self.limit.0).plus_cells(2)
    }

    fn footprint(&self, port: &str, window: &Grid, _: &Terrain) -> Grid {
        if port == "field" { window.grow_metres(self.limit.0).grow_cells(2) } else { *window }
    }

    fn cost(&self, grid: &Grid) -> Cost {
        Cost::per_sample(grid, 20.0 + 25.0 * f64::from(self.octaves))
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let empty = || Error::Input { port: "field", message: "has no samples".into() };
        let sampler = Sampler::new(&input.field).ok_or_else(empty)?;
        let quantity = input.field.quantity();
        let method = method_for(quantity, self.interpolation);
        let (limit, per_metre) = (self.limit.0, 1.0 / cx.grid.cell());
        let displacement = Displacement::new(self, cx, &input)?;
        let field = cx.fill(quantity, |row, out: &mut [f32]| {
            for (i, o) in out.iter_mut().enumerate() {
                let [x, y] = shortened(displacement.at(i, row), limit);
                let at = [(cx.grid.col + i as i64) as f64 + x * per_metre, row.row as f64 + y * per_metre];
                *o = fit(quantity, sampler.value(method, at));
            }
        })?;
        Ok(Outputs { field })
    }
}

/// A vector of at most some length.
fn shortened([x, y]: [f64; 2], limit: f64) -> [f64; 2] {
    let square = x * x + y * y;
    if square <= limit * limit {
        return [x, y];
    }
    let by = limit / libm::sqrt(square);
    [x * by, y * by]
}

/// Where the displacement comes from.
enum Displacement {
    Fields { factor: f64, parts: [Option<Rows>; 2], vectors: Option<Vectors> },
    Noise { noise: Noise, amplitude: f64, xs: Vec<f64> },
}

impl Displacement {
    fn new(node: &Warp, cx: &Context<'_>, input: &Inputs) -> Result<Self> {
        if input.dx.is_none() && input.dy.is_none() && input.vectors.is_none() {
            let noise = Noise::new(cx.seed(node.seed)?, node.feature_size.0, node.octaves);
            return Ok(Self::Noise { noise, amplitude: node.amplitude.0, xs: cx.grid.xs() });
        }
        let rows = |f: &Option<Field>| f.as_ref().map(|f| Rows::of(f, &cx.grid));
        let vectors = input.vectors.as_ref().map(|v| v.crop(&cx.grid));
        Ok(Self::Fields { factor: node.factor.0, parts: [rows(&input.dx), rows(&input.dy)], vectors })
    }

    /// The displacement of a sample, in metres.
    fn at(&self, i: usize, row: Row) -> [f64; 2] {
        match self {
            Self::Noise { noise, amplitude, xs } => noise.at(xs[i], row.y).map(|d| d * amplitude),
            Self::Fields { factor, parts, vectors } => {
                let vector = vectors.as_ref().map_or([0.0; 2], |v| v.row(row.j)[i]);
                [0, 1].map(|k| {
                    let part = parts[k].as_ref().map_or(0.0, |r| r.at(row.row)[i]);
                    (f64::from(part) + f64::from(vector[k])) * factor
                })
            }
        }
    }
}

/// Two independent sums of gradient noise over the plane [perlin2002], each octave moved by chance.
struct Noise {
    octaves: Vec<Octave>,
}

struct Octave {
    seed: u64,
    frequency: f64,
    offset: [f64; 2],
    height: f64,
}

impl Noise {
    fn new(seed: u64, feature_size: f64, octaves: u32) -> Self {
        let octave = |k: u32| {
            let (seed, twice) = (hash::nth(seed, u64::from(k)), f64::from(1u32 << k.min(30)));
            let offset = [hash::unit(seed, 0), hash::unit(seed, 1)];
            Octave { seed, frequency: twice / feature_size, offset, height: 1.0 / twice }
        };
        Self { octaves: (0..octaves.min(12)).map(octave).collect() }
    }

    /// Both sums, about -1 to 1 in the largest octave.
    fn at(&self, x: f64, y: f64) -> [f64; 2] {
        self.octaves.iter().fold([0.0; 2], |sum, o| {
            let value = o.at(x * o.frequency + o.offset[0], y * o.frequency + o.offset[1]);
            [sum[0] + o.height * value[0], sum[1] + o.height * value[1]]
        })
    }
}

impl Octave {
    fn at(&self, x: f64, y: f64) -> [f64; 2] {
        let (i, j) = (x.floor(), y.floor());
        let (s, t) = (x - i, y - j);
        let corner = |di: i64, dj: i64| {
            let (i, j) = ((i as i64).wrapping_add(di) as u64, (j as i64).wrapping_add(dj) as u64);
            let bits = hash::mix(hash::nth(self.seed, i) ^ j);
            // Four numbers of 16 bits: two gradients.
            let g = |k: u32| f64::from((bits >> (16 * k)) as u16) / 32767.5 - 1.0;
            let (u, v) = (s - di as f64, t - dj as f64);
            [g(0) * u + g(1) * v, g(2) * u + g(3) * v]
        };
        let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1));
        let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
        let (s, t) = (fade(s), fade(t));
        [0, 1].map(|k| {
            let (top, bottom) = (a[k] + (b[k] - a[k]) * s, c[k] + (d[k] - c[k]) * s);
            1.6 * (top + (bottom - top) * t)
        })
    }
}
