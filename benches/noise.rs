//! How fast noise is made: samples a second of the generators, on each instruction set, on one thread and on all.

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use orograph::kit::noise::{Form, Fractal, Measure, Metric, Spectrum, Worley};
use orograph::kit::simd::Level;
use orograph::node::{Cancel, Context, Node};
use orograph::nodes::generate;
use orograph::value::{Grid, Terrain};

fn main() {
    divan::main();
}

/// Samples along a side of the fields.
const SIZE: u32 = 1025;

fn grid() -> Grid {
    Terrain::default().grid(SIZE).expect("a size that fits")
}

fn levels() -> Vec<Level> {
    Level::available()
}

fn fractal(form: Form, octaves: u32) -> Fractal {
    let spectrum = Spectrum { feature_size: 2000.0, octaves, lacunarity: 2.0, gain: 0.5 };
    Fractal::new(form, spectrum, 1, 0.0, 600.0)
}

/// Times `row(y, out)` over all rows of the grid on this thread.
fn rows(bencher: Bencher<'_, '_>, row: impl Fn(f64, &mut [f32])) {
    let grid = grid();
    let mut out = vec![0.0; grid.cols];
    bencher.counter(ItemsCount::new(grid.len())).bench_local(|| {
        for j in 0..grid.rows {
            row(grid.y(j), black_box(&mut out));
        }
    });
}

mod one_thread {
    use super::*;

    fn run(bencher: Bencher<'_, '_>, level: Level, form: Form, octaves: u32) {
        let noise = fractal(form, octaves);
        let prepared = noise.over(&grid().xs()).on(level);
        rows(bencher, |y, out| prepared.row(y, out));
    }

    fn run_cells(bencher: Bencher<'_, '_>, level: Level, metric: Metric, measure: Measure) {
        let noise = Worley::new(500.0, 1.0, 1, 0.0, 300.0).measured(metric, measure);
        let prepared = noise.over(&grid().xs()).on(level);
        rows(bencher, |y, out| prepared.row(y, out));
    }

    #[divan::bench(args = levels())]
    fn perlin(bencher: Bencher<'_, '_>, level: Level) {
        run(bencher, level, Form::Fbm, 1);
    }

    #[divan::bench(args = levels())]
    fn fbm_8(bencher: Bencher<'_, '_>, level: Level) {
        run(bencher, level, Form::Fbm, 8);
    }

    #[divan::bench(args = levels())]
    fn ridged_8(bencher: Bencher<'_, '_>, level: Level) {
        run(bencher, level, Form::Ridged { sharpness: 1.0, focus: 2.0 }, 8);
    }

    #[divan::bench(args = levels())]
    fn hybrid_8(bencher: Bencher<'_, '_>, level: Level) {
        run(bencher, level, Form::Hybrid { base: 0.7 }, 8);
    }

    #[divan::bench(args = levels())]
    fn rough_8(bencher: Bencher<'_, '_>, level: Level) {
        run(bencher, level, Form::Rough, 8);
    }

    #[divan::bench(args = levels())]
    fn cellular_f1(bencher: Bencher<'_, '_>, level: Level) {
        run_cells(bencher, level, Metric::Euclidean, Measure::F1);
    }

    #[divan::bench(args = levels())]
    fn cellular_f2_minus_f1(bencher: Bencher<'_, '_>, level: Level) {
        run_cells(bencher, level, Metric::Euclidean, Measure::F2MinusF1);
    }
}

mod all_threads {
    use super::*;

    /// Times a node as the engine runs it, the field allocated each time.
    fn run<N: Node>(bencher: Bencher<'_, '_>, node: &N, inputs: impl Fn() -> N::In + Sync) {
        let (world, cancel) = (Terrain::default(), Cancel::default());
        let cx = Context::bare(grid(), &world, &cancel);
        bencher
            .counter(ItemsCount::new(grid().len()))
            .bench_local(|| node.run(&cx, inputs()).expect("a generator runs"));
    }

    #[divan::bench]
    fn perlin(bencher: Bencher<'_, '_>) {
        use generate::fractal_noise::{FractalNoise, Inputs};
        run(bencher, &FractalNoise { octaves: 1, ..FractalNoise::default() }, || Inputs {});
    }

    #[divan::bench]
    fn fbm_8(bencher: Bencher<'_, '_>) {
        use generate::fractal_noise::{FractalNoise, Inputs};
        run(bencher, &FractalNoise::default(), || Inputs {});
    }

    #[divan::bench]
    fn cellular_f1(bencher: Bencher<'_, '_>) {
        use generate::cellular_noise::{CellularNoise, Inputs};
        run(bencher, &CellularNoise::default(), || Inputs {});
    }
}
