//! A height file on the way in: its content, what lies beside it, and how it is to be read.

use rayon::prelude::*;

use super::beside;
use super::codec::{Codec, LONGEST_MAGIC};
use super::error::{Fault, ReadError};
use super::height::{HeightFile, Limits};
use super::pam;
use super::place::{FARTHEST_NORTH, Units};
use super::reading::Reading;
use super::sidecar::Sidecar;
use super::suspect::suspects;
use super::voids::strike;
use crate::source::{HEAD_BYTES, ReadAt};
use crate::work::Work;

/// A file that lies beside a height file.
#[derive(Clone, Copy, Debug)]
pub struct Companion<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its content.
    pub bytes: &'a [u8],
}

/// The names of the files that may lie beside a file and are looked at as well: `dir/a.json` beside `dir/a.r16`, and
/// what GDAL writes beside files of all kinds, `dir/a.r16.aux.xml`.
pub fn companions(file: &str) -> Vec<String> {
    let stem = match file.rsplit_once('.') {
        Some((stem, extension)) if !extension.contains(['/', '\\']) => stem,
        _ => file,
    };
    let extensions = Codec::of_name(file).map_or(&[][..], |c| c.companions);
    let own = extensions.iter().map(|e| format!("{stem}.{e}"));
    own.chain(pam::BESIDE.iter().map(|e| format!("{file}.{e}"))).collect()
}

/// What a header says of the content behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Claim {
    /// Samples in a row.
    pub cols: u64,
    /// Rows.
    pub rows: u64,
    /// Bytes of memory that reading takes at the peak, the heights among them.
    pub bytes: u64,
}

impl Claim {
    /// A claim whose reading takes the heights and some bytes more, once it is within the limits.
    pub(super) fn new(input: &Input<'_>, size: [u64; 2], more: u64) -> Result<Self, Fault> {
        let [cols, rows] = size;
        let samples = input.limits.samples(cols, rows)? as u64;
        Ok(Self { cols, rows, bytes: samples.saturating_mul(4).saturating_add(more) })
    }
}

/// A height file to read.
#[derive(Clone, Copy)]
pub struct Input<'a> {
    /// The name: its extension chooses the reader, and that of an SRTM tile says where it lies.
    pub name: &'a str,
    /// The content.
    pub bytes: &'a dyn ReadAt,
    /// What lies beside it; see [`companions`].
    pub companions: &'a [Companion<'a>],
    /// How it is read.
    pub reading: &'a Reading,
    /// The most that it may claim.
    pub limits: &'a Limits,
    /// Who wants to know how far the reading is.
    pub work: Work<'a>,
}

impl<'a> Input<'a> {
    /// The content of a companion by its extension.
    pub(super) fn companion(&self, extension: &str) -> Option<&'a [u8]> {
        let fits = |c: &&Companion<'_>| {
            let name = c.name.to_ascii_lowercase();
            name.strip_suffix(extension).is_some_and(|rest| rest.ends_with('.'))
        };
        self.companions.iter().find(fits).map(|c| c.bytes)
    }

    /// What the sidecar says; nothing where there is none, or another file's.
    pub(super) fn sidecar(&self) -> Result<Sidecar, Fault> {
        beside::read(self.name, self.companion("json"))
    }

    /// The first bytes of the content.
    pub(super) fn head(&self) -> Result<Vec<u8>, Fault> {
        let mut head = vec![0; self.bytes.len().min(HEAD_BYTES) as usize];
        self.bytes.read_at(0, &mut head)?;
        Ok(head)
    }

    /// What the header claims, within the limits.
    ///
    /// # Errors
    /// Those of [`read`](Self::read) that show before the first sample.
    pub fn claim(&self) -> Result<Claim, ReadError> {
        let claim = || {
            let claim = (self.codec()?.claim)(self)?;
            Ok(Claim { bytes: claim.bytes.saturating_add(pam::bytes(self, &claim)), ..claim })
        };
        claim().map_err(|fault: Fault| fault.of(self.name))
    }

    /// Reads the heights.
    ///
    /// # Errors
    /// What is wrong with the file; a size over the limits is refused before memory is taken.
    pub fn read(&self) -> Result<HeightFile, ReadError> {
        self.read_checked().map_err(|fault| fault.of(self.name))
    }

    /// The kind of file, by its name and its first bytes.
    fn codec(&self) -> Result<&'static Codec, Fault> {
        let mut head = [0; LONGEST_MAGIC];
        let count = self.bytes.len().min(LONGEST_MAGIC as u64) as usize;
        self.bytes.read_at(0, &mut head[..count])?;
        Codec::of(self.name, &head[..count])
    }

    fn read_checked(&self) -> Result<HeightFile, Fault> {
        let codec = self.codec()?;
        self.work.check()?;
        (codec.claim)(self)?;
        let mut file = (codec.read)(self)?;
        self.work.check()?;
        // A person's number is the one that the file holds: readers that scale have struck it before they did.
        if file.origin.plain {
            strike(&mut file.data, self.reading.nodata);
        }
        // Until here `nodata` is the word of the file alone: what a person says stands beside that of an `.aux.xml`.
        pam::apply(self, &mut file)?;
        on_the_globe(&mut file);
        // One rule for all formats, on the numbers as they are kept: what is read once reads the same again.
        let is_height = |v: &f32| v.abs() <= FARTHEST;
        file.data.par_chunks_mut(1 << 16).for_each(|chunk| {
            chunk.iter_mut().filter(|v| !is_height(v)).for_each(|v| *v = f32::NAN);
        });
        self.work.check()?;
        // Files often hold a second mark of voids beside the one that they name: what is left is looked at as well.
        let plain = file.origin.plain;
        let notes = suspects(&file.data, file.metres).into_iter().map(|s| s.note(plain));
        file.origin.notes.extend(notes);
        file.origin.nodata = file.origin.nodata.or(self.reading.nodata);
        Ok(file)
    }
}

/// Leaves the cell unknown where coordinates are degrees by the word of their system, and lie off the globe.
fn on_the_globe(file: &mut HeightFile) {
    let HeightFile { cols, rows, ref mut placement, ref mut origin, .. } = *file;
    let Some(affine) = placement.affine.filter(|_| placement.units == Units::Degrees) else { return };
    let ends = [0.0, cols as f64].into_iter().flat_map(|i| [0.0, rows as f64].map(|j| affine.at(i, j)));
    let is_off = |[x, y]: &[f64; 2]| x.abs() > FARTHEST_EAST || y.abs() > FARTHEST_NORTH;
    let Some([x, y]) = ends.into_iter().find(is_off) else { return };
    placement.cell = None;
    origin.notes.push(format!(
        "its system counts in degrees, and {x}, {y} is no place on the globe: how far apart its samples are is not known"
    ));
}

/// The farthest longitude that a file may have, in degrees: one that counts from 0 to 360 and goes on over the
/// antimeridian by half the globe, with a degree for the cell around the last sample.
const FARTHEST_EAST: f64 = 360.0 + 180.0 + 1.0;
/// Numbers beyond it mark voids in many files; no height is near it.
const FARTHEST: f32 = 1e30;
