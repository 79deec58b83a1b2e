//! Cellular noise against brute force.

use orograph::kit::noise::{Measure, Metric, Worley};

use super::{mean_and_variance, metrics_and_measures};

/// Distances to all points of 9 × 9 cells around a place, sorted, with the cell each is in.
fn distances(noise: &Worley, metric: Metric, x: f64, y: f64) -> Vec<(f64, [u32; 2])> {
    let (cell, at) = noise.lattice().locate(x, y);
    let mut all = Vec::new();
    for (i, j) in (-4..=5).flat_map(|i| (-4..=5).map(move |j| (i, j))) {
        let near = [cell[0].wrapping_add(i as u32), cell[1].wrapping_add(j as u32)];
        let (point, _) = noise.point(near);
        let dx = (f64::from(i) + f64::from(point[0]) - f64::from(at[0])).abs();
        let dy = (f64::from(j) + f64::from(point[1]) - f64::from(at[1])).abs();
        let d = match metric {
            Metric::Euclidean => (dx * dx + dy * dy).sqrt(),
            Metric::Manhattan => dx + dy,
            Metric::Chebyshev => dx.max(dy),
        };
        all.push((d, near));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

#[test]
fn cells_are_those_of_brute_force() {
    let xs: Vec<f64> = (0..150).map(|i| f64::from(i) * 0.37 - 40.0).collect();
    for jitter in [0.0, 0.5, 1.0] {
        for (metric, measure) in metrics_and_measures() {
            let noise = Worley::new(1.7, jitter, 11, 0.0, 1.0).measured(metric, measure);
            let rows = noise.over(&xs);
            let mut out = vec![0.0; xs.len()];
            for y in (0..60).map(|j| f64::from(j) * 0.41) {
                rows.row(y, &mut out);
                for (&x, &ours) in xs.iter().zip(&out) {
                    let found = distances(&noise, metric, x, y);
                    let truth = match measure {
                        Measure::F1 => found[0].0,
                        Measure::F2 => found[1].0,
                        Measure::F2MinusF1 => found[1].0 - found[0].0,
                        Measure::CellValue => continue,
                    };
                    assert!(
                        (f64::from(ours) - truth).abs() < 2e-6,
                        "{metric:?} {measure:?} jitter {jitter} at {x}, {y}: {ours}, should be {truth}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_worst_places_of_points_are_searched() {
    // Random points seldom stand at their worst. Here every point stands as far away as its square allows: the cell
    // is needed if its nearest possible point can still beat the farthest possible ones of all others.
    type Length = fn(f64, f64) -> f64;
    let metrics: [Length; 3] = [|x, y| (x * x + y * y).sqrt(), |x, y| x + y, f64::max];
    let ring =
        [(0, 0), (1, 0), (0, 1), (1, 1), (0, -1), (1, -1), (-1, 0), (2, 0), (-1, 1), (2, 1), (0, 2), (1, 2)];
    let outer = [(-1, -1), (2, -1), (-1, 2), (2, 2)];
    let far = [(0, -2), (1, -2), (-2, 0), (3, 0), (-2, 1), (3, 1), (0, 3), (1, 3)];
    let span = |f: f64, k: i32| {
        let (lo, hi) = (f64::from(k) - 0.5 - f, f64::from(k) + 0.5 - f);
        let near = if lo <= 0.0 && hi >= 0.0 { 0.0 } else { lo.abs().min(hi.abs()) };
        (near, lo.abs().max(hi.abs()))
    };
    for (metric, (i, j)) in
        metrics.iter().flat_map(|m| (0..=40).flat_map(move |i| (0..=40).map(move |j| (m, (i, j)))))
    {
        let (x, y) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
        let cells = (-3..=4).flat_map(|i| (-3..=4).map(move |j| (i, j)));
        let reach: Vec<_> = cells
            .map(|(i, j)| {
                let ((nx, fx), (ny, fy)) = (span(x, i), span(y, j));
                ((i, j), metric(nx, ny), metric(fx, fy))
            })
            .collect();
        let mut farthest: Vec<f64> = reach.iter().map(|r| r.2).collect();
        farthest.sort_by(f64::total_cmp);
        for (cell, nearest, _) in reach {
            if nearest < farthest[0] - 1e-9 {
                assert!(ring.contains(&cell), "{cell:?} can hold the nearest point of {x}, {y}");
            }
            if nearest < farthest[1] - 1e-9 {
                let searched = ring.contains(&cell) || outer.contains(&cell) || far.contains(&cell);
                assert!(searched, "{cell:?} can hold the second nearest point of {x}, {y}");
            }
        }
    }
}

#[test]
fn cell_values_are_one_number_a_cell() {
    let xs: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.21).collect();
    let noise = Worley::new(3.0, 1.0, 2, 0.0, 1.0).measured(Metric::Euclidean, Measure::CellValue);
    let rows = noise.over(&xs);
    let mut out = vec![0.0; xs.len()];
    let mut seen = std::collections::BTreeMap::new();
    for y in (0..400).map(|j| f64::from(j) * 0.21) {
        rows.row(y, &mut out);
        for (&x, &value) in xs.iter().zip(&out) {
            let found = distances(&noise, Metric::Euclidean, x, y);
            if found[1].0 - found[0].0 > 1e-5 {
                assert_eq!(*seen.entry(found[0].1).or_insert(value), value, "cell {:?}", found[0].1);
            }
        }
    }
    assert!(seen.len() > 700, "{} cells", seen.len());
    let values: Vec<f32> = seen.values().copied().collect();
    let (mean, variance) = mean_and_variance(&values);
    assert!((mean - 0.5).abs() < 0.03 && (variance - 1.0 / 12.0).abs() < 0.01, "{mean} {variance}");
    assert!(values.iter().all(|v| (0.0..=1.0).contains(v)));
}
