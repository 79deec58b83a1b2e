//! One output of a build: from a value on a tile to files and an entry of the report.

use std::io::Write;

use cap_std::fs::Dir;
use serde_json::{Value as Json, json};
use sha2::{Digest, Sha256};

use super::exit::{Exit, Stop};
use crate::engine::Want;
use crate::files::{Format, Target, WriteJob, Writing, encode, sidecar_name, writer_cost};
use crate::graph::{Graph, Output, Place, Problem, Source};
use crate::value::{Grid, Quantity, Terrain, Value};
use crate::whole::{self, Known};

/// A part of the window that is built at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    pub place: crate::files::Tile,
    pub grid: Grid,
}

/// An output that is to be written to a file.
#[derive(Debug)]
pub(super) struct Job {
    pub name: String,
    pub source: Source,
    output: Output,
    target: Option<Target>,
    format: Format,
    range: Option<[f64; 2]>,
    quantity: Quantity,
    channels: usize,
}

/// The settings that all files of a build share.
#[derive(Clone, Copy)]
pub(super) struct Common<'a> {
    /// Whether the terrain is cut into tiles.
    pub cut: bool,
    pub terrain: &'a Terrain,
    /// The grid of the whole terrain.
    pub whole: Grid,
    pub graph_key: &'a str,
    pub folder: &'a Dir,
}

/// A written file: its entry in the report.
pub(super) struct Entry {
    pub json: Json,
    pub notes: Vec<String>,
    /// The estimated seconds of writing.
    pub planned_seconds: f64,
}

/// The jobs of outputs, and the outputs whose source does not resolve.
pub(super) fn jobs(
    graph: &Graph,
    names: &[String],
    format: Option<Format>,
    problems: &[Problem],
) -> (Vec<Job>, Vec<(String, Problem)>) {
    let (mut jobs, mut broken) = (Vec::new(), Vec::new());
    let quantities = graph.quantities();
    for (name, output) in graph.outputs().filter(|(n, _)| names.iter().any(|m| m == n)) {
        match source_of(graph, name, problems) {
            Ok(source) => {
                let quantity = quantities.get(graph, &source);
                jobs.push(Job::new(graph, name, output, (source, quantity), format));
            }
            Err(problem) => broken.push((name.to_owned(), problem)),
        }
    }
    (jobs, broken)
}

/// The message about an output whose source does not resolve.
pub(super) fn said_of(problem: Problem) -> String {
    match &problem.place {
        Place::Output(_) => problem.message,
        _ => problem.to_string(),
    }
}

/// The source of an output, where no problem of the graph stops it. A build thus stops at every error that `check`
/// reports about the output.
pub(super) fn source_of(graph: &Graph, name: &str, problems: &[Problem]) -> Result<Source, Problem> {
    let source = graph.output_source(name)?;
    let upstream = graph.upstream(source.node);
    problems.iter().find(|p| p.stops(name, &upstream)).map_or(Ok(source), |p| Err(p.clone()))
}

impl Job {
    fn new(
        graph: &Graph,
        name: &str,
        output: &Output,
        (source, quantity): (Source, Option<Quantity>),
        format: Option<Format>,
    ) -> Self {
        let quantity = quantity.unwrap_or(Quantity::Number);
        Self {
            name: name.to_owned(),
            target: output.target,
            format: format.unwrap_or_else(|| output.format_for(quantity)),
            range: output.range,
            output: output.clone(),
            quantity,
            channels: graph.wire_type(&source).map_or(1, |wire| wire.channels()),
            source,
        }
    }

    /// The want of the output on a grid.
    pub(super) fn want(&self, grid: Grid) -> Want {
        Want { node: self.source.node, port: self.source.port.clone(), grid }
    }

    /// Estimated seconds of writing the output on a grid, on one core.
    pub(super) fn writing_seconds(&self, grid: &Grid) -> f64 {
        writer_cost(self.format, [grid.cols, grid.rows], self.channels, 1).seconds
    }

    /// The entry of the output in a plan.
    pub(super) fn planned(&self, grid: &Grid, effective_cell: Option<f64>) -> Json {
        json!({
            "name": self.name, "cols": grid.cols, "rows": grid.rows, "effective_cell": effective_cell,
            "format": self.format.name(), "quantity": self.quantity.name(), "unit": self.quantity.unit(),
        })
    }

    /// The format and the quantity as text, such as `exr, elevation in m`.
    pub(super) fn summary(&self) -> String {
        format!("{}, {}", self.format.name(), self.quantity.described())
    }

    /// Whether integers are written and their range is not set.
    pub(super) fn needs_range(&self) -> bool {
        let own = matches!(
            self.quantity,
            Quantity::Mask | Quantity::Direction | Quantity::Slope | Quantity::Color | Quantity::Vector
        );
        self.format.is_integer() && self.range.is_none() && !own
    }

    /// Takes the range from the base grid, a tenth wider each way since finer grids reach a little further.
    pub(super) fn take_range(&mut self, base: &Value) {
        let Value::Field(field) = base else { return };
        let (lo, hi) = field.range().map_or((0.0, 1.0), |(lo, hi)| (f64::from(lo), f64::from(hi)));
        let margin = ((hi - lo) * 0.1).max(1.0);
        let (lo, hi) = ((lo - margin).floor(), (hi + margin).ceil());
        self.range = Some(self.target.map_or([lo, hi], |t| t.range([lo, hi])));
    }

    fn stem(&self, tile: &Tile, cut: bool) -> String {
        if cut { format!("{}_x{}_y{}", self.name, tile.place.col, tile.place.row) } else { self.name.clone() }
    }

    fn file(&self, tile: &Tile, cut: bool) -> String {
        format!("{}.{}", self.stem(tile, cut), self.format.extension())
    }

    /// The names of the files of a tile.
    pub(super) fn files(&self, tile: &Tile, cut: bool) -> Vec<String> {
        let file = self.file(tile, cut);
        let sidecar = self.format.has_sidecar(self.channels).then(|| sidecar_name(&file));
        sidecar.into_iter().chain([file]).collect()
    }

    /// The name of the file of a tile, where it has a sidecar.
    pub(super) fn with_sidecar(&self, tile: &Tile, cut: bool) -> Option<String> {
        self.format.has_sidecar(self.channels).then(|| self.file(tile, cut))
    }

    /// Writes the value of a tile, whole or not at all.
    pub(super) fn write(&self, value: &Value, tile: &Tile, to: &Common<'_>) -> Result<Entry, Stop> {
        let Common { cut, terrain, whole, graph_key, folder } = *to;
        let file = self.file(tile, cut);
        let writing = Writing {
            file: &file,
            range: self.range,
            clip: self.output.clip,
            flip: self.output.flip || self.target.is_some_and(Target::flip),
            target: self.target,
            ..self.format.into()
        };
        let job = WriteJob {
            tile: cut.then_some(tile.place),
            graph_key: Some(graph_key),
            ..WriteJob::new(value, writing, terrain, whole)
        };
        let (stamp, written) = whole::write_stamped(folder, &file, |out| encode(&job, out))
            .map_err(|e| Stop::new(Exit::Failed, e))?;
        let notes = written.notes;
        let sidecar = written.sidecar.as_ref().map(|_| sidecar_name(&file));
        if let Some(sidecar) = &written.sidecar {
            let text = format!("{sidecar:#}\n");
            whole::write(folder, sidecar_name(&file), Known::Anything, |out| out.write_all(text.as_bytes()))
                .map_err(|e: std::io::Error| {
                    Stop::new(Exit::Failed, format!("cannot write the sidecar of {file}: {e}"))
                })?;
        }
        let range = match value {
            Value::Field(f) => f.range(),
            _ => None,
        };
        let grid = tile.grid;
        let json = json!({
            "name": self.name, "path": file, "format": self.format.name(), "bytes": stamp.bytes,
            "sha256": stamp.sha256, "samples_sha256": samples_sha256(value),
            "cols": grid.cols, "rows": grid.rows, "cell": grid.cell(),
            "quantity": self.quantity.name(), "unit": self.quantity.unit(),
            "min": range.map(|r| r.0), "max": range.map(|r| r.1),
            "range": written.range, "clipped": written.clipped, "notes": notes,
            "tile": cut.then(|| json!(tile.place)), "sidecar": sidecar,
        });
        let cost = writer_cost(self.format, [grid.cols, grid.rows], self.channels, 1);
        Ok(Entry { json, notes, planned_seconds: cost.seconds })
    }
}

/// SHA-256 of the samples as little-endian `f32`, row by row: the same on every machine and in every format.
fn samples_sha256(value: &Value) -> String {
    let mut hasher = Sha256::new();
    for chunk in value.components().chunks(1 << 14) {
        if cfg!(target_endian = "little") {
            hasher.update(bytemuck::cast_slice::<f32, u8>(chunk));
        } else {
            chunk.iter().for_each(|x| hasher.update(x.to_le_bytes()));
        }
    }
    hasher.finalize().iter().map(|b| format!("{b:02x}")).collect()
}
