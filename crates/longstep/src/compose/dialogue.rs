//! Compositions as a dialogue with a model.

use super::Stored;
use super::examples::{CompositionExample, EXAMPLES};
use super::grammar::{grammar, schema};
use super::menu::Menu;
use super::read::{CompositionAnswer, in_json, read};
use crate::dialogue::{
    ChatRequest, ConstraintKind, Dialogue, DialogueError, Message, Reply, Role, Round, Task, Transcript, plain_line,
};
use crate::environment::World;

/// Token budget of a script. The longest useful script under the grammar is shorter.
const SCRIPT_TOKENS: u32 = 512;
/// Token budget of a JSON tree.
const TREE_TOKENS: u32 = 2048;

/// The inputs of a composition dialogue.
#[derive(Debug, Clone, Copy)]
pub struct CompositionInput<'a> {
    /// The current world.
    pub world: &'a World,
    /// The stored plans.
    pub stored: &'a [Stored],
    /// The instruction of the person.
    pub instruction: &'a str,
    /// The earlier answers of the model, each with the feedback on it.
    pub rounds: &'a [Round],
    /// The kind of constraint that the model supports.
    pub kind: ConstraintKind,
}

/// Lets a model compose stored plans. One request, or two if a server's first reply cannot be read.
#[derive(Debug, Clone)]
pub struct CompositionDialogue {
    menu: Menu,
    transcript: Transcript,
}

impl CompositionDialogue {
    /// Starts a dialogue for a composition of stored plans that fulfils the instruction, or for a question.
    ///
    /// Task and examples come first and are equal in all requests, so a prefix cache can keep them. With
    /// [`ConstraintKind::Grammar`] the model writes a script; with [`ConstraintKind::JsonSchema`], which servers accept,
    /// it writes a JSON tree.
    pub fn new(input: CompositionInput<'_>) -> Self {
        let menu = Menu::of(input.world, input.stored, input.instruction);
        let mut transcript = Transcript::new(input.kind, fixed(input.kind)).for_task(Task::Plans);
        transcript.push(Role::User, query(&menu, input.instruction));
        for round in input.rounds {
            transcript.push(Role::Assistant, round.reply.clone());
            transcript.push(Role::User, plain_line(&round.message));
        }
        Self { menu, transcript }
    }
}

impl Dialogue for CompositionDialogue {
    type Output = CompositionAnswer;

    fn request(&self) -> ChatRequest {
        match self.transcript.kind {
            ConstraintKind::Grammar => self.transcript.under_grammar(grammar(&self.menu), SCRIPT_TOKENS),
            ConstraintKind::JsonSchema => self.transcript.under_schema(schema(&self.menu), TREE_TOKENS),
        }
    }

    fn supply(&mut self, reply: &Reply) -> Result<Option<CompositionAnswer>, DialogueError> {
        self.transcript.receive(reply)?;
        let answer = read(&reply.text).map_err(|error| DialogueError::Unreadable(error.to_string()));
        self.transcript.read_or_repeat(reply, answer)
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}

/// Addition to the task for JSON replies, since the task describes lines.
const AS_TREE: &str = "\nWrite the program as a JSON object: \"task_tree\" is the list of its parts, {\"call\": \
    \"fetch_pear()\"} for a call, {\"if\": {\"call\": \"rotten(pear)\"}, \"then\": [...], \"else\": [...]} for a branch, \
    {\"parallel\": [{\"lane\": \"left\", \"do\": [...]}, ...]} for arms side by side. \"question\" is empty unless you \
    have to ask; then the list is.";

fn fixed(kind: ConstraintKind) -> Vec<Message> {
    let mut task = include_str!("task.md").trim_end().to_owned();
    if kind == ConstraintKind::JsonSchema {
        task.push_str(AS_TREE);
    }
    let mut messages = vec![Message::new(Role::System, task)];
    for example in EXAMPLES {
        messages.push(Message::new(Role::User, example_query(example)));
        let answer = match kind {
            ConstraintKind::Grammar => example.answer.to_owned(),
            ConstraintKind::JsonSchema => in_json(example.answer),
        };
        messages.push(Message::new(Role::Assistant, answer));
    }
    messages
}

fn query(menu: &Menu, instruction: &str) -> String {
    let plans = menu.plans.iter().map(|plan| {
        let lane = plan.lane.as_deref().filter(|_| !menu.lanes.is_empty());
        plan_line(&plan.name, &plain_line(&plan.summary), lane.unwrap_or(""))
    });
    let checks = menu.checks.iter().map(|check| {
        let conditions = check.conditions();
        // Conditions may be fewer than outcomes: the last one, the negated call, then stands for the rest.
        let cycle = conditions
            .iter()
            .map(String::as_str)
            .chain(conditions.last().map(String::as_str).into_iter().cycle());
        check_line(&check.script(), cycle.zip(check.says.iter().map(String::as_str)))
    });
    whole_query(plans.collect(), checks.collect(), &plain_line(instruction))
}

fn example_query(example: &CompositionExample) -> String {
    let plans = example
        .plans
        .iter()
        .map(|(name, summary, lane)| plan_line(name, summary, lane));
    let checks = example
        .checks
        .iter()
        .map(|(call, outcomes)| check_line(call, outcomes.iter().copied()));
    whole_query(plans.collect(), checks.collect(), example.wish)
}

fn plan_line(name: &str, summary: &str, lane: &str) -> String {
    let mut line = format!("- {name}()");
    if !summary.is_empty() {
        line.push_str(&format!(": {summary}"));
    }
    if !lane.is_empty() {
        line.push_str(&format!(" [{lane}]"));
    }
    line
}

fn check_line<'a>(call: &str, outcomes: impl Iterator<Item = (&'a str, &'a str)>) -> String {
    let outcomes: Vec<String> = outcomes
        .map(|(condition, says)| format!("{condition} if {says}"))
        .collect();
    format!("- {call}: {}", outcomes.join(", "))
}

fn whole_query(plans: Vec<String>, checks: Vec<String>, wish: &str) -> String {
    let mut text = format!("Plans:\n{}\n", plans.join("\n"));
    if !checks.is_empty() {
        text.push_str(&format!("Checks:\n{}\n", checks.join("\n")));
    }
    format!("{text}Wish: {wish}")
}
