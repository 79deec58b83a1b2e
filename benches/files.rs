//! What a user waits for: height files written and read. `../shared/peers.md` has GDAL's times for PNG of 16 bits:
//! 0.43, 1.0 and 2.4 s for 1024², 2048² and 4096².

use std::io::Cursor;

use divan::counter::{BytesCount, ItemsCount};
use divan::{Bencher, bench, black_box};
use orograph::files::{
    Format, Limits, Reading, Relief, Request, WriteJob, Writing, encode, fill_voids, read_height,
};
use orograph::value::{Field, Grid, Lattice, Quantity, Terrain, Value};
use orograph::work::Work;

fn main() {
    divan::main();
}

const SIZES: [usize; 3] = [1024, 2048, 4096];
const SIZE: usize = 2048;

/// Hills of eight octaves, in the manner of noise on a lattice: neither too smooth nor too rough to press.
fn hills(size: usize) -> Value {
    let lattice = Lattice { origin: [0.0, 0.0], span: 8192.0, intervals: size as u32 - 1 };
    let grid = Grid { lattice, col: 0, row: 0, cols: size, rows: size };
    let corner = |o: u64, i: i64, j: i64| {
        orograph::kit::hash::unit(o, ((i as u64) << 32) ^ (j as u64 & 0xffff_ffff)) - 0.5
    };
    let octave = |o: u32, x: f64, y: f64| {
        let f = f64::from(1u32 << o) / 4096.0;
        let (u, v) = (x * f, y * f);
        let (i, j) = (u.floor() as i64, v.floor() as i64);
        let ease = |t: f64| t * t * (3.0 - 2.0 * t);
        let (s, t) = (ease(u - u.floor()), ease(v - v.floor()));
        let line = |j: i64| {
            let (a, b) = (corner(o.into(), i, j), corner(o.into(), i + 1, j));
            a + (b - a) * s
        };
        let (a, b) = (line(j), line(j + 1));
        (a + (b - a) * t) * 1500.0 / f64::from(1u32 << o)
    };
    let height = |x: f64, y: f64| (1000.0 + (0..8).map(|o| octave(o, x, y)).sum::<f64>()) as f32;
    Value::Field(Field::from_fn(grid, Quantity::Elevation, height))
}

fn written(value: &Value, format: Format) -> (Vec<u8>, Option<Vec<u8>>) {
    let terrain = Terrain::default();
    let writing = Writing { range: Some([-500.0, 2500.0]), ..format.into() };
    let job = WriteJob::new(value, writing, &terrain, *value.grid().expect("a raster"));
    let mut out = Cursor::new(Vec::new());
    let written = encode(&job, &mut out).expect("writes");
    (out.into_inner(), written.sidecar.map(|j| j.to_string().into_bytes()))
}

fn write(bencher: Bencher<'_, '_>, size: usize, format: Format) {
    let value = hills(size);
    let bytes = written(&value, format).0.len();
    eprintln!("{format} {size}²: {:.2} bytes a sample", bytes as f64 / (size * size) as f64);
    bencher.counter(ItemsCount::new(size * size)).bench_local(|| written(black_box(&value), format));
}

#[bench(args = SIZES, sample_count = 5)]
fn write_png16(bencher: Bencher<'_, '_>, size: usize) {
    write(bencher, size, Format::Png16);
}

#[bench(args = SIZES, sample_count = 5)]
fn write_tiff(bencher: Bencher<'_, '_>, size: usize) {
    write(bencher, size, Format::Tiff);
}

#[bench(args = SIZES, sample_count = 5)]
fn write_tiff16(bencher: Bencher<'_, '_>, size: usize) {
    write(bencher, size, Format::Tiff16);
}

#[bench(args = SIZES, sample_count = 5)]
fn write_exr(bencher: Bencher<'_, '_>, size: usize) {
    write(bencher, size, Format::Exr);
}

#[bench(args = [SIZE], sample_count = 5)]
fn write_asc(bencher: Bencher<'_, '_>, size: usize) {
    write(bencher, size, Format::Asc);
}

#[bench(args = Format::of_samples(), sample_count = 5)]
fn read(bencher: Bencher<'_, '_>, format: Format) {
    let (bytes, sidecar) = written(&hills(SIZE), format);
    let name = format!("a.{}", format.extension());
    bencher.counter(ItemsCount::new(SIZE * SIZE)).bench_local(|| {
        read_height(&name, black_box(&bytes), sidecar.as_deref(), &Limits::default()).expect("reads")
    });
}

#[bench(sample_count = 5)]
fn import_cubic(bencher: Bencher<'_, '_>) {
    let (bytes, _) = written(&hills(SIZE), Format::Tiff);
    let closing = orograph::files::Closing::Smooth;
    let reading = Reading::default();
    let request = Request { name: "a.tif", companions: &[], reading: &reading, closing, cubic: true };
    bencher.bench_local(|| {
        Relief::new(black_box(&request), &bytes, &Limits::default(), Work::default()).expect("reads")
    });
}

/// Half of the samples void: a coast.
#[bench(sample_count = 5)]
fn fill_half(bencher: Bencher<'_, '_>) {
    let value = hills(SIZE);
    let holes = |v: &f32| if *v < 1000.0 { f32::NAN } else { *v };
    let data: Vec<f32> = value.components().iter().map(holes).collect();
    bencher
        .counter(BytesCount::of_slice(&data))
        .with_inputs(|| data.clone())
        .bench_local_values(|mut data| fill_voids(SIZE, SIZE, &mut data));
}
