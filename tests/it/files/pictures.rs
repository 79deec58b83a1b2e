//! Pictures: what is read of each kind, what is refused, and what `import_picture` makes of it.

use std::io::{Cursor, Write as _};
use std::sync::Arc;

use orograph::files::{
    Channel, Kernel, Limits, Picture, PictureClaim, PictureKind, PixelSpan, Texture, TextureColumns,
};
use orograph::kit::color::{linear_from_srgb, srgb_from_linear};
use orograph::node::{Cancel, Context, Error, Node, SourceFile};
use orograph::nodes::files::import_picture::{ImportPicture, Inputs, Outputs, PicturePlacing};
use orograph::units::{Degrees, FilePath, Metres};
use orograph::value::Terrain;
use orograph::work::Work;

const COLS: usize = 37;
const ROWS: usize = 23;

/// What the fixtures show, made by Pillow 11: ramps to the east, to the south and along the diagonal.
fn shown(k: usize) -> [u8; 3] {
    let (i, j) = ((k % COLS) as f64, (k / COLS) as f64);
    // Numpy rounds halves to even.
    let of = |v: f64, most: usize| (v * 255.0 / most as f64).round_ties_even() as u8;
    [of(i, COLS - 1), of(j, ROWS - 1), of(i + j, COLS + ROWS - 2)]
}

fn read(name: &str, bytes: &[u8]) -> Picture {
    Picture::read(name, bytes, &Limits::default(), &Work::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// The pixels, each component 0 to 255 as a float, as a texture gives them.
fn pixels(picture: &Picture, mask: Channel) -> Vec<([f32; 3], f32)> {
    let texture = Texture::new(&Arc::new(picture.clone()), mask, [1; 2], &Work::default());
    let at = |k: usize| {
        let place = [(k % picture.cols) as f64, (k / picture.cols) as f64];
        texture.at(place, PixelSpan([1.0; 2]), Kernel::Cubic, |m| {
            (m.color().map(|c| c * 255.0), m.mask() * 255.0)
        })
    };
    (0..picture.cols * picture.rows).map(at).collect()
}

fn shows(name: &str, bytes: &[u8], tolerance: f32) {
    let picture = read(name, bytes);
    assert_eq!((picture.cols, picture.rows), (COLS, ROWS), "{name}");
    let claim = PictureClaim::of(name, &mut Cursor::new(bytes), &Limits::default()).unwrap();
    assert_eq!((claim.cols, claim.rows), (COLS as u64, ROWS as u64), "{name}");
    for (k, (color, _)) in pixels(&picture, Channel::Auto).iter().enumerate() {
        for (found, want) in color.iter().zip(shown(k)) {
            let want = f32::from(want);
            assert!((found - want).abs() <= tolerance, "{name}: {k}: {found}, not {want}");
        }
    }
}

/// A PNG of some samples, big-endian where they are of 16 bits.
fn png(color: png::ColorType, depth: png::BitDepth, [cols, rows]: [usize; 2], data: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, cols as u32, rows as u32);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(data).unwrap();
    writer.finish().unwrap();
    out
}

fn bmp() -> Vec<u8> {
    let line = (COLS * 3).next_multiple_of(4);
    let mut out = b"BM".to_vec();
    let mut put = |v: u32| out.extend(v.to_le_bytes());
    [(54 + line * ROWS) as u32, 0, 54, 40, COLS as u32, ROWS as u32, 1 | 24 << 16]
        .into_iter()
        .for_each(&mut put);
    [0, 0, 0, 0, 0, 0].into_iter().for_each(&mut put);
    // From the lowest row up, blue first.
    for j in (0..ROWS).rev() {
        let start = out.len();
        (0..COLS).for_each(|i| out.extend(shown(j * COLS + i).into_iter().rev()));
        out.resize(start + line, 0);
    }
    out
}

fn tga() -> Vec<u8> {
    let mut out = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, COLS as u8, 0, ROWS as u8, 0, 24, 0x20];
    (0..COLS * ROWS).for_each(|k| out.extend(shown(k).into_iter().rev()));
    out
}

/// A PSD: header, an empty colour table, resources and layers, then planes in some compression.
fn psd(version: u16, mode: u16, depth: u16, planes: &[Vec<u8>], compression: u16) -> Vec<u8> {
    let mut out = b"8BPS".to_vec();
    out.extend(version.to_be_bytes());
    out.extend([0; 6]);
    out.extend((planes.len() as u16).to_be_bytes());
    out.extend((ROWS as u32).to_be_bytes());
    out.extend((COLS as u32).to_be_bytes());
    out.extend(depth.to_be_bytes());
    out.extend(mode.to_be_bytes());
    out.extend(0u32.to_be_bytes());
    out.extend(6u32.to_be_bytes());
    out.extend(b"8BIMxy");
    out.extend(if version == 2 { vec![0; 8] } else { vec![0; 4] });
    out.extend(compression.to_be_bytes());
    let line = COLS * usize::from(depth) / 8;
    match compression {
        0 => planes.iter().for_each(|p| out.extend(p)),
        1 => {
            // Every row as runs of one byte and copies of the rest.
            let rows: Vec<Vec<u8>> = planes.iter().flat_map(|p| p.chunks(line)).map(packed).collect();
            for row in &rows {
                match version {
                    2 => out.extend((row.len() as u32).to_be_bytes()),
                    _ => out.extend((row.len() as u16).to_be_bytes()),
                }
            }
            rows.iter().for_each(|r| out.extend(r));
        }
        _ => {
            let mut zip = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
            for row in planes.iter().flat_map(|p| p.chunks(line)) {
                let mut row = row.to_vec();
                if compression == 3 {
                    (1..row.len()).rev().for_each(|i| row[i] = row[i].wrapping_sub(row[i - 1]));
                }
                zip.write_all(&row).unwrap();
            }
            out.extend(zip.finish().unwrap());
        }
    }
    out
}

/// A row as `PackBits`: one run of its first byte as far as it goes, then copies.
fn packed(row: &[u8]) -> Vec<u8> {
    let run = row.iter().take_while(|b| **b == row[0]).count().min(128);
    let mut out = vec![(1 - run as i16) as i8 as u8, row[0]];
    for copy in row[run..].chunks(128) {
        out.push((copy.len() - 1) as u8);
        out.extend(copy);
    }
    out
}

fn plane(channel: usize) -> Vec<u8> {
    (0..COLS * ROWS).map(|k| shown(k)[channel]).collect()
}

fn planes() -> Vec<Vec<u8>> {
    (0..3).map(plane).collect()
}

#[test]
fn every_kind_of_picture_shows_the_same() {
    let rgb: Vec<u8> = (0..COLS * ROWS).flat_map(shown).collect();
    shows("a.png", &png(png::ColorType::Rgb, png::BitDepth::Eight, [COLS, ROWS], &rgb), 0.01);
    let wide: Vec<u8> = rgb.iter().flat_map(|v| (u16::from(*v) * 257).to_be_bytes()).collect();
    shows("a.png", &png(png::ColorType::Rgb, png::BitDepth::Sixteen, [COLS, ROWS], &wide), 0.01);
    shows("a.bmp", &bmp(), 0.01);
    shows("a.tga", &tga(), 0.01);
    for (version, compression) in [(1, 0), (1, 1), (2, 1), (2, 0), (1, 2), (1, 3)] {
        shows("a.psd", &psd(version, 3, 8, &planes(), compression), 0.01);
    }
    shows("a.webp", include_bytes!("fixtures/picture_lossless.webp"), 0.01);
    shows("a.webp", include_bytes!("fixtures/picture_lossy.webp"), 10.0);
    shows("a.jpg", include_bytes!("fixtures/picture.jpg"), 7.0);
    shows("a.jpeg", include_bytes!("fixtures/picture_progressive.jpg"), 12.0);
    // What a file is called does not matter where its content says what it is.
    shows("a.png", include_bytes!("fixtures/picture.jpg"), 7.0);
    let grey = read("a.jpg", include_bytes!("fixtures/picture_grey.jpg"));
    let [left, right] = [pixels(&grey, Channel::Auto)[0], pixels(&grey, Channel::Auto)[COLS * ROWS - 1]];
    assert!(left.1 < 6.0 && right.1 > 249.0, "{left:?} {right:?}");
}

#[test]
fn masks_are_opacity_or_brightness_to_the_number() {
    let grey: Vec<u8> = (0..=255).collect();
    let picture = read("a.png", &png(png::ColorType::Grayscale, png::BitDepth::Eight, [16, 16], &grey));
    assert!(!picture.has_alpha);
    for mask in [Channel::Auto, Channel::Luminance, Channel::Red, Channel::Green, Channel::Blue] {
        for (k, (_, m)) in pixels(&picture, mask).iter().enumerate() {
            assert!((m / 255.0 - k as f32 / 255.0).abs() < 1e-6, "{mask:?}: {m} at {k}");
        }
    }
    assert!(pixels(&picture, Channel::Alpha).iter().all(|(_, m)| *m == 255.0));
    // Half transparent: the mask is that, and the colours do not run into each other over the edge.
    let picture = read("a.webp", include_bytes!("fixtures/picture_lossless.webp"));
    assert!(picture.has_alpha);
    for (k, (color, m)) in pixels(&picture, Channel::Auto).iter().enumerate() {
        assert_eq!(*m, if k % COLS < COLS / 2 { 255.0 } else { 0.0 });
        assert!((color[1] - f32::from(shown(k)[1])).abs() < 0.01, "the colour below is kept");
    }
    // The first channel beside the colours of a PSD is its opacity.
    let alpha: Vec<u8> = (0..COLS * ROWS).map(|k| (k % 256) as u8).collect();
    let picture = read("a.psd", &psd(1, 3, 8, &[planes(), vec![alpha.clone()]].concat(), 1));
    for (k, (_, m)) in pixels(&picture, Channel::Auto).iter().enumerate() {
        assert!((m - f32::from(alpha[k])).abs() < 1e-4);
    }
}

#[test]
fn psds_of_other_modes_are_read_or_named() {
    let grey: Vec<u8> = plane(0);
    let picture = read("a.psd", &psd(1, 1, 8, std::slice::from_ref(&grey), 1));
    for (k, (color, _)) in pixels(&picture, Channel::Auto).iter().enumerate() {
        assert!(color.iter().all(|c| (c - f32::from(grey[k])).abs() < 0.01));
    }
    // 32-bit floats are light.
    let floats: Vec<u8> =
        grey.iter().flat_map(|v| linear_from_srgb(f32::from(*v) / 255.0).to_be_bytes()).collect();
    let picture = read("a.psd", &psd(1, 1, 32, &[floats], 0));
    for (k, (color, _)) in pixels(&picture, Channel::Auto).iter().enumerate() {
        assert!((color[0] - f32::from(grey[k])).abs() < 0.02, "{} for {}", color[0], grey[k]);
    }
    let says = |bytes: &[u8]| {
        Picture::read("a.psd", bytes, &Limits::default(), &Work::default()).expect_err("refused").to_string()
    };
    let cmyk = psd(1, 4, 8, &[planes(), vec![plane(0)]].concat(), 0);
    assert!(says(&cmyk).contains("CMYK"), "{}", says(&cmyk));
    assert!(says(&psd(1, 3, 1, &planes(), 0)).contains("1 bits"));
    let short = psd(1, 3, 8, &planes(), 0);
    assert!(says(&short[..short.len() - 1]).contains("ends early"));
    assert!(says(&psd(1, 3, 8, &planes()[..1], 0)).contains("1 channels"));
}

/// Any cut and any flipped byte is a picture or an error, and no claim takes memory that the limits forbid.
#[test]
fn damaged_pictures_are_errors() {
    let rgb: Vec<u8> = (0..COLS * ROWS).flat_map(shown).collect();
    let whole: Vec<(&str, Vec<u8>)> = vec![
        ("a.png", png(png::ColorType::Rgb, png::BitDepth::Eight, [COLS, ROWS], &rgb)),
        ("a.jpg", include_bytes!("fixtures/picture_progressive.jpg").to_vec()),
        ("b.jpg", include_bytes!("fixtures/picture.jpg").to_vec()),
        ("a.webp", include_bytes!("fixtures/picture_lossless.webp").to_vec()),
        ("b.webp", include_bytes!("fixtures/picture_lossy.webp").to_vec()),
        ("a.bmp", bmp()),
        ("a.tga", tga()),
        ("a.psd", psd(1, 3, 8, &planes(), 1)),
        ("a.psb", psd(2, 3, 8, &planes(), 3)),
    ];
    let limits = Limits { samples: 100_000, side: 2000 };
    let (mut read, mut refused) = (0, 0);
    let mut take = |name: &str, bytes: &[u8]| match Picture::read(name, bytes, &limits, &Work::default()) {
        Ok(picture) => {
            assert!(picture.cols * picture.rows <= 100_000);
            read += 1;
        }
        Err(e) => {
            assert!(e.to_string().ends_with(name), "{e}");
            refused += 1;
        }
    };
    for (name, bytes) in &whole {
        for end in (0..bytes.len()).step_by(bytes.len() / 60 + 1) {
            take(name, &bytes[..end]);
        }
        for at in (0..bytes.len()).step_by(bytes.len() / 160 + 1) {
            for flip in [0x01, 0x80, 0xff] {
                let mut bad = bytes.clone();
                bad[at] ^= flip;
                take(name, &bad);
            }
        }
    }
    assert!(read > 200 && refused > 200, "{read} read, {refused} refused");
    // Headers that claim more than anybody has.
    let mut huge = bmp();
    huge[18..26].copy_from_slice(&[0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0x7f]);
    let e = PictureClaim::of("a.bmp", &mut Cursor::new(&huge), &Limits::default()).expect_err("too large");
    assert!(e.to_string().contains("2147483647"), "{e}");
}

#[test]
fn what_is_no_picture_is_named() {
    let says = |name: &str, bytes: &[u8]| {
        Picture::read(name, bytes, &Limits::default(), &Work::default()).expect_err("refused").to_string()
    };
    assert!(says("a.gif", b"GIF89a").contains("`.gif`"));
    assert!(says("a", b"").contains("without extension"));
    assert!(says("a.jpg", b"hello").contains("no picture"));
    assert!(says("a.jpeg", b"\xff\xd8\xff\xd9").contains("no size"));
    let kind = |name: &str, bytes: &[u8]| {
        PictureClaim::of(name, &mut Cursor::new(bytes), &Limits::default()).map(|c| c.kind)
    };
    assert_eq!(kind("a.tga", &tga()).unwrap(), PictureKind::Tga);
}

fn source(bytes: Vec<u8>) -> Arc<SourceFile> {
    Arc::new(SourceFile::new("a.png".into(), bytes))
}

fn run(node: &ImportPicture, file: Vec<u8>, terrain: &Terrain, size: u32) -> Result<Outputs, Error> {
    let (cancel, files) = (Cancel::default(), [source(file)]);
    let grid = terrain.grid(size).expect("fits");
    node.run(&Context { files: &files, ..Context::bare(grid, terrain, &cancel) }, Inputs {})
}

fn node(placement: PicturePlacing) -> ImportPicture {
    ImportPicture { file: FilePath("a.png".into()), placement, ..ImportPicture::default() }
}

fn greys(cols: usize, rows: usize, f: impl Fn(usize, usize) -> u8) -> Vec<u8> {
    let data: Vec<u8> = (0..cols * rows).map(|k| f(k % cols, k / cols)).collect();
    png(png::ColorType::Grayscale, png::BitDepth::Eight, [cols, rows], &data)
}

#[test]
fn a_picture_is_the_mean_of_what_a_sample_stands_for() {
    // Black and white pixels by turns, sixteen to a base cell.
    let checks = greys(513, 513, |i, j| if (i + j) % 2 == 0 { 255 } else { 0 });
    let terrain = Terrain { width: 512.0, depth: 512.0, base: 33, ..Terrain::default() };
    let out = run(&node(PicturePlacing::Stretch), checks.clone(), &terrain, 33).expect("runs");
    let light = srgb_from_linear(0.5);
    for k in 0..out.colors.data().len() {
        assert!((out.colors.data()[k][0] - light).abs() < 0.02, "half the light: {:?}", out.colors.data()[k]);
        assert!((out.mask.data()[k] - 0.5).abs() < 0.02, "half of it: {}", out.mask.data()[k]);
    }
    // On coarser grids the same, at the same places to the bit.
    let coarse = run(&node(PicturePlacing::Stretch), checks.clone(), &terrain, 17).expect("runs");
    for (i, j) in [(0, 0), (3, 5), (16, 16), (7, 12)] {
        assert_eq!(coarse.mask.at(i, j).to_bits(), out.mask.at(2 * i, 2 * j).to_bits());
    }
    // At its own size it is itself.
    let fine = run(&node(PicturePlacing::Stretch), checks, &terrain, 513).expect("runs");
    for (k, m) in fine.mask.data().iter().enumerate() {
        assert_eq!(*m, if (k % 513 + k / 513) % 2 == 0 { 1.0 } else { 0.0 });
    }
}

#[test]
fn a_picture_drawn_out_is_smooth_and_exact_at_its_pixels() {
    let dots = greys(9, 9, |i, j| ((i * 31 + j * 17) % 256) as u8);
    let terrain = Terrain { width: 800.0, depth: 800.0, base: 129, ..Terrain::default() };
    for interpolation in [Kernel::Cubic, Kernel::Linear, Kernel::Nearest] {
        let node = ImportPicture { interpolation, ..node(PicturePlacing::Stretch) };
        let out = run(&node, dots.clone(), &terrain, 129).expect("runs");
        for (i, j) in (0..9).flat_map(|j| (0..9).map(move |i| (i, j))) {
            let want = ((i * 31 + j * 17) % 256) as f32 / 255.0;
            let found = out.mask.at(i * 16, j * 16);
            assert!((found - want).abs() < 1e-6, "{interpolation:?}: {found}, not {want}");
        }
        let steps = out.mask.row(8).windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max);
        let jumps = interpolation == Kernel::Nearest;
        assert_eq!(steps > 0.06, jumps, "{interpolation:?} steps by {steps}");
    }
}

#[test]
fn a_picture_at_true_size_turns_and_its_border_goes_on() {
    let ramp = greys(11, 5, |i, _| (i * 20) as u8);
    let terrain = Terrain { width: 200.0, depth: 200.0, base: 41, ..Terrain::default() };
    let placed = |rotation: f64| PicturePlacing::TrueSize {
        cell: Metres(5.0),
        x: Metres(10.0),
        y: Metres(-20.0),
        rotation: Degrees(rotation),
    };
    let straight = run(&node(placed(0.0)), ramp.clone(), &terrain, 41).expect("runs");
    // Its middle, the sixth pixel, lies at 110, 80 m: column 22, row 16.
    for i in -7..=7 {
        let pixel = (5 + i).clamp(0, 10) as f32;
        assert!((straight.mask.at(22 + i, 16) - pixel * 20.0 / 255.0).abs() < 1e-6, "{i}");
        assert_eq!(straight.inside.at(22 + i, 16), if (-5..=5).contains(&i) { 1.0 } else { 0.0 });
    }
    assert_eq!((straight.inside.at(22, 18), straight.inside.at(22, 19)), (1.0, 0.0));
    // A quarter turn clockwise: what lay to the east lies to the south.
    let turned = run(&node(placed(90.0)), ramp, &terrain, 41).expect("runs");
    for i in -5..=5 {
        assert!((turned.mask.at(22, 16 + i) - straight.mask.at(22 + i, 16)).abs() < 1e-5, "{i}");
    }
}

#[test]
fn a_picture_that_is_missing_or_broken_names_its_parameter() {
    let terrain = Terrain { width: 200.0, depth: 200.0, base: 41, ..Terrain::default() };
    let none = run(&ImportPicture::default(), Vec::new(), &terrain, 41).err().expect("none").to_string();
    assert!(none.contains("parameter `file` names no file"), "{none}");
    let broken =
        run(&node(PicturePlacing::Stretch), b"GIF".to_vec(), &terrain, 41).err().expect("no PNG").to_string();
    assert!(broken.contains("parameter `file`") && broken.ends_with("a.png"), "{broken}");
}

/// Columns prepared for all rows give what single places give, up to rounding.
#[test]
fn rows_and_places_agree() {
    let picture = Arc::new(read("a.bmp", &bmp()));
    for (kernel, footprint) in [
        (Kernel::Cubic, [1.0, 1.0]),
        (Kernel::Cubic, [3.7, 1.6]),
        (Kernel::Linear, [0.2, 5.0]),
        (Kernel::Nearest, [4.0, 4.0]),
    ] {
        let footprint = PixelSpan(footprint);
        let texture =
            Texture::new(&picture, Channel::Luminance, footprint.reduction(kernel), &Work::default());
        let places: Vec<f64> = (0..60).map(|i| f64::from(i) * 0.71 - 3.0).collect();
        let columns: TextureColumns = texture.columns(places.iter().copied(), footprint, kernel);
        for v in [-2.0, 0.0, 7.3, 22.0, 40.0] {
            let mut row = vec![([0f32; 3], 0f32); places.len()];
            texture.row(&columns, v, footprint, kernel, &mut row, |m| (m.color(), m.mask()));
            for (u, (color, mask)) in places.iter().zip(&row) {
                let (c, m) = texture.at([*u, v], footprint, kernel, |m| (m.color(), m.mask()));
                assert!(
                    (m - mask).abs() < 1e-5 && (0..3).all(|k| (c[k] - color[k]).abs() < 1e-4),
                    "{kernel:?} {u} {v}"
                );
            }
        }
    }
}
