//! Laws 2 to 4: a result on a window is cut from the whole, to the bit; more input than was asked for changes nothing;
//! point kinds are the same at every size; the edge of the terrain is none, and what is bounded continues its border.

use std::collections::BTreeMap;

use orograph::name::Name;
use orograph::node::{Kind, Reach, Reads};
use orograph::value::{Colors, Field, Grid, Quantity, Terrain, Value, Vectors, WireType};
use serde_json::Value as Json;

use crate::kinds::{registry, waves};
use crate::rig::bench::{Bench, clipped, poisoned};
use crate::rig::bytes::bytes;
use crate::rig::graph::{alone, carried, engine, fed_on, is_refusal};
use crate::rig::sets::{self, Set};
use crate::rig::{World, around, breadth, grid, part, shipped, windows};

/// What a kind is tried with: defaults on every terrain at every size, on all windows; other parameters at small sizes.
fn trials(kind: &Kind) -> Vec<(World, u32, Set, usize)> {
    let worlds = [World::Wide, World::Deep];
    let grids: Vec<_> = worlds.into_iter().flat_map(|w| w.sizes().into_iter().map(move |s| (w, s))).collect();
    let mut all = Vec::new();
    for (k, set) in part(sets::all(kind).into_iter().skip(1).collect(), 2, &kind.id).into_iter().enumerate() {
        match breadth() {
            true => all.extend(grids.iter().map(|(w, s)| (*w, *s, set.clone(), 1))),
            // Wide filters take other ways where there are many cells.
            false if k % 6 == 0 => all.push((World::Wide, 257, set, 4)),
            false => all.push([(World::Wide, 33, set.clone(), 4), (World::Deep, 73, set, 4)][k % 2].clone()),
        }
    }
    all.extend(grids.into_iter().map(|(w, s)| (w, s, sets::defaults(), 1)));
    all
}

/// Windows on which a result is not cut from the whole, looking at one in so many.
fn torn(kind: &Kind, world: World, size: u32, set: &Set, one_in: usize) -> Vec<String> {
    let g = fed_on(world, kind, set, None);
    let whole_grid = grid(g.terrain(), size);
    let label = format!("{} {} at {size}", kind.id, Json::from(set.clone()));
    let whole = match alone(&g, kind, around(&whole_grid)) {
        Ok(whole) => whole,
        Err(e) if is_refusal(&e) => return Vec::new(),
        Err(e) => return vec![format!("{label}: {e}")],
    };
    let differs = |window: Grid| match alone(&g, kind, window) {
        Ok(part) => differing(&part, &whole, &window).map(|port| format!("{label}: `{port}` on {window:?}")),
        Err(e) => Some(format!("{label} on {window:?}: {e}")),
    };
    windows(&whole_grid).into_iter().step_by(one_in).filter_map(differs).collect()
}

/// The first output that is not the crop of the whole.
fn differing<'a>(
    part: &'a BTreeMap<String, Value>,
    whole: &BTreeMap<String, Value>,
    window: &Grid,
) -> Option<&'a str> {
    let differs = |(port, value): &(&String, &Value)| bytes(value) != bytes(&whole[*port].crop(window));
    part.iter().find(differs).map(|(port, _)| port.as_str())
}

#[test]
fn tiles_of_every_kind_are_cut_from_the_whole_bit_for_bit() {
    let (mut bad, mut tried) = (Vec::new(), 0);
    for kind in shipped() {
        for (world, size, set, one_in) in trials(kind) {
            bad.extend(torn(kind, world, size, &set, one_in));
            tried += 1;
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(tried > 400, "{tried}");
}

#[test]
fn a_kind_that_looks_further_than_it_says_is_torn() {
    let registry = registry();
    for id in ["peeks", "frames"] {
        let found = torn(registry.find(id).unwrap(), World::Wide, 129, &sets::defaults(), 1);
        assert!(found.len() >= 3, "{id}: {found:?}");
    }
    assert_eq!(torn(registry.find("smooth").unwrap(), World::Wide, 129, &sets::defaults(), 1), [""; 0]);
}

/// What a node gives from exactly what it asks for, and not from larger windows, where the rest is poison.
fn greedy(kind: &Kind, set: &Set, size: u32) -> Option<String> {
    let g = fed_on(World::Wide, kind, set, None);
    let bench = Bench::in_graph(&g, kind).ok()?;
    let (terrain, e) = (g.terrain(), engine(2));
    let source = carried(&g, &e);
    let whole = grid(terrain, size);
    let at =
        Grid { col: whole.cols as i64 / 3, row: -2, cols: whole.cols / 4, rows: whole.rows / 3, ..whole };
    let exact = bench.given(terrain, at, &source, &|window| window);
    let mut wider = bench.given(terrain, at, &source, &|window| window.grow_cells(13));
    wider.wires = (wider.wires.iter())
        .map(|(p, v)| {
            let on = exact.wires.get(p).and_then(Value::grid);
            (p.clone(), on.map_or(v.clone(), |g| poisoned(v.clone(), g)))
        })
        .collect();
    let pairs = wider.views.iter().zip(&exact.views);
    wider.views = pairs
        .map(|((p, v), (_, e))| (p.clone(), e.grid().map_or(v.clone(), |g| poisoned(v.clone(), g))))
        .collect();
    let run = |given| bench.start(terrain, given, &Default::default());
    let differs = match (run(&exact), run(&wider)) {
        (Ok(a), Ok(b)) => a.iter().any(|(p, v)| b.get(p).is_none_or(|other| bytes(other) != bytes(v))),
        (a, b) => a.err() != b.err(),
    };
    differs.then(|| format!("{} {} at {size}", kind.id, Json::from(set.clone())))
}

fn is_near(kind: &Kind, set: &Set) -> bool {
    let reach = kind.parse(set).map(|node| node.reach());
    matches!(reach, Ok(Reach::Point | Reach::Local(_))) && kind.family != "files"
}

#[test]
fn a_larger_input_than_was_asked_for_gives_the_same() {
    let (mut bad, mut tried) = (Vec::new(), 0);
    for kind in shipped() {
        for set in part(sets::all(kind), 2, &kind.id).iter().filter(|set| is_near(kind, set)) {
            bad.extend([33, 129].into_iter().filter_map(|size| greedy(kind, set, size)));
            tried += 1;
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(tried > 150, "{tried}");
}

#[test]
fn a_kind_that_hangs_on_how_much_it_is_given_is_found() {
    let registry = registry();
    assert!(greedy(registry.find("weighs").unwrap(), &sets::defaults(), 129).is_some());
    assert_eq!(greedy(registry.find("smooth").unwrap(), &sets::defaults(), 129), None);
}

/// Samples of a point kind that are not those of a grid so many times as fine.
fn sizes_differ(kind: &Kind, set: &Set) -> Option<String> {
    let g = fed_on(World::Wide, kind, set, None);
    let at = |size| alone(&g, kind, grid(g.terrain(), size));
    let Ok(coarse) = at(33) else { return None };
    [2usize, 3].into_iter().find_map(|k| {
        let fine = at(32 * k as u32 + 1).ok()?;
        let differs = |(port, value): (&String, &Value)| bytes(value) != thinned(&fine[port], k);
        let port = coarse.iter().find(|(p, v)| differs((p, v)))?.0;
        Some(format!("{} {}: `{port}` {k} times as fine", kind.id, Json::from(set.clone())))
    })
}

/// The bytes of every `step`-th sample of a raster.
fn thinned(value: &Value, step: usize) -> Vec<u8> {
    let (grid, parts) = (*value.grid().unwrap(), value.wire_type().channels());
    let rows = value.components().chunks(grid.cols * parts).step_by(step);
    rows.flat_map(|row| row.chunks(parts).step_by(step).flatten())
        .flat_map(|v| v.to_bits().to_le_bytes())
        .collect()
}

#[test]
fn point_kinds_are_equal_to_the_bit_at_every_size() {
    let (mut bad, mut tried) = (Vec::new(), 0);
    let is_point = |kind: &Kind, set: &Set| kind.parse(set).is_ok_and(|n| n.reach() == Reach::Point);
    for kind in shipped() {
        let sets: Vec<_> = sets::all(kind).into_iter().filter(|set| is_point(kind, set)).collect();
        tried += usize::from(!sets.is_empty());
        bad.extend(part(sets, 2, &kind.id).iter().filter_map(|set| sizes_differ(kind, set)));
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(tried >= 10, "{tried}");
    assert!(sizes_differ(registry().find("cells").unwrap(), &sets::defaults()).is_some(), "a lie is found");
}

/// Busy values of every type on the whole plane.
fn plane(kind: &Kind) -> impl Fn(&str, &Grid) -> Option<Value> + Sync {
    let wires: BTreeMap<String, WireType> =
        kind.inputs.iter().map(|p| (p.name.to_string(), p.wire)).collect();
    move |port, g| {
        let at = |x: f64, y: f64, seed: u64| 0.3 * waves(x, y, 700.0, seed);
        Some(match wires.get(port)? {
            WireType::Field if matches!(port, "mask" | "amount" | "roughness" | "shade" | "below") => {
                Value::Field(Field::from_fn(*g, Quantity::Mask, |x, y| (0.5 + at(x, y, 3)).clamp(0.0, 1.0)))
            }
            WireType::Field => {
                Value::Field(Field::from_fn(*g, Quantity::Elevation, |x, y| 300.0 * at(x, y, 1)))
            }
            WireType::Vectors => {
                Value::Vectors(Vectors::from_fn(*g, Quantity::Vector, |x, y| [at(x, y, 2), at(x, y, 4)]))
            }
            WireType::Colors => Value::Colors(Colors::from_fn(*g, Quantity::Color, |x, y| {
                [at(x, y, 2), at(x, y, 4), at(x, y, 5)].map(|v| v.clamp(0.0, 1.0))
            })),
            WireType::Object(_) => return None,
        })
    }
}

/// Whether a kind gives another result across the border of a terrain than in the middle of a larger one: none where it
/// says that it reads the terrain, or looks further than the apron.
fn sees_the_edge(kind: &Kind, set: &Set, size: u32) -> Option<bool> {
    let bench = Bench::set(kind, set).ok()?;
    if kind.reads.has(Reads::TERRAIN) || bench.node.needs_summary() || !is_near(kind, set) {
        return None;
    }
    let small = Terrain { width: 4096.0, depth: 2048.0, base: 65, ..Terrain::default() };
    let large = Terrain { width: 8192.0, depth: 4096.0, base: 129, ..Terrain::default() };
    let on = |terrain: &Terrain, size: u32| {
        let whole = grid(terrain, size);
        let n = i64::from(size) - 1;
        Grid::between(whole.lattice, [n - n / 8, n / 2 - n / 8], [n + n / 8, n / 2 + n / 8])
    };
    let at = on(&small, size);
    let fits = |window: Grid| clipped(&window, &small) == window;
    let asks = |port: &Name| {
        let views = bench.node.views(port, &at, &small).into_iter();
        views.chain([bench.node.footprint(port, &at, &small)]).all(fits)
    };
    if !bench.ports.iter().all(asks) {
        return None;
    }
    let source = plane(kind);
    // The same cells on a terrain twice as large.
    let twice = Grid { lattice: grid(&large, 2 * size - 1).lattice, ..at };
    let a = bench.run(&small, at, &source).ok()?;
    let b = bench.run(&large, twice, &source).ok()?;
    Some(a.iter().any(|(p, v)| b.get(p).is_none_or(|other| bytes(other) != bytes(v))))
}

#[test]
fn the_edge_of_the_terrain_is_none_for_kinds_that_do_not_read_it() {
    let (mut bad, mut tried) = (Vec::new(), 0);
    for kind in shipped() {
        let mut looked = false;
        for set in sets::all(kind) {
            let seen = sees_the_edge(kind, &set, 65);
            looked |= seen.is_some();
            if seen == Some(true) {
                bad.push(format!("{} {}", kind.id, Json::from(set)));
            }
        }
        tried += usize::from(looked);
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(tried >= 20, "{tried} kinds");
    let registry = registry();
    let lie = |id| sees_the_edge(registry.find(id).unwrap(), &sets::defaults(), 65);
    assert_eq!((lie("edgy"), lie("smooth")), (Some(true), Some(false)));
}

/// Outputs of a global kind that do not continue their border value around the terrain.
fn unbounded(kind: &Kind, set: &Set) -> Vec<String> {
    let g = fed_on(World::Wide, kind, set, None);
    let whole = g.terrain().base_grid();
    let Ok(all) = alone(&g, kind, around(&whole)) else { return Vec::new() };
    let carried = |port: &str| kind.carries.iter().any(|(output, _)| *output == port);
    let bad = all.iter().filter(|(port, value)| !carried(port) && !goes_on(value, &whole));
    bad.map(|(port, _)| format!("{} {}: `{port}`", kind.id, Json::from(set.clone()))).collect()
}

/// Whether a value around a window is that of the window's border, but for the rounding of what is interpolated.
fn goes_on(value: &Value, inner: &Grid) -> bool {
    let Some(grid) = value.grid() else { return true };
    let (continued, all) = (value.crop(inner).crop(grid), value.components());
    let (lo, hi) = all.iter().fold((f32::MAX, f32::MIN), |(lo, hi), x| (lo.min(*x), hi.max(*x)));
    let near = |(a, b): (&f32, &f32)| (a - b).abs() <= 1e-5 * (hi - lo).max(lo.abs().max(hi.abs()));
    all.iter().zip(continued.components()).all(near)
}

#[test]
fn what_is_made_on_the_base_grid_continues_its_border() {
    let is_global = |kind: &Kind, set: &Set| kind.parse(set).is_ok_and(|n| n.reach() == Reach::Global);
    let (mut bad, mut tried) = (Vec::new(), 0);
    for kind in shipped() {
        for set in sets::all(kind).iter().filter(|set| is_global(kind, set)) {
            bad.extend(unbounded(kind, set));
            tried += 1;
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
    assert!(tried >= 10, "{tried}");
    let registry = registry();
    assert_eq!(unbounded(registry.find("spread").unwrap(), &sets::defaults()), [""; 0]);
    assert!(!unbounded(registry.find("waves").unwrap(), &sets::defaults()).is_empty(), "waves go on and on");
}
