//! The first directory of a TIFF file, every entry checked to lie within the file.

use super::super::error::Fault;
use super::tag;

/// A directory: its entries, in the order of the file.
#[derive(Debug)]
pub(super) struct Directory<'a> {
    little: bool,
    entries: Vec<Entry<'a>>,
}

/// An entry and its value's bytes.
#[derive(Clone, Copy, Debug)]
struct Entry<'a> {
    tag: u16,
    kind: u16,
    bytes: &'a [u8],
}

/// Bytes of a number of each type, by its code in the file.
fn width(kind: u16) -> Option<usize> {
    Some(match kind {
        1 | 2 | 6 | 7 => 1,
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16 | 17 | 18 => 8,
        _ => return None,
    })
}

fn part<'a>(bytes: &'a [u8], at: u64, len: u64, what: &'static str) -> Result<&'a [u8], Fault> {
    let end = at.checked_add(len).filter(|e| *e <= bytes.len() as u64);
    let short = Fault::Short { what, want: at.saturating_add(len), found: bytes.len() as u64 };
    end.map(|e| &bytes[at as usize..e as usize]).ok_or(short)
}

fn number(little: bool, bytes: &[u8]) -> u64 {
    let shift = |sum: u64, b: &u8| sum << 8 | u64::from(*b);
    if little { bytes.iter().rev().fold(0, shift) } else { bytes.iter().fold(0, shift) }
}

impl<'a> Directory<'a> {
    /// Reads the header and the first directory.
    pub(super) fn first(bytes: &'a [u8]) -> Result<Self, Fault> {
        let header = part(bytes, 0, 8, "the header")?;
        let little = header[0] == b'I';
        let number = |b: &[u8]| number(little, b);
        let big = number(&header[2..4]) == 43;
        let at = if big { number(part(bytes, 8, 8, "the header")?) } else { number(&header[4..8]) };
        let (count_len, entry_len, inline) = if big { (8, 20, 8) } else { (2, 12, 4) };
        let count = number(part(bytes, at, count_len, "a directory")?);
        let length = count.saturating_mul(entry_len);
        let table = part(bytes, at + count_len, length, "a directory")?;
        let mut entries = Vec::new();
        for raw in table.chunks_exact(entry_len as usize) {
            let (tag, kind) = (number(&raw[..2]) as u16, number(&raw[2..4]) as u16);
            // What is of no known type is of no use here.
            let Some(width) = width(kind) else { continue };
            let value = raw.len() - inline;
            let length = number(&raw[4..value]).saturating_mul(width as u64);
            let bytes = if length <= inline as u64 {
                &raw[value..][..length as usize]
            } else {
                match part(bytes, number(&raw[value..]), length, "a value") {
                    Ok(found) => found,
                    Err(fault) if tag::READ.contains(&tag) => return Err(fault),
                    // Of the tags that other programs leave, a damaged one does no harm here.
                    Err(_) => continue,
                }
            };
            entries.push(Entry { tag, kind, bytes });
        }
        Ok(Self { little, entries })
    }

    /// Whether numbers are little-endian.
    pub(super) fn little(&self) -> bool {
        self.little
    }

    fn find(&self, tag: u16) -> Option<&Entry<'a>> {
        self.entries.iter().find(|e| e.tag == tag)
    }

    /// The whole numbers of a tag, by index.
    pub(super) fn numbers(&self, tag: u16) -> Option<Numbers<'a>> {
        let e = self.find(tag)?;
        let whole = matches!(e.kind, 1 | 3 | 4 | 6 | 7 | 8 | 9 | 13 | 16 | 17 | 18);
        whole.then(|| Numbers { little: self.little, width: width(e.kind).unwrap_or(1), bytes: e.bytes })
    }

    /// The first whole number of a tag.
    pub(super) fn number(&self, tag: u16) -> Option<u64> {
        self.numbers(tag)?.get(0)
    }

    /// The floating numbers of a tag.
    pub(super) fn doubles(&self, tag: u16) -> Option<Vec<f64>> {
        let e = self.find(tag).filter(|e| e.kind == 12)?;
        Some(e.bytes.chunks_exact(8).map(|b| f64::from_bits(number(self.little, b))).collect())
    }

    /// The text of a tag, without zeros at its end.
    pub(super) fn text(&self, tag: u16) -> Option<String> {
        let e = self.find(tag).filter(|e| e.kind == 2)?;
        let end = e.bytes.iter().position(|b| *b == 0).unwrap_or(e.bytes.len());
        Some(String::from_utf8_lossy(&e.bytes[..end]).into_owned())
    }
}

/// Whole numbers, read where they lie.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbers<'a> {
    little: bool,
    width: usize,
    bytes: &'a [u8],
}

impl Numbers<'_> {
    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.bytes.len() / self.width
    }

    /// One of them.
    pub(super) fn get(&self, i: usize) -> Option<u64> {
        let at = i.checked_mul(self.width)?;
        Some(number(self.little, self.bytes.get(at..at + self.width)?))
    }
}
