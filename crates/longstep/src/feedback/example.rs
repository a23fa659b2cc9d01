//! The fixed messages of a feedback request: task and few-shot examples.

use serde_json::json;

use super::grammar::{FURTHER, GOAL};
use super::language::{JOINT, WrittenWish, action_of, form};
use crate::call::Call;
use crate::dialogue::{ConstraintKind, Message, Role};
use crate::goal::QUESTION;
use crate::model::{Domain, FeedbackExample};

/// Checks that a model could give the example's answer: changes of the example's plan with calls of this domain.
pub(crate) fn check_feedback_example(domain: &Domain, example: &FeedbackExample) -> Result<(), String> {
    let text = format!("{}\n{}\n{}", example.instruction, example.plan.join("\n"), example.says).to_lowercase();
    let known = |call: &str| -> Result<(), String> {
        let (_, call) = action_of(domain, call).map_err(|error| error.to_string())?;
        match call.arguments.iter().find(|name| !text.contains(&name.to_lowercase())) {
            Some(name) => Err(format!("`{name}` in `{call}` is not spoken of in the example")),
            None => Ok(()),
        }
    };
    for step in &example.plan {
        let end = step.find(')').map_or(step.len(), |end| end + 1);
        action_of(domain, &step[..end]).map_err(|error| error.to_string())?;
    }
    if [GOAL, FURTHER].contains(&example.answer.as_str()) || example.answer.starts_with(QUESTION) {
        return Ok(());
    }
    for part in example.answer.split(JOINT) {
        match form(part, example.plan.len()).map_err(|error| error.to_string())? {
            WrittenWish::Insert { call, .. } | WrittenWish::Replace { call, .. } => known(call)?,
            WrittenWish::Drop { .. } | WrittenWish::Move { .. } => {}
        }
    }
    Ok(())
}

/// Returns the fixed messages: the task, then two messages for each example.
pub(super) fn fixed_turns(domain: &Domain, kind: ConstraintKind) -> Vec<Message> {
    let mut turns = vec![Message::new(Role::System, task(domain, kind))];
    for example in &domain.prompts.feedback_examples {
        turns.push(Message::new(
            Role::User,
            plan_and_words(&example.instruction, &example.plan, &example.says),
        ));
        turns.push(Message::new(Role::Assistant, answer(&example.answer, kind)));
    }
    turns
}

fn task(domain: &Domain, kind: ConstraintKind) -> String {
    let mut text = String::from(
        "A robot has a plan. A person reads it and says what should be different. You write down how the plan has to \
         change.\n\nA change of the steps is one of these, with the numbers of the plan:\n\
         - insert CALL after N, insert CALL before N: one more step\n\
         - drop N: a step that is not wanted\n\
         - replace N with CALL: another action in the place of a step\n\
         - move N after M, move N before M: a step at another place\n\nThe calls are:\n",
    );
    for action in &domain.actions {
        let arguments: Vec<String> = action
            .explicit
            .iter()
            .map(|parameter| action.parameters[*parameter].name.to_uppercase())
            .collect();
        let call = Call {
            name: action.call.clone(),
            arguments,
        };
        text.push_str(&format!("- {call}: {}\n", action.means));
    }
    text.push_str(
        "\nJoin several changes with \" & \". Write only what the person asks for.\n\nIf the person does not speak of \
         steps but wants something else done, another thing or another place, write: goal\nIf the person wants a task \
         done beside this one, write: further\nIf it is not clear what should change, ask back: question: and one \
         short question.",
    );
    if kind == ConstraintKind::JsonSchema {
        text.push_str(
            "\n\nWrite the answer as a JSON object with four keys: \"edits\", the list of changes, \"goal\", true if \
             the person wants something else done, \"further\", true if the person wants a task done beside this one, and \
             \"question\", which is empty unless you have to ask.",
        );
    }
    text
}

fn answer(answer: &str, kind: ConstraintKind) -> String {
    match kind {
        ConstraintKind::Grammar => answer.to_owned(),
        ConstraintKind::JsonSchema => {
            let question = answer.strip_prefix(QUESTION);
            let edits: Vec<&str> = match answer {
                GOAL | FURTHER => Vec::new(),
                _ if question.is_some() => Vec::new(),
                edits => edits.split(JOINT).collect(),
            };
            json!({"question": question.unwrap_or(""), "goal": answer == GOAL, "further": answer == FURTHER,
                "edits": edits})
            .to_string()
        }
    }
}

/// Returns the user message.
pub(super) fn plan_and_words(instruction: &str, steps: &[String], feedback: &str) -> String {
    let mut text = format!("Instruction: {instruction}\nPlan:\n");
    for (index, step) in steps.iter().enumerate() {
        text.push_str(&format!("{}. {step}\n", index + 1));
    }
    text.push_str(&format!("The person says: {feedback}"));
    text
}
