//! Portable float maps: a header of three lines, then 32-bit floats, the southernmost row first.

use super::codec::Codec;
use super::error::Fault;
use super::flat::{Flat, Number, height};
use super::height::{HeightFile, Origin};
use super::input::{Claim, Input};
use super::place::Placement;

pub(super) static CODEC: Codec = Codec {
    name: "PFM",
    extensions: &["pfm"],
    magic: &[b"Pf\n", b"Pf\r", b"Pf ", b"PF\n", b"PF\r", b"PF "],
    companions: &["json"],
    claims_early: true,
    claim,
    read,
    reads: "portable float map, grey, either byte order; in colours the one that `channel` names (`R`, `G`, `B`)",
    metres: "yes; the scale in the header, which is one of light, is not applied",
    place: "from the sidecar",
};

/// Where the numbers lie, and how many there are to a pixel.
fn layout(input: &Input<'_>) -> Result<(Flat, usize), Fault> {
    let head = input.head()?;
    let mut at = 0;
    let mut word = || -> Result<&str, Fault> {
        while head.get(at).is_some_and(u8::is_ascii_whitespace) {
            at += 1;
        }
        let start = at.min(head.len());
        while head.get(at).is_some_and(|b| !b.is_ascii_whitespace()) && at - start < 64 {
            at += 1;
        }
        let word = &head[start..at.min(head.len())];
        // One blank ends the word; after the last word of the header the numbers follow it at once.
        at += 1;
        std::str::from_utf8(word).map_err(|_| Fault::damaged("a header that is no text"))
    };
    let colors = word()? == "PF";
    let side = |word: &str| {
        word.parse::<u64>()
            .map_err(|_| Fault::Damaged(format!("a size must be a whole number, got \"{word}\"")))
    };
    let (cols, rows) = (side(word()?)?, side(word()?)?);
    let scale = word()?;
    let scale: f64 = scale.parse().ok().filter(|s: &f64| s.is_finite() && *s != 0.0).ok_or_else(|| {
        Fault::Damaged(format!("the scale must be a number, below 0 for little-endian, got \"{scale}\""))
    })?;
    let mut flat = Flat::packed([cols, rows], Number::F32, scale > 0.0, at as u64);
    let bands = if colors { 3 } else { 1 };
    if colors {
        let asked = input.reading.channel.as_deref();
        let asked = asked.ok_or_else(|| {
            Fault::unsupported("a colour picture holds no heights; `channel` chooses one of `R`, `G`, `B`")
        })?;
        let band = ["R", "G", "B"].iter().position(|c| c.eq_ignore_ascii_case(asked)).ok_or_else(|| {
            Fault::Channel { asked: asked.to_owned(), known: "there are `R`, `G`, `B`".into() }
        })?;
        flat.skip += 4 * band as u64;
        flat.step = 12;
        flat.line = cols.saturating_mul(12);
    }
    flat.check(input)?;
    Ok((flat, bands))
}

fn claim(input: &Input<'_>) -> Result<Claim, Fault> {
    let (flat, _) = layout(input)?;
    Claim::new(input, [flat.cols, flat.rows], flat.line)
}

fn read(input: &Input<'_>) -> Result<HeightFile, Fault> {
    let (flat, bands) = layout(input)?;
    let data = flat.read(input, height(None))?;
    let mut origin = Origin::new(&CODEC, "f32");
    origin.bands = bands;
    let (cols, rows) = (flat.cols as usize, flat.rows as usize);
    let mut file = HeightFile { cols, rows, data, metres: true, placement: Placement::default(), origin };
    file.flip();
    input.sidecar()?.apply(&mut file, None, input.reading);
    Ok(file)
}
