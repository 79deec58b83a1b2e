//! Lakes: full ones are level, and water that flows in flows out.

use super::land::{run, site, still};

#[test]
fn a_full_lake_is_level_to_a_millimetre() {
    // A bowl 400 m deep at 2000 m, with a notch: rain on its rim runs in and over the notch.
    let n = 65;
    let bowl = |k: usize| {
        let [x, y] = [(k % n) as f64 - 32.0, (k / n) as f64 - 32.0];
        let r = (x * x + y * y).sqrt();
        let rim = if r < 26.0 { -400.0 * (1.0 - r * r / 676.0) } else { 2.0 * (28.0 - r).min(0.0) };
        let notch = if x > 0.0 && y.abs() < 1.5 { 4.0 } else { 0.0 };
        (2000.0 + rim - if r > 20.0 { notch } else { 0.0 }) as f32
    };
    let mut site = site(n, 25.0, (0..n * n).map(bowl).collect(), 20.0, false);
    let level = 1996.0;
    for k in 0..n * n {
        let [x, y] = [(k % n) as f64 - 32.0, (k / n) as f64 - 32.0];
        if x * x + y * y < 26.0 * 26.0 {
            site.filled[k] = site.height[k].max(level);
        }
    }
    let run = run(site, &still(), 1500);
    let (site, state) = (run.site(), run.state());
    let deep: Vec<_> = (0..n * n).filter(|&k| state.depth(site, k) > 20.0).collect();
    let above = |&k: &usize| f64::from(site.filled[k] - level) + f64::from(state.water[k]);
    let low = deep.iter().map(above).fold(f64::INFINITY, f64::min);
    let high = deep.iter().map(above).fold(f64::NEG_INFINITY, f64::max);
    println!("{} cells from {low} to {high} m over the level", deep.len());
    assert!(deep.len() > 500 && high - low < 1e-3, "from {low} to {high} m");
    assert!(low > 0.0 && high < 1.0, "rain should pass through: {low} to {high} m");
}
