//! The outlines of shapes: knots of cubic pieces in user units.

use super::arc::Arc;
use super::place::{Along, Viewport};
use super::tree::Node;
use crate::value::curves::MAX_PIECES;
use crate::value::curves::bezier::{Cubic, Point};

/// The outline of a `line`, `rect`, `circle` or `ellipse`; `None` where it has no length, as SVG says of sides and radii
/// of 0.
///
/// # Errors
/// Names the attribute that cannot be read or is below 0.
pub(super) fn outline(node: &Node<'_>, view: Viewport) -> Result<Option<Vec<Point>>, String> {
    match node.name() {
        "line" => line(node, view).map(Some),
        "rect" => rect(node, view),
        "circle" => {
            let r = size(node, view, "r", Along::Diagonal)?.unwrap_or(0.0);
            Ok(ellipse(middle(node, view)?, [r, r]))
        }
        _ => {
            let rx = size(node, view, "rx", Along::Width)?;
            let ry = size(node, view, "ry", Along::Height)?;
            // A radius that is not given is as the other.
            let radii = [rx.or(ry).unwrap_or(0.0), ry.or(rx).unwrap_or(0.0)];
            Ok(ellipse(middle(node, view)?, radii))
        }
    }
}

fn line(node: &Node<'_>, view: Viewport) -> Result<Vec<Point>, String> {
    let x = |name: &str| view.length(node, name, Along::Width).map(|x| x.unwrap_or(0.0));
    let y = |name: &str| view.length(node, name, Along::Height).map(|y| y.unwrap_or(0.0));
    let (from, to) = ([x("x1")?, y("y1")?], [x("x2")?, y("y2")?]);
    Ok(Cubic::straight(from, to).0.to_vec())
}

/// A length that may not be below 0.
fn size(node: &Node<'_>, view: Viewport, name: &str, along: Along) -> Result<Option<f64>, String> {
    match view.length(node, name, along)? {
        Some(size) if size < 0.0 => Err(format!("`{name}` must be 0 or above, got {size}")),
        size => Ok(size),
    }
}

fn middle(node: &Node<'_>, view: Viewport) -> Result<Point, String> {
    let x = view.length(node, "cx", Along::Width)?;
    let y = view.length(node, "cy", Along::Height)?;
    Ok([x.unwrap_or(0.0), y.unwrap_or(0.0)])
}

/// From the east over the south, as SVG has it.
fn ellipse([x, y]: Point, radii: [f64; 2]) -> Option<Vec<Point>> {
    let [rx, ry] = radii;
    if !(rx > 0.0 && ry > 0.0) {
        return None;
    }
    let corners = [[x + rx, y], [x, y + ry], [x - rx, y], [x, y - ry], [x + rx, y]];
    let mut knots = vec![corners[0]];
    corners.windows(2).for_each(|w| quarter(&mut knots, w[1], radii));
    Some(knots)
}

/// A rectangle, clockwise from its upper left corner, or from where the rounded corner ends.
fn rect(node: &Node<'_>, view: Viewport) -> Result<Option<Vec<Point>>, String> {
    let x = view.length(node, "x", Along::Width)?.unwrap_or(0.0);
    let y = view.length(node, "y", Along::Height)?.unwrap_or(0.0);
    let w = size(node, view, "width", Along::Width)?.unwrap_or(0.0);
    let h = size(node, view, "height", Along::Height)?.unwrap_or(0.0);
    let rx = size(node, view, "rx", Along::Width)?;
    let ry = size(node, view, "ry", Along::Height)?;
    if !(w > 0.0 && h > 0.0) {
        return Ok(None);
    }
    // A radius that is not given is as the other, and none is more than half a side.
    let (rx, ry) = (rx.or(ry).unwrap_or(0.0), ry.or(rx).unwrap_or(0.0));
    let (rx, ry) = (rx.min(w / 2.0), ry.min(h / 2.0));
    let (rx, ry) = if rx > 0.0 && ry > 0.0 { (rx, ry) } else { (0.0, 0.0) };
    let mut knots = vec![[x + rx, y]];
    // Each side, and the corner after it.
    for (side, corner) in [
        ([x + w - rx, y], [x + w, y + ry]),
        ([x + w, y + h - ry], [x + w - rx, y + h]),
        ([x + rx, y + h], [x, y + h - ry]),
        ([x, y + ry], [x + rx, y]),
    ] {
        straight(&mut knots, side);
        if rx > 0.0 {
            quarter(&mut knots, corner, [rx, ry]);
        }
    }
    Ok(Some(knots))
}

/// Goes on along a quarter of an ellipse, clockwise on the page.
fn quarter(knots: &mut Vec<Point>, to: Point, radii: [f64; 2]) {
    let Some(&from) = knots.last() else { return };
    let arc = Arc { from, to, radii, rotation: 0.0, large: false, sweep: true };
    knots.extend(arc.pieces().into_iter().flatten());
}

/// Goes on straight; where nothing lies between, not at all.
fn straight(knots: &mut Vec<Point>, to: Point) {
    let Some(&from) = knots.last() else { return };
    if from != to {
        knots.extend(Cubic::straight(from, to).0.into_iter().skip(1));
    }
}

/// The line of a `polyline` or `polygon`, and what broke it off. Of more pieces than a curve may have the rest is left
/// out: no curve comes of them.
pub(super) fn polyline(text: &str, closed: bool) -> (Vec<Point>, Option<String>) {
    let mut knots: Vec<Point> = Vec::new();
    let (mut x, mut fault) = (None, None);
    for number in svgtypes::NumberListParser::from(text) {
        match (number, x.take()) {
            (Ok(number), None) => x = Some(number),
            (Ok(y), Some(x)) if knots.is_empty() => knots.push([x, y]),
            (Ok(y), Some(x)) if knots.len() <= 3 * MAX_PIECES + 1 => straight(&mut knots, [x, y]),
            (Ok(_), Some(_)) => (),
            (Err(e), _) => {
                fault = Some(format!("`points` cannot be read: {e}"));
                break;
            }
        }
    }
    if let Some(x) = x.filter(|_| fault.is_none()) {
        fault = Some(format!("`points` ends with an x without a y, {x}"));
    }
    if let Some(&first) = knots.first().filter(|_| closed) {
        straight(&mut knots, first);
    }
    (knots, fault)
}
