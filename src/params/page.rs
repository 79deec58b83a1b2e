//! Parameters as a person reads them: rows of a table, and what stands in lists and objects.
//!
//! All of it comes from the schema, so the pages of the command line and the help of the editor say the same, and no
//! parameter can be left out.

use serde_json::Value as Json;

use super::{Choice, Param, Shape, limit};

/// A row of a table of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The name, with that of the mode or member it belongs to.
    pub name: String,
    /// The default, as JSON with its unit.
    pub default: String,
    /// What values it takes, or how a mode is written.
    pub range: String,
    /// What it does.
    pub doc: String,
}

/// What stands in a list or an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// The parameter.
    pub name: String,
    /// What it is made of, a sentence.
    pub form: String,
    /// Its members, where it is made of objects.
    pub rows: Vec<Row>,
    /// How one is written; null for none.
    pub example: Json,
}

/// The rows of some parameters, with rows for their modes and what these take.
pub fn rows(params: &[Param]) -> Vec<Row> {
    let mut table = Table::default();
    params.iter().for_each(|p| table.param("", p));
    table.rows
}

/// What stands in the lists and objects among some parameters, those of modes included.
pub fn sections(params: &[Param]) -> Vec<Section> {
    let mut sections = Vec::new();
    params.iter().for_each(|p| collect("", p, &mut sections));
    sections
}

fn collect(prefix: &str, p: &Param, sections: &mut Vec<Section>) {
    let name = format!("{prefix}{}", p.name);
    match bare(&p.shape) {
        Shape::Choice(modes) => {
            for mode in modes {
                mode.fields.iter().for_each(|f| collect(&format!("{name}.{}.", mode.name), f, sections));
            }
        }
        shape @ (Shape::List { .. } | Shape::Record(_) | Shape::Tuple(_)) => {
            let mut table = Table::default();
            members(shape).iter().for_each(|p| table.param("", p));
            let form = form(shape, p);
            sections.push(Section { name, form, rows: table.rows, example: example(p) });
        }
        Shape::Number { .. } | Shape::Flag | Shape::Text { .. } | Shape::Optional(_) | Shape::Unknown => (),
    }
}

/// A shape, whether it may be null or not.
fn bare(shape: &Shape) -> &Shape {
    match shape {
        Shape::Optional(inner) => bare(inner),
        other => other,
    }
}

/// The members of the objects that a shape is made of.
fn members(shape: &Shape) -> &[Param] {
    match bare(shape) {
        Shape::List { item, .. } => members(item),
        Shape::Record(fields) => fields,
        _ => &[],
    }
}

/// The example of the schema, else the default where it shows anything.
fn example(p: &Param) -> Json {
    match &p.example {
        Some(example) => example.clone(),
        None if p.default.as_array().is_some_and(Vec::is_empty) => Json::Null,
        None => p.default.clone(),
    }
}

/// What a list or an object is made of, a sentence.
fn form(shape: &Shape, p: &Param) -> String {
    let unit = unit(p);
    match bare(shape) {
        Shape::Record(_) => "An object; what is left out has its default.".to_owned(),
        Shape::List { item, min, max } => {
            let n = if min == max { min.to_string() } else { format!("{min} to {max}") };
            match bare(item) {
                Shape::Record(_) => {
                    format!("A list of {n} objects; what is left out of one has its default.")
                }
                inner @ Shape::List { .. } => {
                    format!("A list of {n}, each {}.", list(inner, &p.items, &unit))
                }
                _ => capital(&format!("{}.", list(shape, &p.items, &unit))),
            }
        }
        other => capital(&format!("{}.", range(other, &p.items, &unit))),
    }
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map(|c| c.to_uppercase().chain(chars).collect()).unwrap_or_default()
}

/// What the numbers of a list are.
fn list(shape: &Shape, items: &[String], unit: &str) -> String {
    let Shape::List { item, min, max } = bare(shape) else { return range(shape, items, unit) };
    let names = items.join(", ");
    let values = range(item, &[], unit);
    match (items.is_empty(), min == max) {
        (false, true) => format!("`[{names}]`, {values}"),
        (false, false) => format!("a list of numbers `[{names}, {names}, …]`, {values}"),
        (true, true) => format!("a list of {min} values, {values}"),
        (true, false) => format!("a list of {min} to {max} values, {values}"),
    }
}

/// The unit as it stands after a number, with a space before it.
fn unit(p: &Param) -> String {
    p.unit.as_deref().filter(|u| *u != "1").map(|u| format!(" {u}")).unwrap_or_default()
}

/// What values a shape takes.
fn range(shape: &Shape, items: &[String], unit: &str) -> String {
    match shape {
        Shape::Number { min, max, .. } => format!("{} to {}{unit}", limit(*min), limit(*max)),
        Shape::Flag => "true or false".into(),
        Shape::Choice(modes) => modes.iter().map(|m| format!("`{}`", m.name)).collect::<Vec<_>>().join(" "),
        Shape::List { item, min, max } => match bare(item) {
            Shape::Number { .. } => list(shape, items, unit),
            _ if min == max => format!("{min} items"),
            _ => format!("{min} to {max} items"),
        },
        Shape::Optional(inner) => format!("{}, or null", range(inner, items, unit)),
        Shape::Text { max_length } => format!("text of at most {max_length} characters"),
        Shape::Record(_) => "object".into(),
        Shape::Tuple(shapes) => {
            let each: Vec<_> = shapes.iter().map(|s| range(s, &[], unit)).collect();
            format!("a list of {}: {}", shapes.len(), each.join("; "))
        }
        Shape::Unknown => String::new(),
    }
}

#[derive(Default)]
struct Table {
    rows: Vec<Row>,
    /// Modes that were described, with the parameter they were described for.
    seen: Vec<(String, Vec<Choice>)>,
}

impl Table {
    fn param(&mut self, prefix: &str, p: &Param) {
        let name = format!("{prefix}{}", p.name);
        let unit = unit(p);
        let default = match &p.default {
            Json::Null if p.required => "required".to_owned(),
            Json::Null => String::new(),
            Json::Object(_) => "see below".to_owned(),
            default => format!("`{default}`{unit}"),
        };
        let mut values = range(&p.shape, &p.items, &unit);
        let modes = match bare(&p.shape) {
            Shape::Choice(modes) => modes.as_slice(),
            _ => &[],
        };
        let told = self.seen.iter().find(|(_, seen)| seen.as_slice() == modes);
        let told = told.filter(|_| modes.iter().any(|m| !m.fields.is_empty())).map(|(name, _)| name.clone());
        if let Some(other) = &told {
            values = format!("as `{other}`");
        }
        self.rows.push(Row { name: name.clone(), default, range: values, doc: p.doc.clone() });
        if told.is_some() {
            return;
        }
        self.seen.push((name.clone(), modes.to_vec()));
        for mode in modes {
            let fields: Vec<_> = mode.fields.iter().map(|f| format!("\"{}\": …", f.name)).collect();
            let written = format!("`{{\"{}\": {{{}}}}}`", mode.name, fields.join(", "));
            let range = if fields.is_empty() { String::new() } else { written };
            let row = format!("{name}: {}", mode.name);
            self.rows.push(Row { name: row, default: String::new(), range, doc: mode.doc.clone() });
            mode.fields.iter().for_each(|f| self.param(&format!("{name}.{}.", mode.name), f));
        }
    }
}
