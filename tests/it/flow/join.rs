//! Lines that become a network.

use orograph::kit::flow::join::{Polyline, join};
use orograph::work::Work;
use proptest::prelude::*;

fn line(corners: &[[f64; 2]]) -> Polyline {
    Polyline(corners.iter().map(|[x, y]| [*x, *y, 100.0 - y]).collect())
}

#[test]
fn a_mouth_joins_the_nearest_place_of_another_line() {
    let stem = line(&[[0.0, 0.0], [0.0, 100.0]]);
    let side = line(&[[80.0, 10.0], [6.0, 40.0]]);
    let found = join(&[stem, side], 10.0, &Work::default()).unwrap();
    let places: Vec<_> = found.iter().map(|corner| corner.0).collect();
    assert_eq!(
        places,
        [[0.0, 0.0, 100.0], [0.0, 40.0, 60.0], [0.0, 100.0, 0.0], [80.0, 10.0, 90.0], [6.0, 40.0, 60.0]]
    );
    assert_eq!(
        found.iter().map(|corner| corner.1).collect::<Vec<_>>(),
        [Some(1), Some(2), None, Some(4), Some(1)]
    );
    let apart = join(
        &[line(&[[0.0, 0.0], [0.0, 100.0]]), line(&[[80.0, 10.0], [11.0, 40.0]])],
        10.0,
        &Work::default(),
    );
    assert_eq!(apart.unwrap().iter().filter(|corner| corner.1.is_none()).count(), 2);
}

#[test]
fn a_line_drawn_on_is_one_river() {
    let found =
        join(&[line(&[[0.0, 0.0], [0.0, 50.0]]), line(&[[0.0, 50.0], [0.0, 90.0]])], 1.0, &Work::default());
    assert_eq!(
        found.unwrap().iter().map(|corner| corner.1).collect::<Vec<_>>(),
        [Some(1), Some(2), Some(3), None]
    );
}

#[test]
fn lines_in_a_circle_keep_an_outlet() {
    let corners = [[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]];
    let sides: Vec<Polyline> = (0..4).map(|i| line(&[corners[i], corners[(i + 1) % 4]])).collect();
    let found = join(&sides, 1.0, &Work::default()).unwrap();
    assert_eq!(found.iter().filter(|corner| corner.1.is_none()).count(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn lines_become_a_forest(
        lines in prop::collection::vec(prop::collection::vec((0.0f64..9.0, 0.0f64..9.0), 0..6), 0..8),
        snap in 0.0f64..4.0,
    ) {
        let lines: Vec<Polyline> = lines
            .into_iter()
            .map(|corners| line(&corners.into_iter().map(|(x, y)| [x.floor(), y.floor()]).collect::<Vec<_>>()))
            .collect();
        let found = join(&lines, snap, &Work::default()).unwrap();
        let corners: usize = lines.iter().map(|line| line.0.len()).sum();
        prop_assert!(found.len() >= corners && found.len() <= corners + lines.len());
        for start in 0..found.len() {
            let way = std::iter::successors(Some(start), |&i| found[i].1.map(|down| down as usize));
            prop_assert!(way.take(found.len() + 1).count() <= found.len(), "a circle");
        }
    }
}
