//! The core of Orograph: everything but its faces, the command line and the editor.
//!
//! The program's crate, `orograph`, gives all of it again under the same names and holds the tour of the house.

pub mod context;
pub mod engine;
pub mod files;
pub mod graph;
pub mod node;
pub mod params;
pub mod render;
pub mod source;
pub mod text;
pub mod whole;

pub use orograph_base::{cost, error, kit, name, ports, units, value, widget, work};

#[path = "../nodes/mod.rs"]
pub mod nodes;

/// What a node file imports.
pub mod prelude {
    pub use schemars::JsonSchema;
    pub use serde::{Deserialize, Serialize};

    pub use crate::node::{
        Context, Cost, Detail, Error, FileRequest, Load, Meta, Node, Quantities, Reach, Reads, Result, Row,
        Summarize, Summary,
    };
    pub use crate::ports::Meaning;
    pub use crate::units::{
        Degrees, Discharge, FilePath, Hours, Metres, MetresPerSecond, MillimetresPerHour, Number, PerMetre,
        Ratio, Seconds, Seed, SquareMetres, Years,
    };
    pub use crate::value::{
        Colors, Constraints, Curves, Field, Grid, Object, Quantity, Raster, Ridges, Rivers, Terrain, Value,
        Vectors,
    };
    pub use crate::widget::Widget;
    pub use orograph_base::ports;
}
