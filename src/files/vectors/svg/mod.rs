//! Lines of SVG pictures.

mod arc;
mod css;
mod entities;
mod moves;
mod pen;
mod place;
mod scopes;
mod shape;
mod sheet;
mod style;
mod tree;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::pen::Pen;
use self::place::{Affine, Along, ViewBox, Viewport, page};
use self::tree::{Node, Tree};
use super::collect::Collector;
use super::mapping::Line;
use super::tally::Notice;
use super::{GoOn, Imported, MAX_ELEMENTS, Property, Wanted, Watch, check_size, decode, short, too_many};
use crate::value::Bounds;
use crate::value::curves::CurveError;
use crate::value::curves::bezier::Point;

/// How the picture comes to lie on the terrain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Fit {
    /// As large as fits, in the middle, in true proportions.
    #[default]
    Inside,
    /// Edge to edge, each side with a scale of its own.
    Stretch,
}

/// All lines and shapes of a picture whose page is laid on a rectangle of the terrain, as curves or as they are; each
/// subpath is one.
///
/// The page is as large as `width` and `height` say, in units of a fixed length, else as the view box; the
/// view box lies in it as `preserveAspectRatio` says. Transforms count, and so do inner `svg`, `use`, `symbol` and `switch`. What is not
/// displayed is left out, be it by an attribute, a style or a simple rule of a style sheet; styles count for display,
/// visibility and transforms alone, and nothing is clipped. Entities of the file's own DOCTYPE are unfolded,
/// others stand for nothing: no other file is ever read.
///
/// # Errors
/// When the text is no picture, its page has no size, it is over a limit, or the work was asked to stop.
pub fn read<'a>(
    bytes: &[u8],
    onto: Bounds,
    fit: Fit,
    wanted: impl Into<Wanted<'a>>,
    go_on: &GoOn<'_>,
) -> Result<Imported, CurveError> {
    let wanted = wanted.into();
    check_size(bytes)?;
    let text = decode::text(bytes).map_err(|e| CurveError::file("SVG", e))?;
    // What `use` draws again is in the file once: a small file may become this much more.
    let most = text.len() / 2 + MAX_REPEATED;
    let mut collector = Collector::new(wanted, onto, most);
    let parsing = |share: f32| go_on(0.3 * share);
    let tree = Tree::parse(&text, &wanted, &Watch::new(&parsing, text.len()), &mut collector.tally)?;
    let drawing = |share: f32| go_on(0.3 + 0.7 * share);
    let drawing = Watch::new(&drawing, tree.len());
    let root = tree.node(0);
    if root.attribute("transform").is_some() || root.moves().is_some_and(|said| said.transform.is_some()) {
        collector.tally.add(Notice::Style, || "`transform` of the whole picture".to_owned());
    }
    let (placed, view) = placement(&root, onto, fit)?;
    let mut artist = Artist { tree: &tree, ids: tree.ids(), collector, uses: Vec::new(), visits: 0 };
    artist.all(placed, view, &drawing)?;
    artist.collector.finish(Vec::new())
}

/// Most positions of a picture beyond those that stand in its text.
const MAX_REPEATED: usize = 1 << 17;
/// How deep `use` may stand in what `use` draws.
const MAX_USES: usize = 32;

/// Lays the page on the rectangle.
fn placement(root: &Node<'_>, onto: Bounds, fit: Fit) -> Result<(Affine, Viewport), CurveError> {
    let bad = |message: String| CurveError::file("svg", message);
    let view = ViewBox::of_node(root).map_err(bad)?;
    let size = page(root, view).map_err(bad)?;
    let [width, height] = size;
    let (mut sx, mut sy) = (onto.width() / width, onto.depth() / height);
    if fit == Fit::Inside {
        (sx, sy) = (sx.min(sy), sx.min(sy));
    }
    let middle = |k: usize| 0.5 * (onto.min[k] + onto.max[k]);
    let page = Affine([sx, 0.0, 0.0, sy, middle(0) - 0.5 * sx * width, middle(1) - 0.5 * sy * height]);
    let inner = view.map_or(page, |view| page.after(&view.fitted(root, size)));
    if inner.0.iter().all(|v| v.is_finite()) && sx > 0.0 && sy > 0.0 {
        return Ok((inner, Viewport(view.map_or(size, |view| view.size))));
    }
    Err(bad(format!("its page of {width} x {height} cannot be laid on {onto:?}")))
}

/// Draws the elements of a tree: hands the lines to the collector.
struct Artist<'a> {
    tree: &'a Tree<'a>,
    ids: BTreeMap<&'a str, usize>,
    collector: Collector<'a>,
    uses: Vec<Use>,
    visits: usize,
}

/// A `use` that is being drawn.
#[derive(Clone, Copy)]
struct Use {
    element: usize,
    target: usize,
    /// The `use` in whose target it stands.
    within: Option<usize>,
    depth: usize,
}

/// What holds for the elements inside another.
#[derive(Clone, Copy)]
struct Setting {
    placed: Affine,
    view: Viewport,
    visible: bool,
    /// The `use` that draws them.
    by: Option<usize>,
}

/// Elements that are still to be drawn, one beside the other.
struct Row {
    next: usize,
    end: usize,
    setting: Setting,
    /// Whether only the first of those inside a `switch` is drawn.
    first_only: bool,
}

/// Elements that are not drawn where they stand.
const HIDDEN: [&str; 6] = ["defs", "symbol", "clipPath", "mask", "marker", "pattern"];

impl Artist<'_> {
    /// Goes through the elements without recursion, so that no nesting is too deep.
    fn all(&mut self, placed: Affine, view: Viewport, watch: &Watch<'_>) -> Result<(), CurveError> {
        let root = self.tree.node(0);
        let setting = Setting { placed, view, visible: is_visible(&root, true), by: None };
        let mut rows = vec![row(root.inner(), setting)];
        if !is_displayed(&root) {
            rows.clear();
        }
        while let Some(row) = rows.last_mut() {
            if row.next >= row.end {
                rows.pop();
                continue;
            }
            let node = self.tree.node(row.next);
            let setting = row.setting;
            row.next = node.end();
            watch.at(node.index)?;
            self.visits += 1;
            too_many("elements drawn, those of `use` counted", MAX_ELEMENTS, self.visits)?;
            // Of a `switch` the element that stands for a foreign one is drawn.
            if !is_displayed(&node) || (row.first_only && node.name() == "foreignObject") {
                continue;
            }
            if row.first_only {
                row.next = row.end;
            }
            match self.element(&node, &setting, watch) {
                Ok(inner) => rows.extend(inner),
                Err(Fault::Here(notice, message)) => {
                    self.collector.tally.add(notice, || format!("{}: {message}", node.place()));
                }
                Err(Fault::Stop(error)) => return Err(error),
            }
        }
        Ok(())
    }

    /// Draws an element; gives what stands in it and is to be drawn.
    fn element(&mut self, node: &Node<'_>, outer: &Setting, watch: &Watch<'_>) -> Result<Option<Row>, Fault> {
        let name = node.name();
        // A symbol is drawn where a `use` names it, and nowhere else.
        let target = outer.by.is_some_and(|by| self.uses[by].target == node.index);
        if HIDDEN.contains(&name) && !(target && name == "symbol") {
            return Ok(None);
        }
        let visible = is_visible(node, outer.visible);
        let setting = Setting {
            placed: outer.placed.of_node(node, outer.view).map_err(unreadable)?,
            visible,
            ..*outer
        };
        match name {
            "svg" | "symbol" => self.viewport(node, &setting, target).map(Some),
            "use" => self.used(node, &setting),
            "path" | "polyline" | "polygon" | "line" | "rect" | "circle" | "ellipse" if visible => {
                self.lines(node, &setting, watch).map(|()| None)
            }
            "text" | "image" | "foreignObject" => {
                let what = format!("`{name}` holds no line");
                Err(Fault::Here(Notice::NoLine, what))
            }
            _ => Ok(Some(Row { first_only: name == "switch", ..row(node.inner(), setting) })),
        }
    }

    /// The inside of an `svg` or `symbol`: a rectangle with user units of its own.
    fn viewport(&self, node: &Node<'_>, setting: &Setting, target: bool) -> Result<Row, Fault> {
        let outer = setting.view;
        // A `use` sets the size of what it names.
        let by = setting.by.filter(|_| target).map(|by| self.tree.node(self.uses[by].element));
        let length = |name: &str, along: Along, whole: f64| -> Result<f64, Fault> {
            let given = match by.map(|by| outer.length(&by, name, along)).transpose().map_err(unreadable)? {
                Some(Some(length)) => Some(length),
                _ => outer.length(node, name, along).map_err(unreadable)?,
            };
            Ok(given.unwrap_or(whole))
        };
        let own = |name: &str, along: Along| outer.length(node, name, along).map_err(unreadable);
        let x = own("x", Along::Width)?.unwrap_or(0.0);
        let y = own("y", Along::Height)?.unwrap_or(0.0);
        let size = [length("width", Along::Width, outer.0[0])?, length("height", Along::Height, outer.0[1])?];
        if !(size[0] > 0.0 && size[1] > 0.0) {
            return Ok(row(0..0, *setting));
        }
        let placed = setting.placed.after(&Affine::shift(x, y));
        let (placed, view) = match ViewBox::of_node(node).map_err(unreadable)? {
            Some(view) => (placed.after(&view.fitted(node, size)), Viewport(view.size)),
            None => (placed, Viewport(size)),
        };
        Ok(row(node.inner(), Setting { placed, view, ..*setting }))
    }

    /// What a `use` names, moved to its place.
    fn used(&mut self, node: &Node<'_>, setting: &Setting) -> Result<Option<Row>, Fault> {
        let nothing = |message: String| Err(Fault::Here(Notice::Use, message));
        let Some(name) = node.attribute("href").or(node.attribute("xlink:href")) else {
            return nothing("names nothing".into());
        };
        let Some(&target) = name.trim().strip_prefix('#').and_then(|id| self.ids.get(id)) else {
            return nothing(format!("names `{}`, which is no element of this file", short(name)));
        };
        let depth = setting.by.map_or(0, |by| self.uses[by].depth + 1);
        let mut within = setting.by;
        while let Some(by) = within {
            if self.uses[by].target == target {
                return nothing(format!("`{}` draws itself", short(name)));
            }
            within = self.uses[by].within;
        }
        // Inside of what it names is a cycle, too.
        if self.tree.node(target).inner().contains(&node.index) {
            return nothing(format!("`{}` draws itself", short(name)));
        }
        if depth >= MAX_USES {
            return nothing(format!("stands {MAX_USES} deep in others"));
        }
        let length = |name: &str, along: Along| {
            setting.view.length(node, name, along).map(|l| l.unwrap_or(0.0)).map_err(unreadable)
        };
        let (x, y) = (length("x", Along::Width)?, length("y", Along::Height)?);
        self.uses.push(Use { element: node.index, target, within: setting.by, depth });
        let by = Some(self.uses.len() - 1);
        let placed = setting.placed.after(&Affine::shift(x, y));
        Ok(Some(row(target..self.tree.node(target).end(), Setting { placed, by, ..*setting })))
    }

    /// Hands over the lines of an element.
    fn lines(&mut self, node: &Node<'_>, setting: &Setting, watch: &Watch<'_>) -> Result<(), Fault> {
        let name = node.name();
        let (lines, fault) = match name {
            "path" => {
                let mut segments = 0_usize;
                let collector = &mut self.collector;
                Pen::draw(node.attribute("d").unwrap_or_default(), || {
                    segments += 1;
                    if segments.is_multiple_of(64) {
                        watch.at(node.index)?;
                    }
                    collector.count(1)
                })?
            }
            "polyline" | "polygon" => {
                let (line, fault) =
                    shape::polyline(node.attribute("points").unwrap_or_default(), name == "polygon");
                self.collector.count(line.len() / 3 + 1)?;
                (vec![line], fault)
            }
            _ => {
                self.collector.count(2)?;
                (shape::outline(node, setting.view).map_err(unreadable)?.into_iter().collect(), None)
            }
        };
        let broken = fault.is_some();
        if let Some(fault) = fault {
            self.collector.tally.add(Notice::Broken, || format!("{}: {fault}", node.place()));
        }
        let by = setting.by.map(|by| self.tree.node(self.uses[by].element));
        // A subpath that is a move alone draws nothing, and is no fault where others do.
        let before = lines.len();
        let lines: Vec<_> = lines.into_iter().filter(|line| line.len() > 3).collect();
        if lines.is_empty() && !broken && (before > 0 || name != "path") {
            self.collector.tally.add(Notice::Pointlike, || node.place());
        }
        for line in lines {
            self.line(node, by.as_ref(), line, &setting.placed);
        }
        Ok(())
    }

    fn line(&mut self, node: &Node<'_>, by: Option<&Node<'_>>, line: Vec<Point>, placed: &Affine) {
        let place = || node.place();
        let knots: Vec<Point> = line.into_iter().map(|p| placed.apply(p)).collect();
        if knots.iter().all(|p| *p == knots[0]) {
            self.collector.tally.add(Notice::Pointlike, place);
            return;
        }
        let called = |node: &Node<'_>| {
            let name = node.attribute("label").or(node.attribute("id"));
            name.filter(|name| !name.is_empty()).map(short)
        };
        let name = called(node).or_else(|| by.and_then(called)).unwrap_or_default();
        // What the element does not say itself the `use` that draws it may say.
        let property = |key: &str| match property(node, key)? {
            None => by.map_or(Ok(None), |by| property(by, key)),
            own => Ok(own),
        };
        self.collector.take(Line { name, knots, z: Vec::new(), property: &property }, place);
    }
}

fn row(elements: std::ops::Range<usize>, setting: Setting) -> Row {
    Row { next: elements.start, end: elements.end, setting, first_only: false }
}

/// Why an element is not drawn.
enum Fault {
    /// It is left out, with all in it.
    Here(Notice, String),
    /// The work stops.
    Stop(CurveError),
}

impl From<CurveError> for Fault {
    fn from(error: CurveError) -> Self {
        Self::Stop(error)
    }
}

fn unreadable(message: String) -> Fault {
    Fault::Here(Notice::Attribute, message)
}

/// Whether an element is drawn at all, with what stands in it.
fn is_displayed(node: &Node<'_>) -> bool {
    let asks_for_more = node.attribute("requiredExtensions").is_some_and(|e| !e.trim().is_empty());
    let speaks = |languages: &str| {
        languages.split(',').any(|l| l.trim().split('-').next().is_some_and(|l| l.eq_ignore_ascii_case("en")))
    };
    let foreign = node.attribute("systemLanguage").is_some_and(|languages| !speaks(languages));
    !node.look().hidden && !asks_for_more && !foreign
}

/// Whether the lines of an element show, unless an element in it says otherwise.
fn is_visible(node: &Node<'_>, outer: bool) -> bool {
    node.look().visible.unwrap_or(outer)
}

fn property(node: &Node<'_>, key: &str) -> Result<Option<Property>, String> {
    let Some(text) = node.attribute(&format!("data-{key}")).or(node.attribute(key)) else {
        return Ok(None);
    };
    let words = text.split([',', ' ', ';', '\t', '\n', '\r']).filter(|t| !t.is_empty());
    let numbers = words.map(|t| {
        let number = t.parse::<f64>().ok().filter(|v| v.is_finite());
        number.ok_or_else(|| format!("property `{key}` must be numbers, got \"{}\"", short(text)))
    });
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
    Ok(match numbers.as_slice() {
        [] => None,
        [one] => Some(Property::Number(*one)),
        _ => Some(Property::List(numbers)),
    })
}
