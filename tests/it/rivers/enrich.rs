//! Midpoint displacement beside a skeleton, against the rules of its documentation written out one sample at a time.

use orograph::kit::hash;
use orograph::kit::land::{Bits, Enrichment, enrich};
use orograph::work::{Cancel, Cancelled, Work};
use proptest::prelude::*;

/// A field with holes: values where they are known.
#[derive(Clone)]
struct Plain {
    cols: usize,
    rows: usize,
    values: Vec<Option<f32>>,
}

impl Plain {
    /// Random heights on a share of the samples.
    fn scattered(cols: usize, rows: usize, share: f64, seed: u64) -> Self {
        let one = |k: usize| {
            let height = 1000.0 * hash::unit(seed ^ 7, k as u64) as f32;
            (hash::unit(seed, k as u64) < share).then_some(height)
        };
        Self { cols, rows, values: (0..cols * rows).map(one).collect() }
    }

    fn at(&self, i: i64, j: i64) -> Option<f32> {
        let inside = (0..self.cols as i64).contains(&i) && (0..self.rows as i64).contains(&j);
        inside.then(|| self.values[j as usize * self.cols + i as usize]).flatten()
    }

    /// Fills the samples that `is` picks by column and row from neighbours at some offsets, at once.
    fn fill(
        &mut self,
        is: impl Fn(i64, i64) -> bool,
        near: &[[i64; 2]],
        least: usize,
        how: &Enrichment,
        distance: f64,
    ) {
        let before = self.clone();
        for j in 0..self.rows as i64 {
            for i in (0..self.cols as i64).filter(|&i| is(i, j)) {
                let known = near.iter().filter_map(|&[di, dj]| {
                    let far = ((di * di + dj * dj) as f64).sqrt();
                    (far <= how.limit).then_some((before.at(i + di, j + dj)?, 1.0 / far))
                });
                let known: Vec<_> = known.collect();
                if before.at(i, j).is_none() && known.len() >= least {
                    let weights: f64 = known.iter().map(|(_, w)| w).sum();
                    let mean = known.iter().map(|(z, w)| f64::from(*z) * w).sum::<f64>() / weights;
                    let noise = how.displacement * distance * normal(how.seed, i, j);
                    self.values[j as usize * self.cols + i as usize] = Some((mean + noise) as f32);
                }
            }
        }
    }

    fn enriched(mut self, how: &Enrichment) -> Self {
        for round in 0..how.rounds {
            let half = 1_i64 << round;
            let multiple = |v: i64, of: i64| v % of == 0;
            let (h, corner) = (half, move |i, j| multiple(i, 2 * half) && multiple(j, 2 * half));
            let around = [[-h, -h], [h, -h], [-h, h], [h, h], [h, 0], [-h, 0], [0, h], [0, -h]];
            self.fill(corner, &around, 1, how, half as f64);
            for h in (0..=round).rev().map(|r| 1_i64 << r) {
                let odd = |v: i64| v % (2 * h) == h;
                let even = |v: i64| v % (2 * h) == 0;
                let diagonals = [[-h, -h], [h, -h], [-h, h], [h, h]];
                self.fill(|i, j| odd(i) && odd(j), &diagonals, 2, how, h as f64 * 2_f64.sqrt());
                let sides = [[h, 0], [-h, 0], [0, h], [0, -h]];
                self.fill(
                    |i, j| odd(i) != odd(j) && (even(i) || even(j)) && (odd(i) || odd(j)),
                    &sides,
                    2,
                    how,
                    h as f64,
                );
            }
        }
        self
    }
}

/// Noise of mean 0 and standard deviation 1: four uniform numbers of 16 bits each.
fn normal(seed: u64, i: i64, j: i64) -> f64 {
    let bits = hash::nth(seed, (j as u64) << 32 | i as u64);
    let sum: f64 = (0..4).map(|k| ((bits >> (16 * k)) & 0xffff) as f64 / 65535.0).sum();
    (sum - 2.0) / (4.0_f64 / 12.0).sqrt()
}

fn run(plain: &Plain, how: &Enrichment) -> Plain {
    let field: Vec<f32> = plain.values.iter().map(|v| v.unwrap_or(-77.0)).collect();
    let known = Bits::of(plain.cols, &plain.values, Option::is_some);
    let found = enrich(plain.cols, field, known, how, &Work::default()).expect("nobody stops it");
    let value = |k: usize| {
        let known = found.known.has([k % plain.cols, k / plain.cols]);
        assert!(known || found.field[k] == -77.0, "what is not known is left as it was");
        known.then_some(found.field[k])
    };
    Plain { values: (0..plain.values.len()).map(value).collect(), ..*plain }
}

fn check(plain: &Plain, how: &Enrichment) {
    let (wanted, found) = (plain.clone().enriched(how), run(plain, how));
    for (k, (w, f)) in wanted.values.iter().zip(&found.values).enumerate() {
        let place = [k % plain.cols, k / plain.cols];
        let near = match (w, f) {
            (Some(w), Some(f)) => (w - f).abs() <= 0.01,
            (w, f) => w == f,
        };
        assert!(near, "{place:?} of {} x {}: {f:?}, not {w:?}; {how:?}", plain.cols, plain.rows);
    }
    for (k, value) in plain.values.iter().enumerate().filter(|(_, v)| v.is_some()) {
        assert_eq!(found.values[k].map(f32::to_bits), value.map(f32::to_bits), "known samples stay");
    }
}

#[test]
fn enrichment_equals_a_plain_reference() {
    for (cols, rows) in [(65, 65), (130, 67), (63, 40), (64, 64), (1, 50), (77, 1), (2, 2)] {
        for (rounds, limit) in [(1, 9.0), (3, 100.0), (3, 2.0), (6, 31.0), (2, 1.0), (2, 0.5)] {
            let how = Enrichment { rounds, limit, displacement: 0.5, seed: 5 };
            for share in [0.01, 0.2] {
                check(&Plain::scattered(cols, rows, share, 3), &how);
            }
        }
    }
}

#[test]
fn a_lone_sample_spreads_and_nothing_at_all_stays_nothing() {
    let how = Enrichment { rounds: 3, limit: 10.0, displacement: 0.0, seed: 0 };
    let empty = Plain { cols: 40, rows: 30, values: vec![None; 1200] };
    assert!(run(&empty, &how).values.iter().all(Option::is_none));
    let mut lone = empty;
    lone.values[15 * 40 + 21] = Some(12.5);
    let found = run(&lone, &how);
    let count = found.values.iter().flatten().count();
    assert!(count > 8, "{count} samples");
    assert!(
        found.values.iter().flatten().all(|z| (z - 12.5).abs() < 1e-4),
        "the mean of one height is that height"
    );
    let full = Plain { values: (0..1200).map(|k| Some(k as f32)).collect(), ..found };
    assert_eq!(run(&full, &how).values, full.values);
}

#[test]
fn enrichment_stops_when_asked() {
    let plain = Plain::scattered(50, 50, 0.1, 1);
    let cancel = Cancel::default();
    cancel.cancel();
    let how = Enrichment { rounds: 2, limit: 10.0, displacement: 0.0, seed: 0 };
    let known = Bits::of(50, &plain.values, Option::is_some);
    assert_eq!(enrich(50, vec![0.0; 2500], known, &how, &Work::new(&cancel)), Err(Cancelled));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn enrichment_of_any_size_equals_the_reference(
        (cols, rows) in (1usize..140, 1usize..40),
        share in 0.0f64..0.3,
        (rounds, limit, displacement, seed) in (1u32..7, 0.0f64..70.0, 0.0f64..2.0, any::<u64>()),
    ) {
        check(&Plain::scattered(cols, rows, share, seed), &Enrichment { rounds, limit, displacement, seed });
    }
}
