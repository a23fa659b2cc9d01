//! The goal strategy: the model writes goals, and search finds the steps.

use super::forbidden::Parted;
use super::pending::{Asking, What};
use super::retold::Open;
use super::{Event, Failure, Proposal, Refusal, Session, Stage, Turn};
use crate::coverage::{self, Coverage, Gap};
use crate::dialogue::{
    ChatRequest, ConstraintKind, Dialogue, DialogueError, Doubt, FittedDialogue, GoalDialogue, GoalInput, OverBudget,
    Prepared, PromptError, Reading, ReadingOf, Reply, Round, TokenCounter, plain_line,
};
use crate::environment::World;
use crate::feedback::{Amended, FeedbackDialogue, StepWish, amend};
use crate::goal::{self, Goal, GoalFact, SpelledOut, Understanding};
use crate::report;
use crate::report::Answer;
use crate::search::Limits;
use crate::verify::VerifiedPlan;

impl Session {
    /// Returns the request for goals.
    pub(super) fn goal_request(
        &mut self,
        turn: &Turn,
        goal: &mut Option<Box<FittedDialogue>>,
        counter: &mut dyn TokenCounter,
    ) -> Result<Prepared, PromptError> {
        let fitted = match goal {
            Some(fitted) => fitted,
            None => {
                let instruction = self.spelled_out(turn);
                let input = self.goal_input(turn, &self.world, &instruction);
                let mut fitted = GoalDialogue::fitted(input, self.model.context, counter)?;
                if fitted.is_narrowed {
                    let kept = fitted
                        .dialogue
                        .world()
                        .entities()
                        .map(|(_, entity)| entity.identifier.clone());
                    self.events.push(Event::Focus { kept: kept.collect() });
                }
                if let (Some(_), Some(round)) = (&turn.rereading, turn.rounds.last()) {
                    fitted.dialogue.further(round);
                }
                goal.insert(Box::new(fitted))
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

    /// Returns a request of its own, whose prompt has no part that may be left out.
    pub(super) fn short_request(
        &self,
        request: ChatRequest,
        counter: &mut dyn TokenCounter,
    ) -> Result<Prepared, PromptError> {
        if let Some(context) = self.model.context {
            let messages = request.messages.iter().map(|message| counter.message_tokens(message));
            let needed = messages.sum::<u64>() + counter.frame_tokens();
            let room = context.saturating_sub(request.max_tokens.into());
            if needed > room {
                return Err(OverBudget { needed, room }.into());
            }
        }
        Ok(Prepared {
            forecast: None,
            request,
            costs: Vec::new(),
            dropped: 0,
            left_out: 0,
        })
    }

    pub(super) fn goal_input<'a>(&'a self, turn: &'a Turn, world: &'a World, instruction: &'a str) -> GoalInput<'a> {
        GoalInput {
            domain: &self.domain,
            world,
            instruction,
            // What was said about the wish is not said about a forbidden act.
            rounds: if turn.is_forbidding() { &[] } else { &turn.rounds },
            condition: turn.condition(),
            kind: self.model.kind,
        }
    }

    /// Returns the text that asks for goals, with an open pronoun replaced by the entities of the last plan; or the
    /// forbidden act that is being read.
    fn spelled_out(&self, turn: &Turn) -> String {
        if let Some(act) = turn.parted.as_ref().and_then(Parted::act) {
            return act.to_owned();
        }
        let wish = self.wish(turn).unwrap_or_else(|| turn.words().to_owned());
        let spelled = self.pronoun(&wish);
        spelled.map_or(wish, |spelled| spelled.text)
    }

    fn pronoun(&self, instruction: &str) -> Option<SpelledOut> {
        let last = self.accepted.last()?;
        goal::spelled_out(&self.world, instruction, &last.subjects(&self.domain))
    }

    /// Starts the dialogue with these entities in the prompt, or with all.
    pub(super) fn goal_dialogue(&self, turn: &Turn, kept: Option<&[String]>) -> FittedDialogue {
        let world = &self.world;
        let part = kept.map(|kept| {
            let kept: Vec<_> = kept.iter().filter_map(|identifier| world.find(identifier)).collect();
            world.narrowed(&kept)
        });
        let shown = part.as_ref().unwrap_or(world);
        let mut dialogue = GoalDialogue::new(self.goal_input(turn, shown, &self.spelled_out(turn)));
        if let (Some(_), Some(round)) = (&turn.rereading, turn.rounds.last()) {
            dialogue.further(round);
        }
        FittedDialogue {
            dialogue,
            is_narrowed: part.is_some(),
            left_out: 0,
            costs: Vec::new(),
        }
    }

    /// Starts the dialogue with the entities that a log records.
    pub(super) fn focus(&mut self, kept: Option<Vec<String>>) {
        let Stage::Asking(turn, asking) = &self.stage else {
            return;
        };
        if let What::Goal(None) = asking.what {
            let begun = self.goal_dialogue(turn, kept.as_deref());
            self.stage = Stage::Asking(turn.clone(), Asking::new(What::Goal(Some(Box::new(begun)))));
        }
    }

    pub(super) fn goal_reply(&mut self, mut turn: Turn, goal: Option<Box<FittedDialogue>>, reply: &Reply) {
        let mut fitted = goal.unwrap_or_else(|| Box::new(self.goal_dialogue(&turn, None)));
        match fitted.dialogue.supply(reply) {
            Ok(None) => {
                self.stage = Stage::Asking(turn, Asking::new(What::Goal(Some(fitted))));
            }
            Ok(Some(understood)) => {
                let of = match turn.is_forbidding() {
                    true => ReadingOf::Prohibition,
                    false => ReadingOf::Wish,
                };
                let words = plain_line(&self.spelled_out(&turn));
                turn.readings.push(fitted.dialogue.reading(of, &words));
                self.world.share_values(fitted.dialogue.world());
                let of_server = self.model.kind == ConstraintKind::JsonSchema;
                if of_server {
                    turn.marks = fitted.dialogue.marks(&turn.text());
                }
                let carried = match fitted.is_narrowed {
                    true => understood.carried(&self.domain, fitted.dialogue.world(), &self.world),
                    false => Some(understood),
                };
                match carried {
                    understood if turn.is_forbidding() => self.forbid(turn, understood),
                    // A server writes what is forbidden as a constraint.
                    Some(understood) if !of_server && self.wish(&turn).is_none() => {
                        self.offer_rule(turn, &understood);
                    }
                    Some(Understanding::Goal(_)) if self.is_shaky(&turn) => self.weigh(turn),
                    Some(Understanding::Goal(goal)) if turn.accepts_as_goal(&goal) => {
                        self.pursue_within(turn, goal);
                    }
                    Some(Understanding::Goal(_)) => self.end_rereading(turn, Refusal::NoFurtherGoal),
                    Some(Understanding::Question(question) | Understanding::Which(question))
                        if turn.rereading.is_some() =>
                    {
                        self.end_rereading(turn, Refusal::OpenQuestion(question));
                    }
                    Some(Understanding::Question(question)) => {
                        self.leave_open(turn, Open::Question(question));
                    }
                    Some(Understanding::Doubtful(goal)) => self.leave_open(turn, Open::Doubtful(goal)),
                    Some(Understanding::Which(question)) => self.leave_open(turn, Open::Which(question)),
                    // Each entity of the part exists in the whole world, but a group may have members there for which the
                    // goal makes no sense.
                    None => self.give_up(turn, Failure::Reply(DialogueError::Refused)),
                }
            }
            Err(_) if turn.is_forbidding() => self.forbid(turn, None),
            Err(error) => self.leave_open(turn, Open::Failure(Failure::Reply(error))),
        }
    }

    /// Plans for a goal.
    pub(super) fn pursue(&mut self, mut turn: Turn, mut goal: Goal) {
        let world = &self.world;
        let limits = self.settings.effort.map_or(self.limits, Limits::from);
        let instruction = &turn.instruction;
        let mut solution = report::of_goal(world, &goal, instruction, &limits, self.now);
        if let (Some(staged), Some(_)) = (turn.staged(&goal), &solution.plan) {
            let ordered = report::of_goal(world, &staged, instruction, &limits, self.now);
            if ordered.plan.is_some() {
                (goal, solution) = (staged, ordered);
            }
        }
        let mut answer = solution.answer;
        answer.assumptions.extend(turn.retelling_note());
        if let Some(spelled) = self.pronoun(turn.words()) {
            let names = spelled.meant.iter().map(|id| world.with_article(*id));
            let names: Vec<String> = names.collect();
            let note = format!("\"{}\" was taken for {}", spelled.pronoun, names.join(" and "));
            answer.assumptions.push(note);
        }
        if turn.is_reread && turn.rounds.is_empty() {
            let note = "the words do not name what the goal is about, and no other meaning was found";
            answer.assumptions.push(note.to_owned());
        }
        let forgets = turn.forgets(world, &goal);
        let coverage = turn.coverage(world, &goal, solution.plan.as_ref());
        answer.set_coverage(&goal, &coverage);
        let question = match goal.facts.is_empty() {
            true => Some(rule_question(world, &goal)),
            false => coverage.question(),
        };
        let question = question.filter(|_| !self.settings.partial);
        turn.doubt(match &solution.plan {
            None => Some(Doubt::NoPlan),
            Some(_) => forgets.or_else(|| {
                let is_partial = question.is_some() && !goal.facts.is_empty();
                is_partial.then_some(Doubt::NotRepresented)
            }),
        });
        turn.price(&mut answer);
        match solution.plan {
            Some(plan) => {
                let proposal = Proposal {
                    plan,
                    purpose: goal.purpose(world),
                    goal: Some(goal),
                    answer,
                    refused: Vec::new(),
                    question,
                };
                let is_rule_as_said = turn.parted.is_some() && proposal.offers_rule();
                if forgets.is_some() || proposal.question.is_some() && !is_rule_as_said {
                    self.leave_open(turn, Open::Consent(Box::new(proposal)));
                } else {
                    self.propose(turn, proposal);
                }
            }
            None => self.leave_open(turn, Open::Failure(Failure::NoPlan(Box::new(answer)))),
        }
    }

    /// Returns a round with the goal of the proposal and the feedback on it.
    pub(super) fn goal_round(&self, turn: &Turn, words: String) -> Round {
        let goals = turn.proposal.iter().flat_map(|proposal| &proposal.goal);
        let texts: Vec<String> = goals.flat_map(|goal| goal.everyday(&self.world)).collect();
        Round {
            reply: texts.join(goal::JOINT),
            message: words,
        }
    }

    /// Continues the goal dialogue with feedback that concerns the goal.
    pub(super) fn ask_for_another_goal(&mut self, mut turn: Turn, words: String) {
        let round = self.goal_round(&turn, words);
        turn.rounds.push(round);
        self.stage = Stage::Asking(turn, Asking::new(What::Goal(None)));
    }

    /// Understands the instruction again, together with feedback that asks for something beside it. After other feedback, the
    /// conversation is continued.
    pub(super) fn ask_for_more(&mut self, mut turn: Turn, words: String) {
        if !turn.rounds.is_empty() || turn.retold.is_some() || turn.parted.is_some() {
            return self.ask_for_another_goal(turn, words);
        }
        let both = joined(&turn.instruction, &words);
        turn.marks.clear();
        turn.shorter = Some(std::mem::replace(&mut turn.instruction, both));
        let asking = self.first_request(&turn.instruction);
        self.stage = Stage::Asking(turn, asking);
    }

    /// Applies feedback that concerns the steps, or goes on to its other readings.
    pub(super) fn amend(&mut self, turn: Turn, dialogue: &FeedbackDialogue, words: String, wishes: &[StepWish]) {
        let Some(proposal) = turn.proposal.as_deref() else {
            return self.stage = Stage::Idle;
        };
        let world = &self.world;
        let started = (self.now)();
        match amend(world, proposal.plan.plan(), wishes, &proposal.purpose) {
            Amended::Done(amendment) => self.propose_amended(turn, *amendment, started),
            Amended::Impossible { why, .. } => {
                let why = why.into_iter().map(Refusal::Change).collect();
                self.reread(turn, dialogue, words, wishes, why);
            }
        }
    }
}

impl Session {
    /// Returns the instruction without what it forbids; none if it only forbids something.
    ///
    /// The rest is a wish if it names an entity, or if neither it nor the prohibition names one and it is not much
    /// shorter: "please" in front of a prohibition is no wish.
    pub(super) fn wish(&self, turn: &Turn) -> Option<String> {
        let text = turn.text();
        let (forbidden, rest) = coverage::without_prohibitions(&text, &turn.marks);
        if forbidden.is_empty() {
            return Some(turn.words().to_owned());
        }
        let letters = |text: &str| text.chars().filter(|character| character.is_alphanumeric()).count();
        let is_wish = match coverage::names_entity(&self.world, &rest) {
            true => true,
            false => !coverage::names_entity(&self.world, &forbidden) && letters(&rest) * 2 > letters(&forbidden),
        };
        is_wish.then_some(rest)
    }

    /// Handles an instruction that only forbids something. What the model understood as a goal is what must not be
    /// achieved, or what stays as it is: that is offered as a rule, with an empty plan.
    fn offer_rule(&mut self, turn: Turn, understood: &Understanding) {
        let rules = match understood {
            Understanding::Goal(goal) => self.rule(goal),
            Understanding::Doubtful(_) | Understanding::Question(_) | Understanding::Which(_) => None,
        };
        match rules {
            Some(constraints) => {
                let mut rules = Goal::default();
                rules.constraints = constraints;
                self.pursue(turn, rules);
            }
            None => self.leave_unsaid(turn),
        }
    }

    /// Asks about an instruction that forbids something which is no rule.
    pub(super) fn leave_unsaid(&mut self, turn: Turn) {
        let question = format!(
            "You forbid something that I cannot say as a rule: \"{}\". What may I not do?",
            turn.text()
        );
        self.leave_open(turn, Open::Question(question));
    }
}

/// Returns an instruction with what is wanted beside it, as sentences.
pub(super) fn joined(instruction: &str, further: &str) -> String {
    let instruction = instruction.trim_end();
    let is_ended = instruction.ends_with(|last: char| !last.is_alphanumeric());
    let end = if is_ended { "" } else { "." };
    format!("{instruction}{end} {}", further.trim())
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
    /// Returns the words to be understood as one line, which the marks refer to.
    pub(super) fn text(&self) -> String {
        plain_line(self.words())
    }

    /// Returns the goal with its parts in the order in which they are written, if the instruction gives an order and the
    /// goal has none.
    fn staged(&self, goal: &Goal) -> Option<Goal> {
        let has_order = self.marks.iter().any(|mark| mark.gap == Gap::Order);
        let is_plain = |fact: &GoalFact| !matches!(fact, GoalFact::If(_));
        let can_have = goal.stages.is_empty() && goal.facts.len() > 1 && goal.facts.iter().all(is_plain);
        (has_order && can_have).then(|| {
            let mut staged = goal.clone();
            staged.stages = (1..goal.facts.len()).collect();
            staged
        })
    }

    /// Accounts for the instruction. After an answer or feedback, only the marks of a model count: the later words may
    /// have replaced a name or a number of the instruction.
    fn coverage(&self, world: &World, goal: &Goal, plan: Option<&VerifiedPlan>) -> Coverage {
        let text = self.text();
        match self.rounds.is_empty() {
            true => Coverage::new(world, &text, goal, &self.marks, plan),
            false => Coverage::of_marks(world, &text, goal, &self.marks),
        }
    }

    /// Notes why the plan for the last wish is not acted on, if there is a reason.
    fn doubt(&mut self, doubt: Option<Doubt>) {
        let wish = self
            .readings
            .iter_mut()
            .rev()
            .find(|reading| reading.of == ReadingOf::Wish);
        if let (Some(reading), Some(doubt)) = (wish, doubt) {
            reading.doubt = Some(doubt);
        }
    }

    /// Makes the doubtful reading the last one, without its doubt.
    pub(super) fn settle_doubt(&mut self) {
        let is_doubtful = |reading: &Reading| reading.of == ReadingOf::Wish && reading.doubt == Some(Doubt::Unnamed);
        if let Some(place) = self.readings.iter().position(is_doubtful) {
            let reading = self.readings.remove(place);
            self.readings.push(Reading { doubt: None, ..reading });
        }
    }

    /// Adds the readings, the token counts and the model time of the instruction to an answer.
    pub(super) fn price(&self, answer: &mut Answer) {
        answer.readings.clone_from(&self.readings);
        answer.usage = self.usage.into();
        answer.usage.rounds = self.corrections;
        answer.timings_ms.model = self.model_milliseconds;
    }
}
