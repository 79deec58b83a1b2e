//! Rivers do not keep to the directions of the grid.

use super::land::{island, run, site};
use orograph::kit::erosion::hydraulic::{Run, Settings};

const N: usize = 257;

/// Mean cosines of four and eight times the direction of the flow, over the 4 % of land with most of it, by the root of it.
fn harmonics(run: &Run) -> [f64; 2] {
    let (site, state) = (run.site(), run.state());
    let inner = |k: usize| (3..N - 3).contains(&(k % N)) && (3..N - 3).contains(&(k / N));
    let land = |k: &usize| inner(*k) && site.height[*k] + state.change(site, *k) > 5.0;
    let flow = |k: usize| state.vector(site, k).map(f64::from);
    let mut flows: Vec<_> =
        (0..N * N).filter(land).map(flow).map(|[x, y]| (libm::hypot(x, y), libm::atan2(y, x))).collect();
    flows.sort_by(|a, b| b.0.total_cmp(&a.0));
    flows.truncate(flows.len() / 25);
    let weight: f64 = flows.iter().map(|(q, _)| q.sqrt()).sum();
    [4.0, 8.0].map(|n| flows.iter().map(|(q, turn)| q.sqrt() * libm::cos(n * turn)).sum::<f64>() / weight)
}

#[test]
fn rivers_are_not_pulled_to_the_grid() {
    let settings = Settings {
        capacity: 30.0,
        rock_erodibility: 0.004,
        loose_erodibility: 0.02,
        rock_repose: 1e3,
        loose_repose: 1e3,
        ..Settings::default()
    };
    let mut mean = [0.0; 2];
    for seed in 5..9 {
        let land = site(N, 32.0, island(N, 500.0, seed), 54.0, true);
        let found = harmonics(&run(land, &settings, 1200));
        println!("seed {seed}: {found:.3?}");
        mean = [mean[0] + found[0] / 4.0, mean[1] + found[1] / 4.0];
    }
    println!("mean: {mean:.3?}");
    assert!(mean[0].abs() < 0.1 && mean[1].abs() < 0.15, "pulled to the grid by {mean:.3?}");
}
