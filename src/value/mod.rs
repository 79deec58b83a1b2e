//! What travels on wires.

mod constraints;
pub mod curves;
mod feature;
mod fill;
mod grid;
mod object;
mod quantity;
mod raster;
mod ridges;
pub mod rivers;
mod terrain;

pub use constraints::{Constraints, Mark, Planes};
pub use curves::{Curve, CurveSpec, Curves};
pub use feature::{Feature, Features};
pub use fill::{Row, fill};
pub use grid::{Bounds, Grid, Lattice};
pub use object::{
    AnyObject, Object, ObjectLoader, ObjectType, Pin, Sketch, SketchLine, SketchMark, SketchPoint,
};
pub use quantity::{Lift, Quantity};
pub use raster::{Colors, Field, Raster, Sample, Vectors};
pub use ridges::{MAX_RIDGES, RidgeEdge, RidgeFault, RidgeVertex, Ridges};
pub use rivers::{GUESSED_VERTICES, RiverFault, RiverVertex, Rivers};
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
    /// What is no raster.
    Object(&'static ObjectType),
}

impl WireType {
    /// The name used in messages and pages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Field => f32::NAME,
            Self::Vectors => <[f32; 2]>::NAME,
            Self::Colors => <[f32; 3]>::NAME,
            Self::Object(object) => object.name,
        }
    }

    /// Whether it is samples on a grid, which files and pictures hold and which are carried from the base grid to
    /// others.
    pub fn is_raster(self) -> bool {
        self.channels() > 0
    }

    /// Whether it may be an output of a graph: what files hold.
    pub fn is_output(self) -> bool {
        match self {
            Self::Object(object) => object.has_features,
            _ => true,
        }
    }

    /// Numbers of a sample of a raster; 0 for what is none.
    pub fn channels(self) -> usize {
        match self {
            Self::Field => f32::CHANNELS,
            Self::Vectors => <[f32; 2]>::CHANNELS,
            Self::Colors => <[f32; 3]>::CHANNELS,
            Self::Object(_) => 0,
        }
    }

    /// Bytes of one sample, at most; 0 for what has none.
    pub fn sample_bytes(self) -> u64 {
        match self {
            Self::Object(object) => object.sample_bytes,
            raster => 4 * raster.channels() as u64,
        }
    }

    /// Bytes that a value without samples is taken to hold before it is there; 0 for what has samples.
    pub fn guessed_bytes(self) -> u64 {
        match self {
            Self::Object(object) => object.guessed_bytes,
            _ => 0,
        }
    }

    /// Whether cache folders keep it.
    pub fn is_kept(self) -> bool {
        match self {
            Self::Object(object) => object.load.is_some(),
            _ => true,
        }
    }

    /// The colour of its wires, sRGB: those of Okabe and Ito, which the colour-blind can tell apart.
    pub fn color(self) -> [u8; 3] {
        match self {
            Self::Field => [86, 180, 233],
            Self::Vectors => [204, 121, 167],
            Self::Colors => [230, 159, 0],
            Self::Object(object) => object.color,
        }
    }

    /// The form of its pins.
    pub fn pin(self) -> Pin {
        match self {
            Self::Field => Pin::Circle,
            Self::Vectors => Pin::Polygon { corners: 3, turn: 0.0 },
            Self::Colors => Pin::Polygon { corners: 4, turn: 0.5 },
            Self::Object(object) => object.pin,
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
    /// What is no raster.
    Object(AnyObject),
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
            Self::Object(object) => WireType::Object(object.wire()),
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
            Self::Object(object) => object.bytes(),
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
            Self::Object(_) => self.clone(),
        }
    }

    /// Puts components back on a grid, as [`components`](Self::components) gave them; `None` when their number
    /// is not that of the grid, or the type is no raster.
    pub fn from_components(kind: WireType, grid: Grid, quantity: Quantity, data: Vec<f32>) -> Option<Self> {
        fn pairs<const N: usize>(data: &[f32]) -> Vec<[f32; N]> {
            let (chunks, _) = data.as_chunks::<N>();
            chunks.to_vec()
        }
        if !kind.is_raster() || data.len() != grid.len() * kind.channels() {
            return None;
        }
        Some(match kind {
            WireType::Field => Self::Field(Raster::new(grid, quantity, data)),
            WireType::Vectors => Self::Vectors(Raster::new(grid, quantity, pairs(&data))),
            WireType::Colors => Self::Colors(Raster::new(grid, quantity, pairs(&data))),
            WireType::Object(_) => return None,
        })
    }

    /// The object of a type, where it is one.
    pub fn object<T: Object>(&self) -> Option<&T> {
        match self {
            Self::Object(object) => object.get(),
            _ => None,
        }
    }

    /// Index of the first sample of a raster that is not finite, as column and row of the window.
    pub fn first_not_finite(&self) -> Option<(usize, usize)> {
        use rayon::prelude::*;
        let grid = self.grid()?;
        let all = self.components();
        // x - x is 0 for finite numbers and NaN otherwise, which vectorises where `is_finite` with `any` does not.
        let bad = all.par_chunks(1 << 16).enumerate().find_first(|(_, c)| {
            let sum: f32 = c.iter().map(|x| x * 0.0).sum();
            sum != 0.0 || sum.is_nan()
        });
        let (chunk, values) = bad?;
        let i = (chunk << 16) + values.iter().position(|x| !x.is_finite())?;
        let sample = i / self.wire_type().channels();
        Some((sample % grid.cols, sample / grid.cols))
    }
}
