//! A domain whose names and sentences are no identifiers, or end comments and texts.

use std::path::{Path, PathBuf};

use longstep_core::domain;
use longstep_core::model::Domain;
use longstep_core::plan::behavior_tree::nodes::{self, Language};

/// The names of the actions, and sentences about them.
const NAMES: [(&str, &str); 13] = [
    ("class", "It ends */ a comment \\"),
    ("new", "\"\"\" quit() \"\"\""),
    ("put-in", "line\nbreak\r\n#error\n"),
    ("put_in", "??/ trigraph \\"),
    ("put in", "\u{202e}reversed"),
    ("def", "%s {} {{"),
    ("self", "'''"),
    ("Robot", "\\u000a\\N{BULLET}"),
    ("開ける", "開ける。"),
    ("\"); system(\"x", "/* begins a comment"),
    ("", ""),
    ("__init__", " "),
    ("NULL", "//"),
];

fn hostile() -> Domain {
    let household = domain::shipped("household-checks").unwrap().unwrap();
    let mut data = (*household).clone();
    data.name = "namespace".to_owned();
    data.about = "Ends */ \"\"\" \\".to_owned();
    for (action, (name, sentence)) in data.actions.iter_mut().zip(NAMES) {
        action.call = name.to_owned();
        action.means = sentence.to_owned();
        for (parameter, name) in action.parameters.iter_mut().zip(["from", "class"]) {
            parameter.name = name.to_owned();
        }
    }
    for (predicate, name) in data
        .predicates
        .iter_mut()
        .zip(["double", "double_", "None", "is \"open\"", "std", "BT"])
    {
        predicate.name = name.to_owned();
    }
    // Outcomes that differ in their entities alone.
    if let Some(action) = data
        .actions
        .iter_mut()
        .find(|action| action.senses.len() > 1 && action.parameters.len() == 1)
    {
        let second = action.parameters[0].clone();
        action.parameters.push(second);
        let mut other = action.senses[0].clone();
        other.terms = vec![longstep_core::model::Term::Variable(1)];
        action.senses[1] = other;
    }
    data.into()
}

/// Writes the header into the folder, and returns its inclusion and a call of what it registers.
pub(crate) fn program(folder: &Path) -> String {
    std::fs::write(folder.join("hostile.hpp"), nodes::write(&hostile(), Language::Cpp)).unwrap();
    "#include \"hostile.hpp\"\nnamespace {\n[[maybe_unused]] const auto hostile_nodes = longstep::namespace_::register_nodes;\n}\n".to_owned()
}

/// Writes the module into the folder.
pub(crate) fn module(folder: &Path) -> PathBuf {
    let path = folder.join("hostile.py");
    std::fs::write(&path, nodes::write(&hostile(), Language::Python)).unwrap();
    path
}
