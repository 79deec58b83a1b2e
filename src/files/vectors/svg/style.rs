//! Styles, as far as they say whether and where lines are drawn: `style` attributes, and the rules of style sheets whose
//! selectors are an element, a class, an `id`, `*` or several of these about one element.
//!
//! They are taken up once an element, before anything is drawn, so that drawing an element again takes no reading. Each
//! way in which elements are moved is kept once.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::css;
use super::sheet::{DISPLAY, FRAME, GoOn, ORIGIN, READ, StyleSheet, TRANSFORM, VISIBILITY, Value, Values};
use super::tree::Tree;
use crate::files::vectors::tally::{Notice, Tally};
use crate::value::curves::CurveError;

/// Most bytes of all style sheets of a picture, fonts in them counted.
const MAX_SHEETS: usize = 8 << 20;
/// Longest value of a property, in bytes.
const MAX_VALUE: usize = 256;

/// A style sheet as the picture has it.
#[derive(Debug)]
pub(super) struct StyleText {
    /// Where it stands in the picture, in bytes.
    pub(super) at: usize,
    pub(super) css: String,
    /// Whether it holds on a screen, whatever that is like.
    pub(super) holds: bool,
}

/// What styles say of the elements of a tree.
#[derive(Debug, Default)]
pub(super) struct Looks {
    /// That of each element, and which of the moves is its own.
    each: Vec<(Look, u32)>,
    /// Each once; the first moves nothing.
    moves: Vec<Moves>,
}

/// What styles say of an element.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Look {
    /// It is not drawn, with all in it.
    pub(super) hidden: bool,
    /// Whether its lines show; none where it is as outside.
    pub(super) visible: Option<bool>,
}

/// How styles move an element.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Moves {
    /// The value of `transform`, which counts before the attribute.
    pub(super) transform: Option<Box<str>>,
    pub(super) origin: Option<Box<str>>,
    /// The value of `transform-box`.
    pub(super) frame: Option<Box<str>>,
}

impl Looks {
    /// Those of all elements, by their attributes and the style sheets of the picture.
    ///
    /// # Errors
    /// When the work was asked to stop.
    pub(super) fn of(
        tree: &Tree<'_>,
        texts: &[StyleText],
        tally: &mut Tally,
        go_on: &GoOn<'_>,
    ) -> Result<Self, CurveError> {
        let texts = without_comments(tree, texts, tally, go_on)?;
        let mut sheet = StyleSheet::default();
        for (at, css) in &texts {
            sheet.read(css, &|| tree.line(*at), tally, go_on)?;
        }
        let mut looks = Self { each: Vec::with_capacity(tree.len()), moves: vec![Moves::default()] };
        let mut known = BTreeMap::from([([None; 3], 0)]);
        for index in 0..tree.len() {
            go_on()?;
            let values = sheet.values(&tree.node(index), tally, go_on)?;
            let fits = |said: &Value<'_>| said.value.len() <= MAX_VALUE;
            if let Some(long) = values.iter().flatten().find(|said| !fits(said)) {
                tally.add(Notice::Style, || format!("a value of {} bytes", long.value.len()));
            }
            let moved = [TRANSFORM, ORIGIN, FRAME].map(|p| values[p].filter(fits).map(|said| said.value));
            let which = *known.entry(moved).or_insert_with(|| {
                let [transform, origin, frame] = moved.map(|text| text.map(Box::from));
                looks.moves.push(Moves { transform, origin, frame });
                looks.moves.len() as u32 - 1
            });
            looks.each.push((look(&values), which));
        }
        Ok(looks)
    }

    pub(super) fn look(&self, index: usize) -> Look {
        self.each.get(index).map(|(look, _)| *look).unwrap_or_default()
    }

    pub(super) fn moves(&self, index: usize) -> Option<&Moves> {
        let (_, which) = self.each.get(index)?;
        self.moves.get(*which as usize).filter(|_| *which > 0)
    }
}

/// The sheets that are read, without their comments, each with its place.
fn without_comments<'s>(
    tree: &Tree<'_>,
    texts: &'s [StyleText],
    tally: &mut Tally,
    go_on: &GoOn<'_>,
) -> Result<Vec<(usize, Cow<'s, str>)>, CurveError> {
    let (mut plain, mut left) = (Vec::new(), MAX_SHEETS);
    for text in texts {
        go_on()?;
        let called = || format!("the style sheet in line {}", tree.line(text.at));
        if text.css.len() > left {
            let what = || format!("{}, with which they are more than {MAX_SHEETS} bytes", called());
            tally.add(Notice::Style, what);
            continue;
        }
        left -= text.css.len();
        if !text.holds {
            if css::speaks_of(&text.css, &READ) {
                tally.add(Notice::Style, || format!("{}, which is for some media alone", called()));
            }
            continue;
        }
        let (css, swallowed) = css::without_comments(&text.css);
        if css::speaks_of(swallowed, &READ) {
            tally.add(Notice::Unclosed, || format!("a comment of {}", called()));
        }
        plain.push((text.at, css));
    }
    Ok(plain)
}

fn look(values: &Values<'_>) -> Look {
    let is = |property: usize, word: &str| {
        values[property].is_some_and(|said| said.value.eq_ignore_ascii_case(word))
    };
    let hides = is(VISIBILITY, "hidden") || is(VISIBILITY, "collapse");
    let visible = (hides || is(VISIBILITY, "visible")).then_some(!hides);
    Look { hidden: is(DISPLAY, "none"), visible }
}
