//! Lines as a picture of paths.

use std::io::Write;

use serde_json::Value as Json;

use super::Lines;
use crate::files::codec::{FormatSpec, Writer};
use crate::files::error::WriteError;
use crate::value::Feature;

pub(in crate::files) static FORM: FormatSpec = FormatSpec {
    name: "svg",
    by_extension: false,
    levels: None,
    channels: &[],
    sidecar: false,
    flips: false,
    voids: false,
    write: Writer::Lines(write),
    nanoseconds: 100.0,
    holds: "lines as paths, large rivers wider than small ones, on a page of the terrain; properties as attributes `data-NAME`; no heights of \
            positions; one file a build, not one a tile",
    purpose: "drawing programs, and `import_curves`, which reads them back",
};

/// The longer side of the page, in user units: the picture as browsers and drawing programs first show it.
const PAGE: f64 = 1024.0;
/// The finest line is this share of the longer side wide.
const HAIRLINE: f64 = 5e-4;

/// The view box is the terrain, in metres, so that `import_curves` lays the page where it was.
fn write(lines: &Lines<'_>, out: &mut dyn Write) -> Result<(), WriteError> {
    let terrain = lines.terrain;
    let ([x, y], width, depth) = (terrain.origin, terrain.width, terrain.depth);
    let longer = width.max(depth);
    let page = [width, depth].map(|side| side / longer * PAGE);
    let [r, g, b] = lines.object.wire().color;
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" viewBox=\"{x} {y} {width} {depth}\">",
        page[0], page[1]
    )?;
    writeln!(
        out,
        "<g fill=\"none\" stroke=\"#{r:02x}{g:02x}{b:02x}\" stroke-linecap=\"round\" stroke-linejoin=\"round\">"
    )?;
    lines.each(|_, feature| {
        let stroke = longer * HAIRLINE * feature.weight;
        write!(out, "<path stroke-width=\"{stroke}\"")?;
        attributes(&feature, out)?;
        out.write_all(b" d=\"")?;
        for (i, ([x, y], _)) in feature.line.iter().enumerate() {
            let letter = if i == 0 { "M" } else { "L" };
            write!(out, "{letter}{x} {y}")?;
        }
        Ok(out.write_all(b"\"/>\n")?)
    })?;
    Ok(out.write_all(b"</g>\n</svg>\n")?)
}

/// The properties as attributes: lists as numbers with blanks between them.
fn attributes(feature: &Feature, out: &mut dyn Write) -> Result<(), WriteError> {
    for (name, value) in &feature.properties {
        let text = match value {
            Json::String(text) => text.clone(),
            Json::Array(list) => list.iter().map(Json::to_string).collect::<Vec<_>>().join(" "),
            other => other.to_string(),
        };
        write!(out, " data-{name}=\"{}\"", quick_xml::escape::escape(&*text))?;
    }
    Ok(())
}
