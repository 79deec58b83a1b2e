//! Values of the `transform` and `transform-origin` properties, as styles write them.

use super::place::{Affine, Along, Viewport};
use crate::value::curves::bezier::Point;

/// The steps of a `transform`.
///
/// # Errors
/// Names the function that is none of a plane, or what is no number.
pub(super) fn steps(text: &str, view: Viewport) -> Result<Vec<Affine>, String> {
    let mut steps = Vec::new();
    let mut rest = text.trim();
    if ["none", "initial", "unset"].iter().any(|word| rest.eq_ignore_ascii_case(word)) {
        return Ok(steps);
    }
    while !rest.is_empty() {
        let (name, after) = rest.split_once('(').ok_or_else(|| unread(text))?;
        let (values, after) = after.split_once(')').ok_or_else(|| unread(text))?;
        let values: Vec<&str> = words(values).collect();
        let step = step(&name.trim().to_ascii_lowercase(), &values, view);
        steps.push(step.ok_or_else(|| unread(text))?);
        rest = after.trim_start_matches(|c: char| c.is_ascii_whitespace() || c == ',');
    }
    Ok(steps)
}

/// The point about which an element is moved.
///
/// # Errors
/// When it is none.
pub(super) fn origin(text: &str, view: Viewport) -> Result<Point, String> {
    let bad = || format!("`transform-origin` cannot be read: \"{text}\"");
    let mut all = words(text);
    let (first, second) = (all.next().ok_or_else(bad)?, all.next());
    let is_vertical = |word: &str| matches!(&*word.to_ascii_lowercase(), "top" | "bottom");
    let is_level = |word: &str| matches!(&*word.to_ascii_lowercase(), "left" | "right");
    let turned = is_vertical(first) || second.is_some_and(is_level);
    let second = second.unwrap_or("center");
    let [x, y] = if turned { [second, first] } else { [first, second] };
    let at = |word: &str, along: Along| {
        let share = match &*word.to_ascii_lowercase() {
            "left" | "top" => "0%",
            "center" => "50%",
            "right" | "bottom" => "100%",
            _ => word,
        };
        view.length_of(share, along).map_err(|_| bad())
    };
    Ok([at(x, Along::Width)?, at(y, Along::Height)?])
}

fn unread(text: &str) -> String {
    format!("the style `transform` cannot be read: \"{text}\"")
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_ascii_whitespace() || c == ',').filter(|word| !word.is_empty())
}

fn step(name: &str, values: &[&str], view: Viewport) -> Option<Affine> {
    let number = |text: &str| text.parse::<f64>().ok().filter(|v| v.is_finite());
    let x = |text: &str| view.length_of(text, Along::Width).ok();
    let y = |text: &str| view.length_of(text, Along::Height).ok();
    Some(match (name, values) {
        ("matrix", [a, b, c, d, e, f]) => {
            Affine([number(a)?, number(b)?, number(c)?, number(d)?, x(e)?, y(f)?])
        }
        ("translate", [a]) | ("translatex", [a]) => Affine::shift(x(a)?, 0.0),
        ("translate", [a, b]) => Affine::shift(x(a)?, y(b)?),
        ("translatey", [b]) => Affine::shift(0.0, y(b)?),
        ("scale", [a]) => Affine::scale(number(a)?, number(a)?),
        ("scale", [a, b]) => Affine::scale(number(a)?, number(b)?),
        ("scalex", [a]) => Affine::scale(number(a)?, 1.0),
        ("scaley", [b]) => Affine::scale(1.0, number(b)?),
        ("rotate", [angle]) => Affine::rotate(degrees(angle)?),
        ("skew", [a]) | ("skewx", [a]) => Affine::skew(degrees(a)?, 0.0),
        ("skew", [a, b]) => Affine::skew(degrees(a)?, degrees(b)?),
        ("skewy", [b]) => Affine::skew(0.0, degrees(b)?),
        _ => return None,
    })
}

/// An angle with its unit, in degrees.
fn degrees(text: &str) -> Option<f64> {
    let lower = text.to_ascii_lowercase();
    // The longer name first: "grad" ends in "rad".
    let units =
        [("turn", 360.0), ("grad", 0.9), ("rad", 180.0 / std::f64::consts::PI), ("deg", 1.0), ("", 1.0)];
    let (number, unit) =
        units.into_iter().find_map(|(name, unit)| Some((lower.strip_suffix(name)?, unit)))?;
    number.parse::<f64>().ok().map(|v| v * unit).filter(|v| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEW: Viewport = Viewport([200.0, 100.0]);

    #[test]
    fn transforms_of_styles_have_units() {
        for (text, point, want) in [
            ("none", [1.0, 2.0], [1.0, 2.0]),
            ("translate(20px, 10%)", [0.0, 0.0], [20.0, 10.0]),
            ("translateX(10%) scaleY(2)", [1.0, 3.0], [21.0, 6.0]),
            ("rotate(90deg)", [1.0, 0.0], [0.0, 1.0]),
            ("rotate(0.25turn)", [1.0, 0.0], [0.0, 1.0]),
            ("rotate(100grad)", [1.0, 0.0], [0.0, 1.0]),
            ("Scale(2) matrix(1 0 0 1 5 6)", [1.0, 1.0], [12.0, 14.0]),
            ("skewX(45deg)", [0.0, 1.0], [1.0, 1.0]),
        ] {
            let steps = steps(text, VIEW).expect(text);
            let all = steps.iter().fold(Affine::shift(0.0, 0.0), |all, step| all.after(step));
            let got = all.apply(point);
            assert!((0..2).all(|k| (got[k] - want[k]).abs() < 1e-9), "{text}: {got:?}");
        }
        for bad in [
            "translate3d(1px,2px,3px)",
            "rotate",
            "rotate(",
            "rotate(x)",
            "scale()",
            "10px",
            "perspective(1px)",
        ] {
            assert!(steps(bad, VIEW).is_err(), "{bad}");
        }
    }

    #[test]
    fn origins_are_lengths_shares_and_words() {
        for (text, want) in [
            ("50 50", [50.0, 50.0]),
            ("10px 20px 0", [10.0, 20.0]),
            ("50% 50%", [100.0, 50.0]),
            ("center", [100.0, 50.0]),
            ("right", [200.0, 50.0]),
            ("top", [100.0, 0.0]),
            ("bottom left", [0.0, 100.0]),
            ("25%", [50.0, 50.0]),
        ] {
            assert_eq!(origin(text, VIEW), Ok(want), "{text}");
        }
        assert!(origin("", VIEW).is_err() && origin("here", VIEW).is_err());
    }
}
