//! Erosion: land that falls, washes away, and rises.
//!
//! Water needs a thousand steps to cross a grid, and a valley as long as the terrain takes as many to form. So work goes up
//! a ladder of levels: the coarsest makes the large forms in short time, and each finer one adds what it alone can show.
//!
//! - [`Ladder`] names the levels. Their cells are the same whatever the base grid, which only says where the ladder ends:
//!   a draft on a coarser base is a lower level of the same ladder, and shows the same valleys.
//! - [`prolong`] carries changes, water and load from a level to the next: smoothly, within bounds, and without making or
//!   losing any of it.

mod band;
pub mod hydraulic;
pub mod ladder;
mod lines;
pub mod prolong;
pub mod slippage;
pub mod stream_power;
pub mod thermal;

pub use ladder::{Ladder, Level};
