//! Rain up the ladder of levels: bits, balance, sizes, and what each input does.

use orograph::kit::erosion::Level;
use orograph::kit::erosion::hydraulic::{Border, Eroded, Land, Settings, Showers, erode};
use orograph::value::{Field, Grid, Lattice, Quantity};
use orograph::work::Work;

use super::land::island;

fn grid(cols: usize, rows: usize, span: f64) -> Grid {
    let intervals = (cols.max(rows) - 1).max(1) as u32;
    Grid { lattice: Lattice { origin: [0.0, 0.0], span, intervals }, col: 0, row: 0, cols, rows }
}

fn field(grid: Grid, of: impl Fn([f64; 2]) -> f64) -> Field {
    let at = |k: usize| [grid.x(k % grid.cols), grid.y(k / grid.cols)];
    Field::new(grid, Quantity::Number, (0..grid.len()).map(|k| of(at(k)) as f32).collect())
}

fn rain<'a>(height: &'a Field, settings: &Settings, change: impl Fn(&mut Land<'a>)) -> Eroded {
    let mut land = Land {
        height,
        moisture: None,
        sources: None,
        temperature: None,
        hardness: None,
        loose: None,
        mask: None,
        sea: Some(0.0),
        base: Level::of(height.grid()),
    };
    change(&mut land);
    erode(&land, settings, &mut |_| (), &Work::default()).expect("nobody stops it")
}

/// An island of 6 km.
fn land(n: usize) -> Field {
    let grid = grid(n, n, 6000.0);
    Field::new(grid, Quantity::Elevation, island(n, 600.0, 5))
}

fn short() -> Settings {
    Settings { hours: 0.6, ..Settings::default() }
}

fn volume(values: &[f32], grid: &Grid) -> f64 {
    values.iter().map(|v| f64::from(*v)).sum::<f64>() * grid.cell() * grid.cell()
}

#[test]
fn without_time_or_water_every_bit_stays() {
    let mut height = land(129);
    let grid = *height.grid();
    // A lake and a negative zero are kept as well.
    let mut data = height.data().to_vec();
    data[0] = -0.0;
    height = Field::new(grid, Quantity::Elevation, data);
    let still = Settings { rock_repose: 1e3, loose_repose: 1e3, ..short() };
    let bits = |values: &[f32]| values.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    for settings in [
        Settings { hours: 0.0, ..Settings::default() },
        Settings { rain: 0.0, ..still },
        Settings { rain: 0.0, border: Border::Closed, ..still },
        Settings { rain: 0.0, evaporation: 5.0, full_lakes: false, ..still },
    ] {
        let done = rain(&height, &settings, |_| ());
        assert!(bits(&done.height) == bits(height.data()), "{settings:?}");
        assert!(done.wear.iter().chain(&done.loose).chain(&done.deposit).all(|v| *v == 0.0));
    }
}

#[test]
fn where_the_mask_is_0_every_bit_stays() {
    let height = land(129);
    let mask = field(*height.grid(), |[x, _]| (x / 3000.0 - 1.0).clamp(0.0, 1.0));
    let done = rain(&height, &short(), |land| land.mask = Some(&mask));
    for k in 0..height.data().len() {
        if mask.data()[k] == 0.0 {
            assert!(done.height[k].to_bits() == height.data()[k].to_bits(), "{k}");
            assert!(done.wear[k] == 0.0 && done.deposit[k] == 0.0 && done.loose[k] == 0.0);
        }
    }
    assert!(done.wear.iter().any(|w| *w > 1.0));
}

/// Solid and water of the whole ladder: what is there at the end, in the water and over the border is what was there.
#[test]
fn neither_solid_nor_water_is_lost_between_levels() {
    for (n, settings) in [
        (257, short()),
        (150, Settings { showers: Showers { size: 900.0, seconds: 200.0, strength: 0.8 }, ..short() }),
        (129, Settings { border: Border::Closed, evaporation: 20.0, hardening: 3.0, ..short() }),
    ] {
        let height = land(n);
        let loose = field(*height.grid(), |[x, y]| ((x + y) / 2000.0).rem_euclid(3.0));
        let done = rain(&height, &settings, |land| land.loose = Some(&loose));
        let grid = height.grid();
        let moved: f64 =
            done.deposit.iter().map(|d| f64::from(d.abs())).sum::<f64>() * grid.cell() * grid.cell();
        let off = volume(&done.deposit, grid) + done.carried + done.account.solid_left;
        println!("{n}: {off:.3e} m3 of {moved:.3e}, {:.2} in the water", done.carried / moved);
        assert!(off.abs() < 1e-6 * moved, "{n}: {off} m³ of {moved} m³");
        for k in 0..grid.len() {
            let gained = (done.loose[k] - loose.data()[k]) - done.wear[k];
            assert!((gained - done.deposit[k]).abs() < 1e-3, "{n}, {k}: {gained} {}", done.deposit[k]);
            assert!(done.loose[k] >= 0.0 && done.wear[k] >= 0.0 && done.water.depth[k] >= 0.0);
            let rose = done.height[k] - height.data()[k];
            assert!((rose - done.deposit[k]).abs() < 1e-3, "{n}, {k}: {rose} {}", done.deposit[k]);
        }
    }
}

#[test]
fn a_finer_base_shows_the_same_valleys() {
    let settings = Settings { hours: 2.0, rock_erodibility: 0.004, capacity: 40.0, ..Settings::default() };
    let [coarse, fine] =
        [129, 257].map(|n| (land(n), n)).map(|(height, n)| (rain(&height, &settings, |_| ()), height, n));
    let mut both = Vec::new();
    let relief = 500.0;
    for j in 0..129 {
        for i in 0..129 {
            let (a, b) = (j * 129 + i, 2 * j * 257 + 2 * i);
            assert!(coarse.1.data()[a] == fine.1.data()[b], "the same input");
            if coarse.1.data()[a] > 0.0 {
                both.push([coarse.0.deposit[a], fine.0.deposit[b]].map(f64::from));
            }
        }
    }
    let mean = |of: &dyn Fn(&[f64; 2]) -> f64| both.iter().map(of).sum::<f64>() / both.len() as f64;
    let (a, b) = (mean(&|p| p[0]), mean(&|p| p[1]));
    let (va, vb) = (mean(&|p| (p[0] - a) * (p[0] - a)), mean(&|p| (p[1] - b) * (p[1] - b)));
    let correlation = mean(&|p| (p[0] - a) * (p[1] - b)) / (va * vb).sqrt();
    let mut off: Vec<f64> = both.iter().map(|p| (p[0] - p[1]).abs()).collect();
    off.sort_by(f64::total_cmp);
    let most = off[off.len() * 99 / 100] / relief;
    println!("correlation {correlation:.4}, 99th percentile {:.2} % of the relief", 100.0 * most);
    assert!(correlation > 0.96 && most < 0.04, "{correlation} {most}");
}

#[test]
fn each_input_acts_as_it_says() {
    let height = land(129);
    let grid = *height.grid();
    let settings = short();
    let plain = rain(&height, &settings, |_| ());
    let wear = |done: &Eroded| volume(&done.wear, &grid);
    let west = |values: &[f32]| {
        (0..grid.len()).filter(|k| k % 129 < 64).map(|k| f64::from(values[k].abs())).sum::<f64>()
    };
    // Hard rock wears less, and rock of hardness 1 only where it slips.
    let half = field(grid, |_| 0.5);
    let hard = rain(&height, &settings, |land| land.hardness = Some(&half));
    assert!(wear(&hard) < 0.9 * wear(&plain), "hard: {} of {}", wear(&hard), wear(&plain));
    let one = field(grid, |_| 1.0);
    let steep = Settings { rock_repose: 1e3, ..settings };
    let never = rain(&height, &steep, |land| land.hardness = Some(&one));
    assert!(never.wear.iter().all(|w| *w < 1e-3), "rock of hardness 1 wears");
    // Loose ground goes before rock.
    let cover = field(grid, |_| 30.0);
    let covered = rain(&height, &settings, |land| land.loose = Some(&cover));
    assert!(wear(&covered) < 0.5 * wear(&plain), "covered: {} of {}", wear(&covered), wear(&plain));
    // Rain in the east alone leaves the west as it is.
    let east = field(grid, |[x, _]| if x > 3600.0 { 1.0 } else { 0.0 });
    let settings = Settings { rock_repose: 1e3, loose_repose: 1e3, ..settings };
    let sided = rain(&height, &settings, |land| land.moisture = Some(&east));
    let all = rain(&height, &settings, |_| ());
    assert!(west(&sided.deposit) < 0.05 * west(&all.deposit), "rain in the east alone");
    // Warm air leaves less water; frost leaves all.
    let empty = Settings { full_lakes: false, ..settings };
    let dry = Settings { evaporation: 30.0, ..empty };
    let all_day = rain(&height, &empty, |_| ());
    let [frost, warm] = [-5.0, 30.0].map(|t| field(grid, |_| t));
    let frozen = rain(&height, &dry, |land| land.temperature = Some(&frost));
    let hot = rain(&height, &dry, |land| land.temperature = Some(&warm));
    assert!(frozen.height == all_day.height, "frost takes no water");
    let on_land = |done: &Eroded| {
        (0..grid.len())
            .filter(|k| height.data()[*k] > 1.0)
            .map(|k| f64::from(done.water.flow[k]))
            .sum::<f64>()
    };
    assert!(on_land(&hot) < 0.7 * on_land(&all_day), "{} of {}", on_land(&hot), on_land(&all_day));
    // Bounds hold, but for detail that fades.
    let bounded = rain(&height, &Settings { most_wear: 2.0, most_deposit: 1.0, ..settings }, |_| ());
    let most = |values: &[f32]| values.iter().fold(f32::MIN, |a, b| a.max(*b));
    assert!(most(&all.wear) > 4.0 && most(&bounded.wear) < 2.5, "{}", most(&bounded.wear));
    assert!(most(&all.deposit) > 2.0 && most(&bounded.deposit) < 1.5, "{}", most(&bounded.deposit));
}

/// A spring on a plain that falls to the east cuts a valley below it and nothing above; all its water comes out of the border.
#[test]
fn a_spring_alone_cuts_a_valley_below_it() {
    let grid = grid(257, 129, 5120.0);
    let height = field(grid, |[x, y]| 400.0 - 0.06 * x + 0.00002 * (y - 1280.0) * (y - 1280.0));
    // Between the points of all levels but the base.
    let springs =
        field(grid, |[x, y]| if (x - 1020.0).abs() < 15.0 && (y - 1300.0).abs() < 15.0 { 1.0 } else { 0.0 });
    let settings = Settings { rain: 0.0, hours: 9.0, source_discharge: 80.0, ..Settings::default() };
    let done = rain(&height, &settings, |land| (land.sources, land.sea) = (Some(&springs), None));
    let cell = |x: usize, y: usize| y * 257 + x;
    let deepest = |x: usize| (0..129).map(|y| -done.deposit[cell(x, y)]).fold(0.0f32, f32::max);
    assert!((20..40).all(|x| deepest(x) < 0.01), "the land above the spring stays");
    let cut: Vec<_> = (70..240).map(deepest).collect();
    println!(
        "cut {:.1} to {:.1} m",
        cut.iter().fold(1e9f32, |a, b| a.min(*b)),
        cut.iter().fold(0.0f32, |a, b| a.max(*b))
    );
    assert!(cut.iter().all(|cut| *cut > 0.5), "a valley all the way down: {cut:?}");
    let through: f32 =
        (0..129).map(|y| done.water.velocity[cell(200, y)][0] * done.water.depth[cell(200, y)] * 20.0).sum();
    assert!((through / 80.0 - 1.0).abs() < 0.2, "{through} of 80 m³/s pass");
}

#[test]
fn hostile_land_is_finite_or_stays() {
    let settings = Settings { hours: 0.2, ..Settings::default() };
    let wild = |[x, y]: [f64; 2]| 4424.0 * (1.0 + libm::sin(x * 0.013) * libm::cos(y * 0.017));
    for (cols, rows, span) in
        [(3, 3, 2000.0), (1, 1, 100.0), (2, 70, 6900.0), (65, 33, 6.4), (65, 40, 64_000.0)]
    {
        let height = field(grid(cols, rows, span), wild);
        let negative = field(*height.grid(), |_| -3.0);
        for sea in [None, Some(1e4), Some(4000.0)] {
            let storm = Settings { rain: 1000.0, ..settings };
            let done = rain(&height, &storm, |land| (land.sea, land.loose) = (sea, Some(&negative)));
            let all =
                [&done.height, &done.loose, &done.wear, &done.deposit, &done.water.depth, &done.water.flow];
            assert!(all.iter().all(|values| values.iter().all(|v| v.is_finite())), "{cols} {rows} {sea:?}");
            if sea == Some(1e4) && span > 100.0 {
                assert!(done.wear.iter().all(|w| *w == 0.0) || span < 10_000.0, "the sea is everywhere");
            }
        }
    }
    let flat = field(grid(70, 70, 2000.0), |_| 100.0);
    let done =
        rain(&flat, &Settings { rain: 1000.0, border: Border::Closed, ..settings }, |land| land.sea = None);
    assert!(done.height == flat.data(), "flat land without an outlet stays");
}
