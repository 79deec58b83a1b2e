//! Which channel of a picture holds the heights.
//!
//! A channel's name is what follows its last dot; what stands before it names the layer. Several parts of a file are
//! layers as well, by the name of the part.

use exr::meta::header::Header;
use exr::prelude::Text;

use super::super::error::Fault;

/// The channel that is read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Pick {
    /// Index of the part.
    pub(super) part: usize,
    /// Index of the channel in the part.
    pub(super) channel: usize,
    /// Name of part, layer and channel.
    pub(super) name: String,
    /// Indices of channels that must hold the same, or the picture is one of colours.
    pub(super) same: Vec<usize>,
}

/// Names of what is up, the likeliest first; those of a line are as good as each other.
const HEIGHTS: [&[&str]; 4] =
    [&["height", "heights", "heightmap", "elevation", "altitude"], &["z", "depth"], &["h"], &["y"]];

/// A channel and what its names say.
struct Candidate {
    pick: Pick,
    layer: String,
    own: String,
}

/// Chooses the channel of heights: the one asked for, or the likeliest by its name.
pub(super) fn channel(headers: &[Header], asked: Option<&str>) -> Result<Pick, Fault> {
    let all = candidates(headers);
    if let Some(asked) = asked {
        return named(all, asked);
    }
    let (mut opaque, alphas): (Vec<_>, Vec<_>) = all.into_iter().partition(|c| !is_alpha(&c.own));
    if opaque.is_empty() {
        let why = if alphas.is_empty() { "no flat picture" } else { "nothing but alpha" };
        return Err(Fault::unsupported(format!("{why}, which holds no heights")));
    }
    if opaque.len() == 1 {
        return Ok(opaque.remove(0).pick);
    }
    let ranks: Vec<_> = opaque.iter().map(|c| rank(c, &opaque)).collect();
    let best = ranks.iter().min().copied().unwrap_or(usize::MAX);
    let mut likely: Vec<_> = opaque.iter().zip(ranks).filter(|(_, r)| *r == best).map(|(c, _)| c).collect();
    if best == usize::MAX {
        // Nothing is named as heights are: grey in three channels may be meant.
        return grey(&opaque).ok_or_else(|| ambiguous(&opaque));
    }
    match (likely.pop(), likely.is_empty()) {
        (Some(only), true) => Ok(only.pick.clone()),
        _ => Err(ambiguous(&opaque)),
    }
}

fn candidates(headers: &[Header]) -> Vec<Candidate> {
    let mut all = Vec::new();
    for (part, header) in headers.iter().enumerate().filter(|(_, h)| !h.deep) {
        let layer = header.own_attributes.layer_name.as_ref().map(letters);
        for (channel, c) in header.channels.list.iter().enumerate() {
            let inner = letters(&c.name);
            let name = match layer.as_deref() {
                Some(layer) if !layer.is_empty() && headers.len() > 1 => format!("{layer}.{inner}"),
                _ => inner,
            };
            let (layer, own) = name.rsplit_once('.').unwrap_or(("", &name));
            let (layer, own) = (layer.to_ascii_lowercase(), own.to_ascii_lowercase());
            all.push(Candidate { pick: Pick { part, channel, name, same: Vec::new() }, layer, own });
        }
    }
    all
}

fn named(all: Vec<Candidate>, asked: &str) -> Result<Pick, Fault> {
    let exact = all.iter().position(|c| c.pick.name == asked);
    let loose = || all.iter().position(|c| c.pick.name.eq_ignore_ascii_case(asked));
    match exact.or_else(loose) {
        Some(i) => Ok(all[i].pick.clone()),
        None => Err(Fault::Channel { asked: asked.to_owned(), known: known(&all) }),
    }
}

fn is_alpha(own: &str) -> bool {
    matches!(own, "a" | "alpha" | "ar" | "ag" | "ab" | "opacity")
}

/// How likely a channel holds heights, 0 the most; the highest number where its name says nothing.
fn rank(c: &Candidate, all: &[Candidate]) -> usize {
    let of = |word: &str| HEIGHTS.iter().position(|words| words.contains(&word));
    let beside =
        |own: &str| all.iter().any(|o| o.pick.part == c.pick.part && o.layer == c.layer && o.own == own);
    // Of a vector x, y, z no part is a height by its name alone.
    if matches!(c.own.as_str(), "y" | "z") && beside("x") {
        return usize::MAX;
    }
    let by_layer = || {
        let alone = all.iter().filter(|o| o.pick.part == c.pick.part && o.layer == c.layer).count() == 1;
        let last = c.layer.rsplit('.').next().unwrap_or_default();
        if alone { of(last) } else { None }
    };
    of(&c.own).or_else(by_layer).unwrap_or(usize::MAX)
}

/// Red, green and blue of the only layer, where there is one: grey if they are the same.
fn grey(all: &[Candidate]) -> Option<Pick> {
    let find = |own: &str| {
        let mut found = all.iter().filter(|c| c.own == own);
        found.next().filter(|_| found.next().is_none())
    };
    let [r, g, b] = [find("r")?, find("g")?, find("b")?];
    let together = all.len() == 3 && [g, b].iter().all(|c| c.pick.part == r.pick.part && c.layer == r.layer);
    together.then(|| Pick { same: vec![g.pick.channel, b.pick.channel], ..r.pick.clone() })
}

fn ambiguous(all: &[Candidate]) -> Fault {
    Fault::Unsupported(format!(
        "several channels may hold the heights; `channel` chooses among {}",
        names(all)
    ))
}

/// What there is, as a clause.
fn known(all: &[Candidate]) -> String {
    format!("there {} {}", if all.len() == 1 { "is" } else { "are" }, names(all))
}

/// A name as people write it: in UTF-8, or, in old files, a byte a letter.
fn letters(text: &Text) -> String {
    std::str::from_utf8(text.bytes()).map_or_else(|_| text.to_string(), str::to_owned)
}

/// The names of channels, as many as a person reads.
fn names(all: &[Candidate]) -> String {
    const SHOWN: usize = 24;
    let mut text: Vec<_> = all.iter().take(SHOWN).map(|c| format!("`{}`", c.pick.name)).collect();
    if all.len() > SHOWN {
        text.push(format!("{} more", all.len() - SHOWN));
    }
    text.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        let shown = |bytes: &[u8]| letters(&Text::from_slice_unchecked(bytes));
        assert_eq!(shown("höhe".as_bytes()), "höhe");
        assert_eq!(shown("高さ.Z".as_bytes()), "高さ.Z");
        assert_eq!(shown(b"h\xf6he"), "höhe", "a byte a letter");
    }
}
