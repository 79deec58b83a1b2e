//! What rasterised curves say about the samples of a grid.

use std::sync::Arc;

use super::{Grid, Object, ObjectType, Pin, Sketch, SketchMark};

/// What is known of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Its height.
    Height,
    /// Direction and steepness of its gradient.
    Gradient,
    /// Amplitude and roughness of its noise.
    Noise,
    /// That a slope holds it whose gradient is not known there: gradients cancel.
    Open,
    /// That a plateau ends within a step of it: its height is that of the plateau, [`Planes::lean`] says how far off.
    Edge,
}

impl Mark {
    /// Its bit in [`Planes::marks`].
    pub const fn bit(self) -> u8 {
        match self {
            Self::Height => 1,
            Self::Gradient => 2,
            Self::Noise => 4,
            Self::Open => 8,
            Self::Edge => 16,
        }
    }
}

/// One value per sample in row order; a plane that no curve asks for is not there. What is not marked is 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Planes {
    /// Bits of [`Mark`].
    pub marks: Vec<u8>,
    /// Height of the plateau that holds the sample, or ends right beside it; where [`Planes::ground`] is above 0, that of
    /// the ground between the slopes that meet. In metres.
    pub height: Option<Vec<f32>>,
    /// How the edge of a plateau lies between samples: the direction away from it, as long as the share of the
    /// neighbours over there in the height of the sample; the plateau has the rest. 0 where the plateau alone counts.
    pub lean: Option<Vec<[f32; 2]>>,
    /// The direction, of length one, in which heights flow: x east, y south.
    pub direction: Option<Vec<[f32; 2]>>,
    /// Rise along that direction, as a tangent, below 0 where the ground falls: the mean over the step to the sample from
    /// the neighbours that heights flow from.
    pub steepness: Option<Vec<f32>>,
    /// How far the gradient of a sample is followed, from 0 to 1: less towards the ends of a slope.
    pub trust: Option<Vec<f32>>,
    /// How far the height is followed where slopes of several curves meet, from 0 to 1; there the gradient is followed as
    /// far as [`Planes::trust`] besides.
    pub ground: Option<Vec<f32>>,
    /// Amplitude in metres and roughness from 0 to 1.
    pub noise: Option<Vec<[f32; 2]>>,
    /// Weight of smoothing into an existing terrain, from 0 to 1.
    pub envelope: Option<Vec<f32>>,
}

/// The maps that diffusion starts from; cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints {
    grid: Grid,
    planes: Arc<Planes>,
}

impl Constraints {
    /// Wraps planes in row order.
    ///
    /// # Panics
    /// When a plane has not one value per grid point: that is a bug of the caller.
    pub fn new(grid: Grid, planes: Planes) -> Self {
        let n = grid.len();
        let fits = |len: Option<usize>| len.is_none_or(|len| len == n);
        let Planes { marks, height, lean, direction, steepness, trust, ground, noise, envelope } = &planes;
        let all = [
            Some(marks.len()),
            height.as_ref().map(Vec::len),
            lean.as_ref().map(Vec::len),
            direction.as_ref().map(Vec::len),
            steepness.as_ref().map(Vec::len),
            trust.as_ref().map(Vec::len),
            ground.as_ref().map(Vec::len),
            noise.as_ref().map(Vec::len),
            envelope.as_ref().map(Vec::len),
        ];
        assert!(all.into_iter().all(fits), "one value per grid point");
        Self { grid, planes: Arc::new(planes) }
    }

    /// Where the samples stand.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// All planes.
    pub fn planes(&self) -> &Planes {
        &self.planes
    }

    /// Whether something is known of the sample at a column and row of the window.
    pub fn has(&self, mark: Mark, [col, row]: [usize; 2]) -> bool {
        self.planes.marks[row * self.grid.cols + col] & mark.bit() != 0
    }

    /// The height at a column and row of the window, in metres.
    pub fn height(&self, [col, row]: [usize; 2]) -> Option<f32> {
        let height = self.planes.height.as_ref()?[row * self.grid.cols + col];
        self.has(Mark::Height, [col, row]).then_some(height)
    }

    /// Where a plateau ends right beside a column and row of the window: its height, and its lean.
    pub fn edge(&self, [col, row]: [usize; 2]) -> Option<(f32, [f32; 2])> {
        let at = row * self.grid.cols + col;
        let both = (self.planes.height.as_ref()?[at], self.planes.lean.as_ref()?[at]);
        (self.has(Mark::Edge, [col, row]) || both.1 != [0.0; 2]).then_some(both)
    }

    /// Where slopes of several curves meet at a column and row of the window: the height between theirs, and how far it is
    /// followed.
    pub fn ground(&self, [col, row]: [usize; 2]) -> Option<(f32, f32)> {
        let at = row * self.grid.cols + col;
        let both = (self.planes.height.as_ref()?[at], self.planes.ground.as_ref()?[at]);
        (both.1 > 0.0).then_some(both)
    }

    /// Direction and steepness at a column and row of the window.
    pub fn gradient(&self, [col, row]: [usize; 2]) -> Option<([f32; 2], f32)> {
        let at = row * self.grid.cols + col;
        let both = (self.planes.direction.as_ref()?[at], self.planes.steepness.as_ref()?[at]);
        self.has(Mark::Gradient, [col, row]).then_some(both)
    }

    /// Amplitude and roughness at a column and row of the window.
    pub fn noise(&self, [col, row]: [usize; 2]) -> Option<[f32; 2]> {
        let both = self.planes.noise.as_ref()?[row * self.grid.cols + col];
        self.has(Mark::Noise, [col, row]).then_some(both)
    }

    /// Weight of the envelope at a column and row of the window; 0 without one.
    pub fn envelope(&self, [col, row]: [usize; 2]) -> f32 {
        self.planes.envelope.as_ref().map_or(0.0, |p| p[row * self.grid.cols + col])
    }

    /// 1 where something is known and 0 elsewhere, in row order.
    pub fn mask(&self, mark: Mark) -> Vec<f32> {
        let one = |&m: &u8| if m & mark.bit() != 0 { 1.0 } else { 0.0 };
        self.planes.marks.iter().map(one).collect()
    }

    /// Column and row of the first sample, in row order, of a plane that has a number that is not finite.
    fn first_not_finite(&self) -> Option<(usize, usize)> {
        let Planes { height, lean, direction, steepness, trust, ground, noise, envelope, .. } = &*self.planes;
        let first = |plane: Option<&[f32]>, channels: usize| {
            plane.and_then(|p| p.iter().position(|v| !v.is_finite())).map(|at| at / channels)
        };
        let pairs = |plane: &Option<Vec<[f32; 2]>>| first(plane.as_deref().map(bytemuck::cast_slice), 2);
        let single = |plane: &Option<Vec<f32>>| first(plane.as_deref(), 1);
        let found = [
            single(height),
            pairs(lean),
            pairs(direction),
            single(steepness),
            single(trust),
            single(ground),
            pairs(noise),
            single(envelope),
        ];
        found.into_iter().flatten().min().map(|at| (at % self.grid.cols, at / self.grid.cols))
    }
}

impl Object for Constraints {
    const TYPE: &'static ObjectType = &ObjectType {
        name: "constraints",
        color: [226, 104, 20],
        pin: Pin::Polygon { corners: 6, turn: 0.0 },
        sample_bytes: 45,
        guessed_bytes: 0,
        load: None,
        has_features: false,
    };

    fn bytes(&self) -> u64 {
        let p = &*self.planes;
        let per_sample = 1
            + 4 * u64::from(p.height.is_some())
            + 8 * u64::from(p.lean.is_some())
            + 8 * u64::from(p.direction.is_some())
            + 4 * u64::from(p.steepness.is_some())
            + 4 * u64::from(p.trust.is_some())
            + 4 * u64::from(p.ground.is_some())
            + 8 * u64::from(p.noise.is_some())
            + 4 * u64::from(p.envelope.is_some());
        per_sample * self.grid.len() as u64
    }

    fn grid(&self) -> Option<&Grid> {
        Some(&self.grid)
    }

    fn fault(&self) -> Option<String> {
        let (col, row) = self.first_not_finite()?;
        Some(format!("is not finite at column {col}, row {row}"))
    }

    fn sketch(&self) -> Sketch {
        let (cols, rows) = (self.grid.cols, self.grid.rows);
        let mark = |at: [usize; 2]| match self.height(at) {
            Some(height) => SketchMark::Height(height),
            None if self.has(Mark::Gradient, at) => SketchMark::Strong,
            None if self.has(Mark::Noise, at) => SketchMark::Weak,
            None => SketchMark::Nothing,
        };
        Sketch::Marks(self.grid, (0..cols * rows).map(|i| mark([i % cols, i / cols])).collect())
    }

    fn say(&self, at: [f64; 2]) -> Option<String> {
        let cell = self.grid.nearest(at);
        let height = self.height(cell).map(|h| format!("height {h:.1} m"));
        let slope =
            self.gradient(cell).map(|(_, s)| format!("slope {:.1}°", libm::atan(s.into()).to_degrees()));
        let all: Vec<_> = height.into_iter().chain(slope).collect();
        Some(if all.is_empty() { "nothing is said".to_owned() } else { all.join(", ") })
    }
}
