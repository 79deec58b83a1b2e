//! Arrangement of nodes: columns from sources to results, and alignment.

use std::collections::{BTreeMap, BTreeSet};

use super::layout::{Layout, WIDTH};
use crate::graph::{Graph, NodeId, Problem};
use crate::name::Name;

/// The gap between two columns, and between two nodes of a column.
const GAP: [f32; 2] = [68.0, 24.0];
/// Number of sweeps over the columns that move nodes towards those they are wired to.
const SWEEPS: usize = 6;

/// Arranges nodes in columns: each stands to the right of all nodes it reads, at the height of those it is wired to.
/// The upper left corner of the nodes stays where it was.
pub(crate) fn columns(graph: &mut Graph, nodes: &BTreeSet<NodeId>) -> Result<(), Problem> {
    let places = places(graph, nodes);
    for (id, at) in places {
        let inner: Vec<Name> = graph.inputs(id).map(|(input, _)| input.clone()).collect();
        for input in inner {
            graph.set_bends(id, &input, Vec::new())?;
        }
        graph.move_to(id, at)?;
    }
    Ok(())
}

fn places(graph: &Graph, nodes: &BTreeSet<NodeId>) -> Vec<(NodeId, [f64; 2])> {
    let ranks = ranks(graph, nodes);
    let mut columns: BTreeMap<usize, Vec<NodeId>> = BTreeMap::new();
    for id in graph.nodes().filter(|id| nodes.contains(id)) {
        columns.entry(ranks.get(&id).copied().unwrap_or(0)).or_default().push(id);
    }
    let height = |id: NodeId| Layout::of(graph.node(id)).rect.height() + GAP[1];
    let mut middle: BTreeMap<NodeId, f32> = BTreeMap::new();
    let stack = |column: &[NodeId], middle: &mut BTreeMap<NodeId, f32>| {
        let whole: f32 = column.iter().map(|id| height(*id)).sum();
        let mut y = -0.5 * whole;
        for &id in column {
            middle.insert(id, y + 0.5 * height(id));
            y += height(id);
        }
    };
    columns.values().for_each(|column| stack(column, &mut middle));
    for sweep in 0..SWEEPS {
        let forward = sweep % 2 == 0;
        let mut order: Vec<usize> = columns.keys().copied().collect();
        if !forward {
            order.reverse();
        }
        for rank in order {
            let Some(column) = columns.get_mut(&rank) else { continue };
            let mut wanted: Vec<(f32, NodeId)> =
                column.iter().map(|&id| (pull(graph, id, forward, &middle), id)).collect();
            wanted.sort_by(|a, b| a.0.total_cmp(&b.0));
            *column = wanted.iter().map(|(_, id)| *id).collect();
            settle(&wanted, height, &mut middle);
        }
    }
    let corner = nodes.iter().filter_map(|id| graph.get(*id)).map(|n| n.at);
    let corner = corner.fold([f64::INFINITY; 2], |a, b| [a[0].min(b[0]), a[1].min(b[1])]);
    let top = middle.iter().map(|(id, y)| y - 0.5 * height(*id)).fold(f32::INFINITY, f32::min);
    let place = |(rank, id): (usize, NodeId)| {
        let y = middle.get(&id).map_or(0.0, |y| y - 0.5 * height(id) - top);
        let x = rank as f32 * (WIDTH + GAP[0]);
        let whole = |v: f32| f64::from((v / super::GRID).round() * super::GRID);
        (id, [corner[0] + whole(x), corner[1] + whole(y)])
    };
    let all = columns.iter().flat_map(|(&rank, ids)| ids.iter().map(move |&id| (rank, id)));
    all.map(place).collect()
}

/// For each node how many others stand between it and a source, at most.
fn ranks(graph: &Graph, nodes: &BTreeSet<NodeId>) -> BTreeMap<NodeId, usize> {
    let ids: Vec<_> = graph.nodes().filter(|id| nodes.contains(id)).collect();
    // A graph with a cycle has no order; its nodes then stand as the file has them.
    let order = graph.order_of(&ids).unwrap_or(ids);
    let mut ranks: BTreeMap<NodeId, usize> = BTreeMap::new();
    for id in order.into_iter().filter(|id| nodes.contains(id)) {
        let sources = graph.inputs(id).filter_map(|(_, s)| ranks.get(&s.node));
        let rank = sources.map(|r| r + 1).max().unwrap_or(0);
        ranks.insert(id, rank);
    }
    // A node without inputs stands beside the first node that reads it, not at the far left.
    let mut pulled = ranks.clone();
    for (&id, &rank) in &ranks {
        if graph.inputs(id).next().is_none() {
            let readers = graph.consumers(id).filter_map(|(to, ..)| ranks.get(&to));
            let near = readers.min().map_or(rank, |r| r.saturating_sub(1));
            pulled.insert(id, near.max(rank));
        }
    }
    pulled
}

/// The preferred height of a node: the mean of the nodes it reads, or of those that read it.
fn pull(graph: &Graph, id: NodeId, forward: bool, middle: &BTreeMap<NodeId, f32>) -> f32 {
    let own = middle.get(&id).copied().unwrap_or(0.0);
    let places: Vec<f32> = if forward {
        graph.inputs(id).filter_map(|(_, s)| middle.get(&s.node).copied()).collect()
    } else {
        graph.consumers(id).filter_map(|(to, ..)| middle.get(&to).copied()).collect()
    };
    if places.is_empty() { own } else { places.iter().sum::<f32>() / places.len() as f32 }
}

/// Places the nodes of a column as near to their preferred heights as is possible without overlap.
fn settle(wanted: &[(f32, NodeId)], height: impl Fn(NodeId) -> f32, middle: &mut BTreeMap<NodeId, f32>) {
    // Touching nodes form a run, whose middle is the mean of the middles that its nodes prefer.
    let mut runs: Vec<(f32, f32, Vec<NodeId>)> = Vec::new();
    for &(want, id) in wanted {
        let mut run = (want, height(id), vec![id]);
        while let Some(last) = runs.last() {
            if last.0 + 0.5 * last.1 <= run.0 - 0.5 * run.1 {
                break;
            }
            let Some((at, high, mut ids)) = runs.pop() else { break };
            let (a, b) = (ids.len() as f32, run.2.len() as f32);
            let joined = high + run.1;
            // The middle of the joined run that each of the two parts prefers.
            let (first, second) = (at + 0.5 * (joined - high), run.0 - 0.5 * (joined - run.1));
            ids.append(&mut run.2);
            run = ((first * a + second * b) / (a + b), joined, ids);
        }
        runs.push(run);
    }
    for (at, high, ids) in runs {
        let mut y = at - 0.5 * high;
        for id in ids {
            middle.insert(id, y + 0.5 * height(id));
            y += height(id);
        }
    }
}

/// The edge by which nodes are aligned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AlignEdge {
    Left,
    Top,
}

/// Aligns the left or upper edges of nodes with that of the outermost node.
pub(crate) fn align(graph: &mut Graph, nodes: &BTreeSet<NodeId>, edge: AlignEdge) -> Result<(), Problem> {
    let axis = usize::from(edge == AlignEdge::Top);
    let places = nodes.iter().filter_map(|id| graph.get(*id)).map(|n| n.at[axis]);
    let line = places.fold(f64::INFINITY, f64::min);
    for &id in nodes {
        let mut at = graph.node(id).at;
        at[axis] = line;
        graph.move_to(id, at)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nodes::Registry;

    #[test]
    fn columns_run_forward_and_nodes_do_not_overlap() {
        let mut presets = 0;
        for file in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../../graphs"))
            .expect("presets")
            .flatten()
        {
            let mut graph = Graph::open(&file.path(), &Registry::standard()).expect("a graph");
            let all: BTreeSet<NodeId> = graph.nodes().collect();
            columns(&mut graph, &all).expect("moves");
            let rect = |id: NodeId| Layout::of(graph.node(id)).rect;
            for &id in &all {
                for (_, source) in graph.inputs(id) {
                    assert!(rect(source.node).right() < rect(id).left(), "{:?}", file.path());
                }
                let others = all.iter().filter(|o| **o != id);
                for other in others {
                    assert!(!rect(*other).intersects(rect(id).shrink(4.0)), "{:?}", file.path());
                }
            }
            presets += 1;
        }
        assert!(presets > 10);
    }

    #[test]
    fn aligns_to_the_outermost() {
        let mut graph = Graph::new();
        let ids = ["a", "b", "c"].map(|name| graph.add(name, "blur").expect("adds"));
        for (i, id) in ids.iter().enumerate() {
            graph.move_to(*id, [100.0 - 30.0 * i as f64, 10.0 * i as f64]).expect("moves");
        }
        align(&mut graph, &BTreeSet::from(ids), AlignEdge::Left).expect("moves");
        assert!(ids.iter().all(|id| graph.node(*id).at[0] == 40.0));
        assert_eq!(graph.node(ids[2]).at[1], 20.0);
    }
}
