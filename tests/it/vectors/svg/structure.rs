//! Elements that contain or repeat others, hidden elements, and entities.

use orograph::files::vectors::svg::Fit;

use super::{drawn, read};
use crate::vectors::{corners, plain, svg};

#[test]
fn use_elements_draw_what_they_name() {
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
fn inner_svg_elements_have_units_of_their_own() {
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
fn hidden_elements_are_not_drawn() {
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
fn entities_of_the_file_are_expanded() {
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
fn entities_with_elements_are_not_reported_as_undefined() {
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
