//! Any bytes as any picture: an error or a sound picture, within the limits. `cargo +nightly fuzz run picture`.
#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use orograph::files::{Limits, Picture, PictureClaim, PictureKind};
use orograph::node::Cancel;

const LIMITS: Limits = Limits { samples: 1 << 16, side: 1 << 12 };

fuzz_target!(|input: (u8, &[u8])| {
    let (n, bytes) = input;
    let name = format!("a.{}", PictureKind::EXTENSIONS[usize::from(n) % PictureKind::EXTENSIONS.len()]);
    let claim = PictureClaim::of(&name, &mut Cursor::new(bytes), &LIMITS);
    let Ok(picture) = Picture::read(&name, bytes, &LIMITS, &Cancel::default()) else { return };
    let claim = claim.expect("what is read was claimed");
    assert_eq!([picture.cols as u64, picture.rows as u64], [claim.cols, claim.rows]);
    assert!(picture.bytes() <= claim.bytes());
});
