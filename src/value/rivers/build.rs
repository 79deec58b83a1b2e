//! Vertices become a network: they are checked, sorted where asked, and what follows from them is derived.

use super::{MAX_VERTICES, RiverVertex, Rivers};
use crate::value::curves::{MAX_COORDINATE, MAX_HEIGHT};

/// Why vertices are no river network.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RiverFault {
    /// There are more than this program takes.
    #[error("at most {MAX_VERTICES} river vertices, got {0}")]
    TooMany(usize),
    /// A number of a vertex is not finite or out of range.
    #[error("river vertex {vertex}: `{what}` must be from {least} to {most}, got {found}")]
    Number {
        /// The vertex.
        vertex: usize,
        /// Which of its numbers.
        what: &'static str,
        /// The least allowed.
        least: f64,
        /// The most allowed.
        most: f64,
        /// What it is.
        found: f64,
    },
    /// A vertex drains to one that does not stand before it.
    #[error("river vertex {vertex} must drain to one before it, got {down}")]
    Order {
        /// The vertex.
        vertex: usize,
        /// The one downstream.
        down: u32,
    },
    /// A vertex drains to one that is not there.
    #[error("river vertex {vertex} drains to vertex {down}, of {count}")]
    Missing {
        /// The vertex.
        vertex: usize,
        /// The one downstream.
        down: u32,
        /// Number of vertices.
        count: usize,
    },
    /// Water runs in a circle.
    #[error("river vertex {0} drains to itself over others")]
    Circle(usize),
}

impl Rivers {
    /// A network of vertices that stand downstream first. `length` and `order` are derived, whatever they were.
    ///
    /// # Errors
    /// Names the first vertex with a number that is not finite or out of range, or one that drains to a vertex after it;
    /// and refuses more than [`MAX_VERTICES`].
    pub fn new(mut vertices: Vec<RiverVertex>) -> Result<Self, RiverFault> {
        if vertices.len() > MAX_VERTICES {
            return Err(RiverFault::TooMany(vertices.len()));
        }
        for (vertex, of) in vertices.iter().enumerate() {
            check_numbers(vertex, of)?;
            if let Some(down) = of.down.filter(|&down| down as usize >= vertex) {
                return Err(RiverFault::Order { vertex, down });
            }
        }
        derive_lengths(&mut vertices);
        derive_orders(&mut vertices);
        Ok(Self(vertices.into()))
    }

    /// A network of vertices in any order. They are sorted downstream first: each outlet in the given order with all that
    /// drains to it, river after river. Also returned: the given number of each vertex.
    ///
    /// # Errors
    /// As [`Rivers::new`], and where water runs in a circle or to a vertex that is not there. The vertices named are the
    /// given ones, but for numbers out of range.
    pub fn sorted(vertices: &[RiverVertex]) -> Result<(Self, Vec<u32>), RiverFault> {
        let count = vertices.len();
        if count > MAX_VERTICES {
            return Err(RiverFault::TooMany(count));
        }
        let missing = |of: &RiverVertex| of.down.filter(|&down| down as usize >= count);
        if let Some((vertex, down)) = vertices.iter().enumerate().find_map(|(i, of)| Some((i, missing(of)?)))
        {
            return Err(RiverFault::Missing { vertex, down, count });
        }
        let order = super::Tributaries::of(vertices).downstream_first(vertices);
        let mut place = vec![u32::MAX; count];
        for (to, &from) in order.iter().enumerate() {
            place[from as usize] = to as u32;
        }
        // What no outlet drains is on a circle or drains into one.
        if let Some(vertex) = place.iter().position(|&p| p == u32::MAX) {
            return Err(RiverFault::Circle(circle_below(vertices, vertex)));
        }
        let moved = |&from: &u32| {
            let of = vertices[from as usize];
            RiverVertex { down: of.down.map(|down| place[down as usize]), ..of }
        };
        Ok((Self::new(order.iter().map(moved).collect())?, order))
    }
}

/// A vertex of the circle that a vertex drains into.
fn circle_below(vertices: &[RiverVertex], from: usize) -> usize {
    let down = |i: usize| vertices[i].down.map_or(i, |down| down as usize);
    (0..vertices.len()).fold(from, |at, _| down(at))
}

fn check_numbers(vertex: usize, of: &RiverVertex) -> Result<(), RiverFault> {
    let number = |what, found: f64, least: f64, most: f64| {
        // Not a number is in no range.
        if (least..=most).contains(&found) {
            Ok(())
        } else {
            Err(RiverFault::Number { vertex, what, least, most, found })
        }
    };
    number("x", of.at[0], -MAX_COORDINATE, MAX_COORDINATE)?;
    number("y", of.at[1], -MAX_COORDINATE, MAX_COORDINATE)?;
    number("height", of.height, -MAX_HEIGHT, MAX_HEIGHT)?;
    number("area", of.area.into(), 0.0, f32::MAX.into())?;
    number("width", of.width.into(), 0.0, MAX_COORDINATE)
}

/// Sums the links down to the outlet, in f64, since a long river of short links would lose them in f32.
fn derive_lengths(vertices: &mut [RiverVertex]) {
    let mut lengths = Vec::with_capacity(vertices.len());
    for i in 0..vertices.len() {
        let [x, y] = vertices[i].at;
        let length = vertices[i].down.map_or(0.0, |down| {
            let below = vertices[down as usize].at;
            lengths[down as usize] + libm::hypot(x - below[0], y - below[1])
        });
        lengths.push(length);
        // At most 2²³ links of 3e8 m: far below what f32 holds.
        vertices[i].length = length as f32;
    }
}

/// Strahler's order: 1 at a source; the highest of the tributaries, or one more where two of them have it.
fn derive_orders(vertices: &mut [RiverVertex]) {
    // The highest order that joins each vertex, and whether it does so twice.
    let mut joined = vec![(0_u8, false); vertices.len()];
    for i in (0..vertices.len()).rev() {
        let (highest, twice) = joined[i];
        let order = highest.max(1) + u8::from(twice);
        vertices[i].order = order;
        if let Some(down) = vertices[i].down {
            let below = &mut joined[down as usize];
            if order > below.0 {
                *below = (order, false);
            } else if order == below.0 {
                below.1 = true;
            }
        }
    }
}
