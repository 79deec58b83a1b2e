//! All integration tests, in one binary.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod cli;
mod engine;
mod files;
mod filters;
mod generate;
mod graph;
mod kinds;
mod laws;
mod render;
mod select;
