//! The published schemas: what the program prints, and they accept what it accepts.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use boon::{Compiler, SchemaIndex, Schemas};
use common::{longstep, run};
use longstep::domain::{self, Files};
use serde_json::{Value, json};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn names() -> Vec<String> {
    let home = tempfile::tempdir().unwrap();
    let ran = run(longstep(home.path()).arg("schema"), "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let name = |line: &str| line.split(' ').next().unwrap().to_owned();
    ran.stdout.lines().map(name).collect()
}

/// All schemas of the folder, compiled.
struct Published {
    schemas: Schemas,
    indices: Vec<(String, SchemaIndex)>,
}

impl Published {
    fn new() -> Self {
        let (mut compiler, mut schemas) = (Compiler::new(), Schemas::new());
        let location = |name: &str| format!("https://github.com/longstep/longstep/schemas/{name}.schema.json");
        let names = names();
        for name in &names {
            let text = fs::read_to_string(root().join(format!("schemas/{name}.schema.json"))).unwrap();
            let schema = serde_json::from_str(&text).unwrap();
            compiler.add_resource(&location(name), schema).unwrap();
        }
        let compiled = |name: String| {
            let index = compiler.compile(&location(&name), &mut schemas);
            let index = index.unwrap_or_else(|error| panic!("{name}: {error}"));
            (name, index)
        };
        let indices = names.into_iter().map(compiled).collect();
        Self { schemas, indices }
    }

    fn error(&self, name: &str, value: &Value) -> Option<String> {
        let (_, index) = self.indices.iter().find(|(own, _)| own == name).unwrap();
        let error = self.schemas.validate(value, *index).err()?;
        Some(error.to_string())
    }
}

/// The files below a folder, except those of builds.
fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() && name != "target" && !name.starts_with('.') {
            files_below(&path, found);
        } else if path.is_file() {
            found.push(path);
        }
    }
}

fn read(path: &Path) -> Value {
    let text = fs::read_to_string(path).unwrap();
    if path.extension().is_some_and(|own| own == "toml") {
        serde_json::to_value(toml::from_str::<toml::Value>(&text).unwrap()).unwrap()
    } else {
        serde_json::from_str(&text).unwrap()
    }
}

/// The schema of a file in the tree by its path; none if it has none.
fn schema_of(path: &Path) -> Option<&'static str> {
    let text = path.to_string_lossy();
    let name = path.file_name()?.to_str()?;
    match name {
        "domain.toml" => Some("domain"),
        "skills.toml" => Some("skills"),
        "robot.toml" => Some("ros2"),
        "suite.toml" => Some("suite"),
        "answers.toml" => Some("answers"),
        "examples.toml" if text.contains("/prompt/") => Some("examples"),
        "plans.toml" if text.contains("/prompt/") => Some("plans"),
        "feedback.toml" if text.contains("/prompt/") => Some("feedback"),
        "environment.json" => Some("environment"),
        _ if text.contains("/scenes/") && name.ends_with(".json") => Some("environment"),
        _ if path.with_file_name("suite.toml").exists() && name.ends_with(".toml") => Some("cases"),
        _ => None,
    }
}

/// `LONGSTEP_WRITE_SCHEMAS=1` writes the files instead.
#[test]
fn the_folder_has_what_the_program_prints() {
    let home = tempfile::tempdir().unwrap();
    let folder = root().join("schemas");
    let writes = std::env::var_os("LONGSTEP_WRITE_SCHEMAS").is_some();
    let mut expected = BTreeSet::from(["README.md".to_owned()]);
    for name in names() {
        let ran = run(longstep(home.path()).args(["schema", &name]), "");
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        let file = format!("{name}.schema.json");
        if writes {
            fs::write(folder.join(&file), &ran.stdout).unwrap();
        }
        let hint = "run this test with LONGSTEP_WRITE_SCHEMAS=1";
        assert_eq!(fs::read_to_string(folder.join(&file)).unwrap(), ran.stdout, "{hint}");
        expected.insert(file);
    }
    let entries = fs::read_dir(folder).unwrap();
    let found: BTreeSet<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(found, expected);
}

#[test]
fn an_unknown_name_is_an_error_with_a_hint() {
    let home = tempfile::tempdir().unwrap();
    let ran = run(longstep(home.path()).args(["schema", "enviroment"]), "");
    assert_eq!((ran.code, ran.stdout.as_str()), (30, ""));
    assert!(ran.stderr.contains("did you mean `environment`?"), "{}", ran.stderr);
}

#[test]
fn every_file_in_the_tree_fits_its_schema() {
    let published = Published::new();
    let mut files = Vec::new();
    for folder in ["crates", "examples"] {
        files_below(&root().join(folder), &mut files);
    }
    let mut seen = BTreeSet::new();
    for path in files {
        let Some(name) = schema_of(&path) else { continue };
        // Files of tests that are there to be refused.
        if let Some(error) = published.error(name, &read(&path)) {
            panic!("{}: {error}", path.display());
        }
        seen.insert(name);
    }
    let expected = [
        "cases",
        "domain",
        "environment",
        "examples",
        "feedback",
        "plans",
        "ros2",
        "skills",
        "suite",
    ];
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), expected);
}

/// Every value that differs from this one in a single place: another type, an unknown key, or a part left out.
fn variants(value: &Value) -> Vec<Value> {
    let mut all = match value {
        Value::String(_) => vec![json!({"a": "b"})],
        Value::Object(_) | Value::Array(_) => vec![json!("odd")],
        _ => vec![json!(["odd"])],
    };
    match value {
        Value::Object(object) => {
            for (key, inner) in object {
                let mut without = object.clone();
                without.shift_remove(key);
                all.push(without.into());
                all.extend(variants(inner).into_iter().map(|inner| {
                    let mut other = object.clone();
                    other.insert(key.clone(), inner);
                    other.into()
                }));
            }
            let mut more = object.clone();
            more.insert("unknown_key".to_owned(), json!("odd"));
            all.push(more.into());
        }
        // The elements of a list are alike.
        Value::Array(items) => {
            if let Some(first) = items.first() {
                all.extend(variants(first).into_iter().map(|inner| {
                    let mut other = items.clone();
                    other[0] = inner;
                    other.into()
                }));
            }
        }
        _ => {}
    }
    all
}

/// A domain that does not fit the schema does not load. The reverse is not so: a schema does not know what is declared.
#[test]
fn a_domain_that_the_schema_refuses_does_not_load() {
    let published = Published::new();
    let folder = root().join("crates/longstep-model/domains/household");
    let pddl = fs::read_to_string(folder.join("domain.pddl")).unwrap();
    let goal = fs::read_to_string(folder.join("prompt/goal.md")).unwrap();
    let examples = fs::read_to_string(folder.join("prompt/examples.toml")).unwrap();
    let load = |value: &Value| {
        let text = toml::to_string(value).ok()?;
        let files = [
            ("domain.pddl", pddl.clone()),
            ("domain.toml", text),
            ("prompt/goal.md", goal.clone()),
            ("prompt/examples.toml", examples.clone()),
        ];
        let files = files.map(|(name, text)| (name.to_owned(), text));
        Some(domain::load(&Files::from_texts("odd/", files)))
    };
    let written = read(&folder.join("domain.toml"));
    assert!(load(&written).unwrap().is_ok() && published.error("domain", &written).is_none());
    let (mut refused, mut of_form) = (0, 0);
    for variant in variants(&written) {
        let Some(loaded) = load(&variant) else { continue };
        let fits = published.error("domain", &variant).is_none();
        refused += usize::from(!fits);
        match loaded {
            Ok(_) => assert!(fits, "{:?}\n{variant}", published.error("domain", &variant)),
            Err(findings) => {
                let text = findings.to_string();
                let is_of_form = ["unknown field", "invalid type", "missing field"]
                    .iter()
                    .any(|part| text.contains(part));
                of_form += usize::from(is_of_form);
                assert!(!is_of_form || !fits, "{text}\n{variant}");
            }
        }
    }
    assert!(
        refused > 100 && of_form > 100,
        "{refused} refused, {of_form} of the form"
    );
}

/// For an environment, the schema says what the reader says about its form.
#[test]
fn an_environment_fits_the_schema_if_it_can_be_read() {
    let published = Published::new();
    let text = json!({
        "assets": ["<desk>"], "asset_states": {"<desk>": ["flat()"]}, "objects": ["<pen>"],
        "object_states": {"<pen>": "on_something(<desk>)"}, "asset_properties": {"<desk>": "TABLE"}, "object_properties": {},
        "facts": ["a()"], "names": {"<pen>": "pencil"}, "types": {"<pen>": "tool"}, "speaker": "<ann>", "robot": "<rob>",
    });
    let mut count = [0, 0];
    for bare in variants(&text).into_iter().chain([text]) {
        let mut with_schema = bare.clone();
        if let Value::Object(keys) = &mut with_schema {
            keys.insert("$schema".to_owned(), json!("./schemas/environment.schema.json"));
        }
        for value in [json!({"environment": bare}), bare, with_schema] {
            let read = longstep::Environment::from_json(&value.to_string());
            let fits = published.error("environment", &value).is_none();
            assert_eq!(fits, read.is_ok(), "{value}: {read:?}");
            count[usize::from(fits)] += 1;
        }
    }
    assert!(count[0] > 50 && count[1] > 10, "{count:?}");
}

#[test]
fn answers_fit_their_schema() {
    let published = Published::new();
    let home = tempfile::tempdir().unwrap();
    let environment = root().join("crates/longstep-server/scenes/kitchen.json");
    for goal in [
        "put(cereal, counter)",
        "put(cereal, cereal)",
        "all of object: never(opened(fridge))",
    ] {
        let mut command = longstep(home.path());
        let ran = run(
            command
                .args(["solve", "--json", "--goal", goal, "--env"])
                .arg(&environment),
            "",
        );
        let value: Value = serde_json::from_str(&ran.stdout).unwrap();
        let name = if value.get("error").is_some() {
            "error"
        } else {
            "answer"
        };
        assert_eq!(published.error(name, &value), None, "{goal}");
        if name == "answer" {
            assert_eq!(published.error("plan", &value["plan"]), None, "{goal}");
        }
    }
}

/// Files of `domain new` name schemas that are beside them, and fit them.
#[test]
fn a_new_domain_has_its_schemas() {
    let published = Published::new();
    let home = tempfile::tempdir().unwrap();
    let answers = home.path().join("answers.toml");
    let text = "name = \"porter\"\nrobot = \"the porter\"\nkind = [{ name = \"box\", examples = [\"red box\"] }, { name = \"shelf\", \
                stays = true, examples = [\"top shelf\", \"low shelf\"] }]\nstart = [\"the red box is on the top shelf\"]\n\
                [[action]]\nwords = \"pick up a box\"\nneeds = [\"the box is on a shelf\", \"the porter holds no box\"]\n\
                then = [\"the porter holds the box\"]\n[[action]]\nwords = \"put a box on a shelf\"\n\
                needs = [\"the porter holds the box\"]\nthen = [\"the box is on the shelf\"]\n";
    fs::write(&answers, text).unwrap();
    assert_eq!(published.error("answers", &read(&answers)), None);
    for source in [
        vec!["--starter".to_owned()],
        vec!["--from".to_owned(), answers.display().to_string()],
    ] {
        let folder = home.path().join("porter");
        let ran = run(
            longstep(home.path()).args(["domain", "new"]).arg(&folder).args(&source),
            "",
        );
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        let mut files = Vec::new();
        files_below(&folder, &mut files);
        let mut named = 0;
        for path in files.iter().filter(|path| !path.starts_with(folder.join("schemas"))) {
            let text = fs::read_to_string(path).unwrap();
            let place = match path.extension().and_then(|own| own.to_str()) {
                Some("toml") => text
                    .lines()
                    .next()
                    .unwrap()
                    .strip_prefix("#:schema ")
                    .map(str::to_owned),
                Some("json") => read(path)["$schema"].as_str().map(str::to_owned),
                _ => None,
            };
            if let Some(place) = place {
                let schema = path.parent().unwrap().join(&place);
                let name = schema_of(path).unwrap();
                assert!(
                    place.ends_with(&format!("/{name}.schema.json")),
                    "{}: {place}",
                    path.display()
                );
                assert!(schema.is_file(), "{}", schema.display());
                named += 1;
            }
            if let Some(name) = schema_of(path) {
                assert_eq!(published.error(name, &read(path)), None, "{}", path.display());
            }
        }
        assert!(named >= 4, "{named}");
        let checked = run(longstep(home.path()).args(["domain", "check"]).arg(&folder), "");
        assert_eq!(checked.code, 0, "{}", checked.stderr);
        fs::remove_dir_all(folder).unwrap();
    }
}
