//! Erosion by running water, after Weiss 2015, chapter VI, in metres and seconds.
//!
//! # Theory
//! Rain and sources give water, which runs through eight pipes a cell ([`Site`], [`State`]), wears ground where it can carry
//! more than it does, and lays its load down where it can carry less. Slopes that become too steep slip. The formulas stand
//! where they are worked out: flow in `water`, exchange in `ground`, the border in `border`.
//!
//! # Practice
//! [`Run`] works on one level. All is done in one sweep over the rows, in bands side by side; sums are taken in pairs that
//! change places when the land is mirrored or turned by a quarter, so that under even rain the result does as well, to the
//! bit. Nothing hangs on the number of threads.

mod border;
mod climate;
mod consts;
mod erode;
mod gauge;
mod ground;
mod held;
mod refine;
mod run;
mod settings;
mod site;
mod sweep;
mod water;

pub use erode::{Eroded, Land, Picture, cell_steps, erode};
pub use gauge::Water;
pub use run::{Account, Run};
pub use settings::{Border, Settings, Showers};
pub use site::{Site, State};
