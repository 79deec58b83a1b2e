//! Displacement along the ground.

use crate::kit::derivative;
use crate::kit::hash;
use crate::kit::noise::{Form, Fractal, FractalRows, Spectrum};
use crate::kit::rows::Rows;
use crate::kit::sample::{Interpolation, Sampler, method_for};
use crate::prelude::*;

/// Pulls a field about along the ground: bends straight ridges, lets forms flow.
///
/// The value at `p` is fetched from `p + d(p)`, where `d` comes from the connected displacement fields, times `factor`;
/// those not connected count as zero. Where none is connected, soft noise takes their place.
///
/// A build coarser than the base grid reads the field on a finer grid, so that it bends the same forms.
///
/// # Limits
/// A displacement longer than `limit` is shortened to it. A larger limit makes tiles read more of the input.
/// Between samples the field is interpolated, so that detail of one or two cells is a matter of the size of the
/// build. Where such detail is to be the same at several sizes, `detail` reads the field finer, at the cost of as many
/// more samples of it.
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
    /// Longest displacement by the built-in noise to either side, along each axis.
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
    /// Widest spacing of the samples that are read of the field, down to a sixteenth of a cell; none for the base cell.
    #[schemars(range(min = 0.01, max = 10_000.0), extend("x-soft" = [1.0, 500.0], "x-log" = true))]
    pub detail: Option<Metres>,
    /// Chooses the built-in noise.
    pub seed: Seed,
}

impl Default for Warp {
    fn default() -> Self {
        Self {
            limit: Metres(200.0),
            factor: Number(1.0),
            amplitude: Metres(150.0),
            feature_size: Metres(800.0),
            octaves: 3,
            interpolation: Interpolation::Cubic,
            detail: None,
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
        field: Field = Meaning::like("field"),
    }
}

impl Node for Warp {
    type In = Inputs;
    type Out = Outputs;
    const META: Meta = Meta::new()
        .cite(&["catmull1974", "perlin2002"])
        .reads(Reads::SEED.and(Reads::BASE))
        .migrations(&[|_| ()])
        .mixes(&[("field", "field")])
        .keywords(&["distort", "displace", "domain warp", "turbulence", "swirl", "flow"]);

    fn reach(&self) -> Reach {
        // Cubic reading takes two samples on either side.
        Reach::local(self.limit.0).plus_cells(2)
    }

    fn footprint(&self, port: &str, window: &Grid, terrain: &Terrain) -> Grid {
        if port != "field" {
            return *window;
        }
        let finer = window.refined(self.refinement(window.cell(), terrain.base_cell()));
        finer.grow_metres(self.limit.0).grow_cells(2)
    }

    fn cost(&self, Load { grid, .. }: &Load<'_>) -> Cost {
        // Where the columns stand, twice, the noise's columns, and a row of displacement in each thread.
        let rows = 8 * grid.cols as u64 * (rayon::current_num_threads() as u64 + 2);
        let bytes = 2 * Fractal::bytes(self.octaves, grid.cols) + rows;
        Cost {
            bytes,
            ..Cost::per_sample(grid, self.interpolation.nanoseconds() + 8.0 * f64::from(self.octaves))
        }
    }

    fn run(&self, cx: &Context<'_>, input: Inputs) -> Result<Outputs> {
        let empty = || Error::Input { port: "field".into(), message: "has no samples".into() };
        let sampler = Sampler::new(&input.field).ok_or_else(empty)?;
        let quantity = input.field.quantity();
        let method = method_for(quantity, self.interpolation);
        let fine = f64::from(self.refinement(cx.grid.cell(), cx.base_cell()?));
        let (limit, per_metre) = (self.limit.0, fine / cx.grid.cell());
        let noise = if input.is_displaced() { None } else { Some(self.noise(cx)?) };
        let xs = cx.grid.xs();
        let displacement = match &noise {
            Some(noise) => Displacement::Noise(noise.each_ref().map(|n| n.over(&xs))),
            None => Displacement::of_fields(self.factor.0, cx, &input),
        };
        let columns: Vec<f64> = (cx.grid.col..cx.grid.col_end()).map(|col| col as f64 * fine).collect();
        let field = cx.fill(quantity, |row, out: &mut [f32]| {
            let (mut east, mut south) = (vec![0.0; out.len()], vec![0.0; out.len()]);
            displacement.row(row, [&mut east, &mut south]);
            let line = row.row as f64 * fine;
            let places = |first: usize, [us, vs]: [&mut [f64]; 2]| {
                let moved = east[first..].iter().zip(&south[first..]).zip(&columns[first..]);
                for ((u, v), ((&x, &y), &column)) in us.iter_mut().zip(vs).zip(moved) {
                    let [x, y] = shortened([f64::from(x), f64::from(y)], limit);
                    *u = column + x * per_metre;
                    *v = line + y * per_metre;
                }
            };
            sampler.row(method, quantity, places, out);
        })?;
        Ok(Outputs { field })
    }
}

impl Warp {
    /// How many times finer than the build's the lattice of the field is.
    fn refinement(&self, cell: f64, base_cell: f64) -> u32 {
        let wanted = self.detail.map_or(1.0, |m| (cell / m.0 - 1e-9).ceil().clamp(1.0, FINEST));
        derivative::refinement(cell, base_cell, base_cell).max(wanted as u32)
    }

    /// The displacements to the east and south by noise, in metres.
    fn noise(&self, cx: &Context<'_>) -> Result<[Fractal; 2]> {
        let seed = cx.seed(self.seed)?;
        let spectrum = Spectrum {
            feature_size: self.feature_size.0,
            octaves: self.octaves.clamp(1, 12),
            lacunarity: 2.0,
            gain: 0.5,
        };
        let one = |k| Fractal::new(Form::Fbm, spectrum, hash::nth(seed, k), 0.0, self.amplitude.0);
        Ok([one(0), one(1)])
    }
}

impl Inputs {
    fn is_displaced(&self) -> bool {
        self.dx.is_some() || self.dy.is_some() || self.vectors.is_some()
    }
}

/// The field is asked for on a lattice at most this much finer than the build's.
const FINEST: f64 = 16.0;

/// A vector of at most some length.
#[inline(always)]
fn shortened([x, y]: [f64; 2], limit: f64) -> [f64; 2] {
    let square = x * x + y * y;
    // A choice of factors vectorises; one of what to return may not.
    let by = if square <= limit * limit { 1.0 } else { limit / square.sqrt() };
    [x * by, y * by]
}

/// Where the displacement comes from.
enum Displacement<'a> {
    Fields { factor: f32, parts: [Option<Rows>; 2], vectors: Option<Vectors> },
    Noise([FractalRows<'a>; 2]),
}

impl Displacement<'_> {
    fn of_fields(factor: f64, cx: &Context<'_>, input: &Inputs) -> Self {
        let parts = [&input.dx, &input.dy].map(|f| f.as_ref().map(|f| Rows::of(f, &cx.grid)));
        let vectors = input.vectors.as_ref().map(|v| v.crop(&cx.grid));
        Self::Fields { factor: factor as f32, parts, vectors }
    }

    /// The displacements of a row to the east and south, in metres.
    fn row(&self, row: Row, out: [&mut [f32]; 2]) {
        for (k, out) in out.into_iter().enumerate() {
            match self {
                Self::Noise(noise) => noise[k].row(row.y, out),
                Self::Fields { factor, parts, vectors } => {
                    if let Some(part) = &parts[k] {
                        out.copy_from_slice(part.at(row.row));
                    }
                    if let Some(vectors) = vectors {
                        out.iter_mut().zip(vectors.row(row.j)).for_each(|(o, v)| *o += v[k]);
                    }
                    out.iter_mut().for_each(|o| *o *= factor);
                }
            }
        }
    }
}
