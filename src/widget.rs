//! How panels show parameters.

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

/// How a panel shows a parameter whose shape alone does not say it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Widget {
    /// A transfer curve with points to drag.
    Curve,
    /// A line that is drawn on the terrain.
    CurveOnMap,
    /// Feature curves that are drawn on the terrain.
    Curves,
    /// A path to a file, with a dialog.
    File,
    /// A ramp of colours.
    Gradient,
    /// Straight lines that are drawn on the terrain, each east and south of its start and of its end.
    Lines,
    /// A place, east and south.
    Point,
    /// A number with a dice.
    Seed,
    /// Strokes of a brush on the terrain.
    Strokes,
}

impl Widget {
    /// What a schema says under `x-widget`, if it says something; `None` where that is no widget.
    pub fn in_schema(schema: &Json) -> Option<Option<Self>> {
        let written = schema.get("x-widget");
        written.map_or(Some(None), |text| Self::deserialize(text).ok().map(Some))
    }
}
