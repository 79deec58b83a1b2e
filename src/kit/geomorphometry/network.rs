//! The orders of streams, and how they branch.

use std::cmp::Ordering;

use serde::Serialize;

use super::line::Line;

/// Fewest streams of an order that its side branches are counted for.
const FEWEST: f64 = 3.0;

/// A place in a network of streams.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// The node downstream, whose index is larger; none at a mouth.
    pub down: Option<u32>,
    /// Way to the node downstream, in metres.
    pub length: f64,
    /// Drained area, in m².
    pub area: f64,
}

/// Streams of one order \[strahler1957\]. A stream runs from where its order begins to where a higher one does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Order {
    /// The order, 1 for streams from a source.
    pub order: usize,
    /// Number of streams.
    pub streams: usize,
    /// Mean length, in metres.
    pub mean_length: f64,
    /// Mean drained area at the end, in m².
    pub mean_area: f64,
}

/// How the streams of a network branch: \[horton1945\] and \[tokunaga1978\].
///
/// The ratios are the bases of powers of the order, fitted to the orders with two streams or more: a single stream of the
/// highest order is cut by the border.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Network {
    /// The streams of each order, 1 first.
    pub orders: Vec<Order>,
    /// Bifurcation ratio `R_B`: streams of an order for each stream of the next.
    pub bifurcation_ratio: Option<f64>,
    /// Length ratio `R_L`: mean length of an order over that of the one before.
    pub length_ratio: Option<f64>,
    /// Area ratio `R_A`: mean area of an order over that of the one before.
    pub area_ratio: Option<f64>,
    /// `T_1`, `T_2`, …: mean number of side branches whose order is lower by 1, 2, … than that of the stream they join.
    pub side_branches: Vec<f64>,
    /// `a` and `c` of `T_k = a c^(k−1)`.
    pub tokunaga: Option<Tokunaga>,
}

/// The law of side branches, `T_k = a c^(k−1)`, fitted to three or more of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Tokunaga {
    /// Side branches of the next lower order, on a stream.
    pub a: f64,
    /// Factor to each lower order.
    pub c: f64,
    /// Coefficient of determination.
    pub r2: f64,
}

impl Network {
    /// The figures of a forest of nodes, upstream first; none without a node.
    ///
    /// # Panics
    /// When a node is not followed by the one downstream of it: that is a bug of the caller.
    pub fn of(nodes: &[Node]) -> Option<Self> {
        let streams = Streams::of(nodes);
        let orders = streams.orders();
        if orders.is_empty() {
            return None;
        }
        let several = || orders.iter().filter(|order| order.streams >= 2);
        let ratio = |of: fn(&Order) -> f64| {
            let points: Vec<_> = several().map(|o| [o.order as f64, libm::log(of(o))]).collect();
            let line = Some(points).filter(|points| points.len() >= 3).and_then(Line::even)?;
            Some(libm::exp(line.slope))
        };
        let side = streams.side_branches(&orders);
        Some(Self {
            bifurcation_ratio: ratio(|o| o.streams as f64).map(f64::recip),
            length_ratio: ratio(|o| o.mean_length),
            area_ratio: ratio(|o| o.mean_area),
            tokunaga: Tokunaga::fit(&side),
            side_branches: side.iter().map(|(mean, _)| *mean).collect(),
            orders,
        })
    }

    /// The highest order.
    pub fn highest_order(&self) -> usize {
        self.orders.len()
    }
}

impl Tokunaga {
    /// Fits the mean numbers of side branches, each with the number of streams behind it.
    fn fit(side: &[(f64, f64)]) -> Option<Self> {
        let some = side.iter().enumerate().filter(|(_, (mean, _))| *mean > 0.0);
        let points: Vec<_> = some.map(|(k, (mean, n))| [k as f64, libm::log(*mean), n.sqrt()]).collect();
        let line = if points.len() < 3 { None } else { Line::through(&points) };
        line.map(|Line { intercept, slope, r2 }| Self { a: libm::exp(intercept), c: libm::exp(slope), r2 })
    }
}

/// What comes to a node from upstream.
#[derive(Clone, Copy, Debug, Default)]
struct Joint {
    /// The highest order; 0 at a source.
    highest: u8,
    /// How many streams have it, 2 at most.
    count: u8,
}

impl Joint {
    fn all(nodes: &[Node]) -> Vec<Self> {
        let mut joints = vec![Self::default(); nodes.len()];
        for (i, node) in nodes.iter().enumerate() {
            let order = joints[i].order() as u8;
            let Some(down) = node.down.map(|down| down as usize) else { continue };
            assert!(down > i, "a node is followed by the one downstream of it");
            let joint = &mut joints[down];
            match order.cmp(&joint.highest) {
                Ordering::Greater => *joint = Self { highest: order, count: 1 },
                Ordering::Equal => joint.count = 2,
                Ordering::Less => (),
            }
        }
        joints
    }

    /// The order of the node itself. An order takes twice as many sources as the one below it, so that a byte holds it.
    fn order(self) -> usize {
        usize::from(self.highest) + usize::from(self.highest == 0 || self.count >= 2)
    }
}

/// Streams as they are counted.
#[derive(Default)]
struct Streams {
    /// For each order from 1: number, sum of lengths, sum of areas.
    sums: Vec<[f64; 3]>,
    /// How many streams of order `i + 1` join the side of one of order `j + 1`, at `[i][j]`.
    side: Vec<Vec<f64>>,
}

impl Streams {
    fn of(nodes: &[Node]) -> Self {
        let joints = Joint::all(nodes);
        let highest = joints.iter().map(|joint| joint.order()).max().unwrap_or(0);
        let mut streams = Self { sums: vec![[0.0; 3]; highest], side: vec![vec![0.0; highest]; highest] };
        let mut length = vec![0.0f64; nodes.len()];
        // How many of the streams that make the order of a node have come to it.
        let mut come = vec![0u8; nodes.len()];
        for (i, node) in nodes.iter().enumerate() {
            let own = joints[i].order();
            let long = length[i] + node.length;
            if let Some(down) = node.down.map(|down| down as usize) {
                let next = joints[down].order();
                if next == own {
                    // The same stream goes on; of several ways to its beginning the longest counts.
                    length[down] = length[down].max(long);
                    continue;
                }
                // Two streams make the order of the joint; a third one of the same order joins its side.
                if usize::from(joints[down].highest) == own && come[down] < 2 {
                    come[down] += 1;
                } else {
                    streams.side[own - 1][next - 1] += 1.0;
                }
            }
            let [count, lengths, areas] = &mut streams.sums[own - 1];
            *count += 1.0;
            *lengths += long;
            *areas += node.area;
        }
        streams
    }

    fn orders(&self) -> Vec<Order> {
        let order = |(k, [count, length, area]): (usize, &[f64; 3])| Order {
            order: k + 1,
            streams: *count as usize,
            mean_length: length / count,
            mean_area: area / count,
        };
        self.sums.iter().enumerate().map(order).collect()
    }

    /// `T_k` from `k = 1`, and the streams behind each: the mean over the orders that are `k` apart, by the number of
    /// streams joined.
    fn side_branches(&self, orders: &[Order]) -> Vec<(f64, f64)> {
        let joined = |k: usize| {
            let pairs = (0..orders.len().saturating_sub(k)).map(move |low| (low, low + k));
            let pairs = pairs.filter(|(_, high)| orders[*high].streams as f64 >= FEWEST);
            pairs.fold([0.0; 2], |[n, sum], (low, high)| {
                [n + orders[high].streams as f64, sum + self.side[low][high]]
            })
        };
        let all = (1..orders.len()).map(joined).take_while(|[n, _]| *n > 0.0);
        all.map(|[n, sum]| (sum / n, n)).collect()
    }
}
