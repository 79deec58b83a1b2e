//! Where things of a picture stand: transforms, lengths with units, view boxes in viewports.

use std::str::FromStr as _;

use svgtypes::{
    Align, AspectRatio, Length, LengthUnit, TransformListParser, TransformListToken, ViewBox as Numbers,
};

use super::moves;
use super::tree::Node;
use crate::value::curves::bezier::Point;

/// User units in an inch, as SVG and CSS fix it.
const INCH: f64 = 96.0;
/// User units of a letter's height: that of the text size a picture has where nothing sets one.
const EM: f64 = 16.0;

/// `x' = a x + c y + e`, `y' = b x + d y + f`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Affine(pub(super) [f64; 6]);

impl Affine {
    pub(super) fn apply(&self, [x, y]: Point) -> Point {
        let [a, b, c, d, e, f] = self.0;
        [a * x + c * y + e, b * x + d * y + f]
    }

    /// First `inner`, then this.
    pub(super) fn after(&self, inner: &Self) -> Self {
        let [a, b, c, d, ..] = self.0;
        let [p, q, r, s, t, u] = inner.0;
        let [x, y] = self.apply([t, u]);
        Self([a * p + c * q, b * p + d * q, a * r + c * s, b * r + d * s, x, y])
    }

    pub(super) fn shift(x: f64, y: f64) -> Self {
        Self([1.0, 0.0, 0.0, 1.0, x, y])
    }

    pub(super) fn scale(x: f64, y: f64) -> Self {
        Self([x, 0.0, 0.0, y, 0.0, 0.0])
    }

    /// By degrees, from the x axis to the y axis.
    pub(super) fn rotate(degrees: f64) -> Self {
        let (sin, cos) = libm::sincos(degrees.to_radians());
        Self([cos, sin, -sin, cos, 0.0, 0.0])
    }

    /// By the degrees that each axis is turned towards the other.
    pub(super) fn skew(x: f64, y: f64) -> Self {
        let [x, y] = [x, y].map(|degrees| libm::tan(degrees.to_radians()));
        Self([1.0, y, x, 1.0, 0.0, 0.0])
    }

    fn of(token: &TransformListToken) -> Self {
        use TransformListToken as T;
        match *token {
            T::Matrix { a, b, c, d, e, f } => Self([a, b, c, d, e, f]),
            T::Translate { tx, ty } => Self::shift(tx, ty),
            T::Scale { sx, sy } => Self::scale(sx, sy),
            T::Rotate { angle } => Self::rotate(angle),
            T::SkewX { angle } => Self::skew(angle, 0.0),
            T::SkewY { angle } => Self::skew(0.0, angle),
        }
    }

    /// This after what moves an element: the `transform` of its styles, else of its attribute, about its origin.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(super) fn of_node(&self, node: &Node<'_>, view: Viewport) -> Result<Self, String> {
        let said = node.moves();
        let steps = match said.and_then(|said| said.transform.as_deref()) {
            Some(text) => moves::steps(text, view)?,
            None => steps(node.attribute("transform").unwrap_or_default())?,
        };
        let frame = said.and_then(|said| said.frame.as_deref());
        if steps.is_empty() {
            return Ok(*self);
        }
        if let Some(frame) = frame.filter(|frame| !frame.eq_ignore_ascii_case("view-box")) {
            return Err(format!("`transform-box` must be view-box, got \"{frame}\""));
        }
        let origin = said.and_then(|said| said.origin.as_deref());
        let Some([x, y]) = origin.map(|text| moves::origin(text, view)).transpose()? else {
            return Ok(steps.iter().fold(*self, |all, step| all.after(step)));
        };
        let moved = steps.iter().fold(self.after(&Self::shift(x, y)), |all, step| all.after(step));
        Ok(moved.after(&Self::shift(-x, -y)))
    }
}

/// The steps of a `transform` attribute.
fn steps(text: &str) -> Result<Vec<Affine>, String> {
    let step = |token: Result<TransformListToken, svgtypes::Error>| {
        token.map(|token| Affine::of(&token)).map_err(|e| format!("`transform` cannot be read: {e}"))
    };
    TransformListParser::from(text).map(step).collect()
}

/// What a percentage of a length is a share of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Along {
    Width,
    Height,
    Diagonal,
}

/// The size of the viewport that an element stands in, in its user units: what percentages are shares of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Viewport(pub(super) [f64; 2]);

impl Viewport {
    fn side(self, along: Along) -> f64 {
        let [w, h] = self.0;
        match along {
            Along::Width => w,
            Along::Height => h,
            Along::Diagonal => ((w * w + h * h) / 2.0).sqrt(),
        }
    }

    /// The length that an attribute gives, in user units; `None` where it is not there, or says `auto`.
    ///
    /// # Errors
    /// When it is no length.
    pub(super) fn length(self, node: &Node<'_>, name: &str, along: Along) -> Result<Option<f64>, String> {
        let Some(text) = node.attribute(name).map(str::trim).filter(|t| *t != "auto") else {
            return Ok(None);
        };
        self.length_of(text, along).map(Some).map_err(|e| format!("`{name}` cannot be read: {e}"))
    }

    /// The length that a text gives, in user units.
    ///
    /// # Errors
    /// When it is no length, or its unit cannot be known.
    pub(super) fn length_of(self, text: &str, along: Along) -> Result<f64, String> {
        let length = length(text)?;
        Ok(user_units(&length).unwrap_or_else(|| length.number / 100.0 * self.side(along)))
    }
}

/// Units that depend on a window, or on a font that is not there.
const UNKNOWN: [&str; 14] =
    ["rem", "rex", "ch", "rch", "ic", "cap", "lh", "rlh", "vw", "vh", "vi", "vb", "vmin", "vmax"];

/// A length as it is written, its unit in letters of any case.
///
/// # Errors
/// When it is none, or its unit cannot be known.
fn length(text: &str) -> Result<Length, String> {
    let lower = text.to_ascii_lowercase();
    let unit = lower.trim_start_matches(|c: char| !c.is_ascii_alphabetic());
    if UNKNOWN.contains(&unit) {
        return Err(format!("the length of the unit `{unit}` cannot be known here"));
    }
    // Quarter millimetres.
    let (number, scale) = lower.strip_suffix('q').map_or((&*lower, 1.0), |number| (number, INCH / 101.6));
    let length = Length::from_str(number).map_err(|e| e.to_string())?;
    match length.unit {
        unit if scale == 1.0 => Ok(Length { unit, ..length }),
        LengthUnit::None => Ok(Length { number: length.number * scale, unit: LengthUnit::Px }),
        _ => Err(format!("\"{text}\" is no length")),
    }
}

/// A length in user units; `None` for a percentage.
fn user_units(length: &Length) -> Option<f64> {
    let unit = match length.unit {
        LengthUnit::None | LengthUnit::Px => 1.0,
        LengthUnit::Em => EM,
        LengthUnit::Ex => EM / 2.0,
        LengthUnit::In => INCH,
        LengthUnit::Cm => INCH / 2.54,
        LengthUnit::Mm => INCH / 25.4,
        LengthUnit::Pt => INCH / 72.0,
        LengthUnit::Pc => INCH / 6.0,
        LengthUnit::Percent => return None,
    };
    Some(length.number * unit)
}

/// The rectangle of user units that fills a viewport.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ViewBox {
    pub(super) at: Point,
    pub(super) size: [f64; 2],
}

impl ViewBox {
    /// That of an element, if it has one.
    ///
    /// # Errors
    /// When the attribute is no rectangle with an area.
    pub(super) fn of_node(node: &Node<'_>) -> Result<Option<Self>, String> {
        let Some(text) = node.attribute("viewBox") else { return Ok(None) };
        match Numbers::from_str(text) {
            Ok(Numbers { x, y, w, h }) if w > 0.0 && h > 0.0 => Ok(Some(Self { at: [x, y], size: [w, h] })),
            Ok(Numbers { w, h, .. }) => {
                Err(format!("`viewBox` must have a width and a height, got {w} and {h}"))
            }
            Err(e) => Err(format!("`viewBox` must be four numbers, the last two above 0: {e}")),
        }
    }

    /// How it comes to lie in a viewport, as the element's `preserveAspectRatio` says.
    pub(super) fn fitted(&self, node: &Node<'_>, [width, height]: [f64; 2]) -> Affine {
        let text = node.attribute("preserveAspectRatio").unwrap_or_default();
        let aspect = AspectRatio::from_str(text).unwrap_or_default();
        let scales = [width / self.size[0], height / self.size[1]];
        let (less, more) = (scales[0].min(scales[1]), scales[0].max(scales[1]));
        let [sx, sy] = match (aspect.align, aspect.slice) {
            (Align::None, _) => scales,
            (_, false) => [less; 2],
            (_, true) => [more; 2],
        };
        let [share_x, share_y] = shares(aspect.align);
        let x = share_x * (width - sx * self.size[0]) - sx * self.at[0];
        let y = share_y * (height - sy * self.size[1]) - sy * self.at[1];
        Affine([sx, 0.0, 0.0, sy, x, y])
    }
}

/// Which share of the room that is left goes before the view box, along each axis.
fn shares(align: Align) -> [f64; 2] {
    match align {
        Align::None | Align::XMinYMin => [0.0, 0.0],
        Align::XMidYMin => [0.5, 0.0],
        Align::XMaxYMin => [1.0, 0.0],
        Align::XMinYMid => [0.0, 0.5],
        Align::XMidYMid => [0.5, 0.5],
        Align::XMaxYMid => [1.0, 0.5],
        Align::XMinYMax => [0.0, 1.0],
        Align::XMidYMax => [0.5, 1.0],
        Align::XMaxYMax => [1.0, 1.0],
    }
}

/// The size of the page that the root element asks for, in user units: `width` and `height` where they are lengths, the
/// view box where they are not.
///
/// # Errors
/// When neither gives a size.
pub(super) fn page(root: &Node<'_>, view: Option<ViewBox>) -> Result<[f64; 2], String> {
    let side = |name: &str| -> Result<Option<f64>, String> {
        let Some(text) = root.attribute(name).map(str::trim).filter(|t| *t != "auto") else {
            return Ok(None);
        };
        let length = length(text).map_err(|e| format!("`{name}` cannot be read: {e}"))?;
        // A share of a window that is not there.
        let Some(units) = user_units(&length) else { return Ok(None) };
        if units > 0.0 { Ok(Some(units)) } else { Err(format!("`{name}` must be above 0, got {text}")) }
    };
    match (side("width")?, side("height")?, view) {
        (Some(width), Some(height), _) => Ok([width, height]),
        (Some(width), None, Some(view)) => Ok([width, width * view.size[1] / view.size[0]]),
        (None, Some(height), Some(view)) => Ok([height * view.size[0] / view.size[1], height]),
        (None, None, Some(view)) => Ok(view.size),
        _ => Err("must have a viewBox, or a width and a height that are lengths".to_owned()),
    }
}
