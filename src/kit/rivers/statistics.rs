//! Horton's and Tokunaga's figures of a network \[horton1945; peckham1995\].

/// Streams and side branches of each order. A stream is a run of links of one Strahler order, as long as can be.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Number of streams of order 1, 2 and so on.
    pub streams: Vec<usize>,
    /// `sides[i][j]` streams of order i + 1 join ones of order j + 1 from the side.
    pub sides: Vec<Vec<usize>>,
}

/// The streams that join at a link.
#[derive(Clone, Copy, Default)]
struct Joint {
    /// Highest of their orders.
    highest: usize,
    /// How many have it.
    of_highest: usize,
    /// How many of those have been counted as makers of the stream below.
    makers: usize,
}

impl Statistics {
    /// Of links: the link downstream of each, downstream first. Links of a network of vertices have the numbers of their
    /// upper vertices, and an outlet counts as a link.
    pub fn of(down: &[Option<u32>]) -> Self {
        let (orders, mut joints) = strahler(down);
        let highest = orders.iter().copied().max().unwrap_or(0);
        let mut found = Self { streams: vec![0; highest], sides: vec![vec![0; highest]; highest] };
        for (&order, below) in orders.iter().zip(down) {
            let below = below.map(|below| below as usize);
            if below.is_some_and(|below| orders[below] == order) {
                continue;
            }
            found.streams[order - 1] += 1;
            if let Some(below) = below {
                let joint = &mut joints[below];
                // Two of the highest order make a stream of the next one; others join it from the side.
                if order == joint.highest && joint.makers < 2 {
                    joint.makers += 1;
                } else {
                    found.sides[order - 1][orders[below] - 1] += 1;
                }
            }
        }
        found
    }

    /// Horton's bifurcation ratio of each order: its streams for each one of the next.
    pub fn bifurcation(&self) -> Vec<f64> {
        self.streams.windows(2).map(|pair| pair[0] as f64 / pair[1].max(1) as f64).collect()
    }

    /// Tokunaga's `T_1`, `T_2` and so on: streams k orders lower that join a stream from the side, the mean over orders of
    /// their means over streams. `T_1` of orders 1 and 2, 2 and 3, and so on.
    pub fn side_branches(&self) -> Vec<f64> {
        let highest = self.streams.len();
        let mean = |k: usize| {
            let each = (k..highest).map(|j| self.sides[j - k][j] as f64 / self.streams[j] as f64);
            each.sum::<f64>() / (highest - k) as f64
        };
        (1..highest).map(mean).collect()
    }
}

/// The Strahler order of each link, and what joins there.
fn strahler(down: &[Option<u32>]) -> (Vec<usize>, Vec<Joint>) {
    let mut joints = vec![Joint::default(); down.len()];
    let mut orders = vec![0; down.len()];
    for i in (0..down.len()).rev() {
        let Joint { highest, of_highest, .. } = joints[i];
        let order = highest.max(1) + usize::from(of_highest > 1);
        orders[i] = order;
        if let Some(below) = down[i] {
            let joint = &mut joints[below as usize];
            if order > joint.highest {
                (joint.highest, joint.of_highest) = (order, 1);
            } else if order == joint.highest {
                joint.of_highest += 1;
            }
        }
    }
    (orders, joints)
}
