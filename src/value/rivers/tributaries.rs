//! The vertices upstream of each vertex.

use super::RiverVertex;

/// The vertices upstream of each vertex, in the order of their numbers.
#[derive(Clone, Debug)]
pub struct Tributaries {
    /// Where the list of each vertex starts; one more at the end.
    starts: Vec<u32>,
    upstream: Vec<u32>,
}

impl Tributaries {
    /// Of vertices that each drain to one of them.
    pub(super) fn of(vertices: &[RiverVertex]) -> Self {
        let mut starts = vec![0_u32; vertices.len() + 1];
        for down in vertices.iter().filter_map(|vertex| vertex.down) {
            starts[down as usize + 1] += 1;
        }
        for i in 0..vertices.len() {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut upstream = vec![0; starts[vertices.len()] as usize];
        for (i, vertex) in vertices.iter().enumerate() {
            if let Some(down) = vertex.down {
                let slot = &mut next[down as usize];
                upstream[*slot as usize] = i as u32;
                *slot += 1;
            }
        }
        Self { starts, upstream }
    }

    /// The vertices upstream of a vertex.
    pub fn at(&self, vertex: usize) -> &[u32] {
        &self.upstream[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// Every vertex that drains to an outlet, downstream first: the first river up to its source, then the rivers that
    /// join it, from the source down.
    pub(super) fn downstream_first(&self, vertices: &[RiverVertex]) -> Vec<u32> {
        let mut order = Vec::with_capacity(vertices.len());
        let mut open = Vec::new();
        for outlet in (0..vertices.len()).filter(|&i| vertices[i].down.is_none()) {
            open.push(outlet as u32);
            while let Some(vertex) = open.pop() {
                order.push(vertex);
                open.extend(self.at(vertex as usize).iter().rev());
            }
        }
        order
    }

    /// The main tributary of each vertex: that of the highest order, of those the one with the largest area, of those the
    /// first. None at a source.
    pub fn main(&self, vertex: usize, vertices: &[RiverVertex]) -> Option<usize> {
        let rank = |i: usize| (vertices[i].order, vertices[i].area);
        let mut all = self.at(vertex).iter().map(|&i| i as usize);
        let first = all.next()?;
        Some(all.fold(first, |best, i| if rank(i) > rank(best) { i } else { best }))
    }
}
