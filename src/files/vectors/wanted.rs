//! What the lines of a file become: curves by a mapping, or lines as they are.

use std::collections::BTreeMap;

use super::mapping::{self, Line, Mapping, Property};
use crate::value::curves::bezier::Point;

/// What is made of the lines of a file.
#[derive(Clone, Copy, Debug)]
pub enum Wanted<'a> {
    /// Curves, whose constraints a mapping takes from properties; lines on which nothing is set are left out.
    Curves(&'a Mapping),
    /// Every line, with those of some properties that it has and that are numbers.
    Lines(&'a [&'a str]),
}

impl<'a> From<&'a Mapping> for Wanted<'a> {
    fn from(mapping: &'a Mapping) -> Self {
        Self::Curves(mapping)
    }
}

/// A line of a file, on the terrain.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileLine {
    /// What it is called.
    pub name: String,
    /// Cubic pieces: the start, then two handles and the end of each; in metres, x east and y south.
    pub knots: Vec<Point>,
    /// Heights at shares of the length, where the file has them.
    pub heights: Vec<(f64, f64)>,
    /// The properties that were asked for.
    pub properties: BTreeMap<String, Property>,
}

impl Wanted<'_> {
    /// The properties that are read.
    pub(super) fn names(&self) -> Vec<&str> {
        match self {
            Self::Curves(mapping) => mapping.names().collect(),
            Self::Lines(names) => names.to_vec(),
        }
    }
}

impl FileLine {
    /// The height at a share of the length, from place to place; 0 where the file has none.
    pub fn height(&self, u: f64) -> f64 {
        mapping::at(&self.heights, u)
    }

    /// A line with its properties out of some names; one that is no number is none.
    pub(super) fn of(line: Line<'_>, names: &[&str]) -> Self {
        let value = |name: &&str| Some(((*name).to_owned(), (line.property)(name).ok().flatten()?));
        let properties = names.iter().filter_map(value).collect();
        Self { name: line.name, knots: line.knots, heights: line.z, properties }
    }
}
