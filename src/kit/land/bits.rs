//! A bit for each sample of a grid.

/// A bit for each sample of a grid, a row in whole words, the first sample in the lowest bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bits {
    cols: usize,
    /// Words of a row.
    pub(super) words: usize,
    /// All rows, one after the other. Bits beyond the last column are 0.
    pub(super) data: Vec<u64>,
}

impl Bits {
    /// The samples for which something holds, given row by row.
    pub fn of<T>(cols: usize, samples: &[T], holds: impl Fn(&T) -> bool) -> Self {
        let words = cols.div_ceil(64);
        let mut data = Vec::with_capacity(samples.len().div_ceil(cols.max(1)) * words);
        for row in samples.chunks(cols.max(1)) {
            let word = |some: &[T]| some.iter().enumerate().fold(0, |w, (i, s)| w | u64::from(holds(s)) << i);
            data.extend(row.chunks(64).map(word));
        }
        Self { cols, words, data }
    }

    /// Whether the bit of a sample is set.
    pub fn has(&self, [col, row]: [usize; 2]) -> bool {
        self.data[row * self.words + col / 64] >> (col % 64) & 1 == 1
    }

    /// The bits of a word that stand for columns.
    pub(super) fn valid(&self, word: usize) -> u64 {
        match self.cols - 64 * word {
            left @ 0..64 => (1 << left) - 1,
            _ => u64::MAX,
        }
    }
}

/// Word `word` of a row that is moved by less than 64 columns: its bit `c` is that of column `c + by`.
pub(super) fn moved(row: &[u64], word: usize, by: i32) -> u64 {
    let here = row[word];
    match by {
        0 => here,
        1.. => here >> by | row.get(word + 1).map_or(0, |next| next << (64 - by)),
        _ => here << -by | if word > 0 { row[word - 1] >> (64 + by) } else { 0 },
    }
}
