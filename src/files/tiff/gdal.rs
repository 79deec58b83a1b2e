//! What GDAL writes beside a picture: scale, offset and unit of its bands, and what marks a void.

use std::borrow::Cow;

use quick_xml::escape::resolve_xml_entity;
use quick_xml::events::{BytesRef, BytesStart, Event};
use quick_xml::{Reader, XmlVersion};

use super::super::error::Fault;
use super::ifd::Directory;
use super::tag;

/// Longest text that is looked at, in bytes.
const LONGEST: usize = 1 << 20;

/// What GDAL says of the bands of a picture.
#[derive(Debug, Default)]
pub(super) struct Metadata {
    items: Vec<Item>,
}

#[derive(Debug)]
struct Item {
    /// The band, from 0; none for the whole picture.
    band: Option<usize>,
    role: String,
    text: String,
}

impl Metadata {
    pub(super) fn of(directory: &Directory<'_>) -> Result<Self, Fault> {
        let xml = directory.text(tag::GDAL_METADATA)?.filter(|xml| xml.len() <= LONGEST);
        Ok(xml.and_then(|xml| Self::parse(&xml)).unwrap_or_default())
    }

    /// Nothing where the text is no XML.
    fn parse(xml: &str) -> Option<Self> {
        let mut reader = Reader::from_str(xml);
        let (mut items, mut open) = (Vec::new(), None::<Item>);
        loop {
            let text = match reader.read_event().ok()? {
                Event::Start(tag) if tag.name().as_ref() == b"Item" => {
                    open = Item::of(&tag);
                    continue;
                }
                Event::End(tag) if tag.name().as_ref() == b"Item" => {
                    items.extend(open.take());
                    continue;
                }
                Event::Text(text) => text.decode().ok()?.into_owned(),
                Event::CData(text) => text.decode().ok()?.into_owned(),
                Event::GeneralRef(name) => character(&name)?,
                Event::Eof => break,
                _ => continue,
            };
            if let Some(item) = &mut open {
                item.text += &text;
            }
        }
        items.iter_mut().for_each(|item| item.text = item.text.trim().to_owned());
        Some(Self { items })
    }

    /// What stands of a band under a role; what stands of no band is said of all.
    fn item(&self, band: usize, role: &str) -> Option<&str> {
        let of = |of: Option<usize>| self.items.iter().find(|i| i.band == of && i.role == role);
        of(Some(band)).or_else(|| of(None)).map(|i| i.text.as_str())
    }

    /// Factor and summand that make values of the numbers of a band.
    pub(super) fn scaling(&self, band: usize) -> (f64, f64) {
        let finite = |role: &str| self.item(band, role).and_then(number).filter(|v| v.is_finite());
        (finite("scale").filter(|s| *s != 0.0).unwrap_or(1.0), finite("offset").unwrap_or(0.0))
    }

    /// The word for the unit of a band.
    pub(super) fn unit(&self, band: usize) -> Option<&str> {
        self.item(band, "unittype").filter(|unit| !unit.is_empty())
    }
}

impl Item {
    /// The item that an element begins; its text is empty yet.
    fn of(tag: &BytesStart<'_>) -> Option<Self> {
        let attribute = |name: &str| {
            let attribute = tag.try_get_attribute(name).ok().flatten()?;
            attribute.normalized_value(XmlVersion::Implicit1_0).ok().map(Cow::into_owned)
        };
        Some(Self {
            band: attribute("sample").and_then(|s| s.trim().parse().ok()),
            role: attribute("role").or_else(|| attribute("name"))?.to_ascii_lowercase(),
            text: String::new(),
        })
    }
}

/// What a reference such as `&amp;` or `&#176;` stands for.
fn character(name: &BytesRef<'_>) -> Option<String> {
    match name.resolve_char_ref().ok()? {
        Some(character) => Some(character.into()),
        None => resolve_xml_entity(&name.decode().ok()?).map(str::to_owned),
    }
}

/// A number as GDAL writes it, which ends with zeros or blanks, or is `nan`, `inf`, `-1.#IND`.
pub(super) fn number(text: &str) -> Option<f64> {
    let text = text.trim_matches(['\0', ' ', '\t', '\r', '\n']);
    if text.to_ascii_uppercase().contains("#IND") || text.to_ascii_uppercase().contains("#QNAN") {
        return Some(f64::NAN);
    }
    text.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_belong_to_bands() {
        let xml = r#"<GDALMetadata>
            <Item name="AREA_OR_POINT">Point</Item>
            <Item name="SCALE" sample="1" role="scale">2</Item>
            <Item name="UNITTYPE" role="unittype" sample='0'>US survey foot</Item>
            <Item name="OFFSET" sample="0" role="offset">-5.5</Item>
        </GDALMetadata>"#;
        let metadata = Metadata::parse(xml).expect("parses");
        assert_eq!((metadata.unit(0), metadata.unit(1)), (Some("US survey foot"), None));
        assert_eq!((metadata.scaling(0), metadata.scaling(1)), ((1.0, -5.5), (2.0, 0.0)));
        assert!(Metadata::parse("<GDALMetadata><Item").is_none());
        let told = Metadata::parse(
            "<a><Item name='UNITTYPE' role='unittype'> m&amp;<![CDATA[<s>]]>&#176; </Item></a>",
        );
        assert_eq!(told.expect("parses").unit(0), Some("m&<s>\u{b0}"));
    }

    #[test]
    fn numbers_are_read_as_gdal_writes_them() {
        assert_eq!(number("-9999 "), Some(-9999.0));
        assert_eq!(number("-3.4028234663852886e+38\0"), Some(-3.402_823_466_385_288_6e38));
        assert!(number("nan").is_some_and(f64::is_nan) && number("-1.#IND").is_some_and(f64::is_nan));
        assert_eq!(number("none"), None);
    }
}
