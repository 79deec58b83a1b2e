//! The types of samples, and how a row of bytes becomes heights.

use exr::prelude::f16;

/// The type of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SampleKind {
    /// Whole numbers from 0 of 1 to 31 bits that are packed without regard to bytes, most significant bit first.
    Packed(u32),
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F16,
    F32,
    F64,
}

impl SampleKind {
    /// The type of some bits and of a sample format: 1 and 4 for whole numbers, 2 with a sign, 3 for floats.
    pub(super) fn of(bits: u64, format: u64) -> Option<Self> {
        Some(match (format, bits) {
            (1 | 4, 8) => Self::U8,
            (1 | 4, 16) => Self::U16,
            (1 | 4, 32) => Self::U32,
            (1 | 4, 64) => Self::U64,
            (2, 8) => Self::I8,
            (2, 16) => Self::I16,
            (2, 32) => Self::I32,
            (2, 64) => Self::I64,
            (3, 16) => Self::F16,
            (3, 32) => Self::F32,
            (3, 64) => Self::F64,
            (1 | 4, 1..32) => Self::Packed(bits as u32),
            _ => return None,
        })
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Packed(1) => "u1",
            Self::Packed(2) => "u2",
            Self::Packed(4) => "u4",
            Self::Packed(10) => "u10",
            Self::Packed(12) => "u12",
            Self::Packed(14) => "u14",
            Self::Packed(24) => "u24",
            Self::Packed(_) => "packed integers",
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::U64 => "u64",
            Self::I64 => "i64",
            Self::F16 => "f16",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64)
    }

    /// The highest integer, of the types that files with a range have.
    pub(super) fn levels(self) -> Option<f64> {
        match self {
            Self::Packed(bits) => Some(f64::from((1u32 << bits) - 1)),
            Self::U8 => Some(255.0),
            Self::U16 => Some(65535.0),
            _ => None,
        }
    }

    pub(super) fn bits(self) -> u64 {
        match self {
            Self::Packed(bits) => u64::from(bits),
            Self::U8 | Self::I8 => 8,
            Self::U16 | Self::I16 | Self::F16 => 16,
            Self::U32 | Self::I32 | Self::F32 => 32,
            Self::U64 | Self::I64 | Self::F64 => 64,
        }
    }

    /// Bytes of a sample, of those that take whole ones.
    pub(super) fn bytes(self) -> usize {
        (self.bits() as usize).div_ceil(8)
    }
}

/// How a row of samples is read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    pub(super) kind: SampleKind,
    pub(super) little: bool,
    /// Samples of one pixel in the row.
    pub(super) per_pixel: usize,
    /// Which of them is meant.
    pub(super) band: usize,
}

impl Row {
    /// Undoes the predictor; after predictor 3 the samples are planes of bytes that are put back together.
    pub(super) fn unpredict(&self, predictor: u64, row: &mut Vec<u8>) {
        let (n, step) = (self.per_pixel, self.kind.bytes());
        match predictor {
            2 => match step {
                1 => (n..row.len()).for_each(|i| row[i] = row[i].wrapping_add(row[i - n])),
                2 => sum_up::<2>(row, n, self.little),
                4 => sum_up::<4>(row, n, self.little),
                _ => sum_up::<8>(row, n, self.little),
            },
            3 => {
                (n..row.len()).for_each(|i| row[i] = row[i].wrapping_add(row[i - n]));
                let count = row.len() / step;
                let planes = std::mem::take(row);
                row.resize(planes.len(), 0);
                for (b, plane) in planes.chunks_exact(count.max(1)).enumerate() {
                    let at = if self.little { step - 1 - b } else { b };
                    for (i, v) in plane.iter().enumerate() {
                        row[i * step + at] = *v;
                    }
                }
            }
            _ => (),
        }
    }

    /// Gives each sample of the band to `put`, with its place in `out`.
    pub(super) fn each(&self, row: &[u8], out: &mut [f32], put: impl Fn(f64, &mut f32)) {
        let little = self.little;
        match self.kind {
            SampleKind::Packed(bits) => self.packed(bits as usize, row, out, put),
            SampleKind::U8 => self.convert(row, out, put, |[b]: [u8; 1]| f64::from(b)),
            SampleKind::I8 => self.convert(row, out, put, |[b]: [u8; 1]| f64::from(b as i8)),
            SampleKind::U16 => {
                self.convert(row, out, put, |b| f64::from(u16::from_le_bytes(native(b, little))));
            }
            SampleKind::I16 => {
                self.convert(row, out, put, |b| f64::from(i16::from_le_bytes(native(b, little))));
            }
            SampleKind::U32 => {
                self.convert(row, out, put, |b| f64::from(u32::from_le_bytes(native(b, little))));
            }
            SampleKind::I32 => {
                self.convert(row, out, put, |b| f64::from(i32::from_le_bytes(native(b, little))));
            }
            SampleKind::U64 => self.convert(row, out, put, |b| u64::from_le_bytes(native(b, little)) as f64),
            SampleKind::I64 => self.convert(row, out, put, |b| i64::from_le_bytes(native(b, little)) as f64),
            SampleKind::F16 => {
                let of = |b| f64::from(f16::from_bits(u16::from_le_bytes(native(b, little))).to_f32());
                self.convert(row, out, put, of);
            }
            SampleKind::F32 => {
                self.convert(row, out, put, |b| f64::from(f32::from_le_bytes(native(b, little))));
            }
            SampleKind::F64 => self.convert(row, out, put, |b| f64::from_le_bytes(native(b, little))),
        }
    }

    fn convert<const N: usize>(
        &self,
        row: &[u8],
        out: &mut [f32],
        put: impl Fn(f64, &mut f32),
        of: impl Fn([u8; N]) -> f64,
    ) {
        let (samples, _) = row.as_chunks::<N>();
        let own = samples.iter().skip(self.band).step_by(self.per_pixel);
        out.iter_mut().zip(own).for_each(|(o, b)| put(of(*b), o));
    }

    fn packed(&self, bits: usize, row: &[u8], out: &mut [f32], put: impl Fn(f64, &mut f32)) {
        for (i, o) in out.iter_mut().enumerate() {
            let first = (i * self.per_pixel + self.band) * bits;
            let bit = |at: usize| row.get(at / 8).map_or(0, |b| u32::from(b >> (7 - at % 8) & 1));
            let value =
                if bits == 1 { bit(first) } else { (first..first + bits).fold(0, |v, at| v << 1 | bit(at)) };
            put(f64::from(value), o);
        }
    }
}

/// Bytes of a number in little-endian order.
fn native<const N: usize>(mut b: [u8; N], little: bool) -> [u8; N] {
    if !little {
        b.reverse();
    }
    b
}

/// Adds up differences of numbers of `N` bytes, `n` to a pixel.
fn sum_up<const N: usize>(row: &mut [u8], n: usize, little: bool) {
    let (numbers, _) = row.as_chunks_mut::<N>();
    let of = |b: [u8; N]| native(b, little).iter().rev().fold(0u64, |sum, b| sum << 8 | u64::from(*b));
    for i in n..numbers.len() {
        let sum = of(numbers[i]).wrapping_add(of(numbers[i - n])).to_le_bytes();
        let mut bytes = [0; N];
        bytes.copy_from_slice(&sum[..N]);
        numbers[i] = native(bytes, little);
    }
}
