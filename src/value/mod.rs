//! What travels on wires.

mod constraints;
pub mod curves;
mod fill;
mod grid;
mod raster;
mod terrain;

pub use constraints::{Constraints, Mark, Planes};
pub use curves::{Curve, CurveSpec, Curves};
pub use fill::{Row, fill};
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
    /// Feature curves.
    Curves,
    /// Rasterised curves.
    Constraints,
}

impl WireType {
    /// The name used in messages and pages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Field => f32::NAME,
            Self::Vectors => <[f32; 2]>::NAME,
            Self::Colors => <[f32; 3]>::NAME,
            Self::Curves => "curves",
            Self::Constraints => "constraints",
        }
    }

    /// Whether it is samples on a grid, which files and pictures hold and which are carried from the base grid to
    /// others.
    pub fn is_raster(self) -> bool {
        matches!(self, Self::Field | Self::Vectors | Self::Colors)
    }

    /// Bytes of one sample, at most; 0 for what has none.
    pub fn sample_bytes(self) -> u64 {
        match self {
            Self::Field => 4,
            Self::Vectors => 8,
            Self::Colors => 12,
            Self::Curves => 0,
            Self::Constraints => 45,
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
    /// Feature curves, in world coordinates.
    Curves(Curves),
    /// What curves say about the samples of the base grid.
    Constraints(Constraints),
}

/// Does the same to the raster in a [`Value`], whatever its sample type.
macro_rules! each {
    ($value:expr, $raster:ident => $body:expr, $other:pat => $rest:expr) => {
        match $value {
            Value::Field($raster) => $body,
            Value::Vectors($raster) => $body,
            Value::Colors($raster) => $body,
            $other => $rest,
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
            Self::Curves(_) => WireType::Curves,
            Self::Constraints(_) => WireType::Constraints,
        }
    }

    /// Where the samples of a raster stand; `None` for what is no raster.
    pub fn grid(&self) -> Option<&Grid> {
        each!(self, r => Some(r.grid()), _ => None)
    }

    /// What the numbers of a raster mean; `None` for what is no raster.
    pub fn quantity(&self) -> Option<Quantity> {
        each!(self, r => Some(r.quantity()), _ => None)
    }

    /// Bytes in memory.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Curves(curves) => curves.bytes(),
            Self::Constraints(constraints) => constraints.bytes(),
            raster => size_of_val(raster.components()) as u64,
        }
    }

    /// All components of all samples of a raster, row by row; none of what is no raster.
    pub fn components(&self) -> &[f32] {
        each!(self, r => bytemuck::cast_slice(r.data()), _ => &[])
    }

    /// The samples of a raster on another window of the same lattice; what is no raster as it is.
    pub fn crop(&self, grid: &Grid) -> Self {
        match self {
            Self::Field(r) => Self::Field(r.crop(grid)),
            Self::Vectors(r) => Self::Vectors(r.crop(grid)),
            Self::Colors(r) => Self::Colors(r.crop(grid)),
            Self::Curves(_) | Self::Constraints(_) => self.clone(),
        }
    }

    /// Puts components back on a grid, as [`components`](Self::components) gave them; `None` when their number
    /// is not that of the grid, or the type is no raster.
    pub fn from_components(kind: WireType, grid: Grid, quantity: Quantity, data: Vec<f32>) -> Option<Self> {
        fn pairs<const N: usize>(data: &[f32]) -> Vec<[f32; N]> {
            let (chunks, _) = data.as_chunks::<N>();
            chunks.to_vec()
        }
        let channels = (kind.sample_bytes() / 4) as usize;
        if !kind.is_raster() || data.len() != grid.len() * channels {
            return None;
        }
        Some(match kind {
            WireType::Field => Self::Field(Raster::new(grid, quantity, data)),
            WireType::Vectors => Self::Vectors(Raster::new(grid, quantity, pairs(&data))),
            WireType::Colors => Self::Colors(Raster::new(grid, quantity, pairs(&data))),
            WireType::Curves | WireType::Constraints => return None,
        })
    }

    /// Index of the first sample that is not finite, as column and row of the window.
    pub fn first_not_finite(&self) -> Option<(usize, usize)> {
        use rayon::prelude::*;
        if let Self::Constraints(constraints) = self {
            return constraints.first_not_finite();
        }
        // Curves are checked when they are made.
        let grid = self.grid()?;
        let all = self.components();
        // x - x is 0 for finite numbers and NaN otherwise, which vectorises where `is_finite` with `any` does not.
        let bad = all.par_chunks(1 << 16).enumerate().find_first(|(_, c)| {
            let sum: f32 = c.iter().map(|x| x * 0.0).sum();
            sum != 0.0 || sum.is_nan()
        });
        let (chunk, values) = bad?;
        let i = (chunk << 16) + values.iter().position(|x| !x.is_finite())?;
        let sample = i / (self.wire_type().sample_bytes() / 4) as usize;
        Some((sample % grid.cols, sample / grid.cols))
    }
}
