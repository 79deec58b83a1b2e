//! The table of formats against the page that people read.

use std::fmt::Write;

use orograph::files::{Codec, Format};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/files.md");

/// What is read, a line a codec.
fn codecs() -> String {
    let mut out = "| extension | what is read | metres | place |\n|---|---|---|---|\n".to_owned();
    for c in Codec::all() {
        let names: Vec<_> = c.extensions.iter().map(|e| format!(".{e}")).collect();
        writeln!(out, "| `{}` | {} | {} | {} |", names.join(" "), c.reads, c.metres, c.place).unwrap();
    }
    out
}

/// What is written, a line a format.
fn forms() -> String {
    let mut out = "| format | holds | sidecar | for |\n|---|---|---|---|\n".to_owned();
    for f in Format::ALL {
        let (form, sidecar) = (f.form(), if f.has_sidecar(1) { "yes" } else { "no" });
        writeln!(out, "| `{}` | {} | {sidecar} | {} |", form.name, form.holds, form.purpose).unwrap();
    }
    out
}

/// The page with a table put between its marks.
fn with(page: &str, mark: &str, table: &str) -> String {
    let (head, rest) = page.split_once(&format!("<!-- {mark}:")).expect("the page has the mark");
    let (line, rest) = rest.split_once('\n').expect("a line");
    let (_, tail) = rest.split_once("<!-- end -->").expect("the mark has an end");
    format!("{head}<!-- {mark}:{line}\n{table}<!-- end -->{tail}")
}

/// The page of files says what the table says. `OROGRAPH_BLESS=1` writes it.
#[test]
fn the_page_of_files_has_the_table_of_formats() {
    let page = std::fs::read_to_string(PAGE).expect("reads");
    let right = with(&with(&page, "codecs", &codecs()), "forms", &forms());
    if std::env::var_os("OROGRAPH_BLESS").is_some() {
        std::fs::write(PAGE, &right).expect("writes");
    } else {
        assert!(
            page == right,
            "docs/files.md is not the table of formats; run this test with OROGRAPH_BLESS=1"
        );
    }
}
