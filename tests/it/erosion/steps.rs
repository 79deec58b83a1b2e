//! Half the step is nearly the same land.

use super::land::{island, run, site};
use orograph::kit::erosion::hydraulic::Settings;

#[test]
fn half_the_step_changes_little() {
    let (n, cell, seconds) = (129, 64.0, 1800.0);
    let land = site(n, cell, island(n, 700.0, 6), 54.0, true);
    let mut last: Option<Vec<f32>> = None;
    for courant in [0.7, 0.35, 0.175, 0.09] {
        let settings = Settings {
            courant,
            capacity: 30.0,
            rock_erodibility: 0.004,
            loose_erodibility: 0.02,
            ..Settings::default()
        };
        let steps = (seconds / settings.longest_step(cell)).round() as usize;
        let run = run(land.clone(), &settings, steps);
        let change: Vec<f32> = (0..n * n).map(|k| run.state().change(run.site(), k)).collect();
        if let Some(last) = last {
            let rms = |of: &dyn Fn(usize) -> f32| {
                let on_land = (0..n * n).filter(|k| land.height[*k] > 0.0);
                let squares: Vec<f64> = on_land.map(|k| f64::from(of(k)) * f64::from(of(k))).collect();
                (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
            };
            let (off, moved) = (rms(&|k| change[k] - last[k]), rms(&|k| change[k]));
            println!("{courant}: {off:.3} of {moved:.3} m");
            assert!(off < 0.1 * moved, "steps of {courant} cells: {off} m of {moved} m");
        }
        last = Some(change);
    }
}
