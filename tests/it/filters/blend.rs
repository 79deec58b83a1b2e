//! Combine, mix and switch.

use super::*;

fn combined(mode: combine::Mode, a: (Quantity, &[f32]), b: (Quantity, &[f32])) -> (Vec<f32>, Quantity) {
    let at = window([0, 0], [a.1.len() as i64, 1]);
    let out = run(&Combine { mode, ..Combine::default() }, at, &|port, g| {
        let (quantity, values) = if port == "a" { a } else { b };
        Some(Value::Field(Field::new(*g, quantity, values.to_vec())))
    });
    (out.data().to_vec(), out.quantity())
}

#[test]
fn combine_computes_what_its_modes_say() {
    use combine::Mode;
    let (height, mask) = (Quantity::Elevation, Quantity::Mask);
    let (a, b): (&[f32], &[f32]) = (&[6.0, -8.0, 0.0, 2.0], &[2.0, 3.0, -4.0, 0.0]);
    let width = Number(4.0);
    let cases: [(Mode, [f32; 4]); 11] = [
        (Mode::Add, [8.0, -5.0, -4.0, 2.0]),
        (Mode::Subtract, [4.0, -11.0, 4.0, 2.0]),
        (Mode::Multiply, [12.0, -24.0, 0.0, 0.0]),
        (Mode::Divide, [3.0, -8.0 / 3.0, 0.0, 2.0 / 1e-6]),
        (Mode::Min, [2.0, -8.0, -4.0, 0.0]),
        (Mode::Max, [6.0, 3.0, 0.0, 2.0]),
        (Mode::SmoothMin { width }, [2.0, -8.0, -4.0, -0.25]),
        (Mode::SmoothMax { width }, [6.0, 3.0, 0.0, 2.25]),
        (Mode::Average, [4.0, -2.5, -2.0, 1.0]),
        (Mode::Difference, [4.0, 11.0, 4.0, 2.0]),
        (Mode::Power, [36.0, -512.0, 1e24, 1.0]),
    ];
    for (mode, want) in cases {
        let (got, _) = combined(mode, (height, a), (height, b));
        let near = |(g, w): (&f32, &f32)| (g - w).abs() <= 1e-5 * w.abs();
        assert!(got.iter().zip(&want).all(near), "{mode:?}: {got:?}, not {want:?}");
    }
    let quantity = |mode, a, b| combined(mode, (a, &[0.7]), (b, &[0.8]));
    assert_eq!(quantity(Mode::Add, mask, mask), (vec![1.0], mask));
    assert_eq!(quantity(Mode::Multiply, mask, height).1, height);
    assert_eq!(quantity(Mode::Multiply, height, mask).1, height);
    assert_eq!(quantity(Mode::Difference, height, height).1, Quantity::Length);
    assert_eq!(quantity(Mode::Divide, height, height).1, Quantity::Number);
}

#[test]
fn mix_and_strength_go_between() {
    let at = window([0, 0], [30, 20]);
    let source = |p: &str, g: &Grid| Some(Value::Field(if p == "a" { rough(g) } else { field(g, |x, _| x) }));
    let (a, b) = (rough(&at), field(&at, |x, _| x));
    assert_eq!(bits(&run(&Mix::default(), at, &source)), bits(&b));
    let half = run(&Mix { amount: Ratio(0.25) }, at, &source);
    let subtract = Combine { mode: combine::Mode::Subtract, strength: Ratio(0.5) };
    let weak = run(&subtract, at, &source);
    for (i, (a, b)) in a.data().iter().zip(b.data()).enumerate() {
        assert!((half.data()[i] - (0.75 * a + 0.25 * b)).abs() < 1e-3);
        assert!((weak.data()[i] - (a - 0.5 * b)).abs() < 1e-3);
    }
}

#[test]
fn switch_takes_one_and_needs_no_other() {
    let at = window([0, 0], [9, 5]);
    let node = Switch { choice: 2 };
    let only_c = |p: &str, g: &Grid| match p {
        "a" => Some(Value::Field(Raster::constant(*g, Quantity::Elevation, 1.0))),
        "c" => Some(Value::Field(rough(g))),
        _ => None,
    };
    assert_eq!(bits(&run(&node, at, &only_c)), bits(&rough(&at)));
    assert!(!Node::uses(&node, "a") && Node::uses(&node, "c"));
    let error = Bench::of(&Switch { choice: 3 }).run(&world(), at, &only_c).unwrap_err().to_string();
    assert_eq!(error, "input `d` is not connected, and `choice` is 3");
}
