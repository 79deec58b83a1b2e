//! From the properties of a line in a file to the constraints of its curve.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::units::Number;
use crate::value::Curve;
use crate::value::curves::bezier::Point;
use crate::value::curves::{ConstraintPoint, Elevation, Envelope, Fault, MAX_POINTS, Noise, Rise, Slope};

/// Where a value of the constraints comes from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Source {
    /// From nowhere.
    #[default]
    None,
    /// From the third coordinate of each position.
    Z {
        /// Multiplies it.
        #[serde(default = "one")]
        factor: Number,
    },
    /// It is the same on all lines.
    Value {
        /// The value.
        value: Number,
    },
    /// From a property of the line: a number, or a list of numbers spread evenly over its length.
    Property {
        /// Name of the property; of an SVG element `data-NAME` or `NAME`.
        #[schemars(length(max = 256))]
        name: String,
        /// Multiplies it.
        #[serde(default = "one")]
        factor: Number,
    },
}

fn one() -> Number {
    Number(1.0)
}

/// Which properties of a line become which constraints. A group is set where one of its values is; others of the
/// group are then 0, the roughness 0.5.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Mapping {
    /// Height, in metres.
    pub height: Source,
    /// Radius of the plateau, in metres; alone it sets nothing.
    pub radius: Source,
    /// Extent of the slope to the left, in metres.
    pub left_extent: Source,
    /// Extent of the slope to the right, in metres.
    pub right_extent: Source,
    /// Angle of the slope on the left, in degrees, positive where the ground rises away from the curve.
    pub left_angle: Source,
    /// Angle of the slope on the right, in degrees.
    pub right_angle: Source,
    /// Amplitude of the noise, in metres.
    pub amplitude: Source,
    /// Roughness of the noise, from 0 to 1; alone it sets nothing.
    pub roughness: Source,
    /// Width of the smoothed strip on the left, in metres.
    pub left_blend: Source,
    /// Width of the smoothed strip on the right, in metres.
    pub right_blend: Source,
}

/// A property of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Property {
    /// One number.
    Number(f64),
    /// Numbers spread evenly over the length.
    List(Vec<f64>),
}

impl Property {
    /// Its numbers.
    pub fn numbers(&self) -> &[f64] {
        match self {
            Self::Number(number) => std::slice::from_ref(number),
            Self::List(list) => list,
        }
    }
}

/// A line of a file.
pub(super) struct Line<'a> {
    pub(super) name: String,
    pub(super) knots: Vec<Point>,
    /// Third coordinates at shares of the length, where the file has them.
    pub(super) z: Vec<(f64, f64)>,
    /// The property of a name; what is wrong with it when it is there and no number.
    pub(super) property: &'a dyn Fn(&str) -> Result<Option<Property>, String>,
}

/// Why a line gives no curve.
pub(super) enum Refusal {
    /// A property that the mapping names cannot be used.
    Property(String),
    /// No curve may be like this.
    Curve(String),
}

/// Values at rising shares of the length.
type Values = Vec<(f64, f64)>;

impl Mapping {
    /// The curve of a line; `None` when nothing is set on it.
    pub(super) fn curve(&self, line: Line<'_>) -> Result<Option<Curve>, Refusal> {
        let get = |source: &Source| line.values(source).map_err(Refusal::Property);
        let (height, radius) = (get(&self.height)?, get(&self.radius)?);
        let slope = [&self.left_extent, &self.right_extent, &self.left_angle, &self.right_angle];
        let [a, b, left, right] = [get(slope[0])?, get(slope[1])?, get(slope[2])?, get(slope[3])?];
        let (amplitude, roughness) = (get(&self.amplitude)?, get(&self.roughness)?);
        let (blend_left, blend_right) = (get(&self.left_blend)?, get(&self.right_blend)?);
        let mut points: Vec<ConstraintPoint> = Vec::new();
        if let Some(h) = &height {
            points.extend(places(&[&height, &radius]).map(|u| ConstraintPoint {
                u,
                elevation: Some(Elevation { height: at(h, u), radius: value(&radius, u, 0.0) }),
                ..ConstraintPoint::default()
            }));
        }
        if a.is_some() || b.is_some() {
            points.extend(places(&[&a, &b, &left, &right]).map(|u| {
                let slope = Slope {
                    left_extent: value(&a, u, 0.0),
                    right_extent: value(&b, u, 0.0),
                    left_angle: value(&left, u, 0.0),
                    right_angle: value(&right, u, 0.0),
                };
                ConstraintPoint { u, slope: Some(slope), ..ConstraintPoint::default() }
            }));
        }
        if let Some(amplitude) = &amplitude {
            points.extend(places(&[&Some(amplitude.clone()), &roughness]).map(|u| {
                let noise = Noise { amplitude: at(amplitude, u), roughness: value(&roughness, u, 0.5) };
                ConstraintPoint { u, noise: Some(noise), ..ConstraintPoint::default() }
            }));
        }
        if blend_left.is_some() || blend_right.is_some() {
            points.extend(places(&[&blend_left, &blend_right]).map(|u| {
                let envelope =
                    Envelope { left: value(&blend_left, u, 0.0), right: value(&blend_right, u, 0.0) };
                ConstraintPoint { u, envelope: Some(envelope), ..ConstraintPoint::default() }
            }));
        }
        if points.is_empty() {
            return Ok(None);
        }
        let made = Curve::new(line.name, line.knots, &points, Rise::Monotone);
        made.map(Some).map_err(|Fault(message)| Refusal::Curve(message))
    }

    /// The properties that it reads.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.sources().into_iter().filter_map(|source| match source {
            Source::Property { name, .. } => Some(name.as_str()),
            Source::None | Source::Z { .. } | Source::Value { .. } => None,
        })
    }

    fn sources(&self) -> [&Source; 10] {
        [
            &self.height,
            &self.radius,
            &self.left_extent,
            &self.right_extent,
            &self.left_angle,
            &self.right_angle,
            &self.amplitude,
            &self.roughness,
            &self.left_blend,
            &self.right_blend,
        ]
    }
}

impl Line<'_> {
    fn values(&self, source: &Source) -> Result<Option<Values>, String> {
        let scaled = |values: Values, factor: f64| {
            let scaled: Values = values.into_iter().map(|(u, v)| (u, v * factor)).collect();
            Ok((!scaled.is_empty()).then_some(scaled))
        };
        match source {
            Source::None => Ok(None),
            Source::Value { value } => Ok(Some(vec![(0.0, value.0)])),
            Source::Z { factor } => scaled(self.z.clone(), factor.0),
            Source::Property { name, factor } => match (self.property)(name)? {
                None => Ok(None),
                Some(Property::Number(v)) => scaled(vec![(0.0, v)], factor.0),
                Some(Property::List(list)) if list.len() > MAX_POINTS => {
                    Err(format!("property `{name}` may list {MAX_POINTS} numbers, got {}", list.len()))
                }
                Some(Property::List(list)) => {
                    let last = list.len().saturating_sub(1).max(1) as f64;
                    let spread = list.into_iter().enumerate().map(|(i, v)| (i as f64 / last, v));
                    scaled(spread.collect(), factor.0)
                }
            },
        }
    }
}

/// Every share at which one of some values is given.
fn places(all: &[&Option<Values>]) -> impl Iterator<Item = f64> {
    let mut us: Vec<f64> = all.iter().flat_map(|v| v.iter().flatten().map(|p| p.0)).collect();
    us.sort_by(f64::total_cmp);
    us.dedup();
    us.into_iter()
}

fn value(values: &Option<Values>, u: f64, default: f64) -> f64 {
    values.as_ref().map_or(default, |v| at(v, u))
}

/// Linear between, held beyond the ends; there is at least one.
pub(super) fn at(values: &[(f64, f64)], u: f64) -> f64 {
    let i = values.partition_point(|p| p.0 <= u);
    match (i.checked_sub(1).map(|k| values[k]), values.get(i)) {
        (Some((u0, a)), Some(&(u1, b))) => a + (b - a) * ((u - u0) / (u1 - u0)),
        (Some((_, a)), None) => a,
        (None, Some(&(_, b))) => b,
        (None, None) => 0.0,
    }
}
