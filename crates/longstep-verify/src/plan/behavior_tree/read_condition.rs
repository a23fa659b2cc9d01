//! Reader of conditions, and of what computes them: the inverse of the writer's.

use roxmltree::Node as Xml;

use super::OUTCOME;
use super::part::Part;
use super::read::Reader;
use super::xml::{Fault, Scope, children, code, fault};
use crate::plan::tree::Test;
use crate::plan::written::WrittenStep;

/// A script that computes a condition.
enum Assignment {
    /// An entry of the blackboard is compared with an outcome.
    Compared {
        entry: String,
        word: String,
        is_equal: bool,
    },
    Negated,
    Constant(bool),
}

/// Splits `ENTRY=='WORD'` and `ENTRY!='WORD'`.
fn comparison(code: &str) -> Option<(String, String, bool)> {
    let code = code
        .strip_prefix('(')
        .and_then(|code| code.strip_suffix(')'))
        .unwrap_or(code);
    let (is_equal, sides) = match code.split_once("==") {
        Some(sides) => (true, sides),
        None => (false, code.split_once("!=")?),
    };
    let word = sides.1.strip_prefix('\'')?.strip_suffix('\'')?;
    Some((sides.0.to_owned(), word.to_owned(), is_equal))
}

/// Splits `FLAG:=VALUE`.
fn assignment(code: &str) -> Option<(String, Assignment)> {
    let (flag, value) = code.split_once(":=")?;
    let assignment = match value {
        "true" => Assignment::Constant(true),
        "false" => Assignment::Constant(false),
        _ if value.strip_prefix('!') == Some(flag) => Assignment::Negated,
        _ => {
            let (entry, word, is_equal) = comparison(value)?;
            Assignment::Compared { entry, word, is_equal }
        }
    };
    Some((flag.to_owned(), assignment))
}

/// A condition that is true or false in every state.
fn constant(value: bool) -> Test<WrittenStep> {
    if value {
        Test::All(Vec::new())
    } else {
        Test::Any(Vec::new())
    }
}

fn negated(test: Test<WrittenStep>) -> Test<WrittenStep> {
    Test::Not(Box::new(test))
}

/// Returns the flag that a node computes with its last script, if it has no steps but sensing ones.
fn computed(node: Xml<'_, '_>) -> Option<String> {
    match node.tag_name().name() {
        "Script" => assignment(&code(node)).map(|(flag, _)| flag),
        "Sequence" => computed(*children(node).last()?),
        "IfThenElse" => match children(node)[..] {
            [_, then, otherwise] => match (
                then.has_tag_name("AlwaysSuccess"),
                otherwise.has_tag_name("AlwaysSuccess"),
            ) {
                (true, false) => computed(otherwise),
                (false, true) => computed(then),
                _ => computed(then).filter(|flag| Some(flag) == computed(otherwise).as_ref()),
            },
            _ => None,
        },
        _ => None,
    }
}

impl<'d, 'x: 'd> Reader<'d, 'x> {
    /// Reads a node that is asked.
    pub(super) fn condition(&mut self, node: Xml<'d, 'x>, scope: &Scope) -> Result<Test<WrittenStep>, Fault> {
        let parts = |reader: &mut Self| -> Result<Vec<Test<WrittenStep>>, Fault> {
            let inside = children(node).into_iter().filter(|child| !child.is_comment());
            inside.map(|child| reader.condition(child, scope)).collect()
        };
        Ok(match node.tag_name().name() {
            "ScriptCondition" => self.asked(node)?,
            "AlwaysSuccess" => constant(true),
            "AlwaysFailure" => constant(false),
            "Sequence" => Test::All(parts(self)?),
            "Fallback" => Test::Any(parts(self)?),
            "Inverter" => match parts(self)?.pop() {
                Some(inner) => negated(inner),
                None => return fault(node, "Inverter has no child", "put the condition into it"),
            },
            name if super::name::is_built_in(name) && !matches!(name, "Action" | "Condition") => {
                return fault(
                    node,
                    format!("`{name}` is no condition of a plan"),
                    "use leaves that check a fact, Sequence, Fallback and Inverter",
                );
            }
            _ => {
                let mut step = self.call(node, scope)?;
                step.explanation.clear();
                Test::Holds(step)
            }
        })
    }

    /// Reads a question about the blackboard.
    fn asked(&mut self, node: Xml<'d, 'x>) -> Result<Test<WrittenStep>, Fault> {
        let code = code(node);
        if let Some((entry, word, is_equal)) = comparison(&code) {
            return self.outcome(node, &entry, word, is_equal);
        }
        match self.flags.get(&code) {
            Some(test) => Ok(test.clone()),
            None => fault(
                node,
                format!("`{code}` was not computed just before"),
                "ask a fact, or the outcome of the sensing step before: outcome_1 == 'WORD'",
            ),
        }
    }

    /// Makes the sensing step that was read last a condition.
    fn outcome(
        &mut self,
        node: Xml<'d, 'x>,
        entry: &str,
        word: String,
        is_equal: bool,
    ) -> Result<Test<WrittenStep>, Fault> {
        let Some(sensed) = self.sensed.take_if(|sensed| sensed.entry == entry) else {
            return fault(
                node,
                format!("`{entry}` is not the outcome of the step just before"),
                "ask right after the sensing step; later, ask the fact that it found",
            );
        };
        let mut step = sensed.step;
        step.implicit.push((OUTCOME.to_owned(), word));
        let test = Test::Holds(step);
        Ok(if is_equal { test } else { negated(test) })
    }

    /// Reads a script that computes a condition.
    pub(super) fn script(&mut self, node: Xml<'d, 'x>) -> Result<(), Fault> {
        let Some((flag, assignment)) = assignment(&code(node)) else {
            return fault(
                node,
                "no plan has this script",
                "a script of a plan compares the outcome of a sensing step: flag := (outcome_1 == 'WORD')",
            );
        };
        let test = match assignment {
            Assignment::Constant(value) => constant(value),
            Assignment::Compared { entry, word, is_equal } => self.outcome(node, &entry, word, is_equal)?,
            Assignment::Negated => match self.flags.remove(&flag) {
                Some(test) => negated(test),
                None => {
                    return fault(
                        node,
                        format!("`{flag}` was not computed just before"),
                        "compute it first",
                    );
                }
            },
        };
        self.flags.insert(flag, test);
        Ok(())
    }

    /// Reads a branch that computes a condition: one that sets a flag in both cases, or goes on computing it in one.
    pub(super) fn computes_flag(
        &mut self,
        inside: &[Xml<'d, 'x>],
        scope: &Scope,
        parts: &mut Vec<Part>,
    ) -> Result<bool, Fault> {
        let [condition, then, otherwise] = *inside else {
            return Ok(false);
        };
        let set = |node: Xml<'_, '_>| match assignment(&code(node)) {
            Some((flag, Assignment::Constant(value))) if node.has_tag_name("Script") => Some((flag, value)),
            _ => None,
        };
        if let (Some((flag, true)), Some((other, false))) = (set(then), set(otherwise))
            && flag == other
        {
            let test = self.condition(condition, scope)?;
            self.flush(parts);
            self.flags.insert(flag, test);
            return Ok(true);
        }
        let flag = code(condition);
        if !condition.has_tag_name("ScriptCondition") || !self.flags.contains_key(&flag) {
            return Ok(false);
        }
        let is_settled = |node: Xml<'_, '_>| node.has_tag_name("AlwaysSuccess");
        let (further, is_all) = match (is_settled(then), is_settled(otherwise)) {
            (false, true) => (then, true),
            (true, false) => (otherwise, false),
            _ => return Ok(false),
        };
        if computed(further).as_ref() != Some(&flag) {
            return Ok(false);
        }
        self.flush(parts);
        let before = self.flags.remove(&flag);
        let steps = self.list(&[further], scope)?;
        let (Some(before), Some(after), true) = (before, self.flags.remove(&flag), steps.is_empty()) else {
            return fault(
                further,
                "a condition has a step that senses nothing",
                "put the step before the branch",
            );
        };
        self.flags.insert(flag, joined(before, after, is_all));
        Ok(true)
    }
}

/// Joins a condition with a further part.
fn joined(before: Test<WrittenStep>, further: Test<WrittenStep>, is_all: bool) -> Test<WrittenStep> {
    let mut parts = match before {
        Test::All(parts) if is_all && !parts.is_empty() => parts,
        Test::Any(parts) if !is_all && !parts.is_empty() => parts,
        other => vec![other],
    };
    parts.push(further);
    if is_all { Test::All(parts) } else { Test::Any(parts) }
}
