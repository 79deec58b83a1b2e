//! Coordinate systems as well-known text, in the dialects of OGC 01-009, ISO 19162 and Esri: what code they have and
//! in which units they count.

use super::epsg;
use super::place::Units;

/// How deep the text may be nested.
const DEEPEST: usize = 24;

/// What is understood of a coordinate system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct System {
    /// Its EPSG code.
    pub(super) epsg: Option<u32>,
    /// The unit of its coordinates.
    pub(super) units: Units,
    /// Metres of the unit of its heights, where it has some; below zero for depths, which count downwards.
    pub(super) heights: Option<f64>,
}

/// A keyword with what stands in its brackets.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Node {
    key: String,
    texts: Vec<String>,
    nodes: Vec<Self>,
}

impl Node {
    /// The tree of a text; `None` where it is none.
    pub(super) fn parse(text: &str) -> Option<Self> {
        let mut rest = text.trim_start();
        let mut root = Self::take(&mut rest, 0)?;
        // Esri writes the vertical system behind the other one.
        if let Some(mut second) = rest.trim_start().strip_prefix(',') {
            root.nodes.push(Self::take(&mut second, 0)?);
            rest = second;
        }
        rest.trim().is_empty().then_some(root)
    }

    fn take(rest: &mut &str, depth: usize) -> Option<Self> {
        let end = rest.find(['[', '(']).filter(|_| depth < DEEPEST)?;
        let (key, inside) = rest.split_at(end);
        let key = key.trim().to_ascii_uppercase();
        if key.is_empty() || !key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_') {
            return None;
        }
        let mut node = Self { key, ..Self::default() };
        *rest = &inside[1..];
        loop {
            *rest = rest.trim_start();
            match rest.chars().next()? {
                ']' | ')' => {
                    *rest = &rest[1..];
                    return Some(node);
                }
                ',' => *rest = &rest[1..],
                '"' => {
                    let (text, after) = rest[1..].split_once('"')?;
                    node.texts.push(text.to_owned());
                    *rest = after;
                }
                _ => {
                    let end = rest.find([',', ']', ')', '[', '('])?;
                    if rest[end..].starts_with(['[', '(']) {
                        node.nodes.push(Self::take(rest, depth + 1)?);
                    } else {
                        node.texts.push(rest[..end].trim().to_owned());
                        *rest = &rest[end..];
                    }
                }
            }
        }
    }

    fn child(&self, keys: &[&str]) -> Option<&Self> {
        self.nodes.iter().find(|n| keys.contains(&n.key.as_str()))
    }

    fn name(&self) -> &str {
        self.texts.first().map_or("", String::as_str)
    }

    /// The code that an authority gave it.
    fn epsg(&self) -> Option<u32> {
        let id = self.child(&["AUTHORITY", "ID"])?;
        let [authority, code, ..] = &id.texts[..] else { return None };
        if authority.eq_ignore_ascii_case("EPSG") { code.parse().ok() } else { None }
    }

    /// Metres of its unit of length: of the system's own, or of its first axis.
    fn metres(&self) -> Option<f64> {
        let keys = ["UNIT", "LENGTHUNIT"];
        let axis = || self.child(&["AXIS"]).and_then(|a| a.child(&keys));
        let unit = self.child(&keys).or_else(axis)?;
        unit.texts.get(1).and_then(|t| t.parse().ok()).filter(|m: &f64| m.is_normal() && *m > 0.0)
    }

    /// Metres of its unit of heights, below zero where it counts downwards.
    fn heights(&self) -> Option<f64> {
        let down = |axis: &Self| axis.texts.iter().any(|t| t.eq_ignore_ascii_case("down"));
        let turned = |n: &Self| {
            let direction = n.key == "PARAMETER" && n.name().eq_ignore_ascii_case("direction");
            direction && n.texts.get(1).is_some_and(|t| t.starts_with('-'))
        };
        let depths = self.child(&["AXIS"]).is_some_and(down)
            || self.nodes.iter().any(turned)
            || self.epsg().is_some_and(epsg::is_depth)
            || epsg::names_depth(self.name());
        if depths { Some(-self.metres().unwrap_or(1.0)) } else { self.metres() }
    }
}

const PROJECTED: [&str; 3] = ["PROJCS", "PROJCRS", "PROJECTEDCRS"];
const GEOGRAPHIC: [&str; 4] = ["GEOGCS", "GEOGCRS", "GEODCRS", "GEOGRAPHICCRS"];
const VERTICAL: [&str; 5] = ["VERT_CS", "VERTCS", "VERTCRS", "VERTICALCRS", "VERTICALCS"];
const COMPOUND: [&str; 2] = ["COMPD_CS", "COMPOUNDCRS"];

impl System {
    /// The system that a tree describes.
    pub(super) fn of(root: &Node) -> Option<Self> {
        let is = |node: &Node, keys: &[&str]| keys.contains(&node.key.as_str());
        let compound = is(root, &COMPOUND);
        let of =
            |keys: &[&str]| if is(root, keys) { Some(root) } else { root.child(keys).filter(|_| compound) };
        let heights = root.child(&VERTICAL).and_then(Node::heights);
        if let Some(flat) = of(&PROJECTED) {
            let epsg = flat.epsg().or_else(|| code_of_name(flat.name()));
            let mercator = epsg.and_then(Units::of_epsg).filter(|u| *u == Units::WebMercator);
            let units = mercator.unwrap_or(Units::Length(flat.metres().unwrap_or(1.0)));
            return Some(Self { epsg, units, heights });
        }
        let globe = of(&GEOGRAPHIC)?;
        Some(Self {
            epsg: globe.epsg().or_else(|| code_of_name(globe.name())),
            units: Units::Degrees,
            heights,
        })
    }
}

/// The codes of systems that Esri writes by name only.
fn code_of_name(name: &str) -> Option<u32> {
    let name = name.to_ascii_uppercase().replace([' ', '/'], "_").replace("__", "_").replace("__", "_");
    match name.as_str() {
        "GCS_WGS_1984" | "WGS_84" => return Some(4326),
        "GCS_NORTH_AMERICAN_1983" | "NAD83" => return Some(4269),
        "GCS_NORTH_AMERICAN_1927" | "NAD27" => return Some(4267),
        "GCS_ETRS_1989" | "ETRS89" => return Some(4258),
        "WGS_1984_WEB_MERCATOR_AUXILIARY_SPHERE" | "WGS_84_PSEUDO-MERCATOR" => return Some(3857),
        _ => (),
    }
    let (datum, zone) = name.split_once("_UTM_ZONE_")?;
    let (digits, side) = zone.split_at(zone.len().checked_sub(1)?);
    let zone: u32 = digits.parse().ok().filter(|z| (1..=60).contains(z))?;
    match (datum, side) {
        ("WGS_1984" | "WGS_84", "N") => Some(32600 + zone),
        ("WGS_1984" | "WGS_84", "S") => Some(32700 + zone),
        ("NAD_1983" | "NAD83", "N") if zone <= 23 => Some(26900 + zone),
        ("NAD_1927" | "NAD27", "N") if zone <= 22 => Some(26700 + zone),
        ("ETRS_1989" | "ETRS89", "N") if (28..=38).contains(&zone) => Some(25800 + zone),
        _ => None,
    }
}

/// Metres of a unit of heights, with a note where it is below zero; the metre where a system does not say.
pub(super) fn metres_of_heights(system: Option<&System>, notes: &mut Vec<String>) -> f64 {
    unit_of_heights(system, notes).unwrap_or(1.0)
}

/// The same, and nothing where a system does not say.
pub(super) fn unit_of_heights(system: Option<&System>, notes: &mut Vec<String>) -> Option<f64> {
    let unit = system.and_then(|s| s.heights.or_else(|| s.epsg.and_then(epsg::vertical)))?;
    if unit < 0.0 {
        notes.push(epsg::note_of_depths("the vertical system of the .prj beside it"));
    }
    Some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn system(text: &str) -> Option<System> {
        Node::parse(text).and_then(|n| System::of(&n))
    }

    #[test]
    fn systems_of_three_dialects_are_understood() {
        let esri = r#"PROJCS["NAD_1983_UTM_Zone_11N",GEOGCS["GCS_North_American_1983",DATUM["D_North_American_1983",SPHEROID["GRS_1980",6378137.0,298.257222101]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],UNIT["Meter",1.0]]"#;
        assert_eq!(
            system(esri),
            Some(System { epsg: Some(26911), units: Units::Length(1.0), heights: None })
        );
        let feet = r#"PROJCS["NAD83 / California zone 3 (ftUS)",GEOGCS["NAD83",UNIT["degree",0.0174532925199433]],UNIT["US survey foot",0.304800609601219],AUTHORITY["EPSG","2227"]]"#;
        let found = system(feet).expect("understood");
        assert_eq!((found.epsg, found.units), (Some(2227), Units::Length(0.304_800_609_601_219)));
        let iso = r#"COMPOUNDCRS["x",PROJCRS["NAD83 / UTM zone 11N",BASEGEOGCRS["NAD83"],CS[Cartesian,2],AXIS["(E)",east,LENGTHUNIT["metre",1]],ID["EPSG",26911]],VERTCRS["NAVD88 height (ftUS)",CS[vertical,1],AXIS["h",up,LENGTHUNIT["US survey foot",0.304800609601219]],ID["EPSG",6360]]]"#;
        let found = system(iso).expect("understood");
        assert_eq!(
            (found.epsg, found.units, found.heights),
            (Some(26911), Units::Length(1.0), Some(0.304_800_609_601_219))
        );
        let behind = format!(
            "{esri},VERTCS[\"NAVD88\",VDATUM[\"x\"],PARAMETER[\"Direction\",1.0],UNIT[\"Foot_US\",0.3048006096]]"
        );
        assert_eq!(system(&behind).and_then(|s| s.heights), Some(0.304_800_609_6));
        for depths in [
            r#"VERT_CS["x",UNIT["metre",1],AXIS["Depth",DOWN]]"#,
            r#"VERTCS["MSL_Depth",VDATUM["x"],UNIT["Meter",1.0]]"#,
            r#"VERTCS["x",PARAMETER["Vertical_Shift",0.0],PARAMETER["Direction",-1.0],UNIT["Meter",1.0]]"#,
            r#"VERTCRS["x",CS[vertical,1],AXIS["y (D)",down,LENGTHUNIT["metre",1]],ID["EPSG",5715]]"#,
        ] {
            assert_eq!(system(&format!("{esri},{depths}")).and_then(|s| s.heights), Some(-1.0), "{depths}");
        }
        assert_eq!(system(r#"GEOGCS["GCS_WGS_1984",UNIT["Degree",0.017]]"#).and_then(|s| s.epsg), Some(4326));
    }

    #[test]
    fn broken_texts_are_none() {
        let deep = "A[".repeat(100_000);
        for text in ["", "[", "A[", "A[\"", "]", "A[B]C", "Projection UTM", deep.as_str()] {
            assert_eq!(system(text), None);
        }
    }
}
