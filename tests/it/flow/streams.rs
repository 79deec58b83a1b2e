//! Rivers in a tree.

use orograph::kit::flow::{accumulate, network, streams};
use orograph::value::{Grid, Lattice, Rivers};
use orograph::work::Work;
use proptest::prelude::*;

use super::ground::{Ground, grounds};
use super::routing::{tree, way};

fn grid(ground: &Ground) -> Grid {
    let lattice = Lattice { origin: [-300.0, 50.0], span: 1280.0, intervals: 128 };
    Grid { lattice, col: 0, row: 0, cols: ground.cols, rows: ground.rows }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn rivers_are_the_cells_of_enough_land_down_to_their_outlets(ground in grounds(), threshold in 2u32..9) {
        let (tree, work) = (tree(&ground), Work::default());
        let count = accumulate::count(&tree, |cell| ground.is_land(cell), &work).unwrap();
        let is_river = |cell: usize| ground.is_land(cell) && count[cell] >= threshold;
        let stream = streams::trace(&tree, is_river, &work).unwrap();
        let mut found: Vec<usize> = stream.iter().map(|cell| cell.cell as usize).collect();
        for part in &stream {
            let down = part.down.map(|down| stream[down as usize].cell as usize);
            prop_assert_eq!(down, tree.receiver(part.cell as usize));
        }
        prop_assert!(stream.iter().zip(0..).all(|(part, i)| part.down.is_none_or(|down| down < i)));
        found.sort_unstable();
        // All river cells but lone outlets, and the outlets that they reach.
        let mut wanted: Vec<usize> =
            (0..ground.len()).filter(|&cell| is_river(cell)).flat_map(|cell| way(&tree, cell)).collect();
        wanted.sort_unstable();
        wanted.dedup();
        wanted.retain(|&cell| tree.receiver(cell).is_some()
            || (0..ground.len()).any(|i| is_river(i) && tree.receiver(i) == Some(cell)));
        prop_assert_eq!(found, wanted);
    }

    #[test]
    fn beds_fall_and_networks_are_valid(ground in grounds(), threshold in 1u32..6, smoothing in 0.0f64..40.0) {
        let (tree, work, surface) = (tree(&ground), Work::default(), ground.surface());
        let count = accumulate::count(&tree, |cell| ground.is_land(cell), &work).unwrap();
        let is_river = |cell: usize| ground.is_land(cell) && count[cell] >= threshold;
        let stream = streams::trace(&tree, is_river, &work).unwrap();
        let style = network::Style { smoothing, width: 4.0, falls: true };
        let area = |cell: usize| f64::from(count[cell]) * 100.0;
        let vertices = network::vertices(&surface, &grid(&ground), &stream, area, style, &work).unwrap();
        let whole = grid(&ground).bounds();
        for vertex in &vertices {
            let [x, y] = vertex.at;
            prop_assert!((whole.min[0]..=whole.max[0]).contains(&x) && (whole.min[1]..=whole.max[1]).contains(&y));
            if let Some(down) = vertex.down {
                prop_assert!(vertices[down as usize].height <= vertex.height);
                prop_assert!(vertices[down as usize].area >= vertex.area);
            }
        }
        if ground.sea.is_none_or(|sea| sea < 1e5) {
            prop_assert!(Rivers::new(vertices).is_ok());
        }
    }
}

#[test]
fn smoothing_rounds_steps_and_keeps_the_ends() {
    let ground =
        Ground::of(41, 81, |c, r| 3.0 * (c as f32 - 20.0 - 0.3 * (r as f32 - 40.0)).abs() + (80 - r) as f32);
    let (tree, work) = (tree(&ground), Work::default());
    let count = accumulate::count(&tree, |_| true, &work).unwrap();
    let stream = streams::trace(&tree, |cell| count[cell] >= 120, &work).unwrap();
    let turn = |smoothing: f64| {
        let style = network::Style { smoothing, width: 4.0, falls: true };
        let grid = grid(&ground);
        let area = |cell: usize| f64::from(count[cell]);
        let vertices = network::vertices(&ground.surface(), &grid, &stream, area, style, &work).unwrap();
        let outlet = vertices[0].at;
        let rivers = Rivers::new(vertices).unwrap();
        let heading = |i: usize| {
            let (a, b) = (rivers.vertices()[i].at, rivers.vertices()[rivers.down(i)?].at);
            Some(libm::atan2(b[1] - a[1], b[0] - a[0]))
        };
        let sum: f64 =
            (0..rivers.len()).filter_map(|i| Some((heading(i)? - heading(rivers.down(i)?)?).abs())).sum();
        (sum / rivers.len() as f64, outlet)
    };
    let ((rough, end), (smooth, same_end)) = (turn(0.0), turn(20.0));
    assert_eq!(end, same_end);
    assert!(smooth < 0.3 * rough, "{rough} {smooth}");
}
