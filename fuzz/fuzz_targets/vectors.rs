//! Any bytes as any file of lines: an error, or sound curves within the limits. `cargo +nightly fuzz run vectors`.
//!
//! The first byte chooses the reader and how it reads.
#![no_main]

use libfuzzer_sys::fuzz_target;
use orograph::files::vectors::geojson::{self, Place};
use orograph::files::vectors::svg::{self, Fit};
use orograph::files::vectors::{Imported, Mapping};
use orograph::value::Terrain;
use orograph::value::curves::CurveSpec;

fuzz_target!(|bytes: &[u8]| {
    let [choice, bytes @ ..] = bytes else { return };
    let terrain = Terrain { width: 1000.0, depth: 700.0, ..Terrain::default() };
    let mapping: Mapping = serde_json::from_str(
        r#"{ "height": { "property": { "name": "h", "factor": -2 } }, "amplitude": { "z": { "factor": 0.5 } },
             "left_extent": { "property": { "name": "w" } }, "left_angle": { "value": { "value": 30 } } }"#,
    )
    .expect("a mapping");
    let mapping = if choice & 1 == 0 { mapping } else { Mapping::default() };
    let read = |go_on: &dyn Fn(f32) -> bool| -> Result<Imported, String> {
        if choice & 2 == 0 {
            let fit = if choice & 4 == 0 { Fit::default() } else { Fit::Stretch };
            svg::read(bytes, terrain.bounds(), fit, &mapping, go_on).map_err(|e| e.to_string())
        } else {
            let spacing = if choice & 4 == 0 { 0.0 } else { 25.0 };
            let place = Place { smooth: choice & 8 == 0, spacing, ..Place::on(&terrain) };
            geojson::read(bytes, &place, &mapping, go_on).map_err(|e| e.to_string())
        }
    };
    let first = read(&|share| {
        assert!((0.0..=1.0).contains(&share));
        true
    });
    if let Ok(imported) = &first {
        for curve in imported.curves.iter() {
            let again = CurveSpec::of(curve).build().expect("what was read can be drawn again");
            assert!(again.length().is_finite() && curve.length() > 0.0);
        }
        assert!(imported.warnings.iter().all(|w| !w.is_empty() && !w.ends_with('.') && w.len() < 1000));
    }
    assert_eq!(first, read(&|_| true));
    // Who is asked at once whether to go on and says no gets no curves.
    assert!(bytes.is_empty() || read(&|_| false).is_err());
});
