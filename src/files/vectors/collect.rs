//! Takes up the lines of a file, and keeps account of what is left out.

use std::sync::Arc;

use super::mapping::{Line, Refusal};
use super::tally::{Notice, Tally};
use super::wanted::{FileLine, Wanted};
use super::{Imported, MAX_POSITIONS, too_many};
use crate::value::curves::bezier::Point;
use crate::value::curves::{CurveError, MAX_CURVES};
use crate::value::{Bounds, Curve, Curves};

/// What was made of the lines of a file while it is read.
pub(super) struct Collector<'a> {
    wanted: Wanted<'a>,
    onto: Bounds,
    curves: Vec<Arc<Curve>>,
    lines: Vec<FileLine>,
    /// Lines that were taken up, curves beyond the most counted.
    found: usize,
    positions: usize,
    /// Most positions of this file.
    most: usize,
    pub(super) tally: Tally,
}

impl<'a> Collector<'a> {
    /// For the lines of a file with at most so many positions, which come to lie on a rectangle of the terrain.
    pub(super) fn new(wanted: Wanted<'a>, onto: Bounds, most: usize) -> Self {
        let most = most.min(MAX_POSITIONS);
        let (curves, lines) = (Vec::new(), Vec::new());
        Self { wanted, onto, curves, lines, found: 0, positions: 0, most, tally: Tally::default() }
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
        // Where it lies: whether all of it is off the terrain.
        let taken = match self.wanted {
            Wanted::Curves(mapping) => mapping.curve(line).map(|curve| Some(self.keep_curve(curve?))),
            Wanted::Lines(names) => Ok(Some(self.keep_line(FileLine::of(line, names)))),
        };
        match taken {
            Ok(Some(false)) => (),
            Ok(Some(true)) => self.tally.add(Notice::Off, &place),
            Ok(None) => self.tally.add(Notice::Bare, place),
            Err(Refusal::Property(message)) => self.tally.add(Notice::Property, || refused(message)),
            Err(Refusal::Curve(message)) => self.tally.add(Notice::Unfit, || refused(message)),
        }
    }

    /// Keeps a curve; whether it is off the terrain.
    fn keep_curve(&mut self, curve: Curve) -> bool {
        self.found += 1;
        let off = is_off(curve.knots(), curve.reach(), &self.onto);
        // The rest is counted, so that the error can say how many there are.
        if self.found <= MAX_CURVES {
            self.curves.push(Arc::new(curve));
        }
        off
    }

    /// Keeps a line; whether it is off the terrain.
    fn keep_line(&mut self, line: FileLine) -> bool {
        self.found += 1;
        let off = is_off(&line.knots, 0.0, &self.onto);
        self.lines.push(line);
        off
    }

    /// What was taken up, with a warning for each kind of notice after those of the reader.
    ///
    /// # Errors
    /// When there are too many curves.
    pub(super) fn finish(self, mut warnings: Vec<String>) -> Result<Imported, CurveError> {
        let (nothing, most) = match self.wanted {
            Wanted::Curves(_) => ("the file has no line that becomes a curve", MAX_CURVES),
            // Each has two positions, which are counted.
            Wanted::Lines(_) => ("the file has no line", MAX_POSITIONS),
        };
        too_many("curves", most, self.found)?;
        if self.found == 0 && self.tally.is_empty() {
            warnings.push(nothing.to_owned());
        }
        warnings.extend(self.tally.sentences());
        Ok(Imported { curves: Curves::new(self.curves)?, lines: self.lines, warnings })
    }
}

/// Whether neither a line nor the ground so far beside it reaches the terrain.
fn is_off(knots: &[Point], reach: f64, onto: &Bounds) -> bool {
    // The hull of the handles holds the curve.
    let beyond = |axis: usize| {
        let low = |p: &Point| p[axis] + reach < onto.min[axis];
        let high = |p: &Point| p[axis] - reach > onto.max[axis];
        knots.iter().all(low) || knots.iter().all(high)
    };
    beyond(0) || beyond(1)
}
