//! Slopes of curves that cross, run into each other or run side by side: the land lies between what each curve makes of it
//! alone.

use orograph::kit::curves::merge;
use orograph::nodes::curves::diffuse::Quality;
use orograph::value::{CurveSpec, Curves, Grid, Mark};

use super::land::solved;
use super::{curves, grid, raster, spec};

fn set(specs: &[CurveSpec]) -> Curves {
    Curves::from_specs(specs).expect("curves")
}

fn land(specs: &[CurveSpec], grid: Grid, quality: Quality) -> Vec<f64> {
    solved(&set(specs), grid, quality).data().iter().map(|&h| f64::from(h)).collect()
}

/// Numbers from 0 to 1, the same each time.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / f64::from(1_u32 << 31)
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.roll()
    }
}

/// How two curves meet.
#[derive(Clone, Copy, Debug)]
enum Way {
    Cross,
    RunInto,
    /// They cross at two heights.
    Contradict,
    Slantwise,
    SideBySide,
}

/// A straight curve through a place, with slopes on both sides that change along it; where it ends there, it goes on ahead
/// only.
fn curve(degrees: f64, [x, y]: [f64; 2], height: f64, ends: bool, dice: &mut Dice) -> CurveSpec {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let (back, ahead) = (if ends { 0.0 } else { dice.between(500.0, 780.0) }, dice.between(500.0, 780.0));
    let radius = if dice.roll() < 0.5 { 0.0 } else { dice.between(20.0, 60.0) };
    let from = height + dice.between(-150.0, 150.0);
    let to = height + dice.between(-150.0, 150.0);
    let share = back / (back + ahead);
    let mut it = spec("{}");
    it.line = vec![x - cos * back, y - sin * back, x + cos * ahead, y + sin * ahead];
    it.height = vec![0.0, from, radius, share, height, radius, 1.0, to, radius];
    if ends {
        it.height.drain(..3);
    }
    let mut side = || [dice.between(150.0, 500.0), dice.between(-55.0, 55.0)];
    let [[a, p], [b, q]] = [side(), side()];
    it.slope = vec![0.0, a, b, p, q];
    it
}

/// Two curves in a square of two kilometres.
fn pair(way: Way, dice: &mut Dice) -> [CurveSpec; 2] {
    let at = [dice.between(800.0, 1200.0), dice.between(800.0, 1200.0)];
    let (first, height) = (dice.between(0.0, 180.0), dice.between(200.0, 800.0));
    let one = curve(first, at, height, false, dice);
    let two = match way {
        Way::Cross => curve(first + dice.between(25.0, 155.0), at, height, false, dice),
        Way::RunInto => curve(first + dice.between(25.0, 155.0), at, height, true, dice),
        Way::Contradict => {
            let off = dice.between(100.0, 300.0).copysign(dice.roll() - 0.5);
            curve(first + dice.between(25.0, 155.0), at, height + off, false, dice)
        }
        Way::Slantwise => curve(first + dice.between(8.0, 25.0), at, height, false, dice),
        Way::SideBySide => {
            let (sin, cos) = libm::sincos(first.to_radians());
            let off = dice.between(200.0, 400.0);
            let beside = [at[0] - sin * off, at[1] + cos * off];
            curve(first + dice.between(-6.0, 6.0), beside, height + dice.between(-150.0, 150.0), false, dice)
        }
    };
    [one, two]
}

/// How far the land of two curves leaves what each of them gives alone, as a share of the relief: where slopes of both
/// hold a sample, the range between the two lands there; elsewhere their lowest and their highest.
fn beyond(pair: &[CurveSpec; 2], grid: Grid) -> f64 {
    let quality = Quality::Converged;
    let alone = [0, 1].map(|k| land(&pair[k..=k], grid, quality));
    let both = land(pair, grid, quality);
    let slopes = [0, 1].map(|k| raster(&set(&pair[k..=k]), &grid));
    let all = || alone.iter().flatten();
    let (low, high) = all().fold((f64::MAX, f64::MIN), |r, &h| (r.0.min(h), r.1.max(h)));
    let off = |at: usize| {
        let place = [at % grid.cols, at / grid.cols];
        let meet = slopes.iter().all(|s| s.has(Mark::Gradient, place) || s.has(Mark::Open, place));
        let here = alone.each_ref().map(|f| f[at]);
        let (low, high) = if meet { (here[0].min(here[1]), here[0].max(here[1])) } else { (low, high) };
        (both[at] - high).max(low - both[at])
    };
    (0..both.len()).map(off).fold(0.0, f64::max) / (high - low)
}

fn pairs() -> impl Iterator<Item = (Way, [CurveSpec; 2])> {
    let mut dice = Dice(1);
    let ways = [Way::Cross, Way::RunInto, Way::Contradict, Way::Slantwise, Way::SideBySide];
    (0..50).map(move |k| (ways[k % ways.len()], pair(ways[k % ways.len()], &mut dice)))
}

#[test]
fn fifty_crossings_lie_between_what_each_curve_gives() {
    let g = grid([0.0; 2], 2048.0 / 96.0, 97);
    let mut bad = Vec::new();
    for (k, (way, pair)) in pairs().enumerate() {
        let off = beyond(&pair, g);
        println!("{k} {way:?}: {off:.3}");
        if off > 0.05 {
            bad.push(format!("{k} {way:?} by {off:.3}: {}", serde_json::to_string(&pair).expect("specs")));
        }
    }
    assert!(bad.is_empty(), "{} of 50:\n{}", bad.len(), bad.join("\n"));
}

/// A river in a gorge, and two side valleys that end on it at a sharp angle, on a plateau between two rims.
const CANYON: [&str; 5] = [
    r#"{"line":[0,1300,900,1020,1500,900,2048,1150],"height":[0,420,60,1,300,60],"slope":[0,420,420,62,62,1,520,520,66,66]}"#,
    r#"{"line":[150,150,420,600,560,1000,900,1020],"height":[0,820,25,1,380,25],"slope":[0,120,120,40,40,1,420,420,60,60]}"#,
    r#"{"line":[1000,1900,1300,1500,1250,1150,1500,900],"height":[0,820,25,1,350,25],"slope":[0,120,120,40,40,1,420,420,60,60]}"#,
    r#"{"line":[0,40,2048,60],"height":[0,1000,0]}"#,
    r#"{"line":[0,2010,2048,1990],"height":[0,1000,0]}"#,
];

/// Both qualities: no horns beside the mouths, where two slopes of sixty degrees meet.
#[test]
fn side_valleys_raise_no_horns() {
    let g = grid([0.0; 2], 8.0, 257);
    for quality in [Quality::Converged, Quality::Paper] {
        let land = solved(&curves(&CANYON), g, quality);
        let (low, high) = land.range().expect("heights");
        println!("{quality:?}: {low} to {high} m");
        assert!(high < 1000.0 + 0.05 * 700.0 && low > 300.0 - 0.05 * 700.0, "{quality:?}: {low} to {high} m");
    }
}

/// A dune begins at the foot of another one's crest: the rows of the lee side do not differ, though the ground right beside
/// the crest does.
#[test]
fn a_dune_that_begins_at_a_crest_leaves_no_comb() {
    let dunes = [
        r#"{"through":[550,610,520,1010,630,1400],"height":[0,105,0,1,90,0],"slope":[0,290,0,-33,0,1,260,0,-33,0]}"#,
        r#"{"through":[540,670,360,1040,220,1400],"height":[0,90,0,1,105,0],"slope":[0,60,0,-30,0,1,200,0,-32,0]}"#,
        r#"{"line":[1200,500,1200,1500],"height":[0,30,0]}"#,
        r#"{"line":[0,500,0,1500],"height":[0,30,0]}"#,
    ];
    let land = solved(&curves(&dunes), grid([0.0, 400.0], 8.0, 151), Quality::Converged);
    let at = |i: usize, j: usize| f64::from(land.at(i as i64, j as i64));
    // The lee side, some steps off the crest.
    let bend = |i: usize, j: usize| (at(i, j - 1) - 2.0 * at(i, j) + at(i, j + 1)).abs();
    let places = (45..85).flat_map(|j| (72..84).map(move |i| (i, j)));
    let worst = places.map(|(i, j)| bend(i, j)).fold(0.0, f64::max);
    println!("{worst:.3} m");
    assert!(worst < 0.25, "rows differ by {worst} m");
}

/// In either order of the curves, and whatever of the lattice is asked for.
#[test]
fn what_meets_does_not_depend_on_order_or_window() {
    let one = curves(&CANYON);
    let turned: Vec<&str> = CANYON.iter().rev().copied().collect();
    let other = merge(&[curves(&turned)]).expect("curves");
    let g = grid([0.0; 2], 8.0, 257);
    let (a, b) = (raster(&one, &g), raster(&other, &g));
    let tile = Grid { col: 85, row: 97, cols: 77, rows: 61, ..g };
    let part = raster(&one, &tile);
    let mut met = 0;
    for j in 0..tile.rows {
        for i in 0..tile.cols {
            let there = [i + 85, j + 97];
            assert_eq!(part.ground([i, j]), a.ground(there));
            met += usize::from(a.ground(there).is_some());
            let (p, q) = (a.ground(there).unwrap_or_default(), b.ground(there).unwrap_or_default());
            assert!((p.0 - q.0).abs() < 1e-3 && (p.1 - q.1).abs() < 1e-5, "{p:?} and {q:?} at {there:?}");
        }
    }
    assert!(met > 300, "{met}");
}
