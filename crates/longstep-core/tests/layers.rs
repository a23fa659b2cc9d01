//! Modules of a crate do not import each other in circles, and crates depend on each other one way.
//!
//! Computed from the sources: an edge is a `crate::name` path outside of tests, where `name` is a module of the crate or
//! something that its root re-exports from one. A root's own re-exports are what the crate offers and no edges.

#![allow(clippy::unwrap_used, missing_docs)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Edges of one crate: from module to module, with the lines that make them.
type Edges = BTreeMap<String, BTreeMap<String, Vec<String>>>;

/// Crates from the ground up: each may depend on those before it.
const ORDER: [&str; 15] = [
    "longstep-model",
    "longstep-files",
    "longstep-verify",
    "longstep-search",
    "longstep-core",
    "longstep-picture",
    "longstep-teach",
    "longstep-robot",
    "longstep",
    "longstep-author",
    "longstep-llm",
    "longstep-python",
    "longstep-server",
    "longstep-eval",
    "longstep-cli",
];

fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Every Rust file below a folder, sorted.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    entries.sort();
    let mut files = Vec::new();
    for path in entries {
        if path.is_dir() {
            files.extend(sources(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files
}

/// The code of a file: without comments, and without the module of unit tests, which ends a file.
fn code(text: &str) -> String {
    let text = match text.find("#[cfg(test)]\nmod tests {") {
        Some(at) => &text[..at],
        None => text,
    };
    let bare = |line: &str| line.split("//").next().unwrap_or_default().to_owned() + "\n";
    text.lines().map(bare).collect()
}

/// Modules that a file declares for tests only.
fn test_modules(text: &str) -> Vec<String> {
    let lines: Vec<&str> = text.lines().collect();
    let pairs = lines.windows(2).filter(|pair| pair[0].trim() == "#[cfg(test)]");
    pairs
        .filter_map(|pair| {
            pair[1]
                .trim()
                .strip_prefix("mod ")?
                .strip_suffix(';')
                .map(str::to_owned)
        })
        .collect()
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || c == '_'))
        .filter(|word| !word.is_empty())
}

/// The names that begin the parts of a `{...}` list: `a::{b, c}, d` begins with `a` and `d`.
fn first_names(list: &str) -> Vec<String> {
    let (mut depth, mut names, mut fresh, mut name) = (0, Vec::new(), true, String::new());
    for c in list.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                names.push(std::mem::take(&mut name));
                fresh = true;
                continue;
            }
            _ => {}
        }
        if depth == 0 && fresh && (c.is_alphanumeric() || c == '_') {
            name.push(c);
        } else if !name.is_empty() {
            fresh = false;
        }
    }
    names.push(name);
    names.retain(|name| !name.is_empty());
    names
}

/// The names behind `crate::` in code, each with its line.
fn crate_names(code: &str) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::") {
        if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$') {
            continue;
        }
        let line = code[..at].matches('\n').count() + 1;
        let rest = &code[at + "crate::".len()..];
        match rest.strip_prefix('{') {
            Some(list) => found.extend(first_names(list).into_iter().map(|name| (line, name))),
            None => found.extend(words(rest).next().map(|name| (line, name.to_owned()))),
        }
    }
    found
}

/// The names that a crate's root re-exports: `pub use module::{A, B}` leads from A and B to the module.
fn re_exports(root: &str) -> BTreeMap<String, String> {
    let mut names = BTreeMap::new();
    for part in root.split("use ").skip(1) {
        let statement = part.split(';').next().unwrap_or_default();
        let mut parts = words(statement);
        let Some(module) = parts.next() else { continue };
        names.extend(parts.map(|name| (name.to_owned(), module.to_owned())));
    }
    names
}

/// Files of tests: those that another file declares under `#[cfg(test)]`.
fn test_files(files: &[PathBuf]) -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    for file in files {
        let home = match file.file_stem().and_then(|stem| stem.to_str()) {
            Some("mod" | "lib" | "main") => file.parent().unwrap().to_owned(),
            _ => file.with_extension(""),
        };
        let tests = test_modules(&fs::read_to_string(file).unwrap());
        found.extend(
            tests
                .iter()
                .flat_map(|test| [home.join(format!("{test}.rs")), home.join(test)]),
        );
    }
    found
}

/// The root file of a crate.
fn root(folder: &Path) -> PathBuf {
    let roots = ["lib.rs", "main.rs"].map(|file| folder.join(file));
    roots.into_iter().find(|file| file.exists()).unwrap()
}

/// The files of a crate's modules, each with its module; neither the root nor files of tests.
fn module_files(folder: &Path) -> Vec<(String, PathBuf)> {
    let (root, files) = (root(folder), sources(folder));
    let tests = test_files(&files);
    let inside = files
        .into_iter()
        .filter(|file| *file != root && !tests.iter().any(|test| file.starts_with(test)));
    let with_module = |file: PathBuf| {
        let inside = file.strip_prefix(folder).unwrap();
        let first = inside.components().next().unwrap().as_os_str().to_str().unwrap();
        (first.trim_end_matches(".rs").to_owned(), file)
    };
    inside.map(with_module).collect()
}

fn edges(name: &str) -> Edges {
    let folder = crates().join(name).join("src");
    let re_exports = re_exports(&code(&fs::read_to_string(root(&folder)).unwrap()));
    let inside = module_files(&folder);
    let modules: BTreeSet<&String> = inside.iter().map(|(module, _)| module).collect();
    let mut edges = Edges::new();
    for (from, file) in &inside {
        for (line, name) in crate_names(&code(&fs::read_to_string(file).unwrap())) {
            let to = if modules.contains(&name) {
                Some(&name)
            } else {
                re_exports.get(&name)
            };
            if let Some(to) = to.filter(|to| *to != from && modules.contains(to)) {
                let place = format!(
                    "{}:{line}: crate::{name}",
                    file.strip_prefix(&folder).unwrap().display()
                );
                let targets = edges.entry(from.clone()).or_default();
                targets.entry(to.clone()).or_default().push(place);
            }
        }
    }
    edges
}

/// Modules that can be reached from one.
fn reached(edges: &Edges, from: &str) -> BTreeSet<String> {
    let (mut found, mut open) = (BTreeSet::new(), vec![from.to_owned()]);
    while let Some(module) = open.pop() {
        for next in edges.get(&module).into_iter().flat_map(BTreeMap::keys) {
            if found.insert(next.clone()) {
                open.push(next.clone());
            }
        }
    }
    found
}

/// The imports that are part of a circle, one line each.
fn circles(edges: &Edges) -> Vec<String> {
    let mut lines = Vec::new();
    for (from, targets) in edges {
        for (to, places) in targets.iter().filter(|(to, _)| reached(edges, to).contains(from)) {
            lines.extend(places.iter().map(|place| format!("{from} -> {to}: {place}")));
        }
    }
    lines
}

#[test]
fn modules_do_not_import_in_circles() {
    let mut lines = Vec::new();
    for name in ORDER {
        lines.extend(circles(&edges(name)).into_iter().map(|line| format!("{name}: {line}")));
    }
    assert!(lines.is_empty(), "imports in circles:\n{}", lines.join("\n"));
}

/// Names in backticks in a text: `a::b` counts for both.
fn quoted_names(text: &str) -> BTreeSet<&str> {
    text.split('`').skip(1).step_by(2).flat_map(words).collect()
}

#[test]
fn layer_order_contains_every_crate_folder() {
    let folders = fs::read_dir(crates()).unwrap();
    let names: BTreeSet<String> = folders
        .map(|folder| folder.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(names, ORDER.map(str::to_owned).into());
}

#[test]
fn architecture_names_every_module() {
    let page = fs::read_to_string(crates().join("../ARCHITECTURE.md")).unwrap();
    let mut missing = Vec::new();
    for name in ORDER {
        let heading = format!("\n## Modules of `{name}`\n");
        let section = page.split(&heading).nth(1).and_then(|rest| rest.split("\n## ").next());
        let listed = quoted_names(section.unwrap_or_default());
        let inside = module_files(&crates().join(name).join("src"));
        let modules: BTreeSet<&String> = inside.iter().map(|(module, _)| module).collect();
        let left_out = modules.iter().filter(|module| !listed.contains(module.as_str()));
        missing.extend(left_out.map(|module| format!("{name}: {module}")));
    }
    assert!(
        missing.is_empty(),
        "ARCHITECTURE.md leaves out:\n{}",
        missing.join("\n")
    );
}

#[test]
fn crates_depend_one_way() {
    for (place, name) in ORDER.iter().enumerate() {
        let manifest = fs::read_to_string(crates().join(name).join("Cargo.toml")).unwrap();
        let manifest = manifest.split("[dev-dependencies]").next().unwrap();
        for above in &ORDER[place + 1..] {
            let depends = manifest
                .lines()
                .any(|line| line.split(['.', ' ', '=']).next() == Some(above));
            assert!(!depends, "{name} depends on {above}, which stands above it");
        }
    }
}

#[test]
fn import_circles_are_reported_with_their_lines() {
    let text = "use crate::{b::{X, Y}, c};\n// crate::d is a comment\nfn f() { crate::e::g() }\n";
    let names = crate_names(&code(text));
    let names: Vec<String> = names.into_iter().map(|(line, name)| format!("{line} {name}")).collect();
    assert_eq!(names, ["1 b", "1 c", "3 e"]);
    let edge = |to: &str| BTreeMap::from([(to.to_owned(), vec![format!("x.rs:1: crate::{to}")])]);
    let edges = Edges::from([
        ("a".to_owned(), edge("b")),
        ("b".to_owned(), edge("a")),
        ("c".to_owned(), edge("a")),
    ]);
    assert_eq!(
        circles(&edges),
        ["a -> b: x.rs:1: crate::b", "b -> a: x.rs:1: crate::a"]
    );
}
