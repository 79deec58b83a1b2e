//! r16 and r32: samples and nothing else, little-endian.

use super::error::Fault;
use super::format::Source;
use super::height::{HeightFile, Limits, Origin};
use super::place::Placement;
use super::sidecar::Sidecar;

/// Reads 16-bit integers; the sidecar gives size and range, without it the file must be square.
pub(super) fn read_r16(bytes: &[u8], sidecar: &Sidecar, limits: &Limits) -> Result<HeightFile, Fault> {
    let size = size(bytes, 2, sidecar, limits)?;
    let (pairs, _) = bytes.as_chunks::<2>();
    let data = pairs.iter().map(|b| f32::from(u16::from_le_bytes(*b))).collect();
    let mut file = height_file(size, data, Origin::new(Source::R16, "u16"), false);
    sidecar.apply(&mut file, Some(65535.0));
    Ok(file)
}

/// Reads 32-bit floats; the sidecar gives the size, without it the file must be square.
pub(super) fn read_r32(bytes: &[u8], sidecar: &Sidecar, limits: &Limits) -> Result<HeightFile, Fault> {
    let size = size(bytes, 4, sidecar, limits)?;
    let (quads, _) = bytes.as_chunks::<4>();
    let data = quads.iter().map(|b| finite_or_void(f32::from_le_bytes(*b))).collect();
    // A sidecar vouches for the unit of floats even where it gives no range.
    let metres = sidecar.orograph.is_some();
    let mut file = height_file(size, data, Origin::new(Source::R32, "f32"), metres);
    let scaled = sidecar.scale.is_some() || sidecar.offset.is_some();
    sidecar.apply(&mut file, (scaled && !metres).then_some(1.0));
    Ok(file)
}

/// A number of a float file: what is not finite is a void.
pub(super) fn finite_or_void(v: f32) -> f32 {
    if v.is_finite() { v } else { f32::NAN }
}

fn height_file([cols, rows]: [usize; 2], data: Vec<f32>, origin: Origin, metres: bool) -> HeightFile {
    HeightFile { cols, rows, data, metres, placement: Placement::default(), origin }
}

fn size(bytes: &[u8], width: u64, sidecar: &Sidecar, limits: &Limits) -> Result<[usize; 2], Fault> {
    let found = bytes.len() as u64;
    let (cols, rows) = match (sidecar.cols, sidecar.rows) {
        (Some(cols), Some(rows)) => (cols, rows),
        _ => {
            let side = (found / width).isqrt();
            if side * side * width != found || found == 0 {
                return Err(Fault::Unsupported(format!(
                    "{found} bytes are no square of {width}-byte samples; a sidecar of the same name with `cols` and `rows` \
                     would tell the size"
                )));
            }
            (side, side)
        }
    };
    limits.samples(cols, rows)?;
    let want = cols * rows * width;
    if want > found {
        return Err(Fault::Short { what: "a raster of the size in the sidecar", want, found });
    }
    if want < found {
        return Err(Fault::Sidecar(format!("says {cols} x {rows} samples, {want} bytes; there are {found}")));
    }
    // Both fit, since their product does.
    Ok([cols as usize, rows as usize])
}
