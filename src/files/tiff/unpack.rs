//! How strips and tiles are packed, and how they are unpacked: never more than what is wanted of them.

use std::io::Read;

use flate2::{Decompress, FlushDecompress, Status};
use lzma_rust2::XzReader;
use ruzstd::decoding::{FrameDecoder, StreamingDecoder};

use super::super::error::Fault;
use crate::work::Work;

/// Most memory of an LZMA decoder, in KiB: the dictionary of the highest preset, and what stands around it.
const LZMA_KIB: u32 = 72 * 1024;

/// How strips and tiles are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Lzw,
    Deflate,
    PackBits,
    Lzma,
    Zstd,
}

impl Compression {
    pub(super) fn of(code: u64) -> Result<Self, Fault> {
        Ok(match code {
            1 => Self::None,
            5 => Self::Lzw,
            8 | 32946 => Self::Deflate,
            32773 => Self::PackBits,
            34925 => Self::Lzma,
            50000 => Self::Zstd,
            other => {
                return Err(Fault::Unsupported(format!(
                    "compression {other}; none, LZW, deflate, PackBits, LZMA and ZSTD are"
                )));
            }
        })
    }

    /// The most bytes that a byte of a file can be unpacked to.
    pub(super) fn most(self) -> u64 {
        match self {
            Self::None => 1,
            // 128 times a byte, in two.
            Self::PackBits => 64,
            // 258 bytes again, in two bits.
            Self::Deflate => 1032,
            // The longest string of a full table, 3838 bytes, in twelve bits.
            Self::Lzw => 2560,
            // 273 bytes again, in a third of a bit.
            Self::Lzma => 8192,
            // A block of 128 KiB of one value, in four bytes.
            Self::Zstd => 32768,
        }
    }

    /// The most bytes that unpacking takes beside what is packed and what is wanted of it.
    pub(super) fn working_bytes(self, want: u64) -> u64 {
        match self {
            Self::None => 0,
            Self::Lzw | Self::Deflate | Self::PackBits => 1 << 17,
            // A window, and what was unpacked and not yet taken from it.
            Self::Zstd => 2 * window(want) + (1 << 20),
            Self::Lzma => LZMA_KIB as u64 * 1024 + (1 << 20),
        }
    }

    /// Unpacks the first `want` bytes into a buffer; gives how many there are.
    pub(super) fn unpack(
        self,
        packed: &[u8],
        want: usize,
        buffer: &mut Vec<u8>,
        work: &Work<'_>,
    ) -> Result<usize, Fault> {
        buffer.clear();
        buffer.try_reserve_exact(want).map_err(|_| Fault::NoMemory { bytes: want as u64 })?;
        match self {
            Self::None => buffer.extend_from_slice(&packed[..want.min(packed.len())]),
            Self::Deflate => inflate(packed, want, buffer, work)?,
            Self::Lzw => lzw(packed, want, buffer, work)?,
            Self::PackBits => unpack_bits(packed, want, buffer, work)?,
            Self::Zstd => {
                let mut frames = FrameDecoder::new();
                frames.set_max_window_size(window(want as u64));
                let mut decoder = StreamingDecoder::new_with_decoder(packed, frames).map_err(does_not)?;
                take(&mut decoder, want, buffer, work)?;
            }
            Self::Lzma => {
                let mut decoder = XzReader::new_mem_limit(packed, false, LZMA_KIB);
                take(&mut decoder, want, buffer, work)?;
            }
        }
        Ok(buffer.len())
    }
}

/// Most bytes of the window of a ZSTD frame of some content: encoders take no more than 8 MiB unless they are asked to.
fn window(want: u64) -> u64 {
    want.next_power_of_two().max(1 << 23)
}

fn does_not(why: impl std::fmt::Display) -> Fault {
    Fault::Damaged(format!("a strip or tile does not unpack: {why}"))
}

/// Bytes that are unpacked between two looks at the signal.
const PIECE: usize = 1 << 22;

/// Takes bytes from a decoder until there are enough.
fn take(decoder: &mut impl Read, want: usize, buffer: &mut Vec<u8>, work: &Work<'_>) -> Result<(), Fault> {
    while buffer.len() < want {
        work.check()?;
        let piece = (want - buffer.len()).min(PIECE);
        if decoder.by_ref().take(piece as u64).read_to_end(buffer).map_err(does_not)? == 0 {
            break;
        }
    }
    Ok(())
}

/// Fills a buffer piece by piece; `step` takes what is left of the input and fills what it can of a piece, and gives
/// how many bytes it took, how many it gave, and whether it is done.
fn fill(
    mut packed: &[u8],
    want: usize,
    buffer: &mut Vec<u8>,
    work: &Work<'_>,
    mut step: impl FnMut(&[u8], &mut [u8]) -> Result<(usize, usize, bool), Fault>,
) -> Result<(), Fault> {
    let mut filled = 0;
    loop {
        work.check()?;
        let end = want.min(filled + PIECE);
        if buffer.len() < end {
            buffer.resize(end, 0);
        }
        let (taken, given, done) = step(packed, &mut buffer[filled..end])?;
        packed = &packed[taken..];
        filled += given;
        if done || filled == want || taken + given == 0 {
            buffer.truncate(filled);
            return Ok(());
        }
    }
}

fn inflate(packed: &[u8], want: usize, buffer: &mut Vec<u8>, work: &Work<'_>) -> Result<(), Fault> {
    let mut inflate = Decompress::new(true);
    fill(packed, want, buffer, work, |packed, out| {
        let before = [inflate.total_in(), inflate.total_out()];
        let status = inflate.decompress(packed, out, FlushDecompress::None).map_err(does_not)?;
        let [taken, given] = [inflate.total_in() - before[0], inflate.total_out() - before[1]];
        Ok((taken as usize, given as usize, status == Status::StreamEnd))
    })
}

fn lzw(packed: &[u8], want: usize, buffer: &mut Vec<u8>, work: &Work<'_>) -> Result<(), Fault> {
    let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8);
    fill(packed, want, buffer, work, |packed, out| {
        let step = decoder.decode_bytes(packed, out);
        let status = step.status.map_err(does_not)?;
        Ok((step.consumed_in, step.consumed_out, !matches!(status, weezl::LzwStatus::Ok)))
    })
}

/// Undoes run-length packing (TIFF 6.0, section 9).
fn unpack_bits(mut packed: &[u8], want: usize, out: &mut Vec<u8>, work: &Work<'_>) -> Result<(), Fault> {
    let mut pause = 0;
    while out.len() < want {
        if out.len() >= pause {
            work.check()?;
            pause = out.len() + PIECE;
        }
        let [code, rest @ ..] = packed else { break };
        let code = *code as i8;
        if code >= 0 {
            let n = (code as usize + 1).min(rest.len());
            out.extend_from_slice(&rest[..n]);
            packed = &rest[n..];
        } else if code == -128 {
            packed = rest;
        } else {
            let [value, rest @ ..] = rest else { break };
            out.resize(out.len() + (1 - i16::from(code)) as usize, *value);
            packed = rest;
        }
    }
    Ok(())
}
