//! What the `crs` member of a `GeoJSON` file says of where it lies: the member of the format's first edition of 2008,
//! which most programs still write.

use super::item::{An, AnItem, Any, Desk, Item, Member, Object};
use serde::de::{IgnoredAny, MapAccess};

/// The member as the file has it.
#[derive(Clone, Debug, Default)]
pub(super) struct Crs {
    properties: Option<Member<Named>>,
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

impl Object for Crs {
    fn member<'de, A: MapAccess<'de>>(
        &mut self,
        desk: &Desk<'_>,
        key: &str,
        object: &mut A,
    ) -> Result<(), A::Error> {
        match key {
            "properties" => self.properties = Some(object.next_value_seed(An::of(desk))?),
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

impl Crs {
    /// The coordinate system that it names.
    pub(super) fn system(&self) -> System {
        let Some(Member::Here(Named { name, code })) = &self.properties else {
            return System::Unknown("one without a name".into());
        };
        match (name, code) {
            (Some(Item::Text(name)), _) => named(name),
            (_, Some(Item::Text(code))) => named(&format!("EPSG:{code}")),
            (_, Some(Item::Number(code))) => named(&format!("EPSG:{code}")),
            _ => System::Unknown("one without a name".into()),
        }
    }
}

/// A system by its name, as URN, URL or authority and code.
fn named(name: &str) -> System {
    let upper = name.trim().to_ascii_uppercase();
    let code = upper.rsplit([':', '/', '#']).next().unwrap_or_default();
    match code.parse() {
        _ if matches!(code, "CRS84" | "CRS84H" | "WGS84" | "CRS83" | "CRS27") => System::Degrees,
        Ok(epsg) if !upper.contains("EPSG") => System::Unknown(format!("`{name}` ({epsg} of no EPSG)")),
        // Geographic systems: WGS 84 in two and three dimensions, and those of Europe and North America.
        Ok(4326 | 4979 | 4258 | 4937 | 4269 | 4267) => System::Degrees,
        Ok(epsg) => System::Epsg(epsg),
        Err(_) => System::Unknown(format!("`{name}`")),
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
        ] {
            assert_eq!(named(name), System::Degrees, "{name}");
        }
        for name in ["urn:ogc:def:crs:ESRI::54009", "", "mine"] {
            assert!(matches!(named(name), System::Unknown(_)), "{name}");
        }
    }
}
