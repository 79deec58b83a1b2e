//! What travels on wires.

mod grid;
mod raster;
mod terrain;

pub use grid::{Bounds, Grid, Lattice};
pub use raster::{Colors, Field, Quantity, Raster, Sample, Vectors};
pub use terrain::{Geo, MAX_BASE, MAX_EXTENT, MAX_SIZE, MIN_SIZE, Terrain};

/// The type of a wire: what a port takes or gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum WireType {
    /// One number per point.
    Field,
    /// Two numbers per point.
    Vectors,
    /// A colour per point.
    Colors,
}

impl WireType {
    /// The name used in messages and pages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Field => f32::NAME,
            Self::Vectors => <[f32; 2]>::NAME,
            Self::Colors => <[f32; 3]>::NAME,
        }
    }

    /// Bytes of one sample.
    pub fn sample_bytes(self) -> u64 {
        match self {
            Self::Field => 4,
            Self::Vectors => 8,
            Self::Colors => 12,
        }
    }
}

/// A value on a wire; cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// One number per point.
    Field(Field),
    /// Two numbers per point.
    Vectors(Vectors),
    /// A colour per point.
    Colors(Colors),
}

/// Does the same to the raster in a [`Value`], whatever its sample type.
macro_rules! each {
    ($value:expr, $raster:ident => $body:expr) => {
        match $value {
            Value::Field($raster) => $body,
            Value::Vectors($raster) => $body,
            Value::Colors($raster) => $body,
        }
    };
}

impl Value {
    /// Its type.
    pub fn wire_type(&self) -> WireType {
        match self {
            Self::Field(_) => WireType::Field,
            Self::Vectors(_) => WireType::Vectors,
            Self::Colors(_) => WireType::Colors,
        }
    }

    /// Where the samples stand.
    pub fn grid(&self) -> &Grid {
        each!(self, r => r.grid())
    }

    /// What the numbers mean.
    pub fn quantity(&self) -> Quantity {
        each!(self, r => r.quantity())
    }

    /// Bytes of the samples.
    pub fn bytes(&self) -> u64 {
        each!(self, r => r.bytes())
    }

    /// All components of all samples, row by row.
    pub fn components(&self) -> &[f32] {
        each!(self, r => bytemuck::cast_slice(r.data()))
    }

    /// The samples on another window of the same lattice.
    pub fn crop(&self, grid: &Grid) -> Self {
        match self {
            Self::Field(r) => Self::Field(r.crop(grid)),
            Self::Vectors(r) => Self::Vectors(r.crop(grid)),
            Self::Colors(r) => Self::Colors(r.crop(grid)),
        }
    }

    /// Puts components back on a grid, as [`components`](Self::components) gave them; `None` when their number
    /// is not that of the grid.
    pub fn from_components(kind: WireType, grid: Grid, quantity: Quantity, data: Vec<f32>) -> Option<Self> {
        fn pairs<const N: usize>(data: &[f32]) -> Vec<[f32; N]> {
            let (chunks, _) = data.as_chunks::<N>();
            chunks.to_vec()
        }
        let channels = (kind.sample_bytes() / 4) as usize;
        if data.len() != grid.len() * channels {
            return None;
        }
        Some(match kind {
            WireType::Field => Self::Field(Raster::new(grid, quantity, data)),
            WireType::Vectors => Self::Vectors(Raster::new(grid, quantity, pairs(&data))),
            WireType::Colors => Self::Colors(Raster::new(grid, quantity, pairs(&data))),
        })
    }

    /// Index of the first sample that is not finite, as column and row of the window.
    pub fn first_not_finite(&self) -> Option<(usize, usize)> {
        use rayon::prelude::*;
        let all = self.components();
        // x - x is 0 for finite numbers and NaN otherwise, which vectorises where `is_finite` with `any` does not.
        let bad = all.par_chunks(1 << 16).enumerate().find_first(|(_, c)| {
            let sum: f32 = c.iter().map(|x| x * 0.0).sum();
            sum != 0.0 || sum.is_nan()
        });
        let (chunk, values) = bad?;
        let i = (chunk << 16) + values.iter().position(|x| !x.is_finite())?;
        let sample = i / (self.wire_type().sample_bytes() / 4) as usize;
        Some((sample % self.grid().cols, sample / self.grid().cols))
    }
}
