//! How far a node looks, and what a run of it takes.

use crate::value::Grid;

/// How far a node looks from a point of its output: decides on which grid it runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// No grid at all: curves, rivers, points. The node runs once; fields that it reads come from the base grid.
    Gridless,
    /// A value depends on its own point alone.
    Point,
    /// A value depends on a window around its point; see `Node::footprint`.
    Local(Margin),
    /// A value depends on the whole terrain: the node runs on the base grid.
    Global,
}

impl Reach {
    /// A local reach of some metres.
    pub fn local(metres: f64) -> Self {
        Self::Local(Margin { metres, cells: 0 })
    }

    /// The window that an output window needs of an input.
    pub fn window(self, output: &Grid) -> Grid {
        match self {
            Self::Local(m) => output.grow_metres(m.metres).grow_cells(m.cells),
            Self::Gridless | Self::Point | Self::Global => *output,
        }
    }

    /// The reach with some cells more.
    pub fn plus_cells(self, n: i64) -> Self {
        match self {
            Self::Point => Self::Local(Margin { metres: 0.0, cells: n }),
            Self::Local(m) => Self::Local(Margin { cells: m.cells + n, ..m }),
            Self::Gridless | Self::Global => self,
        }
    }
}

/// A distance in metres and some cells more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margin {
    /// Metres.
    pub metres: f64,
    /// Cells of the grid the node runs on.
    pub cells: i64,
}

/// Seconds that reading and hashing a byte take: a disk that gives about a gigabyte a second.
pub const SECONDS_PER_BYTE: f64 = 1e-9;

/// What a run needs beyond its inputs and outputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Bytes of scratch memory at the peak, inputs and outputs not counted.
    pub bytes: u64,
    /// Seconds on one core.
    pub seconds: f64,
}

impl Cost {
    /// A cost of some nanoseconds a sample and no scratch memory.
    pub fn per_sample(grid: &Grid, nanoseconds: f64) -> Self {
        Self { bytes: 0, seconds: grid.len() as f64 * nanoseconds * 1e-9 }
    }

    /// The cost of holding the content of files of so many bytes.
    pub fn of_reading(bytes: u64) -> Self {
        Self { bytes, seconds: bytes as f64 * SECONDS_PER_BYTE }
    }

    /// Both costs together.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { bytes: self.bytes.saturating_add(other.bytes), seconds: self.seconds + other.seconds }
    }

    /// The cost with scratch memory for some f32 per sample of a grid.
    pub fn with_fields(self, grid: &Grid, fields: f64) -> Self {
        Self { bytes: self.bytes + (grid.len() as f64 * 4.0 * fields) as u64, ..self }
    }
}
