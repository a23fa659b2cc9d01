//! Conditions: calls, `not`, `and`, `or` and parentheses.

use super::super::super::Test;
use super::super::super::tree::DEEPEST;
use super::super::super::written::{WrittenNode, WrittenStep};
use super::super::token::Kind;
use super::super::{Fault, fault};
use super::{Parser, join};
use longstep_model::call::is_script_keyword;

/// Maximum nesting depth of parentheses and `not`; plans within [`DEEPEST`] need less.
const DEEPEST_CONDITION: usize = 4 * DEEPEST;

/// The calls of a condition during parsing.
#[derive(Default)]
struct ParsedCondition {
    calls: Vec<WrittenStep>,
    /// Comments before the first call.
    early: Vec<String>,
    depth: usize,
}

impl ParsedCondition {
    fn say(&mut self, words: String) {
        match self.calls.last_mut() {
            Some(call) => join(&mut call.explanation, &words),
            None => self.early.push(words),
        }
    }

    /// Replaces call indices by the calls.
    fn whole(&self, test: &Test<usize>) -> Test<WrittenStep> {
        test.map(&mut Test::Sense, &mut |call| Test::Holds(self.calls[*call].clone()))
    }
}

impl Parser<'_> {
    /// Parses a condition and the block that depends on it.
    pub(super) fn guarded(&mut self, word: &str) -> Result<(Test<WrittenStep>, Vec<WrittenNode>), Fault> {
        let start = self.tokens[self.next - 1].at;
        let mut condition = ParsedCondition::default();
        let test = self.any(&mut condition)?;
        self.expect(":", &format!("a line with `{word}` ends with a colon"))?;
        self.comments().into_iter().for_each(|words| condition.say(words));
        if let Some(first) = condition.calls.first_mut() {
            let mut words = condition.early.join(" ");
            if !words.is_empty() && !first.explanation.is_empty() {
                words.push(' ');
            }
            first.explanation.insert_str(0, &words);
        }
        let test = condition.whole(&test);
        if self.depth + 1 + test.depth() > DEEPEST {
            return fault(
                start,
                format!("conditions and branches stand more than {DEEPEST} deep in each other"),
                "say the same in fewer branches",
            );
        }
        Ok((test, self.block()?))
    }

    fn any(&mut self, condition: &mut ParsedCondition) -> Result<Test<usize>, Fault> {
        let parts = self.parts(condition, "or", Self::all)?;
        Ok(one_or(parts, Test::Any))
    }

    fn all(&mut self, condition: &mut ParsedCondition) -> Result<Test<usize>, Fault> {
        let parts = self.parts(condition, "and", Self::part)?;
        Ok(one_or(parts, Test::All))
    }

    fn parts(
        &mut self,
        condition: &mut ParsedCondition,
        word: &str,
        read: impl Fn(&mut Self, &mut ParsedCondition) -> Result<Test<usize>, Fault>,
    ) -> Result<Vec<Test<usize>>, Fault> {
        let mut parts = vec![read(self, condition)?];
        while self.take_word(word) {
            parts.push(read(self, condition)?);
        }
        Ok(parts)
    }

    /// Parses a call, a negation, or a condition in parentheses.
    fn part(&mut self, condition: &mut ParsedCondition) -> Result<Test<usize>, Fault> {
        self.comments().into_iter().for_each(|words| condition.say(words));
        if condition.depth == DEEPEST_CONDITION {
            return self.fail(
                format!("parentheses and `not` stand more than {DEEPEST_CONDITION} deep in each other"),
                "take out those that change nothing",
            );
        }
        condition.depth += 1;
        let test = if self.take_word("not") {
            Test::Not(Box::new(self.part(condition)?))
        } else if self.take(&Kind::Sign("(")) {
            let inside = self.any(condition)?;
            self.expect(")", "close the parenthesis")?;
            inside
        } else {
            const HINT: &str =
                "a condition asks with calls, as in `if check_date():` or `if not on(\"<cup>\", \"<table>\"):`";
            match self.peek() {
                Kind::Name("True" | "False" | "None") => return self.fail("this is decided already", HINT),
                Kind::Name(word) if !is_script_keyword(word) => {}
                _ => return self.unexpected("a call is missing here", HINT),
            }
            let call = self.call()?;
            condition.calls.push(call);
            Test::Holds(condition.calls.len() - 1)
        };
        condition.depth -= 1;
        self.comments().into_iter().for_each(|words| condition.say(words));
        Ok(test)
    }
}

fn one_or(mut parts: Vec<Test<usize>>, join: impl FnOnce(Vec<Test<usize>>) -> Test<usize>) -> Test<usize> {
    match parts.len() {
        1 => parts.swap_remove(0),
        _ => join(parts),
    }
}
