//! Failures, warnings and cancellation (laws 8, 9 and 12).

use std::sync::Mutex;

use orograph::engine::{Engine, EngineError, Files, Observer, Options, Unobserved, Want};
use orograph::node::Cancel;
use serde_json::json;

use super::{engine, evaluate, graph, grid, want};

#[test]
fn failures_name_the_node_and_stop_only_what_needs_it() {
    let g = graph(json!({
        "hills": { "kind": "waves" },
        "bad": { "kind": "not_a_number" },
        "mixed": { "kind": "sum", "in": { "a": "hills.field", "b": "bad.field" } },
        "loose": { "kind": "sum", "in": { "a": "hills.field" } },
        "strange": { "kind": "erode_by_magic" },
        "over": { "kind": "copy", "in": { "field": "strange.field" } },
        "panics": { "kind": "panics" },
        "secret": { "kind": "secret_seed" },
        "wrong": { "kind": "wrong_grid" },
        "other": { "kind": "wrong_quantity" },
        "steep": { "kind": "waves", "set": { "height": 1e99 } },
    }));
    let names = ["hills", "bad", "mixed", "loose", "over", "panics", "secret", "wrong", "steep", "other"];
    let wants: Vec<_> = names.iter().map(|n| want(&g, n, grid(&g, 65))).collect();
    let all = engine(2).evaluate(&g, &wants, &Unobserved, &Cancel::default()).unwrap();
    assert!(all.values[0].is_ok(), "what does not need them is made");
    let says = |i: usize, words: &str| {
        let message = all.values[i].as_ref().unwrap_err().to_string();
        assert!(message.contains(words), "{}: {message}", names[i]);
    };
    says(1, "node `bad`: output `field` is not finite at column 0, row 3");
    says(2, "node `bad`");
    says(9, "output `field` is slope, and the kind says number");
    says(3, "node `loose`: input `b` is not connected");
    says(4, "erode_by_magic");
    says(5, "node `panics`: stopped by a bug of its kind: the kind has a bug");
    says(6, "node `secret`: the kind asks for `SEED` and does not declare it");
    says(7, "node `wrong`: output `field` stands on");
    says(8, "node `steep`: parameter `height` must be a number from");
}

/// Cancels at the first sign of work.
struct Stop<'a>(&'a Cancel, Mutex<usize>);

impl Observer for Stop<'_> {
    fn started(&self, _: usize) {
        *self.1.lock().unwrap() += 1;
        self.0.cancel();
    }
}

#[test]
fn cancelling_stops_inside_a_node_and_leaves_the_engine_usable() {
    let g =
        graph(json!({ "slow": { "kind": "slow", "set": { "seconds": 60 } }, "hills": { "kind": "waves" } }));
    let e = engine(1);
    let cancel = Cancel::default();
    let stop = Stop(&cancel, Mutex::new(0));
    let start = std::time::Instant::now();
    let ended = e.evaluate(&g, &[want(&g, "slow", grid(&g, 65))], &stop, &cancel);
    assert!(matches!(ended, Err(EngineError::Cancelled)));
    assert!(start.elapsed().as_secs() < 30);
    assert_eq!(*stop.1.lock().unwrap(), 1);
    assert!(evaluate(&e, &g, "hills", grid(&g, 65)).values[0].is_ok());
}

/// A result says the same whether it was computed or is in memory, for any number of threads; what was warned of is
/// never found on disk.
#[test]
fn warnings_stay_with_a_result() {
    let g = graph(json!({ "a": { "kind": "grumbles" } }));
    let folder = tempfile::tempdir().expect("a folder");
    let grid = g.terrain().grid(65).expect("a grid");
    let run = |e: &Engine| {
        let want = Want { node: g.find("a").expect("a node"), port: "field".into(), grid };
        let all = e.evaluate(&g, &[want], &Unobserved, &Cancel::default()).expect("an evaluation");
        all.tasks.into_iter().map(|t| (t.cached, t.warnings)).collect::<Vec<_>>()
    };
    let said = vec!["row 0".to_owned(), "row 1".to_owned(), "row 2".to_owned()];
    for threads in [1, 3] {
        let cache = Some(folder.path().to_owned());
        let e = Engine::new(&Options { threads, cache, ..Options::default() }, Files::default());
        let e = e.expect("an engine");
        assert_eq!(run(&e), [(None, said.clone())]);
        assert_eq!(run(&e), [(Some("memory"), said.clone())]);
    }
}
