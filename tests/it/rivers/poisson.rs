//! The Poisson blend against its definition, solved exactly here, and against what must hold of any blend.

use orograph::kit::diffusion::Error;
use orograph::kit::hash;
use orograph::kit::poisson::{Blend, Gradients};
use orograph::work::{Cancel, Work};
use proptest::prelude::*;

/// Two fields and a region.
struct Scene {
    cols: usize,
    rows: usize,
    source: Vec<f32>,
    reference: Vec<f32>,
    mask: Vec<f32>,
}

/// Rough ground: random numbers smoothed a few times at two scales.
fn ground(cols: usize, rows: usize, seed: u64) -> Vec<f32> {
    let mut z: Vec<f32> = (0..cols * rows).map(|k| hash::unit(seed, k as u64) as f32 * 100.0).collect();
    for step in [4, 2, 1, 1] {
        let at = |i: usize, j: usize, di: isize, dj: isize| {
            let clamp = |v: usize, d: isize, n: usize| v.saturating_add_signed(d * step).min(n - 1);
            clamp(j, dj, rows) * cols + clamp(i, di, cols)
        };
        let next = |k: usize| {
            let (i, j) = (k % cols, k / cols);
            let near = [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)];
            near.iter().map(|&(di, dj)| z[at(i, j, di, dj)]).sum::<f32>() / 5.0
        };
        z = (0..cols * rows).map(next).collect();
    }
    z
}

impl Scene {
    fn new(cols: usize, rows: usize, inside: impl Fn(f64, f64) -> bool) -> Self {
        let (source, mut reference) = (ground(cols, rows, 1), ground(cols, rows, 2));
        reference.iter_mut().for_each(|r| *r = *r * 3.0 + 500.0);
        let place = |k: usize| ((k % cols) as f64 / cols as f64, (k / cols) as f64 / rows as f64);
        let mask = |k| if inside(place(k).0, place(k).1) { 0.7 } else { 0.0 };
        Self { cols, rows, source, reference, mask: (0..cols * rows).map(mask).collect() }
    }

    /// A disc with a hole, off the middle.
    fn ring(cols: usize, rows: usize) -> Self {
        Self::new(cols, rows, |x, y| {
            let far = |a: f64, b: f64| libm::hypot(x - a, y - b);
            far(0.45, 0.5) < 0.35 && far(0.5, 0.45) > 0.08
        })
    }

    fn blend(&self, gain: f32, gradients: Gradients) -> Blend<'_> {
        let Self { cols, rows, source, reference, mask } = self;
        Blend { cols: *cols, rows: *rows, source, reference, mask, gain, gradients }
    }

    fn blended(&self, gain: f32, gradients: Gradients) -> Vec<f32> {
        self.blend(gain, gradients).run(&Work::default()).expect("blends").field
    }

    fn neighbours(&self, k: usize) -> impl Iterator<Item = usize> {
        let (cols, rows, i, j) = (self.cols, self.rows, k % self.cols, k / self.cols);
        let west = (i > 0).then(|| k - 1);
        let east = (i + 1 < cols).then_some(k + 1);
        let north = (j > 0).then(|| k - cols);
        let south = (j + 1 < rows).then_some(k + cols);
        [west, east, north, south].into_iter().flatten()
    }

    /// Solves `Σ (T_p − T_q) = Σ v_pq` over the neighbours `q` of every `p` inside, `T = S` outside, in f64 by conjugate
    /// gradients; `v` is the difference of `k R`, or of `S` where that is larger and asked for.
    fn exact(&self, gain: f64, mixed: bool) -> Vec<f64> {
        let of = |field: &[f32], k: usize| f64::from(field[k]);
        let guide = |p: usize, q: usize| {
            let s = of(&self.source, p) - of(&self.source, q);
            let r = gain * (of(&self.reference, p) - of(&self.reference, q));
            if mixed && s.abs() > r.abs() { s } else { r }
        };
        let inside: Vec<usize> = (0..self.mask.len()).filter(|&k| self.mask[k] > 0.0).collect();
        let mut field: Vec<f64> = self.source.iter().map(|&s| f64::from(s)).collect();
        // Unknowns start at 0, so that what is known is on the right side.
        inside.iter().for_each(|&k| field[k] = 0.0);
        let laplace = |x: &[f64], p: usize| self.neighbours(p).map(|q| x[p] - x[q]).sum::<f64>();
        let right = |p: usize| self.neighbours(p).map(|q| guide(p, q)).sum::<f64>() - laplace(&field, p);
        let mut residual = vec![0.0; field.len()];
        inside.iter().for_each(|&p| residual[p] = right(p));
        let dot = |a: &[f64], b: &[f64]| inside.iter().map(|&k| a[k] * b[k]).sum::<f64>();
        let (mut x, mut direction) = (vec![0.0; field.len()], residual.clone());
        let mut size = dot(&residual, &residual);
        for _ in 0..4000 {
            if size < 1e-18 {
                break;
            }
            let mut image = vec![0.0; field.len()];
            inside.iter().for_each(|&p| image[p] = laplace(&direction, p));
            let step = size / dot(&direction, &image);
            inside.iter().for_each(|&k| {
                x[k] += step * direction[k];
                residual[k] -= step * image[k];
            });
            let next = dot(&residual, &residual);
            inside.iter().for_each(|&k| direction[k] = residual[k] + next / size * direction[k]);
            size = next;
        }
        assert!(size < 1e-9, "the reference converges, residual {size}");
        inside.iter().for_each(|&k| field[k] = x[k]);
        field
    }
}

fn range(field: &[f64]) -> f64 {
    let (low, high) = field.iter().fold((f64::MAX, f64::MIN), |(l, h), &v| (l.min(v), h.max(v)));
    high - low
}

#[test]
fn blend_equals_an_exact_solve() {
    let corner = |x: f64, y: f64| x < 0.4 && y < 0.6;
    let pieces = |x: f64, y: f64| (x * 3.0).fract() > 0.4 && (y * 2.0).fract() > 0.3;
    for (name, scene) in [
        ("ring", Scene::ring(65, 65)),
        ("on the border", Scene::new(50, 37, corner)),
        ("pieces", Scene::new(47, 80, pieces)),
        ("one row", Scene::new(90, 1, |x, _| x > 0.2 && x < 0.9)),
        ("one column", Scene::new(1, 31, |_, y| y < 0.7)),
    ] {
        for (gain, gradients) in [
            (1.0, Gradients::Reference),
            (0.3, Gradients::Mixed),
            (2.5, Gradients::Reference),
            (0.0, Gradients::Mixed),
        ] {
            let truth = scene.exact(f64::from(gain), gradients == Gradients::Mixed);
            let found = scene.blended(gain, gradients);
            let worst = truth.iter().zip(&found).fold(0.0f64, |m, (t, &f)| m.max((t - f64::from(f)).abs()));
            assert!(
                worst <= 1e-4 * range(&truth),
                "{name}, gain {gain}, {gradients:?}: {worst} of {}",
                range(&truth)
            );
        }
    }
}

#[test]
fn blend_of_a_field_into_itself_is_the_field() {
    let mut scene = Scene::ring(129, 65);
    scene.reference = scene.source.clone();
    for gradients in [Gradients::Reference, Gradients::Mixed] {
        assert_eq!(scene.blended(1.0, gradients), scene.source);
    }
}

#[test]
fn blend_that_covers_all_is_the_reference_with_its_gain_and_says_so() {
    let scene = Scene::new(9, 7, |_, _| true);
    for gradients in [Gradients::Reference, Gradients::Mixed] {
        let found = scene.blend(2.0, gradients).run(&Work::default()).expect("blends");
        assert!(found.covers_all);
        assert!(found.field.iter().zip(&scene.reference).all(|(t, r)| *t == 2.0 * r));
    }
    let none = Scene::new(9, 7, |_, _| false);
    let found = none.blend(2.0, Gradients::Mixed).run(&Work::default()).expect("blends");
    assert_eq!((found.covers_all, found.field), (false, none.source));
}

/// Second differences along rows: across the border of the region, and well inside it, 95th percentiles.
fn bends(scene: &Scene, field: &[f32]) -> (f32, f32) {
    let (mut across, mut inside) = (Vec::new(), Vec::new());
    for j in 0..scene.rows {
        for i in 1..scene.cols - 1 {
            let k = j * scene.cols + i;
            let bend = (field[k - 1] - 2.0 * field[k] + field[k + 1]).abs();
            match [k - 1, k, k + 1].iter().filter(|&&k| scene.mask[k] > 0.0).count() {
                0 => (),
                3 => inside.push(bend),
                _ => across.push(bend),
            }
        }
    }
    let percentile = |mut all: Vec<f32>| {
        all.sort_by(f32::total_cmp);
        all[all.len() * 95 / 100]
    };
    (percentile(across), percentile(inside))
}

#[test]
fn blend_has_no_seam() {
    let scene = Scene::ring(193, 193);
    let (across, inside) = bends(&scene, &scene.blended(1.0, Gradients::Reference));
    assert!(across <= 1.2 * inside, "{across} across the border, {inside} inside");
    let mut pasted = scene.source.clone();
    (0..pasted.len()).filter(|&k| scene.mask[k] > 0.0).for_each(|k| pasted[k] = scene.reference[k]);
    let (across, inside) = bends(&scene, &pasted);
    assert!(across > 4.0 * inside, "a plain paste shows: {across}, {inside}");
}

#[test]
fn mixed_gradients_keep_the_rougher_ground() {
    let mut scene = Scene::ring(97, 97);
    scene.reference.fill(7.0);
    let bent = |field: &[f32]| bends(&scene, field).1;
    let (plain, mixed) = (scene.blended(1.0, Gradients::Reference), scene.blended(1.0, Gradients::Mixed));
    let source = bent(&scene.source);
    assert!(bent(&plain) < 0.3 * source, "a flat reference makes a membrane");
    // All differences are those of the source then, so the source itself.
    assert!(mixed.iter().zip(&scene.source).all(|(t, s)| (t - s).abs() < 0.01));
}

#[test]
fn blend_refuses_arrays_that_do_not_fit_and_stops_when_asked() {
    let scene = Scene::ring(33, 33);
    let blend = scene.blend(1.0, Gradients::Mixed);
    let short = Blend { reference: &scene.reference[1..], ..blend };
    let expected = Error::Length { array: "reference", found: 33 * 33 - 1, expected: 33 * 33 };
    assert_eq!(short.run(&Work::default()), Err(expected));
    let cancel = Cancel::default();
    cancel.cancel();
    assert_eq!(blend.run(&Work::new(&cancel)), Err(Error::Cancelled));
    let nothing = Blend { cols: 0, rows: 0, source: &[], reference: &[], mask: &[], ..blend };
    assert!(nothing.run(&Work::default()).is_ok_and(|found| found.field.is_empty()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn blends_are_finite_and_keep_the_source_outside(
        (cols, rows) in (1usize..20, 1usize..20),
        seed in 0u64..1000,
        share in 0.0f64..1.0,
        gain in prop_oneof![Just(0.0f32), -3.0f32..10.0, Just(1e4)],
        mixed in any::<bool>(),
    ) {
        let mut scene = Scene::new(cols, rows, |_, _| true);
        for (k, mask) in scene.mask.iter_mut().enumerate() {
            *mask = if hash::unit(seed, k as u64) < share { hash::unit(seed, k as u64 + 999) as f32 } else { 0.0 };
        }
        let found = scene.blended(gain, if mixed { Gradients::Mixed } else { Gradients::Reference });
        for (k, t) in found.iter().enumerate() {
            prop_assert!(t.is_finite());
            prop_assert!(scene.mask[k] > 0.0 || t.to_bits() == scene.source[k].to_bits());
        }
    }
}
