//! Module for Python.

use std::fmt::Write;

use super::comment::{lines, literal};
use super::function::{Function, Functions, Outcomes, WordPart};

/// The text before the class of the robot.
const SUPPORT: &str = include_str!("support.py");

/// The text behind it.
const REGISTRATION: &str = include_str!("registration.py");

/// Writes the module of a domain.
pub(super) fn write(functions: &Functions) -> String {
    let mut text = String::new();
    let head = format!(
        "Nodes for the behavior trees of the domain {}, written by `longstep domain nodes`. Derive a class from `Robot`, \
         and give it to `load`. The package `behaviortreepy` ticks the tree.",
        functions.domain
    );
    docstring(&mut text, "", &format!("{head} {}", functions.about));
    text.push('\n');
    text.push_str(SUPPORT);
    for outcomes in functions.actions.iter().filter_map(|action| action.outcomes.as_ref()) {
        enumeration(&mut text, outcomes);
    }
    robot(&mut text, functions);
    text.push_str(REGISTRATION);
    leaves(&mut text, functions);
    text
}

/// Writes a docstring. A backslash begins no escape in it, and a quotation mark does not end it.
fn docstring(text: &mut String, indent: &str, sentence: &str) {
    let lines = lines(sentence).into_iter();
    let lines: Vec<String> = lines.map(|line| line.replace('\\', "\\\\").replace('"', "'")).collect();
    let _ = writeln!(text, "{indent}\"\"\"{}\"\"\"", lines.join(&format!("\n{indent}")));
}

fn enumeration(text: &mut String, outcomes: &Outcomes) {
    let _ = writeln!(text, "class {}(enum.Enum):", outcomes.name);
    docstring(text, "    ", "The outcomes of a sensing action.");
    text.push('\n');
    for (number, value) in outcomes.values.iter().enumerate() {
        for line in lines(&value.about) {
            let _ = writeln!(text, "    # {line}");
        }
        let _ = writeln!(text, "    {} = {number}", value.name);
    }
    text.push_str("\n\n");
}

fn robot(text: &mut String, functions: &Functions) {
    text.push_str("class Robot(abc.ABC):\n");
    docstring(
        text,
        "    ",
        "The robot. Arguments are the names of entities in the environment. An action begins, and returns without waiting. \
         An exception halts all actions that have begun, and is raised by the tree.",
    );
    for action in &functions.actions {
        method(text, action, &format!("Task[{}]", action.result()));
    }
    for condition in &functions.conditions {
        method(text, condition, "bool");
    }
    text.push_str("\n\n");
}

fn method(text: &mut String, function: &Function, result: &str) {
    let arguments = function
        .arguments
        .iter()
        .map(|argument| format!(", {}: str", argument.name));
    let abstraction = if function.is_rare {
        ""
    } else {
        "    @abc.abstractmethod\n"
    };
    let _ = writeln!(
        text,
        "\n{abstraction}    def {}(self{}) -> {result}:",
        function.name,
        arguments.collect::<String>()
    );
    docstring(text, "        ", &function.about);
    if function.is_rare {
        let reason = literal(&format!("this robot has no condition {}", function.leaf));
        let _ = writeln!(text, "        raise NotImplementedError({reason})");
    }
}

fn leaves(text: &mut String, functions: &Functions) {
    text.push_str("_LEAVES: dict[str, _Leaf] = {\n");
    for (function, is_action) in functions
        .actions
        .iter()
        .map(|action| (action, true))
        .chain(functions.conditions.iter().map(|condition| (condition, false)))
    {
        let ports = function.arguments.iter().map(|argument| literal(&argument.port));
        let passed = (0..function.arguments.len()).map(|place| format!("texts[{place}]"));
        let result = if is_action { function.result() } else { "bool" };
        let _ = write!(
            text,
            "    {}: _Leaf(\n        [{}],\n        lambda robot, texts: robot.{}({}),\n        {result},\n",
            literal(&function.leaf),
            ports.collect::<Vec<_>>().join(", "),
            function.name,
            passed.collect::<Vec<_>>().join(", ")
        );
        if let Some(outcomes) = &function.outcomes {
            let _ = writeln!(text, "        lambda texts: [{}],", words(outcomes));
        }
        text.push_str("    ),\n");
    }
    text.push_str("}\n");
}

fn words(outcomes: &Outcomes) -> String {
    let part = |part: &WordPart| match part {
        WordPart::Text(text) => literal(text),
        WordPart::Argument(place) => format!("texts[{place}]"),
    };
    let word = |parts: &Vec<WordPart>| format!("[{}]", parts.iter().map(part).collect::<Vec<_>>().join(", "));
    let all: Vec<String> = outcomes.values.iter().map(|value| word(&value.word)).collect();
    all.join(", ")
}
