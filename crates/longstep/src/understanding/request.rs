//! The request: messages that are the same for every model.

use super::answer::{self, Answer};
use super::left_out::LeftOutKind;
use crate::dialogue::{
    ChatRequest, ConstraintKind, Dialogue, DialogueError, Message, Reply, Role, Task, Transcript, fixed_turns, plain_line, scene,
    scene_and_instruction,
};
use crate::environment::World;
use crate::goal::{Mentions, offers};
use crate::model::{Condition, Domain, PredicateId};

/// Returns the goal language beyond plain goals, at the end of the system text. The adapter has learned these bytes.
fn language(domain: &Domain) -> String {
    let mut text = String::from(
        "\n\nBeyond plain goals:\n\
        - A then B: first A, then B\n\
        - never GOAL: this must not come about on the way; always GOAL: this holds and must go on holding; untouched(THING): leave it alone; _ in it is anything\n",
    );
    let states = other_states(domain);
    if !states.is_empty() {
        text.push_str(&format!("- behind never and always also: {}\n", states.join(", ")));
    }
    text.push_str(
        "- never GOAL until GOAL: only until then\n\
        - instead of a name: all KIND, all KIND where STATE or STATE, all KIND except NAME, any KIND, any of (NAME, NAME), 2 of KIND, all but 1 of KIND\n\
        - instead of an amount: now + 2, now * 2\n\
        - if CONDITION then GOAL else GOAL",
    );
    let conditions = conditions(domain);
    let listed = |form: &String| domain.prompts.goal.contains(form);
    if !conditions.is_empty() && !conditions.iter().all(listed) {
        text.push_str(&format!("; a CONDITION is one of: {}", conditions.join(", ")));
    }
    text.push_str("\n- left out KIND: the words that none of these can say, at the end, and their KIND: ");
    text.push_str(&LeftOutKind::ALL.map(LeftOutKind::word).join(", "));
    text
}

/// Returns the forms of what can be sensed.
fn conditions(domain: &Domain) -> Vec<String> {
    let sensed = domain.states.iter().filter(|word| domain.is_sensed(word.atom.predicate));
    sensed.map(|word| format!("{}(THING)", word.word)).collect()
}

/// Returns the forms of the facts that change and that no goal word is about: where the robot is, what it holds.
fn other_states(domain: &Domain) -> Vec<String> {
    let of_goals = |predicate: PredicateId| {
        let conditions = domain.goal_words.iter().map(|word| &word.condition);
        conditions.flat_map(Condition::atoms).any(|(atom, _)| atom.predicate == predicate)
    };
    let mut forms = Vec::new();
    for (index, predicate) in domain.predicates.iter().enumerate() {
        let id = PredicateId::new(index);
        let words = domain.words(id);
        if words.fluent && !words.event && !domain.is_sensed(id) && !of_goals(id) && !predicate.parameters.is_empty() {
            let kinds = predicate.parameters.iter().map(|parameter| parameter.name.to_uppercase());
            forms.push(format!("{}({})", predicate.name.replace('-', "_"), kinds.collect::<Vec<_>>().join(", ")));
        }
    }
    forms
}

/// The token budget of an answer.
const ANSWER_TOKENS: u32 = 384;

/// The inputs of a request.
#[derive(Debug, Clone, Copy)]
pub struct UnderstandingInput<'a> {
    /// The domain with its prompts.
    pub domain: &'a Domain,
    /// The world shown to the model.
    pub world: &'a World,
    /// The instruction of the person.
    pub instruction: &'a str,
    /// The number of worked examples; all if none.
    pub examples: Option<usize>,
    /// True if the model may ask.
    pub asks: bool,
}

/// The request for an instruction.
#[derive(Debug, Clone)]
pub struct UnderstandingDialogue {
    transcript: Transcript,
    world: World,
    instruction: String,
    asks: bool,
}

impl UnderstandingDialogue {
    /// Starts the request.
    pub fn new(input: UnderstandingInput<'_>) -> Self {
        let UnderstandingInput { domain, world, instruction, examples, asks } = input;
        let mut fixed = fixed_turns(domain, ConstraintKind::Grammar);
        fixed[0].text.push_str(&language(domain));
        if let Some(examples) = examples {
            fixed.truncate(1 + 2 * examples);
        }
        let mut transcript = Transcript::new(ConstraintKind::Grammar, fixed).for_task(Task::Goals);
        let scene = scene(world, &offers(world, &[], &Mentions::default()));
        let instruction = plain_line(instruction);
        transcript.push(Role::User, scene_and_instruction(&scene, &instruction));
        Self {
            transcript,
            world: world.clone(),
            instruction,
            asks,
        }
    }

    /// Returns the messages of the request.
    pub fn messages(&self) -> &[Message] {
        self.transcript.messages()
    }
}

impl Dialogue for UnderstandingDialogue {
    type Output = Answer;

    fn request(&self) -> ChatRequest {
        let form = answer::form(&self.world, &self.instruction, self.asks);
        self.transcript.under_grammar(form.grammar(), ANSWER_TOKENS)
    }

    fn supply(&mut self, reply: &Reply) -> Result<Option<Answer>, DialogueError> {
        self.transcript.receive(reply)?;
        answer::read(&self.world, self.transcript.answer()).map(Some)
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}
