//! Orograph: a node-graph terrain tool.

pub mod context;
pub mod cli;
pub mod engine;
pub mod files;
pub mod graph;
pub mod kit;
pub mod node;
pub mod params;
pub mod ports;
pub mod render;
pub mod units;
pub mod value;

#[path = "../nodes/mod.rs"]
pub mod nodes;

/// What a node file imports.
pub mod prelude {
    pub use schemars::JsonSchema;
    pub use serde::{Deserialize, Serialize};

    pub use crate::node::{
        Context, Cost, Error, FileRequest, Meta, Node, Reach, Reads, Result, Row, Summary,
    };
    pub use crate::ports;
    pub use crate::units::{Degrees, FilePath, Metres, Number, PerMetre, Ratio, Seed};
    pub use crate::value::{Colors, Field, Grid, Quantity, Raster, Terrain, Vectors};
}
