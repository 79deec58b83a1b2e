//! Tests of erosion by running water, on single levels and up the ladder.

mod balance;
mod lake;
mod land;
mod plane;
mod symmetry;
