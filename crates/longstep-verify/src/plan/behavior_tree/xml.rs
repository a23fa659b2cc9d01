//! Nodes of the XML: errors with their places, children in the XML, and the texts of ports and scripts.

use std::collections::HashMap;

use roxmltree::Node as Xml;

/// An error in a behavior tree, at a byte of the text.
#[derive(Debug)]
pub(in crate::plan) struct Fault {
    pub(in crate::plan) at: usize,
    pub(in crate::plan) message: String,
    pub(in crate::plan) hint: String,
}

pub(super) fn fault<T>(node: Xml<'_, '_>, message: impl Into<String>, hint: impl Into<String>) -> Result<T, Fault> {
    Err(Fault {
        at: node.range().start,
        message: message.into(),
        hint: hint.into(),
    })
}

/// The texts that a subtree gets for its ports.
pub(super) type Scope = HashMap<String, String>;

/// Refuses conditions and scripts of a node, which change when it is ticked and what it returns.
pub(super) fn no_conditions(node: Xml<'_, '_>) -> Result<(), Fault> {
    const CHANGING: [&str; 7] = [
        "_skipIf",
        "_failureIf",
        "_successIf",
        "_while",
        "_onSuccess",
        "_onHalted",
        "_post",
    ];
    match CHANGING.iter().find(|name| node.has_attribute(**name)) {
        Some(name) => fault(
            node,
            format!("no plan has the attribute `{name}`"),
            "use IfThenElse for what depends on a fact",
        ),
        None => Ok(()),
    }
}

/// Returns the text of a port.
pub(super) fn text_of(node: Xml<'_, '_>, value: &str, scope: &Scope) -> Result<String, Fault> {
    let Some(entry) = blackboard(value) else {
        return Ok(value.to_owned());
    };
    match scope.get(entry) {
        Some(text) => Ok(text.clone()),
        None => fault(
            node,
            format!("`{value}` is an entry of the blackboard, which a plan does not know"),
            "write the name of an entity, or pass it to the subtree as a text",
        ),
    }
}

/// Returns the entry of the blackboard that a port refers to; none for a text.
pub(super) fn blackboard(value: &str) -> Option<&str> {
    value.strip_prefix('{')?.strip_suffix('}')
}

/// The elements and comments inside of a node.
pub(super) fn children<'d, 'x>(node: Xml<'d, 'x>) -> Vec<Xml<'d, 'x>> {
    node.children()
        .filter(|child| child.is_element() || child.is_comment())
        .collect()
}

pub(super) fn only_child<'d, 'x>(node: Xml<'d, 'x>) -> Option<Xml<'d, 'x>> {
    match children(node)[..] {
        [only] => Some(only),
        _ => None,
    }
}

/// The code of a script without blanks.
pub(super) fn code(node: Xml<'_, '_>) -> String {
    blank_free(node.attribute("code").unwrap_or_default())
}

pub(super) fn blank_free(code: &str) -> String {
    code.split_whitespace().collect()
}
