//! From the cells of rivers to a network of vertices.

use super::flats::LOOK;
use super::streams::StreamCell;
use super::surface::Surface;
use crate::kit::rivers::drainage::width;
use crate::value::curves::MAX_HEIGHT;
use crate::value::{Grid, RiverVertex};
use crate::work::{Cancelled, Work};

/// How the vertices of a network are made of cells.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Standard deviation of the Gaussian that rounds the steps of the ways over the grid, in metres.
    pub smoothing: f64,
    /// Width of a river that drains a square kilometre, in metres; it grows with the root of the area.
    pub width: f64,
    /// Whether beds fall all the way: ways over a pass climb, and are lowered to what lies above them.
    pub falls: bool,
}

/// A vertex for each cell of a stream: where the cell stands, at the height of its ground or of the sea. `area` gives the
/// area in square metres that drains through a cell.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn vertices(
    surface: &Surface<'_>,
    grid: &Grid,
    stream: &[StreamCell],
    area: impl Fn(usize) -> f64,
    style: Style,
    work: &Work<'_>,
) -> Result<Vec<RiverVertex>, Cancelled> {
    let cols = grid.cols.max(1);
    let vertex = |of: &StreamCell| {
        let cell = of.cell as usize;
        let area = area(cell);
        RiverVertex {
            at: [grid.x(cell % cols), grid.y(cell / cols)],
            height: if surface.is_known(cell) {
                f64::from(surface.at(cell).max(surface.sea())).clamp(-MAX_HEIGHT, MAX_HEIGHT)
            } else {
                UNKNOWN
            },
            down: of.down,
            area: area as f32,
            width: width(area, style.width) as f32,
            ..RiverVertex::default()
        }
    };
    let mut vertices: Vec<RiverVertex> = stream.iter().map(vertex).collect();
    take_from_above(&mut vertices);
    if style.falls {
        lower(&mut vertices);
    }
    // Each round of a quarter, a half and a quarter has a variance of half a step.
    let steps = style.smoothing / grid.cell();
    let rounds = (2.0 * steps * steps).ceil().clamp(0.0, 1000.0) as u32;
    smooth(&mut vertices, rounds, work)?;
    Ok(vertices)
}

/// The height of a mouth where there are no data.
const UNKNOWN: f64 = f64::INFINITY;

/// Gives mouths without a height that of the lowest vertex above.
fn take_from_above(vertices: &mut [RiverVertex]) {
    let mouth = |vertex: &RiverVertex| vertex.down.filter(|&down| vertices[down as usize].height == UNKNOWN);
    let heights: Vec<(u32, f64)> = vertices.iter().filter_map(|v| Some((mouth(v)?, v.height))).collect();
    for (down, height) in heights {
        let mouth = &mut vertices[down as usize].height;
        *mouth = mouth.min(height);
    }
}

/// Lowers vertices, which stand downstream first, to those above them.
pub fn lower(vertices: &mut [RiverVertex]) {
    for upper in (0..vertices.len()).rev() {
        let height = vertices[upper].height;
        if let Some(down) = vertices[upper].down {
            let lower = &mut vertices[down as usize].height;
            *lower = lower.min(height);
        }
    }
}

/// Moves vertices towards their neighbours along the river, but for sources, mouths and confluences.
fn smooth(vertices: &mut [RiverVertex], rounds: u32, work: &Work<'_>) -> Result<(), Cancelled> {
    const SEVERAL: u32 = u32::MAX - 1;
    const NOTHING: u32 = u32::MAX;
    let mut above = vec![NOTHING; vertices.len()];
    for (i, vertex) in vertices.iter().enumerate() {
        if let Some(down) = vertex.down {
            let above = &mut above[down as usize];
            *above = if *above == NOTHING { i as u32 } else { SEVERAL };
        }
    }
    for round in 0..rounds {
        work.step(round as f32 / rounds as f32)?;
        let before: Vec<[f64; 2]> = vertices.iter().map(|vertex| vertex.at).collect();
        for (i, vertex) in vertices.iter_mut().enumerate() {
            if i % LOOK == 0 {
                work.check()?;
            }
            let Some(down) = vertex.down.filter(|_| above[i] < SEVERAL) else { continue };
            let [a, b] = [before[down as usize], before[above[i] as usize]];
            vertex.at = [0, 1].map(|k| (a[k] + 2.0 * before[i][k] + b[k]) / 4.0);
        }
    }
    Ok(())
}
