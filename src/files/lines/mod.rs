//! Writers of lines: objects whose values are features, as `GeoJSON` and SVG.
//!
//! Positions are those that the readers of [`vectors`](super::vectors) put back where they were: in `GeoJSON` metres to
//! the east and north, on Earth or from the north-west corner of the terrain, in SVG a page as large as the terrain.

pub(super) mod geojson;
pub(super) mod svg;

use super::codec::{Format, Writer};
use super::error::WriteError;
use super::sheet::{Sink, unfit};
use super::write::{Writing, Written};
use crate::value::{AnyObject, Feature, Terrain};

/// Features between two looks at whether to go on.
const PACE: usize = 256;

/// Lines on the way into a file.
pub(super) struct Lines<'a> {
    pub(super) object: &'a AnyObject,
    pub(super) terrain: &'a Terrain,
    pub(super) writing: Writing<'a>,
}

impl Lines<'_> {
    /// Writes the file.
    ///
    /// # Errors
    /// When the object has no features, the format holds samples, the disk refuses, or the work was asked to stop.
    pub(super) fn write(&self, out: &mut dyn Sink) -> Result<Written, WriteError> {
        let (format, kind) = (self.writing.format, self.object.wire());
        if !kind.has_features {
            return Err(unfit(format, kind.name, "fields, vectors, colours and lines can be written"));
        }
        let Writer::Lines(write) = format.form().write else {
            return Err(unfit(format, kind.name, Format::which(|f| matches!(f.write, Writer::Lines(_)))));
        };
        let mut out = std::io::BufWriter::new(out);
        write(self, &mut out)?;
        std::io::Write::flush(&mut out)?;
        Ok(Written::default())
    }

    /// Does something with each feature, and asks now and then whether to go on. The share of the work is unknown, since
    /// features are made one after another.
    fn each(&self, mut take: impl FnMut(usize, Feature) -> Result<(), WriteError>) -> Result<(), WriteError> {
        for (i, feature) in self.object.features().enumerate() {
            if i.is_multiple_of(PACE) {
                self.writing.work.check()?;
            }
            take(i, feature)?;
        }
        Ok(self.writing.work.step(1.0)?)
    }
}
