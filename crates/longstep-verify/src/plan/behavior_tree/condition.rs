//! Conditions of branches and loops.
//!
//! Conditions on facts alone are trees of condition leaves. A sensing step is an action, which may fail: a condition that
//! is false and a step that failed must not look alike. So a condition with sensing steps is computed before it is asked,
//! into the entry of a single step's outcome or into a flag.

use super::element::Element;
use super::write::{WriteError, Writer, outcome_entry};
use crate::plan::Test;

/// A condition of one part is that part.
fn single(test: &Test) -> &Test {
    match test {
        Test::All(parts) | Test::Any(parts) if parts.len() == 1 => single(&parts[0]),
        other => other,
    }
}

impl Writer<'_> {
    /// Returns the node that asks a condition. What computes it before goes to `before`.
    pub(super) fn condition(&mut self, test: &Test, before: &mut Vec<Element>) -> Result<Element, WriteError> {
        if test.steps().next().is_none() {
            return self.facts(test);
        }
        let test = single(test);
        let (inner, equal) = match test {
            Test::Not(inner) => (single(inner), "!="),
            other => (other, "=="),
        };
        if let Test::Sense(step) = inner {
            before.push(self.step(*step)?);
            let word = self.first_outcome(*step);
            return Ok(Element::test(format!("{} {equal} '{word}'", outcome_entry(*step))));
        }
        let flag = self.flag("test");
        self.compute(test, &flag, before)?;
        Ok(Element::test(flag))
    }

    /// A condition on facts as condition leaves.
    fn facts(&mut self, test: &Test) -> Result<Element, WriteError> {
        let parts = |writer: &mut Self, parts: &[Test]| -> Result<Vec<Element>, WriteError> {
            parts.iter().map(|part| writer.facts(part)).collect()
        };
        Ok(match single(test) {
            Test::Holds(fact) => self.fact(*fact)?,
            Test::Not(inner) => Element::new("Inverter").holding([self.facts(inner)?]),
            Test::All(all) if all.is_empty() => Element::new("AlwaysSuccess"),
            Test::Any(any) if any.is_empty() => Element::new("AlwaysFailure"),
            Test::All(all) => Element::new("Sequence").holding(parts(self, all)?),
            Test::Any(any) => Element::new("Fallback").holding(parts(self, any)?),
            // There is no sensing step in it.
            Test::Sense(step) => self.step(*step)?,
        })
    }

    /// Computes a condition into a flag. The nodes fail only if a sensing step does.
    fn compute(&mut self, test: &Test, flag: &str, nodes: &mut Vec<Element>) -> Result<(), WriteError> {
        match single(test) {
            Test::Sense(step) => {
                nodes.push(self.step(*step)?);
                let word = self.first_outcome(*step);
                let code = format!("{flag} := ({} == '{word}')", outcome_entry(*step));
                nodes.push(Element::script(code));
            }
            Test::Holds(_) => {
                let set = |value: bool| Element::script(format!("{flag} := {value}"));
                nodes.push(Element::branch(self.facts(test)?, set(true), set(false)));
            }
            Test::Not(inner) => {
                self.compute(inner, flag, nodes)?;
                nodes.push(Element::script(format!("{flag} := !{flag}")));
            }
            joined @ (Test::All(parts) | Test::Any(parts)) => {
                let is_all = matches!(joined, Test::All(_));
                let Some((first, rest)) = parts.split_first() else {
                    nodes.push(Element::script(format!("{flag} := {is_all}")));
                    return Ok(());
                };
                self.compute(first, flag, nodes)?;
                for part in rest {
                    let mut further = Vec::new();
                    self.compute(part, flag, &mut further)?;
                    let (further, settled) = (Element::sequence(further), Element::new("AlwaysSuccess"));
                    let (then, otherwise) = if is_all { (further, settled) } else { (settled, further) };
                    nodes.push(Element::branch(Element::test(flag), then, otherwise));
                }
            }
        }
        Ok(())
    }
}
