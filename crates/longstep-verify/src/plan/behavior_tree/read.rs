//! Reader of behavior trees.

use std::collections::{HashMap, HashSet};

use roxmltree::{Document, Node as Xml, ParsingOptions};

use super::name::{is_built_in, parameter};
use super::part::{Flags, Part, number};
use super::xml::{Fault, Scope, blackboard, blank_free, children, code, fault, no_conditions, only_child, text_of};
use super::{CALL, GUARD, MAIN, OUTCOME, SYNC};
use crate::plan::written::{Written, WrittenStep};
use longstep_model::call::Call;

/// The most nodes after the subtrees were put in.
const MOST: usize = 100_000;

/// The deepest tree that BehaviorTree.CPP reads.
const DEEPEST: usize = 256;

/// A plan that a behavior tree is.
pub(in crate::plan) struct Found {
    pub(in crate::plan) written: Written,
    /// The first condition before a step that was ignored: the verifier knows the preconditions.
    pub(in crate::plan) check: Option<usize>,
}

/// Returns the part of a text that is a behavior tree; none if nothing in it is meant as one.
pub(in crate::plan) fn find(text: &str) -> Option<std::ops::Range<usize>> {
    let root = text.find("<root")?;
    if !text[root..].contains("<BehaviorTree") {
        return None;
    }
    let start = text[..root].rfind("<?xml").unwrap_or(root);
    let end = text[root..]
        .rfind("</root>")
        .map_or(text.len(), |end| root + end + "</root>".len());
    Some(start..end)
}

/// Reads a behavior tree.
///
/// # Errors
///
/// At the first node that no plan has.
pub(in crate::plan) fn read(xml: &str) -> Result<Found, Fault> {
    // No entities beyond those of XML, which could grow without a bound.
    let options = ParsingOptions {
        allow_dtd: false,
        nodes_limit: u32::try_from(MOST * 8).unwrap_or(u32::MAX),
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(xml, options).map_err(|error| {
        let position = error.pos();
        let line = xml.split_inclusive('\n').take(position.row.saturating_sub(1) as usize);
        let before: usize = line.map(str::len).sum();
        let column = position.col.saturating_sub(1) as usize;
        let within = xml[before..].char_indices().nth(column).map_or(0, |(at, _)| at);
        Fault {
            at: before + within,
            message: format!("this is no XML: {error}"),
            hint: "correct the XML; Groot2 and editors mark the place".to_owned(),
        }
    })?;
    let root = document.root_element();
    if let Some(version) = root.attribute("BTCPP_format")
        && version != super::FORMAT
    {
        return fault(
            root,
            format!("this is version `{version}` of the format of BehaviorTree.CPP; version 4 is read"),
            "convert it with the script that BehaviorTree.CPP has for its version 3",
        );
    }
    let mut reader = Reader::new(root);
    let main = root.attribute("main_tree_to_execute").unwrap_or(MAIN);
    let first = || reader.trees.get(main).copied().or_else(|| only_tree(root));
    let Some(tree) = first() else {
        return fault(
            root,
            format!("there is no tree `{main}`"),
            "name the main tree in `main_tree_to_execute`",
        );
    };
    let mut parts = reader.tree(tree, &Scope::default())?;
    reader.flush(&mut parts);
    let mut written = Written::default();
    written.body = number(parts, &mut written.steps);
    if !written.is_sound() {
        return fault(
            root,
            format!("the plan is nested deeper than {}", crate::plan::tree::DEEPEST),
            "flatten it",
        );
    }
    Ok(Found {
        written,
        check: reader.check,
    })
}

/// The tree of a file without a main tree.
fn only_tree<'d, 'x>(root: Xml<'d, 'x>) -> Option<Xml<'d, 'x>> {
    let mut trees = root.children().filter(|node| node.has_tag_name("BehaviorTree"));
    let first = trees.next()?;
    trees.next().is_none().then_some(first)
}

/// A sensing step whose outcome was not asked yet, and the entry of the blackboard with it.
pub(super) struct Sensed {
    pub(super) entry: String,
    pub(super) step: WrittenStep,
}

pub(super) struct Reader<'d, 'x> {
    trees: HashMap<&'d str, Xml<'d, 'x>>,
    /// The leaves that `TreeNodesModel` has as conditions.
    conditions: HashSet<&'d str>,
    /// The trees that are being read.
    inside: Vec<&'d str>,
    pub(super) sensed: Option<Sensed>,
    pub(super) flags: Flags,
    nodes: usize,
    depth: usize,
    check: Option<usize>,
}

impl<'d, 'x: 'd> Reader<'d, 'x> {
    fn new(root: Xml<'d, 'x>) -> Self {
        let trees = root.children().filter(|node| node.has_tag_name("BehaviorTree"));
        let models = root.children().filter(|node| node.has_tag_name("TreeNodesModel"));
        let conditions = models
            .flat_map(|model| model.children())
            .filter(|node| node.has_tag_name("Condition"));
        Self {
            trees: trees.filter_map(|tree| Some((tree.attribute("ID")?, tree))).collect(),
            conditions: conditions.filter_map(|node| node.attribute("ID")).collect(),
            inside: Vec::new(),
            sensed: None,
            flags: Flags::default(),
            nodes: 0,
            depth: 0,
            check: None,
        }
    }

    /// Ends the wait for a question about the outcome of a sensing step: nothing asks it.
    pub(super) fn flush(&mut self, parts: &mut Vec<Part>) {
        if let Some(sensed) = self.sensed.take() {
            parts.push(Part::Step(sensed.step));
        }
    }

    fn tree(&mut self, tree: Xml<'d, 'x>, scope: &Scope) -> Result<Vec<Part>, Fault> {
        let id = tree.attribute("ID").unwrap_or(MAIN);
        if self.inside.contains(&id) {
            return fault(
                tree,
                format!("the tree `{id}` is part of itself"),
                "a plan with a loop has a loop node",
            );
        }
        self.inside.push(id);
        let parts = self.list(&children(tree), scope)?;
        self.inside.pop();
        Ok(parts)
    }

    /// Reads nodes that follow each other.
    pub(super) fn list(&mut self, nodes: &[Xml<'d, 'x>], scope: &Scope) -> Result<Vec<Part>, Fault> {
        self.depth += 1;
        let mut parts = Vec::new();
        let mut rest = nodes;
        while let Some((node, behind)) = rest.split_first() {
            self.nodes += 1;
            if self.nodes > MOST || self.depth > DEEPEST {
                return fault(
                    *node,
                    format!("the tree has more than {MOST} nodes, or is deeper than {DEEPEST}"),
                    "split the plan",
                );
            }
            rest = self.node(*node, behind, scope, &mut parts)?;
        }
        self.depth -= 1;
        Ok(parts)
    }

    /// Reads a node, and those behind it that belong to it; returns the others.
    fn node<'n>(
        &mut self,
        node: Xml<'d, 'x>,
        behind: &'n [Xml<'d, 'x>],
        scope: &Scope,
        parts: &mut Vec<Part>,
    ) -> Result<&'n [Xml<'d, 'x>], Fault> {
        if node.is_comment() {
            parts.push(Part::Remark(node.text().unwrap_or_default().trim().to_owned()));
            return Ok(behind);
        }
        no_conditions(node)?;
        let inside = children(node);
        match node.tag_name().name() {
            "Sequence" if node.has_attribute(GUARD) => {
                let Some((last, checks)) = inside.split_last() else {
                    return fault(node, "a sequence has no child", "remove it");
                };
                for check in checks {
                    self.condition(*check, scope)?;
                }
                self.node(*last, &[], scope, parts)?;
            }
            "Sequence" | "SequenceWithMemory" => parts.extend(self.list(&inside, scope)?),
            "AlwaysSuccess" => {}
            "IfThenElse" => {
                if !self.computes_flag(&inside, scope, parts)? {
                    self.branch(node, &inside, scope, parts)?;
                }
            }
            "Repeat" => {
                let times = node.attribute("num_cycles").and_then(|times| times.parse().ok());
                let Some(times) = times else {
                    return fault(
                        node,
                        "`num_cycles` is no number",
                        "a plan repeats a known number of times",
                    );
                };
                self.flush(parts);
                let body = self.settled(&inside, scope)?;
                parts.push(Part::Repeat(times, body));
            }
            "Script" if node.has_attribute(SYNC) => {}
            "Script" => {
                if let Some(behind) = self.repeat_while(node, behind, scope, parts)? {
                    return Ok(behind);
                }
                self.script(node)?;
            }
            "Parallel" => {
                self.flush(parts);
                return self.parallel(node, behind, scope, parts);
            }
            "SubTree" => {
                let inner = self.subtree(node, scope)?;
                parts.extend(inner);
            }
            "Inverter" | "Fallback" if self.is_check(node) => {
                self.condition(node, scope)?;
                self.check.get_or_insert(node.range().start);
            }
            name if is_built_in(name) && !matches!(name, "Action" | "Condition") => {
                return fault(
                    node,
                    format!("no plan has the node `{name}` here"),
                    "use Sequence, IfThenElse, Repeat, Parallel with a lane for each hand, SubTree, and the leaves of the domain",
                );
            }
            _ => self.leaf(node, scope, parts)?,
        }
        Ok(behind)
    }

    /// Reads nodes whose last sensing step is a step of its own.
    pub(super) fn settled(&mut self, nodes: &[Xml<'d, 'x>], scope: &Scope) -> Result<Vec<Part>, Fault> {
        let flags = self.flags.clone();
        let mut parts = self.list(nodes, scope)?;
        self.flush(&mut parts);
        self.flags = flags;
        Ok(parts)
    }

    fn branch(
        &mut self,
        node: Xml<'d, 'x>,
        inside: &[Xml<'d, 'x>],
        scope: &Scope,
        parts: &mut Vec<Part>,
    ) -> Result<(), Fault> {
        let inside: Vec<Xml<'d, 'x>> = inside.iter().copied().filter(|child| !child.is_comment()).collect();
        let (condition, then, otherwise) = match inside[..] {
            [condition, then] => (condition, then, None),
            [condition, then, otherwise] => (condition, then, Some(otherwise)),
            _ => {
                return fault(
                    node,
                    "IfThenElse has two or three children",
                    "add a condition, and what follows if it holds",
                );
            }
        };
        let test = self.condition(condition, scope)?;
        self.flush(parts);
        let then = self.settled(&[then], scope)?;
        let otherwise = otherwise.map(|node| self.settled(&[node], scope)).transpose()?;
        self.flags.clear();
        parts.push(Part::If(test, then, otherwise.unwrap_or_default()));
        Ok(())
    }

    /// Reads a loop if a script begins one, as the writer makes it; returns the nodes behind it.
    fn repeat_while<'n>(
        &mut self,
        script: Xml<'d, 'x>,
        behind: &'n [Xml<'d, 'x>],
        scope: &Scope,
        parts: &mut Vec<Part>,
    ) -> Result<Option<&'n [Xml<'d, 'x>]>, Fault> {
        let code_of_script = code(script);
        let Some(flag) = code_of_script.strip_suffix(":=true") else {
            return Ok(None);
        };
        let [forced, last, behind @ ..] = behind else {
            return Ok(None);
        };
        let rounds = only_child(*forced).filter(|_| forced.has_tag_name("ForceSuccess"));
        let round = rounds
            .filter(|node| node.has_tag_name("KeepRunningUntilFailure"))
            .and_then(only_child);
        let is_asked = last.has_tag_name("ScriptCondition") && code(*last) == flag;
        let Some(round) = round.filter(|node| node.has_tag_name("Sequence") && is_asked) else {
            return Ok(None);
        };
        let fails = |node: &Xml<'_, '_>| {
            node.attribute("_onFailure")
                .is_some_and(|code| blank_free(code) == format!("{flag}:=false"))
        };
        let inside = children(round);
        let (sensing, condition, body) = match inside[..] {
            [condition, body] if fails(&body) => (None, condition, body),
            [sensing, condition, body] if fails(&sensing) && fails(&body) => (Some(sensing), condition, body),
            _ => {
                return fault(
                    round,
                    "a loop has a condition and a body that sets the flag if it fails",
                    "write the loop as `longstep export --format bt` does",
                );
            }
        };
        self.flush(parts);
        self.flags.clear();
        if let Some(sensing) = sensing {
            let steps = self.list(&children(sensing), scope)?;
            if !steps.is_empty() {
                return fault(
                    sensing,
                    "the condition of a loop has steps that sense nothing",
                    "put them into the body",
                );
            }
        }
        let condition = self.condition(condition, scope)?;
        self.flags.clear();
        let body = self.settled(&children(body), scope)?;
        parts.push(Part::While(condition, body));
        Ok(Some(behind))
    }

    fn subtree(&mut self, node: Xml<'d, 'x>, scope: &Scope) -> Result<Vec<Part>, Fault> {
        let id = node.attribute("ID").unwrap_or_default();
        let Some(tree) = self.trees.get(id).copied() else {
            return fault(
                node,
                format!("there is no tree `{id}` in this file"),
                "put all trees into one file",
            );
        };
        let mut inner = Scope::new();
        for attribute in node.attributes() {
            let name = attribute.name();
            if name != "ID" && name != "name" && !name.starts_with('_') {
                inner.insert(name.to_owned(), text_of(node, attribute.value(), scope)?);
            }
        }
        self.tree(tree, &inner)
    }

    fn leaf(&mut self, node: Xml<'d, 'x>, scope: &Scope, parts: &mut Vec<Part>) -> Result<(), Fault> {
        if self.is_condition(node) {
            // A check before a step: the verifier makes the same one.
            self.call(node, scope)?;
            self.check.get_or_insert(node.range().start);
            return Ok(());
        }
        let step = self.call(node, scope)?;
        self.flush(parts);
        self.flags.clear();
        match node.attribute(OUTCOME) {
            Some(entry) => {
                let Some(entry) = blackboard(entry) else {
                    return fault(
                        node,
                        "the outcome is not written to the blackboard",
                        "write outcome=\"{ENTRY}\"",
                    );
                };
                self.sensed = Some(Sensed {
                    entry: entry.to_owned(),
                    step,
                });
            }
            None => parts.push(Part::Step(step)),
        }
        Ok(())
    }

    /// Returns true if all leaves inside of a node check facts.
    fn is_check(&self, node: Xml<'d, 'x>) -> bool {
        let mut leaves = node
            .descendants()
            .filter(|inside| inside.is_element() && !inside.has_children());
        leaves.all(|leaf| self.is_condition(leaf))
    }

    fn is_condition(&self, node: Xml<'d, 'x>) -> bool {
        node.has_tag_name("Condition") || self.conditions.contains(node.tag_name().name())
    }

    /// Reads a leaf as a call whose arguments have names.
    pub(super) fn call(&self, node: Xml<'d, 'x>, scope: &Scope) -> Result<WrittenStep, Fault> {
        no_conditions(node)?;
        if node.has_children() && node.children().any(|child| child.is_element()) {
            return fault(
                node,
                format!("the leaf `{}` has children", node.tag_name().name()),
                "a step has none",
            );
        }
        let tag = node.tag_name().name();
        let explicit = matches!(tag, "Action" | "Condition");
        let own = if explicit { node.attribute("ID") } else { Some(tag) };
        let Some(name) = node.attribute(CALL).or(own) else {
            return fault(node, format!("`{tag}` has no ID"), "name the action in `ID`");
        };
        let mut implicit = Vec::new();
        for attribute in node.attributes() {
            let port = attribute.name();
            let is_other = matches!(port, "name" | OUTCOME) || port.starts_with('_') || (explicit && port == "ID");
            if !is_other {
                implicit.push((parameter(port).to_owned(), text_of(node, attribute.value(), scope)?));
            }
        }
        Ok(WrittenStep {
            call: Call {
                name: name.to_owned(),
                arguments: Vec::new(),
            },
            implicit,
            explanation: node.attribute("name").unwrap_or_default().to_owned(),
        })
    }
}
