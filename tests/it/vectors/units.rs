//! The page: units, view boxes, and how they come to lie on the terrain.

use orograph::files::vectors::svg::Fit;

use super::{corners, plain, svg};

/// Where a line from 20 to 80 of 100 parts of the page, at 20, comes to lie on 1000 by 1000 m.
#[test]
fn a_page_is_as_large_as_it_says_in_any_unit() {
    for (unit, in_user_units) in [
        ("", 1.0),
        ("px", 1.0),
        ("mm", 96.0 / 25.4),
        ("cm", 96.0 / 2.54),
        ("in", 96.0),
        ("pt", 96.0 / 72.0),
        ("pc", 16.0),
        ("em", 16.0),
        ("ex", 8.0),
        ("Q", 96.0 / 101.6),
        ("MM", 96.0 / 25.4),
    ] {
        let [a, b] = [20.0 * in_user_units, 80.0 * in_user_units];
        let page = format!("width=\"100{unit}\" height=\"100{unit}\"");
        // By the path's numbers, and by lengths in the same unit.
        for line in [
            format!("<path d=\"M{a},{a} L{b},{a}\"/>"),
            format!("<line x1=\"20{unit}\" y1=\"20{unit}\" x2=\"80{unit}\" y2=\"20{unit}\"/>"),
            "<line x1=\"20%\" y1=\"20%\" x2=\"80%\" y2=\"20%\"/>".to_owned(),
        ] {
            let got = svg(&format!("<svg {page}>{line}</svg>"), Fit::Inside, &plain()).expect(&line);
            assert_eq!(corners(&got), [[[200, 200], [800, 200]]], "{page} {line}");
        }
    }
}

#[test]
fn the_view_box_lies_in_the_page_and_the_page_on_the_terrain() {
    let line = r#"<path d="M20,20 L80,20"/>"#;
    for (page, fit, want) in [
        // The view box alone is the page.
        ("viewBox='0 0 100 100'", Fit::Inside, [[200, 200], [800, 200]]),
        ("viewBox='0 0 100 100' width='100%' height='100%'", Fit::Inside, [[200, 200], [800, 200]]),
        ("viewBox='10 10 100 100'", Fit::Inside, [[100, 100], [700, 100]]),
        ("viewBox='-100,-100,200,200'", Fit::Inside, [[600, 600], [900, 600]]),
        // Another size of the page changes nothing where its sides are in the same proportion.
        ("viewBox='0 0 100 100' width='210mm' height='210mm'", Fit::Inside, [[200, 200], [800, 200]]),
        ("viewBox='0 0 100 100' width='7in'", Fit::Inside, [[200, 200], [800, 200]]),
        // A wide page lies in the middle, or is stretched.
        ("viewBox='0 0 200 100'", Fit::Inside, [[100, 350], [400, 350]]),
        ("viewBox='0 0 200 100'", Fit::Stretch, [[100, 200], [400, 200]]),
        // A square view box in a wide page.
        ("viewBox='0 0 100 100' width='200' height='100'", Fit::Inside, [[350, 350], [650, 350]]),
        ("viewBox='0 0 100 100' width='200' height='100'", Fit::Stretch, [[350, 200], [650, 200]]),
        (
            "viewBox='0 0 100 100' width='200' height='100' preserveAspectRatio='none'",
            Fit::Stretch,
            [[200, 200], [800, 200]],
        ),
        (
            "viewBox='0 0 100 100' width='200' height='100' preserveAspectRatio='xMinYMin meet'",
            Fit::Stretch,
            [[100, 200], [400, 200]],
        ),
        (
            "viewBox='0 0 100 100' width='200' height='100' preserveAspectRatio='xMidYMax slice'",
            Fit::Stretch,
            [[200, -600], [800, -600]],
        ),
    ] {
        let got = svg(&format!("<svg {page}>{line}</svg>"), fit, &plain()).expect(page);
        assert_eq!(corners(&got), [want], "{page} {fit:?}");
    }
}

#[test]
fn units_that_cannot_be_known_are_named() {
    for unit in ["rem", "vw", "vh", "VMAX"] {
        let text = format!("<svg width='10{unit}' height='10' viewBox='0 0 1 1'/>");
        let error = svg(&text, Fit::Inside, &plain()).expect_err(unit).to_string();
        let want = format!("the length of the unit `{}` cannot be known", unit.to_ascii_lowercase());
        assert!(error.contains(&want), "{error}");
    }
}
