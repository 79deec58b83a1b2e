//! `GeoJSON` files: what is read of them and where it comes to lie.

use orograph::files::vectors::geojson::Place;
use orograph::files::vectors::{Imported, MAX_POSITIONS, Mapping, Source};
use orograph::units::Number;
use orograph::value::curves::CurveError;

use super::{corners, json, mapping, place, plain};

fn read(text: &str) -> Result<Imported, CurveError> {
    json(text, &Place { origin: [500_000.0, 4_000_000.0], smooth: true, ..place() }, &mapping())
}

/// A collection of features, each a line with `h` 1 and these coordinates, and one good line.
fn features(coordinates: &[&str]) -> String {
    let feature = |line: &str| {
        format!(
            r#"{{"type":"Feature","properties":{{"h":1}},"geometry":{{"type":"LineString","coordinates":{line}}}}}"#
        )
    };
    let all = coordinates.iter().chain(&["[[500000,4000000],[500100,3999900]]"]);
    collection(&all.map(|line| feature(line)).collect::<Vec<_>>().join(","))
}

fn collection(features: &str) -> String {
    format!(r#"{{"type":"FeatureCollection","features":[{features}]}}"#)
}

#[test]
fn geojson_lines_lie_on_the_terrain() {
    let text = r#"{"type":"FeatureCollection","features":[
        {"type":"Feature","properties":{"h":[10,40,20],"angle":"-25","name":"brook"},"geometry":{"type":"LineString","coordinates":[[500100,3999900],[500200,3999900],[500200,3999900],[500300,3999800]]}},
        {"type":"Feature","properties":{"h":7},"geometry":{"type":"MultiLineString","coordinates":[[[500000,4000000],[500010,3999990]],[[500020,4000000],[500030,3999990]]]}},
        {"type":"Feature","properties":null,"geometry":{"type":"Point","coordinates":[1,2]}}]}"#;
    let got = read(text).expect("curves");
    assert_eq!(got.curves.len(), 3);
    assert_eq!(got.warnings, ["1 geometry that is no line, left out: feature 2, a Point"]);
    let brook = got.curves.iter().next().expect("a curve");
    // North is up in the file and −y here.
    assert_eq!((brook.name(), brook.point(0.0), brook.point(1.0)), ("brook", [100.0, 100.0], [300.0, 200.0]));
    assert_eq!([0.0, 0.5, 1.0].map(|u| brook.height(u)), [Some(10.0), Some(40.0), Some(20.0)]);
    let slope = brook.attributes(0.5).slope.expect("slopes");
    assert_eq!((slope.left_angle, slope.left_extent, slope.right_extent), (-25.0, 50.0, 60.0));
}

#[test]
fn members_may_stand_in_any_order() {
    let text = r#"{"features":[{"geometry":{"coordinates":[[200,-200],[800,-200]],"type":"LineString"},"properties":{"name":"a"},"type":"Feature"}],"crs":null,"type":"FeatureCollection"}"#;
    let got = json(text, &place(), &plain()).expect("curves");
    assert_eq!(corners(&got), [[[200, 200], [800, 200]]]);
    assert_eq!(got.curves.iter().next().map(|c| c.name().to_owned()), Some("a".into()));
    assert_eq!(got.warnings, [""; 0]);
}

#[test]
fn every_geometry_with_lines_gives_them() {
    let geometry = |text: &str| json(text, &place(), &plain()).expect(text);
    let ring = [[0, 0], [200, 0], [200, 300], [0, 0]];
    let hole = [[50, 10], [60, 10], [60, 20], [50, 10]];
    // The second ring is not closed in the file.
    let rings = "[[[0,0],[200,0],[200,-300],[0,0]],[[50,-10],[60,-10],[60,-20]]]";
    let line = "[[200,-200],[800,-200]]";
    let level = [[200, 200], [800, 200]];
    let nested = |n: usize, inner: &str| {
        let open = r#"{"type":"GeometryCollection","geometries":["#.repeat(n);
        format!("{open}{inner}{}", "]}".repeat(n))
    };
    let line_string = format!(r#"{{"type":"LineString","coordinates":{line}}}"#);
    for (text, want) in [
        (line_string.clone(), vec![level.to_vec()]),
        (format!(r#"{{"type":"MultiLineString","coordinates":[{line},{line}]}}"#), vec![level.to_vec(); 2]),
        (format!(r#"{{"type":"Polygon","coordinates":{rings}}}"#), vec![ring.to_vec(), hole.to_vec()]),
        (
            format!(r#"{{"type":"MultiPolygon","coordinates":[{rings},{rings}]}}"#),
            [vec![ring.to_vec(), hole.to_vec()], vec![ring.to_vec(), hole.to_vec()]].concat(),
        ),
        (nested(1, &format!("{line_string},{line_string}")), vec![level.to_vec(); 2]),
        (nested(50, &line_string), vec![level.to_vec()]),
        (
            format!(r#"{{"type":"Feature","properties":null,"geometry":{}}}"#, nested(3, &line_string)),
            vec![level.to_vec()],
        ),
    ] {
        let got = geometry(&text);
        assert_eq!(corners(&got), want, "{text}");
        assert_eq!(got.warnings, [""; 0], "{text}");
    }
}

#[test]
fn third_coordinates_are_heights_where_the_positions_are() {
    let text = r#"{"type":"LineString","coordinates":[[0,0,5],[100,0,25],[400,0,10]]}"#;
    let mapping = Mapping { height: Source::Z { factor: Number(2.0) }, ..Mapping::default() };
    let got = json(text, &place(), &mapping).expect("curves");
    let c = got.curves.iter().next().expect("a curve");
    assert_eq!([0.0, 0.25, 1.0].map(|u| c.height(u)), [Some(10.0), Some(50.0), Some(20.0)]);
    let thin = Place { spacing: 150.0, ..place() };
    let thinned = json(text, &thin, &mapping).expect("curves");
    assert_eq!(thinned.curves.iter().next().map(|c| c.pieces()), Some(1));
    // A fourth number is nobody's.
    let more = r#"{"type":"LineString","coordinates":[[0,0,5,1],[100,0,25,2],[400,0,10,3]]}"#;
    assert_eq!(json(more, &place(), &mapping).expect("curves").curves, got.curves);
}

#[test]
fn a_feature_that_is_wrong_costs_itself_alone_and_a_warning_names_it() {
    for (line, warning) in [
        (
            "[[1,2],[3]]",
            "1 malformed feature, left out: feature 0: position 1 must be a list [east, north] of numbers, got [3.0]",
        ),
        ("[[1,2],[3,\"x\"]]", "position 1 must be a list [east, north] of numbers, got a list of 2"),
        ("[[1,2],[1,2]]", "1 line without length, left out: feature 0"),
        ("[]", "1 line without length, left out: feature 0"),
        ("[[1,2]]", "1 line without length, left out: feature 0"),
        ("7", "1 malformed feature, left out: feature 0: must have a list of positions, got 7"),
        ("null", "must have a list of positions, got null"),
        (
            "[[0,0],[1e300,0]]",
            "1 line that no curve can follow, left out: feature 0: point 1 must lie within",
        ),
        ("[[0,0],[1,1]]", "1 line wholly off the terrain, taken all the same: feature 0"),
    ] {
        let got = read(&features(&[line])).expect(line);
        assert_eq!(got.curves.len(), 1 + usize::from(warning.contains("wholly")), "{line}");
        assert!(got.warnings.len() == 1 && got.warnings[0].contains(warning), "{line}: {:?}", got.warnings);
    }
    let line = r#""geometry":{"type":"LineString","coordinates":[[500000,4000000],[500009,3999991]]}"#;
    for (feature, warning) in [
        (
            format!(r#"{{"type":"Feature","properties":{{"h":true}},{line}}}"#),
            "1 line with an unusable property, left out: feature 0: property `h` must be a number or a list of numbers, got true",
        ),
        (format!(r#"{{"properties":{{"h":{{"a":1}}}},{line}}}"#), "got an object"),
        (
            format!(r#"{{"properties":{{"h":1e9}},{line}}}"#),
            "h must be a number from -100000 to 100000, got 1000000000",
        ),
        (
            format!(r#"{{"properties":{{}},{line}}}"#).replace("{}", r#"{"other":[1,[2]]}"#),
            "1 line with an unusable property",
        ),
        (r#"{"properties":{},"geometry":null}"#.into(), "1 feature without geometry, left out: feature 0"),
        (r#"{"properties":{}}"#.into(), "1 feature without geometry, left out: feature 0"),
        ("null".into(), "1 malformed feature, left out: feature 0: must be an object, got null"),
        ("[1,2]".into(), "must be an object, got [1.0, 2.0]"),
        (r#"{"geometry":{"coordinates":[]}}"#.into(), "must have a geometry with a text `type`"),
        (r#"{"geometry":{"type":"LineString"}}"#.into(), "must have a list `coordinates`"),
        (r#"{"geometry":{"type":"GeometryCollection"}}"#.into(), "must have a list `geometries`"),
        (
            r#"{"geometry":{"type":"GeometryCollection","geometries":[7]}}"#.into(),
            "feature 0, geometry 0: must be an object, got 7",
        ),
        (
            r#"{"geometry":{"type":"MultiPoint","coordinates":[[1,2]]}}"#.into(),
            "1 geometry that is no line, left out: feature 0, a MultiPoint",
        ),
    ] {
        if warning == "1 line with an unusable property" {
            continue;
        }
        let good = features(&[]);
        let text = good.replacen('[', &format!("[{feature},"), 1);
        let got = read(&text).expect(&feature);
        assert_eq!(got.curves.len(), 1, "{feature}");
        assert!(
            got.warnings.len() == 1 && got.warnings[0].contains(warning),
            "{feature}: {:?}",
            got.warnings
        );
    }
    let got = read(&features(&["[]", "[[1,2],[1,2]]", "[[5,5]]"])).expect("curves");
    assert_eq!(got.warnings, ["3 lines without length, left out; the first: feature 0"]);
}

#[test]
fn what_is_no_geojson_is_refused() {
    for (text, message) in [
        ("{", "GeoJSON: is not JSON"),
        ("", "GeoJSON: is not JSON"),
        ("[]", "must be an object with a text `type`"),
        ("7", "must be an object with a text `type`"),
        (r#"{"type":7}"#, "must be an object with a text `type`"),
        (r#"{"type":"FeatureCollection"}"#, "a FeatureCollection must have a list `features`"),
        (r#"{"type":"FeatureCollection","features":{}}"#, "a FeatureCollection must have a list `features`"),
        (r#"{"type":"FeatureCollection","features":[]} x"#, "is not JSON: trailing characters"),
        (
            "{\"type\":\"Feature\"}\n{\"type\":\"Feature\"}\n",
            "is a sequence of JSON texts (RFC 8142, or one a line)",
        ),
        ("\u{1e}{\"type\":\"Feature\"}\n", "is a sequence of JSON texts (RFC 8142, or one a line)"),
        (r#"{"type":"Topology","objects":{}}"#, "is TopoJSON, which is another format"),
        (
            r#"{"geometryType":"esriGeometryPolyline","features":[]}"#,
            "is JSON of Esri, which is another format",
        ),
        (r#"{"type":"Line"}"#, "must be FeatureCollection, Feature or a geometry, got \"Line\""),
    ] {
        let error = read(text).expect_err(text).to_string();
        assert!(error.contains(message), "{text}: {error}");
    }
    let many = vec!["[0,0],[1,1]"; MAX_POSITIONS / 2 + 1].join(",");
    let error = read(&features(&[&format!("[{many}]")])).expect_err("too many").to_string();
    assert!(error.contains("positions in the file: at most 1048576"), "{error}");
    let deep =
        format!("{}{}", r#"{"type":"GeometryCollection","geometries":["#.repeat(3000), "]}".repeat(3000));
    assert!(read(&deep).is_err_and(|e| e.to_string().contains("recursion limit")));
}

#[test]
fn a_file_says_where_it_lies() {
    let text = |crs: &str, [east, north]: [f64; 2]| {
        format!(
            r#"{{"type":"FeatureCollection",{crs}"features":[{{"type":"Feature","properties":{{}},"geometry":
            {{"type":"LineString","coordinates":[[{east},{north}],[{},{north}]]}}}}]}}"#,
            east + 60.0
        )
    };
    let named = |name: &str| format!(r#""crs":{{"type":"name","properties":{{"name":"{name}"}}}},"#);
    let on_earth = Place { origin: [380_000.0, 3_800_000.0], epsg: Some(32611), ..place() };
    let metres = [380_200.0, 3_799_800.0];
    let of = |crs: &str, at: [f64; 2], place: &Place| json(&text(crs, at), place, &plain());
    for (name, message) in [
        ("urn:ogc:def:crs:EPSG::25832", "the file is in EPSG:25832, the terrain in EPSG:32611; reproject it"),
        ("EPSG:3857", "the file is in EPSG:3857, the terrain in EPSG:32611"),
        ("urn:ogc:def:crs:OGC:1.3:CRS84", "the coordinates of the file are degrees"),
        ("EPSG:4326", "the coordinates of the file are degrees"),
    ] {
        let error = of(&named(name), metres, &on_earth).expect_err(name).to_string();
        assert!(error.contains(message), "{name}: {error}");
    }
    for crs in
        [named("urn:ogc:def:crs:EPSG::32611"), named("EPSG:32611"), String::new(), r#""crs":null,"#.into()]
    {
        let got = of(&crs, metres, &on_earth).expect(&crs);
        assert_eq!((corners(&got), got.warnings.len()), (vec![vec![[200, 200], [260, 200]]], 0), "{crs}");
    }
    for (crs, at, place, warning) in [
        (
            named("EPSG:32611"),
            [200.0, -200.0],
            place(),
            "the file is in EPSG:32611, and the terrain has no `geo`",
        ),
        (named("mine"), metres, on_earth, "the coordinate system of the file, `mine`, is not known"),
        (r#""crs":7,"#.into(), metres, on_earth, "the coordinate system of the file, 7, is not known"),
        (r#""crs":{"type":"link"},"#.into(), metres, on_earth, "one without a name, is not known"),
        (String::new(), [7.0, -45.0], place(), "all positions could be longitudes and latitudes"),
    ] {
        let got = of(&crs, at, &place).expect(&crs);
        assert!(got.warnings[0].contains(warning), "{crs}: {:?}", got.warnings);
    }
    // In degrees on Earth: warned of twice, as such and since it lies off the terrain.
    let got = of("", [-117.0, 34.0], &on_earth).expect("curves");
    assert_eq!(got.warnings.len(), 2, "{:?}", got.warnings);
    assert!(got.warnings[1].contains("1 line wholly off the terrain"), "{:?}", got.warnings);
}

/// `crs` may stand on every object, and the `coordRefSys` of JSON-FG says the same.
#[test]
fn every_object_says_where_it_lies() {
    let on_earth = Place { origin: [380_000.0, 3_800_000.0], epsg: Some(32611), ..place() };
    let line = r#""type":"LineString","coordinates":[[380200,3799800],[380260,3799800]]"#;
    let crs = |epsg: u32| format!(r#""crs":{{"type":"name","properties":{{"name":"EPSG:{epsg}"}}}}"#);
    let url = |epsg: u32| format!(r#""coordRefSys":"http://www.opengis.net/def/crs/EPSG/0/{epsg}""#);
    let href = |epsg: u32| format!(r#""coordRefSys":{{"type":"Reference","href":"[EPSG:{epsg}]"}}"#);
    let list = |epsg: u32| format!(r#""coordRefSys":["[EPSG:{epsg}]","[EPSG:5773]"]"#);
    let forms: [&dyn Fn(u32) -> String; 4] = [&crs, &url, &href, &list];
    let on_feature = |said: &str| {
        collection(&format!(r#"{{"type":"Feature",{said},"properties":{{}},"geometry":{{{line}}}}}"#))
    };
    let on_geometry =
        |said: &str| format!(r#"{{"type":"Feature","properties":{{}},"geometry":{{{line},{said}}}}}"#);
    let on_part = |said: &str| format!(r#"{{"type":"GeometryCollection","geometries":[{{{said},{line}}}]}}"#);
    for form in forms {
        for (what, text) in [
            ("feature 0", &on_feature as &dyn Fn(&str) -> String),
            ("the feature", &on_geometry),
            ("the geometry, geometry 0", &on_part),
        ] {
            let got = json(&text(&form(32611)), &on_earth, &plain()).expect(what);
            assert_eq!(
                (corners(&got), got.warnings.len()),
                (vec![vec![[200, 200], [260, 200]]], 0),
                "{what}"
            );
            for (epsg, message) in [
                (25832, format!("{what} is in EPSG:25832, the terrain in EPSG:32611; reproject it")),
                (4326, format!("the coordinates of {what} are degrees")),
            ] {
                let error = json(&text(&form(epsg)), &on_earth, &plain()).expect_err(what).to_string();
                assert!(error.contains(&message), "{what}: {error}");
            }
            let mine = form(7).replace("EPSG", "MINE");
            let got = json(&text(&mine), &on_earth, &plain()).expect(what);
            assert!(
                got.warnings.len() == 1 && got.warnings[0].contains("is not known"),
                "{:?}",
                got.warnings
            );
        }
    }
}

#[test]
fn coordinates_in_feet_become_metres() {
    let line = r#"{"type":"LineString","coordinates":[[1000,-1000],[2000,-1000]]}"#;
    let feature = format!(r#"{{"type":"Feature","properties":{{}},"geometry":{line}}}"#);
    let crs = r#""crs":{"type":"name","properties":{"name":"EPSG:2263"}}"#;
    // Wherever the member stands.
    for text in [
        format!(r#"{{"type":"FeatureCollection",{crs},"features":[{feature}]}}"#),
        format!(r#"{{"type":"FeatureCollection","features":[{feature}],{crs}}}"#),
        feature.replacen("\"Feature\",", &format!("\"Feature\",{crs},"), 1),
    ] {
        let got = json(&text, &place(), &plain()).expect(&text);
        assert_eq!(corners(&got), [[[305, 305], [610, 305]]], "{text}");
        assert!(
            got.warnings.len() == 1 && got.warnings[0].contains("a unit being 0.3048"),
            "{:?}",
            got.warnings
        );
    }
}

/// JSON-FG keeps the geometry in degrees for others, and its own in `place`.
#[test]
fn the_place_of_json_fg_counts_before_the_geometry() {
    let text = r#"{"type":"Feature","coordRefSys":"[EPSG:32611]","properties":{},
        "geometry":{"type":"LineString","coordinates":[[-117,34],[-116,34]]},
        "place":{"type":"LineString","coordinates":[[380200,3799800],[380260,3799800]]}}"#;
    let on_earth = Place { origin: [380_000.0, 3_800_000.0], epsg: Some(32611), ..place() };
    let got = json(text, &on_earth, &plain()).expect("curves");
    assert_eq!((corners(&got), got.warnings.len()), (vec![vec![[200, 200], [260, 200]]], 0));
    // Where there is no place, the geometry in degrees is not taken for metres, whatever else the file has.
    let line =
        |at: [f64; 2]| format!(r#"{{"type":"LineString","coordinates":[{at:?},[{},0]]}}"#, at[0] + 60.0);
    let there = format!(r#"{{"geometry":null,"place":{}}}"#, line([380_200.0, 3_799_800.0]));
    let beside = |feature: String| {
        collection(&format!("{there},{feature}")).replacen('{', r#"{"coordRefSys":"[EPSG:32611]","#, 1)
    };
    for geometry in [
        line([-117.0, 34.0]),
        format!(r#"{{"type":"GeometryCollection","geometries":[{}]}}"#, line([-117.0, 34.0])),
    ] {
        let text = beside(format!(r#"{{"place":null,"geometry":{geometry}}}"#));
        let error = json(&text, &on_earth, &plain()).expect_err(&text).to_string();
        assert!(error.contains("the coordinates of feature 1"), "{error}");
        assert!(error.contains("are degrees, since `coordRefSys` speaks of `place` alone"), "{error}");
    }
    // One that cannot be in degrees is taken as the file says, and `crs` speaks of it.
    let crs = r#""crs":{"properties":{"name":"EPSG:32611"}}"#;
    for feature in [
        format!(r#"{{"place":null,"geometry":{}}}"#, line([380_200.0, 3_799_800.0])),
        format!(r#"{{"place":null,{crs},"geometry":{}}}"#, line([17.0, 34.0])),
    ] {
        let got = json(&beside(feature.clone()), &on_earth, &plain()).expect(&feature);
        assert_eq!(got.curves.len(), 2, "{feature}");
    }
    // A `place` of somebody else's is none.
    let text = r#"{"type":"Feature","properties":{},"place":{"name":"here"},
        "geometry":{"type":"LineString","coordinates":[[200,-200],[800,-200]]}}"#;
    assert_eq!(corners(&json(text, &place(), &plain()).expect("curves")), [[[200, 200], [800, 200]]]);
}

#[test]
fn a_file_without_lines_is_told_of() {
    for text in [
        collection(""),
        collection(r#"{"type":"Feature","geometry":{"type":"GeometryCollection","geometries":[]}}"#),
    ] {
        let got = json(&text, &place(), &plain()).expect("no fault");
        assert_eq!(got.warnings, ["the file has no line that becomes a curve"], "{text}");
    }
}

/// Features in several systems are told of, a system each.
#[test]
fn every_system_of_a_file_is_told_of() {
    let feature = |epsg: u32| {
        format!(
            r#"{{"type":"Feature","crs":{{"type":"name","properties":{{"name":"EPSG:{epsg}"}}}},"geometry":
            {{"type":"LineString","coordinates":[[200,-200],[800,-200]]}}}}"#
        )
    };
    let all = [32611, 25832, 32611].map(feature).join(",");
    let got = json(&collection(&all), &place(), &plain()).expect("curves");
    let told = ["feature 0 is in EPSG:32611", "feature 1 is in EPSG:25832"];
    assert_eq!(got.warnings.len(), 2, "{:?}", got.warnings);
    assert!(got.warnings.iter().zip(told).all(|(w, told)| w.starts_with(told)), "{:?}", got.warnings);
}

#[test]
fn positions_that_are_not_read_are_no_degrees() {
    let text = collection(
        r#"{"type":"Feature","geometry":{"type":"LineString","coordinates":[[20000,"x"],[80000,-20000]]}}"#,
    );
    let got = json(&text, &place(), &plain()).expect("no fault");
    assert!(got.warnings.len() == 1 && got.warnings[0].contains("malformed"), "{:?}", got.warnings);
}

#[test]
fn a_geometry_in_metres_beside_a_place_is_told_of() {
    let text = r#"{"type":"FeatureCollection","coordRefSys":"[EPSG:32611]","features":[{"type":"Feature",
        "place":null,"geometry":{"type":"LineString","coordinates":[[380200,3799800],[380800,3799800]]}}]}"#;
    let on_earth = Place { origin: [380_000.0, 3_800_000.0], epsg: Some(32611), ..place() };
    let got = json(text, &on_earth, &plain()).expect("curves");
    let want = "the `geometry` of feature 0 should be in degrees";
    assert!(got.warnings.len() == 1 && got.warnings[0].starts_with(want), "{:?}", got.warnings);
}
