//! Takes up the lines of a file as curves, and keeps account of what is left out.

use std::sync::Arc;

use super::mapping::{Line, Refusal};
use super::tally::{Notice, Tally};
use super::{Imported, MAX_POSITIONS, Mapping, too_many};
use crate::value::curves::bezier::Point;
use crate::value::curves::{CurveError, MAX_CURVES};
use crate::value::{Bounds, Curve, Curves};

/// The curves of a file while it is read.
pub(super) struct Collector<'a> {
    mapping: &'a Mapping,
    onto: Bounds,
    curves: Vec<Arc<Curve>>,
    /// Lines that became curves, those beyond the most counted.
    found: usize,
    positions: usize,
    /// Most positions of this file.
    most: usize,
    pub(super) tally: Tally,
}

impl<'a> Collector<'a> {
    /// For the lines of a file with at most so many positions, which come to lie on a rectangle of the terrain.
    pub(super) fn new(mapping: &'a Mapping, onto: Bounds, most: usize) -> Self {
        let most = most.min(MAX_POSITIONS);
        Self { mapping, onto, curves: Vec::new(), found: 0, positions: 0, most, tally: Tally::default() }
    }

    /// Counts positions before they take memory.
    ///
    /// # Errors
    /// When there are too many.
    pub(super) fn count(&mut self, positions: usize) -> Result<(), CurveError> {
        self.positions = self.positions.saturating_add(positions);
        too_many("positions in the file", self.most, self.positions)
    }

    /// Takes up a line; `place` tells what it is called in messages.
    pub(super) fn take(&mut self, line: Line<'_>, place: impl Fn() -> String) {
        let refused = |message: String| format!("{}: {message}", place());
        match self.mapping.curve(line) {
            Ok(Some(curve)) => {
                self.found += 1;
                if is_off(&curve, &self.onto) {
                    self.tally.add(Notice::Off, &place);
                }
                // The rest is counted, so that the error can say how many there are.
                if self.found <= MAX_CURVES {
                    self.curves.push(Arc::new(curve));
                }
            }
            Ok(None) => self.tally.add(Notice::Bare, place),
            Err(Refusal::Property(message)) => self.tally.add(Notice::Property, || refused(message)),
            Err(Refusal::Curve(message)) => self.tally.add(Notice::Unfit, || refused(message)),
        }
    }

    /// The curves, with a warning for each kind of notice after those of the reader.
    ///
    /// # Errors
    /// When there are too many curves.
    pub(super) fn finish(self, mut warnings: Vec<String>) -> Result<Imported, CurveError> {
        too_many("curves", MAX_CURVES, self.found)?;
        if self.found == 0 && self.tally.is_empty() {
            warnings.push("the file has no line that becomes a curve".to_owned());
        }
        warnings.extend(self.tally.sentences());
        Ok(Imported { curves: Curves::new(self.curves)?, warnings })
    }
}

/// Whether neither a curve nor the ground beside it reaches the terrain.
fn is_off(curve: &Curve, onto: &Bounds) -> bool {
    let reach = curve.reach();
    // The hull of the handles holds the curve.
    let beyond = |axis: usize| {
        let low = |p: &Point| p[axis] + reach < onto.min[axis];
        let high = |p: &Point| p[axis] - reach > onto.max[axis];
        curve.knots().iter().all(low) || curve.knots().iter().all(high)
    };
    beyond(0) || beyond(1)
}
