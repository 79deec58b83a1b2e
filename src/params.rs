//! Parameters as data: the JSON schema of a node's struct drives `--set`, the pages, the checks of the graph file
//! and the editor's panel.

pub(crate) mod packed;
pub mod page;

use serde_json::{Map, Value as Json};

use crate::node::{Error, Result};
use crate::text::brief;
use crate::widget::Widget;

/// One parameter, read from the schema.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// Name in the file.
    pub name: String,
    /// What it does.
    pub doc: String,
    /// What values it takes.
    pub shape: Shape,
    /// Unit symbol, `1` for plain numbers.
    pub unit: Option<String>,
    /// The range a slider offers, where it is narrower than what is allowed (`x-soft`).
    pub soft: Option<[f64; 2]>,
    /// How a panel shows it, where the shape does not say (`x-widget`).
    pub widget: Option<Widget>,
    /// What the numbers of a list are, in turn: `east`, `south`, `height` (`x-items`).
    pub items: Vec<String>,
    /// How it may be written (`examples`).
    pub example: Option<Json>,
    /// Whether it must be there, as a member of an object or mode.
    pub required: bool,
    /// The value it has when the file does not set it.
    pub default: Json,
}

/// What values a parameter takes.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A number in a closed range.
    Number {
        /// Lowest value.
        min: f64,
        /// Highest value.
        max: f64,
        /// Whether it is whole.
        integer: bool,
    },
    /// True or false.
    Flag,
    /// A text.
    Text {
        /// Most characters.
        max_length: usize,
    },
    /// One of some named modes, each of which may have parameters of its own.
    Choice(Vec<Choice>),
    /// A list of values of one shape.
    List {
        /// The shape of an item.
        item: Box<Self>,
        /// Fewest items.
        min: usize,
        /// Most items.
        max: usize,
    },
    /// A fixed sequence of values.
    Tuple(Vec<Self>),
    /// Named values.
    Record(Vec<Param>),
    /// A value or null.
    Optional(Box<Self>),
    /// A schema this module does not know; the tests refuse a kind that has one.
    Unknown,
}

/// One mode of a [`Shape::Choice`].
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// Name in the file.
    pub name: String,
    /// What it does.
    pub doc: String,
    /// Parameters of its own; with some, the file writes `{"name": {…}}`.
    pub fields: Vec<Param>,
}

/// The parameters in a schema of an object, in declaration order.
pub fn of_schema(root: &Json, defaults: &Json) -> Vec<Param> {
    fields(root, root, defaults)
}

fn fields(root: &Json, object: &Json, defaults: &Json) -> Vec<Param> {
    let Some(properties) = object["properties"].as_object() else { return Vec::new() };
    let text = |s: &Json, key: &str| s[key].as_str().map(str::to_owned);
    let required =
        |name: &str| object["required"].as_array().is_some_and(|all| all.iter().any(|n| n == name));
    let one = |(name, own): (&String, &Json)| {
        let target = resolve(root, own);
        let soft = own["x-soft"].as_array().and_then(|r| Some([r.first()?.as_f64()?, r.get(1)?.as_f64()?]));
        let items = own["x-items"].as_array().into_iter().flatten().filter_map(Json::as_str);
        let widget = Widget::in_schema(own).and_then(|first| Some(first.or(Widget::in_schema(target)?)));
        let default = defaults.get(name).or(own.get("default")).cloned().unwrap_or(Json::Null);
        Param {
            name: name.clone(),
            doc: text(own, "description").or(text(target, "description")).unwrap_or_default(),
            shape: if widget.is_some() { shape(root, own) } else { Shape::Unknown },
            unit: text(own, "x-unit").or(text(target, "x-unit")),
            soft,
            widget: widget.unwrap_or_default(),
            items: items.map(str::to_owned).collect(),
            example: own["examples"].get(0).or(target["examples"].get(0)).cloned(),
            required: required(name),
            default,
        }
    };
    properties.iter().map(one).collect()
}

/// Follows `$ref`, alone or inside a one-item `allOf`.
fn resolve<'a>(root: &'a Json, schema: &'a Json) -> &'a Json {
    let schema = match schema["allOf"].as_array().map(Vec::as_slice) {
        Some([one]) => one,
        _ => schema,
    };
    let target = schema["$ref"].as_str().and_then(|r| root.pointer(r.strip_prefix('#')?));
    target.unwrap_or(schema)
}

fn shape(root: &Json, own: &Json) -> Shape {
    let s = resolve(root, own);
    if let Some(any) = s["anyOf"].as_array()
        && let [some, null] = any.as_slice()
        && null["type"] == "null"
    {
        return Shape::Optional(Box::new(shape(root, some)));
    }
    if let Some(modes) = s["oneOf"].as_array() {
        return Shape::Choice(modes.iter().flat_map(|m| choices(root, m)).collect());
    }
    if s["enum"].is_array() {
        return Shape::Choice(choices(root, s));
    }
    let limit = |key: &str| s[key].as_u64().map(|v| v as usize);
    match s["type"].as_str() {
        Some(t @ ("number" | "integer")) => Shape::Number {
            min: s["minimum"].as_f64().unwrap_or(f64::MIN),
            max: s["maximum"].as_f64().unwrap_or(f64::MAX),
            integer: t == "integer",
        },
        Some("boolean") => Shape::Flag,
        Some("string") => Shape::Text { max_length: limit("maxLength").unwrap_or(1024) },
        Some("array") => match s["prefixItems"].as_array() {
            Some(items) => Shape::Tuple(items.iter().map(|i| shape(root, i)).collect()),
            None => {
                let item = Box::new(shape(root, &s["items"]));
                Shape::List {
                    item,
                    min: limit("minItems").unwrap_or(0),
                    max: limit("maxItems").unwrap_or(usize::MAX),
                }
            }
        },
        Some("object") => Shape::Record(fields(root, s, &Json::Null)),
        None if s["type"].as_array().is_some_and(|t| t.len() == 2 && t[1] == "null") => {
            let mut inner = s.clone();
            inner["type"] = s["type"][0].clone();
            Shape::Optional(Box::new(shape(root, &inner)))
        }
        _ => Shape::Unknown,
    }
}

/// The modes in one branch of a `oneOf`: unit variants as `const` or `enum`, variants with fields as an object of
/// one required property.
fn choices(root: &Json, mode: &Json) -> Vec<Choice> {
    let doc = mode["description"].as_str().unwrap_or_default().to_owned();
    if let Some(name) = mode["const"].as_str() {
        return vec![Choice { name: name.to_owned(), doc, fields: Vec::new() }];
    }
    if let Some(names) = mode["enum"].as_array() {
        let one = |n: &Json| Choice {
            name: n.as_str().unwrap_or_default().into(),
            doc: doc.clone(),
            fields: vec![],
        };
        return names.iter().map(one).collect();
    }
    let Some((name, body)) = mode["properties"].as_object().and_then(|p| p.iter().next()) else {
        return Vec::new();
    };
    vec![Choice { name: name.clone(), doc, fields: fields(root, resolve(root, body), &Json::Null) }]
}

/// A limit as it is shown: with an exponent where the digits would fill a line.
pub(crate) fn limit(v: f64) -> String {
    if v.abs() < 1e16 { v.to_string() } else { format!("{v:e}") }
}

impl Shape {
    /// Checks a value.
    ///
    /// # Errors
    /// A sentence without a subject: "must be a number from 0 to 80, got 200".
    pub fn check(&self, value: &Json) -> Result<(), String> {
        let bad = |want: String| Err(format!("must be {want}, got {}", brief(value)));
        match self {
            Self::Number { min, max, integer } => {
                let fits = value.as_f64().is_some_and(|v| v >= *min && v <= *max);
                if fits && (!integer || value.is_i64() || value.is_u64()) {
                    return Ok(());
                }
                let what = if *integer { "a whole number" } else { "a number" };
                bad(format!("{what} from {} to {}", limit(*min), limit(*max)))
            }
            Self::Flag if !value.is_boolean() => bad("true or false".into()),
            Self::Text { max_length } => match value.as_str() {
                Some(s) if s.chars().count() <= *max_length => Ok(()),
                Some(s) => Err(format!("must be at most {max_length} characters, got {}", s.chars().count())),
                None => bad("a text".into()),
            },
            Self::Choice(modes) => check_choice(modes, value),
            Self::List { item, min, max } => {
                let Some(items) = value.as_array() else { return bad("a list".into()) };
                if items.len() < *min || items.len() > *max {
                    let want = if min == max { min.to_string() } else { format!("from {min} to {max}") };
                    return Err(format!("must have {want} items, got {}", items.len()));
                }
                let numbered = items.iter().enumerate();
                numbered.into_iter().try_for_each(|(i, v)| item.check(v).map_err(|e| format!("item {i} {e}")))
            }
            Self::Tuple(shapes) => match value.as_array() {
                Some(items) if items.len() == shapes.len() => shapes
                    .iter()
                    .zip(items)
                    .enumerate()
                    .try_for_each(|(i, (s, v))| s.check(v).map_err(|e| format!("item {i} {e}"))),
                _ => bad(format!("a list of {}", shapes.len())),
            },
            Self::Record(fields) => match value.as_object() {
                Some(object) => check_all(fields, object).map_err(|e| format!("has a fault: {e}")),
                None => bad("an object".into()),
            },
            Self::Optional(inner) if !value.is_null() => inner.check(value),
            Self::Flag | Self::Optional(_) | Self::Unknown => Ok(()),
        }
    }

    /// Reads a value from the text of a command line: JSON, or a bare word where a text or a mode is wanted.
    ///
    /// # Errors
    /// As [`check`](Self::check).
    pub fn parse_text(&self, text: &str) -> Result<Json, String> {
        let wants_text = match self {
            Self::Text { .. } | Self::Choice(_) => true,
            Self::Optional(inner) => matches!(**inner, Self::Text { .. } | Self::Choice(_)),
            _ => false,
        };
        let value = match serde_json::from_str(text) {
            Ok(json @ (Json::String(_) | Json::Object(_) | Json::Null)) => json,
            Ok(json) if !wants_text => json,
            _ => Json::from(text),
        };
        self.check(&value).map(|()| value)
    }
}

fn check_choice(modes: &[Choice], value: &Json) -> Result<(), String> {
    let find = |name: &str| modes.iter().find(|m| m.name == name);
    let names = || modes.iter().map(|m| m.name.as_str()).collect::<Vec<_>>();
    match value {
        Json::String(name) => match find(name) {
            Some(mode) if mode.fields.is_empty() => Ok(()),
            Some(mode) => {
                let fields: Vec<_> = mode.fields.iter().map(|f| f.name.as_str()).collect();
                Err(format!("`{name}` needs its fields: {{\"{name}\": {{…}}}} with {}", fields.join(", ")))
            }
            None => Err(format!(
                "must be one of {}, got \"{name}\"{}",
                names().join(", "),
                did_you_mean(name, names())
            )),
        },
        Json::Object(object) if object.len() == 1 => {
            let (name, body) = object.iter().next().ok_or("is empty")?;
            let Some(mode) = find(name) else {
                let hint = did_you_mean(name, names());
                return Err(format!("must be one of {}, got \"{name}\"{hint}", names().join(", ")));
            };
            let Some(body) = body.as_object() else { return Err(format!("`{name}` must be an object")) };
            check_all(&mode.fields, body).map_err(|e| format!("`{name}` has a fault: {e}"))
        }
        other => Err(format!("must be one of {}, got {}", names().join(", "), brief(other))),
    }
}

/// Checks all values that are set.
///
/// # Errors
/// Names the parameter; the nearest name where one is unknown.
pub fn check_all(params: &[Param], set: &Map<String, Json>) -> Result<()> {
    for (name, value) in set {
        let bad = |message| Error::Parameter { name: name.clone(), message };
        let Some(param) = params.iter().find(|p| p.name == *name) else {
            let names: Vec<_> = params.iter().map(|p| p.name.as_str()).collect();
            let hint = did_you_mean(name, names.iter().copied());
            let all =
                if names.is_empty() { "it has none".into() } else { format!("it has {}", names.join(", ")) };
            return Err(bad(format!("is not one of this kind's; {all}{hint}")));
        };
        param.shape.check(value).map_err(bad)?;
    }
    Ok(())
}

/// "; did you mean `x`?" for the nearest of some names, or nothing when none is near.
pub fn did_you_mean<'a>(name: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    // The distance takes time quadratic in the length; nobody mistypes a name this long.
    if name.len() > 256 {
        return String::new();
    }
    let near = |a: &str| strsim::damerau_levenshtein(&a.to_lowercase(), &name.to_lowercase());
    let best = names.into_iter().map(|n| (near(n), n)).min();
    match best {
        Some((distance, n)) if distance <= 1 + name.chars().count() / 3 => format!("; did you mean `{n}`?"),
        _ => String::new(),
    }
}

/// Writes −0 as 0, so that two spellings of one value have one key.
pub fn drop_negative_zero(json: &mut Json) {
    match json {
        Json::Number(n) if n.as_f64() == Some(0.0) && n.is_f64() => *json = Json::from(0.0),
        Json::Array(items) => items.iter_mut().for_each(drop_negative_zero),
        Json::Object(map) => map.values_mut().for_each(drop_negative_zero),
        _ => (),
    }
}
