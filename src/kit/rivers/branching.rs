//! How the links of a self-similar network branch \[zhang2016, section IV.A; peckham1995\].

use super::chance::Chance;

/// How the links of a network branch from step to step.
///
/// # Differs from the paper
/// Generator k of an exterior link has k interior and k + 1 exterior links, as printed. That of an interior link must have
/// k + 1 interior and k exterior ones, `F[++G]F` and `F[++G]F[--G]F`: the printed `F[-G]F[-G][+G]` makes a joint of four,
/// and exterior links are no longer one more than interior ones. Equation (2) is read as `l_t = (Pφ)^-(t-1)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Branching {
    /// Generator φ, from 1 to 8. The means are `T_1 = φ - 1` and `T_k = R φ (R + 1)^(k - 2)` with `R = P (φ - 1)` and
    /// `P = (1 + √(1 + 4φ)) / 2φ`.
    Generator(u8),
    /// Tokunaga's `T_k = a c^(k - 1)`, exactly in the mean, which the paper has for φ 2 alone (a 1, c 2).
    Statistics {
        /// Side branches of the next lower order, a.
        a: f64,
        /// How many times more there are of each lower order, c.
        c: f64,
    },
}

impl Branching {
    /// Mean generator of an exterior link: it becomes so many interior links in a row, a side branch between each two of
    /// them, and two branches at the end.
    pub fn exterior(self) -> f64 {
        match self {
            Self::Generator(phi) => f64::from(phi),
            Self::Statistics { a, .. } => 1.0 + a,
        }
    }

    /// Mean number of side branches that an interior link gets in its `step`-th step as one, from 1.
    pub fn interior(self, step: u32) -> f64 {
        match self {
            Self::Generator(phi) => {
                let phi = f64::from(phi);
                (1.0 + libm::sqrt(1.0 + 4.0 * phi)) / (2.0 * phi) * (phi - 1.0)
            }
            Self::Statistics { a, c } => {
                // c^0 + … + c^(step - 1), which is `step` for c = 1, and c^step.
                let (mut sum, mut power) = (0.0, 1.0);
                for _ in 0..step {
                    sum += power;
                    power *= c;
                }
                a * power / (1.0 + a * sum)
            }
        }
    }

    /// Horton's bifurcation ratio of a large network.
    pub fn bifurcation(self) -> f64 {
        match self {
            Self::Generator(phi) => f64::from(phi) + 1.0 + self.interior(1),
            // Without side branches each step doubles the sources, whatever c is.
            Self::Statistics { a, .. } if a <= 0.0 => 2.0,
            Self::Statistics { a, c } => {
                let sum = 2.0 + a + c;
                (sum + libm::sqrt((sum * sum - 8.0 * c).max(0.0))) / 2.0
            }
        }
    }

    /// How many times shorter links are in each step, so that a network fills the plane: Pφ, equation (2), and √`R_B` for
    /// given statistics, which is the same for a 1 and c 2.
    pub fn shrink(self) -> f64 {
        match self {
            Self::Generator(phi) => (1.0 + libm::sqrt(1.0 + 4.0 * f64::from(phi))) / 2.0,
            Self::Statistics { .. } => libm::sqrt(self.bifurcation()).max(1.2),
        }
    }

    /// Mean number of links of a network of a depth, where a share of interior links is lengthened in each step instead
    /// of branching.
    pub fn links(self, depth: u32, lengthen: f64) -> f64 {
        let mut exterior = 1.0;
        // Interior links by the number of steps that they have been ones.
        let mut interior: Vec<f64> = Vec::new();
        for _ in 1..depth {
            let mut sources = exterior * (1.0 + self.exterior());
            let mut older = vec![exterior * self.exterior()];
            for (age, &count) in interior.iter().enumerate() {
                let side = count * self.interior(age as u32 + 1) * (1.0 - lengthen);
                sources += side;
                older.push(count + side);
            }
            (exterior, interior) = (sources, older);
            if exterior > 1e12 {
                return exterior;
            }
        }
        exterior + interior.iter().sum::<f64>()
    }

    /// The links of a network of a depth without places: the link downstream of each, downstream first. It is what
    /// [`grow`](super::grow) draws where nothing is in the way.
    pub fn topology(self, depth: u32, lengthen: f64, seed: u64) -> Vec<Option<u32>> {
        let mut chance = Chance::new(seed);
        // A link: the one downstream, and how many steps it has been interior, 0 for an exterior one.
        let mut links: Vec<(Option<u32>, u32)> = vec![(None, 0)];
        for _ in 1..depth {
            let mut grown: Vec<(Option<u32>, u32)> = Vec::new();
            // The uppermost piece of each link, to which those upstream are joined.
            let mut uppermost = Vec::with_capacity(links.len());
            for (down, age) in links {
                let side = match age {
                    0 => chance.whole(self.exterior()).max(1) - 1,
                    _ if chance.unit() < lengthen => 0,
                    age => chance.whole(self.interior(age)),
                };
                let mut piece = down.map(|down| uppermost[down as usize]);
                for k in 0..=side {
                    grown.push((piece, age + 1));
                    piece = Some(grown.len() as u32 - 1);
                    if k < side {
                        grown.push((piece, 0));
                    }
                }
                if age == 0 {
                    grown.extend([(piece, 0), (piece, 0)]);
                }
                uppermost.extend(piece);
            }
            links = grown;
        }
        links.into_iter().map(|(down, _)| down).collect()
    }
}
