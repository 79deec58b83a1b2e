//! How strips and tiles are packed, and how they are unpacked: never more than what is wanted of them.

use std::io::Read;

use flate2::{Decompress, FlushDecompress};
use lzma_rust2::XzReader;
use ruzstd::decoding::{FrameDecoder, StreamingDecoder};

use super::super::error::Fault;

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
    pub(super) fn unpack(self, packed: &[u8], want: usize, buffer: &mut Vec<u8>) -> Result<usize, Fault> {
        buffer.clear();
        buffer.try_reserve_exact(want).map_err(|_| Fault::NoMemory { bytes: want as u64 })?;
        match self {
            Self::None => buffer.extend_from_slice(&packed[..want.min(packed.len())]),
            Self::Deflate => {
                buffer.resize(want, 0);
                let mut inflate = Decompress::new(true);
                inflate.decompress(packed, buffer, FlushDecompress::Finish).map_err(does_not)?;
                buffer.truncate(inflate.total_out() as usize);
            }
            Self::Lzw => {
                buffer.resize(want, 0);
                let filled = lzw(packed, buffer)?;
                buffer.truncate(filled);
            }
            Self::PackBits => unpack_bits(packed, want, buffer),
            Self::Zstd => {
                let mut frames = FrameDecoder::new();
                frames.set_max_window_size(window(want as u64));
                let mut decoder = StreamingDecoder::new_with_decoder(packed, frames).map_err(does_not)?;
                take(&mut decoder, want, buffer)?;
            }
            Self::Lzma => {
                let mut decoder = XzReader::new_mem_limit(packed, false, LZMA_KIB);
                take(&mut decoder, want, buffer)?;
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

/// Takes bytes from a decoder until there are enough.
fn take(decoder: &mut impl Read, want: usize, buffer: &mut Vec<u8>) -> Result<(), Fault> {
    decoder.take(want as u64).read_to_end(buffer).map_err(does_not)?;
    Ok(())
}

fn lzw(mut packed: &[u8], out: &mut [u8]) -> Result<usize, Fault> {
    let mut decoder = weezl::decode::Decoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8);
    let mut filled = 0;
    while filled < out.len() {
        let step = decoder.decode_bytes(packed, &mut out[filled..]);
        packed = &packed[step.consumed_in..];
        filled += step.consumed_out;
        match step.status {
            Ok(weezl::LzwStatus::Ok) if step.consumed_in + step.consumed_out > 0 => (),
            Ok(_) => break,
            Err(e) => return Err(does_not(e)),
        }
    }
    Ok(filled)
}

/// Undoes run-length packing (TIFF 6.0, section 9).
fn unpack_bits(mut packed: &[u8], want: usize, out: &mut Vec<u8>) {
    while out.len() < want {
        let [code, rest @ ..] = packed else { return };
        let code = *code as i8;
        if code >= 0 {
            let n = (code as usize + 1).min(rest.len());
            out.extend_from_slice(&rest[..n]);
            packed = &rest[n..];
        } else if code == -128 {
            packed = rest;
        } else {
            let [value, rest @ ..] = rest else { return };
            out.resize(out.len() + (1 - i16::from(code)) as usize, *value);
            packed = rest;
        }
    }
}
