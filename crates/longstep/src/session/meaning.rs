//! The goal strategy: the model says what is meant, and search finds the steps.

use super::pending::{Asking, What};
use super::{Event, Failure, Proposal, Refusal, Session, Stage, Turn};
use crate::coverage::{Coverage, LeftOut};
use crate::dialogue::{Dialogue, DialogueError, Prepared, PromptError, Reply, Round, TokenCounter, plain_line};
use crate::environment::World;
use crate::feedback::{Amended, FeedbackDialogue, StepWish, amend};
use crate::goal::{self, Goal};
use crate::instruction::{self, SpelledOut};
use crate::report::{self, Answer};
use crate::search::Limits;
use crate::understanding::{FittedUnderstanding, Interpretation, Understanding, UnderstandingInput};

impl Session {
    /// Returns the request for the meaning of what was said.
    pub(super) fn meaning_request(
        &mut self,
        turn: &Turn,
        begun: &mut Option<Box<FittedUnderstanding>>,
        counter: &mut dyn TokenCounter,
    ) -> Result<Prepared, PromptError> {
        let fitted = match begun {
            Some(fitted) => fitted,
            None => {
                let instruction = self.spelled_out(turn);
                let input = self.meaning_input(turn, &self.world, &instruction);
                let fitted = Understanding::fitted(input, self.model.context, counter)?;
                if fitted.is_narrowed {
                    let shown = fitted.dialogue.world().entities();
                    let kept = shown.map(|(_, entity)| entity.identifier.clone());
                    self.events.push(Event::Focus { kept: kept.collect() });
                }
                begun.insert(Box::new(fitted))
            }
        };
        Ok(Prepared {
            forecast: None,
            request: fitted.dialogue.request(),
            costs: fitted.costs.clone(),
            dropped: 0,
            left_out: fitted.left_out,
        })
    }

    fn meaning_input<'a>(&'a self, turn: &'a Turn, world: &'a World, instruction: &'a str) -> UnderstandingInput<'a> {
        UnderstandingInput {
            rounds: &turn.rounds,
            ..UnderstandingInput::new(&self.domain, world, instruction, self.model.kind)
        }
    }

    /// Returns the instruction with an open pronoun replaced by the entities of the last plan.
    fn spelled_out(&self, turn: &Turn) -> String {
        let spelled = self.pronoun(&turn.instruction);
        spelled.map_or_else(|| turn.instruction.clone(), |spelled| spelled.text)
    }

    fn pronoun(&self, instruction: &str) -> Option<SpelledOut> {
        let last = self.accepted.last()?;
        instruction::spelled_out(&self.world, instruction, &last.subjects(&self.domain))
    }

    /// Starts the request with these entities in the prompt, or with all.
    fn begun(&self, turn: &Turn, kept: Option<&[String]>) -> FittedUnderstanding {
        let world = &self.world;
        let part = kept.map(|kept| {
            let kept: Vec<_> = kept.iter().filter_map(|identifier| world.find(identifier)).collect();
            world.narrowed(&kept)
        });
        let shown = part.as_ref().unwrap_or(world);
        FittedUnderstanding {
            dialogue: Understanding::new(self.meaning_input(turn, shown, &self.spelled_out(turn))),
            is_narrowed: part.is_some(),
            left_out: 0,
            costs: Vec::new(),
        }
    }

    /// Starts the request with the entities that a log records.
    pub(super) fn focus(&mut self, kept: Option<Vec<String>>) {
        let Stage::Asking(turn, asking) = &self.stage else {
            return;
        };
        if let What::Meaning(None) = asking.what {
            let begun = self.begun(turn, kept.as_deref());
            self.stage = Stage::Asking(turn.clone(), Asking::new(What::Meaning(Some(Box::new(begun)))));
        }
    }

    pub(super) fn meaning_reply(&mut self, mut turn: Turn, begun: Option<Box<FittedUnderstanding>>, reply: &Reply) {
        let mut fitted = begun.unwrap_or_else(|| Box::new(self.begun(&turn, None)));
        match fitted.dialogue.supply(reply) {
            Ok(None) => self.stage = Stage::Asking(turn, Asking::new(What::Meaning(Some(fitted)))),
            Ok(Some(meant)) => {
                turn.readings.push(meant.reading.clone());
                self.world.share_values(fitted.dialogue.world());
                let carried = if fitted.is_narrowed {
                    meant.carried(&self.domain, fitted.dialogue.world(), &self.world)
                } else {
                    Some(meant)
                };
                match carried {
                    Some(meant) => self.meant(turn, meant),
                    // Each entity of the part exists in the whole world, but a group may have members there for which the
                    // goal makes no sense.
                    None => self.give_up(turn, Failure::Reply(DialogueError::Refused)),
                }
            }
            Err(error) => self.give_up(turn, Failure::Reply(error)),
        }
    }

    /// Goes on with what was meant: to a plan, or to a question.
    fn meant(&mut self, turn: Turn, meant: Interpretation) {
        let is_same = |goal: &Goal| {
            turn.proposal
                .as_ref()
                .is_some_and(|own| own.goal.as_ref() == Some(goal))
        };
        let refused = match (&meant.goal, &meant.question) {
            _ if turn.rereading.is_none() => None,
            (_, Some(question)) => Some(Refusal::OpenQuestion(question.clone())),
            (Some(goal), None) if is_same(goal) => Some(Refusal::NoFurtherGoal),
            _ => None,
        };
        match (refused, meant.goal.is_some()) {
            (Some(why), _) => self.end_rereading(turn, why),
            (None, true) => self.pursue(turn, meant),
            (None, false) => {
                let question = meant.question.unwrap_or_default();
                self.ask_back(turn, question);
            }
        }
    }

    /// Asks the person in place of a goal.
    fn ask_back(&mut self, turn: Turn, question: String) {
        self.ask_person(turn, format!("{}{question}", goal::QUESTION), question);
    }

    /// Plans for a goal.
    fn pursue(&mut self, turn: Turn, meant: Interpretation) {
        let world = &self.world;
        let goal = meant.goal.unwrap_or_default();
        let limits = self.settings.effort.map_or(self.limits, Limits::from);
        let solution = report::of_goal(world, &goal, &turn.instruction, &limits, &self.clock);
        let mut answer = solution.answer;
        if let Some(spelled) = self.pronoun(&turn.instruction) {
            let names = spelled.meant.iter().map(|id| world.with_article(*id));
            let names: Vec<String> = names.collect();
            let note = format!("\"{}\" was taken for {}", spelled.pronoun, names.join(" and "));
            answer.assumptions.push(note);
        }
        let said = turn.said(&meant.left_out);
        let coverage = Coverage::new(world, &said, &goal, &meant.left_out, turn.rounds.is_empty());
        answer.set_coverage(&goal, &coverage);
        turn.price(&mut answer);
        let Some(plan) = solution.plan else {
            return match meant.question {
                // What is not sure to be meant is asked about before it is said to be impossible.
                Some(question) => self.ask_back(turn, question),
                None => self.give_up(turn, Failure::NoPlan(Box::new(answer))),
            };
        };
        let left_out = if goal.facts.is_empty() {
            Some(rule_question(world, &goal))
        } else {
            coverage.question()
        };
        let question = meant.question.or(left_out.filter(|_| !self.settings.partial));
        let proposal = Proposal {
            plan,
            purpose: goal.purpose(world),
            goal: Some(goal),
            answer,
            refused: Vec::new(),
            question,
        };
        self.propose(turn, proposal);
    }

    /// Returns a round with the goal of the proposal and the feedback on it.
    pub(super) fn goal_round(&self, turn: &Turn, words: String) -> Round {
        let goals = turn.proposal.iter().flat_map(|proposal| &proposal.goal);
        Round {
            reply: goals.map(|goal| goal.text(&self.world)).collect(),
            message: words,
        }
    }

    /// Goes on from the goal with what is said about it.
    pub(super) fn ask_for_another_goal(&mut self, mut turn: Turn, words: String) {
        let round = self.goal_round(&turn, words);
        turn.rounds.push(round);
        self.stage = Stage::Asking(turn, Asking::new(What::Meaning(None)));
    }

    /// Applies feedback that concerns the steps, or goes on to its other readings.
    pub(super) fn amend(&mut self, turn: Turn, dialogue: &FeedbackDialogue, words: String, wishes: &[StepWish]) {
        let Some(proposal) = turn.proposal.as_deref() else {
            return self.stage = Stage::Idle;
        };
        let world = &self.world;
        let started = self.clock.now();
        match amend(world, proposal.plan.plan(), wishes, &proposal.purpose) {
            Amended::Done(amendment) => self.propose_amended(turn, *amendment, started),
            Amended::Impossible { why, .. } => {
                let why = why.into_iter().map(Refusal::Change).collect();
                self.reread(turn, dialogue, words, wishes, why);
            }
        }
    }
}

/// Returns the question for a goal that only forbids something.
fn rule_question(world: &World, goal: &Goal) -> String {
    let rules: Vec<String> = goal.everyday(world).iter().map(|rule| format!("`{rule}`")).collect();
    format!(
        "There is nothing to do. Should {} hold from now on?",
        rules.join(" and ")
    )
}

impl Turn {
    /// Returns the instruction as one line, which the parts that the goal does not say refer to; and what the person said after
    /// it if they are in that.
    fn said(&self, left_out: &[LeftOut]) -> String {
        let mut said = plain_line(&self.instruction);
        for round in &self.rounds {
            let words = plain_line(&round.message);
            let is_there = |own: &LeftOut| {
                let text = own.text.trim();
                !text.is_empty() && words.contains(text) && !said.contains(text)
            };
            if left_out.iter().any(is_there) {
                said = format!("{said} / {words}");
            }
        }
        said
    }

    /// Adds the readings, the token counts and the model time of the instruction to an answer.
    pub(super) fn price(&self, answer: &mut Answer) {
        answer.readings.clone_from(&self.readings);
        answer.usage = self.usage.into();
        answer.usage.rounds = self.corrections;
        answer.timings_ms.model = self.model_milliseconds;
    }
}
