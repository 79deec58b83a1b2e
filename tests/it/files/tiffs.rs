//! TIFFs as a test wants them, true or lying, without the writer that is tested.

/// What stands behind a tag.
#[derive(Clone, Copy)]
pub(crate) enum Entry<'a> {
    Short(u16),
    Long(u32),
    Shorts(&'a [u16]),
    Doubles(&'a [f64]),
    Text(&'a str),
    /// So many long numbers that are said to stand at an offset of the file.
    Elsewhere(u32, u32),
}

impl Entry<'_> {
    fn kind(self) -> u16 {
        match self {
            Self::Text(_) => 2,
            Self::Short(_) | Self::Shorts(_) => 3,
            Self::Long(_) | Self::Elsewhere(..) => 4,
            Self::Doubles(_) => 12,
        }
    }

    /// How many values there are, and their bytes.
    fn values(self) -> (u32, Vec<u8>) {
        match self {
            Self::Short(v) => (1, v.to_le_bytes().to_vec()),
            Self::Long(v) => (1, v.to_le_bytes().to_vec()),
            Self::Elsewhere(count, offset) => (count, offset.to_le_bytes().to_vec()),
            Self::Shorts(all) => (all.len() as u32, all.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Self::Doubles(all) => (all.len() as u32, all.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Self::Text(text) => (text.len() as u32 + 1, [text.as_bytes(), b"\0"].concat()),
        }
    }
}

/// The tags of a grey picture in one strip, which stands where [`tiff`] puts it: its size, bits and format of a sample (1 for
/// integers, 3 for floats), its compression, and the bytes that the strip is said to have.
pub(crate) fn grey(
    [cols, rows]: [u32; 2],
    (bits, format): (u16, u16),
    compression: u16,
    strip: u32,
) -> Vec<(u16, Entry<'static>)> {
    vec![
        (256, Entry::Long(cols)),
        (257, Entry::Long(rows)),
        (258, Entry::Short(bits)),
        (259, Entry::Short(compression)),
        (262, Entry::Short(1)),
        (273, Entry::Long(8)),
        (277, Entry::Short(1)),
        (278, Entry::Long(rows)),
        (279, Entry::Long(strip)),
        (339, Entry::Short(format)),
    ]
}

/// A little-endian TIFF of a strip and some tags.
pub(crate) fn tiff(strip: &[u8], tags: &[(u16, Entry<'_>)]) -> Vec<u8> {
    let mut out = [b"II*\0\0\0\0\0", strip].concat();
    let mut entries = Vec::new();
    for (tag, entry) in tags {
        let (count, mut value) = entry.values();
        if value.len() > 4 {
            let at = out.len() as u32;
            out.extend(&value);
            value = at.to_le_bytes().to_vec();
        }
        value.resize(4, 0);
        entries.push((*tag, entry.kind(), count, value));
    }
    entries.sort_by_key(|e| e.0);
    let directory = out.len() as u32;
    out[4..8].copy_from_slice(&directory.to_le_bytes());
    out.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, value) in entries {
        out.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
        out.extend([&count.to_le_bytes()[..], &value].concat());
    }
    out.extend([0; 4]);
    out
}
