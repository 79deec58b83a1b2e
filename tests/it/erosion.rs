//! Tests of erosion by running water, on single levels and up the ladder.

mod balance;
mod ladder;
mod lake;
mod land;
mod plane;
mod pull;
mod steps;
mod symmetry;
