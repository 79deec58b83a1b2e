//! Budgets of memory and time (law 10).

use orograph::engine::{Engine, EngineError, Files, Options, Unobserved};
use orograph::node::Cancel;

use super::{bits, chain, engine, evaluate, field, grid, want};

#[test]
fn budgets_that_are_exceeded_refuse_the_evaluation() {
    let g = chain();
    let options = Options { memory: 1 << 20, threads: 1, ..Options::default() };
    let e = Engine::new(&options, Files::default()).unwrap();
    let wants = [want(&g, "end", grid(&g, 2049))];
    match e.evaluate(&g, &wants, &Unobserved, &Cancel::default()) {
        Err(EngineError::Memory { need, budget, at, .. }) => {
            assert!(need > 30 << 20 && budget == 1 << 20, "{need}");
            assert!(at.starts_with("node `"), "{at}");
        }
        other => panic!("refused, not {other:?}"),
    }
    let options = Options { seconds: 1e-6, threads: 1, ..Options::default() };
    let e = Engine::new(&options, Files::default()).unwrap();
    let refused = e.evaluate(&g, &wants, &Unobserved, &Cancel::default());
    assert!(matches!(refused, Err(EngineError::Time { .. })));
}

#[test]
fn budgets_that_are_tight_give_the_same_bits() {
    let g = chain();
    let wide = evaluate(&engine(2), &g, "end", grid(&g, 513));
    let options = Options { memory: wide.planned_bytes / 10 * 11 + 10, threads: 2, ..Options::default() };
    let tight = Engine::new(&options, Files::default()).unwrap();
    let narrow = evaluate(&tight, &g, "end", grid(&g, 513));
    assert_eq!(bits(&field(&wide, 0)), bits(&field(&narrow, 0)));
    assert!(narrow.peak_bytes <= options.memory, "{} of {}", narrow.peak_bytes, options.memory);
    assert!(tight.cached_bytes() <= options.memory);
}
