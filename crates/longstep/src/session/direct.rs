//! The direct strategy: the model writes the whole plan and the final environment.

use super::pending::{Asking, What};
use super::{Accepted, Event, Failure, Proposal, RepairPolicy, Session, Stage, Turn};
use crate::clock::Clock;
use crate::dialogue::{
    DialogueError, Exchange, Prepared, PromptError, Reply, Round, TokenCounter, answered, direct_request, query, whole,
};
use crate::feedback;
use crate::model::Domain;
use crate::plan;
use crate::repair::RepairOutcome;
use crate::report::{Assessment, Status};
use crate::verify::VerifiedPlan;

/// Returns a round with feedback. Its reply is the proposed plan after repair, since the feedback refers to that plan.
pub(super) fn round(domain: &Domain, proposal: &Proposal, words: &str) -> Round {
    Round {
        reply: answered(domain, &proposal.answer.plan),
        message: words.to_owned(),
    }
}

impl Session {
    /// Returns the request for a plan.
    pub(super) fn plan_request(&self, turn: &Turn, counter: &mut dyn TokenCounter) -> Result<Prepared, PromptError> {
        let skipped = self.accepted.len().saturating_sub(self.settings.history);
        let history: Vec<Exchange> = (skipped..self.accepted.len())
            .filter_map(|number| self.exchange(number))
            .collect();
        let rounds = &turn.rounds;
        direct_request(
            &self.domain,
            &self.world,
            &turn.instruction,
            &history,
            rounds,
            self.model.context,
            counter,
        )
    }

    /// Returns an earlier instruction as an exchange whose reply is the accepted plan.
    fn exchange(&self, number: usize) -> Option<Exchange> {
        let Accepted {
            instruction, before, ..
        } = self.accepted.get(number)?;
        Some(Exchange {
            message: query(&self.domain, before, instruction).ok()?,
            reply: answered(&self.domain, &self.plan_file(number)?),
        })
    }

    pub(super) fn plan_reply(&mut self, turn: Turn, reply: &Reply) {
        if let Err(error) = whole(reply) {
            return self.give_up(turn, Failure::Reply(error));
        }
        let draft = match plan::read(&reply.text) {
            Ok(draft) => draft,
            Err(error) => {
                let failure = Failure::Reply(DialogueError::Unreadable(error.to_string()));
                let correction = format!(
                    "{error}. {} Answer with the whole plan, in the format above.",
                    error.hint()
                );
                return self.correct(turn, reply, correction, failure);
            }
        };
        let assessment = Assessment::new(&self.world, draft, Some(&turn.instruction));
        if let Some(question) = assessment.question() {
            let question = question.to_owned();
            return self.ask_person(turn, reply.text.clone(), question);
        }
        let last = turn.corrections >= self.settings.rounds;
        let mend = match self.settings.repair {
            RepairPolicy::First => true,
            RepairPolicy::AfterFeedback => last,
            RepairPolicy::Never => false,
        };
        match self.check(&turn, assessment, mend) {
            Checked::Plan(proposal) => self.propose(turn, *proposal),
            Checked::AsBefore => {
                let correction = "This is the same plan as before. Answer with the whole plan, changed as I said.";
                self.correct(turn, reply, correction.to_owned(), Failure::SamePlan);
            }
            Checked::Wrong { correction, failure } => self.correct(turn, reply, correction, failure),
        }
    }

    /// Assesses a plan of the model.
    fn check(&self, turn: &Turn, assessment: Assessment<'_>, mend: bool) -> Checked {
        let started = self.clock.now();
        // Repair must keep the changes that the person requested.
        let pins = turn
            .proposal
            .as_ref()
            .map(|proposal| feedback::pins(proposal.plan.plan(), &assessment.resolved))
            .unwrap_or_default();
        let assessment = assessment.pinned(pins);
        let outcome = mend.then(|| assessment.repair());
        let searched = self.clock.now();
        let plan: Option<VerifiedPlan> = match outcome {
            Some(RepairOutcome::Valid(plan)) => Some(plan.clone()),
            // A repair that gives up claims would undo the feedback.
            Some(RepairOutcome::Repaired(repaired)) if turn.proposal.is_some() && !repaired.given_up.is_empty() => None,
            Some(RepairOutcome::Repaired(repaired)) => Some(repaired.plan.clone()),
            Some(_) => None,
            None => assessment.verified(),
        };
        let mut answer = match outcome {
            Some(_) if plan.is_some() => assessment.repaired(),
            _ => assessment.verdict(),
        };
        turn.price(&mut answer);
        answer.plan.instruction_summary.clone_from(&turn.instruction);
        if mend {
            answer.timings_ms.search = Clock::milliseconds(started, searched);
        }
        answer.timings_ms.verify = Clock::milliseconds(searched, self.clock.now());
        match plan {
            // The person asked for a different plan.
            Some(plan) if turn.is_as_before(&plan) => Checked::AsBefore,
            Some(plan) => Checked::Plan(Box::new(Proposal {
                plan,
                purpose: assessment.purpose,
                goal: None,
                answer,
                refused: Vec::new(),
                question: None,
            })),
            None => {
                Checked::Wrong {
                    // Feedback is needed only if another round follows.
                    correction: if turn.corrections >= self.settings.rounds {
                        String::new()
                    } else {
                        assessment.feedback()
                    },
                    failure: Failure::NoPlan(Box::new(answer)),
                }
            }
        }
    }

    /// Sends a correction to the model. After the last round, the instruction fails instead.
    fn correct(&mut self, mut turn: Turn, reply: &Reply, correction: String, failure: Failure) {
        if turn.corrections >= self.settings.rounds {
            return self.give_up(turn, failure);
        }
        if let Some(answer) = failure.answer() {
            self.verdict(answer);
        }
        self.events.push(Event::Correction {
            text: correction.clone(),
        });
        turn.corrections += 1;
        turn.uncorrected = Some(Box::new(failure));
        turn.rounds.push(Round {
            reply: reply.text.clone(),
            message: correction,
        });
        self.stage = Stage::Asking(turn, Asking::new(What::Plan));
    }

    /// Returns the last reply of a failed instruction, for the next round.
    pub(super) fn reply_of(&self, failure: &Failure) -> String {
        match failure.answer() {
            Some(answer) if answer.status != Status::Question && !answer.goal.is_empty() => answer.goal.join(" & "),
            Some(answer) => answered(&self.domain, &answer.plan),
            None => String::new(),
        }
    }
}

/// The result of the assessment of a model's plan.
enum Checked {
    /// A valid plan, perhaps after repair.
    Plan(Box<Proposal>),
    /// The plan equals the one that the feedback rejects.
    AsBefore,
    /// An invalid plan: feedback for the model, and the failure if no round follows.
    Wrong { correction: String, failure: Failure },
}

impl Turn {
    /// Returns true if the plan has the steps that the feedback rejects. Explanations count too, since feedback may
    /// concern them.
    fn is_as_before(&self, plan: &VerifiedPlan) -> bool {
        let before = self.proposal.as_ref();
        before.is_some_and(|proposal| proposal.plan.steps() == plan.steps())
    }
}
