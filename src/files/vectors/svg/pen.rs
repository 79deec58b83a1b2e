//! The pen that goes along the data of a path.

use svgtypes::{PathParser, PathSegment};

use super::arc::Arc;
use crate::value::curves::MAX_PIECES;
use crate::value::curves::bezier::{Cubic, Point, add, mix, sub};

/// Where the pen is, and the knots of each subpath that it has left.
#[derive(Default)]
pub(super) struct Pen {
    at: Point,
    start: Point,
    /// The last handle, for `S` and for `T`.
    cubic: Option<Point>,
    quadratic: Option<Point>,
    closed: bool,
    lines: Vec<Vec<Point>>,
}

impl Pen {
    /// The subpaths of path data, and what broke them off. `count` is told of each segment, and may stop the work.
    ///
    /// # Errors
    /// Those of `count`.
    pub(super) fn draw<E>(
        data: &str,
        mut count: impl FnMut() -> Result<(), E>,
    ) -> Result<(Vec<Vec<Point>>, Option<String>), E> {
        let mut pen = Self::default();
        for segment in PathParser::from(data) {
            match segment {
                Ok(segment) => {
                    count()?;
                    pen.segment(&segment);
                }
                Err(e) => return Ok((pen.lines, Some(format!("`d` cannot be read: {e}")))),
            }
        }
        Ok((pen.lines, None))
    }

    fn segment(&mut self, segment: &PathSegment) {
        use PathSegment as S;
        let (at, cubic, quadratic) = (self.at, self.cubic.take(), self.quadratic.take());
        let p = |abs: bool, x: f64, y: f64| if abs { [x, y] } else { add(at, [x, y]) };
        // A handle mirrored at the pen.
        let mirrored = |handle: Option<Point>| handle.map_or(at, |h| sub(add(at, at), h));
        match *segment {
            S::MoveTo { abs, x, y } => {
                self.at = p(abs, x, y);
                self.start = self.at;
                self.lines.push(vec![self.at]);
                self.closed = false;
            }
            S::LineTo { abs, x, y } => self.line(p(abs, x, y)),
            S::HorizontalLineTo { abs, x } => self.line([if abs { x } else { at[0] + x }, at[1]]),
            S::VerticalLineTo { abs, y } => self.line([at[0], if abs { y } else { at[1] + y }]),
            S::CurveTo { abs, x1, y1, x2, y2, x, y } => {
                self.curve(p(abs, x1, y1), p(abs, x2, y2), p(abs, x, y));
            }
            S::SmoothCurveTo { abs, x2, y2, x, y } => {
                self.curve(mirrored(cubic), p(abs, x2, y2), p(abs, x, y));
            }
            S::Quadratic { abs, x1, y1, x, y } => self.parabola(p(abs, x1, y1), p(abs, x, y)),
            S::SmoothQuadratic { abs, x, y } => self.parabola(mirrored(quadratic), p(abs, x, y)),
            S::EllipticalArc { abs, rx, ry, x_axis_rotation, large_arc, sweep, x, y } => {
                let to = p(abs, x, y);
                let (radii, rotation) = ([rx, ry], x_axis_rotation);
                for [b, c, d] in (Arc { from: at, to, radii, rotation, large: large_arc, sweep }).pieces() {
                    self.curve(b, c, d);
                }
                self.cubic = None;
                self.at = to;
            }
            S::ClosePath { .. } => {
                if at != self.start {
                    self.line(self.start);
                }
                self.at = self.start;
                self.closed = true;
            }
        }
    }

    fn curve(&mut self, b: Point, c: Point, to: Point) {
        // After a closed subpath the next one may begin without a move.
        if std::mem::take(&mut self.closed) || self.lines.is_empty() {
            self.lines.push(vec![self.at]);
        }
        // Of more pieces than a curve may have no curve comes: the rest takes no memory.
        if let Some(line) = self.lines.last_mut().filter(|line| line.len() <= 3 * MAX_PIECES + 1) {
            line.extend([b, c, to]);
        }
        self.at = to;
        self.cubic = Some(c);
    }

    fn line(&mut self, to: Point) {
        let [_, b, c, _] = Cubic::straight(self.at, to).0;
        self.curve(b, c, to);
        self.cubic = None;
    }

    fn parabola(&mut self, handle: Point, to: Point) {
        let at = self.at;
        self.curve(mix(at, handle, 2.0 / 3.0), mix(to, handle, 2.0 / 3.0), to);
        self.cubic = None;
        self.quadratic = Some(handle);
    }
}
