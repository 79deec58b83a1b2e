//! River networks as values on wires.

use rayon::prelude::*;

use super::{GUESSED_VERTICES, RiverVertex, Rivers};
use crate::value::{Features, Object, ObjectType, Pin, Sketch, SketchLine, SketchPoint, Value};

/// Most points of a sketch. A network of more shows its larger rivers.
const MAX_SKETCH: usize = 100_000;
/// Bytes of a vertex in a file of the cache: x, y, height, the vertex downstream, area, width.
const RECORD: usize = 36;
/// The vertex downstream of an outlet, in a file.
const NONE: u32 = u32::MAX;

impl Object for Rivers {
    const TYPE: &'static ObjectType = &ObjectType {
        name: "rivers",
        color: [0, 114, 178],
        pin: Pin::Polygon { corners: 3, turn: 0.5 },
        sample_bytes: 0,
        guessed_bytes: (GUESSED_VERTICES * size_of::<RiverVertex>()) as u64,
        load: Some(load),
        has_features: true,
    };

    fn bytes(&self) -> u64 {
        size_of_val(self.vertices()) as u64
    }

    /// Networks are valid, whoever made them.
    fn fault(&self) -> Option<String> {
        None
    }

    fn sketch(&self) -> Sketch {
        Sketch::Lines(self.rivers_of_size(MAX_SKETCH))
    }

    fn say(&self, at: [f64; 2]) -> Option<String> {
        let river = &self.vertices()[self.nearest(at)?];
        let [square_kilometres, kilometres] = [f64::from(river.area) * 1e-6, f64::from(river.length) * 1e-3];
        Some(format!(
            "nearest river: order {}, bed {:.1} m, width {:.1} m, drains {square_kilometres:.3} km², {kilometres:.2} km to the outlet",
            river.order, river.height, river.width
        ))
    }

    fn save(&self) -> Vec<u8> {
        self.vertices().iter().flat_map(record).collect()
    }

    fn features(&self) -> Features<'_> {
        Box::new(self.lines())
    }
}

impl Rivers {
    /// The vertex nearest to a place.
    fn nearest(&self, at: [f64; 2]) -> Option<usize> {
        let distance = |vertex: &RiverVertex| {
            let [x, y] = [0, 1].map(|i| vertex.at[i] - at[i]);
            x * x + y * y
        };
        let all = self.vertices().par_iter().enumerate().map(|(i, vertex)| (distance(vertex), i));
        all.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, i)| i)
    }

    /// Its rivers as lines from their mouths up, as many of the largest as have so many points together. A tributary
    /// starts at the vertex that it joins.
    fn rivers_of_size(&self, most: usize) -> Vec<SketchLine> {
        let vertices = self.vertices();
        let least = least_order(vertices.iter().map(|vertex| vertex.order), most);
        let drawn = vertices.iter().filter(|vertex| vertex.order >= least).count();
        let stride = drawn.div_ceil(most.max(1)).max(1);
        let tributaries = self.tributaries();
        let is_drawn = |i: &usize| vertices[*i].order >= least;
        let main = |i: usize| tributaries.main(i, vertices).filter(is_drawn);
        let starts_river = |i: usize| vertices[i].down.is_none_or(|down| main(down as usize) != Some(i));
        let point = |i: usize| -> SketchPoint { (vertices[i].at, Some(vertices[i].height)) };
        let river = |mouth: usize| -> SketchLine {
            let way: Vec<usize> = std::iter::successors(Some(mouth), |&i| main(i)).collect();
            let last = way.len() - 1;
            let kept = way.into_iter().enumerate().filter(|(k, _)| k % stride == 0 || *k == last);
            self.down(mouth).into_iter().chain(kept.map(|(_, i)| i)).map(point).collect()
        };
        let mouths = (0..vertices.len()).filter(|&i| vertices[i].order >= least && starts_river(i));
        mouths.map(river).filter(|line| line.len() > 1).collect()
    }
}

/// The least order such that at most so many have it or a higher one, but no order that leaves nothing.
pub(in crate::value) fn least_order(orders: impl Iterator<Item = u8>, most: usize) -> u8 {
    let mut counts = [0_usize; 256];
    for order in orders {
        counts[usize::from(order)] += 1;
    }
    let highest = counts.iter().rposition(|&n| n > 0).unwrap_or(0);
    let mut sum = 0;
    let fits = (0..=highest).rev().take_while(|&order| {
        sum += counts[order];
        sum <= most
    });
    fits.last().unwrap_or(highest) as u8
}

fn record(vertex: &RiverVertex) -> [u8; RECORD] {
    let mut bytes = [0; RECORD];
    let doubles = [vertex.at[0], vertex.at[1], vertex.height];
    for (slot, x) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(doubles) {
        *slot = x.to_le_bytes();
    }
    let words = [vertex.down.unwrap_or(NONE), vertex.area.to_bits(), vertex.width.to_bits()];
    for (slot, x) in bytes[24..].as_chunks_mut::<4>().0.iter_mut().zip(words) {
        *slot = x.to_le_bytes();
    }
    bytes
}

fn load(bytes: &[u8]) -> Option<Value> {
    let (records, rest) = bytes.as_chunks::<RECORD>();
    if !rest.is_empty() {
        return None;
    }
    Some(Rivers::new(records.iter().map(vertex).collect()).ok()?.into())
}

fn vertex(record: &[u8; RECORD]) -> RiverVertex {
    let (doubles, words) = record.split_at(24);
    let double = |i: usize| f64::from_le_bytes(doubles.as_chunks::<8>().0[i]);
    let word = |i: usize| u32::from_le_bytes(words.as_chunks::<4>().0[i]);
    RiverVertex {
        at: [double(0), double(1)],
        height: double(2),
        down: Some(word(0)).filter(|&down| down != NONE),
        area: f32::from_bits(word(1)),
        width: f32::from_bits(word(2)),
        ..RiverVertex::default()
    }
}
