//! A stream of random numbers, for work whose order is fixed.

use crate::kit::hash;

/// The stream of a seed, number after number.
#[derive(Clone, Debug)]
pub struct Chance {
    seed: u64,
    drawn: u64,
}

impl Chance {
    /// The stream of a seed, from its start.
    pub fn new(seed: u64) -> Self {
        Self { seed, drawn: 0 }
    }

    /// A number in [0, 1), each as likely.
    pub fn unit(&mut self) -> f64 {
        self.drawn += 1;
        hash::unit(self.seed, self.drawn)
    }

    /// −1 or 1, each as likely.
    pub fn sign(&mut self) -> f64 {
        if self.unit() < 0.5 { -1.0 } else { 1.0 }
    }

    /// A number of mean 0 and standard deviation 1, bell-shaped and never beyond ±3: a sum of three.
    pub fn bell(&mut self) -> f64 {
        2.0 * (self.unit() + self.unit() + self.unit()) - 3.0
    }

    /// A whole number whose mean is the given one: the one below it or the one above.
    pub fn whole(&mut self, mean: f64) -> u32 {
        let below = libm::floor(mean);
        below as u32 + u32::from(self.unit() < mean - below)
    }
}
