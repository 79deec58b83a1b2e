//! Numbers that follow each other without a word, as headerless files and those with a plain header hold them.

use super::error::Fault;
use super::height::room;
use super::input::Input;

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    F32,
    F64,
}

impl Number {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    pub(super) fn bytes(self) -> u64 {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// The number in some bytes, of which there are as many as it takes.
    fn of(self, bytes: &[u8], big: bool) -> f64 {
        let mut word = [0; 8];
        let n = bytes.len().min(8);
        word[..n].copy_from_slice(&bytes[..n]);
        if big {
            word[..n].reverse();
        }
        let [a, b, c, d, ..] = word;
        match self {
            Self::U8 => f64::from(a),
            Self::I8 => f64::from(a as i8),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::F64 => f64::from_le_bytes(word),
        }
    }
}

/// A raster of such numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flat {
    pub(super) cols: u64,
    pub(super) rows: u64,
    pub(super) number: Number,
    /// Whether the highest byte comes first.
    pub(super) big: bool,
    /// Bytes before the first row.
    pub(super) skip: u64,
    /// Bytes from one number of a row to the next.
    pub(super) step: u64,
    /// Bytes from one row to the next.
    pub(super) line: u64,
}

impl Flat {
    /// A raster whose numbers touch.
    pub(super) fn packed(size: [u64; 2], number: Number, big: bool, skip: u64) -> Self {
        let [cols, rows] = size;
        let step = number.bytes();
        Self { cols, rows, number, big, skip, step, line: cols.saturating_mul(step) }
    }

    /// Bytes of a row from its first number to its last.
    fn row_bytes(&self) -> u64 {
        (self.cols.saturating_sub(1)).saturating_mul(self.step).saturating_add(self.number.bytes())
    }

    /// Checks that the size is allowed and that the file is long enough.
    pub(super) fn check(&self, input: &Input<'_>) -> Result<(), Fault> {
        input.limits.samples(self.cols, self.rows)?;
        let rows = (self.rows - 1).saturating_mul(self.line);
        let (want, found) =
            (self.skip.saturating_add(rows).saturating_add(self.row_bytes()), input.bytes.len());
        if want > found {
            Err(Fault::Short { what: "a raster of the size in the header", want, found })
        } else {
            Ok(())
        }
    }

    /// Reads the numbers, row by row.
    pub(super) fn read(&self, input: &Input<'_>, of: impl Fn(f64) -> f32) -> Result<Vec<f32>, Fault> {
        self.check(input)?;
        let mut data = room((self.cols * self.rows) as usize)?;
        let bytes = usize::try_from(self.row_bytes()).map_err(|_| Fault::damaged("a row too long"))?;
        let mut row = room(bytes)?;
        row.resize(bytes, 0u8);
        let (width, step) = (self.number.bytes() as usize, self.step as usize);
        for j in 0..self.rows {
            input.bytes.read_at(self.skip + j * self.line, &mut row)?;
            let numbers = row.chunks(step).map(|b| self.number.of(&b[..width], self.big));
            data.extend(numbers.map(&of));
            input.work.step((j + 1) as f32 / self.rows as f32)?;
        }
        Ok(data)
    }
}

/// Turns a float into a height: what is not finite is a void, and so is a code.
pub(super) fn height(nodata: Option<f64>) -> impl Fn(f64) -> f32 {
    // A float code is written with fewer digits than it has.
    move |v| {
        let void = nodata.is_some_and(|n| v == n || v as f32 == n as f32);
        if void || !(v as f32).is_finite() { f32::NAN } else { v as f32 }
    }
}
