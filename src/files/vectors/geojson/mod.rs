//! Lines of `GeoJSON` files.

mod crs;
mod item;

use serde::de::{DeserializeSeed as _, IgnoredAny, MapAccess, SeqAccess};

use self::crs::{Ground, Said};
use self::item::{An, AnItem, Any, Desk, Feature, Geometry, Item, Member, Object as _, State, Take};
use super::collect::Collector;
use super::mapping::Line;
use super::tally::Notice;
use super::{GoOn, Imported, MAX_POSITIONS, Mapping, Property, Watch, check_size, decode, short};
use crate::kit::curves::short::shares;
use crate::value::curves::bezier::{Point, norm, sub};
use crate::value::curves::{CurveError, Fault, smooth};
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
/// system has another unit, with the constraints that a
/// mapping makes of their properties. The rings of polygons are lines, too; points are left out and counted.
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
    let desk = Desk { watch, asked, state: std::cell::RefCell::new(State::default()) };
    let (ground, warning) = ground(&text, &desk, place)?;
    let collector = Collector::new(mapping, place.onto, MAX_POSITIONS);
    let mut reader = Reader { place, ground, collector, own: None, degrees: true, lines: 0 };
    let mut from = serde_json::Deserializer::from_str(&text);
    let whole = Any(Whole { desk: &desk, reader: &mut reader }).deserialize(&mut from);
    let whole = whole.and_then(|whole| from.end().map(|()| whole));
    if let Some(stopped) = desk.state.take().stopped {
        return Err(stopped);
    }
    let whole = whole.map_err(|e| CurveError::file("GeoJSON", not_json(&text, &e)))?;
    reader.finish(whole, warning)
}

/// Where the whole file lies, and what a person should know of that. It is looked for before the lines are read, since
/// it may stand after them.
fn ground(text: &str, desk: &Desk<'_>, place: &Place) -> Result<(Ground, Option<String>), CurveError> {
    if !Said::MEMBERS.iter().any(|member| text.contains(&format!("\"{member}\""))) {
        return Ok((Ground::UNSAID, None));
    }
    let said = An::<Said>::of(desk).deserialize(&mut serde_json::Deserializer::from_str(text));
    if let Some(stopped) = desk.state.take().stopped {
        return Err(stopped);
    }
    // What is no JSON is told of when the lines are read.
    let Ok(Member::Here(said)) = said else { return Ok((Ground::UNSAID, None)) };
    let Some(system) = said.system() else { return Ok((Ground::UNSAID, None)) };
    system.on("the file", place.epsg).map_err(|message| CurveError::file("GeoJSON", message))
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
    desk: &'a Desk<'a>,
    reader: &'r mut Reader<'p>,
}

impl<'de> Take<'de> for Whole<'_, '_, '_> {
    type Made = Outer;

    fn desk(&self) -> &Desk<'_> {
        self.desk
    }

    fn other(self, _: Item) -> Outer {
        Outer::default()
    }

    fn object<A: MapAccess<'de>>(self, mut object: A) -> Result<Outer, A::Error> {
        let mut outer = Outer::default();
        let desk = self.desk;
        while let Some(key) = object.next_key::<std::borrow::Cow<'_, str>>()? {
            match &*key {
                "features" => {
                    let all = Any(Features { desk, reader: &mut *self.reader });
                    outer.has_features = object.next_value_seed(all)?;
                }
                "type" => outer.kind = Some(object.next_value_seed(Any(AnItem(desk)))?),
                "coordinates" | "geometries" => outer.geometry.member(desk, &key, &mut object)?,
                "geometry" | "place" | "properties" | "id" => {
                    outer.feature.member(desk, &key, &mut object)?;
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
    desk: &'a Desk<'a>,
    reader: &'r mut Reader<'p>,
}

impl<'de> Take<'de> for Features<'_, '_, '_> {
    type Made = bool;

    fn desk(&self) -> &Desk<'_> {
        self.desk
    }

    fn other(self, _: Item) -> bool {
        false
    }

    fn list<A: SeqAccess<'de>>(self, mut list: A) -> Result<bool, A::Error> {
        let mut number = 0_usize;
        while let Some(feature) = list.next_element_seed(An::<Feature>::of(self.desk))? {
            self.desk.count()?;
            let taken = self.reader.feature(&feature, &|| format!("feature {number}"));
            taken.map_err(|error| self.desk.stop(error))?;
            number += 1;
        }
        Ok(true)
    }
}

struct Reader<'a> {
    place: &'a Place,
    /// Where the whole file lies.
    ground: Ground,
    collector: Collector<'a>,
    /// What is to be known of the first object that lies apart from the file.
    own: Option<String>,
    /// Whether every position so far could be longitude and latitude.
    degrees: bool,
    /// Lines with positions.
    lines: usize,
}

/// What something is called in messages.
type Called<'a> = &'a dyn Fn() -> String;

/// What the lines of a geometry have in common.
#[derive(Clone, Copy)]
struct Common<'a> {
    feature: &'a Feature,
    ground: Ground,
    /// Whether they close.
    ring: bool,
}

impl Reader<'_> {
    fn feature(&mut self, feature: &Member<Feature>, called: Called<'_>) -> Result<(), CurveError> {
        let feature = match feature {
            Member::Here(feature) => feature,
            Member::Other(item) => {
                let what = || format!("{}: must be an object, got {item}", called());
                self.collector.tally.add(Notice::Malformed, what);
                return Ok(());
            }
        };
        let ground = self.ground_of(&feature.lies, self.ground, called)?;
        let common = Common { feature, ground, ring: false };
        let is_geometry = |place: &&Member<Geometry>| matches!(place, Member::Here(g) if g.kind.is_some());
        let place = feature.place.as_ref().filter(is_geometry);
        match place.or(feature.geometry.as_ref()) {
            Some(Member::Here(geometry)) => self.geometry(geometry, common, called),
            Some(Member::Other(Item::Null)) | None => {
                self.collector.tally.add(Notice::NoGeometry, called);
                Ok(())
            }
            Some(Member::Other(item)) => {
                self.malformed(called, &format!("its geometry must be an object, got {item}"));
                Ok(())
            }
        }
    }

    /// Where an object lies that stands in another.
    fn ground_of(&mut self, lies: &Said, outer: Ground, called: Called<'_>) -> Result<Ground, CurveError> {
        let Some(system) = lies.system() else { return Ok(outer) };
        let on = system.on(&called(), self.place.epsg);
        let (ground, warning) = on.map_err(|message| CurveError::file("GeoJSON", message))?;
        self.own = self.own.take().or(warning);
        Ok(ground)
    }

    fn malformed(&mut self, called: Called<'_>, message: &str) {
        self.collector.tally.add(Notice::Malformed, || format!("{}: {message}", called()));
    }

    fn geometry(
        &mut self,
        geometry: &Geometry,
        common: Common<'_>,
        called: Called<'_>,
    ) -> Result<(), CurveError> {
        let ground = self.ground_of(&geometry.lies, common.ground, called)?;
        let common = Common { ground, ..common };
        let kind = geometry.kind.as_ref().and_then(Item::text);
        // How deep the lines stand in lists.
        let depth = match kind {
            Some("LineString") => 0,
            Some("MultiLineString" | "Polygon") => 1,
            Some("MultiPolygon") => 2,
            Some("GeometryCollection") => return self.collection(geometry, common, called),
            Some(kind) => {
                let what = || format!("{}, a {}", called(), short(kind));
                self.collector.tally.add(Notice::NoLine, what);
                return Ok(());
            }
            None => {
                self.malformed(called, "must have a geometry with a text `type`");
                return Ok(());
            }
        };
        let ring = matches!(kind, Some("Polygon" | "MultiPolygon"));
        match &geometry.coordinates {
            Some(coordinates) => self.lines(coordinates, depth, Common { ring, ..common }, called),
            None => {
                self.malformed(called, "must have a list `coordinates`");
                Ok(())
            }
        }
    }

    fn collection(
        &mut self,
        geometry: &Geometry,
        common: Common<'_>,
        called: Called<'_>,
    ) -> Result<(), CurveError> {
        let Some(parts) = &geometry.geometries else {
            self.malformed(called, "must have a list `geometries`");
            return Ok(());
        };
        for (i, part) in parts.iter().enumerate() {
            let called = || format!("{}, geometry {i}", called());
            match part {
                Member::Here(part) => self.geometry(part, common, &called)?,
                Member::Other(item) => self.malformed(&called, &format!("must be an object, got {item}")),
            }
        }
        Ok(())
    }

    /// The lines that stand some lists deep.
    fn lines(
        &mut self,
        coordinates: &Item,
        depth: usize,
        common: Common<'_>,
        called: Called<'_>,
    ) -> Result<(), CurveError> {
        let Some(items) = coordinates.list() else {
            self.malformed(called, &format!("must have a list of positions, got {coordinates}"));
            return Ok(());
        };
        if depth == 0 {
            return self.line(items, common, called);
        }
        for (i, item) in items.iter().enumerate() {
            let called = || format!("{}, line {i}", called());
            self.lines(item, depth - 1, common, &called)?;
        }
        Ok(())
    }

    fn line(&mut self, positions: &[Item], common: Common<'_>, called: Called<'_>) -> Result<(), CurveError> {
        let feature = common.feature;
        self.collector.count(positions.len() + 1)?;
        self.lines += usize::from(!positions.is_empty());
        let (points, heights) = match self.points(positions, common) {
            Ok(all) => all,
            Err(message) => {
                self.malformed(called, &message);
                return Ok(());
            }
        };
        if points.len() < 2 {
            self.collector.tally.add(Notice::Pointlike, called);
            return Ok(());
        }
        let line = if self.place.smooth { smooth::through(&points) } else { smooth::straight(&points) };
        let knots = match line {
            Ok(knots) => knots,
            Err(Fault(message)) => {
                self.collector.tally.add(Notice::Unfit, || format!("{}: {message}", called()));
                return Ok(());
            }
        };
        let mut z: Vec<(f64, f64)> = Vec::new();
        if heights.iter().any(Option::is_some) {
            for (u, height) in shares(&knots).into_iter().zip(&heights) {
                if let Some(height) = height
                    && z.last().is_none_or(|last| last.0 < u)
                {
                    z.push((u, *height));
                }
            }
        }
        let property = |name: &str| property(feature.properties.get(name), name);
        let name = feature.properties.get("name").and_then(Item::text);
        let name = name.or(feature.id.as_ref().and_then(Item::text)).unwrap_or_default();
        self.collector.take(Line { name: short(name), knots, z, property: &property }, called);
        Ok(())
    }

    /// Where the positions lie on the terrain, and their heights; those that repeat the one before, or are nearer to it
    /// than the spacing, are left out.
    fn points(
        &mut self,
        positions: &[Item],
        common: Common<'_>,
    ) -> Result<(Vec<Point>, Vec<Option<f64>>), String> {
        let (mut points, mut heights): (Vec<Point>, Vec<Option<f64>>) = (Vec::new(), Vec::new());
        let Place { origin, onto, spacing, .. } = *self.place;
        for (i, position) in positions.iter().enumerate() {
            let Some(([east, north], height)) = position.position() else {
                return Err(format!("position {i} must be a list [east, north] of numbers, got {position}"));
            };
            self.degrees &= !common.ground.is_said && east.abs() <= 180.0 && north.abs() <= 90.0;
            let [east, north] = [east, north].map(|x| x * common.ground.metres);
            let point = [onto.min[0] + (east - origin[0]), onto.min[1] - (north - origin[1])];
            let last = i + 1 == positions.len();
            let near = |p: &Point| {
                let distance = norm(sub(point, *p));
                distance == 0.0 || (distance < spacing && !last)
            };
            if points.last().is_none_or(|p| !near(p)) {
                points.push(point);
                heights.push(height);
            }
        }
        // A ring whose end is not written closes all the same.
        if let (true, [first, .., last]) = (common.ring, points.as_slice())
            && first != last
        {
            points.push(*first);
            heights.push(heights[0]);
        }
        Ok((points, heights))
    }

    fn finish(mut self, whole: Outer, warning: Option<String>) -> Result<Imported, CurveError> {
        let Outer { kind, mut geometry, feature, has_features, is_esri } = whole;
        let refuse = |message: &str| Err(CurveError::file("GeoJSON", message));
        match kind.as_ref().and_then(Item::text) {
            Some("FeatureCollection") if has_features => (),
            Some("FeatureCollection") => return refuse("a FeatureCollection must have a list `features`"),
            Some("Feature") => self.feature(&Member::Here(feature), &|| "the feature".to_owned())?,
            Some(name) if GEOMETRIES.contains(&name) => {
                geometry.kind = kind;
                let common = Common { feature: &Feature::default(), ground: self.ground, ring: false };
                self.geometry(&geometry, common, &|| "the geometry".to_owned())?;
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
        // By the standard of today a file is in degrees.
        let degrees = (self.degrees && self.lines > 0).then(|| {
            "all positions could be longitudes and latitudes, and metres are expected; a file in degrees must be \
             reprojected"
                .to_owned()
        });
        let warnings = [warning, self.own.take(), degrees];
        self.collector.finish(warnings.into_iter().flatten().collect())
    }
}

/// What a geometry may be.
const GEOMETRIES: [&str; 7] =
    ["Point", "MultiPoint", "LineString", "MultiLineString", "Polygon", "MultiPolygon", "GeometryCollection"];

/// A number, a text that is one, or a list of numbers.
fn property(item: Option<&Item>, name: &str) -> Result<Option<Property>, String> {
    let Some(item) = item else { return Ok(None) };
    let number = match item {
        Item::Null => return Ok(None),
        Item::Number(number) => Some(Property::Number(*number)),
        Item::Text(text) => text.trim().parse().ok().filter(|v: &f64| v.is_finite()).map(Property::Number),
        Item::Flag(_) | Item::Object => None,
        Item::Position(..) | Item::List(_) => item.numbers().map(Property::List),
    };
    let bad = || format!("property `{name}` must be a number or a list of numbers, got {item}");
    number.map(Some).ok_or_else(bad)
}
