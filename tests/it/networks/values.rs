//! Rivers and ridges as values.

use orograph::value::rivers::MAX_VERTICES;
use orograph::value::{
    AnyObject, Object, RidgeEdge, RidgeFault, RidgeVertex, Ridges, RiverFault, RiverVertex, Rivers, Sketch,
};
use proptest::prelude::*;

fn vertex(x: f64, y: f64, down: Option<u32>) -> RiverVertex {
    RiverVertex { at: [x, y], height: 0.1 * x, down, area: 3.0, width: 1.5, ..RiverVertex::default() }
}

/// A network of any shape, downstream first.
fn forest() -> impl Strategy<Value = Vec<RiverVertex>> {
    prop::collection::vec((any::<u16>(), -1e6..1e6, -1e6..1e6), 0..60).prop_map(|links| {
        let vertex = |(i, (pick, x, y)): (usize, (u16, f64, f64))| {
            // One in eight starts a network.
            let down = (i > 0 && pick % 8 != 0).then(|| u32::from(pick) % i as u32);
            vertex(x, y, down)
        };
        links.into_iter().enumerate().map(vertex).collect()
    })
}

/// Strahler's order by its definition.
fn strahler(vertices: &[RiverVertex], i: usize) -> u8 {
    let upstream = (0..vertices.len()).filter(|&j| vertices[j].down == Some(i as u32));
    let orders: Vec<u8> = upstream.map(|j| strahler(vertices, j)).collect();
    let Some(&highest) = orders.iter().max() else { return 1 };
    highest + u8::from(orders.iter().filter(|&&order| order == highest).count() > 1)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn rivers_derive_order_and_length(vertices in forest()) {
        let rivers = Rivers::new(vertices.clone()).unwrap();
        for (i, vertex) in rivers.vertices().iter().enumerate() {
            prop_assert_eq!(vertex.order, strahler(&vertices, i));
            let mut length = 0.0;
            let mut at = i;
            while let Some(down) = vertices[at].down {
                let [a, b] = [vertices[at].at, vertices[down as usize].at];
                length += libm::hypot(a[0] - b[0], a[1] - b[1]);
                at = down as usize;
            }
            prop_assert!((f64::from(vertex.length) - length).abs() <= 1e-6 * length);
        }
    }

    #[test]
    fn rivers_come_back_from_a_cache(vertices in forest()) {
        let rivers = Rivers::new(vertices).unwrap();
        let load = Rivers::TYPE.load.unwrap();
        let back = load(&rivers.save()).unwrap();
        prop_assert_eq!(back.object::<Rivers>(), Some(&rivers));
    }

    #[test]
    fn rivers_and_ridges_refuse_hostile_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        // What is read has no fault, whatever the bytes were; most are refused.
        for load in [Rivers::TYPE.load.unwrap(), Ridges::TYPE.load.unwrap()] {
            if let Some(value) = load(&bytes) {
                let again = match (value.object::<Rivers>(), value.object::<Ridges>()) {
                    (Some(rivers), _) => rivers.save(),
                    (_, Some(ridges)) => ridges.save(),
                    _ => panic!("another type"),
                };
                prop_assert_eq!(again, bytes.clone());
            }
        }
    }

    #[test]
    fn rivers_in_any_order_are_sorted(vertices in forest(), turn in any::<u32>()) {
        let n = vertices.len();
        // A permutation of the vertices, and of who drains to whom.
        let moved = |i: usize| (i * 17 + turn as usize) % n.max(1);
        prop_assume!(n % 17 != 0);
        let mut shuffled = vertices.clone();
        for (i, vertex) in vertices.iter().enumerate() {
            shuffled[moved(i)] = RiverVertex { down: vertex.down.map(|down| moved(down as usize) as u32), ..*vertex };
        }
        let (sorted, given) = Rivers::sorted(&shuffled).unwrap();
        prop_assert_eq!(sorted.len(), n);
        for (i, vertex) in sorted.vertices().iter().enumerate() {
            let was = shuffled[given[i] as usize];
            prop_assert_eq!(vertex.at, was.at);
            prop_assert_eq!(vertex.down.map(|down| given[down as usize]), was.down);
        }
    }
}

#[test]
fn rivers_refuse_what_is_no_forest() {
    let chain = |down: Option<u32>| vec![vertex(0.0, 0.0, None), vertex(1.0, 0.0, down)];
    assert_eq!(Rivers::new(chain(Some(1))), Err(RiverFault::Order { vertex: 1, down: 1 }));
    assert_eq!(Rivers::new(chain(Some(7))), Err(RiverFault::Order { vertex: 1, down: 7 }));
    let missing = RiverFault::Missing { vertex: 1, down: 7, count: 2 };
    assert_eq!(Rivers::sorted(&chain(Some(7))).unwrap_err(), missing);
    let circle = [vertex(0.0, 0.0, Some(2)), vertex(1.0, 0.0, None), vertex(2.0, 0.0, Some(0))];
    assert!(matches!(Rivers::sorted(&circle), Err(RiverFault::Circle(0 | 2))));
    // What drains into a circle is not on it.
    let tail = [vertex(0.0, 0.0, Some(1)), vertex(1.0, 0.0, Some(2)), vertex(2.0, 0.0, Some(1))];
    assert!(matches!(Rivers::sorted(&tail), Err(RiverFault::Circle(1 | 2))));
}

#[test]
fn rivers_refuse_numbers_out_of_range_by_name() {
    type Setter = fn(&mut RiverVertex, f64);
    let set: [(&str, Setter); 5] = [
        ("x", |v, x| v.at[0] = x),
        ("y", |v, x| v.at[1] = x),
        ("height", |v, x| v.height = x),
        ("area", |v, x| v.area = x as f32),
        ("width", |v, x| v.width = x as f32),
    ];
    for (name, set) in set {
        for bad in [f64::NAN, f64::INFINITY, -1e12] {
            let mut vertices = vec![vertex(0.0, 0.0, None), vertex(1.0, 0.0, Some(0))];
            set(&mut vertices[1], bad);
            let said = Rivers::new(vertices).unwrap_err().to_string();
            assert!(said.starts_with(&format!("river vertex 1: `{name}` must be from")), "{said}");
        }
    }
}

#[test]
fn ridges_come_back_from_a_cache_and_refuse_what_is_none() {
    let at = |x: f64| RidgeVertex { at: [x, 2.0], height: x };
    let edge = RidgeEdge { ends: [0, 1], rivers: [4, 9], order: 3 };
    let ridges = Ridges::new(vec![at(0.0), at(5.0)], vec![edge, edge]).unwrap();
    let load = Ridges::TYPE.load.unwrap();
    assert_eq!(load(&ridges.save()).unwrap().object::<Ridges>(), Some(&ridges));
    let lost = RidgeEdge { ends: [0, 2], ..edge };
    let missing = RidgeFault::Missing { edge: 1, end: 2, count: 2 };
    assert_eq!(Ridges::new(vec![at(0.0), at(5.0)], vec![edge, lost]), Err(missing));
    assert!(Ridges::new(vec![at(f64::NAN)], vec![]).is_err());
    // A length that would overflow, and one that promises more than is there.
    for count in [u64::MAX, 1 << 60, 3] {
        let mut bytes = ridges.save();
        bytes[..8].copy_from_slice(&count.to_le_bytes());
        assert!(load(&bytes).is_none(), "{count}");
    }
}

#[test]
fn a_sketch_of_a_large_network_shows_its_larger_rivers() {
    // A comb: a stem of many vertices, each with a source beside it.
    let n = 120_000;
    let mut vertices = vec![vertex(0.0, 0.0, None)];
    for i in 1..n {
        let below = if i == 1 { 0 } else { 2 * i as u32 - 3 };
        vertices.push(vertex(i as f64, 0.0, Some(below)));
        vertices.push(vertex(i as f64, 5.0, Some(2 * i as u32 - 1)));
    }
    assert!(vertices.len() < MAX_VERTICES);
    let object = AnyObject::from(Rivers::new(vertices).unwrap());
    let Sketch::Lines(lines) = object.sketch() else { panic!("lines") };
    let points: usize = lines.iter().map(Vec::len).sum();
    assert!((1000..=110_000).contains(&points), "{points}");
    // The stem from its mouth to where it has no side branch any more.
    let longest = lines.iter().max_by_key(|line| line.len()).unwrap();
    assert_eq!((longest[0].0, longest[longest.len() - 1].0[0]), ([0.0, 0.0], (n - 2) as f64));
    let said = object.say([1000.2, 0.1]).unwrap();
    assert!(said.contains("order 2, bed 100.0 m, width 1.5 m"), "{said}");
}

#[test]
fn a_sketch_shows_every_link_of_a_small_network_once() {
    let links = [None, Some(0), Some(1), Some(1), Some(0), Some(4)];
    let vertices: Vec<RiverVertex> =
        links.iter().enumerate().map(|(i, down)| vertex(i as f64, (i * i) as f64, *down)).collect();
    let rivers = Rivers::new(vertices).unwrap();
    let Sketch::Lines(lines) = rivers.sketch() else { panic!("lines") };
    let mut drawn: Vec<[f64; 2]> =
        lines.iter().flat_map(|line| line.windows(2)).map(|pair| [pair[1].0[0], pair[0].0[0]]).collect();
    drawn.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let links: Vec<[f64; 2]> = rivers.links().map(|(upper, lower)| [upper as f64, lower as f64]).collect();
    assert_eq!(drawn, links);
}
