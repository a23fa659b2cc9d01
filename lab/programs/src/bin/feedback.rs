//! Counts the remarks on plans that a model understands (docs/guide/feedback.md has the figures).
//!
//!     cargo run --release --manifest-path lab/programs/Cargo.toml --features embedded --bin feedback -- development [LANGUAGE]
//!     cargo run --release --manifest-path lab/programs/Cargo.toml --features embedded --bin feedback -- held-out
//!
//! A language (`de`, `es`) says the development cases in another language than English. The held-out cases are on other robots, in five
//! languages: nobody looks into them, so only the totals are printed. [`open_model`] names the settings; `LONGSTEP_SHOW` prints the
//! requests, too.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::Path;

use longstep::dialogue::{Dialogue, Round};
use longstep::domain::Domain;
use longstep::feedback::{self, Amended, FeedbackDialogue, FeedbackInput, StepWish, Wish, amend};
use longstep::goal::{self, Goal};
use longstep::understanding::{Understanding, UnderstandingInput};
use longstep_core::environment::{self, Environment, World};
use longstep_core::json;
use longstep_core::plan::{Plan, TaskCohesion, resolve};
use longstep_core::search::{self, Limits, Outcome};
use longstep_core::verify::bind;
use longstep_lab::{mark, open_model, show};
use longstep_llm::{ChatModel, ConverseError, Progress, converse, load_domain};
use serde_json::Value;

type Anyhow<T> = Result<T, Box<dyn Error>>;

const DEVELOPMENT: &str = include_str!("../../data/feedback/cases.json");
const LANGUAGES: &str = include_str!("../../data/feedback/languages.json");
const HELD_OUT: &str = include_str!("../../data/feedback/held.json");

/// A remark on a plan, with the answers that are right.
struct Case {
    domain: Domain,
    world: World,
    goal: Goal,
    /// The goal in the goal language.
    goal_text: String,
    plan: Plan,
    instruction: String,
    remark: String,
    /// Changes of the steps in the notation of answers, or `goal`.
    right: Vec<String>,
    /// For an answer `goal`: the goal that is right then.
    next_goal: Option<String>,
    /// For changes of the steps: `done` or `impossible`, if it matters.
    outcome: Option<String>,
}

impl Case {
    fn read(scenes: &Value, case: &Value) -> Anyhow<Self> {
        let text = |key: &str| case[key].as_str().ok_or_else(|| format!("a case has no `{key}`"));
        let scene = &scenes[text("scene")?];
        let domain = domain_named(scene["domain"].as_str().unwrap_or_default())?;
        let written = scene["environment"].to_string();
        let environment = Environment::from_json(&written)?;
        let mut world = environment::read(&domain, &environment, "environment", &written, &json::Path::default())?;
        let right: Vec<String> = serde_json::from_value(case["right"].clone())?;
        // A session adds the numbers and quotations of what is said.
        let others = case
            .as_object()
            .into_iter()
            .flatten()
            .filter_map(|(_, value)| value.as_str());
        for text in right.iter().map(String::as_str).chain(others) {
            world.add_values(text);
        }
        let goal = goal::parse(&world, text("goal")?)?;
        let plan = match case.get("plan") {
            Some(calls) => written_plan(&world, calls, case["object"].as_str())?,
            None => planned(&world, &goal)?,
        };
        Ok(Self {
            goal_text: text("goal")?.to_owned(),
            instruction: text("instruction")?.to_owned(),
            remark: text("says")?.to_owned(),
            next_goal: case["then"].as_str().map(str::to_owned),
            outcome: case["outcome"].as_str().map(str::to_owned),
            domain,
            world,
            goal,
            plan,
            right,
        })
    }

    fn is_about_goal(&self) -> bool {
        self.right.iter().any(|answer| answer == "goal")
    }

    /// Returns whether a model understands the remark, and what it answered.
    fn ask(&self, model: &mut dyn ChatModel) -> Anyhow<(bool, String)> {
        let mut dialogue = FeedbackDialogue::new(FeedbackInput {
            domain: &self.domain,
            world: &self.world,
            plan: &self.plan,
            instruction: &self.instruction,
            feedback: &self.remark,
            kind: model.constraint_kind(),
        });
        show(&dialogue.request());
        let wish = match converse(model, &mut dialogue, &mut |_: Progress| {}) {
            Err(ConverseError::Model(error)) => return Err(error.into()),
            wish => wish.ok(),
        };
        let answer = dialogue.transcript().answer().to_owned();
        match wish {
            Some(Wish::Steps(wishes)) => {
                let (is_right, outcome) = self.judge_changes(&wishes);
                Ok((is_right, format!("{answer} [{outcome}]")))
            }
            Some(Wish::Goal | Wish::Further) if self.is_about_goal() => {
                let (is_right, goal) = self.ask_goal(model)?;
                Ok((is_right, format!("{answer} -> {goal}")))
            }
            _ => Ok((false, answer)),
        }
    }

    /// Returns whether changes of the steps are right, and their outcome.
    fn judge_changes(&self, wishes: &[StepWish]) -> (bool, String) {
        let steps = self.plan.steps().len();
        let accepted = self
            .right
            .iter()
            .filter_map(|answer| feedback::parse(&self.world, answer, steps).ok());
        let bare = without_explanations(wishes);
        let is_accepted = accepted.into_iter().any(|expected| are_same(&expected, &bare));
        let (outcome, details) = match amend(&self.world, &self.plan, wishes, &self.goal.purpose(&self.world)) {
            Amended::Done(amendment) => {
                let edits = amendment.edits.iter().map(|edit| edit.description(steps));
                ("done", edits.collect::<Vec<_>>().join("; "))
            }
            Amended::Impossible { why, .. } => (
                "impossible",
                why.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "),
            ),
        };
        let is_expected = self.outcome.as_deref().is_none_or(|expected| expected == outcome);
        (
            is_accepted && is_expected,
            format!("{outcome} {details}").trim_end().to_owned(),
        )
    }

    /// Returns whether a model writes the next goal as expected, and the goal.
    fn ask_goal(&self, model: &mut dyn ChatModel) -> Anyhow<(bool, String)> {
        let rounds = [Round {
            reply: self.goal_text.clone(),
            message: self.remark.clone(),
        }];
        let mut dialogue = Understanding::new(UnderstandingInput {
            rounds: &rounds,
            ..UnderstandingInput::new(&self.domain, &self.world, &self.instruction, model.constraint_kind())
        });
        let understood = converse(model, &mut dialogue, &mut |_: Progress| {});
        let expected = goal::parse(&self.world, self.next_goal.as_deref().unwrap_or_default())?;
        let is_right = understood.is_ok_and(|meant| meant.question.is_none() && meant.goal == Some(expected));
        Ok((is_right, dialogue.transcript().answer().to_owned()))
    }
}

fn domain_named(name: &str) -> Anyhow<Domain> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folders = ["crates/longstep-model/domains", "examples"].map(|place| root.join(place).join(name));
    let folder = folders.iter().find(|folder| folder.is_dir());
    let folder = folder.ok_or_else(|| format!("there is no domain `{name}`"))?;
    Ok(load_domain(&folder.display().to_string())?)
}

/// Returns a shortest plan for a goal.
fn planned(world: &World, goal: &Goal) -> Anyhow<Plan> {
    match search::solve(world, &goal.purpose(world), &Limits::default()) {
        Outcome::Solved { plan, .. } => Ok(plan),
        outcome => Err(format!("{outcome:?}").into()),
    }
}

/// Returns a plan from its calls.
fn written_plan(world: &World, calls: &Value, object: Option<&str>) -> Anyhow<Plan> {
    let cohesion = TaskCohesion {
        task_sequence: serde_json::from_value(calls.clone())?,
        object_name: object.map(str::to_owned),
        ..TaskCohesion::default()
    };
    let resolved = resolve(world, &cohesion);
    let steps = resolved.complete().map_err(|violations| format!("{violations:?}"))?;
    let (plan, _) = bind(world, &steps, &resolved.objects, None).map_err(|error| format!("{error:?}"))?;
    Ok(plan)
}

/// Returns true if the changes are the same, in any order: they all refer to the original plan.
fn are_same(one: &[StepWish], other: &[StepWish]) -> bool {
    one.len() == other.len() && one.iter().all(|wish| other.contains(wish))
}

fn without_explanations(wishes: &[StepWish]) -> Vec<StepWish> {
    let mut wishes = wishes.to_vec();
    for wish in &mut wishes {
        if let StepWish::Insert { explanation, .. } | StepWish::Replace { explanation, .. } = wish {
            explanation.clear();
        }
    }
    wishes
}

/// Returns the cases of a file, with the remarks of a language.
fn read_cases(file: &str, language: Option<&str>) -> Anyhow<Vec<Case>> {
    let file: Value = serde_json::from_str(file)?;
    let languages: Value = serde_json::from_str(LANGUAGES)?;
    let mut cases = Vec::new();
    for (index, case) in file["cases"].as_array().into_iter().flatten().enumerate() {
        let mut case = case.clone();
        if let Some(language) = language {
            case["says"] = languages[language][index].clone();
        }
        cases.push(Case::read(&file["scenes"], &case)?);
    }
    Ok(cases)
}

fn main() -> Anyhow<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match &words[..] {
        ["development"] => measure_development(&read_cases(DEVELOPMENT, None)?),
        ["development", language] => measure_development(&read_cases(DEVELOPMENT, Some(language))?),
        ["held-out"] => measure_held_out(&read_cases(HELD_OUT, None)?),
        _ => Err("usage: feedback development [LANGUAGE] | feedback held-out".into()),
    }
}

fn measure_development(cases: &[Case]) -> Anyhow<()> {
    let mut model = open_model()?;
    let mut right = 0;
    for case in cases {
        let (is_right, answer) = case.ask(model.as_mut())?;
        right += usize::from(is_right);
        println!("{} {}  ->  {answer}", mark(is_right), case.remark);
    }
    println!("{right} of {} right", cases.len());
    Ok(())
}

fn measure_held_out(cases: &[Case]) -> Anyhow<()> {
    let mut model = open_model()?;
    let (about_goals, about_steps): (Vec<&Case>, Vec<&Case>) = cases.iter().partition(|case| case.is_about_goal());
    for (name, group) in [("changes of the steps", about_steps), ("goals", about_goals)] {
        let mut right = 0;
        for case in &group {
            right += usize::from(case.ask(model.as_mut())?.0);
        }
        println!("{name}: {right} of {} right", group.len());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]

    use super::*;

    /// A case none of whose answers can be read would count nothing.
    #[test]
    fn every_case_has_a_right_answer() {
        let languages: Value = serde_json::from_str(LANGUAGES).unwrap();
        let mut files = vec![
            read_cases(DEVELOPMENT, None).unwrap(),
            read_cases(HELD_OUT, None).unwrap(),
        ];
        for language in languages.as_object().unwrap().keys() {
            files.push(read_cases(DEVELOPMENT, Some(language)).unwrap());
        }
        for case in files.iter().flatten() {
            if case.is_about_goal() {
                goal::parse(&case.world, case.next_goal.as_deref().unwrap()).unwrap();
                continue;
            }
            let steps = case.plan.steps().len();
            let mut read = case
                .right
                .iter()
                .map(|answer| feedback::parse(&case.world, answer, steps));
            assert!(read.any(|wishes| wishes.is_ok()), "{:?}: {}", case.right, case.remark);
            let outcomes = ["done", "impossible"];
            assert!(
                case.outcome.as_deref().is_none_or(|own| outcomes.contains(&own)),
                "{}",
                case.remark
            );
        }
    }
}
