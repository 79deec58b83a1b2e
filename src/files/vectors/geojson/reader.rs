//! Takes up the lines of features and geometries.

use super::Place;
use super::crs::{Ground, Grounds, Said};
use super::item::{Feature, Geometry, Item, Member};
use crate::files::vectors::collect::Collector;
use crate::files::vectors::mapping::Line;
use crate::files::vectors::tally::Notice;
use crate::files::vectors::{Imported, MAX_POSITIONS, Property, Wanted, short};
use crate::value::curves::bezier::{Point, norm, shares, sub};
use crate::value::curves::{CurveError, Fault, smooth};

/// Takes up features one after the other: their lines become curves.
pub(super) struct Reader<'a> {
    place: &'a Place,
    /// Where the whole file lies.
    pub(super) grounds: Grounds,
    collector: Collector<'a>,
    /// What is to be known of the objects that lie apart from the file: of each system what is said of any object in
    /// it, and the warning about the first.
    own: Vec<(String, String)>,
    /// Whether every position so far could be longitude and latitude.
    degrees: bool,
    /// Lines with positions.
    lines: usize,
}

/// Most warnings about objects that lie apart from the file.
const MAX_OWN: usize = 8;

/// What something is called in messages.
pub(super) type Called<'a> = &'a dyn Fn() -> String;

/// What the lines of a geometry have in common.
#[derive(Clone, Copy)]
pub(super) struct Common<'a> {
    pub(super) feature: &'a Feature,
    pub(super) ground: Ground,
    /// Whether they close.
    pub(super) ring: bool,
}

impl<'a> Reader<'a> {
    pub(super) fn new(place: &'a Place, grounds: Grounds, wanted: Wanted<'a>) -> Self {
        let collector = Collector::new(wanted, place.onto, MAX_POSITIONS);
        Self { place, grounds, collector, own: Vec::new(), degrees: true, lines: 0 }
    }

    /// The curves, with a warning of the whole file before those of its parts.
    pub(super) fn finish(mut self, warning: Option<String>) -> Result<Imported, CurveError> {
        // By the standard of today a file is in degrees.
        let degrees = (self.degrees && self.lines > 0).then(|| {
            "all positions could be longitudes and latitudes, and metres are expected; a file in degrees must be \
             reprojected"
                .to_owned()
        });
        let own = std::mem::take(&mut self.own).into_iter().map(|(_, warning)| warning);
        self.collector.finish(warning.into_iter().chain(own).chain(degrees).collect())
    }

    /// Keeps a warning about an object, unless one says the same of another object.
    fn warn(&mut self, warning: Option<String>, called: Called<'_>) {
        let Some(warning) = warning.filter(|_| self.own.len() < MAX_OWN) else { return };
        let said = warning.replacen(&called(), "", 1);
        if self.own.iter().all(|(known, _)| *known != said) {
            self.own.push((said, warning));
        }
    }

    pub(super) fn feature(
        &mut self,
        feature: &Member<Feature>,
        called: Called<'_>,
    ) -> Result<(), CurveError> {
        let feature = match feature {
            Member::Here(feature) => feature,
            Member::Other(item) => {
                let what = || format!("{}: must be an object, got {item}", called());
                self.collector.tally.add(Notice::Malformed, what);
                return Ok(());
            }
        };
        let within = feature.lies.within(self.grounds, called, self.place.epsg);
        let (grounds, warning) = within.map_err(elsewhere)?;
        self.warn(warning, called);
        let is_geometry = |place: &&Member<Geometry>| matches!(place, Member::Here(g) if g.kind.is_some());
        let (geometry, ground) = match feature.place.as_ref().filter(is_geometry) {
            Some(place) => (Some(place), grounds.place),
            None => (feature.geometry.as_ref(), grounds.geometry),
        };
        let common = Common { feature, ground, ring: false };
        match geometry {
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

    /// Where a geometry lies that stands in another object.
    fn ground_of(&mut self, lies: &Said, outer: Ground, called: Called<'_>) -> Result<Ground, CurveError> {
        let Some(system) = lies.system() else { return Ok(outer) };
        let (ground, warning) = system.on(&called(), self.place.epsg).map_err(elsewhere)?;
        self.warn(warning, called);
        Ok(ground)
    }

    fn malformed(&mut self, called: Called<'_>, message: &str) {
        self.collector.tally.add(Notice::Malformed, || format!("{}: {message}", called()));
    }

    pub(super) fn geometry(
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
        let is_beside = ground.is_of_place && common.feature.place.is_some();
        let first = geometry.coordinates.as_ref().and_then(first_position);
        if is_beside && first.is_some_and(|at| !could_be_degrees(at)) {
            self.warn(Some(beside(called)), called);
        }
        match &geometry.coordinates {
            Some(coordinates) if ground.is_of_place && begins_in_degrees(coordinates) => {
                Err(elsewhere(format!(
                    "the coordinates of {} are degrees, since `coordRefSys` speaks of `place` alone, and metres are \
                 expected; reproject it to the terrain's coordinate system",
                    called()
                )))
            }
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
        let (points, heights) = match self.points(positions, common) {
            Ok(all) => all,
            Err(message) => {
                self.malformed(called, &message);
                return Ok(());
            }
        };
        self.lines += usize::from(!positions.is_empty());
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
            self.degrees &= !common.ground.is_said && could_be_degrees([east, north]);
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
}

/// Tells of a `geometry` beside `coordRefSys` whose numbers can be no degrees.
fn beside(called: Called<'_>) -> String {
    format!(
        "the `geometry` of {} should be in degrees, since `coordRefSys` speaks of `place` alone, and cannot be; it is \
         read as `coordRefSys` says",
        called()
    )
}

/// Tells of coordinates that do not lie on the terrain.
fn elsewhere(message: String) -> CurveError {
    CurveError::file("GeoJSON", message)
}

/// Whether a position could be a longitude and a latitude.
fn could_be_degrees([east, north]: Point) -> bool {
    east.abs() <= 180.0 && north.abs() <= 90.0
}

/// Whether the first position could be a longitude and a latitude.
fn begins_in_degrees(coordinates: &Item) -> bool {
    first_position(coordinates).is_some_and(could_be_degrees)
}

/// The first position, east and north, where one stands first.
fn first_position(coordinates: &Item) -> Option<Point> {
    let mut item = Some(coordinates);
    while let Some(one) = item {
        if let Some((at, _)) = one.position() {
            return Some(at);
        }
        item = one.list().and_then(<[Item]>::first);
    }
    None
}

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
