//! Where a GeoTIFF lies: the tags of GeoTIFF 1.1 (OGC 19-008) and GDAL's own, both ways.

use super::super::place::{Affine, Anchor, Placement, Units};
use super::ifd::Directory;
use super::tag;

mod key {
    pub(super) const MODEL_TYPE: u16 = 1024;
    pub(super) const RASTER_TYPE: u16 = 1025;
    pub(super) const GEOGRAPHIC: u16 = 2048;
    pub(super) const ANGULAR_UNITS: u16 = 2054;
    pub(super) const PROJECTED: u16 = 3072;
    pub(super) const LINEAR_UNITS: u16 = 3076;
    pub(super) const LINEAR_UNIT_SIZE: u16 = 3077;
    pub(super) const VERTICAL_UNITS: u16 = 4099;
}

/// "Given elsewhere in the file", as a code.
const USER_DEFINED: u16 = 32767;

/// The geographic keys of a file.
struct Keys<'a, 'b> {
    directory: &'a Directory<'b>,
    entries: Vec<[u16; 4]>,
}

impl<'a, 'b> Keys<'a, 'b> {
    fn of(directory: &'a Directory<'b>) -> Self {
        let shorts: Vec<u16> = directory
            .numbers(tag::GEO_KEYS)
            .map(|n| (0..n.len().min(4096)).filter_map(|i| n.get(i)).map(|v| v as u16).collect())
            .unwrap_or_default();
        let (quads, _) = shorts.as_chunks::<4>();
        Self { directory, entries: quads.iter().skip(1).copied().collect() }
    }

    /// A code written in the key itself.
    fn code(&self, key: u16) -> Option<u16> {
        self.entries.iter().find(|e| e[0] == key && e[1] == 0).map(|e| e[3])
    }

    fn double(&self, key: u16) -> Option<f64> {
        let e = self.entries.iter().find(|e| e[0] == key && e[1] == tag::GEO_DOUBLES)?;
        self.directory.doubles(tag::GEO_DOUBLES)?.get(usize::from(e[3])).copied()
    }
}

/// Metres of a unit of length, by its EPSG code.
fn metres(unit: u16) -> Option<f64> {
    Some(match unit {
        9001 => 1.0,
        9002 => 0.3048,
        9003 => 1200.0 / 3937.0,
        9036 => 1000.0,
        _ => return None,
    })
}

/// Where the samples of a file lie.
pub(super) fn placement(directory: &Directory<'_>, size: [usize; 2]) -> Placement {
    let keys = Keys::of(directory);
    let anchor = if keys.code(key::RASTER_TYPE) == Some(2) { Anchor::Point } else { Anchor::Area };
    let epsg =
        keys.code(key::PROJECTED).or(keys.code(key::GEOGRAPHIC)).filter(|e| (1024..USER_DEFINED).contains(e));
    let epsg = epsg.map(u32::from);
    let known = epsg.and_then(Units::of_epsg);
    let Some(affine) = affine(directory, anchor) else {
        return Placement { anchor, epsg, ..Placement::default() };
    };
    let units = match keys.code(key::MODEL_TYPE) {
        Some(2) => Units::Degrees,
        Some(1) if known == Some(Units::WebMercator) => Units::WebMercator,
        Some(1) => {
            let size = keys.double(key::LINEAR_UNIT_SIZE).filter(|s| s.is_normal() && *s > 0.0);
            Units::Length(keys.code(key::LINEAR_UNITS).and_then(metres).or(size).unwrap_or(1.0))
        }
        _ => known.unwrap_or_else(|| Units::guess(&affine, size)),
    };
    Placement::new(affine, anchor, epsg, units, size)
}

/// The map from samples to coordinates.
fn affine(directory: &Directory<'_>, anchor: Anchor) -> Option<Affine> {
    // Raster coordinates of an area count from its corner: the sample stands half a step inside.
    let half = if anchor == Anchor::Area { 0.5 } else { 0.0 };
    let affine = match directory.doubles(tag::TRANSFORMATION).as_deref() {
        Some(&[a, b, _, x, d, e, _, y, ..]) => {
            let corner = Affine { origin: [x, y], col: [a, d], row: [b, e] };
            Affine { origin: corner.at(half, half), ..corner }
        }
        _ => {
            let (scale, tie) = (directory.doubles(tag::PIXEL_SCALE)?, directory.doubles(tag::TIE_POINTS)?);
            let (&[dx, dy, ..], &[i, j, _, x, y, ..]) = (&scale[..], &tie[..]) else { return None };
            Affine::upright([x + (half - i) * dx, y - (half - j) * dy], [dx, dy])
        }
    };
    let all = affine.origin.iter().chain(&affine.col).chain(&affine.row);
    let flat = affine.col == [0.0; 2] || affine.row == [0.0; 2];
    (all.into_iter().all(|v| v.is_finite()) && !flat).then_some(affine)
}

/// Factor and summand that make metres of the samples: GDAL's scale and offset, the unit of the vertical datum.
pub(super) fn scaling(directory: &Directory<'_>) -> (f64, f64) {
    let xml = directory.text(tag::GDAL_METADATA).unwrap_or_default();
    let item = |role: &str| {
        let lines = xml.split("<Item ").filter(|i| i.contains(&format!("role=\"{role}\"")));
        let mut first_band = lines.filter(|i| !i.contains("sample=\"") || i.contains("sample=\"0\""));
        let value = first_band.next()?.split_once('>')?.1.split_once('<')?.0;
        value.trim().parse::<f64>().ok().filter(|v| v.is_finite())
    };
    let (scale, offset) = (item("scale").unwrap_or(1.0), item("offset").unwrap_or(0.0));
    let unit = Keys::of(directory).code(key::VERTICAL_UNITS).and_then(metres).unwrap_or(1.0);
    (scale * unit, offset * unit)
}

/// The tags that say where samples lie.
#[derive(Debug, Default)]
pub(super) struct Tags {
    pub(super) keys: Vec<u16>,
    pub(super) doubles: Vec<f64>,
    pub(super) scale: Vec<f64>,
    pub(super) tie: Vec<f64>,
    pub(super) transformation: Vec<f64>,
}

impl Tags {
    pub(super) fn of(placement: &Placement) -> Self {
        let mut tags = Self::default();
        let half = if placement.anchor == Anchor::Area { 0.5 } else { 0.0 };
        if let Some(a) = placement.affine {
            let origin = a.at(-half, -half);
            let upright = a.is_upright() && a.col[0] > 0.0 && a.row[1] < 0.0;
            if upright {
                tags.scale = vec![a.col[0], -a.row[1], 0.0];
                tags.tie = vec![0.0, 0.0, 0.0, origin[0], origin[1], 0.0];
            } else {
                let rows = [
                    [a.col[0], a.row[0], 0.0, origin[0]],
                    [a.col[1], a.row[1], 0.0, origin[1]],
                    [0.0; 4],
                    [0.0, 0.0, 0.0, 1.0],
                ];
                tags.transformation = rows.concat();
            }
        }
        tags.set_keys(placement);
        tags
    }

    fn set_keys(&mut self, placement: &Placement) {
        let code = placement.epsg.and_then(|e| u16::try_from(e).ok()).unwrap_or(USER_DEFINED);
        let mut keys = Vec::new();
        let raster = if placement.anchor == Anchor::Area { 1 } else { 2 };
        match placement.units {
            Units::Degrees => {
                // Coordinates in degrees that name no system are taken for WGS 84 by every reader; say it.
                let code = if code == USER_DEFINED { 4326 } else { code };
                keys.extend([[key::MODEL_TYPE, 0, 1, 2], [key::RASTER_TYPE, 0, 1, raster]]);
                keys.extend([[key::GEOGRAPHIC, 0, 1, code], [key::ANGULAR_UNITS, 0, 1, 9102]]);
            }
            // Local metres have no system: only what a sample stands for is said.
            Units::Length(_) | Units::WebMercator if code == USER_DEFINED => {
                keys.push([key::RASTER_TYPE, 0, 1, raster]);
            }
            Units::Length(_) | Units::WebMercator => {
                keys.extend([[key::MODEL_TYPE, 0, 1, 1], [key::RASTER_TYPE, 0, 1, raster]]);
                keys.push([key::PROJECTED, 0, 1, code]);
                match placement.units {
                    Units::Length(1.0) | Units::WebMercator => keys.push([key::LINEAR_UNITS, 0, 1, 9001]),
                    Units::Length(0.3048) => keys.push([key::LINEAR_UNITS, 0, 1, 9002]),
                    Units::Length(size) => {
                        keys.push([key::LINEAR_UNITS, 0, 1, USER_DEFINED]);
                        keys.push([key::LINEAR_UNIT_SIZE, tag::GEO_DOUBLES, 1, 0]);
                        self.doubles = vec![size];
                    }
                    Units::Degrees => (),
                }
            }
        }
        self.keys = vec![1, 1, 0, keys.len() as u16];
        self.keys.extend(keys.concat());
    }
}
