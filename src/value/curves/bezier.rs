//! One cubic piece: points, derivatives, halves and length.

/// A point of the plane in metres, x to the east and y to the south.
pub type Point = [f64; 2];

/// `a + b`.
#[inline]
pub fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1]]
}

/// `a − b`.
#[inline]
pub fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

/// `a · k`.
#[inline]
pub fn times(a: Point, k: f64) -> Point {
    [a[0] * k, a[1] * k]
}

/// Scalar product.
#[inline]
pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

/// Length of a vector; without `hypot`, which differs between platforms.
#[inline]
pub fn norm(a: Point) -> f64 {
    dot(a, a).sqrt()
}

/// From `a` to `b` by a share.
#[inline]
pub fn mix(a: Point, b: Point, t: f64) -> Point {
    [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t]
}

/// The vector to the left of a heading: north of one to the east, since y grows to the south.
#[inline]
pub fn left_of(heading: Point) -> Point {
    [heading[1], -heading[0]]
}

/// A cubic Bézier piece: its start, two handles and its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic(pub [Point; 4]);

/// Abscissae and weights of the Gauss-Legendre rule of eight points on −1 to 1.
const GAUSS: [[f64; 2]; 4] = [
    [0.183_434_642_495_649_8, 0.362_683_783_378_362],
    [0.525_532_409_916_329, 0.313_706_645_877_887_3],
    [0.796_666_477_413_626_7, 0.222_381_034_453_374_48],
    [0.960_289_856_497_536_2, 0.101_228_536_290_376_26],
];

/// How often an interval is halved at most while its length is measured; cusps alone come near.
const DEPTH: u32 = 14;

impl Cubic {
    /// A straight piece of even speed.
    pub fn straight(from: Point, to: Point) -> Self {
        Self([from, mix(from, to, 1.0 / 3.0), mix(from, to, 2.0 / 3.0), to])
    }

    /// The point at `t`.
    pub fn at(&self, t: f64) -> Point {
        let [a, b, c, d] = self.0;
        let (ab, bc, cd) = (mix(a, b, t), mix(b, c, t), mix(c, d, t));
        mix(mix(ab, bc, t), mix(bc, cd, t), t)
    }

    /// The derivative at `t`.
    pub fn derivative(&self, t: f64) -> Point {
        let [a, b, c, d] = self.0;
        let (u, v, w) = (sub(b, a), sub(c, b), sub(d, c));
        let s = 1.0 - t;
        let at = |i: usize| 3.0 * (s * s * u[i] + 2.0 * s * t * v[i] + t * t * w[i]);
        [at(0), at(1)]
    }

    /// The heading at `t`, of length one; where the derivative vanishes that of the nearest handle that does not;
    /// `None` when all four points are one.
    pub fn heading(&self, t: f64) -> Option<Point> {
        let [a, b, c, d] = self.0;
        let size = norm(sub(b, a)) + norm(sub(c, b)) + norm(sub(d, c));
        let secant = if t < 0.5 { sub(c, a) } else { sub(d, b) };
        [self.derivative(t), secant, sub(d, a), sub(b, a), sub(d, c)].into_iter().find_map(|v| {
            let length = norm(v);
            (length > 1e-12 * size && length > 0.0).then(|| times(v, 1.0 / length))
        })
    }

    /// The two halves.
    pub fn halves(&self) -> [Self; 2] {
        self.split(0.5)
    }

    /// The parts before and after `t`.
    pub fn split(&self, t: f64) -> [Self; 2] {
        let [a, b, c, d] = self.0;
        let (ab, bc, cd) = (mix(a, b, t), mix(b, c, t), mix(c, d, t));
        let (abc, bcd) = (mix(ab, bc, t), mix(bc, cd, t));
        let m = mix(abc, bcd, t);
        [Self([a, ab, abc, m]), Self([m, bcd, cd, d])]
    }

    /// The part from `t0` to `t1`.
    pub fn part(&self, t0: f64, t1: f64) -> Self {
        let first = if t1 >= 1.0 { *self } else { self.split(t1)[0] };
        if t0 <= 0.0 || t1 <= 0.0 { first } else { first.split((t0 / t1).min(1.0))[1] }
    }

    /// The length of its control polygon, which is nowhere less than its own.
    pub fn polygon(&self) -> f64 {
        self.0.windows(2).map(|w| norm(sub(w[1], w[0]))).sum()
    }

    /// The length from `t0` to `t1` by one rule of eight points.
    pub fn gauss(&self, t0: f64, t1: f64) -> f64 {
        let (middle, half) = (0.5 * (t0 + t1), 0.5 * (t1 - t0));
        let speed = |x: f64| norm(self.derivative(middle + half * x));
        half * GAUSS.iter().map(|&[x, w]| w * (speed(-x) + speed(x))).sum::<f64>()
    }

    /// The length from `t0` to `t1`, to about ten digits.
    pub fn length(&self, t0: f64, t1: f64) -> f64 {
        let tolerance = 1e-11 * self.polygon();
        self.refine(t0, t1, self.gauss(t0, t1), tolerance, DEPTH)
    }

    fn refine(&self, t0: f64, t1: f64, whole: f64, tolerance: f64, depth: u32) -> f64 {
        let middle = 0.5 * (t0 + t1);
        let (a, b) = (self.gauss(t0, middle), self.gauss(middle, t1));
        // A NaN ends the descent, too.
        let open = (a + b - whole).abs() > tolerance;
        if !open || depth == 0 {
            return a + b;
        }
        self.refine(t0, middle, a, tolerance, depth - 1) + self.refine(middle, t1, b, tolerance, depth - 1)
    }

    /// The `t` up to which the length is `length`, of the whole length `total`.
    pub fn param_at(&self, length: f64, total: f64) -> f64 {
        if length <= 0.0 || total <= 0.0 {
            return 0.0;
        }
        if length >= total {
            return 1.0;
        }
        let (mut low, mut high) = ((0.0, 0.0), (1.0, total));
        let mut t = length / total;
        // Newton's step where it stays inside the bracket, else the secant's or the middle.
        for round in 0..60 {
            let at = low.1 + self.length(low.0, t);
            let error = at - length;
            if error.abs() <= 1e-11 * total || high.0 - low.0 <= f64::EPSILON {
                break;
            }
            if error < 0.0 {
                low = (t, at);
            } else {
                high = (t, at);
            }
            let newton = t - error / norm(self.derivative(t));
            let inside = newton > low.0 && newton < high.0 && round < 40;
            t = if inside { newton } else { 0.5 * (low.0 + high.0) };
        }
        t
    }
}

/// The share of the length at the ends of all pieces, from 0 to 1.
pub fn shares(knots: &[Point]) -> Vec<f64> {
    let pieces = knots.len().saturating_sub(1) / 3;
    let piece = |i: usize| Cubic([knots[3 * i], knots[3 * i + 1], knots[3 * i + 2], knots[3 * i + 3]]);
    let mut sum = 0.0;
    let mut ends = vec![0.0];
    for i in 0..pieces {
        sum += piece(i).length(0.0, 1.0);
        ends.push(sum);
    }
    let last = ends.len() - 1;
    ends.iter_mut().for_each(|s| *s = if sum > 0.0 { *s / sum } else { 0.0 });
    if last > 0 {
        ends[last] = 1.0;
    }
    ends
}
