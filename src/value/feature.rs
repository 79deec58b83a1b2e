//! Lines with what is known of them, as files of vectors hold them.

use serde_json::{Map, Value as Json};

use super::SketchLine;

/// A line of a file of vectors: a feature, in the terms of `GeoJSON`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Feature {
    /// Its positions in the world, in metres, x east and y south, with heights where it has them. At least two; the
    /// last repeats the first where the line is closed.
    pub line: SketchLine,
    /// How strongly it is drawn in a picture: 1 for the finest line, 3 for one three times as wide.
    pub weight: f64,
    /// What else is known of it: text, numbers, and lists of numbers spread evenly over its length.
    pub properties: Map<String, Json>,
}

/// The features of an object, one after another.
pub type Features<'a> = Box<dyn Iterator<Item = Feature> + 'a>;
