//! Ramps: pieces, steps, and the way of many samples against that of one.

use super::*;
use crate::kit::simd::Level;

fn near(a: [f32; 3], b: [f32; 3], tolerance: f32) -> bool {
    (0..3).all(|k| (a[k] - b[k]).abs() <= tolerance)
}

#[test]
fn stops_keep_their_colours() {
    for (name, palette) in Palette::BUILTIN {
        let ramp = Ramp::builtin(name).unwrap();
        for Stop { at, color } in palette.stops() {
            assert!(
                near(ramp.color(at), color, 2e-3),
                "{name} at {at}: {:?} is not {color:?}",
                ramp.color(at)
            );
        }
    }
    assert!(Ramp::builtin("plaid").is_none());
    assert!(near(Ramp::builtin("grey").unwrap().color(0.0123), [0.0123; 3], 1e-6));
}

#[test]
fn ramps_stay_in_range_and_have_no_jumps() {
    for (name, palette) in Palette::BUILTIN {
        for blend in [Blend::Smooth, Blend::Linear] {
            let ramp = Ramp::of(&palette, blend);
            let mut before = ramp.color(0.0);
            for i in 1..=4096 {
                let now = ramp.color(i as f32 / 4096.0);
                assert!(now.iter().all(|v| (0.0..=1.0).contains(v)), "{name}: {now:?}");
                assert!(near(before, now, 0.004), "{name} jumps at {i}");
                before = now;
            }
        }
    }
}

#[test]
fn viridis_is_matplotlibs() {
    // The first, middle and last entry of matplotlib's table.
    let ramp = Ramp::builtin("viridis").unwrap();
    for (t, hex) in [(0.0, 0x440154), (0.5, 0x21918c), (1.0, 0xfde725)] {
        assert!(near(ramp.color(t), srgb_from_hex(hex), 0.02), "{t}: {:?}", ramp.color(t));
    }
}

/// A colour as it is looked up by itself.
fn plain(ramp: &Ramp, t: f32) -> [f32; 3] {
    let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
    let begun = ramp.pieces.partition_point(|&(start, _)| start <= t);
    let (start, per_width) = ramp.pieces[begun - 1];
    let u = (t - start) * per_width;
    if u >= 1.0 {
        return ramp.table[begun * PIECE].color;
    }
    let along = u * STEPS as f32;
    let k = (along as usize).min(STEPS - 1);
    let (a, b) = (ramp.table[(begun - 1) * PIECE + k], ramp.table[(begun - 1) * PIECE + k + 1]);
    [0, 1, 2].map(|c| a.color[c] + (b.color[c] - a.color[c]) * (along - k as f32))
}

#[test]
fn a_row_has_the_colours_of_its_places_on_every_instruction_set() {
    let place = |i: usize| match i % 37 {
        3 => f32::NAN,
        9 => f32::INFINITY,
        17 => -0.0,
        21 => 1.0,
        k => (i as f32 * 0.618_034).fract() * 1.2 - if k == 5 { 0.5 } else { 0.1 },
    };
    let stop = |at: f32, v: f32| Stop { at, color: [v, 1.0 - v, 0.5 * v] };
    let edges = vec![stop(0.2, 0.1), stop(0.5, 0.9), stop(0.5, 0.3), stop(0.5, 0.7), stop(0.8, 0.2)];
    let ramps = Palette::BUILTIN.iter().flat_map(|(_, palette)| {
        [Blend::Smooth, Blend::Linear, Blend::Steps].map(|blend| Ramp::of(palette, blend))
    });
    let own = [vec![], vec![stop(0.4, 0.5)], edges].map(|stops| Ramp::new(stops, Blend::Smooth));
    for ramp in ramps.chain(own) {
        for (level, n) in
            Level::available().into_iter().flat_map(|level| [(level, 1), (level, 64), (level, 777)])
        {
            let mut row = vec![[f32::NAN; 3]; n];
            let places = |first: usize, ts: &mut [f32]| {
                ts.iter_mut().enumerate().for_each(|(i, t)| *t = place(first + i));
            };
            ramp.row_on(level, places, &mut row);
            for (i, got) in row.iter().enumerate() {
                let want = plain(&ramp, place(i)).map(f32::to_bits);
                assert_eq!(ramp.color(place(i)).map(f32::to_bits), want);
                assert_eq!(got.map(f32::to_bits), want, "{i} of {n} at {} on {level:?}", place(i));
            }
        }
    }
}

#[test]
fn steps_and_hard_edges_are_exact() {
    let stop = |at: f64, v: f64| [Ratio(at), Ratio(v), Ratio(v), Ratio(v)];
    let palette =
        Palette::Custom { stops: vec![stop(0.75, 0.9), stop(0.25, 0.1), stop(0.5, 0.4), stop(0.5, 0.6)] };
    let grey = |blend, t| Ramp::of(&palette, blend).color(t)[0];
    assert_eq!(grey(Blend::Steps, 0.1), 0.1);
    assert_eq!(grey(Blend::Steps, 0.499_999), 0.1);
    assert_eq!(grey(Blend::Steps, 0.5), 0.6);
    assert_eq!(grey(Blend::Steps, 0.8), 0.9);
    assert!((grey(Blend::Linear, 0.499_999) - 0.4).abs() < 1e-3);
    assert!((grey(Blend::Linear, 0.5) - 0.6).abs() < 1e-3);
    assert_eq!(grey(Blend::Smooth, f32::NAN), 0.1);
    assert_eq!(Ramp::new(Vec::new(), Blend::Smooth).color(0.5), [0.0; 3]);
}

#[test]
fn the_satellite_sees_snow_rock_and_forest() {
    let light = |[r, g, b]: [f32; 3]| 0.21 * r + 0.72 * g + 0.07 * b;
    let (forest, wall, snow) = (satellite(0.25, 20.0), satellite(0.25, 60.0), satellite(1.0, 10.0));
    assert!(forest[1] > forest[0] && forest[1] > forest[2], "forest is green: {forest:?}");
    assert!((wall[0] - wall[2]).abs() < 0.12, "a wall is grey: {wall:?}");
    assert!(light(snow) > 0.9 && light(satellite(1.0, 75.0)) < 0.7, "walls shed their snow");
    assert!(satellite(f32::NAN, f32::INFINITY).iter().all(|v| (0.0..=1.0).contains(v)));
}
