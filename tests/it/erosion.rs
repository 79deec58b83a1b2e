//! Tests of erosion by running water, on single levels and up the ladder.

mod land;
mod plane;
