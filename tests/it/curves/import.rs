//! Curves from SVG and `GeoJSON`.

use orograph::kit::curves::import::{Imported, MAX_POSITIONS, Mapping, Source, geojson, svg};
use orograph::units::Number;
use orograph::value::Bounds;
use orograph::value::curves::CurveError;

use super::hypot;

fn property(name: &str) -> Source {
    Source::Property { name: name.into(), factor: Number(1.0) }
}

fn mapping() -> Mapping {
    Mapping {
        height: property("h"),
        left_extent: Source::Value { value: Number(50.0) },
        right_extent: Source::Value { value: Number(60.0) },
        left_angle: property("angle"),
        ..Mapping::default()
    }
}

fn read(body: &str) -> Result<Imported, CurveError> {
    let text = format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">{body}</svg>"#);
    let onto = Bounds { min: [0.0, 0.0], max: [1000.0, 1000.0] };
    svg::read(&text, onto, svg::Fit::Inside, &mapping())
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
fn svg_errors_name_the_element() {
    for (body, message) in [
        (r#"<path id="x" h="1" d="M 0 0 L oops"/>"#, "path `x` in line 1: `d` cannot be read"),
        (r#"<path h="high" d="M 0 0 L 1 1"/>"#, "property `h` must be numbers, got \"high\""),
        (r#"<path transform="spin(3)" h="1" d="M 0 0 L 1 1"/>"#, "`transform` cannot be read"),
        (r#"<path h="1" d="M 5 5 L 5 5"/>"#, "must be at least 0.001 m long"),
        (r#"<path h="1" d="M 0 0 L 1e300 1e300"/>"#, "must lie within"),
        ("<path", "is not XML"),
    ] {
        let error = read(body).expect_err(body).to_string();
        assert!(error.contains(message), "{body}: {error}");
    }
    let onto = Bounds { min: [0.0, 0.0], max: [10.0, 10.0] };
    let plain = |text: &str| svg::read(text, onto, svg::Fit::Stretch, &mapping());
    assert!(plain("<html/>").is_err_and(|e| e.to_string().contains("must be an `svg` element, got `html`")));
    assert!(plain("<svg/>").is_err_and(|e| e.to_string().contains("must have a viewBox")));
    assert!(plain(r#"<svg viewBox="0 0 0 1"/>"#).is_err());
    assert!(plain(r#"<svg width="20" height="10"/>"#).is_ok());
    // Entities that blow up are refused, deep nesting is walked.
    assert!(plain(r#"<!DOCTYPE svg [<!ENTITY a "aaaa">]><svg viewBox="0 0 1 1">&a;</svg>"#).is_err());
    let long =
        format!(r#"<svg viewBox="0 0 1 1"><path h="1" d="M0 0{}"/></svg>"#, " 1 1 0 0".repeat(MAX_POSITIONS));
    assert!(plain(&long).is_err_and(|e| e.to_string().contains("positions in the file: at most 1048576")));
    let nested = format!(r#"<svg viewBox="0 0 1 1">{}{}</svg>"#, "<g>".repeat(800), "</g>".repeat(800));
    assert!(plain(&nested).is_ok());
}

fn json(text: &str) -> Result<Imported, CurveError> {
    let place = geojson::Place { origin: [500_000.0, 4_000_000.0], ..geojson::Place::default() };
    geojson::read(text, &place, &mapping())
}

#[test]
fn geojson_lines_lie_on_the_terrain() {
    let text = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{"h":[10,40,20],"angle":"-25","name":"brook"},"geometry":{"type":"LineString","coordinates":[[500100,3999900],[500200,3999900],[500200,3999900],[500300,3999800]]}},
        {"type":"Feature","properties":{"h":7},"geometry":{"type":"MultiLineString","coordinates":[[[500000,4000000],[500010,3999990]],[[500020,4000000],[500030,3999990]]]}},
        {"type":"Feature","properties":null,"geometry":{"type":"Point","coordinates":[1,2]}}]}"#;
    let got = json(text).expect("curves");
    assert_eq!(got.curves.len(), 3);
    assert_eq!(got.warnings, ["1 geometries that are no lines were left out"]);
    let brook = got.curves.iter().next().expect("a curve");
    // North is up in the file and −y here.
    assert_eq!((brook.name(), brook.point(0.0), brook.point(1.0)), ("brook", [100.0, 100.0], [300.0, 200.0]));
    assert_eq!([0.0, 0.5, 1.0].map(|u| brook.height(u)), [Some(10.0), Some(40.0), Some(20.0)]);
    let slope = brook.attributes(0.5).slope.expect("slopes");
    assert_eq!((slope.left_angle, slope.left_extent, slope.right_extent), (-25.0, 50.0, 60.0));
}

#[test]
fn third_coordinates_are_heights_where_the_positions_are() {
    let text = r#"{"type":"LineString","coordinates":[[0,0,5],[100,0,25],[400,0,10]]}"#;
    let mapping = Mapping { height: Source::Z { factor: Number(2.0) }, ..Mapping::default() };
    let place = geojson::Place { smooth: false, ..geojson::Place::default() };
    let got = geojson::read(text, &place, &mapping).expect("curves");
    let c = got.curves.iter().next().expect("a curve");
    assert_eq!([0.0, 0.25, 1.0].map(|u| c.height(u)), [Some(10.0), Some(50.0), Some(20.0)]);
    let thin = geojson::Place { smooth: false, spacing: 150.0, ..geojson::Place::default() };
    assert_eq!(
        geojson::read(text, &thin, &mapping).expect("curves").curves.iter().next().map(|c| c.pieces()),
        Some(1)
    );
    let near = r#"{"type":"LineString","coordinates":[[7,45,5],[7.5,45.2,25]]}"#;
    let got = geojson::read(near, &place, &mapping).expect("curves");
    assert!(got.warnings.iter().any(|w| w.contains("longitudes")), "{:?}", got.warnings);
}

#[test]
fn geojson_errors_name_the_place() {
    let feature = |coordinates: &str| {
        format!(
            r#"{{"type":"Feature","properties":{{"h":1}},"geometry":{{"type":"LineString","coordinates":{coordinates}}}}}"#
        )
    };
    for (text, message) in [
        ("{".to_owned(), "GeoJSON: is not JSON"),
        ("[]".to_owned(), "must be an object with a text `type`"),
        (feature("[[1,2],[3]]"), "feature 0: position 1 must be a list [east, north] of numbers, got [3]"),
        (feature("[[1,2],[1,2]]"), "feature 0: needs at least two different points, got 1"),
        (feature("[]"), "feature 0: needs at least two different points, got 0"),
        (feature("7"), "feature 0: must have a list `coordinates`"),
        (feature("[[0,0],[1e300,0]]"), "feature 0: point 1 must lie within"),
        (r#"{"type":"Feature","properties":{"h":true},"geometry":{"type":"LineString","coordinates":[[0,0],[9,9]]}}"#.to_owned(), "property `h` must be a number or a list of numbers, got true"),
        (r#"{"type":"Feature","properties":{"h":1e9},"geometry":{"type":"LineString","coordinates":[[0,0],[9,9]]}}"#.to_owned(), "h must be a number from -100000 to 100000, got 1000000000"),
    ] {
        let error = json(&text).expect_err(&text).to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    let many = vec!["[0,0],[1,1]"; MAX_POSITIONS / 2 + 1].join(",");
    let error = json(&feature(&format!("[{many}]"))).expect_err("too many").to_string();
    assert!(error.contains("positions in the file: at most 1048576"), "{error}");
    let deep =
        format!("{}{}", r#"{"type":"GeometryCollection","geometries":["#.repeat(3000), "]}".repeat(3000));
    assert!(json(&deep).is_err());
}
