//! Carrying results of the base grid to other grids (law 3).

use std::borrow::Cow;

use crate::kit::rows::lerp;
use crate::kit::spline::{Spline, Tap, Taps};
use crate::name::Name;
use crate::node::{Context, Error, Result};
use crate::value::{Field, Grid, Lift, Quantity, Raster, Sample, Value};

/// A base-grid result on another grid: a cubic B-spline through the base samples, exact where the two grids share a
/// point; masks stay between 0 and 1, directions turn as vectors, labels come from the nearest sample. Beyond the
/// base grid its border value continues.
///
/// # Errors
/// [`Error::Cancelled`] when the work was asked to stop.
pub fn lift(cx: &Context<'_>, base: &Value) -> Result<Value> {
    Ok(match base {
        Value::Field(f) => Value::Field(lift_field(cx, f)?),
        Value::Vectors(v) => Value::Vectors(lift_channels(cx, v, |x| x)?),
        Value::Colors(c) => Value::Colors(lift_channels(cx, c, |x| x.clamp(0.0, 1.0))?),
        // Made for other global nodes, which read it where it stands.
        Value::Object(_) => base.clone(),
    })
}

/// What weighs the detail of a finer grid in what is carried to it.
pub(super) enum Keep<'a> {
    /// The same number everywhere.
    Number(f32),
    /// A field on the base grid.
    Field(&'a Field),
}

/// A change made on the base grid, applied to the field as it is on another grid:
/// `up(after) + keep · (fine − up(before))`. Where no base sample around a point changed, the fine field stays, bit for bit.
pub(super) fn carry(cx: &Context<'_>, [fine, before, after]: [&Value; 3], keep: Keep<'_>) -> Result<Value> {
    let (Value::Field(fine), Value::Field(before), Value::Field(after)) = (fine, before, after) else {
        return Err(Error::Output {
            port: Name::default(),
            message: "only fields carry a change to finer grids".into(),
        });
    };
    let base = after.grid();
    if base.contains(&cx.grid) {
        return Ok(Value::Field(after.crop(&cx.grid)));
    }
    let before = before.crop(base);
    let weighed = Weighed::new(&before, after, keep);
    let at = Positions::new(&cx.grid, base);
    let taps = weighed.spline().taps(at.cols.iter().copied());
    let fine = fine.crop(&cx.grid);
    let quantity = after.quantity();
    let out = cx.fill(quantity, |row, out: &mut [f32]| {
        let (v, fine) = (at.rows[row.j], fine.row(row.j));
        weighed.row(v, &taps, fine, out);
        let changed = ChangedRows::around(&before, after, v);
        for ((o, f), tap) in out.iter_mut().zip(fine).zip(taps.iter()) {
            *o = if changed.near(tap) { bounded(*o, quantity) } else { *f };
        }
    })?;
    Ok(Value::Field(out))
}

/// The sum that a carry makes of each sample.
enum Weighed {
    /// `keep · fine + up(after − keep · before)`, which is the sum where `keep` is a number.
    Number { keep: f32, rest: Spline },
    /// `up(after) + up(keep) · (fine − up(before))`.
    Field { after: Spline, before: Spline, keep: Spline, quantity: Quantity },
}

impl Weighed {
    fn new(before: &Field, after: &Field, keep: Keep<'_>) -> Self {
        let base = after.grid();
        let fit = |samples: &[f32]| Spline::fit(base.cols, base.rows, samples);
        match keep {
            Keep::Number(keep) => {
                let rest = |(a, b): (&f32, &f32)| a - keep * b;
                let rest: Vec<f32> = after.data().iter().zip(before.data()).map(rest).collect();
                Self::Number { keep, rest: fit(&rest) }
            }
            Keep::Field(keep) => Self::Field {
                after: fit(after.data()),
                before: fit(before.data()),
                keep: fit(keep.crop(base).data()),
                quantity: keep.quantity(),
            },
        }
    }

    /// A spline of the base grid; the taps of all of them are the same.
    fn spline(&self) -> &Spline {
        match self {
            Self::Number { rest: spline, .. } | Self::Field { after: spline, .. } => spline,
        }
    }

    fn row(&self, v: f64, taps: &Taps, fine: &[f32], out: &mut [f32]) {
        match self {
            Self::Number { keep, rest } => {
                rest.row(v, taps, out);
                out.iter_mut().zip(fine).for_each(|(o, f)| *o += keep * f);
            }
            Self::Field { after, before, keep, quantity } => {
                let (mut line, mut weight) = (vec![0.0; out.len()], vec![0.0; out.len()]);
                after.row(v, taps, out);
                before.row(v, taps, &mut line);
                keep.row(v, taps, &mut weight);
                for ((o, f), (b, k)) in out.iter_mut().zip(fine).zip(line.iter().zip(&weight)) {
                    *o += bounded(*k, *quantity) * (f - b);
                }
            }
        }
    }
}

/// The base rows whose change a position feels.
struct ChangedRows<'a> {
    rows: Vec<[&'a [f32]; 2]>,
}

impl<'a> ChangedRows<'a> {
    fn around(before: &'a Field, after: &'a Field, v: f64) -> Self {
        let rows = after.grid().rows;
        let first = Tap::at(v, rows).first;
        let touched = first.saturating_sub(1)..(first + 3).min(rows);
        Self { rows: touched.map(|r| [before.row(r), after.row(r)]).collect() }
    }

    /// Whether any of the samples next to a tap changed.
    fn near(&self, tap: &Tap) -> bool {
        let touches = |[before, after]: &[&[f32]; 2]| {
            let touched = tap.first.saturating_sub(1)..(tap.first + 3).min(before.len());
            before[touched.clone()] != after[touched]
        };
        self.rows.iter().any(touches)
    }
}

/// Where the samples of a grid stand in steps of the base grid.
struct Positions {
    cols: Vec<f64>,
    rows: Vec<f64>,
    /// Columns that the two grids share: of the grid, and of the base grid.
    shared: Vec<(usize, usize)>,
}

impl Positions {
    fn new(grid: &Grid, base: &Grid) -> Self {
        // Formed as `index · base intervals / intervals`, so that a shared point is a whole number exactly.
        let scale = |i: i64| i as f64 * f64::from(base.lattice.intervals) / f64::from(grid.lattice.intervals);
        let cols: Vec<_> = (grid.col..grid.col_end()).map(|c| scale(c) - base.col as f64).collect();
        let rows = (grid.row..grid.row_end()).map(|r| scale(r) - base.row as f64).collect();
        let shared = cols.iter().enumerate().filter_map(|(i, &u)| Some((i, whole(u, base.cols)?))).collect();
        Self { cols, rows, shared }
    }

    /// Puts the base samples themselves where the two grids share a point, free of the rounding of the weights.
    fn keep_shared_points<T: Sample>(&self, base: &Raster<T>, j: usize, out: &mut [T]) {
        let Some(r) = whole(self.rows[j], base.grid().rows) else { return };
        let row = base.row(r);
        for &(i, c) in &self.shared {
            out[i] = row[c];
        }
    }
}

/// The index that a position among `n` samples is, where it is one.
fn whole(position: f64, n: usize) -> Option<usize> {
    (position.fract() == 0.0 && position >= 0.0 && position < n as f64).then_some(position as usize)
}

fn lift_field(cx: &Context<'_>, base: &Field) -> Result<Field> {
    let quantity = base.quantity();
    match quantity.lift() {
        _ if base.grid().contains(&cx.grid) => Ok(base.crop(&cx.grid)),
        Lift::Nearest => nearest(cx, base),
        Lift::Turning => lift_direction(cx, base),
        Lift::Linear => linear(cx, base),
        Lift::Spline | Lift::Share => lift_channels(cx, base, |x| bounded(x, quantity)),
    }
}

fn bounded(x: f32, quantity: Quantity) -> f32 {
    match quantity.lift() {
        Lift::Share => x.clamp(0.0, 1.0),
        _ if quantity.may_be_negative() => x,
        _ => x.max(0.0),
    }
}

/// Linear between the four samples around a point; beyond the base grid its border value continues.
fn linear(cx: &Context<'_>, base: &Field) -> Result<Field> {
    let (grid, at) = (base.grid(), Positions::new(&cx.grid, base.grid()));
    let between = |p: f64, n: usize| {
        let p = p.clamp(0.0, (n - 1) as f64);
        let first = (p as usize).min(n.saturating_sub(2));
        (first, (first + 1).min(n - 1), (p - first as f64) as f32)
    };
    let cols: Vec<_> = at.cols.iter().map(|&u| between(u, grid.cols)).collect();
    cx.fill(base.quantity(), |row, out| {
        let (top, bottom, t) = between(at.rows[row.j], grid.rows);
        let (top, bottom) = (base.row(top), base.row(bottom));
        for (o, &(left, right, s)) in out.iter_mut().zip(&cols) {
            *o = lerp(lerp(top[left], top[right], s), lerp(bottom[left], bottom[right], s), t);
        }
    })
}

fn lift_channels<T: Sample>(
    cx: &Context<'_>,
    base: &Raster<T>,
    finish: impl Fn(f32) -> f32 + Sync,
) -> Result<Raster<T>> {
    let grid = base.grid();
    if grid.contains(&cx.grid) {
        return Ok(base.crop(&cx.grid));
    }
    let all: &[f32] = bytemuck::cast_slice(base.data());
    let channel = |k: usize| match T::CHANNELS {
        1 => Cow::Borrowed(all),
        n => all.iter().skip(k).step_by(n).copied().collect(),
    };
    let splines: Vec<_> = (0..T::CHANNELS).map(|k| Spline::fit(grid.cols, grid.rows, &channel(k))).collect();
    let at = Positions::new(&cx.grid, grid);
    let taps = splines[0].taps(at.cols.iter().copied());
    cx.fill(base.quantity(), |row, out: &mut [T]| {
        let v = at.rows[row.j];
        let flat: &mut [f32] = bytemuck::cast_slice_mut(&mut *out);
        if let [spline] = splines.as_slice() {
            spline.row(v, &taps, flat);
            flat.iter_mut().for_each(|o| *o = finish(*o));
        } else {
            let mut line = vec![0.0; flat.len() / splines.len()];
            for (k, spline) in splines.iter().enumerate() {
                spline.row(v, &taps, &mut line);
                let each = flat.iter_mut().skip(k).step_by(splines.len());
                each.zip(&line).for_each(|(o, &x)| *o = finish(x));
            }
        }
        at.keep_shared_points(base, row.j, out);
    })
}

fn nearest(cx: &Context<'_>, base: &Field) -> Result<Field> {
    let (grid, at) = (base.grid(), Positions::new(&cx.grid, base.grid()));
    let index = |p: f64| (p + 0.5).floor() as i64;
    cx.fill(Quantity::Label, |row, out| {
        let r = grid.row + index(at.rows[row.j]);
        for (o, &u) in out.iter_mut().zip(&at.cols) {
            *o = base.at(grid.col + index(u), r);
        }
    })
}

fn lift_direction(cx: &Context<'_>, base: &Field) -> Result<Field> {
    let turn = |&d: &f32| {
        let (s, c) = libm::sincosf(d * (std::f32::consts::PI / 180.0));
        [s, c]
    };
    let vectors = Raster::new(*base.grid(), Quantity::Vector, base.data().iter().map(turn).collect());
    let lifted = lift_channels(cx, &vectors, |x| x)?;
    let mut out = cx.map(&lifted, Quantity::Direction, |[s, c]: [f32; 2]| {
        let d = libm::atan2f(s, c) * (180.0 / std::f32::consts::PI);
        if d < 0.0 { d + 360.0 } else { d }
    })?;
    let at = Positions::new(&cx.grid, base.grid());
    let mut data = out.data().to_vec();
    for (j, row) in data.chunks_mut(cx.grid.cols).enumerate() {
        at.keep_shared_points(base, j, row);
    }
    out = Raster::new(cx.grid, Quantity::Direction, data);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::node::Cancel;
    use crate::value::Terrain;

    /// A river one cell wide on dry ground: the area that drains through each sample.
    fn river(quantity: Quantity) -> Field {
        let grid = Terrain { base: 17, ..Terrain::default() }.base_grid();
        let area = |i: usize| if i % 17 == 8 { 1e6 } else { 100.0 };
        Field::new(grid, quantity, (0..17 * 17).map(area).collect())
    }

    fn lifted(base: &Field, size: u32) -> Field {
        let terrain = Terrain { base: 17, ..Terrain::default() };
        let cancel = Cancel::default();
        let cx = Context::bare(terrain.grid(size).expect("a size"), &terrain, &cancel);
        let Ok(Value::Field(field)) = lift(&cx, &Value::Field(base.clone())) else { panic!("a field") };
        field
    }

    #[test]
    fn areas_stay_between_the_samples_around_them() {
        let (low, high) = lifted(&river(Quantity::Area), 129).range().expect("samples");
        assert_eq!((low, high), (100.0, 1e6));
        let (low, _) = lifted(&river(Quantity::Number), 129).range().expect("samples");
        assert!(low < -1e5, "a spline swings below, to {low}");
    }

    #[test]
    fn areas_are_linear_and_exact_at_shared_points() {
        let (base, fine) = (river(Quantity::Area), lifted(&river(Quantity::Area), 33));
        assert_eq!(fine.quantity(), Quantity::Area);
        for (j, i) in (0..33).flat_map(|j| (0..33).map(move |i| (j, i))) {
            let [left, right] = [base.row(j / 2)[i / 2], base.row(j.div_ceil(2))[i.div_ceil(2)]];
            assert_eq!(fine.row(j)[i], (left + right) / 2.0, "column {i}, row {j}");
        }
    }
}
