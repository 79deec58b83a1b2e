//! Curves as values on wires.

use super::{Curve, CurveSpec, Curves};
use crate::value::{Object, ObjectType, Pin, Sketch, SketchLine, Value};

/// Points drawn for each piece of a curve.
const STEPS: u32 = 14;

impl Object for Curves {
    const TYPE: &'static ObjectType = &ObjectType {
        name: "curves",
        color: [0, 178, 130],
        pin: Pin::Polygon { corners: 4, turn: 0.0 },
        sample_bytes: 0,
        load: Some(load),
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
