//! Model requests and replies.

use super::pending::{Asking, What};
use super::{Event, Failure, OutOfTurn, Refusal, Session, Stage, Strategy, Turn, direct};
use crate::dialogue::{Dialogue, DialogueError, Finish, Prepared, PromptError, Reply, TokenCounter};
use crate::feedback::{FeedbackDialogue, FeedbackInput, Wish};

impl Session {
    /// Creates a request according to the strategy.
    pub(super) fn ask(&self) -> Asking {
        Asking::new(match self.settings.strategy {
            Strategy::Goal => What::Meaning(None),
            Strategy::Direct => What::Plan,
        })
    }

    /// Creates a request for feedback on the turn's plan, and adds the feedback to the rounds if needed.
    pub(super) fn ask_about(&self, turn: &mut Turn, words: &str) -> Asking {
        let Some(proposal) = &turn.proposal else {
            return self.ask();
        };
        // Step wishes need a linear plan; for a tree, feedback concerns the goal or the whole plan.
        let is_sequence = proposal.plan.plan().is_sequence();
        match self.settings.strategy {
            Strategy::Goal if !is_sequence && proposal.goal.is_some() => {
                let round = self.goal_round(turn, words.to_owned());
                turn.rounds.push(round);
                Asking::new(What::Meaning(None))
            }
            Strategy::Goal if is_sequence => {
                let dialogue = FeedbackDialogue::new(FeedbackInput {
                    domain: &self.domain,
                    world: &self.world,
                    plan: proposal.plan.plan(),
                    instruction: &turn.instruction,
                    feedback: words,
                    kind: self.model.kind,
                });
                Asking::new(What::Wish(Box::new(dialogue), words.to_owned()))
            }
            Strategy::Goal | Strategy::Direct => {
                let round = direct::round(&self.domain, proposal, words);
                turn.rounds.push(round);
                Asking::new(What::Plan)
            }
        }
    }

    /// Returns the request to the model, and records it once; none if the person is asked instead.
    pub(super) fn request(
        &mut self,
        mut turn: Turn,
        mut asking: Asking,
        counter: &mut dyn TokenCounter,
    ) -> Result<Option<Box<Prepared>>, PromptError> {
        let prepared = match &mut asking.what {
            What::Meaning(begun) => self.meaning_request(&turn, begun, counter),
            What::Plan => self.plan_request(&turn, counter),
            What::Wish(dialogue, _) => Ok(Prepared {
                request: dialogue.request(),
                costs: Vec::new(),
                dropped: 0,
                left_out: 0,
                forecast: None,
            }),
        };
        match prepared {
            Ok(prepared) => {
                if !asking.logged {
                    self.tell_request(&prepared);
                    asking.logged = true;
                }
                self.stage = Stage::Asking(turn, asking);
                Ok(Some(Box::new(prepared)))
            }
            // A correction that does not fit: the first plan's own faults say more than the size of the prompt.
            Err(PromptError::OverBudget(_)) if turn.uncorrected.is_some() => {
                let failure = turn.uncorrected.take();
                if let Some(failure) = failure {
                    self.give_up(turn, *failure);
                }
                Ok(None)
            }
            Err(error) => {
                self.give_up(turn, Failure::Prompt(error.clone()));
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

    /// Processes a model's reply; `milliseconds` is its duration. The search for a plan takes place here, within the limits
    /// of the planner. See the [example](Self#example).
    ///
    /// # Errors
    ///
    /// No model request is pending.
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
            What::Meaning(begun) => self.meaning_reply(turn, begun, reply),
            What::Plan => self.plan_reply(turn, reply),
            What::Wish(mut dialogue, words) => match dialogue.supply(reply) {
                Ok(None) => self.stage = Stage::Asking(turn, Asking::new(What::Wish(dialogue, words))),
                Ok(Some(Wish::Goal | Wish::Further)) => self.ask_for_another_goal(turn, words),
                Ok(Some(Wish::Steps(wishes))) => self.amend(turn, &dialogue, words, &wishes),
                Ok(Some(Wish::Question(question))) => self.ask_person(turn, question.clone(), question),
                Err(error @ DialogueError::NoWish(_)) => {
                    let why = vec![Refusal::Failure(Failure::Reply(error))];
                    self.reread(turn, &dialogue, words, &[], why);
                }
                Err(error) => self.give_up(turn, Failure::Reply(error)),
            },
        }
        Ok(())
    }

    /// Records a failed model call. The plan under discussion is proposed again, or the instruction is stuck. See the
    /// example of [`Session::failure`].
    ///
    /// # Errors
    ///
    /// No model request is pending.
    pub fn failed(&mut self, error: &str) -> Result<(), OutOfTurn> {
        let stage = std::mem::replace(&mut self.stage, Stage::Idle);
        let Stage::Asking(turn, _) = stage else {
            self.stage = stage;
            return Err(self.out_of_turn("a failure"));
        };
        self.events.push(Event::Failed {
            error: error.to_owned(),
        });
        self.give_up(turn, Failure::Model(error.to_owned()));
        Ok(())
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
            likelihood: reply.likelihood,
            milliseconds,
        }
    }

    /// Returns the reply of an event, if it is one.
    pub(super) fn as_reply(&self) -> Option<(Reply, f64)> {
        let Self::Reply {
            text,
            finish,
            usage,
            likelihood,
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
            likelihood: *likelihood,
        };
        Some((reply, *milliseconds))
    }
}
