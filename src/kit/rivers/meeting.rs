//! Where two rivers meet, and how large they are there.

use crate::value::RiverVertex;

/// A network as paths: each vertex continues that of the vertex downstream if it has the largest tree of all that drain
/// to it, and starts one otherwise. From any vertex few paths lead to the outlet, as many as the logarithm of the number
/// of vertices at most.
pub struct Meetings<'a> {
    vertices: &'a [RiverVertex],
    /// The lowest vertex of the path of each.
    mouth: Vec<u32>,
    /// The vertex upstream that continues the path of each.
    upper: Vec<u32>,
    outlet: Vec<u32>,
}

impl<'a> Meetings<'a> {
    /// Of vertices that stand downstream first.
    pub fn of(vertices: &'a [RiverVertex]) -> Self {
        let n = vertices.len();
        let (mut size, mut upper) = (vec![1_u32; n], vec![u32::MAX; n]);
        for i in (0..n).rev() {
            let Some(down) = vertices[i].down.map(|down| down as usize) else { continue };
            size[down] += size[i];
            let best = upper[down];
            // Of two as large the later number is seen first, and the earlier one takes its place.
            if best == u32::MAX || size[i] >= size[best as usize] {
                upper[down] = i as u32;
            }
        }
        let (mut mouth, mut outlet) = (vec![0; n], vec![0; n]);
        for i in 0..n {
            let down = vertices[i].down.map(|down| down as usize);
            outlet[i] = down.map_or(i as u32, |down| outlet[down]);
            mouth[i] = down.filter(|&down| upper[down] == i as u32).map_or(i as u32, |down| mouth[down]);
        }
        Self { vertices, mouth, upper, outlet }
    }

    /// The lower of the Strahler orders that the rivers of two vertices have where they meet: those of the links that join
    /// there, or of a vertex itself that the other drains through. Of two that do not meet, at their outlets.
    pub fn order(&self, pair: [usize; 2]) -> u8 {
        let order = |i: usize| self.vertices[i].order;
        let Some((meeting, ways)) = self.meet(pair) else {
            let [a, b] = pair.map(|i| order(self.outlet[i] as usize));
            return a.min(b);
        };
        let came = |(at, link): (usize, usize)| {
            order(if at == meeting { link } else { self.upper[meeting] as usize })
        };
        came(ways[0]).min(came(ways[1]))
    }

    /// The vertex where the rivers of two vertices meet; none of two that do not.
    pub fn meeting(&self, pair: [usize; 2]) -> Option<usize> {
        self.meet(pair).map(|(meeting, _)| meeting)
    }

    /// The vertex where two meet, and where on its path each came to the path of the meeting, by which link.
    fn meet(&self, [a, b]: [usize; 2]) -> Option<(usize, [(usize, usize); 2])> {
        if self.outlet[a] != self.outlet[b] {
            return None;
        }
        // Where each is on its way down, and the link by which it came there.
        let mut ways = [(a, a), (b, b)];
        while self.mouth[ways[0].0] != self.mouth[ways[1].0] {
            // What is downstream has a smaller number, so the path with the later mouth is left.
            let mouths = ways.map(|(at, _)| self.mouth[at]);
            let later = usize::from(mouths[1] > mouths[0]);
            let mouth = mouths[later] as usize;
            match self.vertices[mouth].down {
                Some(down) => ways[later] = (down as usize, mouth),
                // Both have one outlet, so this is not reached.
                None => break,
            }
        }
        Some((ways[0].0.min(ways[1].0), ways))
    }
}
