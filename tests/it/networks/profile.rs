//! Heights of beds against a plain search for the highest that is allowed.

use orograph::kit::delaunay::Delaunay;
use orograph::kit::rivers::branching::Branching;
use orograph::kit::rivers::drainage;
use orograph::kit::rivers::infill::Infill;
use orograph::kit::rivers::profile::{LEAST_FALL, Rise, limit_sides, rise};
use orograph::value::{Bounds, RiverVertex};
use orograph::work::Work;

use super::{LINE, SQUARE, grow, growth, rivers};

/// A filled network with areas.
fn network(seed: u64) -> Vec<RiverVertex> {
    let rivers = rivers(&grow(&growth(Branching::Generator(2), 5, seed), &[LINE]));
    let infill = Infill { bounds: SQUARE, spacing: 900.0, rim: 0.03, seed };
    let mut filled = infill.fill(rivers.vertices(), &Work::default()).unwrap().vertices;
    drainage::drain(&mut filled, infill.filled_bounds(), 2.5, &Work::default()).unwrap();
    filled
}

fn distance(a: &RiverVertex, b: &RiverVertex) -> f64 {
    libm::hypot(a.at[0] - b.at[0], a.at[1] - b.at[1])
}

/// The least fall of a bed along its links.
fn least_fall(vertices: &[RiverVertex]) -> f64 {
    let slope = |vertex: &RiverVertex| {
        let down = &vertices[vertex.down? as usize];
        Some((vertex.height - down.height) / distance(vertex, down))
    };
    vertices.iter().filter_map(slope).fold(f64::INFINITY, f64::min)
}

#[test]
fn even_beds_rise_by_their_slope_from_the_outlet() {
    let mut vertices = network(1);
    let outlets: Vec<f64> = vertices.iter().filter(|v| v.down.is_none()).map(|v| v.height).collect();
    rise(&mut vertices, Rise::Even(0.03));
    for vertex in &vertices {
        if let Some(down) = vertex.down {
            let down = &vertices[down as usize];
            let slope = (vertex.height - down.height) / distance(vertex, down);
            assert!((slope - 0.03).abs() < 1e-6, "{slope}");
        }
    }
    let kept: Vec<f64> = vertices.iter().filter(|v| v.down.is_none()).map(|v| v.height).collect();
    assert_eq!(kept, outlets);
}

#[test]
fn concave_beds_have_their_relief_and_the_slope_of_their_area() {
    let mut vertices = network(2);
    rise(&mut vertices, Rise::Concave { concavity: 0.5, relief: 1200.0 });
    let mut over: Vec<f64> = Vec::new();
    for vertex in &vertices {
        let below = vertex
            .down
            .map_or(0.0, |down| over[down as usize] + vertex.height - vertices[down as usize].height);
        over.push(below);
    }
    over.sort_by(f64::total_cmp);
    let high = over[(0.99 * (over.len() - 1) as f64) as usize];
    assert!((high - 1200.0).abs() < 1.0, "{high} m");
    // Four times the area, half the slope.
    let slope = |vertex: &RiverVertex| {
        let down = &vertices[vertex.down? as usize];
        Some((f64::from(vertex.area), (vertex.height - down.height) / distance(vertex, down)))
    };
    let mut slopes: Vec<(f64, f64)> =
        vertices.iter().filter_map(slope).filter(|(area, _)| *area > 1e7).collect();
    slopes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (first, last) = (slopes[0], slopes[slopes.len() - 1]);
    let exponent = libm::log(last.1 / first.1) / libm::log(last.0 / first.0);
    assert!((exponent + 0.5).abs() < 1e-3, "{exponent}");
}

#[test]
fn limited_sides_are_the_highest_that_demands_allow() {
    let steepest = 0.25;
    let mut vertices = network(3);
    rise(&mut vertices, Rise::Even(0.08));
    let before = vertices.clone();
    limit_sides(&mut vertices, steepest, &Work::default()).unwrap();
    // The same by passing over all demands until none changes a height.
    let sites: Vec<[f64; 2]> = before.iter().map(|vertex| vertex.at).collect();
    let net =
        Delaunay::new(&sites, Bounds::around(sites.iter().copied()).unwrap(), &Work::default()).unwrap();
    let mut demands: Vec<(usize, usize, f64)> = Vec::new();
    for edge in net.edges() {
        let ends = [net.origin(edge), net.end(edge)];
        if ends.iter().all(|&end| net.is_site(end)) {
            let [a, b] = ends.map(|end| end as usize);
            let over = steepest * distance(&before[a], &before[b]);
            demands.extend([(a, b, over), (b, a, over)]);
        }
    }
    for (i, vertex) in before.iter().enumerate() {
        if let Some(down) = vertex.down.map(|down| down as usize) {
            let length = distance(vertex, &before[down]);
            demands.extend([(i, down, steepest * length), (down, i, -LEAST_FALL * length)]);
        }
    }
    let mut heights: Vec<f64> = before.iter().map(|vertex| vertex.height).collect();
    loop {
        let old = heights.clone();
        for &(upper, lower, over) in &demands {
            heights[upper] = heights[upper].min(heights[lower] + over);
        }
        if old == heights {
            break;
        }
    }
    let lowered = before.iter().zip(&vertices).filter(|(a, b)| b.height < a.height - 1.0).count();
    assert!(lowered > 20, "the test has nothing to do: {lowered}");
    for (i, (vertex, want)) in vertices.iter().zip(&heights).enumerate() {
        assert!((vertex.height - want).abs() < 1e-6, "vertex {i}: {}, not {want}", vertex.height);
    }
    assert!(least_fall(&vertices) > 0.999 * LEAST_FALL, "{}", least_fall(&vertices));
}

#[test]
fn profiles_of_lone_and_coincident_vertices_are_finite() {
    let at = |x: f64, down| RiverVertex { at: [x, 0.0], down, ..RiverVertex::default() };
    for mut vertices in [
        vec![],
        vec![at(0.0, None)],
        vec![at(0.0, None), at(0.0, Some(0)), at(5.0, Some(1)), at(5.0, Some(1))],
    ] {
        for kind in [Rise::Even(0.1), Rise::Concave { concavity: 1.0, relief: 100.0 }] {
            rise(&mut vertices, kind);
            limit_sides(&mut vertices, 0.5, &Work::default()).unwrap();
            assert!(vertices.iter().all(|vertex| vertex.height.is_finite()));
        }
    }
}
