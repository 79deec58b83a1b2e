//! The terrain that a file fits: its sides, and a base grid that divides both.

use crate::value::{MAX_BASE, MAX_EXTENT, MIN_SIZE, Terrain};

/// Sides and base grid of a terrain that a file fits.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Fit {
    /// East-west extent, in metres.
    pub width: f64,
    /// North-south extent, in metres.
    pub depth: f64,
    /// Samples along the longer side of the base grid.
    pub base: u32,
    /// What of the file lies outside, east-west and north-south, in metres: less than a base cell, and nothing where
    /// a base grid near the wished one divides both sides.
    pub cropped: [f64; 2],
}

impl Fit {
    /// The terrain for a file of some extent in metres, with a base grid near one of `base` samples: from half to
    /// twice as many along the longer side.
    ///
    /// # Errors
    /// A sentence when no terrain is so large, so small or so narrow.
    pub fn of([width, depth]: [f64; 2], base: u32) -> Result<Self, String> {
        if ![width, depth].iter().all(|v| (1.0..=MAX_EXTENT).contains(v)) {
            return Err(format!(
                "a terrain is from 1 to {MAX_EXTENT} m wide and deep, the file {width} x {depth} m"
            ));
        }
        let base = base.clamp(MIN_SIZE, MAX_BASE);
        let terrain = Terrain { width, depth, ..Terrain::default() };
        let fits = |n: &u32| (MIN_SIZE..=MAX_BASE).contains(n) && terrain.grid(*n).is_ok();
        // The nearest first, of two as near the finer.
        let near = (0..base).flat_map(|away| [base.checked_add(away), base.checked_sub(away)]).flatten();
        let near = near.filter(|n| (base.div_ceil(2)..=base.saturating_mul(2)).contains(n));
        if let Some(base) = near.into_iter().find(fits) {
            return Ok(Self { width, depth, base, cropped: [0.0; 2] });
        }
        Self::cropped(terrain, base)
    }

    /// The terrain whose shorter side is cut to a whole number of base cells.
    fn cropped(file: Terrain, base: u32) -> Result<Self, String> {
        let Terrain { width, depth, .. } = file;
        let cell = file.span() / f64::from(base - 1);
        let steps = (width.min(depth) / cell).floor();
        if steps < 1.0 {
            return Err(format!(
                "{width} x {depth} m is narrower than a cell of a base grid of {base} samples, {cell} m; ask for more \
                 samples with --base"
            ));
        }
        // As one division of an exact product, so that the cell divides the side to the last bit or two.
        let short = file.span() * steps / f64::from(base - 1);
        let (width, depth) = if width >= depth { (width, short) } else { (short, depth) };
        Ok(Self { width, depth, base, cropped: [file.width - width, file.depth - depth] })
    }

    /// Whether nothing of the file lies outside.
    pub fn is_exact(&self) -> bool {
        self.cropped == [0.0; 2]
    }

    /// What lies outside, as a sentence.
    pub fn loss(&self) -> Option<String> {
        let [x, y] = self.cropped;
        let (loss, way, of) =
            if x > 0.0 { (x, "west to east", self.width + x) } else { (y, "north to south", self.depth + y) };
        (!self.is_exact()).then(|| {
            format!(
                "no base grid near {} samples divides both sides: {loss:.3} of {of:.3} m from {way} are cropped, less \
                 than a base cell",
                self.base
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(cols: u32, rows: u32, cell: [f64; 2], base: u32) -> Fit {
        Fit::of([f64::from(cols - 1) * cell[0], f64::from(rows - 1) * cell[1]], base).expect("fits")
    }

    #[test]
    fn files_of_square_cells_fit_to_the_metre() {
        let found = fit(1197, 643, [30.0, 30.0], 1025);
        assert_eq!(found, Fit { width: 35_880.0, depth: 19_260.0, base: 1197, cropped: [0.0; 2] });
        // 97 x 56 is the smallest base grid in proportion; eleven times that is nearest to 1025.
        assert_eq!(fit(4269, 2465, [90.0, 90.0], 1025).base, 1068);
        assert_eq!(fit(2465, 4269, [90.0, 90.0], 1025).base, 1068);
        assert_eq!(fit(1025, 513, [8.0, 8.0], 1025).base, 1025);
    }

    #[test]
    fn what_divides_nothing_is_cropped_by_less_than_a_cell() {
        for (cols, rows, cell) in [
            (32, 24, [57.24, 92.72]),
            (1201, 1201, [65.37, 92.71]),
            (1009, 2003, [7.1, 3.37]),
            (17, 1013, [1.0, 1.7]),
        ] {
            let found = fit(cols, rows, cell, 1025);
            let [x, y] = found.cropped;
            let size = f64::from(found.base - 1);
            let step = found.width.max(found.depth) / size;
            assert!(x.min(y) == 0.0 && x.max(y) > 0.0 && x.max(y) < step, "{found:?}");
            let terrain =
                Terrain { width: found.width, depth: found.depth, base: found.base, ..Terrain::default() };
            assert_eq!(terrain.fault(), None, "{found:?}");
            assert!(found.loss().is_some());
        }
    }

    #[test]
    fn what_is_no_terrain_is_refused() {
        for extent in [[0.0, 5.0], [f64::NAN, 5.0], [3e7, 5.0], [2e7, 1.0], [f64::INFINITY, 10.0]] {
            let error = Fit::of(extent, 1025).expect_err("no terrain");
            assert!(error.contains("m"), "{error}");
        }
    }
}
