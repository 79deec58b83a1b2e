//! Where a GeoTIFF lies: the tags of GeoTIFF 1.1 (OGC 19-008) and GDAL's own, both ways.

use super::super::epsg::{self, Unit};
use super::super::error::Fault;
use super::super::place::{Affine, Anchor, Placement, Units};
use super::gdal::Metadata;
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
    pub(super) const VERTICAL: u16 = 4096;
    pub(super) const VERTICAL_CITATION: u16 = 4097;
    pub(super) const VERTICAL_UNITS: u16 = 4099;
}

/// "Given elsewhere in the file", as a code.
const USER_DEFINED: u16 = 32767;
/// Most numbers of geographic keys that are looked at.
const MOST_KEYS: usize = 4096;

/// The geographic keys of a file.
pub(super) struct Keys {
    entries: Vec<[u16; 4]>,
    doubles: Vec<f64>,
    text: String,
}

impl Keys {
    pub(super) fn of(directory: &Directory<'_>) -> Result<Self, Fault> {
        let shorts: Vec<u16> = directory
            .numbers(tag::GEO_KEYS)?
            .map(|n| (0..n.len().min(MOST_KEYS)).filter_map(|i| n.get(i)).map(|v| v as u16).collect())
            .unwrap_or_default();
        let (quads, _) = shorts.as_chunks::<4>();
        let doubles = directory.doubles(tag::GEO_DOUBLES)?.unwrap_or_default();
        let text = directory.text(tag::GEO_TEXT)?.unwrap_or_default();
        Ok(Self { entries: quads.iter().skip(1).copied().collect(), doubles, text })
    }

    /// A code written in the key itself.
    fn code(&self, key: u16) -> Option<u16> {
        self.entries.iter().find(|e| e[0] == key && e[1] == 0).map(|e| e[3])
    }

    /// A text, which ends with a bar.
    fn text(&self, key: u16) -> Option<String> {
        let e = self.entries.iter().find(|e| e[0] == key && e[1] == tag::GEO_TEXT)?;
        let (from, count) = (usize::from(e[3]), usize::from(e[2]));
        let text = self.text.get(from..from.checked_add(count)?)?;
        Some(text.trim_end_matches(['|', '\0']).to_owned())
    }

    fn double(&self, key: u16) -> Option<f64> {
        let e = self.entries.iter().find(|e| e[0] == key && e[1] == tag::GEO_DOUBLES)?;
        self.doubles.get(usize::from(e[3])).copied()
    }

    /// The code of a system that is in the registry.
    fn system(&self, key: u16) -> Option<u32> {
        self.code(key).filter(|e| (1024..USER_DEFINED).contains(e)).map(u32::from)
    }

    /// Whether coordinates are projected, in whatever system.
    fn is_projected(&self) -> bool {
        match self.code(key::MODEL_TYPE) {
            Some(1) => true,
            Some(2) => false,
            _ => self.code(key::PROJECTED).is_some_and(|code| code != 0),
        }
    }

    /// The name of the vertical system, where it counts downwards.
    fn depths(&self) -> Option<String> {
        let by_code = self.system(key::VERTICAL).filter(|code| epsg::is_depth(*code));
        let by_name = || self.text(key::VERTICAL_CITATION).filter(|name| epsg::names_depth(name));
        by_code.map(|code| format!("EPSG:{code}")).or_else(by_name)
    }

    /// Metres of the unit of projected coordinates: by its code, its size, or the system.
    fn linear(&self) -> Option<f64> {
        let size = || self.double(key::LINEAR_UNIT_SIZE).filter(|s| s.is_normal() && *s > 0.0);
        let system = || match self.system(key::PROJECTED).and_then(epsg::horizontal) {
            Some(Unit::Length(metres)) => Some(metres),
            _ => None,
        };
        self.code(key::LINEAR_UNITS).and_then(epsg::metres).or_else(size).or_else(system)
    }
}

/// Where the samples of a file lie.
pub(super) fn placement(
    directory: &Directory<'_>,
    keys: &Keys,
    size: [usize; 2],
    notes: &mut Vec<String>,
) -> Result<Placement, Fault> {
    let anchor = if keys.code(key::RASTER_TYPE) == Some(2) { Anchor::Point } else { Anchor::Area };
    // The geographic system that a projected one is based on is not the one of the coordinates.
    let globe = || keys.system(key::GEOGRAPHIC).filter(|_| !keys.is_projected());
    let epsg = keys.system(key::PROJECTED).or_else(globe);
    if epsg.is_none() && keys.is_projected() {
        notes.push("its projected system has no EPSG code; of the system only the unit is known".into());
    }
    let known = epsg.and_then(Units::of_epsg);
    let Some(affine) = affine(directory, anchor)? else {
        return Ok(Placement { anchor, epsg, ..Placement::default() });
    };
    let units = match keys.code(key::MODEL_TYPE) {
        Some(2) => Units::Degrees,
        Some(1) if known == Some(Units::WebMercator) => Units::WebMercator,
        Some(1) => Units::Length(keys.linear().unwrap_or(1.0)),
        _ => {
            known.or_else(|| keys.linear().map(Units::Length)).unwrap_or_else(|| Units::guess(&affine, size))
        }
    };
    let affine = if units == Units::Degrees { in_degrees(affine, keys) } else { affine };
    Ok(Placement::new(affine, anchor, epsg, units, size))
}

/// Coordinates in grads, as old French maps have them, in degrees.
fn in_degrees(affine: Affine, keys: &Keys) -> Affine {
    let by_code = keys.code(key::ANGULAR_UNITS).and_then(epsg::unit);
    let unit = by_code.or_else(|| keys.system(key::GEOGRAPHIC).and_then(epsg::horizontal));
    if unit != Some(Unit::Grads) {
        return affine;
    }
    let scaled = |v: [f64; 2]| v.map(|x| x * 0.9);
    Affine { origin: scaled(affine.origin), col: scaled(affine.col), row: scaled(affine.row) }
}

/// The map from samples to coordinates.
fn affine(directory: &Directory<'_>, anchor: Anchor) -> Result<Option<Affine>, Fault> {
    // Raster coordinates of an area count from its corner: the sample stands half a step inside.
    let half = if anchor == Anchor::Area { 0.5 } else { 0.0 };
    let affine = match directory.doubles(tag::TRANSFORMATION)?.as_deref() {
        Some(&[a, b, _, x, d, e, _, y, ..]) => {
            let corner = Affine { origin: [x, y], col: [a, d], row: [b, e] };
            Affine { origin: corner.at(half, half), ..corner }
        }
        _ => {
            let (scale, tie) = (directory.doubles(tag::PIXEL_SCALE)?, directory.doubles(tag::TIE_POINTS)?);
            let (Some(scale), Some(tie)) = (scale, tie) else { return Ok(None) };
            let (&[dx, dy, ..], &[i, j, _, x, y, ..]) = (&scale[..], &tie[..]) else { return Ok(None) };
            Affine::upright([x + (half - i) * dx, y - (half - j) * dy], [dx, dy])
        }
    };
    Ok(affine.is_sound().then_some(affine))
}

/// Metres of a unit of the heights: by GDAL's word of the band, by the keys of the vertical system, or by that system.
/// Of depths, which count downwards, they are below zero.
pub(super) fn unit_of_heights(
    keys: &Keys,
    gdal: &Metadata,
    band: usize,
    notes: &mut Vec<String>,
) -> Option<f64> {
    let by_word = gdal.unit(band).and_then(|word| epsg::unit_of("its heights", word, notes));
    let system = keys.system(key::VERTICAL);
    let by_system = || system.and_then(epsg::vertical);
    let metres = by_word.or_else(|| keys.code(key::VERTICAL_UNITS).and_then(epsg::metres)).or_else(by_system);
    let Some(depths) = keys.depths() else { return metres };
    notes.push(epsg::note_of_depths(&format!("its vertical system, {depths},")));
    Some(-metres.unwrap_or(1.0))
}

/// Metres of a US survey foot.
const FOOT_US: f64 = 1200.0 / 3937.0;

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
            let upright = a.is_north_up();
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
            // Local metres have no system: only what a sample stands for is said. Another unit must be named.
            Units::Length(1.0) | Units::WebMercator if code == USER_DEFINED => {
                keys.push([key::RASTER_TYPE, 0, 1, raster]);
            }
            Units::Length(_) | Units::WebMercator => {
                keys.extend([[key::MODEL_TYPE, 0, 1, 1], [key::RASTER_TYPE, 0, 1, raster]]);
                keys.push([key::PROJECTED, 0, 1, code]);
                match placement.units {
                    Units::Length(1.0) | Units::WebMercator => keys.push([key::LINEAR_UNITS, 0, 1, 9001]),
                    Units::Length(0.3048) => keys.push([key::LINEAR_UNITS, 0, 1, 9002]),
                    Units::Length(FOOT_US) => keys.push([key::LINEAR_UNITS, 0, 1, 9003]),
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
