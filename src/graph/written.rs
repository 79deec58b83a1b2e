//! What a build writes of an output, known without running anything.

use super::{Graph, GraphQuantities, Output};
use crate::files::Format;
use crate::value::{Quantity, WireType};

/// What an output holds, and the format in which it is written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Written {
    /// The type of its value.
    pub wire: WireType,
    /// What its numbers mean; none of what is no raster, or where a fault leaves that open.
    pub quantity: Option<Quantity>,
    /// The format of the file.
    pub format: Format,
}

impl GraphQuantities {
    /// What is written of an output of a graph, and how, where a format is asked for that may suit it. Nothing where its
    /// source does not resolve, or a fault leaves open what its numbers mean.
    pub fn written(&self, graph: &Graph, output: &Output, asked: Option<Format>) -> Option<Written> {
        let source = graph.resolved(&output.from)?;
        let wire = graph.wire_type(&source)?;
        let quantity = self.get(graph, &source);
        if wire.is_raster() && quantity.is_none() {
            return None;
        }
        Some(Written { wire, quantity, format: output.format_for(asked, wire, quantity) })
    }
}

impl Written {
    /// As a person reads it: `exr, elevation in m`, or `geojson, curves`.
    pub fn described(&self) -> String {
        let what = self.quantity.map_or_else(|| self.wire.name().to_owned(), Quantity::described);
        format!("{}, {what}", self.format.name())
    }

    /// Whether it is written once for the terrain, and not once for each tile: lines stand on no grid.
    pub fn is_of_the_whole(&self) -> bool {
        !self.wire.is_raster()
    }
}
