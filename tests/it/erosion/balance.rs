//! Neither solid nor water is made or lost, step by step.

use orograph::kit::erosion::hydraulic::{Account, Border, Run, Settings, Site, State};
use orograph::work::Work;

use super::land::{fractal, island, site};

/// Metres summed over cells: solid and water that are there, and what has moved of either.
fn sums(run: &Run) -> [f64; 3] {
    let (site, state) = (run.site(), run.state());
    let sum = |of: &dyn Fn(usize) -> f64| (0..site.len()).map(of).sum::<f64>();
    let change = |k: usize| f64::from(state.loose[k]) - f64::from(state.wear[k]);
    let before = |k: usize| site.before.as_ref().map_or(0.0, |before| f64::from(before[k]));
    [
        sum(&|k| change(k) + f64::from(state.load[k])),
        sum(&|k| f64::from(state.water[k])),
        sum(&|k| (change(k) - before(k)).abs() + f64::from(state.load[k])),
    ]
}

/// Runs a site and holds it to its account every few steps; the state at the end.
fn hold(name: &str, site: Site, settings: &Settings, steps: usize) -> State {
    let (state, dt, area) = (State::of(&site), settings.longest_step(site.cell), site.cell_area());
    let mut run = Run::new(site, state, settings, dt);
    let [solid, water, _] = sums(&run);
    // Water that came and went, whichever way, step by step.
    let (mut through, mut last) = (0.0, Account::default());
    for step in 1..=steps {
        run.step(&Work::default()).unwrap();
        let account = *run.account();
        through += [
            account.rained - last.rained,
            account.evaporated - last.evaporated,
            account.drowned - last.drowned,
            account.water_left - last.water_left,
        ]
        .iter()
        .map(|metres| metres.abs() / area)
        .sum::<f64>();
        last = account;
        if step % 20 > 0 && step > 20 {
            continue;
        }
        let [now, wet, moved] = sums(&run);
        let off = now + account.solid_left / area - solid;
        assert!(off.abs() <= 1e-6 * moved + 1e-9, "{name}, step {step}: {off} m of solid, {moved} moved");
        let gone = (account.evaporated + account.drowned + account.water_left - account.rained) / area;
        let off = wet + gone - water;
        assert!(
            off.abs() <= 1e-6 * through + 1e-9,
            "{name}, step {step}: {off} m of water, {through} came and went"
        );
        let state = run.state();
        for k in 0..run.site().len() {
            let depth = (run.site().filled[k] - run.site().height[k]) + state.water[k];
            let all = [state.load[k], state.wear[k], state.loose[k], depth];
            assert!(all.iter().all(|v| v.is_finite() && *v >= 0.0), "{name}, step {step}, {k}: {all:?}");
        }
    }
    let ([now, wet, moved], account) = (sums(&run), run.account());
    println!(
        "{name}: moved {:.3} m a cell, solid off {:.1e}, water off {:.1e} of {:.1} m rain",
        moved / run.site().len() as f64,
        (now + account.solid_left / area - solid) / moved,
        (wet - water) * area + account.evaporated + account.drowned + account.water_left - account.rained,
        account.rained / area,
    );
    assert!(moved > 0.0, "{name}: nothing moved");
    run.into_parts().1
}

#[test]
fn an_island_loses_nothing_but_what_leaves() {
    let settings = Settings::default();
    hold("island", site(97, 60.0, island(97, 900.0, 5), 54.0, true), &settings, 400);
    let mut closed = site(65, 60.0, island(65, 900.0, 7), 54.0, false);
    closed.open = false;
    hold("closed", closed, &Settings { border: Border::Closed, ..settings }, 300);
    let mut warm = site(65, 30.0, island(65, 900.0, 6), 54.0, true);
    warm.evaporation = Some((0..65 * 65).map(|k| (k % 65) as f32 * 2e-7).collect());
    warm.before = Some((0..65 * 65).map(|k| (k / 65) as f32 * 0.1).collect());
    warm.mask = Some((0..65 * 65).map(|k| (k % 7) as f32 / 6.0).collect());
    warm.soft = Some((0..65 * 65).map(|k| (k % 5) as f32 / 4.0).collect());
    hold("warm", warm, &Settings { hardening: 2.0, most_wear: 8.0, most_deposit: 3.0, ..settings }, 300);
}

#[test]
fn hostile_land_is_finite_and_balanced() {
    let settings = Settings::default();
    let steep: Vec<f32> = (0..41 * 41)
        .map(|k| (4424.0 + 4000.0 * fractal(3, 20.0, [(k % 41) as f64, (k / 41) as f64])) as f32)
        .collect();
    let mut storm = site(41, 30.0, steep.clone(), 1000.0, false);
    hold("steep", storm.clone(), &settings, 200);
    storm.cell = 0.1;
    hold("tiny cells", storm.clone(), &settings, 100);
    storm.cell = 1000.0;
    hold("wide cells", storm.clone(), &settings, 100);
    storm.open = false;
    storm.cell = 30.0;
    hold("no outlet", storm, &settings, 200);
}

#[test]
fn land_that_nothing_can_move_on_stays() {
    let settings = Settings { rock_repose: 1e3, ..Settings::default() };
    let still = |site: Site| {
        let (state, dt) = (State::of(&site), 1.0);
        let mut run = Run::new(site, state.clone(), &settings, dt);
        for _ in 0..30 {
            run.step(&Work::default()).unwrap();
        }
        let moved = run.state().wear.iter().chain(&run.state().load).any(|v| *v != 0.0);
        assert!(!moved && run.state().loose == state.loose);
    };
    still(site(33, 30.0, vec![-50.0; 33 * 33], 100.0, true));
    still(site(33, 30.0, vec![50.0; 33 * 33], 0.0, false));
    let mut flat = site(33, 30.0, vec![50.0; 33 * 33], 1000.0, false);
    flat.open = false;
    still(flat);
    // A lake of any depth on high ground is at rest, to the bit.
    let mut lake = site(33, 30.0, island(33, 1000.0, 4).iter().map(|h| h + 3000.0).collect(), 0.0, false);
    lake.filled.iter_mut().for_each(|h| *h = h.max(3100.0));
    lake.open = false;
    still(lake);
    for (cols, rows) in [(0, 0), (1, 1), (1, 40), (40, 1), (2, 2), (3, 3)] {
        let mut site = Site::new(cols, rows, 30.0, (0..cols * rows).map(|k| (k * k % 7) as f32).collect());
        site.rain = vec![1e-4; cols * rows];
        for open in [false, true] {
            site.open = open;
            let mut run = Run::new(site.clone(), State::of(&site), &settings, 2.0);
            (0..50).for_each(|_| run.step(&Work::default()).unwrap());
            assert!(run.state().wear.iter().all(|w| w.is_finite()), "{cols} {rows}");
        }
    }
}
