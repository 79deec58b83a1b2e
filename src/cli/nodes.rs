//! `orograph nodes`: the node reference, from the same structs that run.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::json;

use super::exit::{Exit, Stop, print, print_json};
use crate::node::Kind;
use crate::nodes::Registry;
use crate::params::page::{Row, Section, rows, sections};
use crate::ports::Port;
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
        let all: Vec<_> = registry.iter().map(as_json).collect();
        return print_json(&json!(all));
    }
    print(&list(registry))
}

fn families(registry: &Registry) -> Vec<&'static str> {
    let mut families: Vec<_> = registry.iter().map(|k| k.family).collect();
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

fn as_json(kind: &'static Kind) -> serde_json::Value {
    let ports = |ports: &mut dyn Iterator<Item = &'static Port>| -> serde_json::Value {
        ports
            .map(|p| json!({ "name": p.name, "type": p.wire.name(), "required": p.required, "doc": p.doc }))
            .collect()
    };
    json!({
        "kind": kind.id,
        "family": kind.family,
        "version": kind.meta.version,
        "keywords": kind.meta.keywords,
        "doc": kind.doc(),
        "inputs": ports(&mut kind.inputs()),
        "outputs": ports(&mut kind.outputs.iter()),
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
pub(super) fn page(kind: &'static Kind) -> String {
    let mut page = format!("# {}\n\n`{}`, in the family *{}*.\n\n", title(kind.id), kind.id, kind.family);
    // The headings of the doc comment stand below the title of the page.
    for line in kind.doc().lines() {
        let _ = writeln!(page, "{}{line}", if line.starts_with('#') { "#" } else { "" });
    }
    port_table(&mut page, "Inputs", &mut kind.inputs());
    port_table(&mut page, "Outputs", &mut kind.outputs.iter());
    if !kind.params().is_empty() {
        page += "\n## Parameters\n\n";
        table(&mut page, &rows(kind.params()));
    }
    sections(kind.params()).iter().for_each(|section| inside(&mut page, section));
    if !kind.meta.cite.is_empty() {
        let _ = write!(page, "\n## References\n\nKeys of [references.bib](../references.bib): ");
        let _ = writeln!(page, "{}.", kind.meta.cite.join(", "));
    }
    page
}

fn port_table(page: &mut String, head: &str, ports: &mut dyn Iterator<Item = &'static Port>) {
    let mut rows = ports.peekable();
    if rows.peek().is_none() {
        return;
    }
    let _ = write!(page, "\n## {head}\n\n| name | type | what it is |\n|:--|:--|:--|\n");
    for p in rows {
        let optional = if p.required { "" } else { ", optional" };
        let _ = writeln!(page, "| `{}` | {}{optional} | {} |", p.name, p.wire.name(), cell(p.doc));
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
