//! Lines as a `FeatureCollection` of `GeoJSON`.

use std::io::Write;

use serde_json::json;

use super::Lines;
use crate::files::codec::{FormatSpec, Writer};
use crate::files::error::WriteError;
use crate::value::{Feature, Terrain};

pub(in crate::files) static FORM: FormatSpec = FormatSpec {
    name: "geojson",
    by_extension: false,
    levels: None,
    channels: &[],
    sidecar: false,
    flips: false,
    voids: false,
    write: Writer::Lines(write),
    nanoseconds: 150.0,
    holds: "lines with heights and properties, in metres to the east and north, on Earth or from the north-west corner of \
            the terrain; one file a build, not one a tile",
    purpose: "GIS, scripts, and `import_curves`, which reads them back",
};

/// One feature a line of text, so that a file of millions is read and compared line by line.
fn write(lines: &Lines<'_>, out: &mut dyn Write) -> Result<(), WriteError> {
    let terrain = lines.terrain;
    out.write_all(b"{\"type\":\"FeatureCollection\"")?;
    if let Some(geo) = terrain.geo {
        let name = format!("urn:ogc:def:crs:EPSG::{}", geo.epsg);
        write!(out, ",\"crs\":{}", json!({ "type": "name", "properties": { "name": name } }))?;
    }
    out.write_all(b",\"features\":[")?;
    lines.each(|i, feature| {
        out.write_all(if i == 0 { b"\n" } else { b",\n" })?;
        let properties = serde_json::to_string(&feature.properties).unwrap_or_default();
        write!(out, "{{\"type\":\"Feature\",\"properties\":{properties},\"geometry\":")?;
        out.write_all(b"{\"type\":\"LineString\",\"coordinates\":[")?;
        positions(&feature, terrain, out)?;
        Ok(out.write_all(b"]}}")?)
    })?;
    Ok(out.write_all(b"\n]}\n")?)
}

/// The positions of a line, each with a height where all have one: a file of other dimensions in one line is none that
/// readers agree on.
fn positions(feature: &Feature, terrain: &Terrain, out: &mut dyn Write) -> Result<(), WriteError> {
    let [east, north] = terrain.geo.map_or([0.0; 2], |g| [g.east, g.north]);
    let [x0, y0] = terrain.origin;
    let solid = feature.line.iter().all(|(_, z)| z.is_some());
    for (i, &([x, y], z)) in feature.line.iter().enumerate() {
        let comma = if i == 0 { "" } else { "," };
        // Zero minus, not a minus sign: a negative zero would be written as such.
        let (x, y) = (east + (x - x0), north + (0.0 - (y - y0)));
        match z.filter(|_| solid) {
            Some(z) => write!(out, "{comma}[{x},{y},{z}]")?,
            None => write!(out, "{comma}[{x},{y}]")?,
        }
    }
    Ok(())
}
