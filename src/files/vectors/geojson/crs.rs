//! What a `GeoJSON` file says of where it lies: by the member `crs` of the format's first edition of 2008, which most
//! programs still write and which may stand on any object, or by the `coordRefSys` of JSON-FG.

use super::item::{Item, Member, Next, Object};
use crate::files::epsg::{self, Unit};
use serde::de::MapAccess;

/// What an object says of its system.
#[derive(Clone, Debug, Default)]
pub(super) struct Said {
    /// By `crs`, of all that stands in it.
    crs: Option<System>,
    /// By `coordRefSys`, of its `place` alone, or of itself where it is a geometry.
    of_place: Option<System>,
}

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
#[derive(Clone, Debug, PartialEq)]
pub(super) enum System {
    /// Longitude and latitude, in degrees.
    Degrees,
    /// That of an EPSG code, with the metres of its unit.
    Epsg { code: u32, metres: f64 },
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
    /// Whether that is said of `place` alone: the `geometry` beside it lies in degrees.
    pub(super) is_of_place: bool,
}

/// How the coordinates of a feature become metres, by the member they stand in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grounds {
    pub(super) geometry: Ground,
    pub(super) place: Ground,
}

impl Grounds {
    /// Those of a file that says nothing.
    pub(super) const UNSAID: Self = {
        let ground = Ground { metres: 1.0, is_said: false, is_of_place: false };
        Self { geometry: ground, place: ground }
    };
}

impl Said {
    /// The names of the members that say it.
    pub(super) const MEMBERS: [&'static str; 2] = ["crs", "coordRefSys"];

    /// The system of the object itself, where it is a geometry and names one.
    pub(super) fn system(&self) -> Option<&System> {
        self.of_place.as_ref().or(self.crs.as_ref())
    }

    /// How coordinates in the object become metres, and what a person should know of them.
    ///
    /// # Errors
    /// When they lie elsewhere than on the terrain.
    pub(super) fn within(
        &self,
        outer: Grounds,
        called: &dyn Fn() -> String,
        terrain: Option<u32>,
    ) -> Result<(Grounds, Option<String>), String> {
        let (mut grounds, mut warning) = (outer, None);
        if let Some(system) = &self.crs {
            let (ground, told) = system.on(&called(), terrain)?;
            (grounds, warning) = (Grounds { geometry: ground, place: ground }, told);
        }
        if let Some(system) = &self.of_place {
            let (ground, told) = system.on(&called(), terrain)?;
            grounds.place = ground;
            if !grounds.geometry.is_said || grounds.geometry.is_of_place {
                grounds.geometry = Ground { is_of_place: true, ..ground };
            }
            warning = warning.or(told);
        }
        Ok((grounds, warning))
    }
}

impl Object for Said {
    fn member<'de, A: MapAccess<'de>>(&mut self, next: Next<'_, A>) -> Result<(), A::Error> {
        let said = match next.key {
            "crs" => &mut self.crs,
            "coordRefSys" => &mut self.of_place,
            _ => return next.skip(),
        };
        let system = system(&next.object::<Crs>()?);
        *said = said.take().or(system);
        Ok(())
    }
}

impl Object for Crs {
    fn member<'de, A: MapAccess<'de>>(&mut self, next: Next<'_, A>) -> Result<(), A::Error> {
        match next.key {
            "properties" => self.properties = Some(next.object()?),
            "href" => self.href = Some(next.item()?),
            _ => next.skip()?,
        }
        Ok(())
    }
}

impl Object for Named {
    fn member<'de, A: MapAccess<'de>>(&mut self, next: Next<'_, A>) -> Result<(), A::Error> {
        match next.key {
            "name" => self.name = Some(next.item()?),
            "code" => self.code = Some(next.item()?),
            _ => next.skip()?,
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

/// The name of the horizontal part of a compound system, which is the first; of another system its own.
fn horizontal(upper: &str) -> &str {
    if let Some((_, parts)) = upper.split_once("CRS-COMPOUND?") {
        let first = parts.split('&').find_map(|part| part.strip_prefix("1="));
        return first.unwrap_or(upper);
    }
    upper.split(",CRS:").nth(1).unwrap_or(upper)
}

/// A system by its name, as URN, URL or authority and code.
fn named(name: &str) -> System {
    let upper = name.trim().trim_start_matches('[').trim_end_matches(']').to_ascii_uppercase();
    let upper = horizontal(&upper);
    let code = upper.rsplit([':', '/', '#']).next().unwrap_or_default();
    match code.parse() {
        _ if matches!(code, "CRS84" | "CRS84H" | "WGS84" | "CRS83" | "CRS27") => System::Degrees,
        Ok(epsg) if !upper.contains("EPSG") => System::Unknown(format!("`{name}` ({epsg} of no EPSG)")),
        Ok(code) => match epsg::horizontal(code) {
            Some(Unit::Degrees | Unit::Grads) => System::Degrees,
            Some(Unit::Length(metres)) => System::Epsg { code, metres },
            None => System::Epsg { code, metres: 1.0 },
        },
        Err(_) => System::Unknown(format!("`{name}`")),
    }
}

impl System {
    /// How coordinates of this system become metres on a terrain, and what a person should know of it.
    ///
    /// # Errors
    /// When they lie elsewhere.
    pub(super) fn on(&self, what: &str, terrain: Option<u32>) -> Result<(Ground, Option<String>), String> {
        let ground = |metres| Ground { metres, is_said: true, is_of_place: false };
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
            (Self::Epsg { code, .. }, Some(want)) if *code != want => {
                Err(format!("{what} is in EPSG:{code}, the terrain in EPSG:{want}; reproject it"))
            }
            (Self::Epsg { metres, .. }, Some(_)) => Ok((ground(*metres), None)),
            (Self::Epsg { code, metres }, None) => {
                let of = if *metres == 1.0 { String::new() } else { format!(", a unit being {metres} m") };
                let warning = format!(
                    "{what} is in EPSG:{code}, and the terrain has no `geo`: its coordinates are taken from the \
                     terrain's north-west corner{of}"
                );
                Ok((ground(*metres), Some(warning)))
            }
        }
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
            "urn:ogc:def:crs,crs:EPSG::25832,crs:EPSG::5703",
            "http://www.opengis.net/def/crs-compound?1=http://www.opengis.net/def/crs/EPSG/0/25832&2=http://www.opengis.net/def/crs/EPSG/0/5703",
        ] {
            assert_eq!(named(name), System::Epsg { code: 25832, metres: 1.0 }, "{name}");
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
        let ground = |code: u32, terrain| {
            named(&format!("EPSG:{code}")).on("the file", terrain).map(|(ground, _)| ground.metres)
        };
        assert_eq!(ground(2263, None), Ok(1200.0 / 3937.0));
        assert_eq!(ground(2263, Some(2263)), Ok(1200.0 / 3937.0));
        assert_eq!(ground(32611, Some(32611)), Ok(1.0));
        assert!(ground(2263, Some(32611)).is_err() && System::Degrees.on("it", None).is_err());
    }
    /// `crs` speaks of all, `coordRefSys` of `place` alone.
    #[test]
    fn what_is_said_holds_for_the_member_it_speaks_of() {
        let said = |crs: Option<u32>, of_place: Option<u32>| {
            let [crs, of_place] = [crs, of_place].map(|code| Some(named(&format!("EPSG:{}", code?))));
            Said { crs, of_place }
        };
        let (us_foot, it) = (1200.0 / 3937.0, || "it".to_owned());
        // Of the file, of the feature: metres of `geometry` and `place`, and whether the first is said of it.
        for (file, feature, metres, is_of_place) in [
            ((None, None), (None, None), [1.0, 1.0], false),
            ((Some(2263), None), (None, None), [us_foot, us_foot], false),
            ((None, Some(2263)), (None, None), [us_foot, us_foot], true),
            ((Some(32611), Some(2263)), (None, None), [1.0, us_foot], false),
            ((Some(32611), None), (None, Some(2263)), [1.0, us_foot], false),
            ((None, Some(32611)), (None, Some(2263)), [us_foot, us_foot], true),
            ((None, Some(32611)), (Some(2263), None), [us_foot, us_foot], false),
        ] {
            let (outer, _) = said(file.0, file.1).within(Grounds::UNSAID, &it, None).expect("no fault");
            let (all, _) = said(feature.0, feature.1).within(outer, &it, None).expect("no fault");
            let got = ([all.geometry.metres, all.place.metres], all.geometry.is_of_place);
            assert_eq!(got, (metres, is_of_place), "{file:?} {feature:?}");
        }
    }
}
