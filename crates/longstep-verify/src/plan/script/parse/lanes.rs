//! Parser for `with parallel():` and its lanes.

use super::super::super::tree::{DEEPEST, Lane};
use super::super::super::written::WrittenNode;
use super::super::super::{LaneItem, Node};
use super::super::token::Kind;
use super::super::{Fault, fault};
use super::Parser;

impl Parser<'_> {
    pub(super) fn parallel(&mut self, nodes: &mut Vec<WrittenNode>) -> Result<(), Fault> {
        const HINT: &str = "lanes are written `with parallel():` and in it `with lane(\"left\"):`, each with its calls";
        let start = self.at();
        self.next += 1;
        let opened = self.take_word("parallel") && self.take(&Kind::Sign("(")) && self.take(&Kind::Sign(")"));
        if !opened || !self.take(&Kind::Sign(":")) {
            return match self.word() {
                Some("lane") => fault(start, "this is a lane outside of `with parallel():`", HINT),
                _ => self.fail("no plan has a `with` like this", HINT),
            };
        }
        nodes.extend(self.line_end()?.into_iter().map(Node::Remark));
        self.indent()?;
        if self.depth == DEEPEST {
            return fault(
                start,
                format!("blocks stand more than {DEEPEST} deep in each other"),
                HINT,
            );
        }
        let mut lanes: Vec<Lane<String>> = Vec::new();
        loop {
            let at = self.at();
            let remarks = self.words_alone();
            if !self.take_word("with") {
                let Some(last) = lanes.last_mut().filter(|_| matches!(self.peek(), Kind::Dedent)) else {
                    return self.fail("a lane is missing here", HINT);
                };
                last.items.extend(remarks.into_iter().map(LaneItem::Remark));
                break;
            }
            let opened = self.take_word("lane") && self.take(&Kind::Sign("("));
            if !opened {
                return self.fail("a lane is missing here", HINT);
            }
            let actor = self.value(HINT)?;
            if !self.take(&Kind::Sign(")")) || !self.take(&Kind::Sign(":")) {
                return self.fail("a lane has one actor, and a colon behind it", HINT);
            }
            if lanes.iter().any(|lane| lane.actor == actor) {
                let message = format!("`{actor}` has a lane already");
                return fault(at, message, "put all that it does into one lane");
            }
            let mut items: Vec<LaneItem> = remarks.into_iter().map(LaneItem::Remark).collect();
            items.extend(self.line_end()?.into_iter().map(LaneItem::Remark));
            self.indent()?;
            self.items(&mut items)?;
            self.dedent()?;
            lanes.push(Lane { actor, items });
        }
        self.dedent()?;
        nodes.push(Node::Parallel { lanes });
        Ok(())
    }

    /// Parses the items of a lane.
    fn items(&mut self, items: &mut Vec<LaneItem>) -> Result<(), Fault> {
        loop {
            items.extend(self.words_alone().into_iter().map(LaneItem::Remark));
            match self.word() {
                None => return Ok(()),
                Some("pass") => {
                    self.next += 1;
                    items.extend(self.line_end()?.into_iter().map(LaneItem::Remark));
                }
                Some("sync") => {
                    const HINT: &str = "lanes wait for each other at `sync(\"name\")`";
                    self.next += 1;
                    self.expect("(", HINT)?;
                    let name = self.value(HINT)?;
                    self.expect(")", HINT)?;
                    let remarks = self.line_end()?;
                    items.extend(remarks.into_iter().map(LaneItem::Remark));
                    items.push(LaneItem::Sync(name));
                }
                Some("if" | "elif" | "else" | "while" | "for" | "with") => {
                    return self.fail(
                        "nothing branches or repeats in a lane",
                        "branch around `with parallel():`, or write every step",
                    );
                }
                Some(_) => {
                    let step = self.step()?;
                    items.push(LaneItem::Step(step));
                }
            }
        }
    }
}
