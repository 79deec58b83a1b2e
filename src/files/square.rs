//! Heights on cells that are not square, brought onto square ones to be drawn.

use super::height::{HeightFile, Limits};
use crate::kit::spline::Spline;

/// How many times longer than wide a cell may be.
const MOST_OBLONG: f64 = 16.0;

/// Heights on square cells.
#[derive(Clone, Debug, PartialEq)]
pub struct Squared {
    /// Samples in a row.
    pub cols: usize,
    /// Rows.
    pub rows: usize,
    /// The heights, row by row.
    pub data: Vec<f32>,
    /// Distance between samples, in metres; none where the file does not say.
    pub cell: Option<f64>,
}

impl Squared {
    /// Brings a file without voids onto square cells, as fine as its finer side, by a spline through its samples. A
    /// picture of `width` columns gets as many samples at least, so that its sides are in proportion to the pixel.
    ///
    /// # Errors
    /// A sentence when the cells are too far from square, or there would be too many.
    pub fn of(file: HeightFile, width: Option<usize>, limits: &Limits) -> Result<Self, String> {
        let HeightFile { cols, rows, data, placement, .. } = file;
        let Some([dx, dy]) = placement.cell else { return Ok(Self { cols, rows, data, cell: None }) };
        if cols < 2 || rows < 2 {
            return Ok(Self { cols, rows, data, cell: Some((dx * dy).sqrt()) });
        }
        let [east, south] = [dx * (cols - 1) as f64, dy * (rows - 1) as f64];
        let oblong = (dx / dy).max(dy / dx);
        if oblong < 1.0 + 0.5 / cols.max(rows) as f64 {
            // Not half a sample off over the whole file.
            return Ok(Self { cols, rows, data, cell: Some((dx * dy).sqrt()) });
        }
        if oblong > MOST_OBLONG {
            return Err(format!(
                "cells of {dx} x {dy} m are too far from square to be drawn: one side may be {MOST_OBLONG} times as long as \
                 the other at most"
            ));
        }
        let wide = if dx > dy { (rows as f64 * east / south).round() } else { cols as f64 };
        let wide = wide.max(width.unwrap_or(0).min(4096) as f64).max(2.0);
        let deep = (wide * south / east).round().max(2.0);
        let total = limits.samples(wide as u64, deep as u64).map_err(|fault| fault.to_string())?;
        let (wide, deep) = (wide as usize, deep as usize);
        let spline = Spline::fit(cols, rows, &data);
        drop(data);
        let at = |k: usize, of: usize, last: usize| last as f64 * k as f64 / (of - 1) as f64;
        let taps = spline.taps((0..wide).map(|i| at(i, wide, cols - 1)));
        let mut squared = vec![0.0; total];
        for (j, line) in squared.chunks_exact_mut(wide).enumerate() {
            spline.row(at(j, deep, rows - 1), &taps, line);
        }
        Ok(Self { cols: wide, rows: deep, data: squared, cell: Some(east / (wide - 1) as f64) })
    }
}
