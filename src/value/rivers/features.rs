//! Rivers as lines of a file, and back.

use std::rc::Rc;

use serde_json::{Map, Value as Json};

use super::{RiverVertex, Rivers};
use crate::value::{Feature, SketchPoint};

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
    properties.insert("area".to_owned(), list(&|i| short(vertices[i].area)));
    properties.insert("width".to_owned(), list(&|i| short(vertices[i].width)));
    properties.insert("vertex".to_owned(), list(&|i| i.into()));
    let point = |&i: &usize| -> SketchPoint { (vertices[i].at, Some(vertices[i].height)) };
    Feature { line: way.iter().map(point).collect(), weight: vertices[mouth].order.into(), properties }
}

/// The shortest number that stands for one of single precision.
fn short(x: f32) -> Json {
    x.to_string().parse::<f64>().unwrap_or_else(|_| x.into()).into()
}
