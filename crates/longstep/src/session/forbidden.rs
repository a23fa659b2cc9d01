//! The prohibitions of an instruction, understood as constraints.
//!
//! If the screening marks a part as forbidden, a model splits the instruction into what is to be done and what is not
//! ([`SplittingDialogue`]). Each forbidden act is read as if it were wished for, and what it would achieve may never hold.
//! Beside a wish, nothing touches what the act names either, unless the wish is about it. If the model is not sure of the
//! parts, or one of them cannot be read at all, the person is asked about the marked words.

use super::pending::{Asking, What};
use super::{Session, Stage, Turn};
use crate::coverage::{self, Gap, Mark};
use crate::dialogue::{ConditionMark, MessageDialogue, Split, SplittingDialogue};
use crate::environment::EntityId;
use crate::goal::{self, ALWAYS, Constraint, Goal, GoalFact, NEVER, Understanding};

/// An instruction in two parts.
#[derive(Debug, Clone)]
pub(super) struct Parted {
    /// The wishes, in sentences.
    pub(super) wish: String,
    /// The acts that are forbidden, and still to be read; the next one last.
    unread: Vec<String>,
    /// The achievements of the acts that have been read: they may never hold.
    constraints: Vec<Constraint>,
    /// True if the instruction forbids something.
    forbids: bool,
    /// The marks of the whole instruction.
    marks: Vec<Mark>,
    /// The goal of the wish, while the acts are read.
    goal: Option<Goal>,
}

impl Session {
    /// Takes the marks of a screening. A message among them is confirmed first.
    pub(super) fn marked(&mut self, turn: Turn, marks: Vec<Mark>) {
        let has_message = marks.iter().any(|mark| mark.gap == Gap::Quotation);
        if !has_message || !self.settings.confirming || !turn.is_weighed {
            return self.screened(turn, marks);
        }
        let dialogue = MessageDialogue::new(turn.words());
        self.stage = Stage::Asking(turn, Asking::new(What::Message(Box::new(dialogue), marks)));
    }

    /// Goes on after a message was confirmed, or was none.
    pub(super) fn confirmed(
        &mut self,
        mut turn: Turn,
        dialogue: &MessageDialogue,
        mut marks: Vec<Mark>,
        is_message: bool,
    ) {
        turn.readings.push(dialogue.reading().clone());
        marks.retain(|mark| is_message || mark.gap != Gap::Quotation);
        self.screened(turn, marks);
    }

    /// Goes on after the screening: with the parts of an instruction that forbids something, or with its goals.
    ///
    /// A message needs no quotation marks: a marked one is a text that goals can have, if these are the person's own words.
    /// Parts that overruled a screening are not overruled by a second one: it finds again what it found in the same words.
    pub(super) fn screened(&mut self, mut turn: Turn, marks: Vec<Mark>) {
        let text = turn.text();
        for mark in marks.iter().filter(|mark| mark.gap == Gap::Quotation) {
            let message = mark.text(&text);
            if !message.contains('"') && turn.instruction.contains(message) {
                self.world.add_values(&format!("\"{message}\""));
            }
        }
        turn.marks = marks;
        if turn.parted.as_ref().is_some_and(|parted| !parted.forbids) {
            turn.marks.retain(|mark| !mark.is_prohibition_of_all(&text));
        }
        let what = match turn.forbids() && self.settings.forbidding && turn.is_weighed && turn.parted.is_none() {
            true => What::Splitting(Box::new(SplittingDialogue::new(&self.world, turn.words()))),
            false => What::Goal(None),
        };
        self.stage = Stage::Asking(turn, Asking::new(what));
    }

    /// Takes the parts of an instruction; none if the model is not sure of them.
    ///
    /// Parts without a prohibition overrule the screening only if it took the whole instruction for one. If it marked a
    /// prohibition beside a wish, such parts have lost it.
    pub(super) fn split(&mut self, mut turn: Turn, split: Option<Split>) {
        let split = split.filter(|split| !split.forbidden.is_empty() || self.wish(&turn).is_none());
        let Some(Split { wish, mut forbidden }) = split else {
            return self.stage = Stage::Asking(turn, Asking::new(What::Goal(None)));
        };
        forbidden.reverse();
        for text in forbidden.iter().chain([&wish]) {
            self.world.add_values(text);
        }
        let asking = match wish.is_empty() {
            true => Asking::new(What::Goal(None)),
            false => self.first_request(&wish),
        };
        turn.parted = Some(Parted {
            forbids: !forbidden.is_empty(),
            goal: wish.is_empty().then(Default::default),
            wish,
            unread: forbidden,
            constraints: Vec::new(),
            marks: std::mem::take(&mut turn.marks),
        });
        self.stage = Stage::Asking(turn, asking);
    }

    /// Plans for the goal of a wish, after what the instruction forbids has been read.
    pub(super) fn pursue_within(&mut self, mut turn: Turn, mut goal: Goal) {
        match &mut turn.parted {
            Some(parted) if !parted.unread.is_empty() => {
                parted.goal = Some(goal);
                self.stage = Stage::Asking(turn, Asking::new(What::Goal(None)));
            }
            parted => {
                // Feedback on the goals does not lift what the instruction forbids.
                if let Some(parted) = parted
                    && goal.constraints.is_empty()
                {
                    goal.constraints.clone_from(&parted.constraints);
                }
                self.pursue(turn, goal);
            }
        }
    }

    /// Takes what a forbidden act would achieve; none if it was not understood.
    pub(super) fn forbid(&mut self, mut turn: Turn, understood: Option<Understanding>) {
        let Some(parted) = &mut turn.parted else {
            return self.stage = Stage::Idle;
        };
        let read = match understood {
            Some(Understanding::Goal(goal)) => self.prohibition(&goal),
            _ => None,
        };
        // A model reads "touch the butter" as some goal about the butter, and a constraint must not be weaker than what was
        // said. A standing rule is what the person confirms, and need not be stronger.
        let off = match (parted.wish.is_empty(), &read) {
            (true, Some(_)) => None,
            // An act that is not understood may be about what the wish is about.
            (_, None) if self.may_be_about_wish(parted) => None,
            _ => self.hands_off(parted),
        };
        match read.into_iter().chain(off).reduce(|read, off| [read, off].concat()) {
            Some(constraints) => {
                parted.unread.pop();
                parted.constraints.extend(constraints);
                if parted.unread.is_empty() {
                    let goal = parted.goal.take().unwrap_or_default();
                    self.pursue_within(turn, goal);
                } else {
                    self.stage = Stage::Asking(turn, Asking::new(What::Goal(None)));
                }
            }
            None => {
                let goal = parted.goal.take().unwrap_or_default();
                turn.marks = std::mem::take(&mut parted.marks);
                turn.parted = None;
                match goal.is_empty() {
                    true => self.leave_unsaid(turn),
                    false => self.pursue(turn, goal),
                }
            }
        }
    }

    /// Returns the entities that the wish is about; none before it was read.
    fn wished(&self, parted: &Parted) -> Option<Vec<EntityId>> {
        let goal = parted.goal.as_ref()?;
        Some(goal.facts.iter().flat_map(|fact| fact.about(&self.domain)).collect())
    }

    /// Returns true if a name in the act stands for several entities, and the wish is about one of them.
    fn may_be_about_wish(&self, parted: &Parted) -> bool {
        let (Some(wished), Some(act)) = (self.wished(parted), parted.act()) else {
            return false;
        };
        let shared = coverage::shared_names(&self.world, act);
        shared.iter().flatten().any(|entity| wished.contains(entity))
    }

    /// Returns the constraints that nothing touches the entities which the act names in full, and the wish is not about:
    /// more than was said, and never less. None if there is no such entity.
    fn hands_off(&self, parted: &Parted) -> Option<Vec<Constraint>> {
        let wished = self.wished(parted)?;
        let mut named = coverage::named(&self.world, parted.act()?);
        named.retain(|entity| !wished.contains(entity));
        named.sort_unstable();
        named.dedup();
        (!named.is_empty()).then(|| named.into_iter().map(Constraint::Untouched).collect())
    }

    /// Returns the constraints that no fact of a goal ever holds; none if the goal is more than facts.
    fn prohibition(&self, goal: &Goal) -> Option<Vec<Constraint>> {
        self.constraints(goal, |_| NEVER)
    }

    /// Returns the rule that words without a wish give: what they say never holds, and what holds already always does. "The
    /// window stays shut" is read as a shut window.
    pub(super) fn rule(&self, goal: &Goal) -> Option<Vec<Constraint>> {
        self.constraints(goal, |fact| match goal::is_settled(&self.world, fact) {
            true => ALWAYS,
            false => NEVER,
        })
    }

    fn constraints(&self, goal: &Goal, word: impl Fn(&GoalFact) -> &'static str) -> Option<Vec<Constraint>> {
        let is_plain = |fact: &GoalFact| !matches!(fact, GoalFact::If(_) | GoalFact::Choice(_));
        if goal.is_empty() || !goal.constraints.is_empty() || !goal.facts.iter().all(is_plain) {
            return None;
        }
        let parts = goal.facts.iter().flat_map(GoalFact::parts);
        let texts: Vec<String> = parts
            .map(|fact| format!("{}{}", word(fact), fact.exact(&self.world)))
            .collect();
        Some(goal::parse(&self.world, &texts.join(" & ")).ok()?.constraints)
    }
}

impl Parted {
    /// The forbidden act that is being read.
    pub(super) fn act(&self) -> Option<&str> {
        let act = self.unread.last()?;
        self.goal.is_some().then_some(act)
    }
}

impl Turn {
    /// Returns whether the words to be understood have a condition, as far as is known.
    pub(super) fn condition(&self) -> ConditionMark {
        match self.marks.iter().any(|mark| mark.gap == Gap::Condition) {
            true => ConditionMark::Present,
            false => ConditionMark::Unknown,
        }
    }

    /// Returns true while a forbidden act is being read.
    pub(super) fn is_forbidding(&self) -> bool {
        self.parted.as_ref().is_some_and(|parted| parted.act().is_some())
    }

    /// Returns true if the instruction forbids something, as far as is known.
    pub(super) fn forbids(&self) -> bool {
        match &self.parted {
            Some(parted) => parted.forbids,
            None => self.marks.iter().any(|mark| mark.gap == Gap::Prohibition),
        }
    }
}
