//! Depressions against brute force, channels whose law is chosen, networks that are counted.

use orograph::kit::geomorphometry::{Figures, Land, Network, Node, RiverFigures};
use orograph::kit::hash;
use orograph::value::{RiverVertex, Rivers};
use orograph::work::Work;

use super::{figures, land, near};

/// Land of whole heights by chance, some of it void, beside its plain figures.
struct Chance {
    cols: usize,
    rows: usize,
    heights: Vec<f32>,
}

impl Chance {
    fn new(cols: usize, rows: usize, steps: u64, voids: u64, seed: u64) -> Self {
        let height = |k: u64| match hash::nth(seed, 2 * k) % 100 {
            void if void < voids => f32::NAN,
            _ => (hash::nth(seed, 2 * k + 1) % steps) as f32,
        };
        Self { cols, rows, heights: (0..(cols * rows) as u64).map(height).collect() }
    }

    /// The neighbours of a cell; none where one of the eight is not there or void.
    fn inland(&self, at: usize) -> Option<Vec<usize>> {
        let (i, j) = (at % self.cols, at / self.cols);
        let inside = i > 0 && j > 0 && i + 1 < self.cols && j + 1 < self.rows;
        let all = || (j - 1..=j + 1).flat_map(|y| (i - 1..=i + 1).map(move |x| y * self.cols + x));
        let whole = inside && all().all(|k| self.heights[k].is_finite());
        whole.then(|| all().filter(|k| *k != at).collect())
    }

    /// Levels found by letting water off until nothing changes.
    fn levels(&self) -> Vec<f32> {
        let start = |at: usize| if self.inland(at).is_some() { f32::MAX } else { self.heights[at] };
        let mut level: Vec<f32> = (0..self.heights.len()).map(start).collect();
        loop {
            let mut is_same = true;
            for at in 0..level.len() {
                let Some(around) = self.inland(at) else { continue };
                let lowest = around.iter().map(|k| level[*k]).fold(f32::MAX, f32::min);
                let new = lowest.max(self.heights[at]);
                is_same &= new == level[at];
                level[at] = new;
            }
            if is_same {
                return level;
            }
        }
    }
}

#[test]
fn depressions_are_those_of_brute_force() {
    for (seed, (cols, rows, steps, voids)) in
        [(24, 17, 9, 0), (31, 22, 4, 6), (9, 40, 30, 3), (40, 40, 1000, 1), (12, 12, 2, 0)]
            .into_iter()
            .enumerate()
    {
        let chance = Chance::new(cols, rows, steps, voids, seed as u64 + 1);
        let level = chance.levels();
        let found = figures(&Land::new(cols, rows, 10.0, chance.heights.clone())).depressions;
        let land: Vec<usize> = (0..level.len()).filter(|at| chance.heights[*at].is_finite()).collect();
        let count = |is: &dyn Fn(usize) -> bool| land.iter().filter(|at| is(**at)).count() as f64;
        let (all, z) = (land.len() as f64, &chance.heights);
        let inland =
            |at: usize, is: &dyn Fn(usize) -> bool| chance.inland(at).is_some_and(|k| k.into_iter().all(is));
        near(found.pits_per_1000, 1000.0 * count(&|at| inland(at, &|k| z[k] > z[at])) / all, 1e-9);
        near(found.filled, count(&|at| level[at] > z[at]) / all, 1e-12);
        near(found.filled_or_level, count(&|at| inland(at, &|k| level[k] >= level[at])) / all, 1e-12);
        let depths: Vec<f64> =
            land.iter().map(|at| f64::from(level[*at] - z[*at])).filter(|d| *d > 0.0).collect();
        let volume: f64 = depths.iter().sum();
        near(found.mean_depth, volume / depths.len().max(1) as f64, 1e-9);
        let heights = || land.iter().map(|at| f64::from(z[*at]));
        let relief = heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min);
        near(found.volume, volume / (all * relief), 1e-9);
    }
}

/// Rows of a valley: long enough for bins of areas over 1 km².
const ROWS: usize = 4000;

/// A valley between straight flanks, whose bed falls by `A^−θ`.
fn valley(theta: f64) -> Figures {
    let (cols, rows, cell) = (41, ROWS, 10.0);
    let area = |j: usize| (j + 1) as f64 * cols as f64 * cell * cell;
    let mut bed = vec![0.0; rows];
    for j in (0..rows - 1).rev() {
        bed[j] = bed[j + 1] + cell * 4.0 * libm::pow(area(j), -theta);
    }
    figures(&land(cols, rows, cell, |i, j| bed[j as usize] + cell * (i - 20.0).abs()))
}

#[test]
fn a_valley_has_the_concavity_it_was_made_with() {
    for theta in [0.35, 0.5] {
        let found = valley(theta).channels.expect("a channel");
        // Near the source the mean over some steps is less than the slope.
        let large = [found.concavity_1km2, found.concavity_unfilled_1km2];
        for fit in large.map(|fit| fit.expect("a fit")) {
            near(fit.value, theta, 0.02);
            assert!(fit.r2 > 0.98, "{fit:?}");
        }
        // Each row of the flanks drains into the one channel.
        assert_eq!((found.filled, found.straight_run, found.channel_axis_share), (0.0, None, Some(1.0)));
        let length = (ROWS - 1 - 4) as f64 * 10.0;
        near(found.density, 1000.0 * length / (41.0 * ROWS as f64 * 100.0), 1e-9);
        near(found.relative_density, found.density / 1000.0 * (200.0f64 * 100.0).sqrt(), 1e-9);
        // Flanks of 20 cells are a part of every way.
        near(found.hack.expect("a fit").value, 0.95, 0.05);
        assert_eq!(found.threshold, 20_000.0);
    }
}

#[test]
fn channels_begin_where_they_are_told_to() {
    let given = land(60, 400, 5.0, |i, j| 2.0 * (400.0 - j) + 20.0 * (i - 30.0).abs());
    let of = |area: f64| Figures::of(&given, Some(area), &Work::default()).unwrap().expect("land").channels;
    let [long, short] = [1500.0, 150_000.0].map(|area| of(area).expect("a channel"));
    assert_eq!([long.threshold, short.threshold], [1500.0, 150_000.0]);
    assert!(long.density > short.density);
    assert_eq!(of(1e9), None, "nothing drains so much");
}

/// A stream of an order, upstream first, onto a list of nodes: it is made by two of the order below, and has side branches
/// `T_k = a c^(k−1)` of each lower order. The number of its last node is returned.
fn stream(order: usize, [a, c]: [usize; 2], nodes: &mut Vec<Node>) -> usize {
    let node = Node { down: None, length: 10.0, area: 0.0 };
    let join = |nodes: &mut Vec<Node>, into: usize, from: Vec<usize>| {
        for from in from {
            nodes[from].down = Some(into as u32);
        }
    };
    if order == 1 {
        nodes.push(node);
        return nodes.len() - 1;
    }
    let made: Vec<usize> = (0..2).map(|_| stream(order - 1, [a, c], nodes)).collect();
    nodes.push(node);
    let mut last = nodes.len() - 1;
    join(nodes, last, made);
    for low in 1..order {
        for _ in 0..a * (0..order - low - 1).fold(1, |power, _| power * c) {
            let side = stream(low, [a, c], nodes);
            nodes.push(node);
            let next = nodes.len() - 1;
            join(nodes, next, vec![last, side]);
            last = next;
        }
    }
    last
}

/// Drained areas: so much for each node and all above it.
fn drain(nodes: &mut [Node], own: f64) {
    for i in 0..nodes.len() {
        nodes[i].area += own;
        if let Some(down) = nodes[i].down {
            nodes[down as usize].area += nodes[i].area;
        }
    }
}

#[test]
fn a_network_by_the_law_of_tokunaga_is_recognised() {
    for (a, c) in [(1, 2), (2, 3), (1, 1)] {
        let mut nodes = Vec::new();
        stream(6, [a, c], &mut nodes);
        drain(&mut nodes, 100.0);
        let found = Network::of(&nodes).expect("a network");
        assert_eq!(found.highest_order(), 6);
        // Only orders with three streams or more tell of side branches: the fifth is the highest of these.
        let want: Vec<f64> = (0..4).map(|k| libm::pow(c as f64, f64::from(k)) * a as f64).collect();
        for (found, want) in found.side_branches.iter().zip(&want) {
            near(*found, *want, 1e-12);
        }
        assert!(found.side_branches.len() >= 3, "{found:?}");
        let law = found.tokunaga.expect("a law");
        near(law.a, a as f64, 1e-9);
        near(law.c, c as f64, 1e-9);
        // The number of streams of each order, by counting back from the one of the highest.
        let mut streams = [0usize; 7];
        streams[6] = 1;
        for order in (1..6).rev() {
            let side = (order + 1..=6)
                .map(|high| streams[high] * a * (0..high - order - 1).fold(1, |power, _| power * c));
            streams[order] = 2 * streams[order + 1] + side.sum::<usize>();
        }
        let counted: Vec<usize> = found.orders.iter().map(|order| order.streams).collect();
        assert_eq!(counted, streams[1..]);
        assert_eq!(found.orders[0].mean_length, 10.0);
        assert_eq!(found.orders[0].mean_area, 100.0);
        near(found.orders[5].mean_area, 100.0 * nodes.len() as f64, 1e-6);
    }
}

#[test]
fn three_equal_streams_make_one_order_and_one_side_branch() {
    let node = |down: Option<u32>| Node { down, length: 1.0, area: 1.0 };
    let nodes = [node(Some(3)), node(Some(3)), node(Some(3)), node(None)];
    let found = Network::of(&nodes).expect("a network");
    let streams: Vec<usize> = found.orders.iter().map(|order| order.streams).collect();
    assert_eq!(streams, [3, 1]);
    assert_eq!((found.bifurcation_ratio, found.tokunaga, found.side_branches.len()), (None, None, 0));
    assert_eq!(Network::of(&[]), None);
}

/// A network that was drawn has the figures of the nodes it is made of.
#[test]
fn drawn_rivers_are_counted_from_their_sources() {
    let vertex = |x: f64, y: f64, down: Option<u32>, area: f32| RiverVertex {
        at: [x, y],
        down,
        area,
        ..Default::default()
    };
    let all = [
        vertex(0.0, 0.0, None, 9.0),
        vertex(0.0, 30.0, Some(0), 8.0),
        vertex(40.0, 60.0, Some(1), 3.0),
        vertex(0.0, 70.0, Some(1), 4.0),
        vertex(900.0, 0.0, None, 1.0),
        vertex(900.0, 5.0, Some(4), 1.0),
    ];
    let rivers = Rivers::new(all.to_vec()).expect("a network");
    let found = RiverFigures::of(&rivers).expect("figures");
    assert_eq!((found.vertices, found.outlets), (6, 2));
    assert_eq!((found.length, found.longest), (30.0 + 50.0 + 40.0 + 5.0, 80.0));
    let orders: Vec<_> =
        found.network.orders.iter().map(|o| (o.streams, o.mean_length, o.mean_area)).collect();
    assert_eq!(orders, [(3, 95.0 / 3.0, 8.0 / 3.0), (1, 30.0, 9.0)]);
    let highest = rivers.vertices().iter().map(|vertex| vertex.order).max();
    assert_eq!(highest.map(usize::from), Some(found.network.highest_order()));
    assert_eq!(RiverFigures::of(&Rivers::default()), None);
}
