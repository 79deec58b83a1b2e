//! The report that builds of single tiles share: each build replaces its own entries and keeps those of the others.

use std::collections::BTreeMap;

use serde_json::{Map, Value as Json, json};

use crate::files::Tile;

/// The outputs and tiles that one build of a part makes.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// The outputs.
    pub(super) names: Vec<String>,
    pub(super) tiles: Vec<Tile>,
}

impl Part {
    /// Whether an entry of a report is about an output on a tile of this part.
    fn holds(&self, entry: &Json) -> bool {
        let name = entry["name"].as_str().or(entry["output"].as_str()).unwrap_or_default();
        let of = |tile: &Tile| entry["tile"]["col"] == tile.col && entry["tile"]["row"] == tile.row;
        self.names.iter().any(|n| n == name) && self.tiles.iter().any(of)
    }
}

/// Whether a report is of the same build, and thus of another part of it.
pub(super) fn is_same_build(report: &Map<String, Json>, head: &Map<String, Json>) -> bool {
    head.get("build_key").is_some_and(|key| report.get("build_key") == Some(key))
}

/// The report without the entries of a part; `None` where nothing remains.
pub(super) fn without(mut report: Map<String, Json>, part: &Part) -> Option<Map<String, Json>> {
    let mut left = 0;
    for list in ["outputs", "failures"] {
        if let Some(Json::Array(entries)) = report.get_mut(list) {
            entries.retain(|entry| !part.holds(entry));
            left += entries.len();
        }
    }
    settle(&mut report);
    (left > 0).then_some(report)
}

/// The common report of two builds of parts.
pub(super) fn merged(other: Map<String, Json>, mut own: Map<String, Json>, part: &Part) -> Map<String, Json> {
    let Some(other) = without(other, part) else { return own };
    let list = |map: &Map<String, Json>, key: &str| map.get(key).and_then(Json::as_array).cloned();
    for key in ["outputs", "failures"] {
        let mut all: Vec<Json> =
            [list(&other, key), list(&own, key)].into_iter().flatten().flatten().collect();
        // The order is that of one build of all tiles; the outputs of a tile stay in their order.
        all.sort_by_key(|entry| (entry["tile"]["row"].as_u64(), entry["tile"]["col"].as_u64()));
        own.insert(key.to_owned(), all.into());
    }
    let mut warnings = list(&other, "warnings").unwrap_or_default();
    let news = list(&own, "warnings").unwrap_or_default();
    warnings.extend(news.into_iter().filter(|w| !warnings.contains(w)).collect::<Vec<_>>());
    own.insert("warnings".to_owned(), warnings.into());
    for key in ["seconds", "planned_seconds", "processor_seconds"] {
        own.insert(key.to_owned(), json!(number(&other, key) + number(&own, key)));
    }
    for key in ["peak_bytes", "planned_bytes", "reserve_bytes", "process_peak_bytes"] {
        let [a, b] = [&other, &own].map(|map| map.get(key).and_then(Json::as_u64));
        own.insert(key.to_owned(), json!(a.max(b)));
    }
    let nodes = [list(&other, "nodes"), list(&own, "nodes")].into_iter().flatten().flatten();
    own.insert("nodes".to_owned(), nodes_together(nodes).into());
    settle(&mut own);
    own
}

/// The totals of the nodes over all parts.
fn nodes_together(entries: impl Iterator<Item = Json>) -> Vec<Json> {
    let mut nodes: BTreeMap<(String, String), Json> = BTreeMap::new();
    for entry in entries {
        let word = |key: &str| entry[key].as_str().unwrap_or_default().to_owned();
        let key = (word("node"), word("stage"));
        let Some(total) = nodes.get_mut(&key) else {
            nodes.insert(key, entry);
            continue;
        };
        let whole = |json: &Json, key: &str| json[key].as_u64().unwrap_or_default();
        for key in ["runs", "cached"] {
            total[key] = json!(whole(total, key).saturating_add(whole(&entry, key)));
        }
        total["bytes"] = json!(whole(total, "bytes").max(whole(&entry, "bytes")));
        let seconds = |json: &Json| json["seconds"].as_f64().unwrap_or_default();
        total["seconds"] = json!(seconds(total) + seconds(&entry));
        total["failed"] = json!(total["failed"] == true || entry["failed"] == true);
    }
    nodes.into_values().collect()
}

fn number(map: &Map<String, Json>, key: &str) -> f64 {
    map.get(key).and_then(Json::as_f64).unwrap_or_default()
}

/// Sets the status by the failures, and the number of tiles by the outputs.
pub(super) fn settle(report: &mut Map<String, Json>) {
    let done = report.get("failures").and_then(Json::as_array).is_none_or(Vec::is_empty);
    report.insert("status".to_owned(), json!(if done { "done" } else { "failed" }));
    let outputs = report.get("outputs").and_then(Json::as_array).into_iter().flatten();
    let tiles = outputs.filter_map(|o| Some((o["tile"]["row"].as_u64()?, o["tile"]["col"].as_u64()?)));
    let built = tiles.collect::<std::collections::BTreeSet<_>>().len();
    if let Some(cut @ Json::Object(_)) = report.get_mut("tiles") {
        cut["built"] = json!(built);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(col: u32) -> Part {
        Part { names: vec!["height".into()], tiles: vec![Tile { col, row: 0, cols: 2, rows: 1 }] }
    }

    fn report(col: u32, bytes: u64, failed: bool) -> Map<String, Json> {
        let tile = json!({ "col": col, "row": 0, "cols": 2, "rows": 1 });
        let entry = json!({ "name": "height", "output": "height", "bytes": bytes, "tile": tile });
        let (outputs, failures) = if failed { (vec![], vec![entry]) } else { (vec![entry], vec![]) };
        let node =
            json!({ "node": "n", "stage": "run", "runs": 1, "cached": 2, "seconds": 0.5, "bytes": bytes });
        let report = json!({
            "build_key": "k", "tiles": { "cols": 2, "rows": 1 }, "outputs": outputs, "failures": failures,
            "warnings": ["both", format!("tile {col}")], "seconds": 1.5, "planned_seconds": 0.5, "processor_seconds": 2.0, "peak_bytes": bytes, "nodes": [node],
        });
        let mut report = report.as_object().cloned().unwrap_or_default();
        settle(&mut report);
        report
    }

    #[test]
    fn two_parts_are_one_report() {
        let both = merged(report(1, 7, false), report(0, 9, false), &part(0));
        let outputs: Vec<_> =
            both["outputs"].as_array().expect("a list").iter().map(|o| &o["bytes"]).collect();
        assert_eq!(outputs, [9, 7], "in the order of the tiles");
        assert_eq!((&both["status"], &both["tiles"]["built"]), (&json!("done"), &json!(2)));
        assert_eq!(both["warnings"], json!(["both", "tile 1", "tile 0"]));
        assert_eq!((&both["seconds"], &both["peak_bytes"]), (&json!(3.0), &json!(9)));
        assert_eq!((&both["planned_seconds"], &both["processor_seconds"]), (&json!(1.0), &json!(4.0)));
        let node = &both["nodes"][0];
        assert_eq!((&node["runs"], &node["cached"], &node["seconds"]), (&json!(2), &json!(4), &json!(1.0)));
    }

    #[test]
    fn a_part_replaces_its_own_entries() {
        let again = merged(report(0, 7, true), report(0, 9, false), &part(0));
        assert_eq!(again["outputs"].as_array().expect("a list").len(), 1);
        assert_eq!((&again["status"], &again["failures"]), (&json!("done"), &json!([])));
        let failed = merged(report(1, 7, false), report(0, 9, true), &part(0));
        assert_eq!((&failed["status"], &failed["tiles"]["built"]), (&json!("failed"), &json!(1)));
        assert!(without(report(0, 7, false), &part(0)).is_none());
        assert!(without(report(0, 7, false), &part(1)).is_some());
    }
}
