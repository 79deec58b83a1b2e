//! Curves as values on wires.

use serde_json::{Map, Value as Json, json};

use super::{Curve, CurveSpec, Curves, Track};
use crate::value::{Feature, Features, Object, ObjectType, Pin, Sketch, SketchLine, Value};

/// Points drawn for each piece of a curve.
const STEPS: u32 = 14;
/// Steps between the values that a file of vectors holds of what changes along a curve.
const SPREAD: u32 = 32;

impl Object for Curves {
    const TYPE: &'static ObjectType = &ObjectType {
        name: "curves",
        color: [0, 178, 130],
        pin: Pin::Polygon { corners: 4, turn: 0.0 },
        sample_bytes: 0,
        guessed_bytes: 1 << 20,
        load: Some(load),
        has_features: true,
    };

    fn bytes(&self) -> u64 {
        self.iter().map(Curve::bytes).sum()
    }

    /// Curves are valid, whoever made them.
    fn fault(&self) -> Option<String> {
        None
    }

    fn sketch(&self) -> Sketch {
        Sketch::Lines(self.iter().map(Curve::sketch).collect())
    }

    fn save(&self) -> Vec<u8> {
        serde_json::to_vec(&self.specs()).unwrap_or_default()
    }

    /// Lines of short straight pieces, with heights where they have them, and the other values as properties of the names
    /// that `import_curves` has for them.
    fn features(&self) -> Features<'_> {
        Box::new(self.iter().map(|curve| Feature {
            line: curve.sketch(),
            weight: 1.0,
            properties: properties(curve),
        }))
    }
}

fn properties(curve: &Curve) -> Map<String, Json> {
    let mut found = Map::new();
    if !curve.name().is_empty() {
        found.insert("name".to_owned(), json!(curve.name()));
    }
    let tracks = curve.tracks();
    spread(&mut found, &tracks.elevation, ["height", "radius"]);
    spread(&mut found, &tracks.slope, ["left_extent", "right_extent", "left_angle", "right_angle"]);
    spread(&mut found, &tracks.noise, ["amplitude", "roughness"]);
    spread(&mut found, &tracks.envelope, ["left_blend", "right_blend"]);
    found
}

/// Enters the values of a group, each a number where it is the same all along, else a list of numbers spread evenly.
fn spread<const N: usize>(into: &mut Map<String, Json>, track: &Option<Track<N>>, names: [&str; N]) {
    let Some(track) = track else { return };
    for (k, name) in names.into_iter().enumerate() {
        let first = track.keys()[0].1[k];
        let value = if track.keys().iter().all(|(_, values)| values[k] == first) {
            json!(first)
        } else {
            let places = (0..=SPREAD).map(|i| f64::from(i) / f64::from(SPREAD));
            json!(places.map(|u| track.at(u)[k]).collect::<Vec<_>>())
        };
        into.insert(name.to_owned(), value);
    }
}

fn load(bytes: &[u8]) -> Option<Value> {
    let specs: Vec<CurveSpec> = serde_json::from_slice(bytes).ok()?;
    Some(Curves::from_specs(&specs).ok()?.into())
}

impl Curve {
    /// Points along it, some for each piece.
    pub fn sketch(&self) -> SketchLine {
        let length = self.length().max(1e-9);
        let mut line = Vec::new();
        for i in 0..self.pieces() {
            let (piece, [from, to]) = (self.piece(i), self.piece_span(i));
            for k in u32::from(i > 0)..=STEPS {
                let t = f64::from(k) / f64::from(STEPS);
                let u = (from + (to - from) * t) / length;
                line.push((piece.at(t), self.height(u)));
            }
        }
        line
    }
}
