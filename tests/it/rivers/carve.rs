//! River beds in land: they drain, tiles agree to the bit, and what lies beyond the banks stays.

use orograph::kit::hash;
use orograph::kit::land::carve::{Carved, Carving};
use orograph::kit::land::{Line, WideLine};
use orograph::value::{Field, Grid, Lattice, Quantity};
use orograph::work::{Cancel, Cancelled, Work};
use proptest::prelude::*;

/// The base cell of these tests, in metres.
const CELL: f64 = 8.0;

/// 65 × 49 base cells of 8 m, `finer` times as fine.
fn grid(finer: u32) -> Grid {
    let lattice = Lattice { origin: [0.0, 0.0], span: 64.0 * CELL, intervals: 64 * finer };
    Grid { lattice, col: 0, row: 0, cols: 64 * finer as usize + 1, rows: 48 * finer as usize + 1 }
}

/// A chain of links from an outlet inland, that falls towards it by 2 m each.
fn river(points: &[[f64; 2]], outlet: f64, width: f64) -> Vec<WideLine> {
    let height = |i: usize| outlet + 2.0 * i as f64;
    let link = |i: usize| WideLine {
        line: Line { ends: [points[i], points[i + 1]], heights: [height(i), height(i + 1)] },
        width,
        order: 1,
    };
    (0..points.len() - 1).map(link).collect()
}

/// A main river across the terrain, whose outlet is on the border, and a tributary that runs close beside it before it
/// joins, 8 m above.
fn network(width: f64) -> Vec<WideLine> {
    let main: Vec<_> = (0..12).map(|k| [45.0 * f64::from(k), 200.0 + 40.0 * f64::from(k % 3)]).collect();
    let joins = main[4];
    let beside: Vec<_> = std::iter::once(joins)
        .chain((5..10).map(|k| [45.0 * f64::from(k), 200.0 + 40.0 * f64::from(k % 3) - 27.0]))
        .collect();
    let mut links = river(&main, 100.0, width);
    links.extend(river(&beside, 108.0, width));
    links
}

/// Rough land about the rivers: some below them, so that they stand above it.
fn land(grid: &Grid) -> Field {
    let noise = |k: usize| 60.0 * hash::unit(4, k as u64) as f32;
    let height = |k: usize| 85.0 + 0.1 * (k / grid.cols) as f32 + noise(k);
    Field::new(*grid, Quantity::Elevation, (0..grid.len()).map(height).collect())
}

fn carving(grid: &Grid) -> Carving {
    Carving { cell: grid.cell().max(CELL), rise: 0.5, reach: 40.0 }
}

fn carve(land: &Field, grid: &Grid, links: &[WideLine]) -> Carved {
    carving(land.grid()).carve(&Work::default(), land, grid, links).expect("nobody stops it")
}

/// The sample that water of a sample runs to: the steepest way down to one of eight neighbours, none out of a pit.
fn down(height: &Field, [i, j]: [usize; 2]) -> Option<[usize; 2]> {
    let (grid, z) = (height.grid(), height.row(j)[i]);
    let mut best: Option<(f64, [usize; 2])> = None;
    for y in j.saturating_sub(1)..(j + 2).min(grid.rows) {
        for x in i.saturating_sub(1)..(i + 2).min(grid.cols) {
            let steps = (x.abs_diff(i) + y.abs_diff(j)) as f64;
            let fall = f64::from(z - height.row(y)[x]) / steps.max(1.0).sqrt();
            if fall > best.map_or(0.0, |b| b.0) {
                best = Some((fall, [x, y]));
            }
        }
    }
    best.map(|b| b.1)
}

/// Bed samples, and how many of them water leaves for the outlet in the west.
fn drained(carved: &Carved) -> (usize, usize) {
    let grid = *carved.height.grid();
    let (mut beds, mut drained) = (0, 0);
    for k in (0..grid.len()).filter(|&k| carved.bed.data()[k] == 1.0) {
        let mut at = [k % grid.cols, k / grid.cols];
        while let Some(next) = down(&carved.height, at) {
            at = next;
        }
        beds += 1;
        // The lowest height of the main river is that of the samples within half a bed of its outlet.
        let reach = 2.0 * carving(&grid).cell.max(30.0);
        drained += usize::from(libm::hypot(grid.x(at[0]), grid.y(at[1]) - 200.0) < reach);
    }
    (beds, drained)
}

#[test]
fn every_bed_sample_drains_to_the_outlet_at_any_size() {
    for finer in [1, 2, 4] {
        for width in [0.0, 30.0] {
            let (grid, links) = (grid(finer), network(width));
            let land = land(&grid);
            let (beds, drained) = drained(&carve(&land, &grid, &links));
            assert!(beds > 100, "{beds} samples of beds");
            assert_eq!(drained, beds, "{finer} times as fine, {width} m wide");
        }
    }
}

#[test]
fn beds_are_connected_and_have_the_lowest_height_within_half_their_width() {
    let (grid, links) = (grid(1), network(0.0));
    let carved = carve(&land(&grid), &grid, &links);
    let half = 0.75 * CELL;
    for k in 0..grid.len() {
        let (x, y) = (grid.x(k % grid.cols), grid.y(k / grid.cols));
        // Links taken in ten thousand steps.
        let mut lowest = f64::MAX;
        for WideLine { line: Line { ends: [a, b], heights: [low, high] }, .. } in &links {
            for step in 0..=4000 {
                let t = f64::from(step) / 4000.0;
                let at = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
                if libm::hypot(at[0] - x, at[1] - y) <= half {
                    lowest = lowest.min(low + t * (high - low));
                }
            }
        }
        if lowest < f64::MAX {
            assert_eq!(carved.bed.data()[k], 1.0);
            assert!((f64::from(carved.height.data()[k]) - lowest).abs() < 0.01, "at {x}, {y}");
        }
    }
}

#[test]
fn samples_beside_a_bed_stand_above_it_and_those_beyond_the_banks_stay() {
    let (grid, links) = (grid(2), network(0.0));
    let land = land(&grid);
    let carved = carve(&land, &grid, &links);
    let bed = |i: usize, j: usize| (carved.bed.row(j)[i] == 1.0).then(|| carved.height.row(j)[i]);
    let (mut lifted, mut kept) = (0, 0);
    for k in (0..grid.len()).filter(|&k| carved.bed.data()[k] == 0.0) {
        let (i, j) = (k % grid.cols, k / grid.cols);
        let near = (j.saturating_sub(1)..(j + 2).min(grid.rows))
            .flat_map(|y| (i.saturating_sub(1)..(i + 2).min(grid.cols)).map(move |x| (x, y)));
        let highest = near.filter_map(|(x, y)| bed(x, y)).reduce(f32::max);
        if let Some(highest) = highest {
            assert!(carved.height.data()[k] > highest);
            lifted += usize::from(land.data()[k] < highest);
        }
        let far = links.iter().all(|link| {
            let ends = link.line.ends;
            let middle = [(ends[0][0] + ends[1][0]) / 2.0, (ends[0][1] + ends[1][1]) / 2.0];
            let half = libm::hypot(ends[0][0] - ends[1][0], ends[0][1] - ends[1][1]) / 2.0;
            libm::hypot(middle[0] - grid.x(i), middle[1] - grid.y(j)) > half + 0.75 * CELL + 40.0 + CELL
        });
        if far {
            assert_eq!(carved.height.data()[k].to_bits(), land.data()[k].to_bits());
            kept += 1;
        }
    }
    assert!(lifted > 10 && kept > 100, "{lifted} lifted, {kept} kept");
}

#[test]
fn a_tile_is_the_crop_of_the_whole_to_the_bit() {
    let (grid, links) = (grid(4), network(12.0));
    let land = land(&grid);
    let whole = carve(&land, &grid, &links);
    for (col, row, cols, rows) in [(0, 0, 65, 65), (60, 77, 90, 40), (200, 100, 57, 93), (31, 90, 1, 1)] {
        let tile = Grid { col, row, cols, rows, ..grid };
        let part = carve(&land, &tile, &links);
        assert_eq!(part.height, whole.height.crop(&tile));
        assert_eq!(part.bed, whole.bed.crop(&tile));
    }
}

#[test]
fn land_without_rivers_stays_and_carving_stops_when_asked() {
    let grid = grid(1);
    let land = land(&grid);
    assert_eq!(carve(&land, &grid, &[]).height, land);
    let cancel = Cancel::default();
    cancel.cancel();
    let stopped = carving(&grid).carve(&Work::new(&cancel), &land, &grid, &network(0.0));
    assert_eq!(stopped.err(), Some(Cancelled));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    #[test]
    fn carved_land_is_finite(
        points in prop::collection::vec([-1e4..1e4f64, -1e4..1e4f64], 2..6),
        heights in prop::collection::vec(-1e4..1e4f64, 6),
        width in prop_oneof![Just(0.0), 0.0..500.0f64, Just(1e8)],
        (rise, reach) in (0.0..100.0f64, prop_oneof![Just(0.0), 0.0..1e4f64]),
    ) {
        let grid = grid(1);
        let link = |i: usize| WideLine {
            line: Line { ends: [points[i], points[i + 1]], heights: [heights[i], heights[i + 1]] },
            width,
            order: 1,
        };
        let mut links: Vec<_> = (0..points.len() - 1).map(link).collect();
        // A link without length.
        links.push(WideLine { line: Line { ends: [[100.0, 90.0]; 2], heights: [5.0, 4.0] }, width, order: 1 });
        let carved = Carving { cell: CELL, rise, reach }.carve(&Work::default(), &land(&grid), &grid, &links).unwrap();
        prop_assert!(carved.height.data().iter().all(|z| z.is_finite()));
        prop_assert!(carved.bed.data().iter().all(|b| *b == 0.0 || *b == 1.0));
        prop_assert!(carved.bed.at(12, 11) == 1.0);
    }
}
