//! What GDAL writes beside a file that cannot say it: `NAME.aux.xml`, of which void, scale, offset and unit of a band
//! are read, and a mask `NAME.msk`, a TIFF that is 0 where there is nothing.

use quick_xml::Reader;
use quick_xml::XmlVersion;
use quick_xml::events::{BytesStart, Event};

use super::epsg;
use super::error::Fault;
use super::height::HeightFile;
use super::input::{Claim, Input};
use super::tiff::{mask_bytes, strike_mask};
use super::voids::strike;

/// Extensions behind the whole name of a file.
pub(super) const BESIDE: [&str; 2] = ["aux.xml", "msk"];

/// Elements that say where a file lies.
const PLACE: [&str; 2] = ["SRS", "GeoTransform"];

/// The most things that are named because they are not read.
const MOST_UNREAD: usize = 8;

/// What is said of a band.
#[derive(Clone, Debug, Default, PartialEq)]
struct Band {
    nodata: Option<f64>,
    scale: Option<f64>,
    offset: Option<f64>,
    unit: String,
    /// What is there and not read.
    unread: Vec<String>,
}

/// Bytes that reading what stands beside a file takes.
pub(super) fn bytes(input: &Input<'_>, claim: &Claim) -> u64 {
    input.companion("msk").map_or(0, |_| mask_bytes(claim.cols.saturating_mul(claim.rows)))
}

/// Gives a file what stands beside it in the ways of GDAL, and says what is not read.
///
/// # Errors
/// When the work is cancelled, or there is no memory. What is wrong with the files beside it is a note.
pub(super) fn apply(input: &Input<'_>, file: &mut HeightFile) -> Result<(), Fault> {
    if let Some(mask) = input.companion("msk") {
        apply_mask(mask, input, file)?;
    }
    let Some(xml) = input.companion("aux.xml") else { return Ok(()) };
    let number = input.reading.channel.as_deref().and_then(|c| c.parse().ok()).unwrap_or(1);
    let Some(band) = Band::parse(&String::from_utf8_lossy(xml), number) else {
        file.origin.notes.push("the `.aux.xml` beside it is not understood".into());
        return Ok(());
    };
    let unread = band.unread.iter().map(|what| format!("{what} of the `.aux.xml` beside it is not read"));
    file.origin.notes.extend(unread);
    let unit = epsg::unit_of("the `.aux.xml` beside it", &band.unit, &mut file.origin.notes);
    let nodata = band.nodata.filter(|_| file.origin.nodata.is_none());
    let (factor, summand) = (band.scale.unwrap_or(1.0), band.offset.unwrap_or(0.0));
    let scales = (factor, summand, unit.unwrap_or(1.0)) != (1.0, 0.0, 1.0);
    // The `.aux.xml` speaks of the numbers as the file holds them. Once a scale of the file's own was applied to them,
    // neither a nodata value nor another scale fits what is left.
    if !file.origin.plain {
        if scales || nodata.is_some() {
            let note = "scale, unit and nodata of the `.aux.xml` beside it are not read: the file has a scale of its own";
            file.origin.notes.push(note.into());
        }
        return Ok(());
    }
    if let Some(code) = nodata {
        strike(&mut file.data, nodata);
        file.origin.nodata = nodata;
        file.origin.notes.push(format!("{code} marks voids, as the `.aux.xml` beside it says"));
    }
    let metres = unit.unwrap_or(1.0);
    file.scale(factor * metres, summand * metres);
    file.metres |= scales || unit.is_some();
    Ok(())
}

/// Makes voids where a mask beside a file is 0.
fn apply_mask(mask: &[u8], input: &Input<'_>, file: &mut HeightFile) -> Result<(), Fault> {
    // A mask has the rows in the order of the file.
    if file.origin.turned {
        file.flip();
    }
    let struck = strike_mask(&mask, input, file);
    if file.origin.turned {
        file.flip();
    }
    let note = match struck {
        Ok(()) => "a mask beside it, `.msk`, says where it is void".into(),
        Err(fault @ (Fault::Cancelled | Fault::NoMemory { .. })) => return Err(fault),
        Err(fault) => {
            format!("the mask beside it, `.msk`, is not read, and its voids are not known: {fault}")
        }
    };
    file.origin.notes.push(note);
    Ok(())
}

impl Band {
    /// What a text says of a band, counted from 1; nothing where it is no XML.
    fn parse(xml: &str, number: u64) -> Option<Self> {
        let mut reader = Reader::from_str(xml);
        let (mut band, mut inside, mut key, mut text) =
            (Self::default(), false, String::new(), String::new());
        let mut open = 0usize;
        loop {
            let event = reader.read_event().ok()?;
            match event {
                Event::Start(_) => open += 1,
                Event::End(_) => open = open.saturating_sub(1),
                _ => (),
            }
            match event {
                Event::Start(tag) if tag.name().as_ref() == b"PAMRasterBand" => {
                    inside = is_band(&tag, number)
                }
                Event::End(tag) if tag.name().as_ref() == b"PAMRasterBand" => inside = false,
                Event::Start(tag) => {
                    key = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
                    text.clear();
                }
                Event::Text(part) => text += &part.decode().ok()?,
                Event::End(tag) => {
                    if PLACE.contains(&key.as_str()) {
                        band.leave(format!("the `{key}`"));
                    } else if inside && tag.name().as_ref() == key.as_bytes() {
                        band.take(&key, text.trim());
                    }
                    key.clear();
                }
                // A text that ends in the middle of an element is cut off.
                Event::Eof => return (open == 0).then_some(band),
                _ => (),
            }
        }
    }

    /// Names what is not read, once.
    fn leave(&mut self, what: String) {
        if !self.unread.contains(&what) && self.unread.len() < MOST_UNREAD {
            self.unread.push(what);
        }
    }

    fn take(&mut self, key: &str, text: &str) {
        let number = text.parse::<f64>().ok();
        let finite = number.filter(|v| v.is_finite());
        let is_read = match key {
            "NoDataValue" => {
                self.nodata = finite;
                // What is not finite is a void without a word.
                number.is_some()
            }
            "Scale" => {
                self.scale = finite.filter(|v| *v != 0.0);
                self.scale.is_some()
            }
            "Offset" => {
                self.offset = finite;
                finite.is_some()
            }
            "UnitType" => {
                self.unit = text.to_owned();
                true
            }
            _ => true,
        };
        if !is_read {
            let brief: String = text.chars().take(30).collect();
            self.leave(format!("`{key}` \"{brief}\""));
        }
    }
}

/// Whether an element is that of a band; one without a number is the first.
fn is_band(tag: &BytesStart<'_>, number: u64) -> bool {
    let attribute = tag.try_get_attribute("band").ok().flatten();
    let value =
        attribute.and_then(|a| a.normalized_value(XmlVersion::Implicit1_0).ok().map(|v| v.into_owned()));
    value.and_then(|v| v.trim().parse().ok()).unwrap_or(1) == number
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_is_found_by_its_number() {
        let xml = r#"<PAMDataset><Metadata><MDI key="x">1</MDI></Metadata>
            <PAMRasterBand band="1"><NoDataValue le_hex_equiv="00">-9.999E3</NoDataValue><UnitType>ft</UnitType></PAMRasterBand>
            <PAMRasterBand band="2"><Offset>5</Offset><Scale>0.1</Scale></PAMRasterBand></PAMDataset>"#;
        let first = Band { nodata: Some(-9999.0), unit: "ft".into(), ..Band::default() };
        assert_eq!(Band::parse(xml, 1), Some(first));
        let second = Band { scale: Some(0.1), offset: Some(5.0), ..Band::default() };
        assert_eq!(Band::parse(xml, 2), Some(second));
        assert_eq!(Band::parse(xml, 3), Some(Band::default()));
        assert_eq!(Band::parse("<PAMDataset></x>", 1), None);
        assert_eq!(Band::parse(r#"<PAMDataset><PAMRasterBand band="1">"#, 1), None);
    }

    #[test]
    fn what_is_not_read_is_named() {
        let xml = r#"<PAMDataset><SRS>PROJCS["x"]</SRS><PAMRasterBand band="1"><Scale>nan</Scale>
            <Offset>2</Offset><NoDataValue>zz</NoDataValue></PAMRasterBand></PAMDataset>"#;
        let band = Band::parse(xml, 1).expect("parses");
        assert_eq!(band.unread, ["the `SRS`", "`Scale` \"nan\"", "`NoDataValue` \"zz\""]);
        assert_eq!(band.offset, Some(2.0));
        let void = "<PAMRasterBand><NoDataValue>nan</NoDataValue></PAMRasterBand>";
        assert!(Band::parse(void, 1).expect("parses").unread.is_empty());
    }
}
