//! Lines of `GeoJSON` files.

mod crs;
mod item;
mod reader;

use serde::de::{DeserializeSeed as _, IgnoredAny, MapAccess, SeqAccess};

use self::crs::{Grounds, Said};
use self::item::{
    An, AnItem, Any, Feature, Geometry, Item, ItemContext, Member, Next, Object as _, State, Take,
};
use self::reader::{Common, Reader};
use super::{GoOn, Imported, Mapping, Watch, check_size, decode, short};
use crate::value::curves::CurveError;
use crate::value::{Bounds, Terrain};

/// How the lines of a file come to stand on the terrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// East and north in the file, in metres, that come to stand at the north-west corner of the terrain.
    pub origin: [f64; 2],
    /// The terrain, x east and y south, in metres.
    pub onto: Bounds,
    /// EPSG code of its coordinate system, where it lies on Earth.
    pub epsg: Option<u32>,
    /// Whether the curve is smooth through the positions, rather than straight from each to the next.
    pub smooth: bool,
    /// Positions nearer to the one before than this are left out, in metres; the last one stays.
    pub spacing: f64,
}

impl Place {
    /// On a terrain, smooth and with every position.
    pub fn on(terrain: &Terrain) -> Self {
        let origin = terrain.geo.map_or([0.0, 0.0], |g| [g.east, g.north]);
        let epsg = terrain.geo.map(|g| g.epsg);
        Self { origin, onto: terrain.bounds(), epsg, smooth: true, spacing: 0.0 }
    }
}

/// The curves of all lines of a file whose coordinates are lengths to the east and north, metres unless its coordinate
/// system has another unit, with the constraints that a mapping makes of their properties. The rings of polygons are
/// lines, too; points are left out and counted.
///
/// # Errors
/// When the text is no `GeoJSON`, says that it lies in another coordinate system than the terrain, is over a limit, or
/// the work was asked to stop.
pub fn read(
    bytes: &[u8],
    place: &Place,
    mapping: &Mapping,
    go_on: &GoOn<'_>,
) -> Result<Imported, CurveError> {
    check_size(bytes)?;
    let text = decode::text(bytes).map_err(|e| CurveError::file("GeoJSON", e))?;
    let asked = mapping.names().chain(["name"]).map(str::to_owned).collect();
    // A value of a list takes some four bytes at least.
    let watch = Watch::new(go_on, text.len() / 4);
    watch.at(0)?;
    let cx = ItemContext { watch, asked, state: std::cell::RefCell::new(State::default()) };
    let (grounds, warning) = grounds(&text, &cx, place)?;
    let mut reader = Reader::new(place, grounds, mapping);
    let mut from = serde_json::Deserializer::from_str(&text);
    let whole = Any(Whole { cx: &cx, reader: &mut reader }).deserialize(&mut from);
    let whole = whole.and_then(|whole| from.end().map(|()| whole));
    if let Some(stopped) = cx.state.take().stopped {
        return Err(stopped);
    }
    let whole = whole.map_err(|e| CurveError::file("GeoJSON", not_json(&text, &e)))?;
    finish(reader, whole, warning)
}

/// Where the whole file lies, and what a person should know of that. It is looked for before the lines are read, since
/// it may stand after them.
fn grounds(text: &str, cx: &ItemContext<'_>, place: &Place) -> Result<(Grounds, Option<String>), CurveError> {
    if !Said::MEMBERS.iter().any(|member| text.contains(&format!("\"{member}\""))) {
        return Ok((Grounds::UNSAID, None));
    }
    let said = An::<Said>::of(cx).deserialize(&mut serde_json::Deserializer::from_str(text));
    if let Some(stopped) = cx.state.take().stopped {
        return Err(stopped);
    }
    // What is no JSON is told of when the lines are read.
    let Ok(Member::Here(said)) = said else { return Ok((Grounds::UNSAID, None)) };
    let grounds = said.within(Grounds::UNSAID, &|| "the file".to_owned(), place.epsg);
    grounds.map_err(|message| CurveError::file("GeoJSON", message))
}

/// What is wrong with a text that is not JSON.
fn not_json(text: &str, error: &serde_json::Error) -> String {
    let line = text.as_bytes().split(|b| *b == b'\n').nth(error.line().saturating_sub(1));
    let found = line.and_then(|line| line.get(error.column().saturating_sub(1)));
    let follows = error.to_string().starts_with("trailing characters") && found == Some(&b'{');
    if follows || text.trim_start().starts_with(RECORD) {
        let message = "is a sequence of JSON texts (RFC 8142, or one a line), which is another format; put its features \
                       into one FeatureCollection";
        return message.to_owned();
    }
    format!("is not JSON: {error}")
}

/// What begins each text of a sequence.
const RECORD: char = '\u{1e}';

/// The outermost object without its features, which are read as they come.
#[derive(Default)]
struct Outer {
    kind: Option<Item>,
    geometry: Geometry,
    feature: Feature,
    has_features: bool,
    /// Whether it has a member that only Esri's own JSON has.
    is_esri: bool,
}

/// Reads the outermost object.
struct Whole<'a, 'r, 'p> {
    cx: &'a ItemContext<'a>,
    reader: &'r mut Reader<'p>,
}

impl<'de> Take<'de> for Whole<'_, '_, '_> {
    type Made = Outer;

    fn cx(&self) -> &ItemContext<'_> {
        self.cx
    }

    fn other(self, _: Item) -> Outer {
        Outer::default()
    }

    fn object<A: MapAccess<'de>>(self, mut object: A) -> Result<Outer, A::Error> {
        let mut outer = Outer::default();
        let cx = self.cx;
        while let Some(key) = object.next_key::<std::borrow::Cow<'_, str>>()? {
            match &*key {
                "features" => {
                    let all = Any(Features { cx, reader: &mut *self.reader });
                    outer.has_features = object.next_value_seed(all)?;
                }
                "type" => outer.kind = Some(object.next_value_seed(Any(AnItem(cx)))?),
                "coordinates" | "geometries" => {
                    outer.geometry.member(Next { cx, key: &key, object: &mut object })?;
                }
                "geometry" | "place" | "properties" | "id" => {
                    outer.feature.member(Next { cx, key: &key, object: &mut object })?;
                }
                _ => {
                    outer.is_esri |= matches!(&*key, "geometryType" | "spatialReference");
                    object.next_value::<IgnoredAny>()?;
                }
            }
        }
        Ok(outer)
    }
}

/// Reads features one after the other; whether they stand in a list.
struct Features<'a, 'r, 'p> {
    cx: &'a ItemContext<'a>,
    reader: &'r mut Reader<'p>,
}

impl<'de> Take<'de> for Features<'_, '_, '_> {
    type Made = bool;

    fn cx(&self) -> &ItemContext<'_> {
        self.cx
    }

    fn other(self, _: Item) -> bool {
        false
    }

    fn list<A: SeqAccess<'de>>(self, mut list: A) -> Result<bool, A::Error> {
        let mut number = 0_usize;
        while let Some(feature) = list.next_element_seed(An::<Feature>::of(self.cx))? {
            self.cx.count()?;
            let taken = self.reader.feature(&feature, &|| format!("feature {number}"));
            taken.map_err(|error| self.cx.stop(error))?;
            number += 1;
        }
        Ok(true)
    }
}

/// The curves of the whole file, once its features are read.
fn finish(mut reader: Reader<'_>, whole: Outer, warning: Option<String>) -> Result<Imported, CurveError> {
    let Outer { kind, mut geometry, feature, has_features, is_esri } = whole;
    let refuse = |message: &str| Err(CurveError::file("GeoJSON", message));
    match kind.as_ref().and_then(Item::text) {
        Some("FeatureCollection") if has_features => (),
        Some("FeatureCollection") => return refuse("a FeatureCollection must have a list `features`"),
        Some("Feature") => reader.feature(&Member::Here(feature), &|| "the feature".to_owned())?,
        Some(name) if GEOMETRIES.contains(&name) => {
            geometry.kind = kind;
            // Whatever it says of itself is said of a geometry.
            let common = Common { feature: &Feature::default(), ground: reader.grounds.place, ring: false };
            reader.geometry(&geometry, common, &|| "the geometry".to_owned())?;
        }
        Some("Topology") => return refuse("is TopoJSON, which is another format; convert it to GeoJSON"),
        Some(name) => {
            let name = short(name);
            return refuse(&format!(
                "its `type` must be FeatureCollection, Feature or a geometry, got \"{name}\""
            ));
        }
        None if is_esri => {
            return refuse("is JSON of Esri, which is another format; convert it to GeoJSON");
        }
        None => return refuse("must be an object with a text `type`"),
    }
    reader.finish(warning)
}

/// What a geometry may be.
const GEOMETRIES: [&str; 7] =
    ["Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon", "GeometryCollection"];
