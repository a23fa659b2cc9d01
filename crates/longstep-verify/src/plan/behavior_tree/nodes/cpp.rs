//! Header in C++17.

use std::fmt::Write;

use super::comment::{lines, literal};
use super::function::{Function, Functions, Outcomes, WordPart};

/// The text before the class of the robot.
const SUPPORT: &str = include_str!("support.hpp");

/// The text between the class of the robot and the registration.
const REGISTRATION: &str = include_str!("registration.hpp");

const INCLUDES: [&str; 18] = [
    "algorithm",
    "cctype",
    "chrono",
    "condition_variable",
    "cstddef",
    "functional",
    "future",
    "memory",
    "mutex",
    "optional",
    "stdexcept",
    "string",
    "type_traits",
    "utility",
    "variant",
    "vector",
    "",
    "behaviortree_cpp/bt_factory.h",
];

/// Writes the header of a domain.
pub(super) fn write(functions: &Functions) -> String {
    let mut text = String::from("#pragma once\n\n");
    let head = format!(
        "Nodes for the behavior trees of the domain {}, written by `longstep domain nodes`. Derive a class from `Robot`, \
         and give it to `register_nodes`.",
        functions.domain
    );
    comment(&mut text, "", &head);
    comment(&mut text, "", &functions.about);
    text.push('\n');
    for include in INCLUDES {
        let _ = match include {
            "" => writeln!(text),
            local if local.contains('/') => writeln!(text, "#include \"{local}\""),
            standard => writeln!(text, "#include <{standard}>"),
        };
    }
    let _ = writeln!(text, "\nnamespace longstep::{} {{\n", functions.namespace);
    text.push_str(SUPPORT);
    for outcomes in functions.actions.iter().filter_map(|action| action.outcomes.as_ref()) {
        enumeration(&mut text, outcomes);
    }
    robot(&mut text, functions);
    text.push_str(REGISTRATION);
    registration(&mut text, functions);
    let _ = writeln!(text, "}}  // namespace longstep::{}", functions.namespace);
    text
}

fn comment(text: &mut String, indent: &str, sentence: &str) {
    for line in lines(sentence) {
        let _ = writeln!(text, "{indent}/// {line}");
    }
}

fn enumeration(text: &mut String, outcomes: &Outcomes) {
    let _ = writeln!(text, "enum class {} {{", outcomes.name);
    for value in &outcomes.values {
        comment(text, "  ", &value.about);
        let _ = writeln!(text, "  {},", value.name);
    }
    text.push_str("};\n\n");
}

fn robot(text: &mut String, functions: &Functions) {
    text.push_str(
        "/// The robot. Arguments are the names of entities in the environment. An exception from a function halts all actions\n\
         /// that have begun, and leaves the tick of the tree.\n\
         class Robot {\n public:\n  Robot() = default;\n  Robot(const Robot&) = delete;\n  Robot& operator=(const Robot&) = delete;\n  \
         virtual ~Robot() = default;\n\n  // Actions. Each begins, and returns without waiting.\n\n",
    );
    for action in &functions.actions {
        comment(text, "  ", &action.about);
        let result = format!("Begun<{}>", action.result());
        let _ = writeln!(
            text,
            "  virtual {result} {}({}) = 0;\n",
            action.name,
            parameters(action, true)
        );
    }
    text.push_str("  // Conditions, which branches and loops ask, and the preconditions of `--guards`.\n\n");
    for condition in functions.conditions.iter().filter(|condition| !condition.is_rare) {
        comment(text, "  ", &condition.about);
        let _ = writeln!(
            text,
            "  virtual bool {}({}) = 0;\n",
            condition.name,
            parameters(condition, true)
        );
    }
    if functions.conditions.iter().any(|condition| condition.is_rare) {
        text.push_str("  // Conditions that few plans have: on facts that no action changes, and on events.\n\n");
    }
    for condition in functions.conditions.iter().filter(|condition| condition.is_rare) {
        comment(text, "  ", &condition.about);
        let _ = writeln!(
            text,
            "  virtual bool {}({}) {{\n    throw std::logic_error({});\n  }}\n",
            condition.name,
            parameters(condition, false),
            literal(&format!("this robot has no condition {}", condition.leaf))
        );
    }
    text.truncate(text.trim_end().len());
    text.push_str("\n};\n\n");
}

fn parameters(function: &Function, with_names: bool) -> String {
    let parameter = |name: &str| {
        if with_names {
            format!("const std::string& {name}")
        } else {
            format!("const std::string& /* {name} */")
        }
    };
    let parameters = function.arguments.iter().map(|argument| parameter(&argument.name));
    parameters.collect::<Vec<_>>().join(", ")
}

fn registration(text: &mut String, functions: &Functions) {
    text.push_str(
        "/// Registers a node for every leaf that a tree of this domain can have.\n\
         inline void register_nodes(BT::BehaviorTreeFactory& factory, std::shared_ptr<Robot> robot) {\n  \
         if (!robot) throw BT::RuntimeError(\"register_nodes needs a robot\");\n  \
         const auto session = std::make_shared<detail::Session>();\n  session->robot = std::move(robot);\n",
    );
    for action in &functions.actions {
        let _ = write!(
            text,
            "  detail::action<{}>(factory, session, {}, {},\n                 {} {{ return robot_.{}({}); }}",
            action.result(),
            literal(&action.leaf),
            ports(action),
            lambda(action),
            action.name,
            passed(action)
        );
        if let Some(outcomes) = &action.outcomes {
            let _ = write!(text, ",\n                 {}", words(outcomes));
        }
        text.push_str(");\n");
    }
    for condition in &functions.conditions {
        let _ = writeln!(
            text,
            "  detail::condition(factory, session, {}, {},\n                    {} {{ return robot_.{}({}); }});",
            literal(&condition.leaf),
            ports(condition),
            lambda(condition),
            condition.name,
            passed(condition)
        );
    }
    text.push_str("}\n\n");
}

fn ports(function: &Function) -> String {
    let ports = function.arguments.iter().map(|argument| literal(&argument.port));
    format!("{{{}}}", ports.collect::<Vec<_>>().join(", "))
}

/// A parameter without a use has no name.
fn lambda(function: &Function) -> &'static str {
    if function.arguments.is_empty() {
        "[](Robot& robot_, const detail::Texts&)"
    } else {
        "[](Robot& robot_, const detail::Texts& texts)"
    }
}

fn passed(function: &Function) -> String {
    let places = 0..function.arguments.len();
    places
        .map(|place| format!("texts[{place}]"))
        .collect::<Vec<_>>()
        .join(", ")
}

fn words(outcomes: &Outcomes) -> String {
    let part = |part: &WordPart| match part {
        WordPart::Text(text) => literal(text),
        WordPart::Argument(place) => format!("texts[{place}]"),
    };
    let word = |parts: &Vec<WordPart>| {
        format!(
            "detail::Texts{{{}}}",
            parts.iter().map(part).collect::<Vec<_>>().join(", ")
        )
    };
    let all: Vec<String> = outcomes.values.iter().map(|value| word(&value.word)).collect();
    let texts = if outcomes.depend_on_arguments() { " texts" } else { "" };
    format!(
        "[](const detail::Texts&{texts}) {{ return std::vector<detail::Texts>{{{}}}; }}",
        all.join(", ")
    )
}
