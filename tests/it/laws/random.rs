//! A build of many random graphs never panics and every field is finite, whatever is wired to whatever.

use orograph::engine::{Unobserved, Want};
use orograph::graph::Graph;
use orograph::node::{Cancel, Kind};
use proptest::prelude::*;

use crate::kinds::registry;
use crate::rig::graph::engine;
use crate::rig::{grid, shipped};

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]
    #[test]
    fn graphs_evaluate_or_say_why(picks in prop::collection::vec((any::<u16>(), any::<[u8; 4]>()), 2..9)) {
        let kinds: Vec<_> = shipped().into_iter().filter(|k| k.family != "files").collect();
        let mut g = Graph::with_registry(registry());
        g.assign("terrain.base", "17").unwrap();
        let mut made: Vec<(String, &'static Kind)> = Vec::new();
        for (pick, wires) in picks {
            let kind = kinds[pick as usize % kinds.len()];
            let name = format!("n{}", made.len());
            let id = g.add(&name, &kind.id).unwrap();
            for (i, port) in kind.inputs.iter().enumerate() {
                if made.is_empty() { break; }
                let (from, source) = &made[wires[i % 4] as usize % made.len()];
                let output = source.outputs[wires[(i + 1) % 4] as usize % source.outputs.len()].name.clone();
                // A wire of the wrong type is refused, and that is a fair outcome.
                let _ = g.connect(g.find(from).unwrap(), &output, id, &port.name);
            }
            made.push((name, kind));
        }
        let text = g.canonical();
        let again = Graph::from_bytes(&text, &registry()).unwrap();
        prop_assert_eq!(&again.canonical(), &text);
        let e = engine(2);
        for (name, kind) in &made {
            let want = Want { node: g.find(name).unwrap(), port: kind.outputs[0].name.clone(), grid: grid(g.terrain(), 17) };
            let all = e.evaluate(&g, &[want], &Unobserved, &Cancel::default()).unwrap();
            if let Err(failure) = &all.values[0] {
                prop_assert!(!failure.to_string().contains("bug"), "{}", failure);
                prop_assert!(!failure.to_string().contains("not finite"), "{}", failure);
            }
        }
    }
}
