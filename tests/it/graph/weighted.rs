//! A kind that is made while the program runs: nothing of its ports and parameters stands in a source file.

use std::sync::Arc;

use orograph::name::Name;
use orograph::node::{AnyNode, Context, Kind, Reach, Result};
use orograph::nodes::Registry;
use orograph::ports::{Meaning, Port, Wires};
use orograph::value::{Field, Quantity, Value, WireType};
use serde_json::{Map, Value as Json, json};

/// The sum of some inputs, each times a parameter of the same name.
#[derive(Debug)]
struct Weighted {
    weights: Vec<(Name, f64)>,
}

impl AnyNode for Weighted {
    fn reach(&self) -> Reach {
        Reach::Point
    }

    fn uses(&self, port: &str) -> bool {
        self.weights.iter().any(|(name, weight)| name == port && *weight != 0.0)
    }

    fn run(&self, cx: &Context<'_>, wires: Wires) -> Result<Wires> {
        let mut sum = vec![0.0; cx.grid.len()];
        for (name, weight) in &self.weights {
            if let Some(Value::Field(field)) = wires.get(name) {
                let field = field.crop(&cx.grid);
                sum.iter_mut().zip(field.data()).for_each(|(sum, x)| *sum += *weight as f32 * x);
            }
        }
        let sum = Field::new(cx.grid, Quantity::Length, sum);
        Ok([(Name::new("the sum"), Value::Field(sum))].into_iter().collect())
    }

    fn canonical(&self) -> Json {
        self.weights.iter().map(|(name, weight)| (name.to_string(), json!(weight + 0.0))).collect()
    }
}

/// A kind `weighted` with inputs and parameters of some names, and an output `the sum`.
pub(crate) fn kind(names: &[String]) -> Kind {
    let port = |name: &str, wire, required, meaning| Port {
        name: Name::new(name),
        doc: Name::new(format!("What is called {name}.")),
        wire,
        required,
        meaning,
    };
    let own: Vec<Name> = names.iter().map(Name::new).collect();
    let parse = move |set: &Map<String, Json>| -> Result<Arc<dyn AnyNode>> {
        let set_to = |name: &Name| set.get(name.as_str())?.as_f64();
        let weight = |name: &Name| (name.clone(), set_to(name).unwrap_or(1.0));
        Ok(Arc::new(Weighted { weights: own.iter().map(weight).collect() }))
    };
    let parameter = |name: &String| {
        let schema = json!({ "type": "number", "minimum": -9, "maximum": 9, "description": "Its weight.", "x-unit": "1" });
        (name.clone(), schema)
    };
    let schema = json!({
        "type": "object",
        "description": "Adds what it reads.\n\nEach with a weight.",
        "properties": names.iter().map(parameter).collect::<serde_json::Map<_, _>>(),
    });
    let defaults = names.iter().map(|name| (name.clone(), json!(1.0))).collect();
    let mut kind = Kind::new("made", "weighted", parse).with_parameters(schema, defaults);
    let input = |name: &String| port(name, WireType::Field, false, Meaning::Nothing);
    kind.inputs = names.iter().map(input).collect();
    kind.outputs = vec![port("the sum", WireType::Field, true, Meaning::Fixed(Quantity::Length))];
    kind.keywords = vec![Name::new("heap")];
    let mixed = names.first().map(|name| (Name::new("the sum"), Name::new(name)));
    kind.mixing(mixed.into_iter().collect())
}

/// The shipped kinds, and `weighted` with two inputs.
pub(crate) fn registry() -> Registry {
    let names: Vec<String> = ["left", "right"].map(|side| format!("the weight of what stands {side}")).into();
    Registry::standard().with([kind(&names)])
}
