//! SVG pictures: which lines become curves, and where they lie.

mod faults;
mod paths;
mod structure;
mod styles;

use orograph::files::vectors::Imported;
use orograph::files::vectors::svg::Fit;
use orograph::value::curves::CurveError;

use super::{corners, mapping, plain, svg};

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
