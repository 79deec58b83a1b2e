//! Tests of the flow of water over a terrain.
mod closed;
mod fill;
mod ground;
mod join;
mod lakes;
mod robust;
mod routing;
mod streams;
