//! Skill values: how steps are performed, keyed by action and arguments.
//!
//! A domain declares the parameters ([`SkillParameter`]); a person teaches the values, or the robot finds them. Planning
//! does not depend on them: they are passed to the robot with the step.

use indexmap::IndexMap;
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::plan::{Plan, StepId};
use longstep_model::call::Call;
use longstep_model::diagnostic::{Diagnostic, Diagnostics, Position, nearest};
use longstep_model::json::{Locator, Path};
use longstep_model::model::{Action, ActionId, Domain, EntityId, SkillParameter, SkillSource, SkillType, World};

/// The mark for any argument.
const ANY: &str = "_";
/// Maximum number of entries in a file.
const ENTRIES: usize = 10_000;
/// Maximum number of points of a path.
const POINTS: usize = 10_000;
/// Maximum number of characters of a text.
const CHARACTERS: usize = 1_000;
/// The largest number, in any unit.
const LARGEST: f64 = 1e9;

/// The values of skill parameters.
///
/// ```
/// use longstep_model::domain;
/// use longstep_verify::skill::Skills;
/// # let mut files = domain::shipped_files("household").unwrap();
/// # files.words = files.words.replacen("call = \"grasp_object()\"", "call = \"grasp_object()\"\nretries = 2\nskill = [{ name = \"width\", type = \"number\", unit = \"m\", from = \"demonstration\" }]", 1);
/// # let domain = domain::load(&files).unwrap();
/// // `grasp` declares `width`, a number in metres that a person teaches.
/// let text = r#"{"grasp": [{"arguments": ["_"], "values": {"width": 0.08}},
///                          {"arguments": ["<pen>"], "values": {"width": 0.01}}]}"#;
/// let skills = Skills::parse(&domain, "skills.json", text).unwrap();
/// # let env = r#"{"assets": ["<desk>"], "objects": ["<pen>", "<cup>"]}"#;
/// # let world = longstep_model::environment::parse(&domain, "env.json", env).unwrap();
/// # let (grasp, _) = domain.action_ids().find(|(_, action)| action.name == "grasp").unwrap();
/// let pen = skills.values(&world, None, grasp, &[world.find("<pen>").unwrap()]);
/// assert_eq!(pen["width"], 0.01);
/// let cup = skills.values(&world, None, grasp, &[world.find("<cup>").unwrap()]);
/// assert_eq!(cup["width"], 0.08);
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Skills {
    entries: Vec<SkillEntry>,
    /// The file, for the log of an execution.
    source: Value,
}

#[derive(Debug, Clone, PartialEq)]
struct SkillEntry {
    action: ActionId,
    /// By parameter: the identifier; none for any.
    arguments: Vec<Option<String>>,
    /// The step of the plan; none for any.
    step: Option<StepId>,
    values: Map<String, Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EntryText {
    arguments: Vec<String>,
    /// The number of the step in the plan, from 1.
    step: Option<std::num::NonZeroU32>,
    values: Map<String, Value>,
    #[serde(default)]
    taught: IndexMap<String, TaughtText>,
}

/// The origin of a value that was taught. Read for its form only: a robot gets the value.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TaughtText {
    uncertainty: Option<f64>,
    #[serde(rename = "unit")]
    _unit: Option<String>,
    #[serde(rename = "source")]
    _source: String,
}

/// A step whose parameter a person has not taught.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("step {} `{call}` has no `{parameter}` ({kind}); teach it, or add it to the skills file", .step.index() + 1)]
#[non_exhaustive]
pub struct MissingSkill {
    /// The step.
    pub step: StepId,
    /// The action with all its arguments.
    pub call: String,
    /// The parameter.
    pub parameter: String,
    /// Its type.
    pub kind: &'static str,
}

impl Skills {
    /// Reads a skills file: for each action, by its name in `domain.pddl`, a list of arguments with values. `_` stands
    /// for any argument; of several entries that fit, one for the step counts for each parameter, then the one with the
    /// fewest `_`, then the first one.
    ///
    /// # Errors
    ///
    /// All mistakes, with their places.
    pub fn parse(domain: &Domain, file: &str, text: &str) -> Result<Self, Diagnostics> {
        let source: Value = serde_json::from_str(text).map_err(|error| {
            let (line, column) = (error.line() as u32, error.column().max(1) as u32);
            let position = Position { line, column };
            Diagnostics(vec![Diagnostic::at(file, position, error.to_string())])
        })?;
        Self::read(domain, file, text, source)
    }

    /// Reads a skills file that was parsed as JSON before.
    ///
    /// # Errors
    ///
    /// As for [`Skills::parse`], without places.
    pub fn from_value(domain: &Domain, source: Value) -> Result<Self, Diagnostics> {
        Self::read(domain, "skills", "", source)
    }

    fn read(domain: &Domain, file: &str, text: &str, source: Value) -> Result<Self, Diagnostics> {
        let mut reader = Reader {
            domain,
            file,
            locator: Locator::new(text),
            entries: Vec::new(),
            findings: Vec::new(),
        };
        match &source {
            Value::Null => {}
            Value::Object(actions) => {
                for (name, entries) in actions {
                    reader.action(name, entries);
                }
            }
            _ => reader.report(
                &Path::default(),
                "a skills file is an object with an entry for each action".to_owned(),
            ),
        }
        if reader.findings.is_empty() {
            Ok(Self {
                entries: reader.entries,
                source,
            })
        } else {
            Err(Diagnostics::sorted(reader.findings))
        }
    }

    /// The file as it was read; null for no skills.
    pub fn source(&self) -> &Value {
        &self.source
    }

    /// Returns the values for a step, by parameter. `step` is the step of the plan for which the values are; none for a
    /// plan that was changed, in which entries for a step fit no more.
    pub fn values(
        &self,
        world: &World,
        step: Option<StepId>,
        action: ActionId,
        arguments: &[EntityId],
    ) -> Map<String, Value> {
        let is = |(own, entity): (&Option<String>, &EntityId)| {
            own.as_ref().is_none_or(|own| *own == world.entity(*entity).identifier)
        };
        let fits = |entry: &&SkillEntry| {
            entry.action == action
                && entry.step.is_none_or(|own| step == Some(own))
                && entry.arguments.iter().zip(arguments).all(is)
        };
        let mut fitting: Vec<&SkillEntry> = self.entries.iter().filter(fits).collect();
        fitting.sort_by_key(|entry| {
            (
                entry.step.is_none(),
                entry.arguments.iter().filter(|own| own.is_none()).count(),
            )
        });
        let mut values = Map::new();
        for parameter in &world.domain().action(action).skills {
            let value = fitting.iter().find_map(|entry| entry.values.get(&parameter.name));
            if let Some(value) = value {
                values.insert(parameter.name.clone(), value.clone());
            }
        }
        values
    }

    /// Returns the parameters of the steps of a plan that have to be taught and have no value, in order.
    pub fn missing(&self, world: &World, plan: &Plan) -> Vec<MissingSkill> {
        let mut missing = Vec::new();
        for (index, step) in plan.steps().iter().enumerate() {
            let mut parameters = self
                .untaught(world, Some(StepId::new(index)), step.action, &step.arguments)
                .peekable();
            if parameters.peek().is_none() {
                continue;
            }
            let call = Call {
                name: world.domain().action(step.action).call.clone(),
                arguments: step
                    .arguments
                    .iter()
                    .map(|entity| world.entity(*entity).identifier.clone())
                    .collect(),
            };
            missing.extend(parameters.map(|parameter| MissingSkill {
                step: StepId::new(index),
                call: call.to_string(),
                parameter: parameter.name.clone(),
                kind: parameter.kind.name(),
            }));
        }
        missing
    }

    /// Returns the parameters of a step that have to be taught and have no value. `step` is as for [`Skills::values`].
    pub fn untaught<'a>(
        &self,
        world: &'a World,
        step: Option<StepId>,
        action: ActionId,
        arguments: &[EntityId],
    ) -> impl Iterator<Item = &'a SkillParameter> + use<'a> {
        let skills = &world.domain().action(action).skills;
        let values = if skills.is_empty() {
            Map::new()
        } else {
            self.values(world, step, action, arguments)
        };
        skills
            .iter()
            .filter(move |own| own.from == SkillSource::Demonstration && !values.contains_key(&own.name))
    }
}

struct Reader<'a> {
    domain: &'a Domain,
    file: &'a str,
    locator: Locator<'a>,
    entries: Vec<SkillEntry>,
    findings: Vec<Diagnostic>,
}

impl Reader<'_> {
    fn report(&mut self, path: &Path, message: String) {
        let message = match path.to_string().as_str() {
            "" => message,
            path => format!("{path}: {message}"),
        };
        if self.findings.len() < 100 {
            self.findings
                .push(Diagnostic::whole(self.file, message).with_position(self.locator.locate(path)));
        }
    }

    fn action(&mut self, name: &str, entries: &Value) {
        let path = Path::key(name);
        let domain = self.domain;
        let Some((id, action)) = domain.action_ids().find(|(_, own)| own.name == name) else {
            let near = nearest(name, domain.actions.iter().map(|own| own.name.as_str()));
            let near = near.map_or(String::new(), |near| format!("; did you mean `{near}`?"));
            return self.report(&path, format!("the domain has no action `{name}`{near}"));
        };
        let Some(entries) = entries.as_array() else {
            return self.report(&path, "expected a list of `arguments` with `values`".to_owned());
        };
        for (index, entry) in entries.iter().enumerate() {
            let path = path.index(index);
            if self.entries.len() >= ENTRIES {
                return self.report(&path, format!("more than {ENTRIES} entries"));
            }
            match EntryText::deserialize(entry) {
                Ok(entry) => self.entry(&path, id, action, entry),
                Err(error) => self.report(&path, error.to_string()),
            }
        }
    }

    fn entry(&mut self, path: &Path, id: ActionId, action: &Action, entry: EntryText) {
        if entry.arguments.len() != action.parameters.len() {
            let names: Vec<&str> = action.parameters.iter().map(|own| own.name.as_str()).collect();
            let message = format!(
                "`{}` has {} arguments ({}), and this entry has {}",
                action.name,
                names.len(),
                names.join(", "),
                entry.arguments.len()
            );
            self.report(&path.push("arguments"), message);
        }
        for (name, value) in &entry.values {
            let path = path.push("values").push(name);
            match action.skills.iter().find(|own| own.name == *name) {
                Some(parameter) if is_value(parameter.kind, value) => {}
                Some(parameter) => self.report(&path, format!("expected {}", parameter.kind.form())),
                None => {
                    let message = format!("`{}` declares no skill parameter `{name}`", action.name);
                    self.report(&path, message);
                }
            }
        }
        for (name, taught) in &entry.taught {
            let path = path.push("taught").push(name);
            if !entry.values.contains_key(name) {
                self.report(&path, format!("there is no value of `{name}`"));
            }
            if taught.uncertainty.is_some_and(|own| !(0.0..=LARGEST).contains(&own)) {
                self.report(
                    &path.push("uncertainty"),
                    "expected a number that is not negative".to_owned(),
                );
            }
        }
        let argument = |own: String| (own != ANY).then_some(own);
        self.entries.push(SkillEntry {
            action: id,
            step: entry.step.map(|number| StepId::new(number.get() as usize - 1)),
            arguments: entry.arguments.into_iter().map(argument).collect(),
            values: entry.values,
        });
    }
}

/// Returns true if the value has the form of its type.
fn is_value(kind: SkillType, value: &Value) -> bool {
    match kind {
        SkillType::Pose => numbers::<7>(value).is_some_and(|pose| (length(&pose[3..]) - 1.0).abs() < 0.01),
        SkillType::Point | SkillType::Vector => numbers::<3>(value).is_some(),
        SkillType::Direction => numbers::<3>(value).is_some_and(|direction| length(&direction) > 1e-9),
        SkillType::Angle | SkillType::Force | SkillType::Number => number(value).is_some(),
        SkillType::Grasp | SkillType::Text => {
            let length = value.as_str().map(|text| text.chars().count());
            length.is_some_and(|length| (1..=CHARACTERS).contains(&length))
        }
        SkillType::Waypoints => value.as_array().is_some_and(|points| {
            (1..=POINTS).contains(&points.len()) && points.iter().all(|point| numbers::<3>(point).is_some())
        }),
    }
}

fn number(value: &Value) -> Option<f64> {
    value.as_f64().filter(|number| number.abs() <= LARGEST)
}

fn numbers<const N: usize>(value: &Value) -> Option<[f64; N]> {
    let values = value.as_array()?;
    let numbers: Option<Vec<f64>> = values.iter().map(number).collect();
    numbers?.try_into().ok()
}

fn length(vector: &[f64]) -> f64 {
    vector.iter().map(|part| part * part).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use longstep_model::domain::{self, Files};

    use longstep_model::testing;

    use crate::plan::{Plan, Step};

    fn files(skills: &str) -> Files {
        let mut files = domain::shipped_files("household").unwrap();
        let call = "call = \"attach_to_plane()\"";
        assert!(files.words.contains(call));
        files.words = files.words.replacen(call, &format!("{call}\n{skills}"), 1);
        files
    }

    const SKILLS: &str = r#"retries = 3
skill = [{ name = "approach", type = "direction", from = "demonstration" },
         { name = "pose", type = "pose", unit = "m", from = "robot" },
         { name = "path", type = "waypoints", unit = "m", from = "robot" }]"#;

    #[test]
    fn declarations_are_checked() {
        let load = |skills: &str| match domain::load(&files(skills)) {
            Ok(_) => String::new(),
            Err(findings) => findings.to_string(),
        };
        assert_eq!(load(SKILLS), "");
        for (skills, expected) in [
            ("retries = 101", "`retries` is a number from 0 to 100"),
            (
                r#"skill = [{ name = "a", type = "pos", from = "robot" }]"#,
                "unknown type of skill parameters `pos`",
            ),
            (
                r#"skill = [{ name = "a b", type = "pose", from = "robot" }]"#,
                "letters, digits and underscores",
            ),
            (
                r#"skill = [{ name = "a", type = "pose", from = "me" }]"#,
                "`from` is `demonstration` or `robot`",
            ),
            (
                r#"skill = [{ name = "a", type = "text", unit = "m", from = "robot" }]"#,
                "have no unit",
            ),
            (
                r#"skill = [{ name = "a", type = "direction", from = "demonstration", fit = "axle" }]"#,
                "unknown fit `axle`",
            ),
            (
                r#"skill = [{ name = "a", type = "direction", from = "robot", fit = "axis" }]"#,
                "only a parameter with `from = \"demonstration\"` has a `fit`",
            ),
            (
                r#"skill = [{ name = "a", type = "point", unit = "m", from = "demonstration", fit = "axis" }]"#,
                "gives values of the type `direction`",
            ),
            (
                r#"skill = [{ name = "a", type = "angle", unit = "deg", from = "demonstration", fit = "angle" }]"#,
                "needs `unit = \"rad\"`",
            ),
            (
                r#"skill = [{ name = "a", type = "text", from = "demonstration", fit = "hand", prior = [0, 0, 1] }]"#,
                "only fits of a direction or a displacement have a `prior`",
            ),
            (
                r#"skill = [{ name = "a", type = "direction", from = "demonstration", fit = "axis", prior = [0, 0, 0] }]"#,
                "three numbers, not all of them zero",
            ),
            (
                r#"skill = [{ name = "a", type = "text", from = "robot" }, { name = "a", type = "text", from = "robot" }]"#,
                "declared twice",
            ),
        ] {
            let found = load(skills);
            assert!(found.contains(expected), "{skills}: {found}");
        }
    }

    #[test]
    fn values_are_checked() {
        let domain = domain::load(&files(SKILLS)).unwrap();
        let entry = |values: &str| format!(r#"{{"attach": [{{"arguments": ["_", "<shelf>"], "values": {values}}}]}}"#);
        let mistakes = |text: &str| match Skills::parse(&domain, "skills.json", text) {
            Ok(_) => String::new(),
            Err(findings) => findings.to_string(),
        };
        for good in [
            r#"{"approach": [0, 0, -1]}"#,
            r#"{"pose": [0.1, 0.2, 0.3, 0, 0, 0, 1], "path": [[0, 0, 0], [1, 1, 1]]}"#,
        ] {
            assert_eq!(mistakes(&entry(good)), "", "{good}");
        }
        for (text, expected) in [
            (
                entry(r#"{"approach": [0, 0, 0]}"#),
                "expected three numbers, not all of them zero",
            ),
            (
                entry(r#"{"approach": [0, 0]}"#),
                "expected three numbers, not all of them zero",
            ),
            (entry(r#"{"pose": [0, 0, 0, 0, 0, 0, 9]}"#), "a quaternion of length 1"),
            (entry(r#"{"path": []}"#), "1 to 10,000 points"),
            (entry(r#"{"path": [[1e99, 0, 0]]}"#), "1 to 10,000 points"),
            (entry(r#"{"speed": 1}"#), "declares no skill parameter `speed`"),
            (entry(r#"{"path": [[0, 0, 0]]}, "step": 0"#), "expected a nonzero u32"),
            (
                entry(r#"{}, "taught": {"path": {"source": "a.csv"}}"#),
                "there is no value of `path`",
            ),
            (
                entry(r#"{"path": [[0, 0, 0]]}, "taught": {"path": {"source": "a.csv", "uncertainty": -1}}"#),
                "not negative",
            ),
            (
                entry(r#"{"path": [[0, 0, 0]]}, "taught": {"path": {"origin": "a.csv"}}"#),
                "unknown field `origin`",
            ),
            (
                r#"{"attach": [{"arguments": ["_"], "values": {}}]}"#.to_owned(),
                "has 2 arguments (item, to)",
            ),
            (r#"{"attahc": []}"#.to_owned(), "did you mean `attach`?"),
            (r#"{"attach": 3}"#.to_owned(), "expected a list"),
            ("[]".to_owned(), "a skills file is an object"),
            ("{".to_owned(), "skills.json:1:1: EOF"),
        ] {
            let found = mistakes(&text);
            assert!(found.contains(expected), "{text}: {found}");
        }
    }

    #[test]
    fn a_step_that_nobody_taught_is_named() {
        let domain = domain::load(&files(SKILLS)).unwrap();
        let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
        let world = testing::world_of(&domain, text);
        let (attach, _) = domain.action_ids().find(|(_, action)| action.name == "attach").unwrap();
        let arguments = ["<cup>", "<shelf>"].map(|name| world.find(name).unwrap());
        let plan = Plan::sequence(vec![Step::explained(&world, attach, arguments.to_vec())]);
        let missing = Skills::default().missing(&world, &plan);
        let messages: Vec<String> = missing.iter().map(ToString::to_string).collect();
        assert_eq!(
            messages,
            [
                "step 1 `attach_to_plane(<cup>, <shelf>)` has no `approach` (direction); teach it, or add it to the skills file"
            ]
        );
        let taught = r#"{"attach": [{"arguments": ["_", "<shelf>"], "values": {"approach": [0, 0, -1]}}]}"#;
        let taught = Skills::parse(&domain, "skills.json", taught).unwrap();
        assert_eq!(taught.missing(&world, &plan), []);
    }

    #[test]
    fn an_entry_for_a_step_counts_in_that_step_only() {
        let domain = domain::load(&files(SKILLS)).unwrap();
        let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
        let world = testing::world_of(&domain, text);
        let skills = r#"{"attach": [{"arguments": ["_", "<shelf>"], "values": {"approach": [0, 0, -1]}},
                                    {"arguments": ["_", "_"], "step": 5, "values": {"approach": [0, 1, 0]},
                                     "taught": {"approach": {"uncertainty": 0.01, "unit": "rad", "source": "a.csv"}}}]}"#;
        let skills = Skills::parse(&domain, "skills.json", skills).unwrap();
        let (attach, _) = domain.action_ids().find(|(_, action)| action.name == "attach").unwrap();
        let arguments = ["<cup>", "<shelf>"].map(|name| world.find(name).unwrap());
        let approach = |step: Option<usize>| {
            let values = skills.values(&world, step.map(StepId::new), attach, &arguments);
            values["approach"].clone()
        };
        assert_eq!(approach(Some(4)), serde_json::json!([0, 1, 0]));
        assert_eq!(approach(Some(3)), serde_json::json!([0, 0, -1]));
        assert_eq!(approach(None), serde_json::json!([0, 0, -1]));
    }
}
