//! All integration tests, in one binary.

mod engine;
mod files;
mod filters;
mod generate;
mod kinds;
mod graph;
mod laws;
mod render;
mod select;
