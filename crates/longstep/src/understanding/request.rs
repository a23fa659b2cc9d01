//! The request: messages that are the same for every model.

use super::answer::{self, Answer};
use crate::dialogue::{
    ChatRequest, ConstraintKind, Dialogue, DialogueError, Reply, Role, Task, Transcript, fixed_turns, plain_line, scene,
    scene_and_instruction,
};
use crate::environment::World;
use crate::goal::{Mentions, offers};
use crate::model::Domain;

/// The goal language beyond plain goals, at the end of the system text. The adapter has learned these bytes.
const LANGUAGE: &str = "\n\nBeyond plain goals:\n\
    - A then B: first A, then B\n\
    - never GOAL: this must not come about on the way; always GOAL: this holds and must go on holding; untouched(THING): leave it alone\n\
    - instead of a name: all KIND, all KIND where STATE, all KIND except NAME, any KIND, 2 of KIND\n\
    - if CONDITION then GOAL else GOAL\n\
    - left out: the words that none of these can say, at the end";

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
        fixed[0].text.push_str(LANGUAGE);
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
