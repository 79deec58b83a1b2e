//! What files of the field say in ways that are easily read wrongly: flat seas, systems without a code, depths, marks of
//! voids that nobody declares, files of other programs beside them.

use orograph::files::{
    Companion, Encoding, Fault, Format, HeightFile, Input, Limits, ReadError, Reading, Watch, WriteJob,
    Writing, encode_file, read_height,
};

/// Reads a file with what lies beside it.
fn try_read(name: &str, bytes: &[u8], beside: &[(&str, &[u8])]) -> Result<HeightFile, ReadError> {
    let companions: Vec<_> = beside.iter().map(|&(name, bytes)| Companion { name, bytes }).collect();
    let (reading, limits) = (Reading::from(Encoding::Auto), Limits::default());
    let (companions, reading) = (&companions[..], &reading);
    let input = Input { name, bytes: &bytes, companions, reading, limits: &limits, watch: Watch::default() };
    input.read()
}

fn read(name: &str, bytes: &[u8], beside: &[(&str, &[u8])]) -> HeightFile {
    try_read(name, bytes, beside).unwrap_or_else(|e| panic!("{e}"))
}

fn notes(file: &HeightFile) -> String {
    file.origin.notes.join("; ")
}

/// What stands behind a tag.
enum Entry<'a> {
    Short(u16),
    Shorts(&'a [u16]),
    Doubles(&'a [f64]),
    Text(&'a str),
}

impl Entry<'_> {
    fn kind(&self) -> u16 {
        match self {
            Self::Text(_) => 2,
            Self::Short(_) | Self::Shorts(_) => 3,
            Self::Doubles(_) => 12,
        }
    }

    /// How many values there are, and their bytes.
    fn values(&self) -> (u32, Vec<u8>) {
        match self {
            Self::Short(v) => (1, v.to_le_bytes().to_vec()),
            Self::Shorts(all) => (all.len() as u32, all.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Self::Doubles(all) => (all.len() as u32, all.iter().flat_map(|v| v.to_le_bytes()).collect()),
            Self::Text(text) => (text.len() as u32 + 1, [text.as_bytes(), b"\0"].concat()),
        }
    }
}

/// A TIFF of floats in one strip that is packed in some way, with more tags.
fn tiff(side: u16, compression: u16, strip: &[u8], more: &[(u16, Entry<'_>)]) -> Vec<u8> {
    let mut out = b"II*\0\0\0\0\0".to_vec();
    let at = out.len() as u32;
    out.extend(strip);
    let long = |v: u32| v.to_le_bytes().to_vec();
    let mut entries = vec![
        (256, 3, 1, Entry::Short(side).values().1),
        (257, 3, 1, Entry::Short(side).values().1),
        (258, 3, 1, Entry::Short(32).values().1),
        (259, 3, 1, Entry::Short(compression).values().1),
        (262, 3, 1, Entry::Short(1).values().1),
        (273, 4, 1, long(at)),
        (277, 3, 1, Entry::Short(1).values().1),
        (278, 3, 1, Entry::Short(side).values().1),
        (279, 4, 1, long(strip.len() as u32)),
        (339, 3, 1, Entry::Short(3).values().1),
    ];
    for (tag, entry) in more {
        let (count, mut value) = entry.values();
        if value.len() > 4 {
            let at = out.len() as u32;
            out.extend(&value);
            value = long(at);
        }
        entries.push((*tag, entry.kind(), count, value));
    }
    entries.sort_by_key(|e| e.0);
    let directory = out.len() as u32;
    out[4..8].copy_from_slice(&directory.to_le_bytes());
    out.extend((entries.len() as u16).to_le_bytes());
    for (tag, kind, count, mut value) in entries {
        value.resize(4, 0);
        out.extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
        out.extend(long(count));
        out.extend(value);
    }
    out.extend([0; 4]);
    out
}

/// A TIFF of plain floats.
fn floats(side: u16, f: impl Fn(usize) -> f32, more: &[(u16, Entry<'_>)]) -> Vec<u8> {
    let side_ = usize::from(side);
    let strip: Vec<u8> = (0..side_ * side_).flat_map(|k| f(k).to_le_bytes()).collect();
    tiff(side, 1, &strip, more)
}

/// Zeros as ZSTD packs them best: blocks of 128 KiB of one value.
fn zstd_zeros(bytes: usize) -> Vec<u8> {
    const BLOCK: usize = 1 << 17;
    // Magic number, a frame of unknown length, a window of 128 KiB.
    let mut out = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x38];
    for left in (1..=bytes / BLOCK).rev() {
        let head = ((BLOCK as u32) << 3) | 1 << 1 | u32::from(left == 1);
        out.extend(&head.to_le_bytes()[..3]);
        out.push(0);
    }
    out
}

/// A flat sea takes next to nothing, which is no reason to refuse it.
#[test]
fn flat_files_are_read_however_well_they_are_pressed() {
    let bytes = tiff(1024, 50000, &zstd_zeros(4 << 20), &[]);
    assert!(bytes.len() < 400, "{} bytes", bytes.len());
    assert_eq!(read("sea.tif", &bytes, &[]).range(), Some([0.0, 0.0]));
    let lzma = include_bytes!("fixtures/flat_lzma_f32.tif");
    assert_eq!(read("sea.tif", lzma, &[]).range(), Some([0.0, 0.0]));
}

/// The same length does not do where the compression cannot do as much.
#[test]
fn a_claim_is_held_against_its_own_compression() {
    for (compression, fits) in [(1u16, 1usize), (5, 2560), (8, 1032), (32773, 64)] {
        let strip = vec![0; (4 << 20) / fits - 1000];
        let error = try_read("a.tif", &tiff(1024, compression, &strip, &[]), &[]).expect_err("too much");
        assert!(matches!(error.fault, Fault::Overclaim { .. }), "compression {compression}: {error}");
    }
}
