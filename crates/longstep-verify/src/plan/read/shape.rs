//! Conversion of a parsed object to a plan file: checks the keys and types of a plan.

use indexmap::IndexMap;
use indexmap::map::Entry as Slot;
use serde_json::Value;

use super::unreadable::Unreadable;
use crate::plan::{
    ChoiceFile, EndingFile, PlanDomain, PlanFile, PurposeFile, TaskCohesion, TreeError, read_tree, script,
};
use longstep_model::diagnostic::Position;
use longstep_model::json::Path;
use longstep_model::literal::{LeniencyKind as Kind, LiteralValue, Member, Notes, ValueNode, json, shorten};
use longstep_model::model::{Environment, Words};

type Shaped<T> = Result<T, Unreadable>;

/// Degree to which an object looks like a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Likeness {
    /// The object has `task_cohesion` or `python_script`.
    Whole,
    /// The object has fields of `task_cohesion` or a question: a plan, unless it is part of a larger one.
    Part,
}

/// Classifies an object.
pub(super) fn likeness(node: &ValueNode) -> Option<Likeness> {
    let LiteralValue::Object(entries) = &node.value else {
        return None;
    };
    let is_text = |value: &LiteralValue| matches!(value, LiteralValue::Text(text) if !text.trim().is_empty());
    if entries
        .iter()
        .any(|entry| entry.key == "task_cohesion" || entry.key == "python_script")
    {
        Some(Likeness::Whole)
    } else if entries
        .iter()
        .any(|entry| is_steps(&entry.key) || (entry.key == "question" && is_text(&entry.node.value)))
    {
        Some(Likeness::Part)
    } else {
        None
    }
}

/// Returns true if the key holds the steps of a plan.
fn is_steps(key: &str) -> bool {
    matches!(key, "task_sequence" | "task_tree")
}

/// Converts an object that looks like a plan and stands at a path of a larger value.
pub(super) fn plan(text: &str, node: &ValueNode, path: &Path, notes: &mut Notes) -> Shaped<PlanFile> {
    Shape { text, notes }.plan(node, path)
}

const PLAN_KEYS: [&str; 10] = [
    "task_cohesion",
    "python_script",
    "environment_before",
    "environment_after",
    "endings",
    "instruction_summary",
    "question",
    "not_in_plan",
    "purpose",
    "domain",
];
const COHESION_KEYS: [&str; 5] = [
    "task_sequence",
    "step_instructions",
    "task_tree",
    "object_name",
    "object_names",
];
const ENVIRONMENT_KEYS: [&str; 11] = [
    "assets",
    "asset_states",
    "objects",
    "object_states",
    "asset_properties",
    "object_properties",
    "facts",
    "names",
    "types",
    "speaker",
    "robot",
];

struct Shape<'t, 'n> {
    text: &'t str,
    notes: &'n mut Notes,
}

/// The entries of an object with known keys, each key once.
struct Fields<'v> {
    at: usize,
    path: Path,
    known: Vec<(&'static str, &'v ValueNode)>,
}

impl<'v> Fields<'v> {
    fn get(&self, key: &str) -> Option<&'v ValueNode> {
        self.known
            .iter()
            .find(|(known, _)| *known == key)
            .map(|(_, node)| *node)
    }
}

impl Shape<'_, '_> {
    fn plan(&mut self, node: &ValueNode, path: &Path) -> Shaped<PlanFile> {
        let whole = likeness(node) == Some(Likeness::Whole);
        let fields = if whole {
            self.fields(node, path, &PLAN_KEYS)?
        } else {
            self.fields(node, path, &[&PLAN_KEYS[..], &COHESION_KEYS].concat())?
        };
        let question = self.field(&fields, "question", Self::text)?.unwrap_or_default();
        let has_question = !question.trim().is_empty();
        let script = self.field(&fields, "python_script", Self::script)?;
        let cohesion = if let Some(script) = script {
            self.alone(&fields, "python_script", &["task_cohesion"])?;
            Some(script)
        } else if whole {
            self.field(&fields, "task_cohesion", |shape, node, path| {
                let fields = shape.fields(node, path, &COHESION_KEYS)?;
                shape.cohesion(&fields, has_question)
            })?
        } else if fields.known.iter().any(|(key, _)| is_steps(key)) {
            self.notes.add(Kind::Flattened, node.at);
            Some(self.cohesion(&fields, has_question)?)
        } else {
            None
        };
        Ok(PlanFile {
            task_cohesion: self.required(
                cohesion,
                &fields,
                "task_cohesion",
                "an object with the steps",
                has_question,
            )?,
            environment_before: self.field(&fields, "environment_before", Self::environment)?,
            environment_after: self.field(&fields, "environment_after", Self::environment)?,
            endings: self.field(&fields, "endings", Self::endings)?.unwrap_or_default(),
            instruction_summary: self
                .field(&fields, "instruction_summary", Self::text)?
                .unwrap_or_default(),
            question,
            not_in_plan: self.field(&fields, "not_in_plan", Self::texts)?.unwrap_or_default(),
            purpose: self.field(&fields, "purpose", Self::purpose)?,
            domain: self.field(&fields, "domain", Self::domain)?,
        })
    }

    fn domain(&mut self, node: &ValueNode, path: &Path) -> Shaped<PlanDomain> {
        let fields = self.fields(node, path, &["name", "hash"])?;
        let name = self.field(&fields, "name", Self::text)?;
        Ok(PlanDomain {
            name: self.required(name, &fields, "name", "the name of a domain", false)?,
            hash: self.field(&fields, "hash", Self::text)?,
        })
    }

    fn purpose(&mut self, node: &ValueNode, path: &Path) -> Shaped<PurposeFile> {
        let fields = self.fields(node, path, &["goal", "rules", "choices", "assumptions"])?;
        Ok(PurposeFile {
            goal: self.field(&fields, "goal", Self::text)?,
            rules: self.field(&fields, "rules", Self::texts)?.unwrap_or_default(),
            choices: self.field(&fields, "choices", Self::choices)?.unwrap_or_default(),
            assumptions: self.field(&fields, "assumptions", Self::texts)?.unwrap_or_default(),
        })
    }

    fn choices(&mut self, node: &ValueNode, path: &Path) -> Shaped<Vec<ChoiceFile>> {
        let LiteralValue::List(items) = &node.value else {
            return Err(self.wrong(node, path, "a list of choices"));
        };
        let choice = |(index, item): (usize, &ValueNode)| {
            let fields = self.fields(item, &path.index(index), &["goal", "chosen"])?;
            let goal = self.field(&fields, "goal", Self::text)?;
            let chosen = self.field(&fields, "chosen", Self::texts)?;
            Ok(ChoiceFile {
                goal: self.required(goal, &fields, "goal", "a goal", false)?,
                chosen: self.required(chosen, &fields, "chosen", "a list of goals", false)?,
            })
        };
        items.iter().enumerate().map(choice).collect()
    }

    fn endings(&mut self, node: &ValueNode, path: &Path) -> Shaped<Vec<EndingFile>> {
        let LiteralValue::List(items) = &node.value else {
            return Err(self.wrong(node, path, "a list of endings"));
        };
        let ending = |(index, item): (usize, &ValueNode)| {
            let fields = self.fields(item, &path.index(index), &["when", "environment_after"])?;
            let when = self.field(&fields, "when", Self::texts)?;
            let after = self.field(&fields, "environment_after", Self::environment)?;
            Ok(EndingFile {
                when: self.required(when, &fields, "when", "a list of facts", false)?,
                environment_after: self.required(after, &fields, "environment_after", "an environment", false)?,
            })
        };
        items.iter().enumerate().map(ending).collect()
    }

    fn cohesion(&mut self, fields: &Fields, has_question: bool) -> Shaped<TaskCohesion> {
        if let Some(tree) = fields.get("task_tree") {
            return self.tree(tree, fields);
        }
        let steps = self.field(fields, "task_sequence", Self::texts)?;
        let explanations = self.field(fields, "step_instructions", Self::texts)?;
        Ok(TaskCohesion {
            task_sequence: self.required(steps, fields, "task_sequence", "a list of steps", has_question)?,
            step_instructions: self.required(explanations, fields, "step_instructions", "a list of texts", true)?,
            object_name: self.field(fields, "object_name", Self::text)?,
            object_names: self.field(fields, "object_names", Self::texts)?.unwrap_or_default(),
            task_tree: None,
        })
    }

    /// Parses a tree of steps, strictly as to keys and types; literals may have any style.
    fn tree(&mut self, tree: &ValueNode, fields: &Fields) -> Shaped<TaskCohesion> {
        self.alone(fields, "task_tree", &["task_sequence", "step_instructions"])?;
        let object = self.field(fields, "object_name", Self::text)?;
        let objects = self.field(fields, "object_names", Self::texts)?.unwrap_or_default();
        let path = fields.path.push("task_tree");
        let read = |value: Value| read_tree(&value, object.into_iter().chain(objects).collect(), &path);
        let twice = |path| TreeError {
            path,
            message: "stands there twice".to_owned(),
        };
        let written = json(tree, &path)
            .map_err(twice)
            .and_then(read)
            .map_err(|error| Unreadable::Tree {
                position: Position::of(self.text, tree.at),
                error,
            })?;
        Ok(TaskCohesion::from_written(written))
    }

    fn script(&mut self, node: &ValueNode, path: &Path) -> Shaped<TaskCohesion> {
        let text = self.text(node, path)?;
        let written = script::read(&text).or_else(|error| {
            // Trimming a text takes the indentation of its first line away.
            let trimmed = with_first_line_indented(&text).and_then(|text| script::read(&text).ok());
            trimmed.ok_or(error)
        });
        let written = written.map_err(|error| Unreadable::Script {
            inside: Some(Position::of(self.text, node.at)),
            error,
        })?;
        Ok(TaskCohesion::from_written(written))
    }

    /// Returns an error if one of `others`, which have the same meaning as `key`, is also present.
    fn alone(&self, fields: &Fields, key: &str, others: &[&str]) -> Shaped<()> {
        let other = others.iter().find_map(|other| Some((other, fields.get(other)?)));
        let Some((other, node)) = other.filter(|(_, node)| node.value != LiteralValue::Null) else {
            return Ok(());
        };
        let expected = match key {
            "task_tree" => "left out beside `task_tree`",
            _ => "left out beside `python_script`",
        };
        Err(self.wrong(node, &fields.path.push(other), expected))
    }

    /// Parses an environment, bare or wrapped in `{"environment": ...}`.
    fn environment(&mut self, node: &ValueNode, path: &Path) -> Shaped<Environment> {
        let wraps = |entry: &Member| entry.key == "environment";
        if matches!(&node.value, LiteralValue::Object(entries) if entries.iter().any(wraps)) {
            let fields = self.fields(node, path, &["environment"])?;
            self.notes.add_about(Kind::Wrapped, node.at, path.push("environment"));
            let inner = self.field(&fields, "environment", Self::bare_environment)?;
            return self.required(inner, &fields, "environment", "an environment", false);
        }
        self.bare_environment(node, path)
    }

    fn bare_environment(&mut self, node: &ValueNode, path: &Path) -> Shaped<Environment> {
        let fields = self.fields(node, path, &ENVIRONMENT_KEYS)?;
        Ok(Environment {
            assets: self.field(&fields, "assets", Self::texts)?.unwrap_or_default(),
            asset_states: self
                .field(&fields, "asset_states", Self::all_words)?
                .unwrap_or_default(),
            objects: self.field(&fields, "objects", Self::texts)?.unwrap_or_default(),
            object_states: self
                .field(&fields, "object_states", Self::all_words)?
                .unwrap_or_default(),
            asset_properties: self.field(&fields, "asset_properties", Self::all_words)?,
            object_properties: self.field(&fields, "object_properties", Self::all_words)?,
            facts: self.field(&fields, "facts", Self::texts)?,
            names: self.field(&fields, "names", |shape, node, path| shape.map(node, path, Self::text))?,
            types: self.field(&fields, "types", |shape, node, path| shape.map(node, path, Self::text))?,
            speaker: self.field(&fields, "speaker", Self::text)?,
            robot: self.field(&fields, "robot", Self::text)?,
            ..Environment::default()
        })
    }

    /// Collects the entries with known keys and records the unknown keys.
    fn fields<'v>(&mut self, node: &'v ValueNode, path: &Path, known: &[&'static str]) -> Shaped<Fields<'v>> {
        let LiteralValue::Object(entries) = &node.value else {
            return Err(self.wrong(node, path, "an object"));
        };
        let mut fields = Fields {
            at: node.at,
            path: path.clone(),
            known: Vec::new(),
        };
        let mut places = Vec::new();
        for entry in entries {
            let Some(key) = known.iter().find(|key| **key == entry.key) else {
                self.notes
                    .add_about(Kind::ExtraKey, entry.at, path.push(&shorten(&entry.key)));
                continue;
            };
            let before = fields.known.iter().position(|(before, _)| before == key);
            match before {
                Some(index) => {
                    let same = fields.known[index].1 == &entry.node;
                    self.repeated(same, places[index], entry, path)?;
                }
                None => {
                    fields.known.push((key, &entry.node));
                    places.push(entry.at);
                }
            }
        }
        Ok(fields)
    }

    /// Parses the value of `key`; none if it is absent or null.
    fn field<T>(
        &mut self,
        fields: &Fields,
        key: &str,
        read: impl FnOnce(&mut Self, &ValueNode, &Path) -> Shaped<T>,
    ) -> Shaped<Option<T>> {
        let Some(node) = fields.get(key) else {
            return Ok(None);
        };
        let path = fields.path.push(key);
        if node.value == LiteralValue::Null {
            self.notes.add_about(Kind::Null, node.at, path);
            return Ok(None);
        }
        read(self, node, &path).map(Some)
    }

    /// Returns the parsed value, or an empty one where that is allowed; a missing key is recorded.
    fn required<T: Default>(
        &mut self,
        read: Option<T>,
        fields: &Fields,
        key: &str,
        expected: &'static str,
        may_be_empty: bool,
    ) -> Shaped<T> {
        let path = fields.path.push(key);
        match (read, fields.get(key)) {
            (Some(read), _) => Ok(read),
            (None, Some(null)) if !may_be_empty => Err(self.wrong(null, &path, expected)),
            // `field` has recorded the null.
            (None, Some(_)) => Ok(T::default()),
            (None, None) if may_be_empty => {
                self.notes.add_about(Kind::MissingKey, fields.at, path);
                Ok(T::default())
            }
            (None, None) => Err(Unreadable::WrongShape {
                path,
                position: Position::of(self.text, fields.at),
                expected,
                found: "missing",
            }),
        }
    }

    fn text(&mut self, node: &ValueNode, path: &Path) -> Shaped<String> {
        match &node.value {
            LiteralValue::Text(text) => Ok(text.clone()),
            _ => Err(self.wrong(node, path, "a text in quotes")),
        }
    }

    fn texts(&mut self, node: &ValueNode, path: &Path) -> Shaped<Vec<String>> {
        let LiteralValue::List(items) = &node.value else {
            return Err(self.wrong(node, path, "a list of texts"));
        };
        let item = |(index, item)| self.text(item, &path.index(index));
        items.iter().enumerate().map(item).collect()
    }

    fn words(&mut self, node: &ValueNode, path: &Path) -> Shaped<Words> {
        match &node.value {
            LiteralValue::Text(word) => Ok(Words::of_text(word.clone())),
            LiteralValue::List(_) => self.texts(node, path).map(Words::Many),
            _ => Err(self.wrong(node, path, "a text or a list of texts")),
        }
    }

    fn all_words(&mut self, node: &ValueNode, path: &Path) -> Shaped<IndexMap<String, Words>> {
        self.map(node, path, Self::words)
    }

    /// Parses an object with arbitrary keys.
    fn map<T: PartialEq>(
        &mut self,
        node: &ValueNode,
        path: &Path,
        read: impl Fn(&mut Self, &ValueNode, &Path) -> Shaped<T>,
    ) -> Shaped<IndexMap<String, T>> {
        let LiteralValue::Object(entries) = &node.value else {
            return Err(self.wrong(node, path, "an object"));
        };
        let mut map: IndexMap<String, T> = IndexMap::with_capacity(entries.len());
        let mut places = Vec::with_capacity(entries.len());
        for entry in entries {
            let value = read(self, &entry.node, &path.push(&shorten(&entry.key)))?;
            match map.entry(entry.key.clone()) {
                Slot::Occupied(before) => self.repeated(before.get() == &value, places[before.index()], entry, path)?,
                Slot::Vacant(slot) => {
                    slot.insert(value);
                    places.push(entry.at);
                }
            }
        }
        Ok(map)
    }

    /// Handles a repeated key: a leniency if the values are equal, otherwise an error.
    fn repeated(&mut self, same: bool, first: usize, entry: &Member, path: &Path) -> Shaped<()> {
        let path = path.push(&shorten(&entry.key));
        if !same {
            return Err(Unreadable::Contradiction {
                path,
                first: Position::of(self.text, first),
                position: Position::of(self.text, entry.at),
            });
        }
        self.notes.add_about(Kind::RepeatedKey, entry.at, path);
        Ok(())
    }

    fn wrong(&self, node: &ValueNode, path: &Path, expected: &'static str) -> Unreadable {
        Unreadable::WrongShape {
            path: path.clone(),
            position: Position::of(self.text, node.at),
            expected,
            found: match node.value {
                LiteralValue::Null => "null",
                LiteralValue::Bool(_) => "true or false",
                LiteralValue::Number(_) => "a number",
                LiteralValue::Text(_) => "a text",
                LiteralValue::List(_) => "a list",
                LiteralValue::Object(_) => "an object",
            },
        }
    }
}

/// Returns the text with its first line indented as far as the others; none if that is no change.
fn with_first_line_indented(text: &str) -> Option<String> {
    let (_, others) = text.split_once('\n')?;
    let filled = others.lines().filter(|line| !line.trim().is_empty());
    let column = filled
        .map(|line| line.len() - line.trim_start_matches(' ').len())
        .min()?;
    (column > 0).then(|| format!("{}{text}", " ".repeat(column)))
}
