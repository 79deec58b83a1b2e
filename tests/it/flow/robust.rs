//! Any size, any input, any number of threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use orograph::kit::flow::{
    Depressions, Lakes, Puddles, Spread, Surface, Tree, accumulate, breach, epsilon, streams, wetness,
};
use orograph::work::{Cancel, Cancelled, Work};

use super::ground::{Ground, bits};
use super::routing::RULES;

/// Everything that is found of a surface, as bits.
fn all(surface: &Surface<'_>, work: &Work<'_>) -> Result<Vec<Vec<u64>>, Cancelled> {
    let narrow = |numbers: Vec<f32>| bits(&numbers).into_iter().map(u64::from).collect::<Vec<_>>();
    let wide = |numbers: Vec<f64>| numbers.into_iter().map(f64::to_bits).collect::<Vec<_>>();
    let whole = |numbers: Vec<u32>| numbers.into_iter().map(u64::from).collect::<Vec<_>>();
    let n = surface.cells.len();
    let depressions = Depressions::find(surface, &work.stage(0.0, 0.1))?;
    let filled = depressions.filled(surface, work)?;
    let lakes = Lakes::find(surface, &depressions, Puddles::default(), work)?;
    let shores = lakes.with_shores(surface, &lakes.widened(surface, 2, work)?, work)?;
    let tree = depressions.into_tree(surface, work)?;
    let count = accumulate::count(&tree, |cell| surface.is_land(cell), work)?;
    let is_river = |cell: usize| count[cell] > 5;
    let stream = streams::trace(&tree, is_river, work)?;
    let mut found = vec![
        narrow(filled.clone()),
        narrow(epsilon::fill(surface, 0.01, work)?),
        narrow(breach::cut(surface, None, work)?),
        narrow(breach::cut(surface, Some(1.0), work)?),
        whole(lakes.label.clone()),
        whole(shores),
        tree.directions().iter().map(|&k| k.into()).collect(),
        wide(tree.distance(work)?),
        whole(tree.basins(|cell| surface.is_land(cell), work)?),
        narrow(wetness::above_river(&tree, |i| surface.at(i), is_river, work)?),
        stream.iter().map(|cell| cell.cell.into()).collect(),
        whole(count.clone()),
    ];
    for rule in RULES {
        let spread = Spread::new(*surface, &tree, &filled, rule);
        found.push(wide(spread.accumulate(vec![0.1; n], work)?));
        found.push((0..n).flat_map(|cell| spread.direction(cell)).map(f64::to_bits).collect());
    }
    Ok(found)
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    for ground in [Ground::rough(700, 530, 3), Ground::of(900, 400, |c, r| ((c / 50 + r / 70) % 5) as f32)] {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| all(&ground.surface(), &Work::default())).expect("nobody stops it")
        };
        let one = run(1);
        assert!(run(4) == one && run(3) == one);
    }
}

#[test]
fn any_size() {
    let sizes = [
        (0, 0),
        (0, 5),
        (5, 0),
        (1, 1),
        (1, 2),
        (2, 1),
        (2, 2),
        (3, 3),
        (1, 1000),
        (1000, 1),
        (2, 333),
        (5, 7),
    ];
    for (cols, rows) in sizes {
        for sea in [None, Some(0.0), Some(1e9)] {
            for ground in [Ground::of(cols, rows, |_, _| 3.0), Ground::rough(cols, rows, 2)] {
                let ground = Ground { sea, ..ground };
                let found = all(&ground.surface(), &Work::default()).expect("nobody stops it");
                assert_eq!(found[0].len(), cols * rows);
            }
        }
    }
}

#[test]
fn hostile_heights_give_finite_numbers() {
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::MAX,
        f32::MIN,
        -1e30,
        9e29,
        1e-45,
        -1e-45,
        0.0,
        -0.0,
        3.0,
    ];
    let n = 40;
    let mut seed = 1u32;
    let mut pick = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        odd[(seed >> 16) as usize % odd.len()]
    };
    for sea in [None, Some(0.0), Some(f64::NAN), Some(f64::INFINITY), Some(f64::NEG_INFINITY), Some(-1e300)] {
        let ground = Ground { cols: n, rows: n, height: (0..n * n).map(|_| pick()).collect(), sea };
        let surface = ground.surface();
        all(&surface, &Work::default()).expect("nobody stops it");
        let tree = Tree::of(&surface, &Work::default()).unwrap();
        let filled = Depressions::find(&surface, &Work::default())
            .unwrap()
            .filled(&surface, &Work::default())
            .unwrap();
        for rule in RULES {
            let spread = Spread::new(surface, &tree, &filled, rule);
            let area = spread.accumulate(vec![1.0; n * n], &Work::default()).unwrap();
            assert!(area.iter().all(|area| (1.0..=(n * n) as f64 + 1e-6).contains(area)), "{sea:?} {rule:?}");
            assert!((0..n * n).all(|cell| spread.direction(cell).iter().all(|x| x.is_finite())));
        }
    }
}

#[test]
fn nothing_but_sea_is_nothing_but_outlets() {
    let ground = Ground { sea: Some(100.0), ..Ground::rough(30, 20, 1) };
    let surface = ground.surface();
    let depressions = Depressions::find(&surface, &Work::default()).unwrap();
    assert_eq!(depressions.pits(), []);
    assert_eq!(depressions.filled(&surface, &Work::default()).unwrap(), ground.height);
    let tree = depressions.into_tree(&surface, &Work::default()).unwrap();
    assert!((0..ground.len()).all(|cell| tree.receiver(cell).is_none()));
    assert_eq!(tree.basins(|cell| surface.is_land(cell), &Work::default()).unwrap(), vec![0; 600]);
}

#[test]
fn work_tells_and_stops() {
    let ground = Ground::rough(300, 300, 6);
    let told = Mutex::new(Vec::new());
    let tell = |done: f32| told.lock().expect("whole").push(done);
    Depressions::find(&ground.surface(), &Work::default().telling(&tell)).expect("nobody stops it");
    let told = told.into_inner().expect("whole");
    assert!(told.len() > 3 && told.last() == Some(&1.0), "{told:?}");
    // Stopped at the first look, at one in the middle, and at the last.
    let after = |looks: usize| {
        let seen = AtomicUsize::new(0);
        let cancel = Cancel::asking(move || seen.fetch_add(1, Ordering::SeqCst) >= looks);
        all(&ground.surface(), &Work::new(&cancel)).map(|_| ())
    };
    for at in [0, 1, 5, 20] {
        assert_eq!(after(at), Err(Cancelled), "after {at} looks");
    }
    assert_eq!(after(1_000_000), Ok(()));
}
