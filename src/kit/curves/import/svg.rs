//! Paths of SVG pictures.

use std::str::FromStr as _;

use roxmltree::{Document, Node, ParsingOptions};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use svgtypes::{Length, PathParser, PathSegment, TransformListParser, TransformListToken, ViewBox};

use super::arc::Arc;
use super::mapping::Line;
use super::{Budget, Imported, Mapping, Property, check_size, short};
use crate::value::curves::CurveError;
use crate::value::curves::bezier::{Cubic, Point, add, mix, sub};
use crate::value::{Bounds, Curves};

/// How the picture comes to lie on the terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Fit {
    /// As large as fits, in the middle, in true proportions.
    #[default]
    Inside,
    /// Edge to edge, each side with a scale of its own.
    Stretch,
}

/// The curves of all `path`, `line`, `polyline` and `polygon` elements of a picture whose view box is laid on a
/// rectangle of the terrain; each subpath is a curve. Transforms of elements and groups count, styles do not; what
/// stands in `defs`, `symbol`, `clipPath`, `mask`, `marker` or `pattern` is left out.
///
/// # Errors
/// Names the element and the line of the file.
pub fn read(text: &str, onto: Bounds, fit: Fit, mapping: &Mapping) -> Result<Imported, CurveError> {
    check_size(text)?;
    let options = ParsingOptions { nodes_limit: 1 << 20, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options)
        .map_err(|e| CurveError::file("SVG", format!("is not XML: {e}")))?;
    let root = document.root_element();
    if root.tag_name().name() != "svg" {
        let message = format!("must be an `svg` element, got `{}`", short(root.tag_name().name()));
        return Err(CurveError::file("SVG", message));
    }
    let placed = placement(&root, onto, fit)?;
    let mut reader = Reader { mapping, curves: Vec::new(), budget: Budget::default(), bare: 0 };
    reader.all(&root, placed)?;
    let mut warnings = Vec::new();
    if reader.bare > 0 {
        warnings.push(format!("{} lines on which the mapping sets nothing were left out", reader.bare));
    }
    Ok(Imported { curves: Curves::new(reader.curves)?, warnings })
}

/// `x' = a x + c y + e`, `y' = b x + d y + f`.
#[derive(Clone, Copy, Debug)]
struct Affine([f64; 6]);

impl Affine {
    fn apply(&self, [x, y]: Point) -> Point {
        let [a, b, c, d, e, f] = self.0;
        [a * x + c * y + e, b * x + d * y + f]
    }

    /// First `inner`, then this.
    fn after(&self, inner: &Self) -> Self {
        let [a, b, c, d, ..] = self.0;
        let [p, q, r, s, t, u] = inner.0;
        let [x, y] = self.apply([t, u]);
        Self([a * p + c * q, b * p + d * q, a * r + c * s, b * r + d * s, x, y])
    }

    fn of(token: &TransformListToken) -> Self {
        use TransformListToken as T;
        let tan = |degrees: f64| libm::tan(degrees.to_radians());
        Self(match *token {
            T::Matrix { a, b, c, d, e, f } => [a, b, c, d, e, f],
            T::Translate { tx, ty } => [1.0, 0.0, 0.0, 1.0, tx, ty],
            T::Scale { sx, sy } => [sx, 0.0, 0.0, sy, 0.0, 0.0],
            T::Rotate { angle } => {
                let (sin, cos) = libm::sincos(angle.to_radians());
                [cos, sin, -sin, cos, 0.0, 0.0]
            }
            T::SkewX { angle } => [1.0, 0.0, tan(angle), 1.0, 0.0, 0.0],
            T::SkewY { angle } => [1.0, tan(angle), 0.0, 1.0, 0.0, 0.0],
        })
    }
}

/// Lays the view box on the rectangle.
fn placement(root: &Node<'_, '_>, onto: Bounds, fit: Fit) -> Result<Affine, CurveError> {
    let [x, y, width, height] = match root.attribute("viewBox") {
        Some(text) => {
            let bad = |e| CurveError::file("viewBox", format!("must be four numbers: {e}"));
            let ViewBox { x, y, w, h } = ViewBox::from_str(text).map_err(bad)?;
            [x, y, w, h]
        }
        None => {
            let side = |name: &str| {
                let length = root.attribute(name).and_then(|t| Length::from_str(t).ok()).map(|l| l.number);
                let missing = || CurveError::file("svg", format!("must have a viewBox or a number `{name}`"));
                length.filter(|&l| l > 0.0).ok_or_else(missing)
            };
            [0.0, 0.0, side("width")?, side("height")?]
        }
    };
    let (mut sx, mut sy) = (onto.width() / width, onto.depth() / height);
    if fit == Fit::Inside {
        (sx, sy) = (sx.min(sy), sx.min(sy));
    }
    let middle = |k: usize| 0.5 * (onto.min[k] + onto.max[k]);
    let all = [sx, 0.0, 0.0, sy, middle(0) - sx * (x + 0.5 * width), middle(1) - sy * (y + 0.5 * height)];
    if all.iter().all(|v| v.is_finite()) && sx > 0.0 && sy > 0.0 {
        return Ok(Affine(all));
    }
    Err(CurveError::file("viewBox", format!("cannot be laid on a rectangle of {onto:?}")))
}

struct Reader<'a> {
    mapping: &'a Mapping,
    curves: Vec<std::sync::Arc<crate::value::Curve>>,
    budget: Budget,
    bare: usize,
}

/// Elements that are not drawn where they stand.
const HIDDEN: [&str; 6] = ["defs", "symbol", "clipPath", "mask", "marker", "pattern"];

impl Reader<'_> {
    /// Walks the elements without recursion, so that no nesting is too deep.
    fn all(&mut self, root: &Node<'_, '_>, placed: Affine) -> Result<(), CurveError> {
        let mut stack = vec![(*root, placed)];
        while let Some((node, outer)) = stack.pop() {
            let name = node.tag_name().name();
            if HIDDEN.contains(&name) {
                continue;
            }
            let inner = transform(&node, outer)?;
            self.element(&node, name, &inner)?;
            let first = stack.len();
            stack.extend(node.children().filter(Node::is_element).map(|child| (child, inner)));
            // The first child comes off first.
            stack[first..].reverse();
        }
        Ok(())
    }

    fn element(&mut self, node: &Node<'_, '_>, name: &str, place: &Affine) -> Result<(), CurveError> {
        let bad = |message: String| CurveError::file(named(node), message);
        let number = |key: &str| match node.attribute(key).map(Length::from_str) {
            None => Ok(0.0),
            Some(Ok(length)) => Ok(length.number),
            Some(Err(e)) => Err(bad(format!("`{key}` must be a number: {e}"))),
        };
        let lines = match name {
            "path" => Pen::draw(node.attribute("d").unwrap_or_default(), &mut self.budget)
                .map_err(|e| if let Stop::Bad(m) = e { bad(m) } else { e.into_error() })?,
            "line" => {
                let (from, to) = ([number("x1")?, number("y1")?], [number("x2")?, number("y2")?]);
                vec![Cubic::straight(from, to).0.to_vec()]
            }
            "polyline" | "polygon" => {
                let text = node.attribute("points").unwrap_or_default();
                let mut points: Vec<Point> = Vec::new();
                for (x, y) in svgtypes::PointsParser::from(text) {
                    self.budget.take(1)?;
                    points.push([x, y]);
                }
                if name == "polygon" {
                    points.extend(points.first().copied());
                }
                let mut knots: Vec<_> = points.first().copied().into_iter().collect();
                knots.extend(
                    points.windows(2).flat_map(|w| Cubic::straight(w[0], w[1]).0.into_iter().skip(1)),
                );
                vec![knots]
            }
            _ => return Ok(()),
        };
        let property = |key: &str| property(node, key);
        let label = ("http://www.inkscape.org/namespaces/inkscape", "label");
        let name = node.attribute(label).or(node.attribute("id")).unwrap_or_default();
        for line in lines.into_iter().filter(|l| l.len() > 3) {
            let knots: Vec<Point> = line.into_iter().map(|p| place.apply(p)).collect();
            let line =
                Line { name: short(name), knots, z: Vec::new(), property: &property, place: named(node) };
            match self.mapping.curve(line)? {
                Some(curve) => self.curves.push(std::sync::Arc::new(curve)),
                None => self.bare += 1,
            }
        }
        Ok(())
    }
}

/// What an element is called in messages.
fn named(node: &Node<'_, '_>) -> String {
    let line = node.document().text_pos_at(node.range().start).row;
    match node.attribute("id") {
        Some(id) => format!("{} `{}` in line {line}", short(node.tag_name().name()), short(id)),
        None => format!("{} in line {line}", short(node.tag_name().name())),
    }
}

fn transform(node: &Node<'_, '_>, outer: Affine) -> Result<Affine, CurveError> {
    let mut all = outer;
    for token in TransformListParser::from(node.attribute("transform").unwrap_or_default()) {
        let bad = |e| CurveError::file(named(node), format!("`transform` cannot be read: {e}"));
        all = all.after(&Affine::of(&token.map_err(bad)?));
    }
    Ok(all)
}

fn property(node: &Node<'_, '_>, key: &str) -> Result<Option<Property>, String> {
    let Some(text) = node.attribute(format!("data-{key}").as_str()).or(node.attribute(key)) else {
        return Ok(None);
    };
    let numbers = text.split([',', ' ', ';']).filter(|t| !t.is_empty()).map(|t| {
        let number = t.parse::<f64>().ok().filter(|v| v.is_finite());
        number.ok_or_else(|| format!("property `{key}` must be numbers, got \"{}\"", short(text)))
    });
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
    Ok(match numbers.as_slice() {
        [] => None,
        [one] => Some(Property::Number(*one)),
        _ => Some(Property::List(numbers)),
    })
}

/// Why drawing a path stopped.
enum Stop {
    Bad(String),
    Full(CurveError),
}

impl Stop {
    fn into_error(self) -> CurveError {
        match self {
            Self::Bad(message) => CurveError::file("path", message),
            Self::Full(error) => error,
        }
    }
}

/// The pen that goes along a path and leaves the knots of each subpath.
#[derive(Default)]
struct Pen {
    at: Point,
    start: Point,
    /// The last handle, for `S` and for `T`.
    cubic: Option<Point>,
    quadratic: Option<Point>,
    closed: bool,
    lines: Vec<Vec<Point>>,
}

impl Pen {
    fn draw(path: &str, budget: &mut Budget) -> Result<Vec<Vec<Point>>, Stop> {
        let mut pen = Self::default();
        for segment in PathParser::from(path) {
            let segment = segment.map_err(|e| Stop::Bad(format!("`d` cannot be read: {e}")))?;
            budget.take(1).map_err(Stop::Full)?;
            pen.segment(&segment);
        }
        Ok(pen.lines)
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
        if let Some(line) = self.lines.last_mut() {
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
