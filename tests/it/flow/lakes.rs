//! Lakes and their shores.

use orograph::kit::flow::{Depressions, Lakes, Puddles};
use orograph::work::Work;
use proptest::prelude::*;

use super::ground::{Ground, grounds};

fn lakes(ground: &Ground, puddles: Puddles) -> Lakes {
    let (surface, work) = (ground.surface(), Work::default());
    let depressions = Depressions::find(&surface, &work).unwrap();
    Lakes::find(&surface, &depressions, puddles, &work).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn lakes_are_connected_water_of_one_level(ground in grounds()) {
        let (found, level) = (lakes(&ground, Puddles::default()), ground.lowest(|height| height));
        let mut cells = vec![0; found.lakes.len() + 1];
        for cell in numbers(ground.len()) {
            let label = found.label[cell];
            prop_assert_eq!(label > 0, level[cell] > ground.height[cell]);
            cells[label as usize] += 1;
            if label > 0 {
                prop_assert_eq!(found.lake(label).unwrap().level, level[cell]);
                for i in ground.around(cell) {
                    prop_assert!(found.label[i] == 0 || found.label[i] == label);
                }
            }
        }
        for (label, lake) in (1..).zip(&found.lakes) {
            prop_assert_eq!(lake.cells as usize, cells[label]);
            // All of a lake is reached from its first cell.
            let mut reached = vec![found.label.iter().position(|&l| l as usize == label).unwrap()];
            let mut next = 0;
            while let Some(&cell) = reached.get(next) {
                next += 1;
                for i in ground.around(cell) {
                    if found.label[i] as usize == label && !reached.contains(&i) {
                        reached.push(i);
                    }
                }
            }
            prop_assert_eq!(reached.len(), cells[label]);
        }
    }

    #[test]
    fn puddles_are_no_lakes(ground in grounds(), area in 0.0f64..900.0, depth in 0.0f64..4.0) {
        let (all, some) = (lakes(&ground, Puddles::default()), lakes(&ground, Puddles { area, depth }));
        let counts = |lake: &&orograph::kit::flow::Lake| {
            f64::from(lake.cells) * 100.0 >= area && f64::from(lake.depth) >= depth
        };
        let kept: Vec<_> = all.lakes.iter().filter(counts).copied().collect();
        prop_assert_eq!(&some.lakes, &kept);
        let wet: usize = some.label.iter().filter(|&&label| label > 0).count();
        prop_assert_eq!(wet, kept.iter().map(|lake| lake.cells as usize).sum::<usize>());
    }
}

#[test]
fn levels_reach_two_cells_beyond_and_shores_stop_at_the_dam() {
    // A hollow behind a dam of one cell; the valley falls away to the east.
    let height = |c: usize, r: usize| {
        let side = 2.0 * (r as f32 - 12.0).abs();
        side + match c {
            0..20 => 10.0 + (20 - c) as f32 * 0.2 - 4.0,
            20 => 10.0,
            _ => 9.0 - (c - 20) as f32,
        }
    };
    let ground = Ground::of(45, 25, height);
    let found = lakes(&ground, Puddles::default());
    assert_eq!(found.lakes.len(), 1);
    let lake = found.lakes[0];
    assert_eq!(lake.level, 10.0);
    let (surface, work) = (ground.surface(), Work::default());
    let widened = found.widened(&surface, 2, &work).unwrap();
    let shores = found.with_shores(&surface, &widened, &work).unwrap();
    let (mut beyond, mut shore) = (0, 0);
    for cell in numbers(ground.len()) {
        let far = |n: usize| {
            let (c, r) = (cell % 45, cell / 45);
            let near = |i: usize| (i % 45).abs_diff(c) <= n && (i / 45).abs_diff(r) <= n;
            !(0..ground.len()).any(|i| found.label[i] == 1 && near(i))
        };
        assert_eq!(widened[cell] == 1, !far(2), "cell {cell}");
        assert!(shores[cell] == 0 || widened[cell] == 1);
        if shores[cell] == 1 && found.label[cell] == 0 {
            shore += 1;
            assert!(ground.height[cell] >= lake.level);
            let low = |i: &usize| found.label[*i] == 0 && ground.height[*i] < lake.level;
            assert_eq!(ground.around(cell).iter().find(|i| low(i)), None, "water behind the dam at {cell}");
        }
        beyond +=
            usize::from(widened[cell] == 1 && ground.height[cell] < lake.level && found.label[cell] == 0);
    }
    assert!(beyond > 0 && shore > 20, "{beyond} {shore}");
}

/// The numbers of so many cells.
fn numbers(count: usize) -> std::ops::Range<usize> {
    0..count
}
