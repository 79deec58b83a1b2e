//! Noise: random fields with a feature size, a function of the world position alone.
//!
//! # Theory
//! [`perlin`](lattice::perlin) noise hangs a random slope on every corner of a square lattice and blends the four
//! of a cell with a quintic weight, so that value, slope and curvature are continuous \[perlin2002\]. Sums of it over
//! octaves, each finer and weaker, make the fractals of [`Fractal`] \[ebert2003\]; [`Worley`] measures the distance to
//! random points, one in each cell \[worley1996\].
//!
//! # The lattice
//! Every octave has a lattice of its own, turned by a random angle and shifted by a random offset (both from a hash
//! of seed and octave), so no axis and no common corner shows. Positions on it are fixed-point numbers: 32 bits of
//! cell, 31 bits of fraction, one part from the column and one from the row, added exactly. A sample so depends on
//! its own x and y alone, not on the window, the lane or the thread; there is no edge (cells wrap after 2³², positions
//! beyond are still finite), and the precision of a position in its cell is that of the f64 world coordinate.
//!
//! # Amplitude
//! Single-octave Perlin noise lies within −1 and 1, with mean 0 and standard deviation 0.302. Sums are divided by the
//! sum of their weights, so they keep the bound; see [`Form`] for each.

mod fractal;
pub mod lattice;
mod worley;

pub use fractal::{Form, Fractal, FractalRows, Spectrum};
pub use worley::{Measure, Metric, Worley, WorleyRows};

/// Samples that a kernel holds in its local arrays at a time: some KiB, well inside the fast cache.
const CHUNK: usize = 256;
