//! Numbers with a unit: what the parameters of nodes are made of.
//!
//! Each is a transparent `f64` whose JSON schema carries the unit and the widest range; a parameter narrows the
//! range with `#[schemars(range(min = …, max = …))]`.

use crate::widget::Widget;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

macro_rules! units {
    ($($(#[$meta:meta])* $name:ident = $unit:literal, $min:expr, $max:expr;)+) => {$(
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(pub f64);

        impl JsonSchema for $name {
            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($name).into()
            }
            fn inline_schema() -> bool {
                true
            }
            fn json_schema(_: &mut SchemaGenerator) -> Schema {
                json_schema!({ "type": "number", "minimum": $min, "maximum": $max, "x-unit": $unit })
            }
        }

        impl From<$name> for f64 {
            fn from(value: $name) -> Self {
                value.0
            }
        }

        impl std::ops::Mul<f64> for $name {
            type Output = f64;
            fn mul(self, factor: f64) -> f64 {
                self.0 * factor
            }
        }
    )+};
}

units! {
    /// A length, distance or height, in metres.
    Metres = "m", -2.0e7, 2.0e7;
    /// An area, in square metres.
    SquareMetres = "m2", 0.0, 4.0e14;
    /// A time, in years.
    Years = "a", 0.0, 1.0e9;
    /// A time, in hours.
    Hours = "h", 0.0, 1.0e9;
    /// A time, in seconds.
    Seconds = "s", 0.0, 1.0e9;
    /// A speed, in m/s.
    MetresPerSecond = "m/s", 0.0, 1.0e4;
    /// A discharge, in m³/s.
    Discharge = "m3/s", 0.0, 1.0e9;
    /// Rain or evaporation, in mm/h.
    MillimetresPerHour = "mm/h", 0.0, 1.0e6;
    /// An angle, in degrees.
    Degrees = "deg", -360.0, 360.0;
    /// A share from 0 to 1.
    Ratio = "1", 0.0, 1.0;
    /// A plain number without a unit.
    Number = "1", -1.0e9, 1.0e9;
    /// A curvature, in 1/m.
    PerMetre = "1/m", -10.0, 10.0;
}

/// The seed of a node: drawn when the node is made, stored in the file, mixed with the seed of the graph.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Seed(pub u32);

impl JsonSchema for Seed {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Seed".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "integer", "minimum": 0, "maximum": u32::MAX, "x-unit": "1", "x-widget": Widget::Seed })
    }
}

/// The name of a file beside the graph, or below a folder that the user allowed; empty for none.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct FilePath(pub String);

impl JsonSchema for FilePath {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "FilePath".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "maxLength": 1024, "x-widget": Widget::File })
    }
}
