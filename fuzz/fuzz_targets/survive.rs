//! What every reader is asked for: an error or a sound file, within the limits.

use orograph::files::{FileJob, Format, Limits, encode_file, read_height};

const LIMITS: Limits = Limits { samples: 1 << 16, side: 1 << 10 };

/// Reads bytes under a name; what can be read can be written and read again.
pub fn survive(name: &str, bytes: &[u8], sidecar: Option<&[u8]>) {
    let file = match read_height(name, bytes, sidecar, &LIMITS) {
        Ok(file) => file,
        Err(e) => {
            assert!(e.to_string().ends_with(name));
            return;
        }
    };
    assert_eq!(file.data.len(), file.cols * file.rows);
    assert!(file.data.len() as u64 <= LIMITS.samples);
    assert!(file.data.iter().all(|v| v.is_finite() || v.is_nan()));
    let mut out = std::io::Cursor::new(Vec::new());
    encode_file(&FileJob::new(&file, Format::Tiff), &mut out).expect("floats hold any height");
    let again =
        read_height("again.tif", &out.into_inner(), None, &LIMITS).expect("what was written can be read");
    assert!(again.data.iter().zip(&file.data).all(|(a, b)| a == b || (a.is_nan() && b.is_nan())));
}
