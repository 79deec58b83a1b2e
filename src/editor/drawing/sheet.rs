//! The drawn parameter of a node: curves, a line through points, or strokes of a brush. The widget in the schema of the
//! kind says which, so that new kinds can be drawn on without changes here.

use serde_json::Value as Json;

use crate::graph::{Graph, NodeId};
use crate::kit::paint::Stroke;
use crate::nodes::curves::short::{self, Grain, Ground};
use crate::units::{Metres, Ratio};
use crate::value::{Curve, CurveSpec};
use crate::widget::Widget;

/// The drawing of a node.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Sheet {
    /// Feature curves.
    Curves(Vec<CurveSpec>),
    /// Points that one curve goes through: east, south and, where the kind has heights, height.
    Trail(Vec<Vec<f64>>),
    /// Strokes of a brush.
    Strokes(Vec<Stroke>),
}

impl Sheet {
    /// The drawing of a node, and the name of its parameter; `None` where the kind has none or the value is malformed.
    pub(crate) fn of(graph: &Graph, id: NodeId) -> Option<(String, Self)> {
        let node = graph.get(id)?;
        let drawn = |p: &&crate::params::Param| {
            matches!(p.widget, Some(Widget::Curves | Widget::CurveOnMap | Widget::Strokes))
        };
        let param = node.kind()?.params().iter().find(drawn)?;
        let value = node.set.get(&param.name).unwrap_or(&param.default).clone();
        let sheet = match param.widget {
            Some(Widget::Curves) => Self::Curves(serde_json::from_value(value).ok()?),
            Some(Widget::Strokes) => Self::Strokes(serde_json::from_value(value).ok()?),
            _ => {
                let points: Vec<Vec<f64>> = serde_json::from_value(value).ok()?;
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
            Self::Trail(points) => serde_json::to_value(points),
            Self::Strokes(strokes) => serde_json::to_value(strokes),
        };
        let mut value = value.unwrap_or_default();
        tidy(&mut value);
        value
    }

    /// Number of curves.
    pub(crate) fn len(&self) -> usize {
        match self {
            Self::Curves(specs) => specs.len(),
            Self::Trail(points) => usize::from(!points.is_empty()),
            Self::Strokes(_) => 0,
        }
    }

    /// The control points of a curve.
    pub(super) fn places(&self, i: usize) -> Vec<[f64; 2]> {
        match self {
            Self::Curves(specs) => specs.get(i).map(CurveSpec::anchors).unwrap_or_default(),
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
            None => format!("curve {}", i + 1),
        }
    }

    /// A curve in its evaluated form; `None` where it has a fault.
    pub(super) fn build(&self, i: usize) -> Option<Curve> {
        match self {
            Self::Curves(specs) => specs.get(i)?.build().ok(),
            Self::Trail(points) => trail(points),
            Self::Strokes(_) => None,
        }
    }
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
