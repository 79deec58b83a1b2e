//! Style sheets and style attributes.

use super::{drawn, read};

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
fn styles_that_are_not_read_are_warned_of() {
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
fn style_sheets_are_read_one_by_one() {
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
