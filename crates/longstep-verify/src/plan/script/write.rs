//! Writer for scripts.

use std::fmt::Write as _;

use super::super::written::{Written, WrittenNode, WrittenStep};
use super::super::{LaneItem, Node, Test};
use longstep_model::call::is_script_keyword;
use longstep_model::visible;

/// Writes a plan as a script; [`super::read`] returns an equal plan.
///
/// Text that a comment cannot contain literally, such as a line break, is written as a quoted JSON string. Control
/// characters, bidirectional controls and zero-width characters are escaped in comments and strings.
pub fn write(plan: &Written) -> String {
    let mut writer = Writer {
        plan,
        script: String::new(),
        depth: 0,
    };
    if !plan.objects.is_empty() {
        let names: Vec<String> = plan.objects.iter().map(|name| json(name)).collect();
        writer.line(&format!("# {OBJECTS} [{}]", names.join(", ")));
    }
    writer.nodes(&plan.body);
    writer.script
}

/// Prefix of the comment that lists the handled objects.
pub(super) const OBJECTS: &str = "objects:";

struct Writer<'p> {
    plan: &'p Written,
    script: String,
    depth: usize,
}

impl Writer<'_> {
    fn line(&mut self, text: &str) {
        let _ = writeln!(self.script, "{:indent$}{text}", "", indent = 4 * self.depth);
    }

    /// Writes a header line and its block; `pass` if the block is `idle`.
    fn block(&mut self, head: &str, idle: bool, inside: impl FnOnce(&mut Self)) {
        self.line(head);
        self.depth += 1;
        inside(self);
        if idle {
            self.line("pass");
        }
        self.depth -= 1;
    }

    fn nodes(&mut self, nodes: &[WrittenNode]) {
        for node in nodes {
            self.node(node);
        }
    }

    fn branch(&mut self, head: &str, nodes: &[WrittenNode]) {
        let idle = nodes.iter().all(|node| matches!(node, Node::Remark(_)));
        self.block(head, idle, |writer| writer.nodes(nodes));
    }

    fn node(&mut self, node: &WrittenNode) {
        match node {
            Node::Step(step) => self.step(step.index()),
            Node::Remark(words) => self.line(&comment(words)),
            Node::If { .. } => self.decision("if", node),
            Node::While { condition, body } => {
                let head = self.head("while", condition);
                self.branch(&head, body);
            }
            Node::Repeat { times, body } => self.branch(&format!("for _ in range({times}):"), body),
            Node::Parallel { lanes } => self.block("with parallel():", lanes.is_empty(), |writer| {
                for lane in lanes {
                    let idle = lane.items.iter().all(|item| matches!(item, LaneItem::Remark(_)));
                    let head = format!("with lane({}):", quoted(&lane.actor));
                    writer.block(&head, idle, |writer| {
                        lane.items.iter().for_each(|item| writer.item(item))
                    });
                }
            }),
        }
    }

    fn decision(&mut self, word: &str, node: &WrittenNode) {
        let Node::If {
            condition,
            then,
            otherwise,
        } = node
        else {
            return;
        };
        let head = self.head(word, condition);
        self.branch(&head, then);
        match otherwise.as_slice() {
            [] => {}
            [another @ Node::If { .. }] => self.decision("elif", another),
            _ => self.branch("else:", otherwise),
        }
    }

    fn item(&mut self, item: &LaneItem) {
        match item {
            LaneItem::Step(step) => self.step(step.index()),
            LaneItem::Sync(name) => self.line(&format!("sync({})", quoted(name))),
            LaneItem::Remark(words) => self.line(&comment(words)),
        }
    }

    fn step(&mut self, index: usize) {
        let Some(step) = self.plan.steps.get(index) else {
            return;
        };
        let text = call(step);
        let behind = behind(&step.explanation);
        self.line(&format!("{text}{behind}"));
    }

    /// Writes `if` or `while` with its condition. The explanation of the last call goes to the end of the line; an
    /// explanation of an earlier call is followed by a line break.
    fn head(&self, word: &str, condition: &Test<WrittenStep>) -> String {
        let mut pieces = Vec::new();
        collect(condition, &mut pieces);
        let last = pieces.iter().rposition(|piece| matches!(piece, Piece::Call(_)));
        let mut text = String::new();
        let mut breaks = false;
        let mut last_words = String::new();
        for (index, piece) in pieces.into_iter().enumerate() {
            match piece {
                Piece::Word(word) if text.ends_with(' ') => text.push_str(word.trim_start()),
                Piece::Word(word) => text.push_str(word),
                Piece::Call(step) => {
                    text.push_str(&call(step));
                    let words = behind(&step.explanation);
                    if Some(index) == last {
                        last_words = words;
                    } else if !words.is_empty() {
                        breaks = true;
                        let _ = write!(text, "{words}\n{:indent$}", "", indent = 4 * (self.depth + 1));
                    }
                }
            }
        }
        if breaks {
            format!("{word} ({text}):{last_words}")
        } else {
            format!("{word} {text}:{last_words}")
        }
    }
}

enum Piece<'p> {
    Word(&'static str),
    Call(&'p WrittenStep),
}

fn collect<'p>(condition: &'p Test<WrittenStep>, pieces: &mut Vec<Piece<'p>>) {
    let mut joined = |parts: &'p [Test<WrittenStep>], word| {
        for (index, part) in parts.iter().enumerate() {
            if index > 0 {
                pieces.push(Piece::Word(word));
            }
            enclosed(part, pieces);
        }
    };
    match condition {
        Test::Holds(step) => pieces.push(Piece::Call(step)),
        // Conditions of a written plan contain calls only.
        Test::Sense(_) => {}
        Test::Not(inner) => {
            pieces.push(Piece::Word("not "));
            enclosed(inner, pieces);
        }
        Test::All(parts) => joined(parts, " and "),
        Test::Any(parts) => joined(parts, " or "),
    }
}

/// Writes a part of a condition, in parentheses if it is a conjunction or disjunction.
fn enclosed<'p>(part: &'p Test<WrittenStep>, pieces: &mut Vec<Piece<'p>>) {
    if matches!(part, Test::All(_) | Test::Any(_)) {
        pieces.push(Piece::Word("("));
        collect(part, pieces);
        pieces.push(Piece::Word(")"));
    } else {
        collect(part, pieces);
    }
}

fn call(step: &WrittenStep) -> String {
    let shown = step.call.arguments.iter().map(|argument| quoted(argument));
    let named = step
        .implicit
        .iter()
        .map(|(name, value)| format!("{}={}", keyword(name), quoted(value)));
    let arguments: Vec<String> = shown.chain(named).collect();
    format!("{}({})", step.call.name, arguments.join(", "))
}

/// Returns the explanation of a call as a trailing comment.
fn behind(explanation: &str) -> String {
    match explanation {
        "" => String::new(),
        _ => format!("  {}", comment(explanation)),
    }
}

fn comment(words: &str) -> String {
    let plain = !words.is_empty()
        && words.trim() == words
        && !words.starts_with(['#', '"'])
        && !words.starts_with(OBJECTS)
        && !words.contains(visible::is_hidden);
    if plain {
        format!("# {words}")
    } else {
        format!("# {}", json(words))
    }
}

/// Returns a quoted JSON string, the form in comments.
fn json(text: &str) -> String {
    visible::json(&serde_json::Value::from(text).to_string()).into_owned()
}

/// Returns a quoted Python string; control and hidden characters are escaped.
fn quoted(text: &str) -> String {
    let quoted = serde_json::Value::from(text).to_string();
    if !quoted.contains(visible::is_hidden) {
        return quoted;
    }
    let mut shown = String::with_capacity(quoted.len() + 16);
    for character in quoted.chars() {
        let _ = match (visible::is_hidden(character), u32::from(character)) {
            (false, _) => write!(shown, "{character}"),
            (true, code @ ..=0xffff) => write!(shown, "\\u{code:04x}"),
            (true, code) => write!(shown, "\\U{code:08x}"),
        };
    }
    shown
}

/// Returns a parameter's name before `=`; names that are reserved in Python get an additional underscore.
fn keyword(name: &str) -> String {
    if is_script_keyword(name.trim_end_matches('_')) {
        format!("{name}_")
    } else {
        name.to_owned()
    }
}
