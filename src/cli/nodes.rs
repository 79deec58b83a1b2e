//! `orograph nodes`: the node reference, from the same structs that run.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::exit::{Exit, Stop, print, print_json};
use crate::name::Name;
use crate::node::Kind;
use crate::nodes::Registry;
use crate::params::page::{Row, Section, rows, sections};
use crate::ports::{Meaning, Port};
use crate::whole::{self, Known};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// One kind; all when left out
    kind: Option<String>,
    /// Prints JSON
    #[arg(long)]
    pub(super) json: bool,
    /// Writes one Markdown page a kind, and an index, into a folder
    #[arg(long, value_name = "DIR", conflicts_with_all = ["kind", "json"])]
    docs: Option<PathBuf>,
}

pub(super) fn run(args: &Args, registry: &Registry) -> Result<Exit, Stop> {
    if let Some(folder) = &args.docs {
        return write_pages(folder, registry);
    }
    if let Some(id) = &args.kind {
        let kind = registry.find(id);
        let kind =
            kind.ok_or_else(|| Stop::usage(format!("there is no kind `{id}`{}", registry.suggest(id))))?;
        return if args.json { print_json(&as_json(kind)) } else { print(&page(kind)) };
    }
    if args.json {
        let all: Vec<_> = registry.iter().map(|kind| as_json(kind)).collect();
        return print_json(&json!(all));
    }
    print(&list(registry))
}

fn families(registry: &Registry) -> Vec<&str> {
    let mut families: Vec<_> = registry.iter().map(|k| k.family.as_str()).collect();
    families.sort_unstable();
    families.dedup();
    families
}

fn list(registry: &Registry) -> String {
    let mut text = String::new();
    for family in families(registry) {
        let _ = writeln!(text, "{family}");
        for kind in registry.iter().filter(|k| k.family == family) {
            let _ = writeln!(text, "  {:20} {}", kind.id, kind.summary());
        }
    }
    text
}

fn as_json(kind: &Kind) -> serde_json::Value {
    let port = |p: &Port| {
        let (name, doc) = (p.name.as_str(), p.doc.as_str());
        json!({ "name": name, "type": p.wire.name(), "required": p.required, "doc": doc })
    };
    let output = |p: &Port| {
        let mut output = port(p);
        output["quantity"] = quantity(p).into();
        output
    };
    let names = |all: &[Name]| all.iter().map(Name::to_string).collect::<Vec<_>>();
    json!({
        "kind": kind.id.as_str(),
        "family": kind.family.as_str(),
        "version": kind.version,
        "keywords": names(&kind.keywords),
        "doc": kind.doc(),
        "inputs": kind.inputs.iter().map(port).collect::<Vec<_>>(),
        "outputs": kind.outputs.iter().map(output).collect::<Vec<_>>(),
        "parameters": kind.schema(),
    })
}

/// `fractal_noise` as "Fractal noise".
fn title(id: &str) -> String {
    let text = id.replace('_', " ");
    let mut chars = text.chars();
    chars.next().map(|c| c.to_uppercase().chain(chars).collect()).unwrap_or_default()
}

/// The manual page of a kind in Markdown.
pub(super) fn page(kind: &Kind) -> String {
    let mut page = format!("# {}\n\n`{}`, in the family *{}*.\n\n", title(&kind.id), kind.id, kind.family);
    // The headings of the doc comment stand below the title of the page.
    for line in kind.doc().lines() {
        let _ = writeln!(page, "{}{line}", if line.starts_with('#') { "#" } else { "" });
    }
    input_table(&mut page, &kind.inputs);
    output_table(&mut page, &kind.outputs);
    if !kind.params().is_empty() {
        page += "\n## Parameters\n\n";
        table(&mut page, &rows(kind.params()));
    }
    sections(kind.params()).iter().for_each(|section| inside(&mut page, section));
    if !kind.cite.is_empty() {
        let _ = write!(page, "\n## References\n\nKeys of [references.bib](../references.bib): ");
        let _ = writeln!(page, "{}.", kind.cite.join(", "));
    }
    page
}

fn input_table(page: &mut String, ports: &[Port]) {
    if ports.is_empty() {
        return;
    }
    *page += "\n## Inputs\n\n| name | type | what it is |\n|:--|:--|:--|\n";
    for p in ports {
        let optional = if p.required { "" } else { ", optional" };
        let _ = writeln!(page, "| `{}` | {}{optional} | {} |", p.name, p.wire.name(), cell(&p.doc));
    }
}

fn output_table(page: &mut String, ports: &[Port]) {
    *page += "\n## Outputs\n\n| name | type | numbers | what it is |\n|:--|:--|:--|:--|\n";
    for p in ports {
        let optional = if p.required { "" } else { ", optional" };
        let (wire, numbers) = (p.wire.name(), quantity(p));
        let _ = writeln!(page, "| `{}` | {wire}{optional} | {numbers} | {} |", p.name, cell(&p.doc));
    }
}

/// What the numbers of an output mean, as far as its port says so.
fn quantity(port: &Port) -> String {
    match &port.meaning {
        Meaning::Fixed(quantity) => quantity.described(),
        Meaning::Like(input) => format!("as `{input}`"),
        Meaning::Chosen => "by parameters and inputs".to_owned(),
        Meaning::Nothing => String::new(),
    }
}

fn table(page: &mut String, rows: &[Row]) {
    *page += "| name | default | range | what it does |\n|:--|:--|:--|:--|\n";
    for Row { name, default, range, doc } in rows {
        let _ = writeln!(page, "| `{name}` | {default} | {range} | {} |", cell(doc));
    }
}

/// What stands in a list or an object.
fn inside(page: &mut String, section: &Section) {
    let _ = write!(page, "\n### In `{}`\n\n{}\n", section.name, section.form);
    if !section.rows.is_empty() {
        page.push('\n');
        table(page, &section.rows);
    }
    if !section.example.is_null() {
        let _ = write!(page, "\n```json\n{}\n```\n", section.example);
    }
}

/// A text on one line of a table.
fn cell(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|")
}

fn write_pages(folder: &Path, registry: &Registry) -> Result<Exit, Stop> {
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        whole::save(&path, text.as_bytes(), Known::Anything)
            .map_err(|e| Stop::new(Exit::Failed, format!("cannot write {}: {e}", path.display())))
    };
    std::fs::create_dir_all(folder)
        .map_err(|e| Stop::new(Exit::Failed, format!("{}: {e}", folder.display())))?;
    let mut index = String::from("# Nodes\n\nMade by `orograph nodes --docs`; do not edit.\n");
    for family in families(registry) {
        let _ = write!(index, "\n## {}\n\n", title(family));
        for kind in registry.iter().filter(|k| k.family == family) {
            let _ = writeln!(index, "- [{}]({}.md): {}", kind.id, kind.id, kind.summary());
            write(&format!("{}.md", kind.id), &page(kind))?;
        }
    }
    write("README.md", &index)?;
    Ok(Exit::Done)
}
