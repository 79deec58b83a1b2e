//! Blur, sharpen, median: against direct sums and sorted disks.

use super::*;

/// A line of samples one metre apart; the only row, so that the plane is constant across it.
fn line(from: i64, values: Vec<f32>) -> Field {
    let lattice = Lattice { origin: [0.0, 0.0], span: 1024.0, intervals: 1024 };
    let grid = Grid::between(lattice, [from, 0], [from + values.len() as i64, 1]);
    Field::new(grid, Quantity::Elevation, values)
}

fn blurred(input: &Field, at: Grid, sigma: f64) -> Field {
    blur::gaussian(&Work::default(), input, at, sigma).expect("a blur")
}

/// Weights of a Gaussian at distances 0, 1, …, cut at 9 sigma and summing to 1.
fn gauss(sigma: f64) -> Vec<f64> {
    let n = (9.0 * sigma).ceil() as i64 + 1;
    let raw: Vec<f64> = (0..=n).map(|i| libm::exp(-0.5 * (i * i) as f64 / (sigma * sigma))).collect();
    let sum = raw[0] + 2.0 * raw[1..].iter().sum::<f64>();
    raw.iter().map(|w| w / sum).collect()
}

fn convolved(values: &[f32], sigma: f64) -> Vec<f64> {
    let (w, last) = (gauss(sigma), values.len() as i64 - 1);
    let at = |i: i64| f64::from(values[i.clamp(0, last) as usize]);
    let one = |i: i64| {
        w[0] * at(i)
            + w.iter()
                .enumerate()
                .skip(1)
                .map(|(k, w)| w * (at(i - k as i64) + at(i + k as i64)))
                .sum::<f64>()
    };
    (0..=last).map(one).collect()
}

/// The largest difference from the direct sum that any input of range 1 can make, at one point: half the sum of the
/// differences of all weights.
fn worst_error(sigma: f64, at: i64) -> f64 {
    let (w, reach) = (gauss(sigma), (6.0 * sigma) as i64 + 70);
    let target = line(at, vec![0.0]);
    let weight = |i: i64| {
        let mut impulse = vec![0.0; 2 * reach as usize + 1];
        impulse[(i + reach) as usize] = 1.0;
        let got = blurred(&line(at - reach, impulse), *target.grid(), sigma).data()[0];
        (f64::from(got) - w.get(i.unsigned_abs() as usize).unwrap_or(&0.0)).abs()
    };
    0.5 * (-reach + 2..reach - 1).map(weight).sum::<f64>()
}

#[test]
fn no_input_blurs_further_from_the_direct_sum_than_a_ten_thousandth() {
    // Two axes: each may make half of it.
    for sigma in [0.2, 0.5, 1.0, 3.0, 6.9, 7.0, 7.7, 9.0, 13.9, 14.0, 17.0, 28.0] {
        let phases = if sigma < 14.0 { 2 } else { 4 };
        let worst = (0..phases).map(|at| worst_error(sigma, 100 + at)).fold(0.0, f64::max);
        assert!(worst < 0.5e-4, "sigma {sigma}: {worst}");
    }
}

#[test]
fn wide_blurs_match_the_direct_sum() {
    let n = 3000usize;
    let noise: Vec<f32> = (0..n).map(|i| hash::unit(5, i as u64) as f32).collect();
    let step: Vec<f32> = (0..n).map(|i| f32::from(i > 1411)).collect();
    let comb: Vec<f32> = (0..n).map(|i| f32::from(i / 64 % 2 == 1)).collect();
    for sigma in [3.0, 7.0, 27.9, 56.0, 100.0, 223.0, 224.0, 400.0] {
        for values in [&noise, &step, &comb] {
            let input = line(-777, values.clone());
            let (got, want) = (blurred(&input, *input.grid(), sigma), convolved(values, sigma));
            let worst =
                got.data().iter().zip(&want).map(|(g, w)| (f64::from(*g) - w).abs()).fold(0.0, f64::max);
            assert!(worst < 0.5e-4, "sigma {sigma}: {worst}");
        }
    }
}

#[test]
fn blur_in_the_plane_matches_the_direct_sum() {
    let at = window([-20, 3], [60, 70]);
    for cells in [1.3, 5.0, 9.0, 20.0] {
        let got = run(&Blur { radius: Metres(cells * CELL) }, at, &rough_field);
        let reach = (6.0 * cells) as i64;
        let (input, w) = (rough(&at.grow_cells(reach)), gauss(cells));
        let wide = *input.grid();
        let down = |c: i64, r: i64| {
            (-reach..=reach)
                .map(|k| w[k.unsigned_abs() as usize] * f64::from(input.at(c, r + k)))
                .sum::<f64>()
        };
        for row in [3, 30, 69] {
            let sums: Vec<f64> = (wide.col..wide.col_end()).map(|c| down(c, row)).collect();
            for col in [-20, 0, 1, 59] {
                let middle = (col - wide.col) as usize;
                let want: f64 = (0..=2 * reach as usize)
                    .map(|k| {
                        w[(k as i64 - reach).unsigned_abs() as usize] * sums[middle + k - reach as usize]
                    })
                    .sum();
                let got = f64::from(got.at(col, row));
                assert!(
                    (got - want).abs() < 1e-4 * 620.0,
                    "{cells} cells at {col}, {row}: {got}, not {want}"
                );
            }
        }
    }
}

#[test]
fn blur_keeps_what_is_flat_or_rises_evenly() {
    let at = window([0, 0], [70, 50]);
    for metres in [0.0, 4.0, 30.0, 90.0, 900.0, 10_000.0] {
        let blur = Blur { radius: Metres(metres) };
        let flat = run(&blur, at, &|_, g| Some(Value::Field(field(g, |_, _| 1234.567))));
        assert!(flat.data().iter().all(|&v| v == 1234.567), "{metres} m");
    }
    let slope = |g: &Grid| field(g, |x, y| 0.25 * x - 0.5 * y);
    let got = run(&Blur { radius: Metres(90.0) }, at, &|_, g| Some(Value::Field(slope(g))));
    let worst = got.data().iter().zip(slope(&at).data()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-3, "{worst}");
}

#[test]
fn identities_change_no_bit() {
    let at = window([-5, 2], [60, 50]);
    let input = rough(&at);
    let same = |name: &str, out: Field| assert!(bits(&out) == bits(&input), "{name}");
    same("blur", on(&Blur { radius: Metres(0.0) }, &input));
    same("median", on(&Median { radius: Metres(7.0) }, &input));
    same("sharpen", on(&Sharpen { amount: Number(0.0), ..Sharpen::default() }, &input));
    same("transform", on(&Transform { rotate: Degrees(360.0), ..Transform::default() }, &input));
    same("warp", run(&Warp { limit: Metres(0.0), ..Warp::default() }, at, &rough_field));
    same("warp", run(&Warp { amplitude: Metres(0.0), ..Warp::default() }, at, &rough_field));
    same("terrace", on(&Terrace { sharpness: Ratio(0.0), ..Terrace::default() }, &input));
    same("equalize", on(&Equalize { strength: Ratio(0.0) }, &input));
    same("combine", run(&Combine { strength: Ratio(0.0), ..Combine::default() }, at, &rough_field));
    same("mix", run(&Mix { amount: Ratio(0.0) }, at, &rough_field));
    let points = [[0.0, 0.0], [0.3, 0.3], [1.0, 1.0]].map(|p| p.map(Ratio)).to_vec();
    same("curve", run(&Curve { points, ..Curve::default() }, at, &rough_field));
    let wide = Clamp { low: Number(-1e4), high: Number(1e4), knee: Number(0.0) };
    same("clamp", on(&wide, &input));
    same("clamp", on(&Clamp { knee: Number(500.0), ..wide }, &input));
}

#[test]
fn sharpen_adds_the_detail_beyond_its_threshold() {
    let at = window([0, 0], [50, 40]);
    let smooth = run(&Blur { radius: Metres(40.0) }, at, &rough_field);
    let node = Sharpen { radius: Metres(40.0), amount: Number(1.5), threshold: Number(4.0) };
    let (sharp, input) = (run(&node, at, &rough_field), rough(&at));
    for ((&s, &x), &b) in sharp.data().iter().zip(input.data()).zip(smooth.data()) {
        let d = x - b;
        let want = if d > 4.0 {
            x + 1.5 * (d - 4.0)
        } else if d < -4.0 {
            x + 1.5 * (d + 4.0)
        } else {
            x
        };
        assert!((s - want).abs() < 1e-3, "{s}, not {want}");
    }
}

/// The median by sorting, of samples `stride` apart.
fn sorted_median(input: &Field, [col, row]: [i64; 2], radius: f64, stride: i64) -> f32 {
    let reach = radius as i64;
    let square = radius * radius;
    let offsets = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| (x, y)));
    let mut values: Vec<f32> = offsets
        .filter(|(x, y)| (x * x + y * y) as f64 <= square)
        .map(|(x, y)| input.at(col + x * stride, row + y * stride))
        .collect();
    values.sort_by(f32::total_cmp);
    values[values.len() / 2]
}

#[test]
fn median_is_that_of_the_sorted_disk() {
    let at = window([-9, -70], [130, 20]);
    for cells in [1.0, 1.5, 2.0, 5.0, 13.7, 32.0] {
        let got = run(&Median { radius: Metres(cells * CELL) }, at, &rough_field);
        let input = rough(&at.grow_cells(33));
        let step = if cells > 10.0 { 11 } else { 3 };
        for row in (at.row..at.row_end()).step_by(step) {
            for col in (at.col..at.col_end()).step_by(step) {
                assert_eq!(
                    got.at(col, row),
                    sorted_median(&input, [col, row], cells, 1),
                    "{cells} at {col}, {row}"
                );
            }
        }
    }
}

#[test]
fn wide_median_is_exact_on_its_lattice_and_between_it_near() {
    let at = window([10, 10], [60, 40]);
    let got = run(&Median { radius: Metres(50.0 * CELL) }, at, &rough_field);
    let input = rough(&at.grow_cells(60));
    for (col, row) in [(10, 10), (12, 38), (58, 20)] {
        assert_eq!(got.at(col, row), sorted_median(&input, [col, row], 50.0, 1), "{col}, {row}");
        let (near, want) = (got.at(col + 1, row + 1), sorted_median(&input, [col + 1, row + 1], 50.0, 1));
        assert!((near - want).abs() < 1.5, "{near}, not {want}");
    }
    let got = run(&Median { radius: Metres(140.0 * CELL) }, window([18, 6], [19, 7]), &rough_field);
    let input = rough(&world().apron(at.lattice));
    assert_eq!(got.data()[0], sorted_median(&input, [18, 6], 70.0, 2));
}

#[test]
fn median_takes_a_spike_away_and_leaves_a_cliff() {
    let at = window([0, 0], [40, 30]);
    let input = |g: &Grid| {
        let mut values: Vec<f32> = field(g, |x, _| if x < 500.0 { 0.0 } else { 90.0 }).data().to_vec();
        values[g.cols * (15 - g.row) as usize + (10 - g.col) as usize] = 5000.0;
        Field::new(*g, Quantity::Elevation, values)
    };
    let got = run(&Median { radius: Metres(24.0) }, at, &|_, g| Some(Value::Field(input(g))));
    assert!(
        got.data()
            .iter()
            .zip(field(&at, |x, _| if x < 500.0 { 0.0 } else { 90.0 }).data())
            .all(|(a, b)| a == b)
    );
}
