//! What a `GeoJSON` file says of where it lies: by the member `crs` of the format's first edition of 2008, which most
//! programs still write and which may stand on any object, or by the `coordRefSys` of JSON-FG.

use super::item::{An, AnItem, Any, Desk, Item, Member, Object};
use crate::files::epsg::{self, Unit};
use serde::de::{IgnoredAny, MapAccess};

/// What an object says of its system.
#[derive(Clone, Debug, Default)]
pub(super) struct Said(Option<System>);

/// A member as the file has it.
#[derive(Clone, Debug, Default)]
struct Crs {
    properties: Option<Member<Named>>,
    /// Of a reference of JSON-FG.
    href: Option<Item>,
}

/// Its properties.
#[derive(Clone, Debug, Default)]
struct Named {
    name: Option<Item>,
    code: Option<Item>,
}

/// A coordinate system.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum System {
    /// Longitude and latitude, in degrees.
    Degrees,
    /// That of an EPSG code.
    Epsg(u32),
    /// One that is not known here.
    Unknown(String),
}

/// How coordinates become metres on the terrain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ground {
    /// Metres of their unit.
    pub(super) metres: f64,
    /// Whether the file says what they are.
    pub(super) is_said: bool,
}

impl Ground {
    /// That of a file that says nothing.
    pub(super) const UNSAID: Self = Self { metres: 1.0, is_said: false };
}

impl Said {
    /// The names of the members that say it.
    pub(super) const MEMBERS: [&'static str; 2] = ["crs", "coordRefSys"];

    /// The system, where one is named.
    pub(super) fn system(&self) -> Option<&System> {
        self.0.as_ref()
    }
}

impl Object for Said {
    fn member<'de, A: MapAccess<'de>>(
        &mut self,
        desk: &Desk<'_>,
        key: &str,
        object: &mut A,
    ) -> Result<(), A::Error> {
        if Self::MEMBERS.contains(&key) {
            let system = system(&object.next_value_seed(An::<Crs>::of(desk))?);
            self.0 = self.0.take().or(system);
        } else {
            object.next_value::<IgnoredAny>()?;
        }
        Ok(())
    }
}

impl Object for Crs {
    fn member<'de, A: MapAccess<'de>>(
        &mut self,
        desk: &Desk<'_>,
        key: &str,
        object: &mut A,
    ) -> Result<(), A::Error> {
        match key {
            "properties" => self.properties = Some(object.next_value_seed(An::of(desk))?),
            "href" => self.href = Some(object.next_value_seed(Any(AnItem(desk)))?),
            _ => drop(object.next_value::<IgnoredAny>()?),
        }
        Ok(())
    }
}

impl Object for Named {
    fn member<'de, A: MapAccess<'de>>(
        &mut self,
        desk: &Desk<'_>,
        key: &str,
        object: &mut A,
    ) -> Result<(), A::Error> {
        match key {
            "name" => self.name = Some(object.next_value_seed(Any(AnItem(desk)))?),
            "code" => self.code = Some(object.next_value_seed(Any(AnItem(desk)))?),
            _ => drop(object.next_value::<IgnoredAny>()?),
        }
        Ok(())
    }
}

/// The coordinate system that a member names; none where it is null.
fn system(member: &Member<Crs>) -> Option<System> {
    let without_name = || System::Unknown("one without a name".into());
    Some(match member {
        Member::Other(Item::Null) => return None,
        Member::Other(Item::Text(name)) => named(name),
        // Of a compound system the first part is the horizontal one.
        Member::Other(Item::List(parts)) => match parts.first() {
            Some(Item::Text(name)) => named(name),
            _ => without_name(),
        },
        Member::Other(item) => System::Unknown(item.to_string()),
        Member::Here(Crs { href: Some(Item::Text(name)), .. }) => named(name),
        Member::Here(Crs { properties: Some(Member::Here(Named { name, code })), .. }) => {
            match (name, code) {
                (Some(Item::Text(name)), _) => named(name),
                (_, Some(Item::Text(code))) => named(&format!("EPSG:{code}")),
                (_, Some(Item::Number(code))) => named(&format!("EPSG:{code}")),
                _ => without_name(),
            }
        }
        Member::Here(_) => without_name(),
    })
}

/// A system by its name, as URN, URL or authority and code.
fn named(name: &str) -> System {
    let upper = name.trim().trim_start_matches('[').trim_end_matches(']').to_ascii_uppercase();
    let code = upper.rsplit([':', '/', '#']).next().unwrap_or_default();
    match code.parse() {
        _ if matches!(code, "CRS84" | "CRS84H" | "WGS84" | "CRS83" | "CRS27") => System::Degrees,
        Ok(epsg) if !upper.contains("EPSG") => System::Unknown(format!("`{name}` ({epsg} of no EPSG)")),
        Ok(epsg) if matches!(epsg::horizontal(epsg), Some(Unit::Degrees | Unit::Grads)) => System::Degrees,
        Ok(epsg) => System::Epsg(epsg),
        Err(_) => System::Unknown(format!("`{name}`")),
    }
}

impl System {
    /// How coordinates of this system become metres on a terrain, and what a person should know of it.
    ///
    /// # Errors
    /// When they lie elsewhere.
    pub(super) fn on(&self, what: &str, terrain: Option<u32>) -> Result<(Ground, Option<String>), String> {
        let ground = |metres| Ground { metres, is_said: true };
        match (self, terrain) {
            (Self::Degrees, _) => Err(format!(
                "the coordinates of {what} are degrees, and metres are expected; reproject it to the terrain's \
                 coordinate system"
            )),
            (Self::Unknown(name), _) => Ok((
                ground(1.0),
                Some(format!(
                    "the coordinate system of {what}, {name}, is not known; its coordinates are taken for metres"
                )),
            )),
            (Self::Epsg(epsg), Some(want)) if *epsg != want => {
                Err(format!("{what} is in EPSG:{epsg}, the terrain in EPSG:{want}; reproject it"))
            }
            (Self::Epsg(epsg), Some(_)) => Ok((ground(unit(*epsg)), None)),
            (Self::Epsg(epsg), None) => {
                let metres = unit(*epsg);
                let of = if metres == 1.0 { String::new() } else { format!(", a unit being {metres} m") };
                let warning = format!(
                    "{what} is in EPSG:{epsg}, and the terrain has no `geo`: its coordinates are taken from the \
                     terrain's north-west corner{of}"
                );
                Ok((ground(metres), Some(warning)))
            }
        }
    }
}

/// Metres of the unit of a projected system.
fn unit(epsg: u32) -> f64 {
    match epsg::horizontal(epsg) {
        Some(Unit::Length(metres)) => metres,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_are_known_by_every_form_of_their_name() {
        for name in [
            "urn:ogc:def:crs:EPSG::25832",
            "urn:ogc:def:crs:EPSG:6.9:25832",
            "urn:x-ogc:def:crs:EPSG:25832",
            "EPSG:25832",
            "epsg:25832 ",
            "http://www.opengis.net/def/crs/EPSG/0/25832",
            "http://www.opengis.net/gml/srs/epsg.xml#25832",
            "[EPSG:25832]",
        ] {
            assert_eq!(named(name), System::Epsg(25832), "{name}");
        }
        for name in [
            "urn:ogc:def:crs:OGC:1.3:CRS84",
            "urn:ogc:def:crs:OGC::CRS84",
            "urn:ogc:def:crs:OGC:1.3:CRS84h",
            "OGC:CRS84",
            "http://www.opengis.net/def/crs/OGC/1.3/CRS84",
            "urn:ogc:def:crs:EPSG::4326",
            "EPSG:4258",
            "EPSG:4807",
        ] {
            assert_eq!(named(name), System::Degrees, "{name}");
        }
        for name in ["urn:ogc:def:crs:ESRI::54009", "", "mine"] {
            assert!(matches!(named(name), System::Unknown(_)), "{name}");
        }
    }
    #[test]
    fn units_of_systems_become_metres() {
        let ground = |epsg: u32, terrain| System::Epsg(epsg).on("the file", terrain).map(|(g, _)| g.metres);
        assert_eq!(ground(2263, None), Ok(1200.0 / 3937.0));
        assert_eq!(ground(2263, Some(2263)), Ok(1200.0 / 3937.0));
        assert_eq!(ground(32611, Some(32611)), Ok(1.0));
        assert!(ground(2263, Some(32611)).is_err() && System::Degrees.on("it", None).is_err());
    }
}
