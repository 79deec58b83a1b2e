//! Tests of: files.

mod budgets;
mod cases;
mod crates;
mod dem;
mod field;
mod foreign;
mod hostile;
mod import;
mod pictures;
mod round_trip;
mod stop;
mod table;
pub(crate) mod tiffs;

use orograph::files::{HeightFile, Limits, WriteJob, Writing, encode, read_height};
use orograph::value::{Field, Grid, Lattice, Quantity, Terrain, Value};

/// A window from the north-west corner of a lattice of some cell.
pub(crate) fn grid(cols: usize, rows: usize, cell: f64) -> Grid {
    let lattice = Lattice { origin: [0.0, 0.0], span: cell * 1024.0, intervals: 1024 };
    Grid { lattice, col: 0, row: 0, cols, rows }
}

/// A height field of some samples.
pub(crate) fn heights(cols: usize, rows: usize, f: impl Fn(usize) -> f32) -> Value {
    let data = (0..cols * rows).map(f).collect();
    Value::Field(Field::new(grid(cols, rows, 10.0), Quantity::Elevation, data))
}

/// Writes a job into memory: the bytes, and what goes into the sidecar.
pub(crate) fn write(job: &WriteJob<'_>) -> (Vec<u8>, Option<Vec<u8>>) {
    let mut out = std::io::Cursor::new(Vec::new());
    let written = encode(job, &mut out).expect("writes");
    (out.into_inner(), written.sidecar.map(|j| j.to_string().into_bytes()))
}

/// Writes a job and reads it back.
pub(crate) fn there_and_back(job: &WriteJob<'_>) -> HeightFile {
    let (bytes, sidecar) = write(job);
    let name = format!("a.{}", job.writing.format.extension());
    read_height(&name, &bytes, sidecar.as_deref(), &Limits::default()).expect("reads")
}

/// A job for a value on a terrain of 10 km.
pub(crate) fn job<'a>(
    value: &'a Value,
    writing: impl Into<Writing<'a>>,
    terrain: &'a Terrain,
) -> WriteJob<'a> {
    WriteJob::new(value, writing, terrain, *value.grid().expect("a raster"))
}
