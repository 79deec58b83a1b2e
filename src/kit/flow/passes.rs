//! The passes between basins, and those over which each basin drains.

use rayon::prelude::*;

use super::descent::band;
use super::flats::LOOK;
use super::neighbor::{Cells, NONE};
use super::surface::Surface;
use crate::work::{Cancelled, Work};

/// The lowest place between two basins: two neighbouring cells, or a cell of the border and what lies beyond.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Pass {
    /// Labels of the two basins, the lower one first; 0 is the outside.
    pub basins: [u32; 2],
    /// The height of the higher cell, then its place: passes of one height are told apart by it.
    key: u64,
}

impl Pass {
    fn new(a: u32, b: u32, height: f32, cell: usize, k: u8) -> Self {
        let place = (cell as u64) << 3 | u64::from(k & 7);
        Self { basins: [a.min(b), a.max(b)], key: u64::from(ordered(height)) << 32 | place }
    }

    /// Height of the pass, in metres.
    pub(super) fn height(self) -> f32 {
        unordered((self.key >> 32) as u32)
    }

    /// Its first cell and the direction to the second; over the border there is none.
    pub(super) fn place(self) -> (usize, u8) {
        let place = self.key as u32;
        // Directions to cells of higher index are 4 to 7.
        let k = (place & 7) as u8;
        ((place >> 3) as usize, if k < 4 { NONE } else { k })
    }
}

/// Bits that are ordered as the number is; both zeros are one.
pub(super) fn ordered(x: f32) -> u32 {
    let bits = (x + 0.0).to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}

/// The number of such bits.
pub(super) fn unordered(bits: u32) -> f32 {
    f32::from_bits(if bits >> 31 == 1 { bits & !(1 << 31) } else { !bits })
}

/// The lowest pass of every two basins that touch, in no order that depends on the threads.
pub(super) fn between(
    surface: &Surface<'_>,
    label: &[u32],
    work: &Work<'_>,
) -> Result<Vec<Vec<Pass>>, Cancelled> {
    let Cells { cols, rows } = surface.cells;
    let band = band(cols);
    let bands = (0..rows.div_ceil(band)).into_par_iter().map(|b| {
        work.check()?;
        let mut found = Lowest::default();
        for j in b * band..((b + 1) * band).min(rows) {
            of_row(surface, label, j, &mut found);
        }
        Ok(found.thinned())
    });
    let mut all: Vec<Vec<Pass>> = bands.collect::<Result<_, Cancelled>>()?;
    work.check()?;
    all.push(over_the_border(surface, label));
    Ok(all)
}

/// Passes from a row to itself and to the next.
fn of_row(surface: &Surface<'_>, label: &[u32], j: usize, found: &mut Lowest) {
    let Cells { cols, rows } = surface.cells;
    let first = j * cols;
    let here = &label[first..][..cols];
    let mut look = |i: usize, k: u8, to: usize| {
        let (a, b) = (here[i], label[to]);
        if a != b {
            let height = surface.at(first + i).max(surface.at(to));
            found.add(Pass::new(a, b, height, first + i, k));
        }
    };
    for i in 0..cols {
        if i + 1 < cols {
            look(i, 4, first + i + 1);
        }
        if j + 1 < rows {
            let below = first + cols + i;
            if i > 0 {
                look(i, 5, below - 1);
            }
            look(i, 6, below);
            if i + 1 < cols {
                look(i, 7, below + 1);
            }
        }
    }
}

/// Land of the border lets water out of its basin at its own height.
fn over_the_border(surface: &Surface<'_>, label: &[u32]) -> Vec<Pass> {
    let Cells { cols, rows } = surface.cells;
    let mut found = Lowest::default();
    for j in 0..rows {
        let inner = j > 0 && j + 1 < rows && cols > 2;
        for i in (0..cols).step_by(if inner { cols - 1 } else { 1 }) {
            let cell = j * cols + i;
            if label[cell] != 0 {
                found.add(Pass::new(0, label[cell], surface.at(cell), cell, 0));
            }
        }
    }
    found.thinned()
}

/// Passes, where of those between the same basins only the lowest counts.
#[derive(Default)]
struct Lowest {
    passes: Vec<Pass>,
    /// How many passes are known to be of different basins.
    distinct: usize,
}

impl Lowest {
    #[inline]
    fn add(&mut self, pass: Pass) {
        // Passes between the same basins come in runs.
        match self.passes.last_mut() {
            Some(last) if last.basins == pass.basins => last.key = last.key.min(pass.key),
            _ => {
                if self.passes.len() >= 2 * self.distinct + (1 << 12) {
                    self.thin();
                }
                self.passes.push(pass);
            }
        }
    }

    /// The passes, in no more memory than they take: of noise there are many.
    fn thinned(mut self) -> Vec<Pass> {
        self.thin();
        self.passes.shrink_to_fit();
        self.passes
    }

    fn thin(&mut self) {
        self.passes.sort_unstable();
        self.passes.dedup_by_key(|pass| pass.basins);
        self.distinct = self.passes.len();
    }
}

/// The passes over which the basins 1 to `count` drain to the outside, 0: the minimum spanning tree of the graph of
/// passes \[boruvka1926\]. In each round every group of basins is joined to another over its lowest pass, and passes inside
/// a group are forgotten.
pub(super) fn lowest_tree(
    mut passes: Vec<Vec<Pass>>,
    count: usize,
    work: &Work<'_>,
) -> Result<Vec<Pass>, Cancelled> {
    let mut groups = Groups::new(count + 1);
    let mut tree = Vec::with_capacity(count);
    loop {
        let mut lowest = vec![None::<Pass>; count + 1];
        for list in &mut passes {
            let mut kept = 0;
            for n in 0..list.len() {
                if n % LOOK == 0 {
                    work.check()?;
                }
                let pass = list[n];
                let [a, b] = pass.basins.map(|basin| groups.of(basin));
                if a != b {
                    list[kept] = pass;
                    kept += 1;
                    for group in [a, b] {
                        let best = &mut lowest[group as usize];
                        *best = best.filter(|best| best.key < pass.key).or(Some(pass));
                    }
                }
            }
            list.truncate(kept);
        }
        let before = tree.len();
        for pass in lowest.into_iter().flatten() {
            // The lowest pass of two groups may be one.
            if groups.join(pass.basins) {
                tree.push(pass);
            }
        }
        if tree.len() == before {
            return Ok(tree);
        }
    }
}

/// Sets of basins, each named after one of its own.
struct Groups(Vec<u32>);

impl Groups {
    fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    fn of(&mut self, basin: u32) -> u32 {
        let mut basin = basin as usize;
        while self.0[basin] as usize != basin {
            // Every other member on the way is brought nearer.
            let up = self.0[basin] as usize;
            self.0[basin] = self.0[up];
            basin = self.0[basin] as usize;
        }
        basin as u32
    }

    /// Makes one group of two; false when they are one.
    fn join(&mut self, basins: [u32; 2]) -> bool {
        let [a, b] = basins.map(|basin| self.of(basin));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }
}
