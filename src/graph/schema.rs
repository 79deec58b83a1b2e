//! The JSON schema of `.graph` files, with which text editors can check them.

use schemars::{JsonSchema, schema_for};
use serde_json::{Map, Value as Json, json};

use super::canvas::Note;
use super::parts::{About, Exposed, NodeKeys, Output};
use super::settings::TerrainSettings;
use super::{FORMAT, MAX_NAMED, MAX_NODES};
use crate::node::Kind;
use crate::nodes::Registry;

/// The JSON schema (draft 2020-12) of graph files with the kinds of a registry.
///
/// It is stricter than the reader in one way: it rejects unknown keys, so that a text editor marks typing errors, while
/// the reader keeps them with a warning. It cannot check whether wires and binds resolve.
pub fn schema(registry: &Registry) -> Json {
    let mut defs = Map::new();
    let about = part::<About>("about", &mut defs);
    let output = output_schema(&mut defs);
    let exposed = closed(part::<Exposed>("exposed", &mut defs), &["bind"]);
    let note = closed(part::<Note>("note", &mut defs), &[]);
    let terrain = part::<TerrainSettings>("terrain", &mut defs);
    let keys = part::<NodeKeys>("node", &mut defs);
    let rules: Vec<Json> = registry.iter().map(|kind| rule(kind, &mut defs)).collect();
    let kinds: Vec<&str> = registry.iter().map(|k| k.id.as_str()).collect();
    let versions: Map<String, Json> = registry
        .iter()
        .map(|k| (k.id.to_string(), json!({"type": "integer", "minimum": 1, "maximum": k.version})))
        .collect();
    let mut node = json!({
        "type": "object",
        "properties": {
            "kind": { "description": "The kind of the node.", "enum": kinds },
            "in": { "description": "What its inputs read, each as `node.port`.", "type": "object", "additionalProperties": source() },
            "set": { "description": "Parameters that differ from their defaults.", "type": "object" }
        },
        "required": ["kind"],
        "allOf": rules
    });
    adopt(&mut node["properties"], &keys);
    let node = closed(node, &["kind"]);
    let named = |of: Json, limit: usize| {
        json!({
            "type": "object",
            "propertyNames": { "pattern": "^[a-z0-9_]{1,64}$" },
            "maxProperties": limit,
            "additionalProperties": of
        })
    };
    let mut file = json!({
        "orograph": { "description": "The version of the file format.", "type": "integer", "minimum": 1, "maximum": FORMAT },
        "kinds": { "description": "The versions of the kinds.", "type": "object", "properties": versions }
    });
    adopt(&mut file, &about);
    file["terrain"] = open_defaults(terrain);
    file["expose"] = named(exposed, MAX_NAMED);
    file["nodes"] = named(json!({"$ref": "#/$defs/node"}), MAX_NODES);
    file["outputs"] = named(output, MAX_NAMED);
    file["notes"] = named(note, MAX_NAMED);
    defs.insert("node".into(), node);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Orograph graph",
        "type": "object",
        "properties": file,
        "required": ["orograph", "nodes"],
        "additionalProperties": false,
        "$defs": defs
    })
}

fn source() -> Json {
    json!({ "type": "string", "pattern": "^[a-z0-9_]{1,64}\\.[a-z0-9_]+$" })
}

/// The rule for nodes of a kind: the parameters they can set and the inputs they can read.
fn rule(kind: &Kind, defs: &mut Map<String, Json>) -> Json {
    let set = moved(kind.schema(), &format!("kind.{}", kind.id), defs);
    let ports = kind.inputs.iter().map(|p| {
        let mut port = source();
        port["description"] = p.doc.as_str().into();
        (p.name.to_string(), port)
    });
    let required: Vec<&str> = kind.inputs.iter().filter(|p| p.required).map(|p| p.name.as_str()).collect();
    let mut then = json!({
        "properties": {
            "set": set,
            "in": {
                "type": "object",
                "properties": ports.collect::<Map<_, _>>(),
                "required": required,
                "additionalProperties": false
            }
        }
    });
    if !required.is_empty() {
        then["required"] = json!(["in"]);
    }
    json!({ "if": { "properties": { "kind": { "const": kind.id.as_str() } }, "required": ["kind"] }, "then": then })
}

fn output_schema(defs: &mut Map<String, Json>) -> Json {
    let mut output = closed(part::<Output>("output", defs), &["from"]);
    let from = &mut output["properties"]["from"];
    let text = from["description"].take();
    *from = source();
    from["description"] = text;
    output
}

/// The schema of a part, with its definitions moved to those of the file.
fn part<T: JsonSchema>(name: &str, defs: &mut Map<String, Json>) -> Json {
    moved(schema_for!(T).to_value(), name, defs)
}

/// Moves the definitions of a schema to `defs` under a prefix, and redirects its references.
fn moved(mut schema: Json, prefix: &str, defs: &mut Map<String, Json>) -> Json {
    redirect(&mut schema, prefix);
    if let Some(object) = schema.as_object_mut() {
        object.shift_remove("$schema");
        if let Some(Json::Object(own)) = object.shift_remove("$defs") {
            defs.extend(own.into_iter().map(|(name, def)| (format!("{prefix}.{name}"), def)));
        }
    }
    schema
}

fn redirect(schema: &mut Json, prefix: &str) {
    match schema {
        Json::Object(map) => {
            for (key, value) in map.iter_mut() {
                match value.as_str().and_then(|r| r.strip_prefix("#/$defs/")).filter(|_| key == "$ref") {
                    Some(name) => *value = format!("#/$defs/{prefix}.{name}").into(),
                    None => redirect(value, prefix),
                }
            }
        }
        Json::Array(items) => items.iter_mut().for_each(|item| redirect(item, prefix)),
        _ => (),
    }
}

/// Forbids other properties of an object, and requires some.
fn closed(mut schema: Json, required: &[&str]) -> Json {
    schema["additionalProperties"] = false.into();
    schema["required"] = required.iter().map(|&r| Json::from(r)).collect();
    schema
}

/// Makes all settings of the terrain optional, since they have defaults.
fn open_defaults(mut schema: Json) -> Json {
    if let Some(object) = schema.as_object_mut() {
        object.shift_remove("required");
    }
    schema
}

/// Adds the properties of a part.
fn adopt(properties: &mut Json, part: &Json) {
    for (name, property) in part["properties"].as_object().into_iter().flatten() {
        properties[name] = property.clone();
    }
}
