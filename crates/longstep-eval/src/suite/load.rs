//! Loads a [`Suite`] from the files of its folder.

use std::collections::BTreeMap;

use longstep::domain::Domain;
use longstep::goal::{self, Goal};
use longstep_core::diagnostic::{Diagnostic, Diagnostics, Position, nearest};
use longstep_core::environment::{self, Environment, World};
use longstep_core::json::Path;
use longstep_core::model::Prohibition;
use longstep_core::spanned::Spanned;
use serde::Deserialize;

use super::{Case, Expected, PLAIN, Step, Suite};
use crate::ablation::digest;

/// The texts of a suite's folder.
#[derive(Debug, Clone, Default)]
pub struct Files {
    /// The folder for error messages, with a slash at its end.
    pub folder: String,
    /// `suite.toml`.
    pub suite: String,
    /// The other `.toml` files, by name.
    pub cases: BTreeMap<String, String>,
    /// The environments in `scenes/`, by name without `.json`.
    pub scenes: BTreeMap<String, String>,
}

impl Files {
    /// SHA-256 of all files.
    pub fn sha256(&self) -> String {
        let suite = ("suite.toml", self.suite.as_str());
        let cases = self.cases.iter().map(|(name, text)| (name.as_str(), text.as_str()));
        let scenes = self.scenes.iter().map(|(name, text)| (name.as_str(), text.as_str()));
        digest([suite].into_iter().chain(cases).chain(scenes))
    }
}

/// Returns the JSON Schema of `suite.toml`.
///
/// ```
/// assert!(longstep_eval::suite::schema()["properties"]["domain"].is_object());
/// ```
#[cfg(feature = "schema")]
pub fn schema() -> serde_json::Value {
    longstep_core::schema::of::<SuiteFile>("A suite of Longstep: suite.toml")
}

/// Returns the JSON Schema of a file with cases of a suite.
///
/// ```
/// assert!(longstep_eval::suite::cases_schema()["properties"]["case"].is_object());
/// ```
#[cfg(feature = "schema")]
pub fn cases_schema() -> serde_json::Value {
    longstep_core::schema::of::<CasesFile>("Cases of a suite of Longstep")
}

/// A suite.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct SuiteFile {
    /// The name of the suite.
    name: String,
    /// A sentence about it.
    about: String,
    /// Its domain: the name of a shipped one, or a folder.
    domain: String,
}

/// Cases of a suite.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct CasesFile {
    /// The cases.
    #[serde(default)]
    case: Vec<Spanned<CaseEntry>>,
}

/// A case: an instruction in a scene, and what is right.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct CaseEntry {
    /// The name of the case.
    id: Spanned<String>,
    /// The file of the environment.
    scene: Spanned<String>,
    /// Rules that bind all plans of the case, joined by `&`.
    rules: Option<Spanned<String>>,
    /// The instruction.
    says: Option<String>,
    /// Other wordings of the instruction, by name.
    #[serde(default)]
    wordings: BTreeMap<Spanned<String>, String>,
    /// The goal, or several of which one is right.
    goal: Option<Spanned<Goals>>,
    /// The right result where there is no goal.
    expect: Option<Spanned<String>>,
    /// Several instructions, one after the other.
    steps: Option<Vec<Spanned<StepEntry>>>,
    /// Words by which results are grouped.
    #[serde(default)]
    tags: Vec<String>,
}

/// A step of a case.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct StepEntry {
    /// The instruction.
    says: String,
    /// The goal, or several of which one is right.
    goal: Option<Spanned<Goals>>,
    /// The right result where there is no goal.
    expect: Option<Spanned<String>>,
}

/// The right goal.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
enum Goals {
    /// A goal.
    One(String),
    /// Goals of which one is right.
    AnyOf(Vec<String>),
}

impl CaseEntry {
    /// Iterates over all expected goals.
    fn goals(&self) -> impl Iterator<Item = &String> {
        let steps = self
            .steps
            .iter()
            .flatten()
            .filter_map(|step| step.get_ref().goal.as_ref());
        let all = self.goal.iter().chain(steps);
        all.flat_map(|goals| match goals.get_ref() {
            Goals::One(text) => std::slice::from_ref(text),
            Goals::AnyOf(texts) => texts,
        })
    }
}

/// The expected result of a step, as the file has it.
struct Wished<'a> {
    goal: Option<&'a Spanned<Goals>>,
    expect: Option<&'a Spanned<String>>,
    /// The position of the step.
    at: usize,
}

fn parse<T: serde::de::DeserializeOwned>(file: &str, text: &str) -> Result<T, Diagnostic> {
    toml::from_str(text).map_err(|error| {
        let position = Position::of(text, error.span().map_or(0, |span| span.start));
        Diagnostic::at(file, position, error.message().trim().replace('\n', "; "))
    })
}

/// The domain of the suite: its name, or a folder relative to the suite's.
///
/// # Errors
///
/// When `suite.toml` cannot be read.
pub fn domain_name(files: &Files) -> Result<String, Diagnostics> {
    let file = format!("{}suite.toml", files.folder);
    let suite: SuiteFile = parse(&file, &files.suite).map_err(|fault| Diagnostics(vec![fault]))?;
    Ok(suite.domain)
}

/// Reads a suite for its domain.
///
/// # Errors
///
/// All faults at once: files that are not TOML or not an environment, duplicate ids, missing scenes, goals with unknown
/// names, cases without an instruction or without an expected result.
pub fn load(files: &Files, domain: &Domain) -> Result<Suite, Diagnostics> {
    let mut faults = Vec::new();
    let suite_file = format!("{}suite.toml", files.folder);
    let suite: Option<SuiteFile> = keep(parse(&suite_file, &files.suite), &mut faults);
    let mut scenes = BTreeMap::new();
    for (name, text) in &files.scenes {
        let file = format!("{}scenes/{name}.json", files.folder);
        scenes.extend(read_scene(domain, &file, text, &mut faults).map(|world| (name.clone(), world)));
    }
    let mut case_files: Vec<(&String, &String, CasesFile)> = Vec::new();
    for (name, text) in &files.cases {
        let read = parse(&format!("{}{name}", files.folder), text);
        case_files.extend(keep(read, &mut faults).map(|entries| (name, text, entries)));
    }
    let mut judged = scenes.clone();
    for entry in case_files.iter().flat_map(|(_, _, entries)| &entries.case) {
        if let Some(world) = judged.get_mut(entry.get_ref().scene.get_ref()) {
            entry.get_ref().goals().for_each(|text| goal::add_values(world, text));
        }
    }
    let mut loader = Loader {
        files,
        scenes: &judged,
        faults,
        file: String::new(),
        text: "",
        seen: BTreeMap::new(),
    };
    let mut cases = Vec::new();
    for (name, text, entries) in &case_files {
        loader.file = format!("{}{name}", files.folder);
        loader.text = text;
        cases.extend(entries.case.iter().filter_map(|entry| loader.case(entry)));
    }
    let mut faults = loader.faults;
    if cases.is_empty() && faults.is_empty() {
        faults.push(
            Diagnostic::whole(&suite_file, "the suite has no cases")
                .hint("put `[[case]]` entries into any other .toml file of the folder"),
        );
    }
    match suite {
        Some(suite) if faults.is_empty() => Ok(Suite {
            name: suite.name,
            about: suite.about,
            domain: suite.domain,
            scenes,
            judged,
            cases,
        }),
        _ => Err(Diagnostics::sorted(faults)),
    }
}

fn keep<T>(read: Result<T, Diagnostic>, faults: &mut Vec<Diagnostic>) -> Option<T> {
    read.map_err(|fault| faults.push(fault)).ok()
}

fn read_scene(domain: &Domain, file: &str, text: &str, faults: &mut Vec<Diagnostic>) -> Option<World> {
    match Environment::from_json(text) {
        Ok(environment) => match environment::read(domain, &environment, file, text, &Path::default()) {
            Ok(world) => Some(world),
            Err(found) => {
                faults.extend(found.0);
                None
            }
        },
        Err(error) => {
            faults.push(Diagnostic::whole(file, error.to_string()));
            None
        }
    }
}

struct Loader<'a> {
    files: &'a Files,
    scenes: &'a BTreeMap<String, World>,
    faults: Vec<Diagnostic>,
    /// The current file.
    file: String,
    text: &'a str,
    /// The position of the first occurrence of each id.
    seen: BTreeMap<String, String>,
}

impl Loader<'_> {
    fn fault(&mut self, at: usize, message: impl Into<String>) -> &mut Diagnostic {
        let position = Position::of(self.text, at);
        self.faults.push(Diagnostic::at(&self.file, position, message));
        let last = self.faults.len() - 1;
        &mut self.faults[last]
    }

    fn hinted(&mut self, at: usize, message: impl Into<String>, hint: impl Into<String>) {
        self.fault(at, message).hint = Some(hint.into());
    }

    fn case(&mut self, entry: &Spanned<CaseEntry>) -> Option<Case> {
        let begin = entry.span().start;
        let entry = entry.get_ref();
        let at = |place: &Spanned<String>| place.span().start;
        let place = Position::of(self.text, at(&entry.id));
        let here = format!("{}:{}", self.file, place.line);
        if let Some(first) = self.seen.insert(entry.id.get_ref().clone(), here) {
            let message = format!("the id `{}` is taken by the case at {first}", entry.id.get_ref());
            self.hinted(at(&entry.id), message, "give each case an id of its own");
        }
        let scene = entry.scene.get_ref();
        let world = self.scenes.get(scene);
        // A fault in the scene's file has been reported already.
        if world.is_none() && !self.files.scenes.contains_key(scene) {
            let near = nearest(scene, self.files.scenes.keys().map(String::as_str));
            let hint = match near {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("put the environment into {}scenes/{scene}.json", self.files.folder),
            };
            self.hinted(at(&entry.scene), format!("there is no scene `{scene}`"), hint);
        }
        let rules = match (&entry.rules, world) {
            (Some(rules), Some(world)) => self.rules(rules, world),
            _ => Vec::new(),
        };
        let bound = world.map(|world| world.with_prohibitions(rules.iter().cloned()));
        let world = bound.as_ref();
        let steps = match (&entry.says, &entry.steps) {
            (Some(says), None) => {
                let wished = Wished {
                    goal: entry.goal.as_ref(),
                    expect: entry.expect.as_ref(),
                    at: begin,
                };
                let step = self.step(says, &wished, world);
                let plain = entry.wordings.keys().find(|key| key.get_ref() == PLAIN);
                if let Some(plain) = plain {
                    self.fault(at(plain), format!("`{PLAIN}` is the wording of `says`"));
                }
                let wordings = entry.wordings.iter();
                step.into_iter()
                    .map(|step| Step {
                        wordings: wordings
                            .clone()
                            .map(|(key, says)| (key.get_ref().clone(), says.clone()))
                            .collect(),
                        ..step
                    })
                    .collect()
            }
            (None, Some(steps)) if !steps.is_empty() => {
                if entry.goal.is_some() || entry.expect.is_some() || !entry.wordings.is_empty() {
                    self.fault(begin, "a chain says what it expects, and in which words, step by step");
                }
                let step = |step: &Spanned<StepEntry>| {
                    let (at, step) = (step.span().start, step.get_ref());
                    let wished = Wished {
                        goal: step.goal.as_ref(),
                        expect: step.expect.as_ref(),
                        at,
                    };
                    self.step(&step.says, &wished, world)
                };
                steps.iter().filter_map(step).collect()
            }
            _ => {
                self.hinted(
                    begin,
                    "a case has either `says` or `steps`",
                    "`steps` is for a chain of instructions",
                );
                Vec::new()
            }
        };
        (!steps.is_empty()).then(|| Case {
            id: entry.id.get_ref().clone(),
            scene: scene.clone(),
            rules,
            steps,
            tags: entry.tags.clone(),
        })
    }

    fn rules(&mut self, written: &Spanned<String>, world: &World) -> Vec<Prohibition> {
        match goal::rules(world, written.get_ref()) {
            Ok(rules) => rules,
            Err(error) => {
                self.fault(written.span().start, format!("`{}`: {error}", written.get_ref()));
                Vec::new()
            }
        }
    }

    fn step(&mut self, says: &str, wished: &Wished<'_>, world: Option<&World>) -> Option<Step> {
        if says.trim().is_empty() {
            self.fault(wished.at, "the instruction is empty");
        }
        let expected = match (wished.goal, wished.expect) {
            (Some(goals), None) => self.goals(goals, world?),
            (None, Some(expect)) => match expect.get_ref().as_str() {
                "question" => Some(Expected::Question),
                "refusal" => Some(Expected::Refusal),
                "either" => Some(Expected::Either),
                "nothing" => Some(Expected::Nothing),
                other => {
                    let message = format!("`{other}` is nothing that can be expected");
                    self.hinted(
                        expect.span().start,
                        message,
                        "write question, refusal, either or nothing",
                    );
                    None
                }
            },
            _ => {
                let hint = "`goal` is what must hold in the end; `expect` is question, refusal, either or nothing";
                self.hinted(wished.at, "an instruction has either `goal` or `expect`", hint);
                None
            }
        };
        Some(Step {
            says: says.to_owned(),
            wordings: BTreeMap::new(),
            expected: expected?,
        })
    }

    fn goals(&mut self, written: &Spanned<Goals>, world: &World) -> Option<Expected> {
        let at = written.span().start;
        let texts: Vec<&String> = match written.get_ref() {
            Goals::One(text) => vec![text],
            Goals::AnyOf(texts) => texts.iter().collect(),
        };
        if texts.is_empty() {
            self.fault(at, "the list of goals is empty");
            return None;
        }
        let mut goals: Vec<Goal> = Vec::new();
        for text in &texts {
            match goal::parse(world, text) {
                Ok(goal) if !goal.facts.is_empty() => goals.push(goal),
                Ok(_) => {
                    self.fault(at, "the goal is empty");
                }
                Err(error) => {
                    self.fault(at, format!("`{text}`: {error}"));
                }
            }
        }
        (goals.len() == texts.len()).then_some(Expected::Plan(goals))
    }
}
