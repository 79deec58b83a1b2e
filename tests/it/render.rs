//! Tests of: render. What a picture shows is held to geometry and to the compass.

use orograph::context::Cancel;
use orograph::node::Error;
use orograph::render::{Camera, Edge, GroundPalette, Picture, Scene, Sun, map, perspective, thumbnail};
use orograph::value::{Colors, Field, Grid, Lattice, Quantity, Value, Vectors};
use orograph::work::Work;

fn grid(cols: usize, rows: usize, cell: f64) -> Grid {
    let intervals = cols as u32 - 1;
    let lattice = Lattice { origin: [0.0, 0.0], span: cell * f64::from(intervals), intervals };
    Grid { lattice, col: 0, row: 0, cols, rows }
}

fn field(cols: usize, rows: usize, cell: f64, f: impl Fn(f64, f64) -> f32) -> Field {
    Field::from_fn(grid(cols, rows, cell), Quantity::Elevation, f)
}

/// Hills with a basin, rough enough to have shadows, steep ground and water.
fn hills(cols: usize, rows: usize) -> Field {
    field(cols, rows, 20.0, |x, y| {
        let wave = |a: f64, b: f64| libm::sin(x * a + 1.3) * libm::cos(y * b - 0.4);
        (120.0 * wave(0.004, 0.005) + 60.0 * wave(0.011, 0.009) + 15.0 * wave(0.05, 0.06)) as f32
    })
}

fn drawn(scene: &Scene<'_>, width: Option<usize>) -> Picture {
    map(scene, width, &Work::new(&Cancel::default())).expect("a good scene")
}

fn seen(scene: &Scene<'_>, camera: &Camera) -> Picture {
    perspective(scene, camera, &Work::new(&Cancel::default())).expect("a good scene")
}

fn clay(height: &Field, azimuth: f64, altitude: f64) -> Scene<'_> {
    Scene { palette: GroundPalette::Clay, sun: Sun { azimuth, altitude }, ..Scene::new(height) }
}

fn light([r, g, b]: [u8; 3]) -> i32 {
    i32::from(r) + i32::from(g) + i32::from(b)
}

#[test]
fn a_shadow_is_as_long_as_the_wall_is_high_over_the_tangent_of_the_sun() {
    let (height, cell, side) = (100.0, 5.0, 161);
    let middle = 80.0 * cell;
    for altitude in [20.0f64, 30.0, 50.0] {
        let length = height / libm::tan(altitude.to_radians());
        for (azimuth, [east, south]) in
            [(90.0, [1.0, 0.0]), (270.0, [-1.0, 0.0]), (0.0, [0.0, -1.0]), (180.0, [0.0, 1.0])]
        {
            // A wall four cells thick across the light, through the middle.
            let wall = field(side, side, cell, |x, y| {
                let along: f64 = (x - middle) * east + (y - middle) * south;
                if along.abs() <= 2.0 * cell { height as f32 } else { 0.0 }
            });
            let picture = drawn(&clay(&wall, azimuth, altitude), None);
            let at = |steps: f64| {
                let place = |d: f64| (80.0 - d * steps) as usize;
                light(picture.at(place(east), place(south)))
            };
            let (shade, lit) = (at(4.0), at(76.0));
            assert!(lit > shade + 150, "sun {azimuth}/{altitude}: {shade} in the shadow, {lit} outside");
            let half = f64::from(shade + lit) / 2.0;
            let edge = (4..76).find(|&n| f64::from(at(f64::from(n))) > half).unwrap();
            let want = 2.0 + length / cell;
            assert!(
                (f64::from(edge) - want).abs() <= 1.5,
                "sun {azimuth}/{altitude}: ends at {edge}, not {want}"
            );
        }
    }
}

#[test]
fn ground_that_faces_the_sun_is_brighter_and_mirror_slopes_are_equal() {
    let side = 101;
    let shade = |slope_east: f64, slope_south: f64| {
        let plane = field(side, side, 10.0, |x, y| (slope_east * x + slope_south * y) as f32);
        let picture = drawn(&clay(&plane, 180.0, 40.0), None);
        light(picture.at(50, 50))
    };
    // The sun stands in the south: ground that falls to the south faces it.
    let (level, towards, away) = (shade(0.0, 0.0), shade(0.0, -0.5), shade(0.0, 0.5));
    assert!(towards > level + 30 && level > away + 30, "{towards} {level} {away}");
    let (east, west) = (shade(0.4, 0.0), shade(-0.4, 0.0));
    assert!((east - west).abs() <= 6, "{east} and {west}");
}

#[test]
fn north_is_up_and_east_is_right() {
    let height = field(40, 30, 10.0, |_, _| 5.0);
    let quadrants = Colors::from_fn(*height.grid(), Quantity::Color, |x, y| match (x < 195.0, y < 145.0) {
        (true, true) => [0.9, 0.05, 0.05],
        (false, true) => [0.05, 0.9, 0.05],
        (true, false) => [0.05, 0.05, 0.9],
        (false, false) => [0.9, 0.9, 0.05],
    });
    let picture = drawn(&Scene { color: Some(&quadrants), ..Scene::new(&height) }, Some(80));
    assert_eq!((picture.width, picture.height), (80, 60));
    let strong = |x, y| picture.at(x, y).map(|c| c > 128);
    assert_eq!(strong(10, 10), [true, false, false], "north-west");
    assert_eq!(strong(70, 10), [false, true, false], "north-east");
    assert_eq!(strong(10, 50), [false, false, true], "south-west");
    assert_eq!(strong(70, 50), [true, true, false], "south-east");
    // Looking north, the west is left and the north is far; looking south, all is turned.
    for (azimuth, near_left, far_right) in [
        (0.0, [false, false, true], [false, true, false]),
        (180.0, [false, true, false], [false, false, true]),
    ] {
        let camera = Camera { azimuth, pitch: 60.0, width: 160, height: 120, ..Camera::default() };
        let picture = seen(&Scene { color: Some(&quadrants), haze: 0.0, ..Scene::new(&height) }, &camera);
        let strong = |x, y| {
            let [r, g, b] = picture.at(x, y);
            let top = r.max(g).max(b);
            [r, g, b].map(|c| u32::from(c) * 3 > u32::from(top) * 2)
        };
        assert_eq!(strong(50, 80), near_left, "looking {azimuth}");
        assert_eq!(strong(110, 45), far_right, "looking {azimuth}");
    }
}

#[test]
fn water_is_blue_and_darker_where_it_is_deep() {
    // A beach that falls from 20 m in the west to -80 m in the east.
    let beach = field(201, 101, 10.0, |x, _| (20.0 - 0.05 * x) as f32);
    let picture = drawn(&Scene { sea_level: Some(0.0), ..Scene::new(&beach) }, None);
    let (shallow, deep, land) = (picture.at(60, 50), picture.at(190, 50), picture.at(10, 50));
    assert!(deep[2] > deep[0] + 40 && deep[2] > deep[1], "{deep:?}");
    assert!(light(shallow) > light(deep) + 40, "{shallow:?} {deep:?}");
    assert!(land[2] < land[1], "{land:?}");
    // The shore, at 400 m, is where the picture turns blue.
    let shore = (0..201).find(|&x| picture.at(x, 50)[2] > picture.at(x, 50)[0]).unwrap();
    assert!((38..=48).contains(&shore), "{shore}");
}

#[test]
fn a_cone_has_the_outline_that_geometry_gives() {
    const RADIUS: f64 = 1280.0;
    const TOP: f64 = 900.0;
    let cone = |x: f64, y: f64| {
        let (dx, dy) = (x - RADIUS, y - RADIUS);
        (TOP * (1.0 - (dx * dx + dy * dy).sqrt() / RADIUS)).max(0.0)
    };
    let height = field(257, 257, 10.0, |x, y| cone(x, y) as f32);
    let red = Colors::constant(*height.grid(), Quantity::Color, [1.0, 0.0, 0.0]);
    // Dim, so that bright red does not run to white.
    let scene = Scene { color: Some(&red), haze: 0.0, exposure: -2.0, ..clay(&height, 250.0, 50.0) };
    let (azimuth, distance, fov, size) = (30.0f64, 6000.0, 30.0f64, [400usize, 300usize]);
    let camera = Camera {
        azimuth,
        pitch: 0.0,
        field_of_view: fov,
        distance: Some(distance),
        look_at: Some([RADIUS, RADIUS, 450.0]),
        width: size[0],
        height: size[1],
        edge: Edge::Block,
    };
    let picture = seen(&scene, &camera);
    let (sin, cos) = (libm::sin(azimuth.to_radians()), libm::cos(azimuth.to_radians()));
    let eye = [RADIUS - distance * sin, RADIUS + distance * cos];
    let pixel = 2.0 * libm::tan(fov.to_radians() / 2.0) / size[0] as f64;
    let mut columns = 0;
    for column in 60..340 {
        // The steepest look up to the cone in the upright plane of this column, by brute force.
        let aside = (column as f64 + 0.5 - 200.0) * pixel;
        let steepest = (0..40_000).map(|n| {
            let depth = distance - 1300.0 + f64::from(n) * 0.065;
            let (x, y) = (eye[0] + depth * (sin + aside * cos), eye[1] + depth * (-cos + aside * sin));
            (cone(x, y) - 450.0) / depth
        });
        let steepest = steepest.fold(f64::NEG_INFINITY, f64::max);
        if steepest < -0.05 {
            continue;
        }
        let want = 150.0 - steepest / pixel;
        let found = (0..size[1]).find(|&row| {
            let [r, g, b] = picture.at(column, row).map(i32::from);
            2 * r > 3 * g && 2 * r > 3 * b
        });
        let found = found.unwrap_or(size[1]) as f64;
        assert!((found - want).abs() <= 1.5, "column {column}: outline at row {found}, not {want}");
        columns += 1;
    }
    assert!(columns > 150, "only {columns} columns were compared");
}

#[test]
fn the_whole_block_is_in_the_picture() {
    let height = hills(90, 50);
    let red = Colors::constant(*height.grid(), Quantity::Color, [1.0, 0.0, 0.0]);
    for (azimuth, pitch) in [(0.0, 30.0), (45.0, 10.0), (200.0, 89.0), (300.0, -2.0)] {
        let camera = Camera { azimuth, pitch, width: 200, height: 160, ..Camera::default() };
        let picture = seen(&Scene { color: Some(&red), haze: 0.0, ..clay(&height, 315.0, 45.0) }, &camera);
        let is_red = |x: usize, y: usize| {
            let [r, g, b] = picture.at(x, y).map(i32::from);
            r > 2 * g && r > 2 * b
        };
        let pixels = (0..160).flat_map(|y| (0..200).map(move |x| (x, y))).filter(|&(x, y)| is_red(x, y));
        let found: Vec<_> = pixels.collect();
        assert!(!found.is_empty(), "looking {azimuth}, {pitch} down");
        let border = |&(x, y): &(usize, usize)| x == 0 || y == 0 || x == 199 || y == 159;
        assert!(!found.iter().any(border), "looking {azimuth}, {pitch} down");
        if pitch > 0.0 {
            let wide = found.iter().map(|p| p.0).max().unwrap() - found.iter().map(|p| p.0).min().unwrap();
            let tall = found.iter().map(|p| p.1).max().unwrap() - found.iter().map(|p| p.1).min().unwrap();
            assert!(wide > 150 || tall > 120, "looking {azimuth}, {pitch} down: only {wide} x {tall}");
        }
    }
}

#[test]
fn contours_lie_at_their_heights() {
    // 1 m of height per cell: lines every 20 columns.
    let slope = field(201, 41, 10.0, |x, _| (x * 0.1) as f32);
    let plain = drawn(&clay(&slope, 315.0, 60.0), None);
    let lined = drawn(&Scene { contours: Some(20.0), ..clay(&slope, 315.0, 60.0) }, None);
    let darker = |x: usize| light(plain.at(x, 20)) - light(lined.at(x, 20));
    for x in 5..196 {
        let on_line = x % 20 == 0;
        let near = (x % 20).min(20 - x % 20) <= 2;
        assert!(!on_line || darker(x) > 40, "no line at column {x}: {}", darker(x));
        assert!(near || darker(x) == 0, "a line at column {x}");
    }
    assert!(darker(100) > darker(80) + 20, "the fifth line is not heavier");
}

#[test]
fn pictures_are_the_same_on_any_number_of_threads() {
    let height = hills(150, 110);
    let scene = Scene { sea_level: Some(-20.0), contours: Some(25.0), ..Scene::new(&height) };
    let block = Camera { width: 90, height: 60, ..Camera::default() };
    let haze = Camera { edge: Edge::Haze, pitch: 12.0, ..block };
    let all = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| [drawn(&scene, Some(100)), seen(&scene, &block), seen(&scene, &haze)])
    };
    let one = all(1);
    assert_eq!(one, all(2));
    assert_eq!(one, all(7));
    assert_ne!(one[1], one[2], "the two edges differ");
}

#[test]
fn odd_terrains_are_drawn_without_harm() {
    let odd = [
        ("smallest", field(2, 2, 1.0, |x, y| (x + y) as f32)),
        ("3 x 3", field(3, 3, 100.0, |x, y| (x * y * 0.01) as f32)),
        ("flat", field(20, 20, 10.0, |_, _| 7.0)),
        ("under water", field(20, 30, 10.0, |x, _| -50.0 - x as f32)),
        ("wide", field(300, 4, 10.0, |x, _| x as f32)),
        ("tall", field(4, 300, 10.0, |_, y| y as f32)),
        ("huge range", field(16, 16, 1e-3, |x, y| if x > y { f32::MAX } else { f32::MIN })),
        ("far off", field(16, 16, 1e6, |x, _| 1e7 + x as f32)),
        ("spike", field(33, 33, 10.0, |x, y| if x == 160.0 && y == 160.0 { 1e6 } else { 0.0 })),
    ];
    for (name, height) in &odd {
        for (sea_level, exaggeration, altitude) in
            [(None, 1.0, 35.0), (Some(0.0), 1000.0, 1.0), (Some(1e6), 0.01, 90.0), (Some(5.0), 1.0, 20.0)]
        {
            let sun = Sun { azimuth: 45.0, altitude };
            let scene = Scene { sea_level, exaggeration, sun, ..Scene::new(height) };
            let picture = drawn(&scene, Some(24));
            assert_eq!(picture.rgb.len(), picture.width * picture.height, "{name}");
            let camera = Camera { width: 16, height: 12, edge: Edge::Haze, pitch: 15.0, ..Camera::default() };
            assert_eq!(seen(&scene, &camera).rgb.len(), 16 * 12, "{name}");
            seen(&scene, &Camera { edge: Edge::Block, ..camera });
            seen(&scene, &Camera { pitch: -60.0, distance: Some(1.0), ..camera });
            seen(&scene, &Camera { look_at: Some([1e9, -1e9, 1e9]), ..camera });
        }
    }
}

#[test]
fn what_cannot_be_drawn_is_refused_by_name() {
    let cancel = Cancel::default();
    let watch = Work::new(&cancel);
    let good = hills(20, 20);
    let said = |scene: &Scene<'_>| map(scene, Some(10), &watch).unwrap_err().to_string();
    let line = Field::constant(Grid { rows: 1, ..*good.grid() }, Quantity::Elevation, 0.0);
    assert!(said(&Scene::new(&line)).contains("at least 2 x 2 samples"), "{}", said(&Scene::new(&line)));
    let mut data = good.data().to_vec();
    data[3 * 20 + 5] = f32::NAN;
    let broken = Field::new(*good.grid(), Quantity::Elevation, data);
    assert!(said(&Scene::new(&broken)).contains("column 5, row 3"));
    let small = Colors::constant(*line.grid(), Quantity::Color, [0.0; 3]);
    assert!(said(&Scene { color: Some(&small), ..Scene::new(&good) }).contains("`color` has 20 x 1 samples"));
    let scene = Scene { exaggeration: 0.0, ..Scene::new(&good) };
    assert!(said(&scene).contains("`exaggeration` must be from 0.01 to 1000, got 0"), "{}", said(&scene));
    let scene = Scene { sun: Sun { azimuth: f64::NAN, altitude: 30.0 }, ..Scene::new(&good) };
    assert!(said(&scene).contains("sun azimuth"));
    let scene = Scene { sun: Sun { azimuth: 0.0, altitude: -5.0 }, ..Scene::new(&good) };
    assert!(said(&scene).contains("sun altitude"));
    assert!(map(&Scene::new(&good), Some(0), &watch).unwrap_err().to_string().contains("`width`"));
    let camera = Camera { height: 100_000, ..Camera::default() };
    assert!(perspective(&Scene::new(&good), &camera, &watch).unwrap_err().to_string().contains("`height`"));
    let camera = Camera { field_of_view: 180.0, ..Camera::default() };
    assert!(
        perspective(&Scene::new(&good), &camera, &watch).unwrap_err().to_string().contains("field of view")
    );
}

#[test]
fn work_tells_how_far_it_is_and_stops() {
    let height = hills(120, 120);
    let camera = Camera { width: 64, height: 48, ..Camera::default() };
    let cancel = Cancel::default();
    let furthest = std::sync::Mutex::new(0.0f32);
    let tell = |share: f32| {
        assert!((0.0..=1.0001).contains(&share), "{share}");
        let mut furthest = furthest.lock().unwrap();
        *furthest = furthest.max(share);
    };
    perspective(&Scene::new(&height), &camera, &Work::new(&cancel).telling(&tell)).unwrap();
    assert!(*furthest.lock().unwrap() > 0.999);
    // Stopped halfway through.
    let stop = |share: f32| {
        if share > 0.5 {
            cancel.cancel();
        }
    };
    let stopped = perspective(&Scene::new(&height), &camera, &Work::new(&cancel).telling(&stop));
    assert!(matches!(stopped, Err(Error::Cancelled)), "{stopped:?}");
    assert!(matches!(map(&Scene::new(&height), None, &Work::new(&cancel)), Err(Error::Cancelled)));
}

#[test]
fn a_large_field_is_averaged_not_sampled() {
    // A fine checker of two colours becomes one colour; a sample of it would keep either.
    let height = field(401, 401, 1.0, |_, _| 0.0);
    let checker = Colors::from_fn(*height.grid(), Quantity::Color, |x, y| {
        if (x as i64 + y as i64) % 2 == 0 { [1.0; 3] } else { [0.0; 3] }
    });
    let picture = drawn(&Scene { color: Some(&checker), ..Scene::new(&height) }, Some(50));
    let lights: Vec<i32> = (5..45).map(|x| light(picture.at(x, 25))).collect();
    let spread = lights.iter().max().unwrap() - lights.iter().min().unwrap();
    assert!(spread <= 12, "{lights:?}");
}

#[test]
fn thumbnails_show_any_value() {
    let cancel = Cancel::default();
    let small = |value: &Value, side| thumbnail(value, side, &cancel).unwrap();
    let relief = small(&Value::Field(hills(200, 100)), 64);
    assert_eq!((relief.width, relief.height), (64, 32));
    let g = grid(3, 2, 1.0);
    let mask = Field::new(g, Quantity::Mask, vec![0.0, 0.5, 1.0, -1.0, 2.0, 0.25]);
    let picture = small(&Value::Field(mask), 64);
    let levels: Vec<u8> = picture.rgb.iter().map(|c| c[0]).collect();
    assert_eq!(levels, [0, 128, 255, 0, 255, 64]);
    let colors = Colors::constant(g, Quantity::Color, [0.2, 0.4, 0.6]);
    assert_eq!(small(&Value::Colors(colors), 64).rgb[0], [51, 102, 153]);
    let vectors = Vectors::constant(g, Quantity::Vector, [0.0, 2.0]);
    assert_eq!(small(&Value::Vectors(vectors), 64).rgb[0], [128, 255, 128]);
    let area = Field::new(g, Quantity::Area, vec![5.0, 6.0, 7.0, 8.0, 9.0, 1e6]);
    assert_ne!(small(&Value::Field(area.clone()), 64).rgb[0], small(&Value::Field(area), 64).rgb[5]);
    let north = Field::constant(g, Quantity::Direction, 360.0);
    let [r, green, b] = small(&Value::Field(north), 64).rgb[0];
    assert!(r > 200 && green < 100 && b < 100);
    assert!(thumbnail(&Value::Field(hills(20, 20)), 0, &cancel).is_err());
    let line = Field::constant(Grid { rows: 1, ..g }, Quantity::Elevation, 3.0);
    assert_eq!(small(&Value::Field(line), 64).rgb.len(), 3);
}

#[test]
fn every_palette_has_a_name() {
    for name in GroundPalette::names() {
        assert!(GroundPalette::named(name).is_some(), "{name}");
    }
    assert_eq!(GroundPalette::named("plaid"), None);
    assert_eq!((Edge::named("haze"), Edge::named("moat")), (Some(Edge::Haze), None));
}
