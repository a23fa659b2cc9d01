//! Parser for scripts: tokens to a written plan.

mod condition;
mod foreign;
mod lanes;

use super::super::tree::DEEPEST;
use super::super::written::{Written, WrittenNode, WrittenStep, is_argument};
use super::super::{Node, StepId};
use super::token::{Kind, Token};
use super::write::OBJECTS;
use super::{Fault, fault};
use longstep_model::call::{Call, is_script_keyword};

/// Allowed statements, for hints.
const STATEMENTS: &str = "a plan has calls such as `grasp(\"<cup>\")`, `if`, `while`, `for _ in range(N)`, \
                          `with parallel()`, `pass` and comments";

pub(super) fn plan(tokens: Vec<Token<'_>>) -> Result<Written, Fault> {
    let mut parser = Parser {
        tokens,
        next: 0,
        depth: 0,
        steps: Vec::new(),
    };
    let objects = parser.objects()?;
    let body = parser.nodes()?;
    match parser.peek() {
        Kind::End => {}
        Kind::Indent => return parser.fail("nothing opens a block here", "indent this line like the one before it"),
        _ => return parser.unknown(),
    }
    Ok(Written {
        steps: parser.steps,
        body,
        objects,
    })
}

struct Parser<'t> {
    tokens: Vec<Token<'t>>,
    next: usize,
    /// Number of open branches and loops.
    depth: usize,
    steps: Vec<WrittenStep>,
}

impl<'t> Parser<'t> {
    fn peek(&self) -> &Kind<'t> {
        &self.tokens[self.next.min(self.tokens.len() - 1)].kind
    }

    fn at(&self) -> usize {
        self.tokens[self.next.min(self.tokens.len() - 1)].at
    }

    fn fail<T>(&self, message: impl Into<String>, hint: impl Into<String>) -> Result<T, Fault> {
        fault(self.at(), message, hint)
    }

    fn take(&mut self, kind: &Kind<'_>) -> bool {
        let taken = self.peek() == kind;
        self.next += usize::from(taken);
        taken
    }

    fn word(&self) -> Option<&'t str> {
        match self.peek() {
            Kind::Name(word) => Some(word),
            _ => None,
        }
    }

    fn take_word(&mut self, word: &str) -> bool {
        let taken = self.word() == Some(word);
        self.next += usize::from(taken);
        taken
    }

    fn expect(&mut self, sign: &'static str, hint: &str) -> Result<(), Fault> {
        if self.take(&Kind::Sign(sign)) {
            Ok(())
        } else {
            self.unexpected(&format!("`{sign}` is missing before this"), hint)
        }
    }

    /// Fails at the next token: names it if it is unsupported Python, otherwise uses `message`.
    fn unexpected<T>(&self, message: &str, hint: &str) -> Result<T, Fault> {
        match self.foreign() {
            Some((what, instead)) => self.fail(format!("this is {what}, which no plan has"), instead),
            None => self.fail(message, hint),
        }
    }

    fn unknown<T>(&self) -> Result<T, Fault> {
        self.unexpected("this is nothing that a plan has", STATEMENTS)
    }

    /// Parses the object list in the first comment of a plan.
    fn objects(&mut self) -> Result<Vec<String>, Fault> {
        let Kind::Objects(words) = self.peek() else {
            return Ok(Vec::new());
        };
        let Some(list) = words.strip_prefix(OBJECTS) else {
            return Ok(Vec::new());
        };
        match serde_json::from_str(list.trim()) {
            Ok(objects) => {
                self.next += 1;
                Ok(objects)
            }
            Err(_) => self.fail(
                "the list of objects cannot be read",
                "write it as `# objects: [\"<cup>\", \"<plate>\"]`",
            ),
        }
    }

    /// Parses statements up to the end of a block.
    fn nodes(&mut self) -> Result<Vec<WrittenNode>, Fault> {
        let mut nodes = Vec::new();
        loop {
            nodes.extend(self.remarks());
            match self.word() {
                None => match self.peek() {
                    Kind::Dedent | Kind::End => return Ok(nodes),
                    Kind::Indent => {
                        return self.fail("nothing opens a block here", "indent this line like the one before it");
                    }
                    _ => return self.unknown(),
                },
                Some(_) => self.statement(&mut nodes)?,
            }
        }
    }

    /// Consumes comments on lines of their own.
    fn remarks(&mut self) -> Vec<WrittenNode> {
        self.words_alone().into_iter().map(Node::Remark).collect()
    }

    fn words_alone(&mut self) -> Vec<String> {
        let mut words = Vec::new();
        while let Kind::Remark(remark) | Kind::Objects(remark) = self.peek() {
            words.push(remark.clone());
            self.next += 1;
        }
        words
    }

    /// Returns true if only comments come before an `else` or `elif`.
    fn alternative_ahead(&self) -> bool {
        let mut ahead = self.tokens[self.next..].iter().map(|token| &token.kind);
        let next = ahead.find(|kind| !matches!(kind, Kind::Remark(_) | Kind::Objects(_)));
        matches!(next, Some(Kind::Name("else" | "elif")))
    }

    fn statement(&mut self, nodes: &mut Vec<WrittenNode>) -> Result<(), Fault> {
        match self.word() {
            Some("if") => {
                let node = self.decision()?;
                nodes.push(node);
            }
            Some("while") => {
                self.next += 1;
                let (condition, body) = self.guarded("while")?;
                nodes.push(Node::While { condition, body });
            }
            Some("for") => {
                let times = self.range()?;
                let body = self.body("for")?;
                nodes.push(Node::Repeat { times, body });
            }
            Some("with") => self.parallel(nodes)?,
            Some("pass") => {
                self.next += 1;
                nodes.extend(self.line_end()?.into_iter().map(Node::Remark));
            }
            Some("elif" | "else") => {
                return self.fail("no `if` stands before this", "write the `if` that it belongs to");
            }
            _ => {
                let step = self.step()?;
                nodes.push(Node::Step(step));
            }
        }
        Ok(())
    }

    fn step(&mut self) -> Result<StepId, Fault> {
        let mut step = self.call()?;
        for words in self.line_end()? {
            join(&mut step.explanation, &words);
        }
        self.steps.push(step);
        Ok(StepId::new(self.steps.len() - 1))
    }

    /// Consumes the end of a line and returns the comments before it.
    fn line_end(&mut self) -> Result<Vec<String>, Fault> {
        let comments = self.comments();
        if self.take(&Kind::Newline) {
            Ok(comments)
        } else {
            self.unexpected("the line should end here", "write each call on a line of its own")
        }
    }

    fn comments(&mut self) -> Vec<String> {
        let mut comments = Vec::new();
        while let Kind::Comment(words) = self.peek() {
            comments.push(words.clone());
            self.next += 1;
        }
        comments
    }

    /// Parses a call with its arguments; comments between them become its explanation.
    fn call(&mut self) -> Result<WrittenStep, Fault> {
        let start = self.at();
        let Some(name) = self
            .word()
            .filter(|name| !is_script_keyword(name) && !name.starts_with('<'))
        else {
            return match self.word() {
                Some("lane") => self.fail("this is a lane outside of `with parallel():`", "put it into one"),
                Some("sync") => self.fail("only lanes wait for each other", "put it into a `with lane(...):`"),
                _ => self.unknown(),
            };
        };
        self.next += 1;
        if !matches!(self.peek(), Kind::Sign("(")) {
            let message = format!("`{name}` is no call");
            let hint = format!("write `{name}()`, with its arguments in the parentheses");
            return match self.foreign().filter(|_| matches!(self.peek(), Kind::Sign(_))) {
                Some((what, instead)) => self.fail(format!("this is {what}, which no plan has"), instead),
                None => fault(start, message, hint),
            };
        }
        self.next += 1;
        let mut step = WrittenStep {
            call: Call {
                name: name.to_owned(),
                arguments: Vec::new(),
            },
            implicit: Vec::new(),
            explanation: String::new(),
        };
        loop {
            self.comments()
                .iter()
                .for_each(|words| join(&mut step.explanation, words));
            if self.take(&Kind::Sign(")")) {
                return Ok(step);
            }
            self.argument(&mut step)?;
            self.comments()
                .iter()
                .for_each(|words| join(&mut step.explanation, words));
            if !self.take(&Kind::Sign(",")) && !matches!(self.peek(), Kind::Sign(")")) {
                return match self.peek() {
                    Kind::Sign("(") => self.fail("this is a call in a call", "name things, as in `grasp(\"<cup>\")`"),
                    Kind::Text(_) => self.fail("this is a second text", "put a comma between arguments"),
                    _ => self.unexpected("`,` or `)` is missing before this", "separate arguments by commas"),
                };
            }
        }
    }

    fn argument(&mut self, step: &mut WrittenStep) -> Result<(), Fault> {
        const HINT: &str = "an argument is a name, as in `grasp(\"<cup>\")` or `grasp(cup)`";
        let at = self.at();
        let following = self.tokens.get(self.next + 1).map(|token| &token.kind);
        if let (Some(name), Some(Kind::Sign("="))) = (self.word(), following) {
            self.next += 2;
            let name = match name.strip_suffix('_') {
                Some(kept) if is_script_keyword(kept.trim_end_matches('_')) => kept,
                _ => name,
            };
            if name.starts_with('<') || step.implicit.iter().any(|(before, _)| before == name) {
                return fault(
                    at,
                    "this parameter cannot be given here",
                    "give each parameter once, by its name",
                );
            }
            let value = self.value(HINT)?;
            step.implicit.push((name.to_owned(), value));
            return Ok(());
        }
        let argument = self.value(HINT)?.trim().to_owned();
        if !is_argument(&argument) {
            return fault(at, "this names nothing", HINT);
        }
        if !step.implicit.is_empty() {
            return fault(
                at,
                "this stands behind a parameter that is given by name",
                "put it first",
            );
        }
        step.call.arguments.push(argument);
        Ok(())
    }

    fn value(&mut self, hint: &str) -> Result<String, Fault> {
        let value = match self.peek() {
            Kind::Text(text) => text.clone(),
            Kind::Number(digits) => (*digits).to_owned(),
            Kind::Name(name) if !is_script_keyword(name) => {
                let following = self.tokens.get(self.next + 1).map(|token| &token.kind);
                if let (1, Some(Kind::Text(_))) = (name.chars().count(), following) {
                    return self.fail(
                        format!("this is a text with the prefix `{name}`, which no plan has"),
                        hint,
                    );
                }
                (*name).to_owned()
            }
            _ => return self.unexpected("an argument is missing here", hint),
        };
        self.next += 1;
        Ok(value)
    }

    fn decision(&mut self) -> Result<WrittenNode, Fault> {
        self.next += 1;
        let (condition, then) = self.guarded("if")?;
        let mut otherwise = Vec::new();
        if matches!(self.peek(), Kind::Name("else" | "elif")) || self.alternative_ahead() {
            otherwise.extend(self.remarks());
            if self.word() == Some("elif") {
                let another = self.deeper(Self::decision)?;
                otherwise.push(another);
            } else {
                self.next += 1;
                let mut nodes = self.body("else")?;
                otherwise.append(&mut nodes);
            }
        }
        Ok(Node::If {
            condition,
            then,
            otherwise,
        })
    }

    /// Parses content one branch or loop deeper.
    fn deeper<T>(&mut self, read: impl FnOnce(&mut Self) -> Result<T, Fault>) -> Result<T, Fault> {
        if self.depth == DEEPEST {
            return self.fail(
                format!("branches and loops stand more than {DEEPEST} deep in each other"),
                "say the same in fewer branches",
            );
        }
        self.depth += 1;
        let inside = read(self)?;
        self.depth -= 1;
        Ok(inside)
    }

    /// Parses the colon, the comments after it and the block.
    fn body(&mut self, word: &str) -> Result<Vec<WrittenNode>, Fault> {
        self.expect(":", &format!("a line with `{word}` ends with a colon"))?;
        let mut nodes: Vec<WrittenNode> = self.comments().into_iter().map(Node::Remark).collect();
        nodes.append(&mut self.block()?);
        Ok(nodes)
    }

    /// Parses the block after a colon, indented or on the same line.
    fn block(&mut self) -> Result<Vec<WrittenNode>, Fault> {
        self.deeper(|parser| {
            if !parser.take(&Kind::Newline) {
                return match parser.word() {
                    Some("if" | "while" | "for" | "with") => {
                        parser.fail("this opens a block in a line", "put it on a line of its own, indented")
                    }
                    _ => {
                        let mut nodes = Vec::new();
                        parser.statement(&mut nodes)?;
                        Ok(nodes)
                    }
                };
            }
            parser.indent()?;
            let nodes = parser.nodes()?;
            parser.dedent()?;
            Ok(nodes)
        })
    }

    fn indent(&mut self) -> Result<(), Fault> {
        if self.take(&Kind::Indent) {
            Ok(())
        } else {
            self.fail(
                "a block is missing before this",
                "indent what belongs to the line before, or write `pass` there",
            )
        }
    }

    fn dedent(&mut self) -> Result<(), Fault> {
        if self.take(&Kind::Dedent) {
            Ok(())
        } else {
            self.unknown()
        }
    }

    /// Parses `for _ in range(N)`; returns N.
    fn range(&mut self) -> Result<u32, Fault> {
        const HINT: &str = "a loop that counts is written `for _ in range(3):`";
        self.next += 1;
        let named = self.word().is_some_and(|word| !is_script_keyword(word));
        self.next += usize::from(named);
        if !named || !self.take_word("in") || !self.take_word("range") || !self.take(&Kind::Sign("(")) {
            return self.fail("no plan has a loop like this", HINT);
        }
        let Kind::Number(digits) = self.peek() else {
            return self.fail("a number is missing here", HINT);
        };
        let Some(times) = digits
            .parse()
            .ok()
            .filter(|_| digits.bytes().all(|byte| byte.is_ascii_digit()))
        else {
            return self.fail("this is no number of times", HINT);
        };
        self.next += 1;
        if self.take(&Kind::Sign(")")) {
            Ok(times)
        } else {
            self.fail("no plan has a loop like this", HINT)
        }
    }
}

fn join(words: &mut String, more: &str) {
    if !words.is_empty() {
        words.push(' ');
    }
    words.push_str(more);
}
