//! All integration tests, in one binary.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod budgets;
mod cache;
mod carries;
mod chance;
mod cli;
mod curves;
mod diffusion;
mod digests;
mod engine;
mod erosion;
mod farm;
mod files;
mod filters;
mod flow;
mod generate;
mod geomorphometry;
mod golden;
mod graph;
mod growth;
mod kinds;
mod laws;
mod lines;
mod memory;
mod networks;
mod objects;
mod pages;
mod plans;
mod readme;
mod render;
mod rig;
mod rivers;
mod select;
mod sidecars;
mod sources;
mod strangers;
mod trials;
mod uplift;
mod vectors;
mod views;
mod water;
