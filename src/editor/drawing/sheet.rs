//! The drawn parameter of a node: curves, straight lines, a line through points, or strokes of a brush. The widget in the
//! schema of the kind says which, so that new kinds can be drawn on without changes here.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value as Json;

use crate::graph::{Graph, GraphNode, NodeId};
use crate::kit::paint::Stroke;
use crate::nodes::curves::short::{self, Grain, Ground};
use crate::params::Param;
use crate::units::{Metres, Ratio};
use crate::value::{Curve, CurveSpec};
use crate::widget::Widget;

/// The drawing of a node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Sheet {
    /// Feature curves.
    Curves(Vec<CurveSpec>),
    /// Straight lines: east and south of the start of each, then of its end.
    Lines(Vec<[f64; 4]>),
    /// Points that one curve goes through: east, south and, where the kind has heights, height.
    Trail(Vec<Vec<f64>>),
    /// Strokes of a brush.
    Strokes(Vec<Stroke>),
}

impl Sheet {
    /// The drawing of a node, and the name of its parameter; `None` where the kind has none or the value is malformed.
    pub(crate) fn of(graph: &Graph, id: NodeId) -> Option<(String, Self)> {
        let node = graph.get(id)?;
        let drawn = |p: &&Param| {
            matches!(p.widget, Some(Widget::Curves | Widget::CurveOnMap | Widget::Lines | Widget::Strokes))
        };
        let param = node.kind()?.params().iter().find(drawn)?;
        let sheet = match param.widget {
            Some(Widget::Curves) => Self::Curves(read(node, param)?),
            Some(Widget::Strokes) => Self::Strokes(read(node, param)?),
            // Of a kind that has lines of its own where none are set, none are there to be changed.
            Some(Widget::Lines) => Self::Lines(read::<Option<_>>(node, param)?.unwrap_or_default()),
            _ => {
                let points: Vec<Vec<f64>> = read(node, param)?;
                // A file written by hand may hold points with one number.
                Self::Trail(points.iter().all(|p| p.len() > 1).then_some(points)?)
            }
        };
        Some((param.name.clone(), sheet))
    }

    /// The value of the parameter.
    pub(crate) fn json(&self) -> Json {
        let value = match self {
            Self::Curves(specs) => serde_json::to_value(specs),
            Self::Lines(lines) => serde_json::to_value(lines),
            Self::Trail(points) => serde_json::to_value(points),
            Self::Strokes(strokes) => serde_json::to_value(strokes),
        };
        let mut value = value.unwrap_or_default();
        tidy(&mut value);
        value
    }

    /// What has to be set to make it of an earlier drawing: the parameter, or where one item has changed, as when a hand
    /// moves it, this item by its path; and its value.
    pub(crate) fn change(&self, before: &Self, param: &str) -> (String, Json) {
        let item = match (self, before) {
            (Self::Curves(now), Self::Curves(before)) => changed(now, before),
            (Self::Lines(now), Self::Lines(before)) => changed(now, before),
            (Self::Trail(now), Self::Trail(before)) => changed(now, before),
            (Self::Strokes(now), Self::Strokes(before)) => changed(now, before),
            _ => None,
        };
        match item {
            Some((i, item)) => (format!("{param}.{i}"), item),
            None => (param.to_owned(), self.json()),
        }
    }

    /// Number of curves.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Curves(specs) => specs.len(),
            Self::Lines(lines) => lines.len(),
            Self::Trail(points) => usize::from(!points.is_empty()),
            Self::Strokes(_) => 0,
        }
    }

    /// The control points of a curve.
    pub(super) fn places(&self, i: usize) -> Vec<[f64; 2]> {
        match self {
            Self::Curves(specs) => specs.get(i).map(CurveSpec::anchors).unwrap_or_default(),
            Self::Lines(lines) => {
                lines.get(i).map(|[a, b, c, d]| vec![[*a, *b], [*c, *d]]).unwrap_or_default()
            }
            Self::Trail(points) => points.iter().filter_map(|p| Some([*p.first()?, *p.get(1)?])).collect(),
            Self::Strokes(_) => Vec::new(),
        }
    }

    pub(crate) fn spec(&self, i: usize) -> Option<&CurveSpec> {
        match self {
            Self::Curves(specs) => specs.get(i),
            _ => None,
        }
    }

    /// The name of a curve, or its number where it has no name.
    pub(crate) fn name(&self, i: usize) -> String {
        match self.spec(i).filter(|s| !s.name.is_empty()) {
            Some(spec) => spec.name.clone(),
            None if matches!(self, Self::Lines(_)) => format!("line {}", i + 1),
            None => format!("curve {}", i + 1),
        }
    }

    /// A curve in its evaluated form; `None` where it has a fault.
    pub(super) fn build(&self, i: usize) -> Option<Curve> {
        match self {
            Self::Curves(specs) => specs.get(i)?.build().ok(),
            // A curve says something; what does not matter here.
            Self::Lines(lines) => {
                let line = lines.get(i)?.to_vec();
                CurveSpec { line, noise: vec![0.0, 0.0, 0.0], ..CurveSpec::default() }.build().ok()
            }
            Self::Trail(points) => trail(points),
            Self::Strokes(_) => None,
        }
    }
}

/// The parameter of a node, or its default; `None` where it is malformed.
fn read<T: DeserializeOwned>(node: &GraphNode, param: &Param) -> Option<T> {
    node.set.read(&param.name).unwrap_or_else(|| serde_json::from_value(param.default.clone())).ok()
}

/// The index and the value of the only item that differs between two lists of one length.
fn changed<T: PartialEq + Serialize>(now: &[T], before: &[T]) -> Option<(usize, Json)> {
    let mut different = now.iter().zip(before).enumerate().filter(|(_, (now, before))| now != before);
    let (i, (item, _)) = different.next()?;
    if now.len() != before.len() || different.next().is_some() {
        return None;
    }
    let mut value = serde_json::to_value(item).ok()?;
    tidy(&mut value);
    Some((i, value))
}

/// The curve that kinds with a line through points make of it.
fn trail(points: &[Vec<f64>]) -> Option<Curve> {
    let places: Vec<_> = points.iter().map(|p| Some([*p.first()?, *p.get(1)?])).collect::<Option<_>>()?;
    let heights: Option<Vec<f64>> = points.iter().map(|p| p.get(2).copied()).collect();
    // A curve without constraints is refused, so that this one sets noise, which is not used.
    let grain = Grain::Set { amplitude: Metres(0.0), roughness: Ratio(0.0) };
    let curves = short::curve("", &places, heights.as_deref(), Ground { grain, ..Ground::default() });
    curves.ok()?.iter().next().cloned()
}

/// Rounds all numbers to six decimals and writes whole ones without a decimal point.
pub(crate) fn tidy(json: &mut Json) {
    match json {
        Json::Number(n) => {
            let Some(x) = n.as_f64().filter(|_| n.is_f64()) else { return };
            let x = (x * 1e6).round() / 1e6;
            *json = if x == x.round() && x.abs() < 1e15 { Json::from(x as i64) } else { Json::from(x) };
        }
        Json::Array(items) => items.iter_mut().for_each(tidy),
        Json::Object(map) => map.values_mut().for_each(tidy),
        _ => (),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn strokes(ends: &[f64]) -> Sheet {
        let stroke = |end: &f64| Stroke { path: vec![0.0, 0.5, *end, 2.0], ..Stroke::default() };
        Sheet::Strokes(ends.iter().map(stroke).collect())
    }

    #[test]
    fn a_drawing_of_which_one_item_moved_is_changed_in_that_item() {
        let before = strokes(&[1.0, 2.0, 3.0]);
        let (path, value) = strokes(&[1.0, 5.0, 3.0]).change(&before, "strokes");
        assert_eq!((path.as_str(), &value["path"]), ("strokes.1", &json!([0, 0.5, 5, 2])));
        for other in
            [strokes(&[1.0, 2.0]), strokes(&[1.0, 2.0, 3.0, 4.0]), strokes(&[0.0, 2.0, 4.0]), before.clone()]
        {
            assert_eq!(other.change(&before, "strokes"), ("strokes".to_owned(), other.json()));
        }
        let lines = Sheet::Lines(vec![[0.0, 1.0, 2.0, 3.0]]);
        assert_eq!(lines.change(&before, "lines").0, "lines", "another sheet");
    }
}
