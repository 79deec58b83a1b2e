//! The state of a running node: shown to who looks, part of no result.

use std::sync::Mutex;

use orograph::engine::{Observer, Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::Cancel;
use orograph::value::Value;
use serde_json::json;

use super::{engine, grid};
use crate::kinds::registry;

/// Looks at an output and keeps the columns of its states.
struct Look(&'static str, Mutex<Vec<usize>>);

impl Observer for Look {
    fn looks(&self, _: usize, port: &str) -> bool {
        port == self.0
    }

    fn state(&self, _: usize, port: &str, value: Value) {
        let Value::Field(field) = value else { panic!("a state of another type") };
        assert_eq!(port, self.0);
        assert!(field.data().iter().all(|height| height.is_finite()));
        self.1.lock().unwrap().push(field.grid().cols);
    }
}

#[test]
fn each_level_of_erosion_is_a_state() {
    for kind in ["hydraulic_erosion", "stream_power"] {
        let file = json!({
            "orograph": 1,
            "terrain": { "width": 4096, "depth": 2048, "base": 129 },
            "nodes": {
                "hills": { "kind": "fractal_noise" },
                "rain": { "kind": kind, "in": { "height": "hills.field" }, "set": { "duration": 0.3 } },
            },
            "outputs": {},
        });
        let g = Graph::from_bytes(file.to_string().as_bytes(), &registry()).unwrap();
        let wants = [Want { node: g.find("rain").unwrap(), port: "height".into(), grid: grid(&g, 129) }];
        let look = Look("height", Mutex::default());
        let seen = engine(2).evaluate(&g, &wants, &look, &Cancel::default()).unwrap();
        let columns = look.1.into_inner().unwrap();
        let base = g.terrain().base as usize;
        assert!(columns.first() == Some(&65) && columns.last() == Some(&base), "{kind}: {columns:?}");
        assert!(columns.windows(2).all(|pair| pair[0] < pair[1]), "{kind}: {columns:?}");
        let unseen = engine(2).evaluate(&g, &wants, &Unobserved, &Cancel::default()).unwrap();
        assert!(
            seen.values[0].as_ref().unwrap() == unseen.values[0].as_ref().unwrap(),
            "{kind}: another result"
        );
        // Who looks at another output sees nothing, and what is in memory has no state.
        let other = Look("wear", Mutex::default());
        let e = engine(2);
        e.evaluate(&g, &wants, &other, &Cancel::default()).unwrap();
        let again = Look("height", Mutex::default());
        e.evaluate(&g, &wants, &again, &Cancel::default()).unwrap();
        assert!(other.1.into_inner().unwrap().is_empty() && again.1.into_inner().unwrap().is_empty());
    }
}
