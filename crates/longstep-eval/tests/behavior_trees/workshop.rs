//! Programs with the nodes of domains: written, compiled and started.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use longstep_core::model::Domain;
use longstep_core::plan::behavior_tree::nodes::{self, Language};

/// A function of `Robot` in a header: the type of its result, its name, and the names of its arguments.
struct Declaration {
    result: String,
    name: String,
    arguments: Vec<String>,
}

/// Returns the functions of the class `Robot`.
fn declarations(header: &str) -> Vec<Declaration> {
    let functions = header.lines().filter_map(|line| line.strip_prefix("  virtual "));
    let functions = functions.filter(|line| line.contains("std::string& ") && !line.contains('~'));
    let declaration = |line: &str| {
        let (start, rest) = line.split_once('(').unwrap();
        let (result, name) = start.rsplit_once(' ').unwrap();
        let (arguments, _) = rest.rsplit_once(')').unwrap();
        let argument = |text: &str| {
            let name = text.trim().trim_start_matches("const std::string& ");
            name.trim_matches([' ', '*', '/']).to_owned()
        };
        Declaration {
            result: result.to_owned(),
            name: name.to_owned(),
            arguments: arguments.split(',').map(argument).collect(),
        }
    };
    functions.map(declaration).collect()
}

/// A leaf or a port of the shipped domains has the name of its function or argument, but for a reserved word.
fn unreserved(name: &str) -> &str {
    name.trim_end_matches('_')
}

/// Returns a robot that asks what it does, for the header of a domain.
fn scripted(header: &str, namespace: &str) -> String {
    let mut functions = String::new();
    for function in declarations(header) {
        let parameters = function
            .arguments
            .iter()
            .map(|name| format!("const std::string& {name}"));
        let parameters = parameters.collect::<Vec<_>>().join(", ");
        let mut call = format!("std::string(\"{}\")", unreserved(&function.name));
        for name in &function.arguments {
            let _ = write!(call, " + \"\\t{}=\" + {name}", unreserved(name));
        }
        let body = match function
            .result
            .strip_prefix("Begun<")
            .and_then(|rest| rest.strip_suffix('>'))
        {
            None => format!("return scripted::answer(\"ask\\t\" + {call}) == \"success\";"),
            Some(result) => format!(
                "return std::make_unique<Asked<{result}>>({call}, []([[maybe_unused]] const std::string& word) -> \
                 std::optional<{result}> {{ {} }});",
                named(header, result)
            ),
        };
        let _ = writeln!(
            functions,
            "  {} {}({parameters}) override {{ {body} }}",
            function.result, function.name
        );
    }
    include_str!("scripted.hpp")
        .replace("NAMESPACE", namespace)
        .replace("FUNCTIONS", &functions)
}

/// Returns the statements that find a result by its word.
fn named(header: &str, result: &str) -> String {
    if result == "Done" {
        return "return Done{};".to_owned();
    }
    let start = header.find(&format!("enum class {result} {{")).unwrap();
    let values = header[start..].split("};").next().unwrap().lines().skip(1);
    let values = values.filter_map(|line| line.trim().strip_suffix(','));
    let tests = values.map(|value| format!("if (word == \"{value}\") return {result}::{value};"));
    tests
        .chain(["return std::nullopt;".to_owned()])
        .collect::<Vec<_>>()
        .join(" ")
}

/// The headers and the main function of a program for domains. Each robot stands behind the header of its domain.
pub(crate) fn program(domains: &[Domain], folder: &Path) -> String {
    let mut text = String::from(
        "#include <exception>\n#include <iostream>\n#include <stdexcept>\n#include <string>\n\nnamespace scripted {\nbool halts = false;\n\
         void tell(const std::string& line) { std::cout << line << std::endl; }\n\
         std::string answer(const std::string& question) {\n  tell(question);\n  std::string line;\n  \
         if (!std::getline(std::cin, line)) std::exit(3);\n  return line;\n}\n}  // namespace scripted\n\n",
    );
    let mut registrations = String::new();
    for domain in domains {
        let header = nodes::write(domain, Language::Cpp);
        let namespace = domain.name.replace('-', "_");
        std::fs::write(folder.join(format!("{namespace}.hpp")), &header).unwrap();
        let _ = writeln!(text, "#include \"{namespace}.hpp\"");
        text.push_str(&scripted(&header, &namespace));
        let _ = writeln!(
            registrations,
            "  if (domain == \"{}\") return longstep::{namespace}::register_nodes(factory, \
             std::make_shared<longstep::{namespace}::Scripted>());",
            domain.name
        );
    }
    let _ = writeln!(
        text,
        "namespace scripted {{\nvoid register_domain(const std::string& domain, BT::BehaviorTreeFactory& factory) {{\n{registrations}\
         }}\n}}  // namespace scripted\n"
    );
    text
}

/// Compiles a program with all warnings as errors, and links BehaviorTree.CPP. Returns its path.
pub(crate) fn compiled(folder: &Path, text: &str) -> PathBuf {
    let runner = std::env::var("LONGSTEP_BEHAVIOR_TREES").expect("LONGSTEP_BEHAVIOR_TREES names the runner");
    let place = Path::new(&runner).parent().unwrap();
    let (source, program) = (folder.join("nodes.cpp"), folder.join("nodes"));
    std::fs::write(&source, text).unwrap();
    let output = Command::new("g++")
        .args([
            "-std=c++17",
            "-O0",
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Wshadow",
            "-Werror",
        ])
        .arg("-isystem")
        .arg(place.join("source/BehaviorTree.CPP/include"))
        .arg("-I")
        .arg(folder)
        .arg(source)
        .arg(place.join("libbehaviortree.a"))
        .args(["-lpthread", "-ldl", "-o"])
        .arg(&program)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    program
}

/// Writes a script that starts a program with arguments.
pub(crate) fn starter(folder: &Path, name: &str, words: &[&str]) -> PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.join(name);
    let words: Vec<String> = words.iter().map(|word| format!("'{word}'")).collect();
    std::fs::write(&path, format!("#!/bin/sh\nexec {}\n", words.join(" "))).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
    path
}

/// The Python with behaviortreepy and mypy.
pub(crate) fn python() -> String {
    std::env::var("LONGSTEP_BEHAVIOR_TREES_PYTHON").expect("LONGSTEP_BEHAVIOR_TREES_PYTHON names a Python")
}

/// Checks the types of modules.
pub(crate) fn check_types(folder: &Path, modules: &[PathBuf]) {
    let output = Command::new(python())
        .args(["-m", "mypy", "--strict", "--python-version", "3.11", "--cache-dir"])
        .arg(folder.join("mypy"))
        .args(modules)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
}
