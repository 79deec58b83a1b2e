//! World files and `.prj`: where samples lie, in files beside the one that holds them.

use super::epsg;
use super::input::Input;
use super::place::{Affine, Anchor, Placement, Units};
use super::wkt::{Node, System};

/// Longest of these files that is looked at, in bytes.
const LONGEST: usize = 1 << 16;

/// What a `.prj` beside a file says.
pub(super) fn system(input: &Input<'_>, notes: &mut Vec<String>) -> Option<System> {
    let text = text(input, "prj")?;
    let system = Node::parse(&text).and_then(|root| System::of(&root)).or_else(|| old(&text, notes));
    if system.is_none() {
        notes.push("the .prj beside it is not understood".into());
    }
    system
}

/// The place that a world file and a `.prj` give, for files that have none of their own.
pub(super) fn placement(input: &Input<'_>, size: [usize; 2], notes: &mut Vec<String>) -> Placement {
    match beside(input, notes) {
        Some(affine) => placed(affine, Anchor::Area, system(input, notes), size),
        None => Placement::default(),
    }
}

/// The map from samples to coordinates that a world file gives, whatever the system.
pub(super) fn beside(input: &Input<'_>, notes: &mut Vec<String>) -> Option<Affine> {
    let worlds = ["tfw", "tifw", "pgw", "pngw", "wld", "blw", "bilw", "bpw", "bqw"];
    let text = worlds.iter().find_map(|w| text(input, w))?;
    let affine = affine(&text);
    if affine.is_none() {
        notes.push("the world file beside it is not six numbers".into());
    }
    affine
}

/// A placement of coordinates in a system, where there is one.
pub(super) fn placed(affine: Affine, anchor: Anchor, system: Option<System>, size: [usize; 2]) -> Placement {
    let epsg = system.as_ref().and_then(|s| s.epsg);
    let units = system.map(|s| s.units).or_else(|| epsg.and_then(Units::of_epsg));
    let units = units.unwrap_or_else(|| Units::guess(&affine, size));
    Placement::new(affine, anchor, epsg, units, size)
}

fn text(input: &Input<'_>, extension: &str) -> Option<String> {
    let bytes = input.companion(extension).filter(|b| b.len() <= LONGEST)?;
    Some(String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)).into_owned())
}

/// The six numbers of a world file: steps along a row, steps from row to row, and where the first sample stands.
fn affine(text: &str) -> Option<Affine> {
    let number = |word: &str| word.replacen(',', ".", 1).parse::<f64>().ok();
    let numbers: Option<Vec<f64>> = text.split_ascii_whitespace().take(6).map(number).collect();
    let &[a, d, b, e, c, f] = &numbers?[..] else { return None };
    let affine = Affine { origin: [c, f], col: [a, d], row: [b, e] };
    affine.is_sound().then_some(affine)
}

/// The `.prj` of `ArcInfo`: a word and its value in each line.
fn old(text: &str, notes: &mut Vec<String>) -> Option<System> {
    let value = |key: &str| {
        let mut lines = text.lines().map(|l| l.split_ascii_whitespace().collect::<Vec<_>>());
        let line = lines.find(|l| l.first().is_some_and(|w| w.eq_ignore_ascii_case(key)))?;
        line.get(1).map(|w| w.to_ascii_uppercase())
    };
    let projection = value("projection")?;
    let (zone, datum) = (value("zone"), value("datum").unwrap_or_default());
    let epsg = match projection.as_str() {
        "GEOGRAPHIC" => match datum.as_str() {
            "WGS84" => Some(4326),
            "NAD83" => Some(4269),
            "NAD27" => Some(4267),
            _ => None,
        },
        "UTM" => {
            zone.and_then(|z| z.parse::<i32>().ok()).filter(|z| (1..=60).contains(&z.abs())).and_then(|z| {
                let zone = z.unsigned_abs();
                match datum.as_str() {
                    "WGS84" => Some(if z > 0 { 32600 } else { 32700 } + zone),
                    "NAD83" if (1..=23).contains(&z) => Some(26900 + zone),
                    "NAD27" if (1..=22).contains(&z) => Some(26700 + zone),
                    _ => None,
                }
            })
        }
        _ => None,
    };
    let units = if projection == "GEOGRAPHIC" {
        Units::Degrees
    } else {
        let unit = value("units").and_then(|word| length("coordinates", &word, notes));
        Units::Length(unit.unwrap_or(1.0))
    };
    let heights = value("zunits").and_then(|word| length("heights", &word, notes));
    for key in ["Xshift", "Yshift"] {
        let shift = value(&key.to_ascii_lowercase()).filter(|v| v.parse() != Ok(0.0));
        notes
            .extend(shift.map(|v| {
                format!("`{key} {v}` of the .prj beside it is not applied: its place is off by it")
            }));
    }
    Some(System { epsg, units, heights })
}

/// Metres of a unit in the `.prj` of `ArcInfo`: a word, or how many of it are a metre. `NO` and `NONE` are no unit.
fn length(of: &str, word: &str, notes: &mut Vec<String>) -> Option<f64> {
    let metres = word.parse::<f64>().ok().filter(|n| n.is_normal() && *n > 0.0).map(f64::recip);
    match word {
        "NO" | "NONE" => None,
        // Feet in such files are those of the survey.
        "FEET" => epsg::metres(9003),
        _ => metres.or_else(|| epsg::unit_of(&format!("{of} in the .prj beside it"), word, notes)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn world_files_are_six_numbers() {
        let a = affine("30.0\r\n0\r\n0\r\n-30,0\r\n500015\r\n3999985.0\r\n").expect("six numbers");
        assert_eq!(a, Affine::upright([500_015.0, 3_999_985.0], [30.0, 30.0]));
        assert_eq!(affine("1 0 0 -1 5"), None);
        assert_eq!(affine("0 0 0 0 5 5"), None);
        assert_eq!(affine("1 0 0 nan 5 5"), None);
    }

    #[test]
    fn files_of_arcinfo_are_understood() {
        let mut notes = Vec::new();
        let text = "Projection    UTM\nZone 11\nDatum NAD83\nZunits FEET\nUnits METERS\nXshift 0.0\n";
        let utm = old(text, &mut notes).expect("understood");
        assert_eq!((utm.epsg, utm.units, utm.heights), (Some(26911), Units::Length(1.0), epsg::metres(9003)));
        let globe = old("Projection GEOGRAPHIC\nDatum WGS84\nUnits DD", &mut notes).expect("understood");
        assert_eq!((globe.epsg, globe.units, globe.heights), (Some(4326), Units::Degrees, None));
        assert!(old("hello", &mut notes).is_none());
        assert!(notes.is_empty(), "{notes:?}");
    }

    #[test]
    fn units_of_arcinfo_are_words_and_numbers() {
        let mut notes = Vec::new();
        let mut heights = |unit: &str| {
            let system = old(&format!("Projection UTM\nUnits METERS\nZunits {unit}\n"), &mut notes);
            system.expect("understood").heights
        };
        let tenth = Some(0.1);
        assert_eq!((heights("DECIMETERS"), heights("10"), heights("NO")), (tenth, tenth, None));
        assert_eq!((heights("centimeters"), heights("Kilometers")), (Some(0.01), Some(1000.0)));
        assert_eq!(heights("FOO"), None);
        assert!(notes.len() == 1 && notes[0].contains("\"FOO\", is not known"), "{notes:?}");
        old("Projection UTM\nXshift 1000.0\nYshift 0\n", &mut notes).expect("understood");
        assert!(notes.len() == 2 && notes[1].starts_with("`Xshift 1000.0`"), "{notes:?}");
    }
}
