//! Other readings of feedback whose change of the steps is not possible.
//!
//! "Close the fridge afterwards" names a step, and a state too. Before a wish is refused, its other readings are tried:
//! as another order of the steps, then as a goal beside those of the plan. Only a verified plan is proposed, and a
//! refusal lists what stands in the way of each reading.
//!
//! The order of the readings is from the narrowest to the widest. A wish that was read as a goal in the first place is
//! not read as a step after that: nearly every step verifies somewhere, so this would show nothing. Words with a call, or with
//! the number of a step that is to change, are about the steps, and are not read as a goal.

use std::time::Duration;

use super::pending::{Asking, What};
use super::{Event, Proposal, Refusal, Session, Stage, Turn};
use crate::clock::Clock;
use crate::feedback::{Amendment, FeedbackDialogue, StepWish, reordered};
use crate::report::{Answer, EditAnswer};

impl Session {
    /// Goes on from a refused change of the steps.
    pub(super) fn reread(
        &mut self,
        mut turn: Turn,
        dialogue: &FeedbackDialogue,
        words: String,
        wishes: &[StepWish],
        why: Vec<Refusal>,
    ) {
        let Some(proposal) = turn.proposal.as_deref() else {
            return self.stage = Stage::Idle;
        };
        let started = self.clock.now();
        let (plan, purpose) = (proposal.plan.plan(), &proposal.purpose);
        let amendment = reordered(&self.world, plan, wishes, purpose);
        if let Some(amendment) = amendment {
            return self.propose_amended(turn, amendment, started);
        }
        let may_be_goal = proposal.goal.is_some() && dialogue.may_be_goal(wishes);
        let round = self.goal_round(&turn, words);
        turn.rounds.push(round);
        turn.rereading = Some(why);
        if may_be_goal {
            self.stage = Stage::Asking(turn, Asking::new(What::Meaning(None)));
        } else {
            let why = turn.end_rereading().unwrap_or_default();
            self.refuse(turn, why);
        }
    }

    /// Refuses feedback whose reading as a further goal failed, too.
    pub(super) fn end_rereading(&mut self, mut turn: Turn, why: Refusal) {
        let mut all = turn.end_rereading().unwrap_or_default();
        all.push(why);
        self.refuse(turn, all);
    }

    /// Keeps the proposed plan and records why the feedback is refused.
    pub(super) fn refuse(&mut self, mut turn: Turn, why: Vec<Refusal>) {
        turn.end_rereading();
        let sentences = why.iter().map(Refusal::to_string).collect();
        self.events.push(Event::Refused { why: sentences });
        if let Some(proposal) = &mut turn.proposal {
            proposal.refused = why;
        }
        self.stage = Stage::Proposed(turn);
    }

    /// Takes over the refusal of a log whose program knew one reading only.
    pub(super) fn refuse_as_recorded(&mut self, why: &[String]) {
        if let Stage::Asking(turn, _) = &self.stage
            && turn.rereading.is_some()
        {
            let why = why.iter().cloned().map(Refusal::Recorded).collect();
            self.refuse(turn.clone(), why);
        }
    }

    /// Proposes a changed plan; the change began to be looked for at this time.
    pub(super) fn propose_amended(&mut self, turn: Turn, amendment: Amendment, started: Duration) {
        let Some(proposal) = turn.proposal.as_deref() else {
            return self.stage = Stage::Idle;
        };
        let (purpose, goal) = (proposal.purpose.clone(), proposal.goal.clone());
        let question = proposal.question.clone();
        let before = &proposal.answer;
        let (coverage, not_represented) = (before.coverage.clone(), before.not_represented.clone());
        let world = &self.world;
        let report = amendment.plan.report();
        let mut answer = Answer::of_report(world, report, goal.as_ref(), &turn.instruction);
        answer.edits = amendment.edits.iter().map(EditAnswer::from).collect();
        answer.timings_ms.search = Clock::milliseconds(started, self.clock.now());
        (answer.coverage, answer.not_represented) = (coverage, not_represented);
        turn.price(&mut answer);
        let proposal = Proposal {
            plan: amendment.plan,
            purpose,
            goal,
            answer,
            refused: Vec::new(),
            question,
        };
        self.propose(turn, proposal);
    }
}

impl Turn {
    /// Stops reading the feedback as a further goal, and returns what stood in the way of its first reading.
    pub(super) fn end_rereading(&mut self) -> Option<Vec<Refusal>> {
        let why = self.rereading.take()?;
        self.rounds.pop();
        Some(why)
    }
}
