//! XML elements to write.

use std::borrow::Cow;
use std::fmt::Write as _;

use longstep_model::visible;

/// An element with its children, or a comment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Element {
    Node {
        name: Cow<'static, str>,
        attributes: Vec<(Cow<'static, str>, String)>,
        children: Vec<Element>,
    },
    /// Text inside of an element that has nothing else.
    Text(String),
    Comment(String),
}

impl Element {
    pub(super) fn new(name: impl Into<Cow<'static, str>>) -> Self {
        Self::Node {
            name: name.into(),
            attributes: Vec::new(),
            children: Vec::new(),
        }
    }

    /// Adds an attribute.
    #[must_use]
    pub(super) fn with(mut self, name: impl Into<Cow<'static, str>>, value: impl Into<String>) -> Self {
        if let Self::Node { attributes, .. } = &mut self {
            attributes.push((name.into(), value.into()));
        }
        self
    }

    /// Adds children.
    #[must_use]
    pub(super) fn holding(mut self, more: impl IntoIterator<Item = Element>) -> Self {
        if let Self::Node { children, .. } = &mut self {
            children.extend(more);
        }
        self
    }

    /// Adds a node that succeeds to nodes of which none is more than a comment: control nodes have a child.
    pub(super) fn never_empty(mut nodes: Vec<Element>) -> Vec<Element> {
        if !nodes.iter().any(Element::is_node) {
            nodes.push(Self::new("AlwaysSuccess"));
        }
        nodes
    }

    /// A sequence; a single element is that element itself.
    pub(super) fn sequence(children: Vec<Element>) -> Self {
        let mut children = Self::never_empty(children);
        match children.len() {
            1 => children.remove(0),
            _ => Self::new("Sequence").holding(children),
        }
    }

    pub(super) fn script(code: impl Into<String>) -> Self {
        Self::new("Script").with("code", code)
    }

    /// A condition on the blackboard.
    pub(super) fn test(code: impl Into<String>) -> Self {
        Self::new("ScriptCondition").with("code", code)
    }

    /// Executes the second if the first succeeds, else the third. It needs all three.
    pub(super) fn branch(condition: Element, then: Element, otherwise: Element) -> Self {
        Self::new("IfThenElse").holding([condition, then, otherwise])
    }

    fn is_node(&self) -> bool {
        matches!(self, Self::Node { .. })
    }

    /// Writes the element with its children on lines of their own.
    pub(super) fn write(&self, depth: usize, xml: &mut String) {
        let indent = 2 * depth;
        match self {
            Self::Comment(text) => {
                // A comment has no two hyphens in a row.
                let text = visible::line(text).replace("--", "\u{2010}\u{2010}");
                let _ = writeln!(xml, "{:indent$}<!-- {text} -->", "");
            }
            Self::Text(text) => {
                let _ = writeln!(xml, "{:indent$}{}", "", escaped(text));
            }
            Self::Node {
                name,
                attributes,
                children,
            } => {
                let _ = write!(xml, "{:indent$}<{name}", "");
                for (name, value) in attributes {
                    let _ = write!(xml, " {name}=\"{}\"", escaped(value));
                }
                match &children[..] {
                    [] => xml.push_str("/>\n"),
                    [Self::Text(text)] => {
                        let _ = writeln!(xml, ">{}</{name}>", escaped(text));
                    }
                    children => {
                        xml.push_str(">\n");
                        children.iter().for_each(|child| child.write(depth + 1, xml));
                        let _ = writeln!(xml, "{:indent$}</{name}>", "");
                    }
                }
            }
        }
    }
}

/// Returns true for characters that XML has no way to write.
pub(super) fn is_unwritable(character: char) -> bool {
    matches!(character, '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}')
}

/// Escapes a text for an attribute or the content of an element. Characters that a reader does not see become numbers, which
/// mean the same; those that XML cannot have become visible.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            _ if is_unwritable(character) => escaped.push_str(&visible::line(&character.to_string())),
            // White space would become a blank in an attribute.
            _ if visible::is_hidden(character) => {
                let _ = write!(escaped, "&#{};", u32::from(character));
            }
            _ => escaped.push(character),
        }
    }
    escaped
}
