//! Tests of: generate.

use orograph::kit::noise::{self, Form, Fractal, Measure, Metric, Spectrum, Worley, lattice};
use orograph::kit::simd::Level;
use orograph::node::{Cancel, Context, Kind};
use orograph::nodes::Registry;
use orograph::params::{Param, Shape};
use orograph::ports::Wires;
use orograph::value::{Field, Grid, Lattice, Quantity, Terrain, Value};
use serde_json::{Map, Value as Json, json};

const KINDS: [&str; 5] = ["cellular_noise", "constant", "fractal_noise", "gradient", "multifractal"];

fn kind(id: &str) -> &'static Kind {
    Registry::standard().find(id).expect(id)
}

fn set(json: Json) -> Map<String, Json> {
    json.as_object().cloned().expect("an object")
}

/// Runs a kind on a grid with some inputs.
fn run_with(id: &str, params: Json, grid: Grid, terrain: &Terrain, wires: Wires) -> Field {
    let node = kind(id).parse(&set(params)).expect("good parameters");
    let cancel = Cancel::default();
    let mut out = node.run(&Context::bare(grid, terrain, &cancel), wires).expect("a generator runs");
    match out.take("field") {
        Some(Value::Field(field)) => field,
        other => panic!("{id} gave {other:?}"),
    }
}

fn run(id: &str, params: Json, grid: Grid, terrain: &Terrain) -> Field {
    run_with(id, params, grid, terrain, Wires::default())
}

/// The forms in which the generators that have some are tried.
fn cases() -> Vec<(&'static str, Json)> {
    let mut cases = vec![("constant", json!({"value": 3.5}))];
    let (metrics, measures) =
        (["euclidean", "manhattan", "chebyshev"], ["f1", "f2", "f2_minus_f1", "cell_value"]);
    for form in [
        json!("fbm"),
        json!({"billow": {"sharpness": 0.7}}),
        json!({"ridged": {"sharpness": 0.9}}),
        json!({"hybrid": {"base": 0.6}}),
    ] {
        cases.push(("fractal_noise", json!({"form": form, "lacunarity": 2.1})));
    }
    for metric in metrics {
        for measure in measures {
            cases.push(("cellular_noise", json!({"metric": metric, "measure": measure, "size": 333.0})));
        }
    }
    for form in [
        json!({"linear": {"direction": 30.0}}),
        json!({"radial": {"radius": 3000.0}}),
        json!({"cone": {"radius": 3000.0}}),
        json!({"dome": {"radius": 3000.0}}),
    ] {
        cases.push(("gradient", json!({"form": form, "centre": [200.0, -300.0]})));
    }
    cases.push(("multifractal", json!({"roughness": 0.8, "octaves": 6})));
    cases
}

fn assert_same_bits(a: &Field, b: &Field, what: &str) {
    assert_eq!(a.grid(), b.grid(), "{what}");
    let differ = a.data().iter().zip(b.data()).filter(|(x, y)| x.to_bits() != y.to_bits()).count();
    assert_eq!(differ, 0, "{what}: samples that differ of {}", a.data().len());
}

// The laws, on every generator.

#[test]
fn coincident_samples_are_equal_at_all_sizes() {
    let terrain = Terrain { origin: [-1234.5, 987.25], width: 7000.0, depth: 7000.0, ..Terrain::default() };
    for (coarse, fine) in [(65, 129), (65, 257), (127, 379), (64, 64 * 5 - 4)] {
        let step = (fine - 1) / (coarse - 1);
        assert_eq!(step * (coarse - 1), fine - 1);
        for (id, params) in cases() {
            let small = run(id, params.clone(), terrain.grid(coarse).unwrap(), &terrain);
            let large = run(id, params.clone(), terrain.grid(fine).unwrap(), &terrain);
            for row in 0..i64::from(coarse) {
                for col in 0..i64::from(coarse) {
                    let (a, b) = (small.at(col, row), large.at(col * i64::from(step), row * i64::from(step)));
                    assert_eq!(
                        a.to_bits(),
                        b.to_bits(),
                        "{id} {params} at {col}, {row} of {coarse} in {fine}"
                    );
                }
            }
        }
    }
}

#[test]
fn coincident_samples_are_equal_at_real_sizes() {
    let terrain = Terrain::default();
    let params = json!({"octaves": 3});
    let fields = [505, 513, 1025, 1513, 2049]
        .map(|size| (size, run("fractal_noise", params.clone(), terrain.grid(size).unwrap(), &terrain)));
    for (small, large) in [(1, 2), (1, 4), (0, 3)] {
        let ((n, small), (m, large)) = (&fields[small], &fields[large]);
        let step = i64::from((m - 1) / (n - 1));
        for row in 0..i64::from(*n) {
            for col in 0..i64::from(*n) {
                assert_eq!(small.at(col, row).to_bits(), large.at(col * step, row * step).to_bits());
            }
        }
    }
}

#[test]
fn tiles_are_crops_of_the_whole() {
    let terrain = Terrain::default();
    let whole = terrain.grid(513).unwrap();
    let big = whole.grow_cells(70);
    for (id, params) in cases() {
        let all = run(id, params.clone(), big, &terrain);
        for (start, end) in
            [([0, 0], [513, 513]), ([-70, -3], [200, 19]), ([257, 300], [258, 583]), ([8, 8], [9, 9])]
        {
            let tile = Grid::between(whole.lattice, start, end);
            let alone = run(id, params.clone(), tile, &terrain);
            assert_same_bits(&alone, &all.crop(&tile), &format!("{id} {params} on {tile:?}"));
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let terrain = Terrain::default();
    let grid = terrain.grid(257).unwrap();
    for (id, params) in cases() {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(id, params.clone(), grid, &terrain))
        };
        let one = on(1);
        for threads in [2, 7] {
            assert_same_bits(&one, &on(threads), &format!("{id} {params} on {threads} threads"));
        }
    }
}

fn forms() -> [Form; 5] {
    let round = Form::Ridged { sharpness: 0.8, focus: 2.0 };
    [Form::Fbm, Form::Billow { sharpness: 1.0 }, round, Form::Hybrid { base: 0.7 }, Form::Rough]
}

#[test]
fn instruction_sets_do_not_change_a_bit() {
    let spectrum = Spectrum { feature_size: 700.0, octaves: 9, lacunarity: 2.03, gain: 0.55 };
    // Widths around the chunk and the lanes.
    for cols in [1, 7, 16, 33, 256, 257, 1025] {
        let xs: Vec<f64> = (0..cols).map(|i| f64::from(i) * 7.3 - 2000.0).collect();
        let roughness: Vec<f32> = (0..cols).map(|i| (i % 100) as f32 / 80.0 - 0.1).collect();
        let check = |what: &str, row: &dyn Fn(Level, &mut [f32])| {
            let (mut reference, mut other) = (vec![0.0; xs.len()], vec![0.0; xs.len()]);
            row(Level::BASELINE, &mut reference);
            for level in Level::available() {
                row(level, &mut other);
                let bits = |v: &[f32]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(&reference), bits(&other), "{what}, {cols} columns, {level:?}");
            }
        };
        for form in forms() {
            let noise = Fractal::new(form, spectrum, 99, 10.0, 500.0);
            for y in [0.0, -12_345.678, 1e7] {
                check(&format!("{form:?}"), &|level, out| {
                    noise.over(&xs).on(level).rough_row(y, &roughness, out)
                });
            }
        }
        for (metric, measure) in metrics_and_measures() {
            let noise = Worley::new(55.0, 0.95, 7, 0.0, 100.0).measured(metric, measure);
            check(&format!("{metric:?} {measure:?}"), &|level, out| noise.over(&xs).on(level).row(77.7, out));
        }
    }
    let levels = Level::available().len();
    if levels == 1 {
        eprintln!(
            "instruction_sets_do_not_change_a_bit: this machine has the baseline alone, nothing compared"
        );
    }
}

#[test]
fn seeds_change_the_noise_everywhere() {
    let terrain = Terrain::default();
    let grid = terrain.grid(257).unwrap();
    let other = Terrain { seed: 2, ..terrain.clone() };
    for (id, params) in cases().into_iter().filter(|(id, _)| !["constant", "gradient"].contains(id)) {
        let mut params = set(params);
        for size in ["feature_size", "size"] {
            if kind(id).param(size).is_some() {
                params.insert(size.into(), json!(100.0));
            }
        }
        let first = run(id, Json::Object(params.clone()), grid, &terrain);
        let graph_seed = run(id, Json::Object(params.clone()), grid, &other);
        params.insert("seed".into(), json!(1));
        let node_seed = run(id, Json::Object(params.clone()), grid, &terrain);
        for (what, field) in [("graph", graph_seed), ("node", node_seed)] {
            let same = first.data().iter().zip(field.data()).filter(|(a, b)| a == b).count();
            let r = correlation(first.data(), field.data());
            assert!(same < 2000, "{id} {params:?}: {same} samples do not feel the seed of the {what}");
            assert!(r.abs() < 0.06, "{id} {params:?}: correlation {r} under another seed of the {what}");
        }
    }
}

fn correlation(a: &[f32], b: &[f32]) -> f64 {
    let mean = |v: &[f32]| v.iter().map(|&x| f64::from(x)).sum::<f64>() / v.len() as f64;
    let (ma, mb) = (mean(a), mean(b));
    let (mut saa, mut sab, mut sbb) = (0.0, 0.0, 0.0);
    for (&x, &y) in a.iter().zip(b) {
        let (x, y) = (f64::from(x) - ma, f64::from(y) - mb);
        saa += x * x;
        sab += x * y;
        sbb += y * y;
    }
    sab / (saa * sbb).sqrt()
}

/// Values at the ends of a parameter's range.
fn ends(shape: &Shape) -> Vec<Json> {
    let fields = |fields: &[Param], pick: fn(&[Json]) -> Json| {
        let each = fields.iter().map(|f| (f.name.clone(), pick(&ends(&f.shape))));
        Json::Object(each.collect())
    };
    let (first, last) = (|v: &[Json]| v[0].clone(), |v: &[Json]| v[v.len() - 1].clone());
    match shape {
        Shape::Number { min, max, integer: true } => vec![json!(*min as i64), json!(*max as i64)],
        Shape::Number { min, max, integer: false } => vec![json!(min), json!(max)],
        Shape::Choice(modes) => (modes.iter())
            .flat_map(|m| match m.fields.as_slice() {
                [] => vec![json!(m.name)],
                own => vec![
                    json!({ m.name.clone(): fields(own, first) }),
                    json!({ m.name.clone(): fields(own, last) }),
                ],
            })
            .collect(),
        Shape::List { item, min, .. } => ends(item).into_iter().map(|v| Json::Array(vec![v; *min])).collect(),
        other => panic!("a generator has a parameter of shape {other:?}"),
    }
}

#[test]
fn every_end_of_every_range_is_finite() {
    let far =
        |origin: f64| Terrain { origin: [origin, -origin], width: 2e7, depth: 2e7, ..Terrain::default() };
    for terrain in [Terrain::default(), far(1e8), far(-1e8)] {
        let grid = Grid { cols: 37, rows: 5, ..terrain.grid(9).unwrap().grow_cells(4) };
        for id in KINDS {
            let choices: Vec<(String, Vec<Json>)> =
                kind(id).params().iter().map(|p| (p.name.clone(), ends(&p.shape))).collect();
            let total: usize = choices.iter().map(|(_, v)| v.len()).product();
            for case in 0..total {
                let mut rest = case;
                let pick = |(name, values): &(String, Vec<Json>)| {
                    let value = values[rest % values.len()].clone();
                    rest /= values.len();
                    (name.clone(), value)
                };
                let params = Json::Object(choices.iter().map(pick).collect());
                let field = run(id, params.clone(), grid, &terrain);
                assert_eq!(Value::Field(field).first_not_finite(), None, "{id} {params}");
            }
        }
    }
}

// Perlin noise.

/// Textbook Perlin noise in f64 over the slopes of the kit.
fn perlin_reference([col, row]: [u32; 2], [x, y]: [f64; 2]) -> f64 {
    let fade = |t: f64| 6.0 * t.powf(5.0) - 15.0 * t.powf(4.0) + 10.0 * t.powf(3.0);
    let mut sum = 0.0;
    for (i, j) in [(0u32, 0u32), (1, 0), (0, 1), (1, 1)] {
        let [cw, rw] = lattice::spread([col.wrapping_add(i), row.wrapping_add(j)]);
        let slope = lattice::slope(lattice::scramble(cw, rw)).map(f64::from);
        let d = [x - f64::from(i), y - f64::from(j)];
        sum += fade(1.0 - d[0].abs()) * fade(1.0 - d[1].abs()) * (slope[0] * d[0] + slope[1] * d[1]);
    }
    sum * 1.421
}

#[test]
fn perlin_is_what_the_textbook_says() {
    for n in 0..200_u32 {
        let cell = [n.wrapping_mul(0x1357_9bdf), u32::MAX - n];
        for i in 0..=20_u8 {
            for j in 0..=20_u8 {
                let at = [f32::from(i) / 20.0, f32::from(j) / 20.0];
                let (ours, truth) = (lattice::perlin(cell, at), perlin_reference(cell, at.map(f64::from)));
                assert!((f64::from(ours) - truth).abs() < 5e-7, "{cell:?} {at:?}: {ours}, should be {truth}");
            }
        }
        for corner in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            assert_eq!(lattice::perlin(cell, corner), 0.0, "not zero on a corner");
        }
    }
}

#[test]
fn perlin_is_smooth_across_cells() {
    // In f64, so that second differences can be taken; the kernel itself is held to it above. The curvature along x
    // vanishes on the border from both sides, as the quintic has it; the cubic fade would leave up to 6 times a slope.
    let h = 1e-4;
    for n in 0..300_u32 {
        let (here, east) = ([n, 3 * n], [n + 1, 3 * n]);
        let y = f64::from(n) / 300.0;
        let w = |t: f64| perlin_reference(here, [1.0 - t, y]);
        let e = |t: f64| perlin_reference(east, [t, y]);
        assert!((w(0.0) - e(0.0)).abs() < 1e-12);
        let (left, right) = ((w(0.0) - w(h)) / h, (e(h) - e(0.0)) / h);
        assert!((left - right).abs() < 1e-4, "slopes {left} and {right}");
        let (left, right) =
            ((w(0.0) - 2.0 * w(h) + w(2.0 * h)) / h / h, (e(0.0) - 2.0 * e(h) + e(2.0 * h)) / h / h);
        assert!(left.abs() < 0.05 && right.abs() < 0.05, "curvatures {left} and {right}");
    }
}

#[test]
fn slopes_have_no_direction_of_their_own() {
    let (mut sums, mut harmonics) = ([0.0_f64; 5], [0.0_f64; 4]);
    let n = 1 << 20;
    for i in 0..n {
        let [x, y] = lattice::slope((i as u32).wrapping_mul(0x9e37_79b9)).map(f64::from);
        let length = (x * x + y * y).sqrt();
        assert!((0.95..1.01).contains(&length), "length {length}");
        sums = [sums[0] + x, sums[1] + y, sums[2] + x * x, sums[3] + y * y, sums[4] + x * y];
        let angle = libm::atan2(y, x);
        for (h, k) in harmonics.iter_mut().zip([2.0, 4.0, 6.0, 8.0]) {
            *h += libm::cos(k * angle);
        }
    }
    let [mx, my, xx, yy, xy] = sums.map(|s| s / f64::from(n));
    assert!(mx.abs() < 1e-3 && my.abs() < 1e-3 && xy.abs() < 1e-3, "{mx} {my} {xy}");
    assert!((xx - 17.0 / 35.0).abs() < 1e-3 && (yy - 17.0 / 35.0).abs() < 1e-3, "{xx} {yy}");
    for h in harmonics {
        assert!((h / f64::from(n)).abs() < 0.05, "{harmonics:?}");
    }
}

#[test]
fn the_hash_shows_no_lattice() {
    const N: usize = 512;
    let lags = [0, 1, 2, 3, 4, 5, 7, 8, 12, 16, 31, 32, 64, 100, 128];
    for place in [[0, 0], [0x8000_0000, 12_345], [0xffff_ff00, 0xdead_beef]] {
        let cell =
            |i: usize, j: usize| lattice::spread([place[0] + i as u32, place[1].wrapping_add(j as u32)]);
        // Sign bit, and both components of the slope, as ±1 or scaled to variance 1.
        let planes: [Box<dyn Fn(u32) -> f64>; 3] = [
            Box::new(|h| if h >> 31 == 0 { 1.0 } else { -1.0 }),
            Box::new(|h| f64::from(lattice::slope(h)[0]) / (17.0_f64 / 35.0).sqrt()),
            Box::new(|h| f64::from(lattice::slope(h)[1]) / (17.0_f64 / 35.0).sqrt()),
        ];
        for (p, plane) in planes.iter().enumerate() {
            let hash = |i, j| cell(i, j).into();
            let at = |i: usize, j: usize| {
                let [col, row]: [u32; 2] = hash(i, j);
                plane(lattice::scramble(col, row))
            };
            let values: Vec<f64> = (0..N * N).map(|k| at(k % N, k / N)).collect();
            for (dx, dy) in lags.iter().flat_map(|&a| lags.map(|b| (a, b))).skip(1) {
                let mut sum = 0.0;
                for j in 0..N - dy {
                    for i in 0..N - dx {
                        sum += values[j * N + i] * values[(j + dy) * N + i + dx];
                    }
                }
                let sigma = sum / (((N - dx) * (N - dy)) as f64).sqrt();
                assert!(sigma.abs() < 5.5, "plane {p} at {place:?}: {sigma} sigma at lag {dx}, {dy}");
            }
        }
    }
}

/// Runs a fractal on a square of samples.
fn square(noise: &Fractal, n: usize, cell: f64, origin: [f64; 2]) -> Vec<f32> {
    let xs: Vec<f64> = (0..n).map(|i| origin[0] + cell * i as f64).collect();
    let rows = noise.over(&xs);
    let mut data = vec![0.0; n * n];
    for (j, out) in data.chunks_mut(n).enumerate() {
        rows.row(origin[1] + cell * j as f64, out);
    }
    data
}

fn one_octave(size: f64, seed: u64) -> Fractal {
    let spectrum = Spectrum { feature_size: size, octaves: 1, lacunarity: 2.0, gain: 0.5 };
    Fractal::new(Form::Fbm, spectrum, seed, 0.0, 1.0)
}

fn mean_and_variance(data: &[f32]) -> (f64, f64) {
    let n = data.len() as f64;
    let mean = data.iter().map(|&x| f64::from(x)).sum::<f64>() / n;
    (mean, data.iter().map(|&x| (f64::from(x) - mean) * (f64::from(x) - mean)).sum::<f64>() / n)
}

#[test]
fn perlin_has_the_variance_of_theory_and_keeps_its_bound() {
    // Var = 4 · 1.421² · E[g²] · ∫∫ (1 − f(x))² (1 − f(y))² (x² + y²), f the quintic, E[g²] of one component 17/35.
    let (mut squares, mut moments, n) = (0.0, 0.0, 100_000);
    for i in 0..n {
        let x = (f64::from(i) + 0.5) / f64::from(n);
        let rest = 1.0 - x * x * x * (x * (x * 6.0 - 15.0) + 10.0);
        squares += rest * rest / f64::from(n);
        moments += rest * rest * x * x / f64::from(n);
    }
    let theory = 4.0 * 1.421 * 1.421 * (17.0 / 35.0) * 2.0 * squares * moments;
    assert!((theory.sqrt() - 0.302).abs() < 1e-3, "the documented deviation is {}", theory.sqrt());
    for origin in [[0.0, 0.0], [9.9e7, -9.9e7]] {
        let data = square(&one_octave(100.0, 5), 1024, 37.7, origin);
        let (mean, variance) = mean_and_variance(&data);
        assert!(mean.abs() < 0.005, "mean {mean}");
        assert!((variance / theory - 1.0).abs() < 0.02, "variance {variance}, theory {theory}");
        assert!(data.iter().all(|x| x.abs() <= 1.0));
    }
}

#[test]
fn perlin_reaches_nearly_one_and_never_more() {
    // The largest sum for each place in a cell: every corner takes the slope that helps most.
    let slopes: Vec<[f64; 2]> = (0..=1000_u32)
        .map(|i| lattice::slope((i * 2_147_483) & 0x7fff_ffff).map(|v| f64::from(v).abs()))
        .collect();
    let help = |x: f64, y: f64| slopes.iter().map(|g| g[0] * x + g[1] * y).fold(0.0, f64::max);
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let mut best = 0.0_f64;
    for i in 0..=60 {
        for j in 0..=60 {
            let (x, y) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
            let (a, b) = (fade(x), fade(y));
            let north = (1.0 - a) * help(x, y) + a * help(1.0 - x, y);
            let south = (1.0 - a) * help(x, 1.0 - y) + a * help(1.0 - x, 1.0 - y);
            best = best.max((1.0 - b) * north + b * south);
        }
    }
    let bound = best * 1.421;
    assert!((0.999..=1.0).contains(&bound), "largest value {bound}");
}

#[test]
fn directions_are_alike_over_seeds() {
    // Mean square differences at a distance of half a cell, in eight directions.
    let mut sums = [0.0_f64; 8];
    for seed in 0..60 {
        let noise = one_octave(100.0, seed);
        let n = 64;
        let xs: Vec<f64> = (0..n).map(|i| f64::from(i) * 71.3).collect();
        for (k, sum) in sums.iter_mut().enumerate() {
            let (sin, cos) = libm::sincos(k as f64 * std::f64::consts::PI / 8.0);
            let shifted: Vec<f64> = xs.iter().map(|x| x + 50.0 * cos).collect();
            let (here, there) = (noise.over(&xs), noise.over(&shifted));
            let (mut a, mut b) = (vec![0.0; xs.len()], vec![0.0; xs.len()]);
            for j in 0..n {
                let y = f64::from(j) * 71.3;
                here.row(y, &mut a);
                there.row(y + 50.0 * sin, &mut b);
                *sum += a.iter().zip(&b).map(|(a, b)| f64::from((a - b) * (a - b))).sum::<f64>();
            }
        }
    }
    let mean = sums.iter().sum::<f64>() / 8.0;
    for (k, sum) in sums.iter().enumerate() {
        assert!((sum / mean - 1.0).abs() < 0.03, "direction {k}: {sums:?}");
    }
}

#[test]
fn the_far_plane_is_as_smooth_as_the_near() {
    // Features of 0.1 m at 1e8 m: a step of 1 mm is a hundredth of a cell, whose largest slope is about 3 per cell.
    let noise = one_octave(0.1, 3);
    for origin in [[0.0, 0.0], [1e8, -1e8], [-1e8, 1e8]] {
        let data = square(&noise, 512, 0.001, origin);
        let steps = data.chunks(512).flat_map(|row| row.windows(2).map(|w| (w[1] - w[0]).abs()));
        let (most, sum) = steps.fold((0.0_f32, 0.0_f64), |(m, s), d| (m.max(d), s + f64::from(d)));
        assert!(most < 0.04, "a jump of {most} near {origin:?}");
        assert!(sum / (512.0 * 511.0) > 0.002, "no relief near {origin:?}");
    }
    // Further than positions can be told apart the noise is still finite and bounded.
    for origin in [[1e15, 1e15], [-1e300, 1e200]] {
        let spectrum = Spectrum { feature_size: 0.1, octaves: 16, lacunarity: 4.0, gain: 1.0 };
        let noise = Fractal::new(Form::Fbm, spectrum, 1, 0.0, 1.0);
        assert!(square(&noise, 16, 1.0, origin).iter().all(|x| x.abs() <= 1.0), "near {origin:?}");
    }
}

// The fractals against their formulas.

/// Noise of every octave at a point, from the parts that are tested above.
fn octaves(spectrum: Spectrum, seed: u64, [x, y]: [f64; 2]) -> Vec<f64> {
    let mut size = spectrum.feature_size;
    let mut all = Vec::new();
    for k in 0..spectrum.octaves {
        let turned = lattice::Turned::new(size, orograph::kit::hash::nth(seed, u64::from(k)));
        let (cell, at) = turned.locate(x, y);
        all.push(perlin_reference(cell, at.map(f64::from)));
        size /= spectrum.lacunarity;
    }
    all
}

#[test]
fn fractals_are_what_their_formulas_say() {
    let spectrum = Spectrum { feature_size: 1000.0, octaves: 6, lacunarity: 2.3, gain: 0.6 };
    let xs: Vec<f64> = (0..301).map(|i| f64::from(i) * 13.7 - 1500.0).collect();
    let roughness: Vec<f32> = (0..301_u16).map(|i| f32::from(i) / 200.0 - 0.25).collect();
    let gain = |k: usize| (0..k).fold(1.0, |w, _| w * 0.6);
    let sum: f64 = (0..6).map(gain).sum();
    for form in forms() {
        let noise = Fractal::new(form, spectrum, 42, 5.0, 100.0);
        let mut out = vec![0.0; xs.len()];
        for y in [-800.0, 0.0, 4321.0] {
            noise.over(&xs).rough_row(y, &roughness, &mut out);
            for ((&x, &r), &ours) in xs.iter().zip(&roughness).zip(&out) {
                let n = octaves(spectrum, 42, [x, y]);
                let parts = match form {
                    Form::Fbm => n.iter().enumerate().map(|(k, n)| gain(k) * n).sum::<f64>() / sum,
                    Form::Billow { .. } => {
                        n.iter().enumerate().map(|(k, n)| gain(k) * n.abs()).sum::<f64>() / sum
                    }
                    Form::Ridged { sharpness, focus } => {
                        let width = 1.0 - f64::from(sharpness);
                        let round = |a: f64| if a < width { a * a / (2.0 * width) } else { a - width / 2.0 };
                        let (mut result, mut weight) = (0.0, 1.0);
                        for (k, n) in n.iter().enumerate() {
                            let crest = 1.0 - round(n.abs());
                            let signal = crest * crest * weight;
                            result += signal * gain(k);
                            weight = (signal * f64::from(focus)).clamp(0.0, 1.0);
                        }
                        result / sum
                    }
                    Form::Hybrid { base } => {
                        let (mut result, mut weight) = (0.0, 1.0);
                        for (k, n) in n.iter().enumerate() {
                            let signal = (n + f64::from(base)) * weight;
                            result += signal * gain(k);
                            weight = signal.clamp(0.0, 1.0);
                        }
                        result / sum / (1.0 + f64::from(base))
                    }
                    Form::Rough => {
                        let r = f64::from(r).clamp(0.0, 1.0);
                        let scaled =
                            n.iter().enumerate().map(|(k, n)| libm::pow(2.3, -(k as f64) * (1.0 - r)) * n);
                        scaled.sum()
                    }
                };
                let truth = 5.0 + 100.0 * parts;
                assert!(
                    (f64::from(ours) - truth).abs() < 3e-3,
                    "{form:?} at {x}, {y}: {ours}, should be {truth}"
                );
            }
        }
    }
}

#[test]
fn fractals_keep_their_bounds() {
    for gain in [0.0, 0.5, 1.0] {
        let spectrum = Spectrum { feature_size: 50.0, octaves: 6, lacunarity: 2.0, gain };
        for (form, low, high) in [
            (Form::Fbm, -1.0, 1.0),
            (Form::Billow { sharpness: 1.0 }, 0.0, 1.0),
            (Form::Ridged { sharpness: 1.0, focus: 8.0 }, 0.0, 1.0),
            (Form::Hybrid { base: 0.7 }, -0.3 / 1.7, 1.0),
            (Form::Hybrid { base: 0.0 }, -1.0, 1.0),
        ] {
            let data = square(&Fractal::new(form, spectrum, 8, 0.0, 1.0), 512, 9.1, [0.0, 0.0]);
            let (lo, hi) = data.iter().fold((f32::MAX, f32::MIN), |(lo, hi), &x| (lo.min(x), hi.max(x)));
            assert!(lo >= low - 1e-6 && hi <= high + 1e-6, "{form:?} gain {gain}: {lo} to {hi}");
            assert!(
                hi - lo > 0.4 * (high - low).min(1.0),
                "{form:?} gain {gain} has no relief: {lo} to {hi}"
            );
        }
    }
}

#[test]
fn multifractal_follows_its_fields() {
    let terrain = Terrain::default();
    let grid = terrain.grid(129).unwrap();
    let plain = run("multifractal", json!({"amplitude": 80.0, "roughness": 0.25}), grid, &terrain);
    let larger = grid.grow_cells(3);
    let wires = |amplitude: Field, roughness: Field| -> Wires {
        [("amplitude", Value::Field(amplitude)), ("roughness", Value::Field(roughness))].into_iter().collect()
    };
    // Constant fields are the parameters, to the bit, and override them.
    let amplitude = Field::constant(larger, Quantity::Length, 80.0);
    let roughness = Field::constant(larger, Quantity::Mask, 0.25);
    let other = json!({"amplitude": 1.0, "roughness": 1.0});
    let by_fields =
        run_with("multifractal", other.clone(), grid, &terrain, wires(amplitude, roughness.clone()));
    assert_same_bits(&plain, &by_fields, "constant fields");
    // Amplitude scales, sample by sample.
    let ramp = Field::from_fn(larger, Quantity::Length, |x, _| (x / 64.0) as f32);
    let scaled = run_with("multifractal", other, grid, &terrain, wires(ramp.clone(), roughness));
    for row in 0..129 {
        for col in 0..129 {
            let want = plain.at(col, row) / 80.0 * ramp.at(col, row);
            assert!((scaled.at(col, row) - want).abs() < 1e-3 * (1.0 + want.abs()));
        }
    }
    // Huge amplitudes stay finite.
    let huge = Field::constant(grid, Quantity::Length, f32::MAX);
    let rough = Field::constant(grid, Quantity::Mask, -f32::MAX);
    let field = run_with("multifractal", json!({"octaves": 16}), grid, &terrain, wires(huge, rough));
    assert_eq!(Value::Field(field).first_not_finite(), None);
}

// Cellular noise against brute force.

fn metrics_and_measures() -> Vec<(Metric, Measure)> {
    let measures = [Measure::F1, Measure::F2, Measure::F2MinusF1, Measure::CellValue];
    [Metric::Euclidean, Metric::Manhattan, Metric::Chebyshev]
        .into_iter()
        .flat_map(|metric| measures.map(|measure| (metric, measure)))
        .collect()
}

/// Distances to all points of 9 × 9 cells around a place, sorted, with the cell each is in.
fn distances(noise: &Worley, metric: Metric, x: f64, y: f64) -> Vec<(f64, [u32; 2])> {
    let (cell, at) = noise.lattice().locate(x, y);
    let mut all = Vec::new();
    for (i, j) in (-4..=5).flat_map(|i| (-4..=5).map(move |j| (i, j))) {
        let near = [cell[0].wrapping_add(i as u32), cell[1].wrapping_add(j as u32)];
        let (point, _) = noise.point(near);
        let dx = (f64::from(i) + f64::from(point[0]) - f64::from(at[0])).abs();
        let dy = (f64::from(j) + f64::from(point[1]) - f64::from(at[1])).abs();
        let d = match metric {
            Metric::Euclidean => (dx * dx + dy * dy).sqrt(),
            Metric::Manhattan => dx + dy,
            Metric::Chebyshev => dx.max(dy),
        };
        all.push((d, near));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

#[test]
fn cells_are_those_of_brute_force() {
    let xs: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.37 - 40.0).collect();
    for jitter in [0.0, 0.5, 1.0] {
        for (metric, measure) in metrics_and_measures() {
            let noise = Worley::new(1.7, jitter, 11, 0.0, 1.0).measured(metric, measure);
            let rows = noise.over(&xs);
            let mut out = vec![0.0; xs.len()];
            for y in (0..200).map(|j| f64::from(j) * 0.41) {
                rows.row(y, &mut out);
                for (&x, &ours) in xs.iter().zip(&out) {
                    let found = distances(&noise, metric, x, y);
                    let truth = match measure {
                        Measure::F1 => found[0].0,
                        Measure::F2 => found[1].0,
                        Measure::F2MinusF1 => found[1].0 - found[0].0,
                        Measure::CellValue => continue,
                    };
                    assert!(
                        (f64::from(ours) - truth).abs() < 2e-6,
                        "{metric:?} {measure:?} jitter {jitter} at {x}, {y}: {ours}, should be {truth}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_worst_places_of_points_are_searched() {
    // Random points seldom stand at their worst. Here every point stands as far away as its square allows: the cell
    // is needed if its nearest possible point can still beat the farthest possible ones of all others.
    type Length = fn(f64, f64) -> f64;
    let metrics: [Length; 3] = [|x, y| (x * x + y * y).sqrt(), |x, y| x + y, f64::max];
    let ring =
        [(0, 0), (1, 0), (0, 1), (1, 1), (0, -1), (1, -1), (-1, 0), (2, 0), (-1, 1), (2, 1), (0, 2), (1, 2)];
    let outer = [(-1, -1), (2, -1), (-1, 2), (2, 2)];
    let far = [(0, -2), (1, -2), (-2, 0), (3, 0), (-2, 1), (3, 1), (0, 3), (1, 3)];
    let span = |f: f64, k: i32| {
        let (lo, hi) = (f64::from(k) - 0.5 - f, f64::from(k) + 0.5 - f);
        let near = if lo <= 0.0 && hi >= 0.0 { 0.0 } else { lo.abs().min(hi.abs()) };
        (near, lo.abs().max(hi.abs()))
    };
    for (metric, (i, j)) in
        metrics.iter().flat_map(|m| (0..=40).flat_map(move |i| (0..=40).map(move |j| (m, (i, j)))))
    {
        let (x, y) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
        let cells = (-3..=4).flat_map(|i| (-3..=4).map(move |j| (i, j)));
        let reach: Vec<_> = cells
            .map(|(i, j)| {
                let ((nx, fx), (ny, fy)) = (span(x, i), span(y, j));
                ((i, j), metric(nx, ny), metric(fx, fy))
            })
            .collect();
        let mut farthest: Vec<f64> = reach.iter().map(|r| r.2).collect();
        farthest.sort_by(f64::total_cmp);
        for (cell, nearest, _) in reach {
            if nearest < farthest[0] - 1e-9 {
                assert!(ring.contains(&cell), "{cell:?} can hold the nearest point of {x}, {y}");
            }
            if nearest < farthest[1] - 1e-9 {
                let searched = ring.contains(&cell) || outer.contains(&cell) || far.contains(&cell);
                assert!(searched, "{cell:?} can hold the second nearest point of {x}, {y}");
            }
        }
    }
}

#[test]
fn cell_values_are_one_number_a_cell() {
    let xs: Vec<f64> = (0..600).map(|i| f64::from(i) * 0.21).collect();
    let noise = Worley::new(3.0, 1.0, 2, 0.0, 1.0).measured(Metric::Euclidean, Measure::CellValue);
    let rows = noise.over(&xs);
    let mut out = vec![0.0; xs.len()];
    let mut seen = std::collections::BTreeMap::new();
    for y in (0..600).map(|j| f64::from(j) * 0.21) {
        rows.row(y, &mut out);
        for (&x, &value) in xs.iter().zip(&out) {
            let found = distances(&noise, Metric::Euclidean, x, y);
            if found[1].0 - found[0].0 > 1e-5 {
                assert_eq!(*seen.entry(found[0].1).or_insert(value), value, "cell {:?}", found[0].1);
            }
        }
    }
    assert!(seen.len() > 1500, "{} cells", seen.len());
    let values: Vec<f32> = seen.values().copied().collect();
    let (mean, variance) = mean_and_variance(&values);
    assert!((mean - 0.5).abs() < 0.03 && (variance - 1.0 / 12.0).abs() < 0.01, "{mean} {variance}");
    assert!(values.iter().all(|v| (0.0..=1.0).contains(v)));
}

// Gradients.

#[test]
fn gradients_have_their_profiles() {
    let terrain = Terrain { origin: [100.0, 50.0], width: 4000.0, depth: 2000.0, ..Terrain::default() };
    let grid = terrain.grid(401).unwrap();
    // 10 m a cell; the middle of the terrain is column 200, row 100.
    let at = |form: Json, col: i64, row: i64| {
        let params = json!({"form": form, "centre": [-100.0, 50.0], "foot": 20.0, "top": 120.0});
        f64::from(run("gradient", params, grid, &terrain).at(col, row))
    };
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-4, "{a}, should be {b}");
    let ramp = |direction: f64| json!({"linear": {"direction": direction, "length": 400.0}});
    close(at(ramp(0.0), 190, 105), 70.0);
    close(at(ramp(0.0), 7, 95), 95.0); // 100 m north of the centre
    close(at(ramp(90.0), 200, 3), 95.0); // 100 m east
    close(at(ramp(225.0), 180, 105), 70.0 + 25.0 * std::f64::consts::FRAC_1_SQRT_2 * 2.0);
    close(at(ramp(90.0), 0, 0), 20.0);
    close(at(ramp(90.0), 400, 0), 120.0);
    for (form, profile) in [
        ("radial", [120.0, 20.0 + 100.0 * (1.0 - 3.0 * 0.0625 + 2.0 * 0.015_625), 70.0, 20.0]),
        ("cone", [120.0, 95.0, 70.0, 20.0]),
        ("dome", [120.0, 20.0 + 100.0 * 0.9375_f64.sqrt(), 20.0 + 100.0 * 0.75_f64.sqrt(), 20.0]),
    ] {
        let form = json!({form: {"radius": 200.0}});
        for (i, want) in profile.into_iter().enumerate() {
            let d = [0, 5, 10, 20][i];
            close(at(form.clone(), 190 + d, 105), want);
            close(at(form.clone(), 190, 105 - d), want);
        }
        close(at(form, 300, 5), 20.0);
    }
}

#[test]
fn modes_need_only_the_fields_that_differ() {
    let terrain = Terrain::default();
    let lattice = Lattice { origin: [0.0, 0.0], span: 8192.0, intervals: 64 };
    let grid = Grid { lattice, col: -3, row: 2, cols: 40, rows: 3 };
    let short = run("fractal_noise", json!({"form": {"ridged": {}}}), grid, &terrain);
    let long =
        run("fractal_noise", json!({"form": {"ridged": {"sharpness": 1.0, "focus": 2.0}}}), grid, &terrain);
    assert_same_bits(&short, &long, "ridged");
    let bad = kind("fractal_noise").parse(&set(json!({"form": {"ridged": {"focus": 9.0}}}))).unwrap_err();
    assert!(bad.to_string().contains("from 0 to 8, got 9"), "{bad}");
    let bad = kind("fractal_noise").parse(&set(json!({"octaves": 1e9 as i64}))).unwrap_err();
    assert!(bad.to_string().contains("from 1 to 16"), "{bad}");
    let _: noise::Form = orograph::nodes::generate::fractal_noise::Form::Fbm.into();
}
