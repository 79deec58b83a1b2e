//! Faults, warnings and limits.

use orograph::files::vectors::MAX_POSITIONS;
use orograph::files::vectors::svg::Fit;

use super::{drawn, read};
use crate::vectors::{corners, mapping, plain, svg};

#[test]
fn faulty_lines_are_left_out_with_a_warning() {
    let good = r#"<path h="1" d="M 0 0 L 50 50"/>"#;
    for (body, left, warning) in [
        (
            r#"<path id="x" h="1" d="M 0 0 L 10 10 L oops"/>"#,
            1,
            "1 element with broken data, taken up to the fault: path `x` in line 1: `d` cannot be read",
        ),
        (
            r#"<polyline h="1" points="0,0 10,10 20,x"/>"#,
            1,
            "1 element with broken data, taken up to the fault: polyline in line 1: `points` cannot be read",
        ),
        (r#"<polyline h="1" points="0,0 10,10 20"/>"#, 1, "`points` ends with an x without a y, 20"),
        (
            r#"<path h="high" d="M 0 0 L 1 1"/>"#,
            0,
            "1 line with an unusable property, left out: path in line 1: property `h` must be numbers, got \"high\"",
        ),
        (r#"<path transform="spin(3)" h="1" d="M 0 0 L 1 1"/>"#, 0, "`transform` cannot be read"),
        (
            r#"<line h="1" x1="1 fathom"/>"#,
            0,
            "1 element with an unreadable attribute, left out: line in line 1: `x1` cannot be read",
        ),
        (r#"<circle h="1" r="-4"/>"#, 0, "`r` must be 0 or above, got -4"),
        (
            "<path h=\"1\" d=\"M 5 5 L 5 5\"/>\n<path h=\"1\" d=\"M 1 1 z\"/>",
            0,
            "2 lines without length, left out; the first: path in line 1",
        ),
        (r#"<rect h="1" width="5" height="0"/>"#, 0, "1 line without length, left out: rect in line 1"),
        (
            r#"<path h="1" d="M 0 0 L 1e300 1e300"/>"#,
            0,
            "1 line that no curve can follow, left out: path in line 1: point 1 must lie within",
        ),
        (
            "<path d='M 0 0 L 1 1'/>\n<text>words</text>",
            1,
            "1 geometry that is no line, left out: text in line 2: `text` holds no line",
        ),
        (
            r##"<use href="#gone"/><use/><use href="other.svg#x"/>"##,
            0,
            "3 `use` that draw nothing, left out; the first: use in line 1: names `#gone`, which is no element of this file",
        ),
        (
            r#"<path h="1" d="M 200 0 L 300 50"/>"#,
            1,
            "1 line wholly off the terrain, taken all the same: path in line 1",
        ),
        ("a &thing; b", 0, "1 undefined entity, left out: `&thing;` at byte"),
    ] {
        let got = read(&format!("{body}{good}")).expect(body);
        assert_eq!(got.curves.len(), left + 1, "{body}: {:?}", got.warnings);
        assert!(got.warnings.len() == 1 && got.warnings[0].contains(warning), "{body}: {:?}", got.warnings);
    }
    let kept = read(r#"<path h="1" d="M 10 10 L 20 20 H x"/>"#).expect("what came before the fault");
    assert_eq!(corners(&kept), [[[100, 100], [200, 200]]]);
}

#[test]
fn files_that_are_no_svg_are_refused() {
    let whole = |text: &str| svg(text, Fit::Stretch, &mapping());
    for (text, message) in [
        ("<path", "is not XML"),
        ("", "is not XML: there is no element"),
        ("<svg viewBox='0 0 1 1'><g></svg>", "is not XML"),
        ("<svg viewBox='0 0 1 1'><g>", "is not XML: `g` has no end"),
        ("<html/>", "must be an `svg` element, got `html`"),
        ("<svg/>", "must have a viewBox, or a width and a height that are lengths"),
        ("<svg width='20'/>", "must have a viewBox, or a width and a height that are lengths"),
        ("<svg width='100%' height='100%'/>", "must have a viewBox"),
        ("<svg viewBox='0 0 0 1'/>", "`viewBox` must be four numbers, the last two above 0"),
        ("<svg width='0' height='1'/>", "`width` must be above 0, got 0"),
        ("<svg width='1' height='1e-320'/>", "cannot be laid on"),
    ] {
        let error = whole(text).expect_err(text).to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    assert!(whole(r#"<svg width="20" height="10"/>"#).is_ok());
}

#[test]
fn limits_name_what_was_found() {
    let long = format!(
        r#"<svg viewBox="0 0 1 1"><path h="1" d="M0 0{}"/></svg>"#,
        " 1 1 0 0".repeat(MAX_POSITIONS / 2 + 1)
    );
    let error = svg(&long, Fit::Inside, &mapping()).expect_err("too long").to_string();
    assert!(error.contains("positions in the file: at most 1048576, got 1048577"), "{error}");
    let many = format!("<svg viewBox='0 0 1 1'>{}</svg>", "<path d='m0 0h1'/>".repeat(70_000));
    let error = svg(&many, Fit::Inside, &plain()).expect_err("too many").to_string();
    assert!(error.contains("curves: at most 65536, got 70000"), "{error}");
    let nested =
        format!(r#"<svg viewBox="0 0 1 1">{}{}</svg>"#, "<g>".repeat(300_000), "</g>".repeat(300_000));
    assert!(svg(&nested, Fit::Inside, &mapping()).is_ok());
    let groups = format!("<svg viewBox='0 0 1 1'>{}</svg>", "<g/>".repeat(1 << 20));
    let error = svg(&groups, Fit::Inside, &plain()).expect_err("too many").to_string();
    assert!(error.contains("elements of the picture: at most 1048576, got 1048577"), "{error}");
}

#[test]
fn pictures_without_lines_are_warned_of() {
    assert!(drawn("").is_empty());
    assert!(drawn(r#"<path display="none" d="M0 0h1"/>"#).is_empty());
}

#[test]
fn sizes_in_styles_and_foreign_elements_are_warned_of() {
    let line = r#"<path d="M0 0h10"/>"#;
    for (root, body, warning) in [
        ("", "<rect width='10' height='60' style='width:60px'/>", "`width` in the style of rect in line 1"),
        ("style='height:50px'", "", "`height` in the style of svg in line 1"),
        ("", "<style>rect{width:9px}</style>", "`width` of the style sheet"),
        (
            "",
            "<foreignObject style='width:9px'><path d='M0 0h1'/></foreignObject>",
            "`foreignObject` holds no line",
        ),
    ] {
        let text = format!("<svg viewBox='0 0 100 100' {root}>{body}{line}</svg>");
        let got = svg(&text, Fit::Inside, &plain()).expect(body);
        assert!(got.warnings.len() == 1 && got.warnings[0].contains(warning), "{body}: {:?}", got.warnings);
    }
    // Of a `switch` what stands for a foreign element is drawn.
    assert_eq!(drawn(&format!("<switch><foreignObject/>{line}</switch>")).len(), 1);
}
