//! What of a drawing shows: `display`, `visibility` and `opacity`, as attributes, in `style`, and in style sheets.

use roxmltree::{Document, Node};

/// The rules of a drawing's style sheets: those whose selectors are elements, classes and ids, alone, joined, or
/// within one another. Others (`>`, `[…]`, `:hover`, `@media`) are passed over.
pub(super) struct Styles(Vec<Rule>);

/// One selector and what it sets.
struct Rule {
    /// From the outermost element to the one that is meant.
    path: Vec<Compound>,
    /// Ids, classes, elements: of two rules, the heavier one wins, of equally heavy ones the later.
    weight: [usize; 3],
    declarations: Vec<Declaration>,
}

#[derive(Default)]
struct Compound {
    element: Option<String>,
    ids: Vec<String>,
    classes: Vec<String>,
}

#[derive(Clone)]
struct Declaration {
    name: String,
    value: String,
    important: bool,
}

impl Styles {
    /// The style sheets of a drawing.
    pub(super) fn of(document: &Document<'_>) -> Self {
        let mut rules = Vec::new();
        for sheet in
            document.descendants().filter(|n| n.has_tag_name("style") || n.tag_name().name() == "style")
        {
            let text: String = sheet.children().filter_map(|n| n.text()).collect();
            read(&without_comments(&text), &mut rules);
        }
        Self(rules)
    }

    /// Whether an element, with all that is in it, is shown.
    pub(super) fn shows(&self, node: Node<'_, '_>) -> bool {
        let nothing = |text: &str| {
            let percent = text.trim_end_matches('%');
            percent.trim().parse::<f64>().is_ok_and(|opacity| opacity <= 0.0)
        };
        self.property(node, "display").is_none_or(|v| v != "none")
            && !self.property(node, "opacity").is_some_and(|v| nothing(&v))
    }

    /// Whether an element itself is visible; what is in it may have another say.
    pub(super) fn visible(&self, node: Node<'_, '_>) -> bool {
        let said = node.ancestors().find_map(|n| self.property(n, "visibility").filter(|v| v != "inherit"));
        said.is_none_or(|v| v == "visible")
    }

    /// A property as it is set for an element, in lower case: by rules that are important, else by its `style`, else by
    /// rules, else by its attribute.
    fn property(&self, node: Node<'_, '_>, name: &str) -> Option<String> {
        let own = node.attribute("style").map(declarations).unwrap_or_default();
        let own = own.into_iter().map(|d| ((d.important, true, [0; 3]), d));
        let matching = self.0.iter().filter(|rule| rule.matches(node));
        let ruled = matching.flat_map(|rule| {
            rule.declarations.iter().map(|d| ((d.important, false, rule.weight), d.clone()))
        });
        // Of equal ones the last.
        let set = ruled.chain(own).filter(|(_, d)| d.name == name).max_by_key(|(rank, _)| *rank);
        let set = set.map(|(_, d)| d.value);
        set.or_else(|| node.attribute(name).map(|v| v.trim().to_ascii_lowercase()))
    }
}

impl Rule {
    fn matches(&self, node: Node<'_, '_>) -> bool {
        let Some((last, outer)) = self.path.split_last() else { return false };
        let mut around = node.ancestors().skip(1).filter(Node::is_element);
        // From the inside out; each takes the nearest that there is, so that the most are left for the others.
        last.matches(node) && outer.iter().rev().all(|compound| around.any(|n| compound.matches(n)))
    }
}

impl Compound {
    /// A selector without spaces; `None` where it has what is not known.
    fn read(text: &str) -> Option<Self> {
        let mut compound = Self::default();
        let (mut rest, mut mark) = (text, ' ');
        loop {
            let end = rest.find(['.', '#']).unwrap_or(rest.len());
            let word = &rest[..end];
            let known = |c: char| c.is_alphanumeric() || c == '-' || c == '_';
            let first = mark == ' ';
            if !(word.chars().all(known) || first && word == "*") || word.is_empty() && !first {
                return None;
            }
            match mark {
                '#' => compound.ids.push(word.to_owned()),
                '.' => compound.classes.push(word.to_owned()),
                _ => compound.element = Some(word.to_owned()).filter(|w| !w.is_empty() && w != "*"),
            }
            let Some(next) = rest[end..].chars().next() else { return Some(compound) };
            mark = next;
            rest = &rest[end + 1..];
        }
    }

    fn matches(&self, node: Node<'_, '_>) -> bool {
        let has = |attribute: &str, word: &String| {
            node.attribute(attribute).is_some_and(|text| text.split_whitespace().any(|w| w == word))
        };
        self.element.as_ref().is_none_or(|name| node.tag_name().name() == name)
            && self.ids.iter().all(|id| has("id", id))
            && self.classes.iter().all(|class| has("class", class))
    }
}

/// Appends the rules of a style sheet.
fn read(mut text: &str, rules: &mut Vec<Rule>) {
    while let Some(open) = text.find('{') {
        // Statements without a block, such as `@import`, end before.
        let selectors = text[..open].rsplit([';', '}']).next().unwrap_or_default().trim();
        let body = &text[open + 1..];
        if selectors.starts_with('@') {
            text = after_block(body);
            continue;
        }
        let end = body.find('}').unwrap_or(body.len());
        let declarations = declarations(&body[..end]);
        for selector in selectors.split(',') {
            let path: Option<Vec<Compound>> = selector.split_whitespace().map(Compound::read).collect();
            let Some(path) = path.filter(|path| !path.is_empty()) else { continue };
            let count = |of: fn(&Compound) -> usize| path.iter().map(of).sum();
            let weight = [
                count(|c| c.ids.len()),
                count(|c| c.classes.len()),
                count(|c| usize::from(c.element.is_some())),
            ];
            rules.push(Rule { path, weight, declarations: declarations.clone() });
        }
        text = body.get(end + 1..).unwrap_or_default();
    }
}

/// What follows the block that is open, blocks within it included.
fn after_block(text: &str) -> &str {
    let mut depth = 1;
    for (at, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return &text[at + 1..];
        }
    }
    ""
}

fn declarations(text: &str) -> Vec<Declaration> {
    let one = |text: &str| {
        let (name, value) = text.split_once(':')?;
        let (value, mark) = value.split_once('!').unwrap_or((value, ""));
        let lower = |s: &str| s.trim().to_ascii_lowercase();
        Some(Declaration { name: lower(name), value: lower(value), important: lower(mark) == "important" })
    };
    text.split(';').filter_map(one).collect()
}

fn without_comments(text: &str) -> String {
    let mut kept = String::new();
    let mut rest = text;
    while let Some((before, comment)) = rest.split_once("/*") {
        kept += before;
        kept.push(' ');
        rest = comment.split_once("*/").map_or("", |(_, after)| after);
    }
    (kept + rest).replace("<!--", " ").replace("-->", " ")
}
