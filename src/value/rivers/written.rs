//! Networks in files of lines: rivers from source to mouth, and the network back from them.

use std::rc::Rc;

use serde_json::{Map, Value as Json};

use super::{MAX_VERTICES, RiverVertex, Rivers};
use crate::value::{Feature, SketchPoint};

/// The property with the numbers of the vertices of a river.
pub const VERTEX: &str = "vertex";
/// The property with the areas that drain through them, in square metres.
pub const AREA: &str = "area";
/// The property with their widths, in metres.
pub const WIDTH: &str = "width";
/// The properties of which a network is made again.
pub const NAMES: [&str; 3] = [VERTEX, AREA, WIDTH];

/// A river of a file, from its source to the vertex that it joins, or to its outlet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WrittenRiver<'a> {
    /// Its positions, in metres, x east and y south.
    pub at: Vec<[f64; 2]>,
    /// Their heights, in metres; none where the file has none.
    pub heights: Vec<f64>,
    /// The property [`VERTEX`].
    pub numbers: &'a [f64],
    /// The property [`AREA`].
    pub areas: &'a [f64],
    /// The property [`WIDTH`].
    pub widths: &'a [f64],
}

/// The vertices of a network that was written as such rivers; nothing where the properties are not there or do not fit
/// together, as in a file that was changed or never was one of ours.
pub fn network<'a>(rivers: impl IntoIterator<Item = WrittenRiver<'a>>) -> Option<Vec<RiverVertex>> {
    let mut found: Vec<Option<RiverVertex>> = Vec::new();
    for river in rivers {
        let count = river.at.len();
        let lists = [river.numbers, river.areas, river.widths];
        if lists.iter().any(|list| list.len() != count) || ![0, count].contains(&river.heights.len()) {
            return None;
        }
        let numbers = river.numbers.iter().map(|&x| number(x)).collect::<Option<Vec<usize>>>()?;
        let most = numbers.iter().max().map_or(0, |&most| most + 1);
        if most > found.len() {
            found.resize(most, None);
        }
        for (k, &i) in numbers.iter().enumerate() {
            let vertex = RiverVertex {
                at: river.at[k],
                height: river.heights.get(k).copied().unwrap_or(0.0),
                down: numbers.get(k + 1).map(|&down| down as u32),
                area: river.areas[k] as f32,
                width: river.widths[k] as f32,
                ..RiverVertex::default()
            };
            let known = found[i].get_or_insert(vertex);
            // Where a river joins another both name the vertex.
            if known.at != vertex.at
                || (known.down.is_some() && vertex.down.is_some_and(|d| known.down != Some(d)))
            {
                return None;
            }
            known.down = known.down.or(vertex.down);
        }
    }
    let vertices: Vec<RiverVertex> = found.into_iter().collect::<Option<_>>()?;
    let flows = vertices.iter().enumerate().all(|(i, v)| v.down.is_none_or(|down| (down as usize) < i));
    (flows && !vertices.is_empty()).then_some(vertices)
}

/// The number of a vertex.
fn number(x: f64) -> Option<usize> {
    (x >= 0.0 && x < MAX_VERTICES as f64 && x.fract() == 0.0).then_some(x as usize)
}

impl Rivers {
    /// Its rivers from source to mouth, the largest tributary of each vertex being its river, and on to the vertex that
    /// they join. `vertex` has the numbers of the vertices, so that a reader can put the network together again; `area`
    /// and `width` have a value for each of them.
    pub(super) fn lines(&self) -> impl Iterator<Item = Feature> + '_ {
        let vertices = self.vertices();
        let tributaries = Rc::new(self.tributaries());
        let main = move |i: usize| tributaries.main(i, vertices);
        let mouths = (0..vertices.len()).filter({
            let main = main.clone();
            move |&i| vertices[i].down.is_none_or(|down| main(down as usize) != Some(i))
        });
        mouths.filter_map(move |mouth| {
            let mut way: Vec<usize> = self.down(mouth).into_iter().collect();
            way.extend(std::iter::successors(Some(mouth), |&i| main(i)));
            way.reverse();
            (way.len() > 1).then(|| feature(vertices, &way, mouth))
        })
    }
}

fn feature(vertices: &[RiverVertex], way: &[usize], mouth: usize) -> Feature {
    let list = |of: &dyn Fn(usize) -> Json| Json::Array(way.iter().map(|&i| of(i)).collect());
    let mut properties = Map::new();
    properties.insert("order".to_owned(), vertices[mouth].order.into());
    properties.insert(AREA.to_owned(), list(&|i| short(vertices[i].area)));
    properties.insert(WIDTH.to_owned(), list(&|i| short(vertices[i].width)));
    properties.insert(VERTEX.to_owned(), list(&|i| i.into()));
    let point = |&i: &usize| -> SketchPoint { (vertices[i].at, Some(vertices[i].height)) };
    Feature { line: way.iter().map(point).collect(), weight: vertices[mouth].order.into(), properties }
}

/// The shortest number that stands for one of single precision.
fn short(x: f32) -> Json {
    x.to_string().parse::<f64>().unwrap_or_else(|_| x.into()).into()
}
