//! The directories of a TIFF file, every entry checked to lie within the file, values read when they are asked for.

use super::super::error::Fault;
use super::super::height::room;
use crate::source::ReadAt;

/// Most directories that are looked at: pictures, masks and overviews of one file.
const MOST_DIRECTORIES: usize = 128;
/// Most entries of a directory that are looked at.
const MOST_ENTRIES: u64 = 4096;

/// A file, and how its numbers are written.
#[derive(Clone, Copy)]
pub(super) struct File<'a> {
    pub(super) bytes: &'a dyn ReadAt,
    /// Whether numbers are little-endian.
    pub(super) little: bool,
    /// Whether it is a BigTIFF.
    big: bool,
}

/// A directory: its entries, in the order of the file.
pub(super) struct Directory<'a> {
    pub(super) file: File<'a>,
    entries: Vec<Entry>,
    /// Where the next directory lies; 0 after the last.
    next: u64,
}

/// An entry, and its value or where that lies.
#[derive(Clone, Copy, Debug)]
struct Entry {
    tag: u16,
    kind: u16,
    count: u64,
    field: [u8; 8],
}

/// Bytes of a number of each type, by its code in the file.
fn width(kind: u16) -> Option<u64> {
    Some(match kind {
        1 | 2 | 6 | 7 => 1,
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16 | 17 | 18 => 8,
        _ => return None,
    })
}

/// A whole number of some bytes.
fn number(little: bool, bytes: &[u8]) -> u64 {
    let shift = |sum: u64, b: &u8| sum << 8 | u64::from(*b);
    if little { bytes.iter().rev().fold(0, shift) } else { bytes.iter().fold(0, shift) }
}

impl<'a> File<'a> {
    /// Reads the header; gives where the first directory lies.
    fn open(bytes: &'a dyn ReadAt) -> Result<(Self, u64), Fault> {
        let mut file = Self { bytes, little: true, big: false };
        let header = file.part(0, 8, "the header")?;
        file.little = header[0] == b'I';
        file.big = number(file.little, &header[2..4]) == 43;
        let at = if file.big {
            number(file.little, &file.part(8, 8, "the header")?)
        } else {
            number(file.little, &header[4..8])
        };
        Ok((file, at))
    }

    /// Some bytes of the file.
    pub(super) fn part(&self, at: u64, len: u64, what: &'static str) -> Result<Vec<u8>, Fault> {
        let mut part = Vec::new();
        self.read(at, len, what, &mut part)?;
        Ok(part)
    }

    /// Reads some bytes of the file into a buffer.
    pub(super) fn read(
        &self,
        at: u64,
        len: u64,
        what: &'static str,
        buffer: &mut Vec<u8>,
    ) -> Result<(), Fault> {
        let found = self.bytes.len();
        if at.checked_add(len).is_none_or(|end| end > found) {
            return Err(Fault::Short { what, want: at.saturating_add(len), found });
        }
        // What lies within a file in memory fits into memory; a file on a disk may not.
        let len = usize::try_from(len).map_err(|_| Fault::NoMemory { bytes: len })?;
        buffer.clear();
        buffer.try_reserve_exact(len).map_err(|_| Fault::NoMemory { bytes: len as u64 })?;
        buffer.resize(len, 0);
        self.bytes.read_at(at, buffer).map_err(Fault::from)
    }
}

impl<'a> Directory<'a> {
    /// The first directory.
    pub(super) fn first(bytes: &'a dyn ReadAt) -> Result<Self, Fault> {
        let (file, at) = File::open(bytes)?;
        Self::read(file, at)
    }

    /// The directories behind this one, as far as they can be read; the first has to be.
    pub(super) fn others(&self) -> Vec<Self> {
        let (mut found, mut next, mut seen) = (Vec::<Self>::new(), self.next, Vec::new());
        while next != 0 && found.len() < MOST_DIRECTORIES && !seen.contains(&next) {
            seen.push(next);
            let Ok(directory) = Self::read(self.file, next) else { break };
            next = directory.next;
            found.push(directory);
        }
        found
    }

    fn read(file: File<'a>, at: u64) -> Result<Self, Fault> {
        let (count_len, entry_len, inline) = if file.big { (8, 20, 8) } else { (2, 12, 4) };
        let count = number(file.little, &file.part(at, count_len, "a directory")?);
        if count > MOST_ENTRIES {
            return Err(Fault::Damaged(format!(
                "a directory of {count} entries; the limit is {MOST_ENTRIES}"
            )));
        }
        let table = file.part(at + count_len, count * entry_len, "a directory")?;
        let mut entries = Vec::with_capacity(count as usize);
        for raw in table.chunks_exact(entry_len as usize) {
            let (tag, kind) = (number(file.little, &raw[..2]) as u16, number(file.little, &raw[2..4]) as u16);
            let (head, value) = raw.split_at(raw.len() - inline);
            let mut field = [0; 8];
            field[..inline].copy_from_slice(value);
            entries.push(Entry { tag, kind, count: number(file.little, &head[4..]), field });
        }
        // A file may end without the word that there is no other directory.
        let word = inline as u64;
        let next = file.part(at + count_len + count * entry_len, word, "a directory");
        let next = next.map_or(0, |word| number(file.little, &word));
        Ok(Self { file, entries, next })
    }

    fn find(&self, tag: u16) -> Option<&Entry> {
        // What is of no known type is of no use here.
        self.entries.iter().find(|e| e.tag == tag && width(e.kind).is_some())
    }

    fn bytes(&self, e: &Entry) -> Result<Vec<u8>, Fault> {
        let length = e.count.saturating_mul(width(e.kind).unwrap_or(1));
        let inline = if self.file.big { 8 } else { 4 };
        if length <= inline {
            let mut value = room(length as usize)?;
            value.extend_from_slice(&e.field[..length as usize]);
            return Ok(value);
        }
        self.file.part(number(self.file.little, &e.field[..inline as usize]), length, "a value")
    }

    /// How many values a tag has.
    pub(super) fn count(&self, tag: u16) -> Option<u64> {
        self.find(tag).map(|e| e.count)
    }

    /// The whole numbers of a tag.
    pub(super) fn numbers(&self, tag: u16) -> Result<Option<Numbers>, Fault> {
        let whole = |e: &&Entry| matches!(e.kind, 1 | 3 | 4 | 6 | 7 | 8 | 9 | 13 | 16 | 17 | 18);
        let Some(e) = self.find(tag).filter(whole) else { return Ok(None) };
        let width = width(e.kind).unwrap_or(1) as usize;
        Ok(Some(Numbers { little: self.file.little, width, bytes: self.bytes(e)? }))
    }

    /// The first whole number of a tag.
    pub(super) fn number(&self, tag: u16) -> Result<Option<u64>, Fault> {
        Ok(self.numbers(tag)?.and_then(|n| n.get(0)))
    }

    /// The floating numbers of a tag.
    pub(super) fn doubles(&self, tag: u16) -> Result<Option<Vec<f64>>, Fault> {
        let Some(e) = self.find(tag).filter(|e| e.kind == 12) else { return Ok(None) };
        let of = |b: &[u8]| f64::from_bits(number(self.file.little, b));
        Ok(Some(self.bytes(e)?.chunks_exact(8).map(of).collect()))
    }

    /// The text of a tag, without zeros at its end.
    pub(super) fn text(&self, tag: u16) -> Result<Option<String>, Fault> {
        let Some(e) = self.find(tag).filter(|e| e.kind == 2) else { return Ok(None) };
        let bytes = self.bytes(e)?;
        let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
        Ok(Some(String::from_utf8_lossy(&bytes[..end]).into_owned()))
    }
}

/// Whole numbers, as they stand in the file.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    little: bool,
    width: usize,
    bytes: Vec<u8>,
}

impl Numbers {
    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.bytes.len() / self.width
    }

    /// One of them.
    pub(super) fn get(&self, i: usize) -> Option<u64> {
        let at = i.checked_mul(self.width)?;
        Some(number(self.little, self.bytes.get(at..at + self.width)?))
    }

    /// Whether they are all the same.
    pub(super) fn same(&self) -> bool {
        (1..self.len()).all(|i| self.get(i) == self.get(0))
    }
}
