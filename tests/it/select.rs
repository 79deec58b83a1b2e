//! The select family against closed forms, brute force and the laws.

mod derivatives;
mod distances;
mod ranges;
mod sky;

use orograph::kit::hash;
use orograph::ports::Wires;
use orograph::value::{Field, Grid, Quantity, Terrain, Value};
use serde_json::Value as Json;

use crate::rig::bench::Bench;

type Source = dyn Fn(&str, f64, f64) -> f32 + Sync;

/// A node of the family, on fields that are functions of the place.
struct Case(Bench);

fn case(id: &str, set: Json) -> Case {
    Case(Bench::named(id, &set))
}

/// Fields on every port.
fn plane<'a>(source: &'a Source) -> impl Fn(&str, &Grid) -> Option<Value> + Sync + 'a {
    |port, grid| Some(Value::Field(Field::from_fn(*grid, Quantity::Number, |x, y| source(port, x, y))))
}

impl Case {
    fn run(&self, terrain: &Terrain, window: Grid, source: &Source) -> Wires {
        let ran = self.0.run(terrain, window, &plane(source));
        ran.unwrap_or_else(|e| panic!("{}: {e}", self.0.label))
    }

    fn field(&self, terrain: &Terrain, window: Grid, source: &Source, port: &str) -> Field {
        self.0.field(terrain, window, &plane(source), port)
    }
}

/// A world 2 km wide with a base cell of 8 m.
fn world() -> Terrain {
    Terrain { width: 2048.0, depth: 2048.0, base: 257, ..Terrain::default() }
}

fn window(terrain: &Terrain, size: u32, [col, row]: [i64; 2], [cols, rows]: [usize; 2]) -> Grid {
    Grid { col, row, cols, rows, ..terrain.grid(size).expect("a size that fits") }
}

/// Value noise of some octaves, from about −1 to 1, from hashed lattice points.
fn noise(x: f64, y: f64, feature: f64, octaves: u32) -> f64 {
    let corner = |c: i64, r: i64, octave: u32| {
        2.0 * hash::unit(u64::from(octave), (c as u64).wrapping_mul(0x1_0000_0001) ^ (r as u64) << 20) - 1.0
    };
    let ease = |t: f64| t * t * t * (t * (6.0 * t - 15.0) + 10.0);
    let octave = |o: u32| {
        let (u, v) = (x / feature * f64::from(1 << o) + 0.31, y / feature * f64::from(1 << o) + 0.17);
        let (c, r) = (u.floor() as i64, v.floor() as i64);
        let (s, t) = (ease(u - u.floor()), ease(v - v.floor()));
        let along = |r: i64| corner(c, r, o) * (1.0 - s) + corner(c + 1, r, o) * s;
        (along(r) * (1.0 - t) + along(r + 1) * t) / f64::from(1 << o)
    };
    (0..octaves).map(octave).sum()
}

/// A fractal ground, and masks and slopes to go with it.
fn ground(port: &str, x: f64, y: f64) -> f32 {
    let share = |v: f64| (0.5 + 0.6 * v).clamp(0.0, 1.0);
    (match port {
        "mask" => f64::from(noise(x + 900.0, y, 300.0, 3) > 0.35),
        "shade" => share(noise(x, y + 500.0, 100.0, 2)),
        "slope" => 45.0 * share(noise(x + 70.0, y, 200.0, 2)),
        _ => 150.0 + 180.0 * noise(x, y, 700.0, 6),
    }) as f32
}

fn same(label: &str, a: &Wires, b: &Wires, window: &Grid) {
    for (port, value) in a.iter() {
        let other = b.get(port).expect("the same ports").crop(window);
        let differs =
            value.components().iter().zip(other.components()).position(|(a, b)| a.to_bits() != b.to_bits());
        assert_eq!(differs, None, "{label}: `{port}` on {window:?}");
        assert_eq!(value.components().len(), other.components().len());
    }
}

/// Every `step`-th sample of a raster.
fn thinned(value: &Value, step: usize) -> Vec<u32> {
    let (grid, parts) = (*value.grid().unwrap(), (value.wire_type().sample_bytes() / 4) as usize);
    let rows = value.components().chunks(grid.cols * parts).step_by(step);
    rows.flat_map(|row| row.chunks(parts).step_by(step).flatten().map(|v| v.to_bits())).collect()
}
