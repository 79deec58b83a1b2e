//! The flow of water over a terrain: where it goes, where it stands, and how much of it passes a place.
//!
//! Everything starts from a [`Surface`]. Water leaves it at *outlets*: cells at or below the sea, cells without data, and
//! cells of the border that have no lower neighbour. Every other cell drains to a neighbour.
//!
//! - [`Depressions`] finds the pits of a surface, their basins, and the level to which each fills: the least height that
//!   water must climb on any way from the pit to an outlet. Cells descend to their pits first; then the passes between
//!   neighbouring basins are a graph, and its minimum spanning tree holds all levels \[cordonnier2019\]. No queue of cells
//!   is kept in order of height, as in a priority flood \[barnes2014\], and the time is nearly linear in the cells.
//! - [`Depressions::filled`] is the surface with its lakes full; [`epsilon::fill`] also gives the lakes a slope;
//!   [`breach::cut`] lowers the passes instead. [`Lakes`] names what stands in the depressions.
//! - [`Tree`] sends the water of each cell to one neighbour (D8), and that of a pit over its pass. [`Spread`] divides it
//!   over two or more (D-infinity, MFD).
//! - [`accumulate`] sums over what drains through each cell; [`Tree::upwards`] carries values from the outlets upwards.
//!   [`streams`] finds the rivers in a tree, [`network`] makes vertices of them, [`wetness`] says what lies near them.
//!
//! Ties go to the cell of lower index (row by row from the north-west), on flats too, so that a result is the same for
//! any number of threads.

pub mod accumulate;
pub mod breach;
mod depressions;
mod descent;
pub mod epsilon;
mod flats;
pub mod join;
mod lakes;
pub mod neighbor;
pub mod network;
mod passes;
mod spread;
pub mod streams;
mod surface;
mod tree;
pub mod wetness;

pub use depressions::{Depressions, Pit};
pub use lakes::{Lake, Lakes, Puddles};
pub use spread::{Rule, Spread};
pub use surface::Surface;
pub use tree::Tree;
