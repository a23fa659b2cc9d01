//! A model is asked, and answers.

use super::{Event, OutOfTurn, Session, Stage, Stuck, Trouble, Turn, direct, goal};
use crate::dialogue::{DialogueError, Finish, Prepared, PromptError, Reply, TokenCounter};
use crate::feedback::{FeedbackDialogue, Wish};

use super::Strategy;
use goal::GoalAsking;

/// What the model is asked for.
#[derive(Debug, Clone)]
pub(super) struct Asking {
    pub(super) what: What,
    /// Whether the request is in the log.
    pub(super) told: bool,
}

#[derive(Debug, Clone)]
pub(super) enum What {
    /// A goal. The conversation begins when it is known how much fits.
    Goal(Option<Box<GoalAsking>>),
    /// A whole plan.
    Plan,
    /// What a person's words about a plan ask for.
    Wish(Box<FeedbackDialogue>, String),
}

impl Asking {
    pub(super) fn new(what: What) -> Self {
        Self { what, told: false }
    }
}

impl Session {
    /// Asks the way that the settings say.
    pub(super) fn ask(&self) -> Asking {
        Asking::new(match self.settings.strategy {
            Strategy::Goal => What::Goal(None),
            Strategy::Direct => What::Plan,
        })
    }

    /// Asks about a person's words on the plan of the turn, and has the conversation go on with them.
    pub(super) fn ask_about(&self, turn: &mut Turn, words: &str) -> Asking {
        let Some(proposal) = &turn.proposal else {
            return self.ask();
        };
        // Words about single steps are understood of a list of them; of a tree, what is wanted is talked about.
        let is_sequence = proposal.plan.plan().is_sequence();
        match self.settings.strategy {
            Strategy::Goal if !is_sequence && proposal.goal.is_some() => {
                let round = self.goal_round(turn, words.to_owned());
                turn.rounds.push(round);
                Asking::new(What::Goal(None))
            }
            Strategy::Goal if is_sequence => {
                let (domain, world) = (&self.domain, &self.world);
                let plan = proposal.plan.plan();
                let dialogue = FeedbackDialogue::new(domain, world, plan, &turn.instruction, words, self.model.kind);
                Asking::new(What::Wish(Box::new(dialogue), words.to_owned()))
            }
            Strategy::Goal | Strategy::Direct => {
                let round = direct::round(&self.domain, proposal, words);
                turn.rounds.push(round);
                Asking::new(What::Plan)
            }
        }
    }

    /// What to send to the model now.
    pub(super) fn request(
        &mut self,
        turn: Turn,
        mut asking: Asking,
        counter: &mut dyn TokenCounter,
    ) -> Result<Box<Prepared>, PromptError> {
        let prepared = match &mut asking.what {
            What::Goal(goal) => self.goal_request(&turn, goal, counter),
            What::Plan => self.plan_request(&turn, counter),
            What::Wish(dialogue, _) => Ok(Prepared {
                request: dialogue.request(&self.domain, &self.world),
                costs: Vec::new(),
                dropped: 0,
                left_out: 0,
            }),
        };
        match prepared {
            Ok(prepared) => {
                if !asking.told {
                    self.tell_request(&prepared);
                    asking.told = true;
                }
                self.stage = Stage::Asking(turn, asking);
                Ok(Box::new(prepared))
            }
            Err(error) => {
                let stuck = Stuck {
                    why: error.to_string(),
                    answer: None,
                    trouble: Trouble::Limit,
                };
                self.give_up(turn, stuck);
                Err(error)
            }
        }
    }

    fn tell_request(&mut self, prepared: &Prepared) {
        let request = &prepared.request;
        let (fixed, rest) = request.messages.split_at(request.fixed.min(request.messages.len()));
        let known = self.prompts.iter().position(|prompt| prompt == fixed);
        let prompt = known.unwrap_or_else(|| {
            let number = self.prompts.len();
            self.prompts.push(fixed.to_vec());
            self.events.push(Event::Prompt {
                number,
                messages: fixed.iter().map(Into::into).collect(),
            });
            number
        });
        self.events.push(Event::Request {
            prompt,
            messages: rest.iter().map(Into::into).collect(),
            answer_so_far: request.answer_so_far.clone(),
            max_tokens: request.max_tokens,
            dropped: prepared.dropped,
            left_out: prepared.left_out,
        });
    }

    /// Takes a model's reply, which took so many milliseconds.
    ///
    /// # Errors
    ///
    /// When no model was asked.
    pub fn supply(&mut self, reply: &Reply, milliseconds: f64) -> Result<(), OutOfTurn> {
        let stage = std::mem::replace(&mut self.stage, Stage::Idle);
        let Stage::Asking(mut turn, asking) = stage else {
            self.stage = stage;
            return Err(self.out_of_turn("a reply"));
        };
        turn.usage += reply.usage;
        turn.model_milliseconds += milliseconds;
        self.events.push(Event::reply(reply, milliseconds));
        match asking.what {
            What::Goal(goal) => self.goal_reply(turn, goal, reply),
            What::Plan => self.plan_reply(turn, reply),
            What::Wish(mut dialogue, words) => match dialogue.supply(&self.domain, &self.world, reply) {
                Ok(Wish::Goal) => self.ask_for_another_goal(turn, words),
                Ok(Wish::Steps(wishes)) => self.amend(turn, &wishes),
                Ok(Wish::Question(question)) => self.ask_person(turn, question.clone(), question),
                Err(error) => self.give_up(turn, unusable(&error)),
            },
        }
        Ok(())
    }

    /// The model was asked and did not answer: the plan that the words were about is there again, or the
    /// instruction is stuck.
    ///
    /// # Errors
    ///
    /// When no model was asked.
    pub fn failed(&mut self, error: &str) -> Result<(), OutOfTurn> {
        let stage = std::mem::replace(&mut self.stage, Stage::Idle);
        let Stage::Asking(turn, _) = stage else {
            self.stage = stage;
            return Err(self.out_of_turn("a failure"));
        };
        self.events.push(Event::Failed {
            error: error.to_owned(),
        });
        let stuck = Stuck {
            why: error.to_owned(),
            answer: None,
            trouble: Trouble::Model,
        };
        self.give_up(turn, stuck);
        Ok(())
    }
}

/// A reply that cannot be used.
pub(super) fn unusable(error: &DialogueError) -> Stuck {
    Stuck {
        why: error.to_string(),
        answer: None,
        trouble: match error {
            DialogueError::CutOff(_) => Trouble::Limit,
            _ => Trouble::Model,
        },
    }
}

impl Event {
    fn reply(reply: &Reply, milliseconds: f64) -> Self {
        let finish = match reply.finish {
            Finish::Stop => "stop",
            Finish::Length => "length",
            Finish::Refused => "refused",
        };
        Self::Reply {
            text: reply.text.clone(),
            finish: finish.to_owned(),
            usage: reply.usage.into(),
            milliseconds,
        }
    }

    /// The reply of an event, if it is one.
    pub(super) fn as_reply(&self) -> Option<(Reply, f64)> {
        let Self::Reply {
            text,
            finish,
            usage,
            milliseconds,
        } = self
        else {
            return None;
        };
        let finish = match finish.as_str() {
            "length" => Finish::Length,
            "refused" => Finish::Refused,
            _ => Finish::Stop,
        };
        let reply = Reply {
            text: text.clone(),
            finish,
            usage: (*usage).into(),
        };
        Some((reply, *milliseconds))
    }
}
