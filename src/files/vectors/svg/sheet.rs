//! What the rules of style sheets and the styles of elements say of the properties that are read, and which of it counts.
//!
//! What a block says is kept once, whatever its selectors.

use std::collections::{BTreeMap, BTreeSet};

use super::css::{self, Declaration, Rule, Selector, Simple};
use super::tree::Node;
use crate::files::vectors::short;
use crate::files::vectors::tally::{Notice, Tally};
use crate::value::curves::CurveError;

/// Properties that are read.
pub(super) const READ: [&str; 5] =
    ["display", "visibility", "transform", "transform-origin", "transform-box"];
pub(super) const DISPLAY: usize = 0;
pub(super) const VISIBILITY: usize = 1;
pub(super) const TRANSFORM: usize = 2;
pub(super) const ORIGIN: usize = 3;
pub(super) const FRAME: usize = 4;
/// Properties that place or shape lines, too, and are not read.
const UNREAD: [&str; 14] = [
    "translate",
    "rotate",
    "scale",
    "offset-path",
    "d",
    "cx",
    "cy",
    "r",
    "rx",
    "ry",
    "x",
    "y",
    "width",
    "height",
];
/// Rules at an `@` that say nothing of elements.
const IDLE: [&str; 7] =
    ["charset", "namespace", "font-face", "page", "keyframes", "-webkit-keyframes", "counter-style"];
/// Most selectors that are kept: they take some hundred bytes each, and their blocks as much again.
const MAX_SELECTORS: usize = 1 << 16;
/// Most selectors about several things of one element at once, as `path.a`.
const MAX_COMPOUNDS: usize = 64;

/// Asks whether to go on.
pub(super) type GoOn<'a> = dyn Fn() -> Result<(), CurveError> + 'a;

/// A value that holds for an element, and how much it counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Value<'s> {
    pub(super) value: &'s str,
    /// Whether it is important, then how near it is to the element, then how late it stands.
    weight: (bool, u32, u32),
}

/// Values by property that is read.
pub(super) type Values<'s> = [Option<Value<'s>>; READ.len()];

/// Takes up a value where none that counts more is there.
fn put<'s>(values: &mut Values<'s>, property: usize, said: Value<'s>) {
    if values[property].is_none_or(|known| known.weight <= said.weight) {
        values[property] = Some(said);
    }
}

/// The weight of a `style` attribute, above that of every selector.
const OWN: u32 = u32::MAX;

/// What a block says of each property that is read: the value, and whether it is important.
type Block<'s> = [Option<(&'s str, bool)>; READ.len()];

/// For each property the block that says it, by its number.
type Sources = [u32; READ.len()];

/// The rules of the style sheets of a picture.
#[derive(Debug)]
pub(super) struct StyleSheet<'s> {
    /// In the order of the file; the first says nothing.
    blocks: Vec<Block<'s>>,
    simple: BTreeMap<Simple<'s>, Sources>,
    compound: Vec<(Selector<'s>, Sources)>,
    /// What stands in selectors of several parts.
    parts: BTreeSet<Simple<'s>>,
    /// Selectors that are kept.
    kept: usize,
}

impl Default for StyleSheet<'_> {
    fn default() -> Self {
        let (simple, compound, parts) = (BTreeMap::new(), Vec::new(), BTreeSet::new());
        Self { blocks: vec![Block::default()], simple, compound, parts, kept: 0 }
    }
}

impl<'s> StyleSheet<'s> {
    /// Takes up the rules of a sheet that stands in a line.
    pub(super) fn read(
        &mut self,
        css: &'s str,
        line: &dyn Fn() -> usize,
        tally: &mut Tally,
        go_on: &GoOn<'_>,
    ) -> Result<(), CurveError> {
        for rule in css::rules(css) {
            go_on()?;
            let mut all = [rule.head, rule.block.unwrap_or_default()].into_iter();
            if !rule.is_closed && all.any(|text| css::speaks_of(text, &READ)) {
                tally.add(Notice::Unclosed, || {
                    format!("`{}` of the style sheet in line {}", short(rule.head), line())
                });
            }
            match (rule.head.strip_prefix('@'), rule.block) {
                (Some(words), block) => at_rule(words, block.unwrap_or_default(), tally),
                (None, Some(block)) => self.take(rule, block, tally, go_on)?,
                (None, None) => (),
            }
        }
        Ok(())
    }

    /// Takes up the block of a rule: what it says is kept once, and its selectors name it.
    fn take(
        &mut self,
        rule: Rule<'s>,
        block: &'s str,
        tally: &mut Tally,
        go_on: &GoOn<'_>,
    ) -> Result<(), CurveError> {
        let said = said(block, tally, go_on)?;
        if said == Block::default() {
            return Ok(());
        }
        let (number, before) = (self.blocks.len() as u32, self.kept);
        self.blocks.push(said);
        for text in css::selectors(rule.head) {
            go_on()?;
            if self.kept == MAX_SELECTORS {
                tally
                    .add(Notice::Style, || format!("what follows {MAX_SELECTORS} selectors of style sheets"));
                break;
            }
            if !css::selector(text).is_some_and(|selector| self.keep(selector, number)) {
                tally.add(Notice::Style, || format!("the rules of `{}` in the style sheet", short(text)));
            }
        }
        if self.kept == before {
            self.blocks.pop();
        }
        Ok(())
    }

    /// Keeps a selector of a block; whether there is room for it.
    fn keep(&mut self, selector: Selector<'s>, number: u32) -> bool {
        match selector.parts.as_slice() {
            [one] if selector.weight == one.weight() => {
                let sources = self.simple.entry(*one).or_default();
                for (property, source) in sources.iter_mut().enumerate() {
                    let important =
                        |n: u32| self.blocks[n as usize][property].map(|(_, important)| important);
                    // The later one counts, unless the earlier one alone is important.
                    if important(number).is_some() && important(number) >= important(*source) {
                        *source = number;
                    }
                }
            }
            _ if self.compound.len() == MAX_COMPOUNDS => return false,
            parts => {
                self.parts.extend(parts);
                self.compound.push((selector, [number; READ.len()]));
            }
        }
        self.kept += 1;
        true
    }

    /// What holds for an element: its attributes, the rules that name it, and its own style, by what counts more.
    pub(super) fn values<'n>(
        &'n self,
        node: &Node<'n>,
        tally: &mut Tally,
        go_on: &GoOn<'_>,
    ) -> Result<Values<'n>, CurveError> {
        let mut values = Values::default();
        for property in [DISPLAY, VISIBILITY, ORIGIN] {
            if let Some(value) = node.attribute(READ[property]) {
                put(&mut values, property, Value { value: value.trim(), weight: (false, 0, 0) });
            }
        }
        self.put_rules(&mut values, node, go_on)?;
        for said in css::declarations(node.attribute("style").unwrap_or_default()) {
            go_on()?;
            // Nothing in a foreign element is drawn, however large it is.
            if node.name() != "foreignObject" {
                tell_of_unread(&said, tally, &|| format!("in the style of {}", node.place()));
            }
            if let Some(property) = said.among(&READ) {
                put(&mut values, property, Value { value: said.value, weight: (said.important, OWN, 0) });
            }
        }
        Ok(values)
    }

    /// Puts what the rules that name an element say.
    fn put_rules<'n>(
        &'n self,
        values: &mut Values<'n>,
        node: &Node<'n>,
        go_on: &GoOn<'_>,
    ) -> Result<(), CurveError> {
        if self.kept == 0 {
            return Ok(());
        }
        let classes = node.attribute("class").unwrap_or_default().split_ascii_whitespace().map(Simple::Class);
        let id = node.attribute("id").map(Simple::Id);
        let mut own = BTreeSet::new();
        for part in [Simple::Any, Simple::Element(node.name())].into_iter().chain(id).chain(classes) {
            go_on()?;
            if let Some(sources) = self.simple.get(&part) {
                self.put_blocks(values, sources, part.weight());
            }
            // Those that no such selector has are many, at times, and of no use.
            if self.parts.contains(&part) {
                own.insert(part);
            }
        }
        for (selector, sources) in &self.compound {
            if selector.parts.iter().all(|part| own.contains(part)) {
                self.put_blocks(values, sources, selector.weight);
            }
        }
        Ok(())
    }

    fn put_blocks<'n>(&'n self, values: &mut Values<'n>, sources: &Sources, weight: u32) {
        for (property, number) in sources.iter().enumerate() {
            if let Some((value, important)) = self.blocks[*number as usize][property] {
                put(values, property, Value { value, weight: (important, weight, *number) });
            }
        }
    }
}

/// What a block says.
fn said<'s>(block: &'s str, tally: &mut Tally, go_on: &GoOn<'_>) -> Result<Block<'s>, CurveError> {
    let mut all = Block::default();
    for said in css::declarations(block) {
        go_on()?;
        tell_of_unread(&said, tally, &|| "of the style sheet".to_owned());
        if let Some(property) = said.among(&READ)
            && all[property].is_none_or(|(_, important)| important <= said.important)
        {
            all[property] = Some((said.value, said.important));
        }
    }
    Ok(all)
}

/// Tells of a declaration that would say what is drawn, and is not read.
fn tell_of_unread(said: &Declaration<'_>, tally: &mut Tally, of: &dyn Fn() -> String) {
    let is_as_without =
        said.among(&["width", "height"]).is_some() && matches!(said.value.trim(), "auto" | "100%");
    if let Some(property) = said.among(&UNREAD).filter(|_| !is_as_without) {
        tally.add(Notice::Style, || format!("`{}` {}", UNREAD[property], of()));
    }
    if said.holds_rule_of(&READ) {
        tally.add(Notice::Style, || format!("a block inside of a block {}", of()));
    }
}

/// Tells of a rule at an `@` that would say what is drawn.
fn at_rule(words: &str, block: &str, tally: &mut Tally) {
    let name = words.split(|c: char| !c.is_alphanumeric() && c != '-').next().unwrap_or_default();
    let says = name.eq_ignore_ascii_case("import") || css::speaks_of(block, &READ);
    if says && !IDLE.iter().any(|idle| name.eq_ignore_ascii_case(idle)) {
        tally.add(Notice::Style, || format!("`@{}` in the style sheet", short(name)));
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    fn read(css: &str) -> (StyleSheet<'_>, Tally) {
        let (mut sheet, mut tally) = (StyleSheet::default(), Tally::default());
        sheet.read(css, &|| 1, &mut tally, &|| Ok(())).expect("nobody stops it");
        (sheet, tally)
    }

    #[test]
    fn blocks_are_kept_once_and_selectors_up_to_a_number() {
        let many: String = (0..1000).map(|k| format!(".a{k},")).collect();
        let css = format!("{many}b{{fill:red;display:none;display:inline}}");
        let (sheet, tally) = read(&css);
        assert_eq!((sheet.kept, sheet.simple.len(), sheet.blocks.len()), (1001, 1001, 2));
        assert_eq!(sheet.blocks[1][DISPLAY], Some(("inline", false)));
        assert!(tally.is_empty());
        let (sheet, tally) = read("g > a{display:none} a:b{display:none} c{fill:red}");
        assert!(sheet.blocks.len() == 1 && !tally.is_empty(), "a block that nothing names is not kept");
        for css in
            ["a,".repeat(MAX_SELECTORS + 9) + "b{display:none}", "a{display:none}".repeat(MAX_SELECTORS + 9)]
        {
            let (sheet, tally) = read(&css);
            assert_eq!((sheet.kept, sheet.simple.len()), (MAX_SELECTORS, 1));
            assert!(sheet.blocks.len() <= MAX_SELECTORS + 1 && !tally.is_empty());
        }
    }

    #[test]
    fn parts_that_stand_again_are_looked_for_once() {
        let css = format!("{}{{display:none}}.a{{display:inline}}", ".a".repeat(100_000));
        let (sheet, tally) = read(&css);
        assert_eq!((sheet.compound[0].0.parts.len(), sheet.parts.len(), sheet.kept), (1, 1, 2));
        assert!(tally.is_empty());
    }

    #[test]
    fn reading_a_sheet_asks_whether_to_go_on() {
        let selectors = "a,".repeat(1000) + "b{display:none}";
        let declarations = format!("a{{{}}}", "display:none;".repeat(1000));
        for css in [selectors, declarations, "a{display:none}".repeat(1000), "@a;".repeat(1000)] {
            let asked = Cell::new(0);
            let go_on = || {
                asked.set(asked.get() + 1);
                if asked.get() < 500 { Ok(()) } else { Err(CurveError::Cancelled) }
            };
            let stopped = StyleSheet::default().read(&css, &|| 1, &mut Tally::default(), &go_on);
            assert!(matches!(stopped, Err(CurveError::Cancelled)), "{} bytes", css.len());
        }
    }
}
