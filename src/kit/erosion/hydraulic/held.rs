//! The rows that a sweep has in hand.

use crate::kit::erosion::lines::Lines;

/// Rows of what is known of cells and of edges while a sweep passes over them.
#[derive(Clone, Debug)]
pub(super) struct Held {
    /// Of cells: depth, change of bed and of surface, load per water, square of the flow vector, what they can give.
    pub(super) depth: Lines,
    pub(super) bed: Lines,
    pub(super) surface: Lines,
    pub(super) thick: Lines,
    pub(super) square: Lines,
    pub(super) can: Lines,
    /// Of edges to the east, south, south-east and south-west: flow; wetted depth, then fall of the bed; drop of the surface,
    /// then power; load that crosses.
    pub(super) flow: [Lines; 4],
    pub(super) deep: [Lines; 4],
    pub(super) drop: [Lines; 4],
    pub(super) load: [Lines; 4],
    /// A row of zeros, with a sample before and after, and one of ones.
    pub(super) none: Vec<f32>,
    pub(super) one: Vec<f32>,
    /// Room for a row.
    pub(super) spare: Vec<f32>,
    pub(super) swept: Swept,
}

impl Held {
    pub(super) fn new(cols: usize) -> Self {
        let lines = || Lines::new(cols);
        let four = || [lines(), lines(), lines(), lines()];
        Self {
            depth: lines(),
            bed: lines(),
            surface: lines(),
            thick: lines(),
            square: lines(),
            can: lines(),
            flow: four(),
            deep: four(),
            drop: four(),
            load: four(),
            none: vec![0.0; cols + 2],
            one: vec![1.0; cols],
            spare: vec![0.0; cols],
            swept: Swept::default(),
        }
    }
}

/// What a sweep moved, in metres of water summed over each row of its band: sums of rows, so that the bands show nowhere.
#[derive(Clone, Debug, Default)]
pub(super) struct Swept {
    pub(super) rained: Vec<f64>,
    pub(super) evaporated: Vec<f64>,
    pub(super) sea: Vec<f64>,
}

impl Swept {
    pub(super) fn clear(&mut self) {
        self.rained.clear();
        self.evaporated.clear();
        self.sea.clear();
    }
}
