//! A second look at an instruction that led to a question: in plain English, as a model retells it.
//!
//! A question is the safe end of an attempt to understand, and mostly needless: the words were strange, not the wish. The
//! retold instruction is understood from the beginning. Only a plan without a question takes the place of the question,
//! and only if it keeps what the instruction forbids.

use super::pending::{Asking, What};
use super::{Failure, Proposal, Session, Stage, Strategy, Turn};
use crate::coverage::{self, Gap};
use crate::dialogue::{ConstraintKind, Doubt, Reading, ReadingOf, Retelling, RetellingDialogue};
use crate::environment::World;
use crate::goal::{self, Goal};

/// Likelihood in nats below which the goal of a retelling is not used as it is, if the instruction names nothing itself.
const MADE_UP: f64 = -2.8;

/// An instruction that is retold.
#[derive(Debug, Clone)]
pub(super) struct Retold {
    /// The instruction in plain English; none while it is awaited.
    text: Option<String>,
    /// True if the model is sure of it.
    is_sure: bool,
    /// The turn before.
    before: Box<Turn>,
    /// The open point of that attempt.
    open: Open,
}

/// The open point of an attempt to understand an instruction.
#[derive(Debug, Clone)]
pub(super) enum Open {
    /// A question about what the person wants.
    Question(String),
    /// A goal that the words do not show. It is what they mean if other words for them show nothing else.
    Doubtful(Goal),
    /// A question which one of several things is meant. Other words do not answer it.
    Which(String),
    /// A plan with a question.
    Consent(Box<Proposal>),
    /// There is no plan.
    Failure(Failure),
}

impl Open {
    /// Returns true if it may be due to the words of the instruction: other words may be understood.
    fn may_be_words(&self) -> bool {
        !matches!(self, Self::Which(_) | Self::Failure(Failure::NoPlan(_)))
    }
}

impl Session {
    /// Ends an attempt to understand an instruction. It is retold if that may help; if it has been, what was left open
    /// before is what is open now.
    pub(super) fn leave_open(&mut self, mut turn: Turn, open: Open) {
        if turn.is_retold_now() {
            match open {
                Open::Question(_) | Open::Doubtful(_) => self.weigh(turn),
                Open::Which(_) | Open::Consent(_) | Open::Failure(_) => self.take_back(turn),
            }
        } else if self.may_retell(&turn) && open.may_be_words() {
            let dialogue = RetellingDialogue::new(&self.world, &turn.instruction);
            turn.retold = Some(Retold {
                text: None,
                is_sure: false,
                before: Box::new(turn.clone()),
                open,
            });
            self.stage = Stage::Asking(turn, Asking::new(What::Retelling(Box::new(dialogue))));
        } else {
            self.conclude(turn, open);
        }
    }

    /// Returns true if a model can retell the instruction, and say how likely that is.
    fn may_retell(&self, turn: &Turn) -> bool {
        self.settings.retelling
            && self.settings.strategy == Strategy::Goal
            && self.model.kind == ConstraintKind::Grammar
            && turn.is_weighed
            && turn.is_unanswered()
            && turn.retold.is_none()
            && !turn.is_reread
    }

    /// Understands the retold instruction from the beginning, or leaves open what was open before.
    pub(super) fn retold(&mut self, mut turn: Turn, retelling: Option<Retelling>) {
        let retelling = retelling.filter(|own| own.is_sure || self.settings.weighing);
        match (&mut turn.retold, retelling) {
            (Some(retold), Some(Retelling { text, is_sure })) => {
                self.world.add_values(&text);
                let asking = self.first_request(&text);
                retold.text = Some(text);
                retold.is_sure = is_sure;
                turn.marks.clear();
                turn.parted = None;
                self.stage = Stage::Asking(turn, asking);
            }
            _ => self.take_back(turn),
        }
    }

    /// Returns true if the goal of a retelling is not used as it is: the model is not sure of the retelling, or it may have made
    /// up what it names, for an instruction that names nothing itself.
    pub(super) fn is_shaky(&self, turn: &Turn) -> bool {
        let likelihood = || turn.readings.last()?.chosen()?.likelihood;
        let is_made_up = || {
            goal::Mentions::of(&self.world, &turn.instruction).entities.is_empty()
                && likelihood().is_some_and(|likelihood| likelihood < MADE_UP)
        };
        turn.is_retold_now() && (!turn.is_sure() || is_made_up())
    }

    /// Returns to what was open before the instruction was retold.
    pub(super) fn take_back(&mut self, turn: Turn) {
        let Some(retold) = turn.retold else {
            return self.stage = Stage::Idle;
        };
        // Nothing but the same words speaks for a goal that they do not show.
        let open = match retold.open {
            Open::Doubtful(goal) if retold.text.is_none() => Open::Question(goal::guess(&self.world, &goal)),
            open => open,
        };
        let before = Turn {
            usage: turn.usage,
            model_milliseconds: turn.model_milliseconds,
            readings: turn.readings,
            is_reread: true,
            ..*retold.before
        };
        self.conclude(before, open);
    }

    fn conclude(&mut self, mut turn: Turn, open: Open) {
        match open {
            Open::Doubtful(goal) if turn.is_reread => {
                turn.settle_doubt();
                self.pursue_within(turn, goal);
            }
            Open::Doubtful(goal) => {
                let question = goal::guess(&self.world, &goal);
                self.ask_person(turn, format!("{}{question}", goal::QUESTION), question);
            }
            Open::Question(question) | Open::Which(question) => {
                self.ask_person(turn, format!("{}{question}", goal::QUESTION), question);
            }
            Open::Consent(mut proposal) => {
                turn.price(&mut proposal.answer);
                self.propose(turn, *proposal);
            }
            Open::Failure(failure) => self.give_up(turn, failure),
        }
    }
}

impl Turn {
    /// Returns the words to be understood: the instruction or what it was retold as, without what it forbids.
    pub(super) fn words(&self) -> &str {
        let wish = self.parted.as_ref().map(|parted| parted.wish.as_str());
        let wish = wish.filter(|wish| !wish.is_empty());
        wish.or_else(|| self.retelling()).unwrap_or(&self.instruction)
    }

    /// Returns the instruction in plain English, if a model has retold it.
    pub(super) fn retelling(&self) -> Option<&str> {
        self.retold.as_ref()?.text.as_deref()
    }

    /// Returns true if the model is sure of the retelling.
    pub(super) fn is_sure(&self) -> bool {
        self.retold.as_ref().is_some_and(|retold| retold.is_sure)
    }

    /// Returns the readings of the wish, each with true if it can be relied on: that of a retelling of which the model is not sure
    /// can choose among the answers to the instruction itself, and adds one only if it is likely for both.
    pub(super) fn wishes(&self) -> impl Iterator<Item = (&Reading, bool)> {
        let mut counts = true;
        self.readings.iter().filter_map(move |own| match own.of {
            ReadingOf::Wish => Some((own, counts)),
            ReadingOf::Retelling => {
                counts = self.is_sure();
                None
            }
            ReadingOf::Prohibition | ReadingOf::Message | ReadingOf::Weighing => None,
        })
    }

    /// Puts a better guess in place of one that would be asked about.
    pub(super) fn ask_instead(&mut self, question: String) {
        let Some(retold) = &mut self.retold else {
            return;
        };
        let wish = retold.before.last_wish();
        let is_guess = wish.is_some_and(|own| own.doubt == Some(Doubt::Unlikely));
        if let Open::Question(open) = &mut retold.open
            && is_guess
        {
            *open = question;
        }
    }

    /// Returns true if neither the instruction nor its retelling has been split.
    pub(super) fn is_whole(&self) -> bool {
        let before = self.retold.as_ref().map(|retold| retold.before.parted.is_none());
        self.parted.is_none() && before.unwrap_or(true)
    }

    /// Returns true if the person has said nothing but the instruction, and nothing is proposed.
    pub(super) fn is_unanswered(&self) -> bool {
        self.rounds.is_empty() && self.proposal.is_none() && self.rereading.is_none()
    }

    /// Returns true while the instruction is being understood as it was retold.
    pub(super) fn is_retold_now(&self) -> bool {
        self.retold.is_some() && self.is_unanswered()
    }

    /// Returns the doubt about the goal of a retelling that lacks what the instruction forbids, all but one of the things that it
    /// puts in order, the condition of its answer, or a case or a message that was told from the rest: other words for a wish do
    /// not answer the question about them. An amount can be in the other words ("only half" is "halfway").
    pub(super) fn forgets(&self, world: &World, goal: &Goal) -> Option<Doubt> {
        let retold = self.retold.as_ref().filter(|_| self.is_retold_now())?;
        if goal.constraints.is_empty() && retold.before.forbids() {
            return Some(Doubt::ForgetsProhibition);
        }
        if !goal.depends() && retold.before.depends(world) {
            return Some(Doubt::NotRepresented);
        }
        let orders = retold.before.marks.iter().any(|mark| mark.gap == Gap::Order);
        if orders && goal.facts.len() < 2 && goal.stages.is_empty() && goal.constraints.is_empty() {
            return Some(Doubt::NotRepresented);
        }
        let is_kept = |gap: Gap| self.marks.iter().any(|mark| mark.gap == gap);
        let text = retold.before.text();
        let mut missing = coverage::missing(world, &text, goal, &retold.before.marks);
        let is_lost = missing.any(|mark| matches!(mark.gap, Gap::Condition | Gap::Quotation) && !is_kept(mark.gap));
        (is_lost && matches!(retold.open, Open::Consent(_))).then_some(Doubt::NotRepresented)
    }

    /// Returns the last reading of the wish.
    fn last_wish(&self) -> Option<&Reading> {
        self.readings.iter().rfind(|own| own.of == ReadingOf::Wish)
    }

    /// Returns true if the answer to the instruction had a condition.
    fn depends(&self, world: &World) -> bool {
        let chosen = self.last_wish().and_then(Reading::chosen);
        chosen.is_some_and(|answer| goal::parse(world, &answer.text).is_ok_and(|goal| goal.depends()))
    }

    /// Returns the note that a plan is for other words than those of the instruction.
    pub(super) fn retelling_note(&self) -> Option<String> {
        let words = self.words();
        (words != self.instruction).then(|| format!("\"{}\" was taken for \"{words}\"", self.instruction))
    }
}
