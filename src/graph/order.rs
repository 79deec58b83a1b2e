//! The order of evaluation, and the nodes upstream and downstream of a node.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap, HashMap};

use petgraph::Direction::{self, Incoming, Outgoing};

use super::dag::NodeMap;
use super::{Graph, NodeId, Place, Problem};

impl Graph {
    /// All nodes, each after the nodes that it reads, otherwise in the order of the file.
    ///
    /// # Errors
    /// Fails when there is a cycle, whose nodes the error names.
    pub fn order(&self) -> Result<Vec<NodeId>, Problem> {
        self.sorted(self.sequence.clone()).map_err(|rest| self.cycle_problem(&rest))
    }

    /// Some nodes and all nodes upstream of them, each after the nodes that it reads, otherwise in the order of the
    /// file. Cycles elsewhere in the graph are ignored.
    ///
    /// # Errors
    /// Fails when there is a cycle among these nodes, which the error names.
    pub fn order_of(&self, ids: &[NodeId]) -> Result<Vec<NodeId>, Problem> {
        let wanted = self.reach(ids, Incoming);
        let nodes = self.nodes().filter(|id| wanted.contains(id)).collect();
        self.sorted(nodes).map_err(|rest| self.cycle_problem(&rest))
    }

    /// A node and all nodes that it reads, directly or through others.
    pub fn upstream(&self, id: NodeId) -> BTreeSet<NodeId> {
        self.reach(&[id], Incoming)
    }

    /// A node and all nodes that read it, directly or through others.
    pub fn downstream(&self, id: NodeId) -> BTreeSet<NodeId> {
        self.reach(&[id], Outgoing)
    }

    fn reach(&self, ids: &[NodeId], direction: Direction) -> BTreeSet<NodeId> {
        let mut stack: Vec<NodeId> = ids.iter().copied().filter(|&id| self.get(id).is_some()).collect();
        let mut found: BTreeSet<NodeId> = stack.iter().copied().collect();
        while let Some(id) = stack.pop() {
            stack.extend(self.dag.neighbors(id, direction).filter(|&next| found.insert(next)));
        }
        found
    }

    /// Sorts nodes that are given in the order of the file; `Err` has those on a cycle or downstream of one.
    fn sorted(&self, nodes: Vec<NodeId>) -> Result<Vec<NodeId>, Vec<NodeId>> {
        let (sorted, rest) = self.sorted_as_far(nodes);
        if rest.is_empty() { Ok(sorted) } else { Err(rest) }
    }

    /// Sorts nodes that are given in the order of the file. The second list has those on a cycle or downstream of one.
    pub(super) fn sorted_as_far(&self, nodes: Vec<NodeId>) -> (Vec<NodeId>, Vec<NodeId>) {
        let place: NodeMap<usize> = nodes.iter().enumerate().map(|(i, &id)| (id, i)).collect();
        let sources =
            |&id: &NodeId| self.dag.neighbors(id, Incoming).filter(|s| place.contains_key(s)).count();
        let mut waits: Vec<usize> = nodes.iter().map(sources).collect();
        let free = waits.iter().enumerate().filter(|(_, w)| **w == 0).map(|(i, _)| Reverse(i));
        let mut ready: BinaryHeap<_> = free.collect();
        let mut order = Vec::with_capacity(nodes.len());
        while let Some(Reverse(i)) = ready.pop() {
            order.push(nodes[i]);
            for reader in self.dag.neighbors(nodes[i], Outgoing).filter_map(|r| place.get(&r)) {
                waits[*reader] -= 1;
                if waits[*reader] == 0 {
                    ready.push(Reverse(*reader));
                }
            }
        }
        let rest = nodes.into_iter().zip(waits).filter(|(_, w)| *w > 0).map(|(id, _)| id).collect();
        (order, rest)
    }

    /// One problem for each group of nodes that read each other.
    pub(super) fn cycles(&self) -> Vec<Problem> {
        let Err(mut rest) = self.sorted(self.sequence.clone()) else { return Vec::new() };
        let mut found = Vec::new();
        // A node that has been on a cycle is taken out; what is left may hold others.
        loop {
            let cycle = self.cycle_in(&rest);
            found.push(self.cycle_named(&cycle));
            let on_it: BTreeSet<NodeId> = cycle.into_iter().collect();
            rest.retain(|id| !on_it.contains(id));
            match self.sorted(rest) {
                Ok(_) => return found,
                Err(left) if found.len() == MAX_CYCLES => {
                    let named = format!("is on a cycle or below one; more than {MAX_CYCLES} were found");
                    let place = |id| Place::Node(self.node(id).name.clone());
                    found.extend(left.iter().map(|&id| Problem::error(place(id), named.as_str()).of(id)));
                    return found;
                }
                Err(left) => rest = left,
            }
        }
    }

    fn cycle_problem(&self, rest: &[NodeId]) -> Problem {
        self.cycle_named(&self.cycle_in(rest))
    }

    /// A cycle among nodes each of which reads another of them. It follows the wires and begins with the node that is
    /// first in the file.
    fn cycle_in(&self, nodes: &[NodeId]) -> Vec<NodeId> {
        let among: BTreeSet<NodeId> = nodes.iter().copied().collect();
        let (mut walk, mut seen) = (Vec::new(), HashMap::new());
        let mut next = nodes.first().copied();
        while let Some(id) = next {
            if let Some(start) = seen.insert(id, walk.len()) {
                let mut cycle = walk.split_off(start);
                cycle.reverse();
                let on_it: BTreeSet<NodeId> = cycle.iter().copied().collect();
                let first = nodes.iter().find(|n| on_it.contains(n));
                let start = cycle.iter().position(|id| Some(id) == first);
                cycle.rotate_left(start.unwrap_or(0));
                return cycle;
            }
            walk.push(id);
            next = self.dag.neighbors(id, Incoming).find(|s| among.contains(s));
        }
        walk
    }

    fn cycle_named(&self, cycle: &[NodeId]) -> Problem {
        let Some(&first) = cycle.first() else { return Problem::error(Place::Graph, "has a cycle") };
        let message = format!("is on a cycle: {}", self.path_text(cycle, first));
        Problem::error(Place::Node(self.node(first).name.clone()), message).of(first)
    }

    /// The text of a path, such as "`a` > `b` > `a`"; the middle of a long path is left out.
    pub(super) fn path_text(&self, path: &[NodeId], last: NodeId) -> String {
        const SHOWN: usize = 12;
        let name = |id: &NodeId| format!("`{}`", self.node(*id).name);
        let mut names: Vec<String> = path.iter().chain([&last]).map(name).collect();
        if names.len() > SHOWN {
            let left_out = names.len() - SHOWN;
            names.splice(SHOWN / 2..SHOWN / 2 + left_out, [format!("… ({left_out} more) …")]);
        }
        names.join(" > ")
    }

    /// The nodes of a path along the wires from one node to another, both included.
    pub(super) fn way(&self, from: NodeId, to: NodeId) -> Option<Vec<NodeId>> {
        let mut reached_from = HashMap::from([(from, from)]);
        let mut front = std::collections::VecDeque::from([from]);
        while let Some(id) = front.pop_front() {
            if id == to {
                let mut way = vec![to];
                while let Some(&id) = way.last().filter(|id| **id != from) {
                    way.extend(reached_from.get(&id));
                }
                way.reverse();
                return Some(way);
            }
            for next in self.dag.neighbors(id, Outgoing) {
                reached_from.entry(next).or_insert_with(|| {
                    front.push_back(next);
                    id
                });
            }
        }
        None
    }
}

/// The most cycles that are reported; each takes a walk over the remaining nodes.
const MAX_CYCLES: usize = 64;
