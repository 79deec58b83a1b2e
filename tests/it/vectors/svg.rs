//! Pictures: what is drawn of them and where it comes to lie.

use orograph::files::vectors::svg::Fit;
use orograph::files::vectors::{Imported, MAX_POSITIONS};
use orograph::value::curves::CurveError;

use super::{corners, mapping, plain, svg};
use crate::curves::hypot;

fn read(body: &str) -> Result<Imported, CurveError> {
    svg(
        &format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">{body}</svg>"#),
        Fit::Inside,
        &mapping(),
    )
}

/// What is said of a picture that gives no curve.
const NOTHING: &str = "the file has no line that becomes a curve";

/// The corners of all curves of a body on a page of 100 by 100, laid on 1000 by 1000 m.
fn drawn(body: &str) -> Vec<Vec<[i64; 2]>> {
    let text = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="0 0 100 100">{body}</svg>"#
    );
    let got = svg(&text, Fit::Inside, &plain()).expect(body);
    let nothing = got.curves.is_empty().then(|| NOTHING.to_owned());
    assert_eq!(got.warnings, nothing.into_iter().collect::<Vec<_>>(), "{body}");
    corners(&got)
}

#[test]
fn svg_paths_lie_on_the_terrain() {
    let got = read(r#"<g transform="translate(10 0)"><path id="a" data-h="100,200" d="M0 50 h10 v10 l10,-10 C 30 50 40 40 50 40 S 60 30 70 40 Q 75 50 80 40 T 90 40"/></g>
        <polyline points="0,0 10,0 10,10" h="5"/><line x1="0" y1="90" x2="50" y2="90" data-angle="-30"/>
        <defs><path d="M0 0 L1 1"/></defs><polygon points="20,20 30,20 30,30" h="7"/>"#).expect("curves");
    assert_eq!(got.curves.len(), 4);
    let all: Vec<_> = got.curves.iter().collect();
    assert_eq!(all[0].name(), "a");
    assert_eq!(all[0].point(0.0), [100.0, 500.0]);
    assert_eq!(all[0].point(1.0), [1000.0, 400.0]);
    assert_eq!(all[0].height(0.0), Some(100.0));
    assert_eq!(all[0].height(1.0), Some(200.0));
    assert_eq!(all[2].attributes(0.5).slope.map(|s| s.left_angle), Some(-30.0));
    assert!(all[3].is_closed());
    assert!((all[3].length() - (200.0 + 100.0 * 2f64.sqrt())).abs() < 1e-6);
}

#[test]
fn svg_arcs_are_circles() {
    let got = read(r#"<path h="1" d="M 20 50 a 30 30 0 0 1 60 0 A 30 30 0 0 1 20 50 z m 1 1 h 5"/>"#)
        .expect("curves");
    assert_eq!(got.curves.len(), 2);
    let ring = got.curves.iter().next().expect("a ring");
    assert!(ring.is_closed());
    assert!((ring.length() / (600.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3, "{}", ring.length());
    for k in 0..100 {
        let p = ring.point(f64::from(k) / 100.0);
        assert!((hypot(p[0] - 500.0, p[1] - 500.0) - 300.0).abs() < 0.2, "{p:?}");
    }
    // With the sweep flag set it goes clockwise on the map: first over the north.
    assert!(ring.point(0.25)[1] < 210.0, "{:?}", ring.point(0.25));
    // Radii that are too small grow; turned ellipses end where they should.
    let got = read(r#"<path h="1" d="M 10 10 A 1 2 30 0 0 50 40"/><path h="1" d="M0 0A0 5 0 0 0 9 9"/>"#)
        .expect("curves");
    let end = got.curves.iter().next().expect("an arc").point(1.0);
    assert!((end[0] - 500.0).abs() < 1e-6 && (end[1] - 400.0).abs() < 1e-6, "{end:?}");
}

#[test]
fn a_line_that_is_wrong_costs_itself_alone_and_a_warning_names_it() {
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
fn what_is_no_picture_is_refused() {
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
fn shapes_are_outlines() {
    let ring = |r: i64| [[500 + r, 600], [500, 600 + r], [500 - r, 600], [500, 600 - r], [500 + r, 600]];
    assert_eq!(drawn(r#"<circle cx="50" cy="60" r="20"/>"#), [ring(200)]);
    assert_eq!(drawn(r#"<ellipse cx="50" cy="60" rx="20"/>"#), [ring(200)]);
    let oval = [[600, 600], [500, 800], [400, 600], [500, 400], [600, 600]];
    assert_eq!(drawn(r#"<ellipse cx="50%" cy="60%" rx="10%" ry="20"/>"#), [oval]);
    let square = [[100, 200], [400, 200], [400, 300], [100, 300], [100, 200]];
    assert_eq!(drawn(r#"<rect x="10" y="20" width="30" height="10"/>"#), [square]);
    // Radii that are too large make an ellipse; the sides that are left have no length.
    let round = [[250, 200], [400, 250], [250, 300], [100, 250], [250, 200]];
    assert_eq!(drawn(r#"<rect x="10" y="20" width="30" height="10" rx="99"/>"#), [round]);
    let rounded = drawn(r#"<rect width="30" height="10" ry="2" rx="auto"/>"#);
    assert_eq!(rounded[0].len(), 9);
    assert_eq!(rounded[0][..3], [[20, 0], [280, 0], [300, 20]]);
    assert_eq!(drawn(r#"<line x2="10" y2="20"/>"#), [[[0, 0], [100, 200]]]);
    let triangle = [[0, 0], [100, 0], [0, 100], [0, 0]];
    assert_eq!(
        drawn(r#"<polygon points="0 0 10 0 0 10"/><polygon points="0,0,10,0,0,10,0,0"/>"#),
        [triangle; 2]
    );
}

#[test]
fn use_draws_what_it_names_where_it_stands() {
    let line = |x: i64, y: i64| [[x, y], [x + 100, y]];
    let bar = r#"<defs><path id="bar" d="M0 0h10"/></defs>"#;
    for (body, want) in [
        (r##"<use href="#bar" x="20" y="30"/>"##, vec![line(200, 300)]),
        (r##"<use xlink:href="#bar" x="20%" transform="translate(0 5)"/>"##, vec![line(200, 50)]),
        (
            r##"<g id="two"><use href="#bar"/><use href="#bar" y="1"/></g><use href="#two" y="50"/>"##,
            vec![line(0, 0), line(0, 10), line(0, 500), line(0, 510)],
        ),
        (r##"<use href="#later" x="1"/><g id="later" display="none"><path d="M0 0h10"/></g>"##, vec![]),
        (
            r##"<symbol id="s" viewBox="0 0 1 1"><path d="M0 .5h1"/></symbol><use href="#s" x="10" y="10" width="10" height="10"/>"##,
            vec![line(100, 150)],
        ),
        (
            r##"<symbol id="s" width="10" height="10" viewBox="0 0 1 1"><path d="M0 .5h1"/></symbol><use href="#s"/>"##,
            vec![line(0, 50)],
        ),
        (
            r##"<svg id="s" width="0" height="10" viewBox="0 0 1 1"><path d="M0 .5h1"/></svg><use href="#s" width="10"/>"##,
            vec![line(0, 50)],
        ),
        (r##"<use href="#bar" visibility="hidden"/>"##, vec![]),
    ] {
        assert_eq!(drawn(&format!("{bar}{body}")), want, "{body}");
    }
    // The element says more than the `use`, which says more than nothing.
    let got = read(
        r##"<defs><path id="a" d="M0 0h9"/><path id="b" h="5" d="M0 0h9"/></defs>
        <use id="one" href="#a" data-h="7"/><use href="#b" data-h="7"/>"##,
    )
    .expect("curves");
    let told: Vec<_> = got.curves.iter().map(|c| (c.name().to_owned(), c.height(0.0))).collect();
    assert_eq!(told, [("a".to_owned(), Some(7.0)), ("b".to_owned(), Some(5.0))]);
}

#[test]
fn an_inner_picture_has_units_of_its_own() {
    for (inner, want) in [
        (r#"x="20" y="30" width="10" height="10" viewBox="0 0 2 2""#, [[200, 350], [300, 350]]),
        (r#"x="20%" y="30%" width="10%" height="10%" viewBox="0 0 2 2""#, [[200, 350], [300, 350]]),
        (r#"x="2" y="3""#, [[20, 40], [40, 40]]),
        (r#"width="40" height="20" viewBox="0 0 2 2""#, [[100, 100], [300, 100]]),
        (
            r#"width="40" height="20" viewBox="0 0 2 2" preserveAspectRatio="xMaxYMid""#,
            [[200, 100], [400, 100]],
        ),
        (r#"width="40" height="20" viewBox="0 0 2 2" preserveAspectRatio="none""#, [[0, 100], [400, 100]]),
        (
            r#"width="40" height="20" viewBox="0 0 2 2" preserveAspectRatio="xMidYMid slice""#,
            [[0, 100], [400, 100]],
        ),
        (r#"viewBox="-1 -1 4 4""#, [[250, 500], [750, 500]]),
    ] {
        assert_eq!(drawn(&format!(r#"<svg {inner}><path d="M0 1h2"/></svg>"#)), [want], "{inner}");
    }
    // A percentage is a share of the view box it stands in.
    let inner =
        r#"<svg width="50" height="50" viewBox="0 0 200 200"><line x1="50%" y1="0" x2="100%" y2="0"/></svg>"#;
    assert_eq!(drawn(inner), [[[250, 0], [500, 0]]]);
}

#[test]
fn what_is_not_shown_is_not_drawn() {
    let line = r#"<path d="M0 0h10"/>"#;
    for hidden in
        ["defs", "symbol", "clipPath", "mask", "marker", "pattern", "foreignObject", "metadata", "text"]
    {
        let got = svg(
            &format!("<svg viewBox='0 0 1 1'><{hidden}><g>{line}</g></{hidden}></svg>"),
            Fit::Inside,
            &plain(),
        );
        assert_eq!(got.expect(hidden).curves.len(), 0, "{hidden}");
    }
    for (body, shown) in [
        (r#"<g display="none"><path d="M0 0h1"/></g>"#, 0),
        (r#"<g style="fill:red; display : none"><path d="M0 0h1"/></g>"#, 0),
        (r#"<g visibility="hidden"><path d="M0 0h1"/><path style="visibility:visible" d="M0 0h1"/></g>"#, 1),
        (
            r#"<switch><path systemLanguage="de" d="M0 0h1"/><path requiredExtensions="http://x/" d="M0 0h2"/><g><path d="M0 0h3"/><path d="M0 0h4"/></g><path d="M0 0h5"/></switch>"#,
            2,
        ),
        (r#"<o:thing xmlns:o="http://other/"><path d="M0 0h1"/></o:thing>"#, 0),
        (r#"<a><path d="M0 0h1"/></a><unknown><path d="M0 0h1"/></unknown>"#, 2),
    ] {
        assert_eq!(drawn(body).len(), shown, "{body}");
    }
    let prefixed =
        r#"<s:svg xmlns:s="http://www.w3.org/2000/svg" viewBox="0 0 1 1"><s:path d="M0 0h1"/></s:svg>"#;
    assert_eq!(svg(prefixed, Fit::Inside, &plain()).expect("curves").curves.len(), 1);
}

#[test]
fn entities_of_the_file_itself_unfold() {
    let text = r#"<?xml version="1.0"?>
        <!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [
            <!ENTITY ns_svg "http://www.w3.org/2000/svg"> <!-- > ]> -->
            <!ENTITY line "M0 0h10">
            <!ENTITY secret SYSTEM "file:///etc/hostname">
        ]>
        <svg xmlns="&ns_svg;" viewBox="0 0 100 100"><path d="&line;"/><path id="&secret;" d="M0 0h20"/></svg>"#;
    let got = svg(text, Fit::Inside, &plain()).expect("curves");
    assert_eq!(corners(&got), [[[0, 0], [100, 0]], [[0, 0], [200, 0]]]);
    assert_eq!(got.warnings, ["1 undefined entity, left out: in `id=\"&secret;\"`"]);
    assert_eq!(got.curves.iter().nth(1).map(|c| c.name().to_owned()), Some(String::new()));
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

/// What styles hide is not drawn, whoever writes them: an attribute, a rule, or a rule that counts more.
#[test]
fn style_sheets_hide_lines() {
    let line = |style: &str, element: &str| format!("<style>{style}</style>{element}<path d='M0 0h10'/>");
    let path = r#"<path id="p" class="st0 a" d="M50 0V99"/>"#;
    for (style, shown) in [
        (".st0{display:none}", 0),
        ("/* x */ .b, .st0 { fill: url(a;b); DISPLAY : none }", 0),
        ("<![CDATA[#p{visibility:hidden}]]>", 0),
        ("path.a.st0{display:none}", 0),
        ("*.st0{display:none}", 0),
        (".st0{display:none} .st0{display:inline}", 1),
        (".st0{display:none !important} #p{display:inline}", 0),
        ("#p{display:inline} .st0{display:none}", 1),
        (".other{display:none} path.other{display:none}", 1),
        ("@font-face{font-family:'display'} .st1{fill:red}", 1),
        (".a.a{display:inline} .st0{display:none}", 1),
        // A string ends with its line, and a comment in one is none.
        (".b{font:'x}\n} .st0{display:none}", 0),
        (".b{font:'/*'} .st0{display:none}", 0),
    ] {
        assert_eq!(drawn(&line(style, path)).len(), 1 + shown, "{style}");
    }
    let own = r#"<path class="st0" style="display:inline" d="M50 0V99"/>"#;
    assert_eq!(drawn(&line(".st0{display:none}", own)).len(), 2, "its own style is nearer");
    assert_eq!(drawn(&line(".st0{display:none!important}", own)).len(), 1);
    let attribute = r#"<path class="st0" display="none" d="M50 0V99"/>"#;
    assert_eq!(drawn(&line(".st0{display:inline}", attribute)).len(), 2, "an attribute is furthest");
    // After the elements that it speaks of, for another medium, or in another language.
    assert_eq!(
        drawn(&format!("{path}<defs><style>.st0{{display:none}}</style></defs><path d='M0 0h1'/>")).len(),
        1
    );
    for held in ["media='print, screen'", "media='only screen'", "type='Text/CSS; charset=utf-8'", "type=''"]
    {
        assert_eq!(drawn(&format!("<style {held}>.st0{{display:none}}</style>{path}")).len(), 0, "{held}");
    }
    for other in ["media='print'", "media='print and (min-width:1px)'", "type='text/less'"] {
        assert_eq!(drawn(&format!("<style {other}>.st0{{display:none}}</style>{path}")).len(), 1, "{other}");
    }
}

/// One warning for all that is not read of styles, with the first place.
#[test]
fn styles_that_are_not_read_are_told_of() {
    let path = r#"<path h="1" d="M0 0h10"/>"#;
    for (body, warning) in [
        (
            "<style>g > path{display:none} a:hover{display:none}</style>",
            "2 styles that are not read, left out; the first: the rules of `g > path` in the style sheet",
        ),
        (
            "<style>@import 'a.css';</style>",
            "1 style that is not read, left out: `@import` in the style sheet",
        ),
        ("<style>@media print{path{display:none}}</style>", "`@media` in the style sheet"),
        ("<style>path{cx:5px}</style>", "`cx` of the style sheet"),
        ("<style>path{CX:5px}</style>", "`cx` of the style sheet"),
        ("<path style='rotate:20deg' h='1' d='M0 5h10'/>", "`rotate` in the style of path in line 1"),
        ("<path style='Translate:10px' h='1' d='M0 5h10'/>", "`translate` in the style of path in line 1"),
        ("<style>@MEDIA print{path{DISPLAY:none}}</style>", "`@MEDIA` in the style sheet"),
        ("<style>g{fill:red; path{display:none}}</style>", "a block inside of a block of the style sheet"),
        (
            "\n<style media='screen and (min-width:1px)'>path{display:none}</style>",
            "the style sheet in line 2, which is for some media alone",
        ),
        ("<?xml-stylesheet href='a.css'?>", "the style sheet of another file"),
    ] {
        let got = read(&format!("{body}{path}")).expect(body);
        assert!(got.warnings.len() == 1 && got.warnings[0].contains(warning), "{body}: {:?}", got.warnings);
    }
    let long = format!("<style>{} path{{display:none}}</style>{path}", " ".repeat(8 << 20));
    let got = read(&long).expect("curves");
    assert!(
        got.curves.len() == 1 && got.warnings[0].contains("more than 8388608 bytes"),
        "{:?}",
        got.warnings
    );
    // What says nothing of lines is nobody's business.
    let got =
        read(&format!("<style>g > path:hover{{fill:red}} @page{{margin:0}} g{{fill:red</style><style media='(width)'>g{{}}</style>{path}")).expect("curves");
    assert_eq!(got.warnings, [""; 0]);
}

/// A sheet that lacks an end costs itself alone, and is told of.
#[test]
fn every_style_sheet_is_read_by_itself() {
    for (first, hidden) in [
        ("path{display:none", 2),
        ("path{fill:red", 1),
        ("path{font:'x", 1),
        ("path{fill:red /* ", 1),
        ("@media print{", 1),
        ("path", 1),
    ] {
        let sheets = format!("\n<style>{first}</style><style>.b{{display:none}}</style>");
        let body = format!("{sheets}<path h='1' d='M0 0h1'/><path class='b' h='1' d='M0 0h1'/>");
        let got = read(&body).expect(first);
        assert_eq!(got.curves.len(), 2 - hidden, "{first}: {:?}", got.warnings);
        assert_eq!(got.warnings.len(), hidden - 1, "{first}: {:?}", got.warnings);
    }
    for (css, place) in [
        ("path{display:none", "`path` of the style sheet in line 2"),
        ("g{fill:red} path{fill:red; .b{display:none}", "`path` of the style sheet in line 2"),
        ("g{} /* path{display:none}", "a comment of the style sheet in line 2"),
        ("@font-face{src:x; g{display:none}", "`@font-face` of the style sheet in line 2"),
    ] {
        let got = read(&format!("\n<style>{css}</style><path h='1' d='M0 0h1'/>")).expect(css);
        let want = format!("1 part of a style sheet without an end, taken to end with the sheet: {place}");
        assert!(got.warnings.contains(&want), "{css}: {:?}", got.warnings);
    }
}

#[test]
fn styles_move_lines() {
    let turned = [[800, 200], [200, 200]];
    for (attributes, want) in [
        (r#"style="transform:translate(20px,20px)" d="M0 0H60""#, [[200, 200], [800, 200]]),
        (
            r#"style="transform:translate(20%,20%)" transform="scale(9)" d="M0 0H60""#,
            [[200, 200], [800, 200]],
        ),
        (r#"transform="rotate(90)" transform-origin="50 50" d="M20 20V80""#, turned),
        (r#"transform="rotate(90)" style="transform-origin:center" d="M20 20V80""#, turned),
        (r#"style="transform:rotate(90deg);transform-origin:50% 50px" d="M20 20V80""#, turned),
        (r#"transform-origin="50 50" d="M20 20H80""#, [[200, 200], [800, 200]]),
    ] {
        assert_eq!(drawn(&format!("<path {attributes}/>")), [want], "{attributes}");
    }
    for (attributes, message) in [
        ("style='transform:rotateX(9deg)'", "the style `transform` cannot be read: \"rotateX(9deg)\""),
        ("transform='scale(2)' transform-origin='here'", "`transform-origin` cannot be read: \"here\""),
        (
            "transform='scale(2)' style='transform-box:fill-box'",
            "`transform-box` must be view-box, got \"fill-box\"",
        ),
    ] {
        let got = read(&format!("<path {attributes} h='1' d='M0 0h10'/>")).expect(attributes);
        assert!(
            got.curves.is_empty() && got.warnings[0].contains(message),
            "{attributes}: {:?}",
            got.warnings
        );
    }
}

#[test]
fn an_entity_of_elements_is_no_undefined_one() {
    let text = r#"<!DOCTYPE svg [<!ENTITY p '<path d="M20,20 L80,20"/>'><!ENTITY t 'words'>]>
        <svg viewBox="0 0 100 100">&p;&t;<path d="M0 0h10"/></svg>"#;
    let got = svg(text, Fit::Inside, &plain()).expect("curves");
    assert!(got.warnings.len() == 1, "{:?}", got.warnings);
    assert!(
        got.warnings[0].starts_with("1 entity that stands for elements, left out: `&p;`"),
        "{:?}",
        got.warnings
    );
}

#[test]
fn a_picture_without_lines_is_told_of() {
    assert!(drawn("").is_empty());
    assert!(drawn(r#"<path display="none" d="M0 0h1"/>"#).is_empty());
}

#[test]
fn sizes_in_styles_and_foreign_elements_are_told_of() {
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
