//! Counts the wishes for which a model puts stored plans together as expected (docs/guide/feedback.md has the figure).
//!
//!     cargo run --release --manifest-path lab/programs/Cargo.toml --features embedded --bin compositions
//!
//! [`open_model`] names the settings; `LONGSTEP_SHOW` prints the requests, too.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::time::Instant;

use longstep::compose::{self, Composed, CompositionAnswer, CompositionDialogue, CompositionInput, Stored};
use longstep::dialogue::Dialogue;
use longstep::domain;
use longstep_core::environment::{self, Environment, World};
use longstep_core::json;
use longstep_core::plan::{Node, PlanFile, Written, script};
use longstep_lab::{mark, open_model, show};
use longstep_llm::{ConverseError, Progress, converse};
use serde_json::{Value, json};

type Anyhow<T> = Result<T, Box<dyn Error>>;

const CASES: &str = include_str!("../../data/compositions/cases.json");

/// A world with stored plans.
struct Scene {
    world: World,
    stored: Vec<Stored>,
}

impl Scene {
    fn read(scene: &Value) -> Anyhow<Self> {
        let domain = domain::shipped(text(&scene["domain"])).ok_or("there is no such domain")??;
        let written = scene["environment"].to_string();
        let environment = Environment::from_json(&written)?;
        let world = environment::read(&domain, &environment, "environment", &written, &json::Path::default())?;
        let plans = scene["plans"].as_object().into_iter().flatten();
        let stored = plans.map(|(name, plan)| Ok(Stored::new(name, plan_file(scene, plan)?)));
        Ok(Self {
            world,
            stored: stored.collect::<Anyhow<_>>()?,
        })
    }

    /// Returns the reason why a composition is not valid; none if it is.
    fn fault(&self, written: &Written, wish: &str) -> Option<String> {
        let inlined = match compose::inline(&self.world, written, &self.stored) {
            Ok(inlined) => inlined,
            Err(misfits) => return Some(misfits.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")),
        };
        let composed = Composed::new(&self.world, inlined, wish);
        if composed.verified().is_some() {
            return None;
        }
        let violations = composed.verdict().violations;
        Some(
            violations
                .into_iter()
                .map(|violation| violation.message)
                .collect::<Vec<_>>()
                .join("; "),
        )
    }
}

/// Returns a plan of a scene, whose steps are pairs of call and explanation, as a plan file.
fn plan_file(scene: &Value, plan: &Value) -> Anyhow<PlanFile> {
    let steps = plan["steps"].as_array().ok_or("a plan has no steps")?;
    let column = |column: usize| steps.iter().map(|step| &step[column]).collect::<Vec<_>>();
    let file = json!({
        "task_cohesion": {"task_sequence": column(0), "step_instructions": column(1), "object_name": plan["object"]},
        "environment_before": plan.get("environment").unwrap_or(&scene["environment"]),
        "instruction_summary": plan["summary"],
    });
    Ok(serde_json::from_value(file)?)
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

/// Returns a composition as a script whose lanes are in the order of their actors; none for a question.
fn normal_form(answer: &CompositionAnswer) -> Option<String> {
    let CompositionAnswer::Composition(written) = answer else {
        return None;
    };
    let mut written = written.clone();
    for node in &mut written.body {
        if let Node::Parallel { lanes } = node {
            lanes.sort_by(|one, other| one.actor.cmp(&other.actor));
        }
    }
    Some(script::write(&written))
}

/// Returns the compositions that are right for a case.
fn right_answers(case: &Value) -> Anyhow<Vec<CompositionAnswer>> {
    let answers = case["right"].as_array().into_iter().flatten();
    answers.map(|answer| Ok(compose::read(text(answer))?)).collect()
}

fn main() -> Anyhow<()> {
    let file: Value = serde_json::from_str(CASES)?;
    let mut model = open_model()?;
    let (mut verified, mut right, mut count) = (0, 0, 0);
    for case in file["cases"].as_array().into_iter().flatten() {
        let scene = Scene::read(&file["scenes"][text(&case["scene"])])?;
        let instruction = text(&case["instruction"]);
        let mut dialogue = CompositionDialogue::new(CompositionInput {
            world: &scene.world,
            stored: &scene.stored,
            instruction,
            rounds: &[],
            kind: model.constraint_kind(),
        });
        show(&dialogue.request());
        let started = Instant::now();
        let answer = match converse(model.as_mut(), &mut dialogue, &mut |_: Progress| {}) {
            Err(ConverseError::Model(error)) => return Err(error.into()),
            answer => answer,
        };
        let seconds = started.elapsed().as_secs_f64();
        let form = answer.as_ref().ok().and_then(normal_form);
        let is_right = form.is_some() && right_answers(case)?.iter().any(|right| normal_form(right) == form);
        let fault = match &answer {
            Ok(CompositionAnswer::Composition(written)) => scene.fault(written, instruction),
            Ok(CompositionAnswer::Question(question)) => Some(question.clone()),
            Err(error) => Some(error.to_string()),
        };
        count += 1;
        right += usize::from(is_right);
        verified += usize::from(fault.is_none());
        let verdict = fault.map_or_else(|| "verified".to_owned(), |fault| format!("not verified: {fault}"));
        let answer = dialogue.transcript().answer();
        println!(
            "{} {seconds:5.1} s  {instruction}\n{answer}\n  {verdict}\n",
            mark(is_right)
        );
    }
    println!("{verified} of {count} verified, {right} of {count} right");
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]

    use super::*;

    /// A case whose own answer is not valid would count nothing.
    #[test]
    fn every_right_composition_is_valid() {
        let file: Value = serde_json::from_str(CASES).unwrap();
        for case in file["cases"].as_array().unwrap() {
            let scene = Scene::read(&file["scenes"][text(&case["scene"])]).unwrap();
            for right in right_answers(case).unwrap() {
                let CompositionAnswer::Composition(written) = &right else {
                    panic!("{right:?}")
                };
                assert_eq!(scene.fault(written, text(&case["instruction"])), None, "{right:?}");
            }
        }
    }
}
