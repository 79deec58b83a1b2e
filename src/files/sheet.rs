//! The samples that a writer puts into a file, and the checks that all writers share.

use std::io::{Seek, Write};

use rayon::prelude::*;

use super::bands::{self, Band, Split};
use super::codec::Format;
use super::error::WriteError;
use super::place::Placement;
use super::quantize::Quantizer;
use super::sidecar::{FirstRow, Sidecar};
use super::target::target_warnings;
use super::write::{Writing, Written};
use crate::value::Quantity;

/// The destination of a file.
pub trait Sink: Write + Seek {}

impl<T: Write + Seek> Sink for T {}

/// The samples of a file that is being written.
pub(super) struct Sheet<'a> {
    pub(super) cols: usize,
    pub(super) rows: usize,
    pub(super) channels: usize,
    pub(super) samples: &'a [f32],
    pub(super) quantity: Quantity,
    pub(super) placement: Placement,
    pub(super) nodata: Option<f64>,
    pub(super) sidecar: Sidecar,
    pub(super) writing: Writing<'a>,
}

impl Sheet<'_> {
    /// Writes the file; returns the content of its sidecar, among others.
    pub(super) fn write(&self, out: &mut dyn Sink) -> Result<Written, WriteError> {
        let format = self.writing.format;
        let form = format.form();
        if self.cols == 0 || self.rows == 0 {
            return Err(unfit(format, "no samples at all", "ask for a size of at least 1 x 1"));
        }
        if !format.takes(self.channels) {
            let what = format!("{} numbers a sample", self.channels);
            return Err(unfit(format, what, Format::which(|f| f.channels.contains(&self.channels))));
        }
        if self.writing.flip && !form.flips {
            return Err(unfit(format, "rows from south to north", Format::which(|f| f.flips)));
        }
        let mut written = (form.write)(self, out)?;
        if format.has_sidecar(self.channels) {
            let sidecar = self.sidecar(written.range);
            // A struct of numbers and names always turns into JSON.
            written.sidecar = Some(serde_json::to_value(sidecar).unwrap_or_default());
        }
        if let Some(target) = self.writing.target {
            let cell = self.placement.cell.unwrap_or([1.0; 2]);
            written.notes.extend(target_warnings(target, format, self.cols, self.rows));
            written.notes.extend(target.notes(written.range, cell, [self.cols, self.rows]));
        }
        Ok(written)
    }

    fn sidecar(&self, range: Option<[f64; 2]>) -> Sidecar {
        Sidecar {
            orograph: Some(1),
            format: self.writing.format.name().into(),
            cols: Some(self.cols as u64),
            rows: Some(self.rows as u64),
            quantity: self.quantity.name().into(),
            unit: self.quantity.unit().into(),
            range,
            rows_from: if self.writing.flip { FirstRow::South } else { FirstRow::North },
            file: self.writing.file.into(),
            ..self.sidecar.clone()
        }
        .with_steps(self.placement.cell)
    }

    /// The samples of a row of the file.
    pub(super) fn row(&self, j: usize) -> &[f32] {
        let j = if self.writing.flip { self.rows - 1 - j } else { j };
        let line = self.cols * self.channels;
        &self.samples[j * line..][..line]
    }

    pub(super) fn has_voids(&self) -> bool {
        self.samples.par_chunks(1 << 16).any(|c| c.iter().any(|v| v.is_nan()))
    }

    /// Refuses voids where the format cannot mark them.
    pub(super) fn no_voids(&self) -> Result<(), WriteError> {
        if !self.has_voids() {
            return Ok(());
        }
        let own = self.writing.format.name();
        let others = Format::which(|f| f.voids && f.name != own);
        let instead =
            format!("fill them, as `orograph convert --fill` does, or choose another format: {others}");
        Err(unfit(self.writing.format, "voids", instead))
    }

    /// The range of the options, or that of the quantity.
    pub(super) fn own_range(&self) -> Option<[f64; 2]> {
        let range = self.writing.range;
        match self.quantity {
            Quantity::Color => Some([0.0, 1.0]),
            Quantity::Mask => range.or(Some([0.0, 1.0])),
            Quantity::Direction => range.or(Some([0.0, 360.0])),
            Quantity::Slope => range.or(Some([0.0, 90.0])),
            _ => range,
        }
    }

    /// The conversion of the samples to integers, after a check of all samples, with the number that are clipped.
    pub(super) fn quantizer(&self) -> Result<(Quantizer, Written), WriteError> {
        let format = self.writing.format;
        let unit = if self.quantity.unit() == "1" { "value" } else { self.quantity.unit() };
        let range = self.own_range().ok_or(WriteError::NoRange { format: format.name(), unit })?;
        let q = Quantizer::new(range, format.levels().unwrap_or(65535.0))?;
        let clipped = q.check(self.samples, self.writing.clip)?;
        Ok((q, Written { clipped, range: Some(range), ..Written::default() }))
    }

    /// Writes rows of numbers with the same number of bytes each, without a header.
    pub(super) fn plain_rows(
        &self,
        out: &mut dyn Sink,
        bytes: usize,
        fill: impl Fn(&[f32], &mut [u8]) + Sync,
    ) -> Result<(), WriteError> {
        let line = self.cols * bytes;
        let make = |band: Band| {
            let mut block = vec![0; band.rows * line];
            for (j, line) in block.chunks_exact_mut(line).enumerate() {
                fill(self.row(band.first_row + j), line);
            }
            block
        };
        let split = Split::new(self.rows, line);
        bands::in_order(&split, &self.writing.work, make, |_, block| out.write_all(&block))
    }
}

/// The error that a format cannot hold something, with an alternative.
pub(super) fn unfit(format: Format, what: impl Into<String>, instead: impl Into<String>) -> WriteError {
    WriteError::Unfit { format: format.name(), what: what.into(), instead: instead.into() }
}

/// Writes a row of integers, little-endian.
pub(super) fn little_words(line: &mut [u8], row: &[f32], of: impl Fn(f32) -> u16) {
    let (words, _) = line.as_chunks_mut::<2>();
    words.iter_mut().zip(row).for_each(|(o, v)| *o = of(*v).to_le_bytes());
}

/// Writes a row of floats, little-endian, with a number for voids.
pub(super) fn little_floats(line: &mut [u8], row: &[f32], void: f32) {
    let (words, _) = line.as_chunks_mut::<4>();
    words.iter_mut().zip(row).for_each(|(o, &v)| *o = (if v.is_nan() { void } else { v }).to_le_bytes());
}
