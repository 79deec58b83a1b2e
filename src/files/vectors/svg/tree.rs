//! The elements of a picture, as far as drawing its lines needs them.
//!
//! The text is gone through once by a pull parser, so that reading can be stopped, takes time that follows the length
//! of the text, and keeps no attribute that nobody asks for.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use quick_xml::Reader;
use quick_xml::events::attributes::Attributes;
use quick_xml::events::{BytesStart, Event};

use super::css;
use super::entities::{Between, Entities, TooLong};
use super::scopes::{Scopes, Space};
use super::style::{Look, Looks, Moves, StyleText};
use crate::files::vectors::tally::{Notice, Tally};
use crate::files::vectors::{MAX_ELEMENTS, Wanted, Watch, short, too_many};
use crate::value::curves::CurveError;

/// Elements that hold nothing to draw, with all that stands in them.
const IDLE: [&str; 9] =
    ["style", "script", "metadata", "title", "desc", "filter", "linearGradient", "radialGradient", "font"];

/// Attributes that drawing asks for.
const ASKED: [&str; 29] = [
    "class",
    "cx",
    "cy",
    "d",
    "display",
    "height",
    "href",
    "id",
    "label",
    "points",
    "preserveAspectRatio",
    "r",
    "requiredExtensions",
    "rx",
    "ry",
    "style",
    "systemLanguage",
    "transform",
    "transform-origin",
    "viewBox",
    "visibility",
    "width",
    "x",
    "x1",
    "x2",
    "xlink:href",
    "y",
    "y1",
    "y2",
];

/// The elements of a picture in the order of the file.
#[derive(Debug)]
pub(super) struct Tree<'t> {
    text: &'t str,
    elements: Vec<Element<'t>>,
    attributes: Vec<(&'t str, Cow<'t, str>)>,
    looks: Looks,
}

#[derive(Clone, Copy, Debug)]
struct Element<'t> {
    name: &'t str,
    /// Where it stands in the text, in bytes.
    at: usize,
    /// The element after all that stand in it.
    end: u32,
    /// Its first attribute, and the one after its last.
    attributes: [u32; 2],
}

/// An element of a tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node<'a> {
    tree: &'a Tree<'a>,
    pub(super) index: usize,
}

impl<'t> Tree<'t> {
    /// The elements of a text, whose root is an `svg`.
    ///
    /// # Errors
    /// When the text is no XML, its root is another element, or it is over a limit.
    pub(super) fn parse(
        text: &'t str,
        wanted: &Wanted<'_>,
        watch: &Watch<'_>,
        tally: &mut Tally,
    ) -> Result<Self, CurveError> {
        let mut parser = Parser {
            tree: Self { text, elements: Vec::new(), attributes: Vec::new(), looks: Looks::default() },
            asked: asked(wanted),
            entities: Entities::default(),
            scopes: Scopes::default(),
            open: Vec::new(),
            depth: 0,
            idle: None,
            in_style: false,
            styles: Vec::new(),
            tally,
        };
        parser.all(text, watch)?;
        let Parser { mut tree, styles, tally, .. } = parser;
        tree.looks = Looks::of(&tree, &styles, tally, &|| watch.at(text.len()))?;
        Ok(tree)
    }

    pub(super) fn len(&self) -> usize {
        self.elements.len()
    }

    pub(super) fn node(&self, index: usize) -> Node<'_> {
        Node { tree: self, index }
    }

    /// The line of the text that a place stands in.
    pub(super) fn line(&self, at: usize) -> usize {
        let before = self.text.as_bytes().get(..at).unwrap_or_default();
        1 + before.iter().filter(|b| **b == b'\n').count()
    }

    /// The first element of each `id`.
    pub(super) fn ids(&self) -> BTreeMap<&str, usize> {
        let mut ids = BTreeMap::new();
        for index in 0..self.len() {
            if let Some(id) = self.node(index).attribute("id") {
                ids.entry(id).or_insert(index);
            }
        }
        ids
    }
}

fn asked(wanted: &Wanted<'_>) -> BTreeSet<String> {
    let mut asked: BTreeSet<String> = ASKED.iter().map(|&name| name.to_owned()).collect();
    for name in wanted.names() {
        asked.insert(name.to_owned());
        asked.insert(format!("data-{name}"));
    }
    asked
}

impl<'a> Node<'a> {
    fn element(&self) -> &'a Element<'a> {
        &self.tree.elements[self.index]
    }

    pub(super) fn name(&self) -> &'a str {
        self.element().name
    }

    /// The elements in it, as a range: its children, and all that stand in them.
    pub(super) fn inner(&self) -> std::ops::Range<usize> {
        self.index + 1..self.end()
    }

    /// The element after it and all that stand in it.
    pub(super) fn end(&self) -> usize {
        self.element().end as usize
    }

    pub(super) fn attribute(&self, name: &str) -> Option<&'a str> {
        let [from, to] = self.element().attributes;
        let own = &self.tree.attributes[from as usize..to as usize];
        own.iter().find(|(key, _)| *key == name).map(|(_, value)| &**value)
    }

    /// What styles say of it.
    pub(super) fn look(&self) -> Look {
        self.tree.looks.look(self.index)
    }

    /// How styles move it, where they do.
    pub(super) fn moves(&self) -> Option<&'a Moves> {
        self.tree.looks.moves(self.index)
    }

    /// What it is called in messages.
    pub(super) fn place(&self) -> String {
        let line = self.tree.line(self.element().at);
        match self.attribute("id") {
            Some(id) => format!("{} `{}` in line {line}", short(self.name()), short(id)),
            None => format!("{} in line {line}", short(self.name())),
        }
    }
}

struct Parser<'t, 'm> {
    tree: Tree<'t>,
    asked: BTreeSet<String>,
    entities: Entities,
    scopes: Scopes<'t>,
    /// Elements that are open and kept.
    open: Vec<u32>,
    depth: usize,
    /// Depth of the open element whose content is of no use.
    idle: Option<usize>,
    /// Whether that is a style sheet.
    in_style: bool,
    /// The style sheets, in the order of the file.
    styles: Vec<StyleText>,
    tally: &'m mut Tally,
}

fn not_xml(message: impl std::fmt::Display) -> CurveError {
    CurveError::file("SVG", format!("is not XML: {message}"))
}

impl From<TooLong> for CurveError {
    fn from(_: TooLong) -> Self {
        Self::file("SVG", "has entities in its DOCTYPE that unfold to more than 4 MiB")
    }
}

impl<'t> Parser<'t, '_> {
    fn all(&mut self, text: &'t str, watch: &Watch<'_>) -> Result<(), CurveError> {
        let mut reader = Reader::from_str(text);
        loop {
            let event = reader.read_event();
            let at = reader.buffer_position() as usize;
            watch.at(at)?;
            match event.map_err(|e| not_xml(format!("{e}, at byte {}", reader.error_position())))? {
                Event::Start(tag) => self.start(text, &tag)?,
                Event::Empty(tag) => {
                    self.start(text, &tag)?;
                    self.end();
                }
                Event::End(_) => self.end(),
                Event::DocType(doctype) => {
                    let doctype = doctype.decode().map_err(not_xml)?;
                    self.entities = Entities::declared(&doctype)?;
                }
                Event::GeneralRef(name) => self.reference(&name.decode().map_err(not_xml)?, at)?,
                Event::Text(css) if self.in_style => self.style(&css.decode().map_err(not_xml)?),
                Event::CData(css) if self.in_style => self.style(&css.decode().map_err(not_xml)?),
                Event::PI(told) if told.target() == b"xml-stylesheet" => {
                    self.tally.add(Notice::Style, || "the style sheet of another file".to_owned());
                }
                Event::Text(_) | Event::CData(_) | Event::Comment(_) | Event::Decl(_) | Event::PI(_) => (),
                Event::Eof => break,
            }
        }
        if self.depth > 0 {
            let open = self.open.last().map_or("", |i| self.tree.elements[*i as usize].name);
            return Err(not_xml(format!("`{}` has no end", short(open))));
        }
        if self.tree.elements.is_empty() {
            return Err(not_xml("there is no element"));
        }
        Ok(())
    }

    /// More text of the style sheet that is open.
    fn style(&mut self, text: &str) {
        if let Some(sheet) = self.styles.last_mut() {
            sheet.css.push_str(text);
        }
    }

    /// A reference between elements.
    fn reference(&mut self, name: &str, at: usize) -> Result<(), CurveError> {
        if self.in_style {
            let reference = format!("&{name};");
            let (text, _) = self.entities.unfold(&reference)?;
            self.style(&text);
        } else if self.idle.is_none() {
            let notice = match self.entities.between(name) {
                Between::Text => return Ok(()),
                Between::Markup => Notice::Markup,
                Between::Nothing => Notice::Entity,
            };
            self.tally.add(notice, || format!("`&{};` at byte {at}", short(name)));
        }
        Ok(())
    }

    fn start(&mut self, text: &'t str, tag: &BytesStart<'t>) -> Result<(), CurveError> {
        self.depth += 1;
        if self.idle.is_some() {
            return Ok(());
        }
        // The parser hands out slices of the text itself: their place is where they stand in it.
        let at = (tag.as_ptr() as usize).wrapping_sub(text.as_ptr() as usize);
        let Some(tag_text) = text.get(at..at.saturating_add(tag.len())) else {
            return Err(not_xml("a tag is not part of the text"));
        };
        let full = tag_text.get(..tag.name().as_ref().len()).unwrap_or_default();
        let (prefix, name) = full.split_once(':').unwrap_or(("", full));
        let first = self.tree.attributes.len();
        self.attributes(tag_text, full.len())?;
        let space = self.scopes.of(prefix);
        let root = self.tree.elements.is_empty();
        if root && name != "svg" {
            let message = format!("must be an `svg` element, got `{}`", short(name));
            return Err(CurveError::file("SVG", message));
        }
        if !root && (space == Space::Other || IDLE.contains(&name)) {
            self.tree.attributes.truncate(first);
            self.idle = Some(self.depth);
            if space == Space::Picture && name == "style" {
                self.style_sheet(tag_text, full.len(), at)?;
            }
            return Ok(());
        }
        too_many("elements of the picture", MAX_ELEMENTS, self.tree.elements.len() + 1)?;
        let attributes = [first as u32, self.tree.attributes.len() as u32];
        self.open.push(self.tree.elements.len() as u32);
        self.tree.elements.push(Element { name, at, end: 0, attributes });
        Ok(())
    }

    /// Keeps the attributes that somebody asks for, and takes up namespaces.
    fn attributes(&mut self, tag: &'t str, name: usize) -> Result<(), CurveError> {
        let first = self.tree.attributes.len();
        // The parser's own look for doubles is quadratic; here the first of a name counts.
        for attribute in Attributes::new(tag, name).with_checks(false) {
            let attribute = attribute.map_err(not_xml)?;
            let key = slice(tag, attribute.key.as_ref());
            let raw = slice(tag, &attribute.value);
            let (prefix, local) = key.split_once(':').unwrap_or(("", key));
            if prefix == "xmlns" || key == "xmlns" {
                let (value, _) = self.entities.unfold(raw)?;
                self.scopes.declare(self.depth, if prefix.is_empty() { "" } else { local }, &value);
                continue;
            }
            let key = match (prefix, local) {
                ("", _) => key,
                (_, "label") => "label",
                (_, "href") => "xlink:href",
                _ => continue,
            };
            if !self.asked.contains(key) || self.tree.attributes[first..].iter().any(|(k, _)| *k == key) {
                continue;
            }
            let (value, unfolded) = self.entities.unfold(raw)?;
            if unfolded.unknown {
                self.tally.add(Notice::Entity, || format!("in `{}=\"{}\"`", short(key), short(raw)));
            }
            self.tree.attributes.push((key, value));
        }
        Ok(())
    }

    /// Begins a style sheet, where it may hold for what is drawn here.
    fn style_sheet(&mut self, tag: &'t str, name: usize, at: usize) -> Result<(), CurveError> {
        let (mut is_css, mut holds) = (true, Some(true));
        for attribute in Attributes::new(tag, name).with_checks(false) {
            let attribute = attribute.map_err(not_xml)?;
            let value = slice(tag, &attribute.value);
            match attribute.key.as_ref() {
                b"type" => {
                    // Parameters may follow, as the encoding.
                    let kind = value.split(';').next().unwrap_or_default().trim();
                    is_css = kind.is_empty() || kind.eq_ignore_ascii_case("text/css");
                }
                b"media" => holds = css::is_for_screen(value),
                _ => (),
            }
        }
        self.in_style = is_css && holds != Some(false);
        if self.in_style {
            self.styles.push(StyleText { at, css: String::new(), holds: holds == Some(true) });
        }
        Ok(())
    }

    fn end(&mut self) {
        self.scopes.leave(self.depth);
        match self.idle {
            Some(depth) if depth == self.depth => (self.idle, self.in_style) = (None, false),
            Some(_) => (),
            None => {
                if let Some(index) = self.open.pop() {
                    self.tree.elements[index as usize].end = self.tree.elements.len() as u32;
                }
            }
        }
        self.depth = self.depth.saturating_sub(1);
    }
}

/// The part of a text that a slice of its bytes is.
fn slice<'t>(text: &'t str, part: &[u8]) -> &'t str {
    let at = (part.as_ptr() as usize).wrapping_sub(text.as_ptr() as usize);
    text.get(at..at.saturating_add(part.len())).unwrap_or_default()
}
