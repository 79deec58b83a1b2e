//! Migration of old files: steps from one format, or from one version of a kind, to the next.

use serde_json::{Map, Value as Json};

use super::LoadError;
use super::path::{get, put};
use crate::node::Migration;

/// Rewrites a file of one format into the next.
pub(super) type FormatStep = fn(&mut Map<String, Json>);

/// The steps from each format to the next; the first leads from format 1 to 2.
pub(super) const FORMAT_STEPS: &[FormatStep] = &[];

/// The format of the files that this version writes.
pub const FORMAT: u64 = 1 + FORMAT_STEPS.len() as u64;

/// Brings a file to the current format.
pub(super) fn upgrade(file: &mut Map<String, Json>, steps: &[FormatStep]) -> Result<(), LoadError> {
    let current = 1 + steps.len() as u64;
    let Some(written) = file.get("orograph") else { return Err(LoadError::NotAGraph) };
    let version = match written.as_u64() {
        Some(version) if version >= 1 => version,
        _ => return Err(LoadError::BadVersion { found: crate::text::brief(written), current }),
    };
    if version > current {
        return Err(LoadError::NewerVersion { found: version, current });
    }
    for step in &steps[version as usize - 1..] {
        step(file);
    }
    Ok(())
}

/// Brings parameters to the current version of their kind.
pub(super) fn parameters(set: &mut Map<String, Json>, steps: &[Migration]) {
    for step in steps {
        step(set);
    }
}

/// The path and the value of a parameter after a migration.
///
/// A step migrates a whole set of parameters, so that the steps run on the set of the node with the value added. Where
/// the parameter is gone afterwards and exactly one new name has appeared, it was renamed to that.
pub(super) fn follow(
    set: &Map<String, Json>,
    steps: &[Migration],
    path: &[String],
    value: &Json,
) -> Option<(Vec<String>, Json)> {
    let (first, rest) = path.split_first()?;
    let rest: Vec<&str> = rest.iter().map(String::as_str).collect();
    let mut probe = set.clone();
    put(probe.entry(first.as_str()).or_insert(Json::Null), &rest, value.clone());
    let before = probe.clone();
    parameters(&mut probe, steps);
    let name = if probe.contains_key(first) {
        first.clone()
    } else {
        let mut fresh = probe.keys().filter(|k| !before.contains_key(k.as_str()));
        let (only, None) = (fresh.next()?, fresh.next()) else { return None };
        only.clone()
    };
    let found = get(probe.get(&name)?.into(), &rest)?.json();
    let path = std::iter::once(name).chain(rest.iter().map(|&s| s.to_owned())).collect();
    Some((path, found))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn object(json: Json) -> Map<String, Json> {
        json.as_object().unwrap().clone()
    }

    #[test]
    fn a_file_of_an_older_format_takes_every_step_from_its_own() {
        let steps: &[FormatStep] = &[
            |file| {
                let nodes = file.shift_remove("boxes").unwrap_or_default();
                file.insert("nodes".into(), nodes);
            },
            |file| {
                file.insert("title".into(), "from two".into());
            },
        ];
        let mut first = object(json!({"orograph": 1, "boxes": {}}));
        upgrade(&mut first, steps).unwrap();
        assert_eq!(Json::Object(first), json!({"orograph": 1, "nodes": {}, "title": "from two"}));
        let mut second = object(json!({"orograph": 2, "boxes": 5}));
        upgrade(&mut second, steps).unwrap();
        assert_eq!(Json::Object(second), json!({"orograph": 2, "boxes": 5, "title": "from two"}));
        let mut third = object(json!({"orograph": 3}));
        upgrade(&mut third, steps).unwrap();
        assert_eq!(Json::Object(third), json!({"orograph": 3}));
        let newer = upgrade(&mut object(json!({"orograph": 4})), steps).unwrap_err();
        assert!(newer.to_string().contains("format 4"), "{newer}");
    }

    #[test]
    fn a_renamed_and_rescaled_parameter_is_followed() {
        let step: Migration = |set| {
            if let Some(old) = set.shift_remove("size_km").and_then(|v| v.as_f64()) {
                set.insert("size".into(), (old * 1000.0).into());
            }
        };
        let set = object(json!({"size_km": 1, "other": 3}));
        let found = follow(&set, &[step], &["size_km".into()], &json!(2.5));
        assert_eq!(found, Some((vec!["size".to_owned()], json!(2500.0))));
        let found = follow(&set, &[step], &["other".into()], &json!(7));
        assert_eq!(found, Some((vec!["other".to_owned()], json!(7))));
    }
}
