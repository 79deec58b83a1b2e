//! The course of wires on the canvas, and the distance from them.

use eframe::egui::epaint::CubicBezierShape;
use eframe::egui::{Color32, Pos2, Shape, Stroke, Vec2, vec2};

use super::camera::Viewport;
use super::layout::{Layout, place};
use crate::graph::{Graph, NodeId, Source};
use crate::name::Name;
use crate::value::WireType;

/// A wire between two nodes, on the canvas.
#[derive(Clone, Debug)]
pub(crate) struct Course {
    pub(crate) source: Source,
    pub(crate) to: NodeId,
    pub(crate) input: Name,
    pub(crate) wire: WireType,
    /// The points from the source through the bends to the input.
    pub(crate) points: Vec<Pos2>,
}

/// The courses of the wires into a node.
pub(crate) fn courses<'a>(
    graph: &Graph,
    id: NodeId,
    layout: impl Fn(NodeId) -> Option<&'a Layout>,
) -> Vec<Course> {
    let Some(own) = layout(id) else { return Vec::new() };
    let course = |(input, source): (&Name, Source)| {
        let from = layout(source.node)?.output(&source.port)?;
        let bends = graph.bends(id, input).iter().map(|at| place(*at));
        let points = [from].into_iter().chain(bends).chain([own.input(input)?]).collect();
        Some(Course { wire: graph.wire_type(&source)?, source, to: id, input: input.clone(), points })
    };
    graph.inputs(id).filter_map(course).collect()
}

/// The direction of a wire at each of its points.
fn tangents(points: &[Pos2]) -> Vec<Vec2> {
    let last = points.len() - 1;
    let reach = |a: Pos2, b: Pos2| {
        let d = b - a;
        (0.45 * d.x.abs() + 0.15 * d.y.abs()).clamp(18.0, 220.0)
    };
    (0..points.len())
        .map(|i| match i {
            0 => vec2(reach(points[0], points[1]), 0.0),
            _ if i == last => vec2(reach(points[last - 1], points[last]), 0.0),
            _ => (points[i + 1] - points[i - 1]) * 0.25,
        })
        .collect()
}

/// The control points of the Bézier pieces of a wire.
pub(crate) fn pieces(points: &[Pos2]) -> Vec<[Pos2; 4]> {
    if points.len() < 2 {
        return Vec::new();
    }
    let t = tangents(points);
    let piece = |i: usize| [points[i], points[i] + t[i], points[i + 1] - t[i + 1], points[i + 1]];
    (0..points.len() - 1).map(piece).collect()
}

/// The shapes of a wire on the screen.
pub(crate) fn shapes(points: &[Pos2], view: &Viewport, stroke: Stroke) -> impl Iterator<Item = Shape> {
    let view = *view;
    pieces(points).into_iter().map(move |piece| {
        let points = piece.map(|p| view.pos(p));
        CubicBezierShape::from_points_stroke(points, false, Color32::TRANSPARENT, stroke).into()
    })
}

/// Number of straight steps into which a piece is divided to measure distances.
const STEPS: usize = 24;

/// The distance of a wire from a place, and the index of the nearest piece.
pub(crate) fn nearest(points: &[Pos2], to: Pos2) -> Option<(f32, usize)> {
    let near = |(k, [a, b, c, d]): (usize, [Pos2; 4])| {
        let at = |t: f32| {
            let s = 1.0 - t;
            let sum = a.to_vec2() * (s * s * s)
                + b.to_vec2() * (3.0 * s * s * t)
                + c.to_vec2() * (3.0 * s * t * t)
                + d.to_vec2() * (t * t * t);
            sum.to_pos2()
        };
        let place = |i: usize| at(i as f32 / STEPS as f32);
        let away = (0..STEPS).map(|i| from_segment(place(i), place(i + 1), to));
        (away.fold(f32::INFINITY, f32::min), k)
    };
    pieces(points).into_iter().enumerate().map(near).min_by(|a, b| a.0.total_cmp(&b.0))
}

fn from_segment(a: Pos2, b: Pos2, p: Pos2) -> f32 {
    let d = b - a;
    let t = if d.length_sq() > 0.0 { ((p - a).dot(d) / d.length_sq()).clamp(0.0, 1.0) } else { 0.0 };
    (a + d * t).distance(p)
}

#[cfg(test)]
mod tests {
    use eframe::egui::pos2;

    use super::*;

    #[test]
    fn wires_go_through_their_bends() {
        let points = [pos2(0.0, 0.0), pos2(100.0, 80.0), pos2(300.0, 10.0)];
        for (k, p) in points.iter().enumerate() {
            let (away, piece) = nearest(&points, *p).expect("a wire");
            assert!(away < 1e-3, "{k}: {away}");
            assert!(piece + 1 >= k);
        }
        let (away, piece) = nearest(&points, pos2(200.0, 400.0)).expect("a wire");
        assert!(away > 250.0 && piece <= 1);
    }
}
