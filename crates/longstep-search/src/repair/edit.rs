//! Edits of a repair with their reasons.

use super::compile::{Move, Reason, compare_mentions};
use super::target::Meant;
use crate::search::GroundAction;
use longstep_model::model::{Domain, Fact, Moment, NumberChange, State, World, fact_text, holds};
use longstep_verify::plan::{DraftStep, Plan, Resolved, Step};
use longstep_verify::verify::{Change, Purpose, Report, Violation, apply, broken_at_end, unmet};

/// Kind of an [`Edit`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EditKind {
    /// A new step.
    Insert,
    /// A removed step.
    Drop,
    /// A replaced step.
    Replace,
    /// A step moved to a later position.
    Move,
}

/// One change to a draft.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Edit {
    /// The kind of change.
    pub kind: EditKind,
    /// Position in the repaired plan, from 0: that of the new step, or the one where a dropped step would be.
    pub at: usize,
    /// The changed step of the draft, from 0, or the step before which a step is inserted; the number of steps for the
    /// end.
    pub step: usize,
    /// The call before the change.
    pub before: Option<String>,
    /// The call after the change.
    pub after: Option<String>,
    /// Explanation of the new call, if the call omits arguments.
    pub about: Option<String>,
    /// Reason for the user.
    pub why: String,
}

impl EditKind {
    /// The kind in `--json` output.
    pub fn name(self) -> &'static str {
        match self {
            Self::Insert => "insert",
            Self::Drop => "drop",
            Self::Replace => "replace",
            Self::Move => "move",
        }
    }
}

impl Edit {
    /// Describes the change in a few words; `length` is the number of steps in the draft. Steps in the text count from
    /// 1.
    pub fn description(&self, length: usize) -> String {
        let before = self.before.as_deref().unwrap_or("");
        let about = self.about.as_ref().map_or(String::new(), |about| format!(" ({about})"));
        let after = format!("{}{about}", self.after.as_deref().unwrap_or(""));
        let number = self.step + 1;
        match self.kind {
            EditKind::Insert if self.step >= length => format!("add {after} at the end"),
            EditKind::Insert => format!("insert {after} before step {number}"),
            EditKind::Drop => format!("leave out step {number}, {before}"),
            EditKind::Replace => format!("in step {number}, {after} instead of {before}"),
            EditKind::Move => format!("do step {number}, {before}, later, as step {}", self.at + 1),
        }
    }
}

/// Origin of a step in the repaired plan.
enum Origin {
    Kept,
    /// Inserted before this step of the draft.
    Inserted(usize),
    Replaced(usize),
    Moved(usize),
}

/// The repaired plan with the origin of each step, and the dropped steps with their positions.
pub(super) struct Script {
    steps: Vec<(Step, Origin)>,
    dropped: Vec<(usize, usize, Reason)>,
}

impl Script {
    /// Builds the plan from the moves of a search.
    pub(super) fn of(world: &World, draft: &Resolved, moves: &[Move]) -> Self {
        let mut script = Self {
            steps: Vec::new(),
            dropped: Vec::new(),
        };
        let own = |index: usize, ground: &GroundAction| as_written(world, draft.steps[index].as_ref(), ground);
        let meant = |index: usize, ground: &GroundAction| replacement(world, draft.steps[index].as_ref(), ground);
        let new = |ground: &GroundAction| Step::explained(world, ground.action, ground.arguments.clone());
        let mut read = 0;
        for next in moves {
            match next {
                Move::Keep(index, _) | Move::Replace(index, _) | Move::Drop(index, _) | Move::Postpone(index) => {
                    read = index + 1;
                }
                Move::Insert(_) | Move::Resume(..) | Move::Forgo(_) => {}
            }
            match next {
                Move::Keep(index, ground) => script.steps.push((own(*index, ground), Origin::Kept)),
                Move::Resume(index, ground) => script.steps.push((own(*index, ground), Origin::Moved(*index))),
                Move::Insert(ground) => script.steps.push((new(ground), Origin::Inserted(read))),
                Move::Replace(index, ground) => script.steps.push((meant(*index, ground), Origin::Replaced(*index))),
                Move::Drop(index, reason) => script.dropped.push((script.steps.len(), *index, *reason)),
                Move::Postpone(_) | Move::Forgo(_) => {}
            }
        }
        script
    }

    /// Returns the repaired plan.
    pub(super) fn plan(&self) -> Plan {
        self.steps.iter().map(|(step, _)| step.clone()).collect()
    }

    /// Returns the edits, in plan order.
    pub(super) fn edits(
        &self,
        world: &World,
        draft: &Resolved,
        purpose: &Purpose,
        meant: &Meant,
        report: &Report,
    ) -> Vec<Edit> {
        let domain = world.domain();
        let reasons = Reasons {
            domain,
            world,
            purpose,
            meant,
            report,
            before: states(world, report.plan.steps()),
        };
        let mut edits = Vec::new();
        let mut dropped = self.dropped.iter().peekable();
        for at in 0..=self.steps.len() {
            while let Some((_, index, reason)) = dropped.next_if(|(place, ..)| *place == at) {
                edits.push(Edit {
                    kind: EditKind::Drop,
                    at,
                    step: *index,
                    before: Some(draft.written[*index].clone()),
                    after: None,
                    about: None,
                    why: reasons.for_dropping(draft, *index, at, *reason),
                });
            }
            let Some((step, origin)) = self.steps.get(at) else {
                break;
            };
            let after = Some(step.call(world).to_string());
            let hides = domain.action(step.action).implicit().next().is_some();
            let (kind, index, why) = match origin {
                Origin::Kept => continue,
                Origin::Inserted(index) => (EditKind::Insert, *index, reasons.for_having(at)),
                Origin::Replaced(index) => (EditKind::Replace, *index, reasons.for_replacing(draft, *index, at)),
                Origin::Moved(index) => (EditKind::Move, *index, reasons.for_having(at)),
            };
            let before = (kind != EditKind::Insert).then(|| draft.written[index].clone());
            edits.push(Edit {
                kind,
                at,
                step: index,
                before,
                after,
                about: hides.then(|| step.explanation.clone()),
                why,
            });
        }
        edits
    }
}

/// Returns the step with the explanation of the draft, if that has one.
fn as_written(world: &World, written: Option<&DraftStep>, ground: &GroundAction) -> Step {
    let mut step = Step::explained(world, ground.action, ground.arguments.clone());
    if let Some(written) = written.filter(|step| !step.explanation.is_empty()) {
        step.explanation.clone_from(&written.explanation);
    }
    step
}

/// Returns the step in place of a written one. A new actor is often the one that the explanation already names; then the
/// explanation is kept.
fn replacement(world: &World, written: Option<&DraftStep>, ground: &GroundAction) -> Step {
    let same = written.filter(|step| step.action == ground.action);
    let actor = world.domain().action(ground.action).actor;
    let named = same.zip(actor).is_some_and(|(written, actor)| {
        let before = written.arguments[actor].unwrap_or(ground.arguments[actor]);
        compare_mentions(world, &written.explanation, ground.arguments[actor], before).is_gt()
    });
    if named {
        as_written(world, written, ground)
    } else {
        Step::explained(world, ground.action, ground.arguments.clone())
    }
}

/// Returns a state without changes to it. A change that a later step undid has no part in it.
fn undone(state: &State, changes: &[Change]) -> State {
    let mut without = state.clone();
    for change in changes.iter().filter(|change| state.holds(change.fact) == change.holds) {
        without.set(change.fact, !change.holds);
    }
    without
}

/// Returns a state without changes to it, and with the numbers that it would have without the differences that these changes make.
fn without_changes(state: &State, changes: &[Change], numbers: &[NumberChange]) -> State {
    let mut without = undone(state, changes);
    for change in numbers {
        let other = change.before.and_then(|before| {
            let difference = change.after.minus(before)?;
            state.number(change.fluent)?.minus(difference)
        });
        if let Some(other) = other {
            without.set_number(change.fluent, other);
        }
    }
    without
}

/// Returns the states before each step and after the last one.
fn states(world: &World, steps: &[Step]) -> Vec<State> {
    let mut state = world.state.clone();
    let mut states = vec![state.clone()];
    for step in steps {
        apply(world, &mut state, world.domain().action(step.action), &step.arguments);
        states.push(state.clone());
    }
    states
}

struct Reasons<'a> {
    domain: &'a Domain,
    world: &'a World,
    purpose: &'a Purpose,
    meant: &'a Meant,
    report: &'a Report,
    before: Vec<State>,
}

impl Reasons<'_> {
    /// Explains a step by what would fail without it: the first later step that would not be applicable, or a condition
    /// on the final state.
    fn for_having(&self, at: usize) -> String {
        let steps = self.report.plan.steps();
        let changes: Vec<Change> = self
            .report
            .ending()
            .trace
            .steps()
            .nth(at)
            .map_or_else(Vec::new, |(_, changes)| changes.to_vec());
        let trace = &self.report.ending().trace;
        let numbers = trace
            .numbers()
            .nth(at)
            .map_or(&[] as &[NumberChange], |(_, numbers)| numbers);
        let without = |state: &State| without_changes(state, &changes, numbers);
        for (step, before) in steps.iter().zip(&self.before).skip(at + 1) {
            let missing = self.lacking(step, &without(before));
            if !missing.is_empty() {
                // Prefer facts that alone decide whether the later step is applicable.
                let decides = |change: &&Change| !self.lacking(step, &undone(before, &[**change])).is_empty();
                let decisive = changes.iter().filter(decides);
                let needed: Vec<String> = decisive
                    .map(|change| fact_text(self.world, change.fact, change.holds))
                    .collect();
                let call = step.call(self.world);
                let needs = if needed.is_empty() { missing } else { needed };
                return format!("{call} needs that {}", needs.join(", and that "));
            }
        }
        let end = without(&self.before[steps.len()]);
        self.at_end(&end).unwrap_or_else(|| "the plan needs it".to_owned())
    }

    /// Describes what is wrong with a final state.
    fn at_end(&self, state: &State) -> Option<String> {
        let (domain, world) = (self.domain, self.world);
        if let Some(broken) = broken_at_end(world, state, self.purpose).find(|broken| broken.binds) {
            let says = &domain.rules[broken.rule].says;
            return Some(says.fill(|slot| world.with_article(broken.bindings[slot])));
        }
        // Facts that hold after the repair but would not without the step.
        let failing = |fact: &&Fact| self.report.ending().after.holds(**fact) && !state.holds(**fact);
        if let Some(fact) = self.meant.promised().find(failing) {
            let text = fact_text(world, *fact, true);
            return Some(format!("the plan is to end so that {text}"));
        }
        if let Some(fact) = self.meant.kept.iter().find(failing) {
            return Some(format!("it is to be as before: {}", fact_text(world, *fact, true)));
        }
        let moment = Moment { world, state };
        let mut wanted = self.purpose.wanted.iter();
        let is_unmet = wanted.any(|wanted| !holds(moment, &wanted.condition, &mut wanted.bindings.clone()));
        is_unmet.then(|| "the goal asks for it".to_owned())
    }

    fn lacking(&self, step: &Step, state: &State) -> Vec<String> {
        let condition = &self.domain.action(step.action).precondition;
        unmet(self.world, state, condition, &mut step.arguments.clone())
            .iter()
            .map(|missing| missing.text(self.world).unwrap_or_else(|| "the impossible".to_owned()))
            .collect()
    }

    /// Returns the missing preconditions of a draft step at a position of the repaired plan. Its implicit arguments are
    /// those of the replacement `instead`, if that has the same action.
    fn draft_lacks(&self, draft: &Resolved, index: usize, at: usize, instead: Option<&Step>) -> Vec<String> {
        let Some(step) = &draft.steps[index] else {
            return Vec::new();
        };
        let same = instead.filter(|instead| instead.action == step.action);
        let hidden = |place: usize| same.map(|instead| instead.arguments[place]);
        let arguments = step.arguments.iter().enumerate();
        let complete: Option<Vec<_>> = arguments
            .map(|(place, argument)| argument.or_else(|| hidden(place)))
            .collect();
        let Some(arguments) = complete else {
            return Vec::new();
        };
        let step = Step::explained(self.world, step.action, arguments);
        self.lacking(&step, &self.before[at])
    }

    fn for_replacing(&self, draft: &Resolved, index: usize, at: usize) -> String {
        // A missing precondition of the old step says more than a use of the new one.
        let missing = self.draft_lacks(draft, index, at, self.report.plan.steps().get(at));
        if missing.is_empty() {
            self.for_having(at)
        } else {
            format!("{} needs that {}", draft.written[index], missing.join(", and that "))
        }
    }

    fn for_dropping(&self, draft: &Resolved, index: usize, at: usize, reason: Reason) -> String {
        let missing = self.draft_lacks(draft, index, at, None);
        let needs = if missing.is_empty() {
            String::new()
        } else {
            format!(": it needs that {}", missing.join(", and that "))
        };
        match reason {
            Reason::Unknown => {
                let about = |issue: &&Violation| issue.step() == Some(index);
                let issue = draft.issues.iter().find(about);
                let message = issue.map(|issue| issue.message(self.world, &[], None));
                message.unwrap_or_else(|| "its words mean nothing here".to_owned())
            }
            Reason::Impossible => format!("it can never be done here{needs}"),
            Reason::Idle => "it would change nothing here".to_owned(),
            Reason::Unwanted => format!("it conflicts with the rest of the plan{needs}"),
        }
    }
}
