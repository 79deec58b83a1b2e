//! Perlin noise on its lattice: the textbook, theory, the far plane.

use orograph::kit::noise::{Form, Fractal, Spectrum, lattice};

use super::{mean_and_variance, perlin_reference, square};

#[test]
fn perlin_is_what_the_textbook_says() {
    for n in 0..200_u32 {
        let cell = [n.wrapping_mul(0x1357_9bdf), u32::MAX - n];
        for i in 0..=20_u8 {
            for j in 0..=20_u8 {
                let at = [f32::from(i) / 20.0, f32::from(j) / 20.0];
                let (ours, truth) = (lattice::perlin(cell, at), perlin_reference(cell, at.map(f64::from)));
                assert!((f64::from(ours) - truth).abs() < 5e-7, "{cell:?} {at:?}: {ours}, should be {truth}");
            }
        }
        for corner in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
            assert_eq!(lattice::perlin(cell, corner), 0.0, "not zero on a corner");
        }
    }
}

#[test]
fn perlin_is_smooth_across_cells() {
    // In f64, so that second differences can be taken; the kernel itself is held to it above. The curvature along x
    // vanishes on the border from both sides, as the quintic has it; the cubic fade would leave up to 6 times a slope.
    let h = 1e-4;
    for n in 0..300_u32 {
        let (here, east) = ([n, 3 * n], [n + 1, 3 * n]);
        let y = f64::from(n) / 300.0;
        let w = |t: f64| perlin_reference(here, [1.0 - t, y]);
        let e = |t: f64| perlin_reference(east, [t, y]);
        assert!((w(0.0) - e(0.0)).abs() < 1e-12);
        let (left, right) = ((w(0.0) - w(h)) / h, (e(h) - e(0.0)) / h);
        assert!((left - right).abs() < 1e-4, "slopes {left} and {right}");
        let (left, right) =
            ((w(0.0) - 2.0 * w(h) + w(2.0 * h)) / h / h, (e(0.0) - 2.0 * e(h) + e(2.0 * h)) / h / h);
        assert!(left.abs() < 0.05 && right.abs() < 0.05, "curvatures {left} and {right}");
    }
}

#[test]
fn slopes_have_no_direction_of_their_own() {
    let (mut sums, mut harmonics) = ([0.0_f64; 5], [0.0_f64; 4]);
    let n = 1 << 20;
    for i in 0..n {
        let [x, y] = lattice::slope((i as u32).wrapping_mul(0x9e37_79b9)).map(f64::from);
        let length = (x * x + y * y).sqrt();
        assert!((0.95..1.01).contains(&length), "length {length}");
        sums = [sums[0] + x, sums[1] + y, sums[2] + x * x, sums[3] + y * y, sums[4] + x * y];
        let angle = libm::atan2(y, x);
        for (h, k) in harmonics.iter_mut().zip([2.0, 4.0, 6.0, 8.0]) {
            *h += libm::cos(k * angle);
        }
    }
    let [mx, my, xx, yy, xy] = sums.map(|s| s / f64::from(n));
    assert!(mx.abs() < 1e-3 && my.abs() < 1e-3 && xy.abs() < 1e-3, "{mx} {my} {xy}");
    assert!((xx - 17.0 / 35.0).abs() < 1e-3 && (yy - 17.0 / 35.0).abs() < 1e-3, "{xx} {yy}");
    for h in harmonics {
        assert!((h / f64::from(n)).abs() < 0.05, "{harmonics:?}");
    }
}

#[test]
fn the_hash_shows_no_lattice() {
    const N: usize = 512;
    let lags = [0, 1, 2, 3, 4, 5, 7, 8, 12, 16, 31, 32, 64, 100, 128];
    for place in [[0_u32, 0], [0x8000_0000, 12_345], [0xffff_ff00, 0xdead_beef]] {
        // Sign bit, and both components of the slope, as ±1 or scaled to variance 1.
        let planes: [fn(u32) -> f64; 3] = [
            |h| if h >> 31 == 0 { 1.0 } else { -1.0 },
            |h| f64::from(lattice::slope(h)[0]) / (17.0_f64 / 35.0).sqrt(),
            |h| f64::from(lattice::slope(h)[1]) / (17.0_f64 / 35.0).sqrt(),
        ];
        for (p, plane) in planes.iter().enumerate() {
            let at = |i: usize, j: usize| {
                let cell = [place[0].wrapping_add(i as u32), place[1].wrapping_add(j as u32)];
                let [col, row] = lattice::spread(cell);
                plane(lattice::scramble(col, row))
            };
            let values: Vec<f64> = (0..N * N).map(|k| at(k % N, k / N)).collect();
            for (dx, dy) in lags.iter().flat_map(|&a| lags.map(|b| (a, b))).skip(1) {
                let mut sum = 0.0;
                for j in 0..N - dy {
                    for i in 0..N - dx {
                        sum += values[j * N + i] * values[(j + dy) * N + i + dx];
                    }
                }
                let sigma = sum / (((N - dx) * (N - dy)) as f64).sqrt();
                assert!(sigma.abs() < 5.5, "plane {p} at {place:?}: {sigma} sigma at lag {dx}, {dy}");
            }
        }
    }
}

fn one_octave(size: f64, seed: u64) -> Fractal {
    let spectrum = Spectrum { feature_size: size, octaves: 1, lacunarity: 2.0, gain: 0.5 };
    Fractal::new(Form::Fbm, spectrum, seed, 0.0, 1.0)
}

#[test]
fn perlin_has_the_variance_of_theory_and_keeps_its_bound() {
    // Var = 4 · 1.421² · E[g²] · ∫∫ (1 − f(x))² (1 − f(y))² (x² + y²), f the quintic, E[g²] of one component 17/35.
    let (mut squares, mut moments, n) = (0.0, 0.0, 100_000);
    for i in 0..n {
        let x = (f64::from(i) + 0.5) / f64::from(n);
        let rest = 1.0 - x * x * x * (x * (x * 6.0 - 15.0) + 10.0);
        squares += rest * rest / f64::from(n);
        moments += rest * rest * x * x / f64::from(n);
    }
    let theory = 4.0 * 1.421 * 1.421 * (17.0 / 35.0) * 2.0 * squares * moments;
    assert!((theory.sqrt() - 0.302).abs() < 1e-3, "the documented deviation is {}", theory.sqrt());
    for origin in [[0.0, 0.0], [9.9e7, -9.9e7]] {
        let data = square(&one_octave(100.0, 5), 1024, 37.7, origin);
        let (mean, variance) = mean_and_variance(&data);
        assert!(mean.abs() < 0.005, "mean {mean}");
        assert!((variance / theory - 1.0).abs() < 0.02, "variance {variance}, theory {theory}");
        assert!(data.iter().all(|x| x.abs() <= 1.0));
    }
}

#[test]
fn perlin_reaches_nearly_one_and_never_more() {
    // The largest sum for each place in a cell: every corner takes the slope that helps most.
    let slopes: Vec<[f64; 2]> = (0..=1000_u32)
        .map(|i| lattice::slope((i * 2_147_483) & 0x7fff_ffff).map(|v| f64::from(v).abs()))
        .collect();
    let help = |x: f64, y: f64| slopes.iter().map(|g| g[0] * x + g[1] * y).fold(0.0, f64::max);
    let fade = |t: f64| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let mut best = 0.0_f64;
    for i in 0..=60 {
        for j in 0..=60 {
            let (x, y) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
            let (a, b) = (fade(x), fade(y));
            let north = (1.0 - a) * help(x, y) + a * help(1.0 - x, y);
            let south = (1.0 - a) * help(x, 1.0 - y) + a * help(1.0 - x, 1.0 - y);
            best = best.max((1.0 - b) * north + b * south);
        }
    }
    let bound = best * 1.421;
    assert!((0.999..=1.0).contains(&bound), "largest value {bound}");
}

#[test]
fn directions_are_alike_over_seeds() {
    // Mean square differences at a distance of half a cell, in eight directions.
    let mut sums = [0.0_f64; 8];
    for seed in 0..60 {
        let noise = one_octave(100.0, seed);
        let n = 64;
        let xs: Vec<f64> = (0..n).map(|i| f64::from(i) * 71.3).collect();
        for (k, sum) in sums.iter_mut().enumerate() {
            let (sin, cos) = libm::sincos(k as f64 * std::f64::consts::PI / 8.0);
            let shifted: Vec<f64> = xs.iter().map(|x| x + 50.0 * cos).collect();
            let (here, there) = (noise.over(&xs), noise.over(&shifted));
            let (mut a, mut b) = (vec![0.0; xs.len()], vec![0.0; xs.len()]);
            for j in 0..n {
                let y = f64::from(j) * 71.3;
                here.row(y, &mut a);
                there.row(y + 50.0 * sin, &mut b);
                *sum += a.iter().zip(&b).map(|(a, b)| f64::from((a - b) * (a - b))).sum::<f64>();
            }
        }
    }
    let mean = sums.iter().sum::<f64>() / 8.0;
    for (k, sum) in sums.iter().enumerate() {
        assert!((sum / mean - 1.0).abs() < 0.03, "direction {k}: {sums:?}");
    }
}

#[test]
fn lattices_are_turned_any_way_and_shifted_anywhere() {
    // The step that 10 m to the east make on a lattice of 100 m, and where the origin of the world lies in its cell.
    let (mut harmonics, mut places) = ([[0.0_f64; 2]; 4], [0.0_f64; 2]);
    let n = 4000;
    for seed in 0..n {
        let turned = lattice::Turned::new(100.0, seed);
        let ((c0, p0), (c1, p1)) = (turned.locate(0.0, 0.0), turned.locate(10.0, 0.0));
        let step =
            [0, 1].map(|a| f64::from(c1[a].wrapping_sub(c0[a]) as i32) + f64::from(p1[a]) - f64::from(p0[a]));
        assert!((step[0] * step[0] + step[1] * step[1] - 0.01).abs() < 1e-6, "a step of {step:?} cells");
        let angle = libm::atan2(step[1], step[0]);
        for (sum, k) in harmonics.iter_mut().zip([1.0, 2.0, 4.0, 8.0]) {
            *sum = [sum[0] + libm::cos(k * angle), sum[1] + libm::sin(k * angle)];
        }
        places = [0, 1].map(|a| places[a] + f64::from(p0[a]));
    }
    // Four standard deviations of a mean over the seeds.
    let chance = 4.0 / (n as f64).sqrt();
    assert!(harmonics.iter().flatten().all(|s| (s / n as f64).abs() < chance), "angles {harmonics:?}");
    assert!(places.iter().all(|s| (s / n as f64 - 0.5).abs() < 0.3 * chance), "places {places:?}");
}

#[test]
fn the_far_plane_is_as_smooth_as_the_near() {
    // Features of 0.1 m at 1e8 m: a step of 1 mm is a hundredth of a cell, whose largest slope is about 3 per cell.
    let noise = one_octave(0.1, 3);
    for origin in [[0.0, 0.0], [1e8, -1e8], [-1e8, 1e8]] {
        let data = square(&noise, 512, 0.001, origin);
        let steps = data.chunks(512).flat_map(|row| row.windows(2).map(|w| (w[1] - w[0]).abs()));
        let (most, sum) = steps.fold((0.0_f32, 0.0_f64), |(m, s), d| (m.max(d), s + f64::from(d)));
        assert!(most < 0.04, "a jump of {most} near {origin:?}");
        assert!(sum / (512.0 * 511.0) > 0.002, "no relief near {origin:?}");
    }
    // Further than positions can be told apart the noise is still finite and bounded.
    for origin in [[1e15, 1e15], [-1e300, 1e200]] {
        let spectrum = Spectrum { feature_size: 0.1, octaves: 16, lacunarity: 4.0, gain: 1.0 };
        let noise = Fractal::new(Form::Fbm, spectrum, 1, 0.0, 1.0);
        assert!(square(&noise, 16, 1.0, origin).iter().all(|x| x.abs() <= 1.0), "near {origin:?}");
    }
}
