//! River networks: how they branch, grow on a map, fill empty land, rise from their outlets, and what ridges part them.
//!
//! # Theory
//! A self-similar network is grown by replacing each link by a generator again and again \[zhang2016, section IV\]: an
//! exterior link, one that starts at a source, by generator φ, an interior one by generator R. [`branching::Branching`] has both.
//! Side branches of such a network are as many as Tokunaga's law says, `T_k = a c^(k-1)` \[peckham1995\].
//!
//! # Practice
//! [`grow`] draws the lines of an artist into networks, [`infill`] adds tributaries, [`meander`] makes them wind, [`drainage`] sums the land that
//! drains through each vertex, [`profile`] sets the heights of beds, and [`ridges`] finds the divides. [`statistics`]
//! counts orders and side branches of any network.

pub mod branching;
pub mod chance;
pub mod drainage;
pub mod gap;
pub mod grow;
pub mod infill;
pub mod link_grid;
pub mod meander;
pub mod meeting;
pub mod profile;
pub mod ridges;
pub mod statistics;
