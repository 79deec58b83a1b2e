//! Tests of the ladder of levels, of rising land and of falling slopes.

mod ladder;
mod prolong;
mod stream_power;
mod thermal;
