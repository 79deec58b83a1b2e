//! Figures of land: closed forms, plain references, land that says nothing, and real models.

mod drainage;
mod forms;
mod hostile;
mod models;
mod spectrum;

use orograph::kit::geomorphometry::{Figures, Land};
use orograph::work::Work;

/// Land of a function of column and row.
fn land(cols: usize, rows: usize, cell: f64, height: impl Fn(f64, f64) -> f64) -> Land {
    let heights = (0..rows).flat_map(|j| (0..cols).map(move |i| (i, j)));
    Land::new(cols, rows, cell, heights.map(|(i, j)| height(i as f64, j as f64) as f32).collect())
}

fn figures(land: &Land) -> Figures {
    Figures::of(land, None, &Work::default()).unwrap().expect("some land")
}

#[track_caller]
fn near(found: f64, want: f64, off: f64) {
    assert!((found - want).abs() <= off, "{found}, not {want}");
}
