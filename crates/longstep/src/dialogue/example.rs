//! The fixed messages of a goal request: task and few-shot examples.

use minijinja::context;

use super::template_context::size;
use super::{Message, Role, template};
use crate::goal::{WrittenConditional, read_form};
use crate::model::{Domain, Example, GoalWord, StateWord};

/// Checks that a model could give the example's answer: goals of this domain about entities of the example's scene.
pub(crate) fn check_example(domain: &Domain, example: &Example) -> Result<(), String> {
    if example.answer.starts_with(crate::goal::QUESTION) {
        return Ok(());
    }
    for part in example.answer.split(" & ") {
        let Some(written) = WrittenConditional::read(part) else {
            check_part(domain, example, part)?;
            continue;
        };
        let sensed = |word: &&StateWord| domain.is_sensed(word.atom.predicate);
        let word = written.condition.split('(').next().unwrap_or_default();
        if !domain.states.iter().filter(sensed).any(|state| state.word == word) {
            return Err(format!("`{}` is nothing that sensing tells", written.condition));
        }
        let thing = written.condition.trim_start_matches(word).trim_matches(['(', ')']);
        if !example.names().any(|name| name == thing) {
            return Err(format!("`{thing}` in `{part}` is not in the example's scene"));
        }
        for part in written.then.iter().chain(&written.otherwise) {
            check_part(domain, example, part)?;
        }
    }
    Ok(())
}

fn check_part(domain: &Domain, example: &Example, part: &str) -> Result<(), String> {
    let is_known = |name: &str| example.names().any(|n| n == name) || matches!(domain.value(name), Some(Ok(_)));
    let fits = |word: &GoalWord| read_form(word, part).is_some_and(|names| names.iter().all(|name| is_known(name)));
    if domain.goal_words.iter().any(fits) {
        return Ok(());
    }
    Err(match domain.goal_words.iter().find_map(|word| read_form(word, part)) {
        Some(names) => {
            let missing = names.iter().find(|name| !is_known(name));
            format!("`{}` in `{part}` is not in the example's scene", missing.unwrap_or(&""))
        }
        None => format!("`{part}` has the form of no goal word of this domain"),
    })
}

/// Renders `prompt/goal.md`. Errors carry the line in the template.
pub(crate) fn render_goal_prompt(domain: &Domain, template: &str) -> Result<String, (u32, String)> {
    let goals: Vec<_> = domain
        .goal_words
        .iter()
        .map(|word| context! { form => word.shown(), means => &word.means })
        .collect();
    let actions: Vec<_> = domain
        .actions
        .iter()
        .map(|action| context! { call => &action.call, means => &action.means })
        .collect();
    let sensed = domain
        .states
        .iter()
        .filter(|word| domain.is_sensed(word.atom.predicate));
    let conditions: Vec<_> = sensed
        .map(|word| context! { form => format!("{}(THING)", word.word), means => &word.means })
        .collect();
    let variables = context! { name => &domain.name, about => &domain.about, goals, actions, conditions };
    template::render(template, variables, size(domain)).map(|text| text.trim_end().to_owned())
}

/// Returns the fixed messages: the task, then two messages for each example.
pub(crate) fn fixed_turns(domain: &Domain) -> Vec<Message> {
    let mut turns = vec![Message::new(Role::System, domain.prompts.goal.clone())];
    for example in &domain.prompts.examples {
        let text = scene_and_instruction(&scene_text(&example.objects, &example.places), &example.instruction);
        turns.push(Message::new(Role::User, text));
        turns.push(Message::new(Role::Assistant, example.answer.clone()));
    }
    turns
}

/// Renders the two lists of a scene.
pub(super) fn scene_text(objects: &[(String, String)], places: &[(String, String)]) -> String {
    let mut text = String::new();
    for (title, entries) in [("Objects", objects), ("Places", places)] {
        text.push_str(title);
        text.push_str(":\n");
        for (name, description) in entries {
            text.push_str("- ");
            text.push_str(name);
            if !description.is_empty() {
                text.push_str(": ");
                text.push_str(description);
            }
            text.push('\n');
        }
    }
    text
}

/// Returns the user message. The scene comes first, since it changes less often than the instruction.
pub(crate) fn scene_and_instruction(scene: &str, instruction: &str) -> String {
    format!("{scene}\nInstruction: {instruction}")
}
