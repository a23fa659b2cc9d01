//! Execution paths of a draft as sequential drafts.

use super::super::{Pins, Reach, Unwanted};
use super::draft::{Draft, Part};
use longstep_model::model::{Domain, Fact, State, World};
use longstep_verify::plan::{Node, Resolved, StepId, Test};
use longstep_verify::verify::apply;

/// Order in which sensing outcomes are followed.
#[derive(Debug, Clone, Copy)]
pub(super) enum OutcomeOrder {
    FirstOutcome,
    LastOutcome,
}

/// One execution path of the draft.
#[derive(Debug, Default)]
pub(super) struct ExecutionPath {
    /// The steps with their blocks; none for sensing steps of conditions.
    pub(super) steps: Vec<(usize, Option<usize>)>,
    /// The block in which the path ends.
    pub(super) last: usize,
    /// Sensing outcomes on the path, with the positions of the sensing steps.
    pub(super) outcomes: Vec<(usize, Fact)>,
    /// Sensing outcomes at loop conditions.
    pub(super) looped: Vec<Fact>,
    /// For each decision, the chosen outcome and the number of outcomes.
    pub(super) decisions: Vec<(usize, usize)>,
}

impl Draft {
    /// Follows the given decisions, then the first outcome of each further one, as if every step were applicable.
    pub(super) fn path(&self, world: &World, decisions: &[(usize, usize)], order: OutcomeOrder) -> ExecutionPath {
        let domain = world.domain();
        let mut follower = Follower {
            draft: self,
            domain,
            world,
            state: world.state.clone(),
            given: decisions,
            order,
            path: ExecutionPath::default(),
        };
        follower.block(0);
        follower.path
    }

    /// Converts the path to a sequential draft, with pins for its fixed steps: steps on settled paths, sensing steps,
    /// and the user's pins.
    pub(super) fn linear(&self, resolved: &Resolved, path: &ExecutionPath, pins: &Pins) -> (Resolved, Pins) {
        let items = || path.steps.iter().map(|(number, _)| &self.items[*number]);
        let body = (0..path.steps.len())
            .map(|index| Node::Step(StepId::new(index)))
            .collect();
        let linear = Resolved {
            steps: items().map(|item| Some(item.step.clone())).collect(),
            written: items().map(|item| item.written.clone()).collect(),
            body,
            objects: resolved.objects.clone(),
            ..Resolved::default()
        };
        let kept = path.steps.iter().enumerate().filter(|(place, (number, _))| {
            let item = &self.items[*number];
            let pinned = item.drafted().is_some_and(|number| pins.kept.contains(&number));
            pinned || item.settled || path.outcomes.iter().any(|(sensed, _)| sensed == place)
        });
        let pins = Pins {
            kept: kept.map(|(place, _)| place).collect(),
            unwanted: pins.unwanted.iter().filter_map(|out| self.on(path, out)).collect(),
        };
        (linear, pins)
    }

    /// Translates a prohibition to a position on the path; none if it concerns a position elsewhere.
    fn on(&self, path: &ExecutionPath, unwanted: &Unwanted) -> Option<Unwanted> {
        let drafted = path.steps.iter().map(|(number, _)| self.items[*number].drafted());
        let place_of = |step: usize| drafted.clone().position(|drafted| drafted == Some(step));
        let behind = || place_of(unwanted.before.checked_sub(1)?).map(|place| place + 1);
        let here = place_of(unwanted.before).or_else(behind);
        let before = match unwanted.reach {
            Reach::Here => here?,
            Reach::ThisStep | Reach::ThisAction => here.unwrap_or(path.steps.len()),
        };
        Some(Unwanted {
            before,
            ..unwanted.clone()
        })
    }
}

/// Follows one execution path of a draft.
struct Follower<'a> {
    draft: &'a Draft,
    domain: &'a Domain,
    world: &'a World,
    state: State,
    given: &'a [(usize, usize)],
    order: OutcomeOrder,
    path: ExecutionPath,
}

impl Follower<'_> {
    fn block(&mut self, block: usize) {
        self.path.last = block;
        for part in &self.draft.blocks[block] {
            match part {
                Part::Step(number) => {
                    self.step(*number, Some(block));
                }
                Part::If(test, then, otherwise) => {
                    let side = if self.test(test) { then } else { otherwise };
                    self.block(*side);
                }
                // One iteration suffices to find the errors in the body.
                Part::While(test, body) => {
                    let before = self.path.outcomes.len();
                    let goes_on = self.test(test);
                    let outcomes = self.path.outcomes[before..].iter().map(|(_, fact)| *fact);
                    self.path.looped.extend(outcomes);
                    if goes_on {
                        self.block(*body);
                        self.path.last = block;
                    }
                }
                Part::Repeat(times, body) => {
                    if *times > 0 {
                        self.block(*body);
                        self.path.last = block;
                    }
                }
                Part::Remark(_) => {}
            }
        }
    }

    /// Executes a step; returns the index of its outcome if it senses.
    fn step(&mut self, number: usize, block: Option<usize>) -> Option<usize> {
        let item = &self.draft.items[number];
        let (action, arguments) = (self.domain.action(item.step.action), &item.bound);
        self.path.steps.push((number, block));
        apply(self.world, &mut self.state, action, arguments);
        let outcomes: Vec<Fact> = action
            .senses
            .iter()
            .map(|atom| longstep_model::model::ground(atom, arguments))
            .collect();
        if outcomes.is_empty() {
            return None;
        }
        // A known outcome is no decision: no other one is possible on this path.
        let known = outcomes.iter().position(|fact| self.state.holds(*fact));
        let taken = known.unwrap_or_else(|| self.decide(outcomes.len()));
        self.state.set(outcomes[taken], true);
        self.path.outcomes.push((self.path.steps.len() - 1, outcomes[taken]));
        Some(taken)
    }

    fn decide(&mut self, of: usize) -> usize {
        let given = self.given.get(self.path.decisions.len());
        let taken = given.map_or(0, |(taken, _)| *taken);
        self.path.decisions.push((taken, of));
        match self.order {
            OutcomeOrder::FirstOutcome => taken,
            OutcomeOrder::LastOutcome => of - 1 - taken,
        }
    }

    fn test(&mut self, test: &Test) -> bool {
        match test {
            Test::Sense(step) => self.step(step.index(), None) == Some(0),
            Test::Holds(fact) => self.state.holds(*fact),
            Test::Not(inner) => !self.test(inner),
            Test::All(parts) => parts.iter().all(|part| self.test(part)),
            Test::Any(parts) => parts.iter().any(|part| self.test(part)),
        }
    }
}
