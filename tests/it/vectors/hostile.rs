//! Files that were made to hang, to fill memory or to read others: every reader is quick, bounded and can be stopped.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use orograph::files::vectors::svg::Fit;
use orograph::files::vectors::{geojson, svg as pictures};
use orograph::value::curves::CurveError;

use super::{SQUARE, json, place, plain, svg};

fn picture(body: &str) -> String {
    format!("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 100 100\">{body}</svg>")
}

#[test]
fn uses_of_uses_end() {
    let mut bomb = String::from("<g id='u0'><path d='M0 0h1'/></g>");
    let mut empty = String::from("<g id='u0'/>");
    for k in 1..30 {
        let all = format!("<use href='#u{}'/>", k - 1).repeat(10);
        bomb += &format!("<g id='u{k}'>{all}</g>");
        empty += &format!("<defs><g id='u{k}'>{all}</g></defs>");
    }
    let error = svg(&picture(&bomb), Fit::Inside, &plain()).expect_err("a bomb").to_string();
    assert!(error.contains("positions in the file: at most"), "{error}");
    let error = svg(&picture(&(empty + "<use href='#u29'/>")), Fit::Inside, &plain()).expect_err("a bomb");
    assert!(error.to_string().contains("elements drawn, those of `use` counted"), "{error}");
    for (cycle, warning) in [
        ("<g id='a'><use href='#a'/></g>", "`#a` draws itself"),
        ("<use id='a' href='#a'/>", "`#a` draws itself"),
        ("<g id='a'><use href='#b'/></g><g id='b'><use href='#a'/></g>", "draws itself"),
        ("<symbol id='a'><use href='#a'/></symbol><use href='#a'/>", "`#a` draws itself"),
    ] {
        let got = svg(&picture(cycle), Fit::Inside, &plain()).expect(cycle);
        assert!(got.warnings.len() == 1 && got.warnings[0].contains(warning), "{cycle}: {:?}", got.warnings);
    }
    let chain: String = (0..100).map(|k| format!("<use id='u{k}' href='#u{}'/>", k + 1)).collect();
    let got =
        svg(&picture(&(chain + "<path id='u100' d='M0 0h1'/>")), Fit::Inside, &plain()).expect("curves");
    assert!(got.warnings.iter().any(|w| w.contains("stands 32 deep in others")), "{:?}", got.warnings);
}

#[test]
fn entities_are_no_way_out_of_the_file_and_no_bomb() {
    let with = |doctype: &str, body: &str| {
        let text = format!("<!DOCTYPE svg [{doctype}]><svg viewBox='0 0 100 100'>{body}</svg>");
        svg(&text, Fit::Inside, &plain())
    };
    let mut laughs = String::from("<!ENTITY a0 'M0 0h1'>");
    for k in 1..40 {
        laughs += &format!("<!ENTITY a{k} '{}'>", format!("&a{};", k - 1).repeat(10));
    }
    let error = with(&laughs, "<path d='&a39;'/>").expect_err("a bomb").to_string();
    assert!(error.contains("entities in its DOCTYPE that unfold to more than 4 MiB"), "{error}");
    let long = format!("<!ENTITY a '{}'>", "1 ".repeat(1 << 15));
    let error = with(&long, &format!("<path d='{}'/>", "&a;".repeat(1000))).expect_err("a bomb").to_string();
    assert!(error.contains("unfold to more than 4 MiB"), "{error}");
    // Without end, and of another file: both stand for nothing.
    for doctype in [
        "<!ENTITY a '&b;'><!ENTITY b '&a;'>",
        "<!ENTITY a SYSTEM 'file:///etc/passwd'>",
        "<!ENTITY % p SYSTEM 'http://127.0.0.1/x'> %p;",
    ] {
        let got = with(doctype, "<path d='M0 0h1' id='&a;'/>").expect(doctype);
        assert_eq!(got.curves.len(), 1, "{doctype}");
    }
}

/// Files of some 10 MB that would take a reader that is not linear for hours.
fn large() -> Vec<(&'static str, String)> {
    let n = 400_000;
    let features = |feature: &str, n: usize| {
        format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, vec![feature; n].join(","))
    };
    vec![
        ("paths on one line.svg", picture(&"<path d=\"M 0 0 L 1 1\"/>".repeat(n))),
        ("attributes of one element.svg", picture(&format!("<g {}/>", names(n, |k| format!("a{k}='' "))))),
        ("namespaces.svg", picture(&format!("<g {}/>", names(n, |k| format!("xmlns:a{k}='u' "))))),
        ("namespaces in all.svg", picture(&"<g xmlns='a' xmlns:b='c'>".repeat(n / 2))),
        (
            "entities.svg",
            format!(
                "<!DOCTYPE svg [{}]>{}",
                names(n / 2, |k| format!("<!ENTITY e{k} 'x'>")),
                picture(&"<g id='&e7;'/>".repeat(n / 2))
            ),
        ),
        ("ids and uses.svg", picture(&names(n / 4, |k| format!("<g id='a{k}'/><use href='#a{}'/>", n - k)))),
        ("deep.svg", picture(&"<g>".repeat(n))),
        ("classes.svg", picture(&format!("<style>{}</style>", ".a{} ".repeat(n)))),
        (
            "rules.svg",
            picture(&format!(
                "<style>{}</style>{}",
                names(n / 4, |k| format!(".a.b{k}{{display:none}} .c{k}{{display:none}}")),
                "<g class='a b1'/>".repeat(n / 4)
            )),
        ),
        ("classes of one.svg", picture(&format!("<g class='{}'/>", names(n, |k| format!("a{k} "))))),
        ("open blocks.svg", picture(&format!("<style>{}</style>", "a{".repeat(n)))),
        (
            "selectors and declarations.svg",
            picture(&format!("<style>{}{{{}}}</style>", "a,".repeat(n), "display:a;".repeat(n / 4))),
        ),
        (
            "parts of a selector.svg",
            picture(&format!("<style>{}{{display:a}}</style>{}", ".a".repeat(n), "<g class='a'/>".repeat(n))),
        ),
        (
            "moves of all.svg",
            picture(&format!(
                "<style>*{{transform:scale(1);transform-origin:1px;transform-box:a}}</style>{}",
                "<g/>".repeat(n)
            )),
        ),
        ("sheets.svg", picture(&"<style>a{display:a</style>".repeat(n))),
        ("comments.svg", picture(&format!("<style>{}</style>", "/* */ ".repeat(n)))),
        ("subpaths.svg", picture(&format!("<path d=\"{}\"/>", "m0 0h1".repeat(n)))),
        ("points.svg", picture(&format!("<polyline points=\"{}\"/>", "0 0 1 1 ".repeat(n)))),
        ("errors.svg", picture(&"<path d=\"M 0 0 L x\"/>\n".repeat(n))),
        (
            "lines.geojson",
            features(r#"{"geometry":{"type":"LineString","coordinates":[[0,0],[1,1]]}}"#, n / 4),
        ),
        (
            "systems.geojson",
            format!(
                r#"{{"type":"FeatureCollection","features":[{}null]}}"#,
                names(n / 4, |k| format!(r#"{{"crs":{{"properties":{{"name":"EPSG:{k}000"}}}}}},"#))
            ),
        ),
        (
            "properties.geojson",
            features(
                &format!(r#"{{"properties":{{{}"a":0}}}}"#, names(100, |k| format!("\"a{k}\":[1,2],"))),
                n / 100,
            ),
        ),
        ("nulls.geojson", features("null", n)),
        ("empty lists.geojson", features("[[],[]]", n)),
        ("line.geojson", format!(r#"{{"type":"LineString","coordinates":[{}[1,1]]}}"#, "[0,0],".repeat(n))),
        ("text.geojson", format!(r#"{{"type":"{}"}}"#, "\\u0041".repeat(n))),
    ]
}

fn names(n: usize, name: impl Fn(usize) -> String) -> String {
    (0..n).map(name).collect()
}

#[test]
fn no_file_of_ten_megabytes_takes_long_and_every_one_can_be_stopped() {
    for (name, text) in large() {
        let read = |go_on: &dyn Fn(f32) -> bool| {
            if name.ends_with("svg") {
                pictures::read(text.as_bytes(), SQUARE, Fit::Inside, &plain(), go_on)
            } else {
                geojson::read(text.as_bytes(), &place(), &plain(), go_on)
            }
        };
        let (start, asked) = (Instant::now(), AtomicU32::new(0));
        let result = read(&|share| {
            assert!((0.0..=1.0).contains(&share), "{name}: {share}");
            asked.fetch_add(1, Ordering::Relaxed);
            true
        });
        let took = start.elapsed().as_secs_f64();
        let said = match &result {
            Ok(got) => format!("{} curves, {:?}", got.curves.len(), got.warnings),
            Err(e) => e.to_string(),
        };
        println!("{name}, {} kB: {took:.2} s, {said}", text.len() / 1000);
        assert!(took < 20.0, "{name}: {took} s");
        let stopped = read(&|_| false);
        assert!(matches!(stopped, Err(CurveError::Cancelled)), "{name}: {stopped:?}");
    }
    assert!(json("null", &place(), &plain()).is_err());
}
