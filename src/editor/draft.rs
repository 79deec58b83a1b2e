//! Drafts: the grid of a preview, and a graph whose global nodes run on a coarser base grid.

use serde_json::Value as Json;

use crate::graph::Graph;
use crate::value::{Grid, Terrain};

/// Factors by which drafts are coarser along a side; the first that is quick enough is used.
pub(super) const COARSER: [u32; 3] = [2, 4, 8];

/// The grid of the whole terrain with at most `size` samples along the longer side; `None` where none fits.
pub(super) fn preview(terrain: &Terrain, size: u32) -> Option<Grid> {
    (2..=size).rev().take(512).find_map(|size| terrain.grid(size).ok())
}

/// The graph with a base grid coarser by a factor, and the preview grid that fits it; `None` where the factor does not
/// divide the base grid.
pub(super) fn draft_of(graph: &Graph, size: u32, coarser: u32) -> Option<(Graph, Grid)> {
    let intervals = graph.terrain().base - 1;
    let base = intervals.is_multiple_of(coarser).then(|| intervals / coarser + 1)?;
    let mut draft = graph.clone();
    let exposed = graph.exposed().find(|(_, e)| e.bind.iter().any(|b| b == "terrain.base"));
    let set = match exposed {
        Some((name, _)) => draft.set_exposed(name, Json::from(base)),
        None => draft.set_terrain("base", Json::from(base)),
    };
    set.ok()?;
    let fits = draft.terrain().base == base && draft.terrain().fault().is_none();
    let grid = preview(draft.terrain(), (size - 1) / coarser + 1)?;
    fits.then_some((draft, grid))
}
