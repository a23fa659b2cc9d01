//! Sensing: its outcomes on one path, and insertion of sensing steps.

use super::super::{Edit, EditKind, Pins, Repaired, Unwanted};
use super::draft::{Draft, Item, Part};
use longstep_model::model::{Atom, Condition, Domain, Effect, EntityId, Fact, Term, Voice, World, ground};
use longstep_verify::plan::{Plan, Step, StepId};
use longstep_verify::verify::{Purpose, Violation, check};

/// Returns the world with a domain in which sensing has exactly these outcomes, so that on one path it is an ordinary
/// action.
pub(super) fn with_outcomes(world: &World, outcomes: &[Fact]) -> World {
    let domain = world.domain().edited(|data| {
        for action in &mut data.actions {
            for atom in std::mem::take(&mut action.senses) {
                for fact in outcomes.iter().filter(|fact| fact.predicate() == atom.predicate) {
                    action.effects.push(Effect {
                        forall: Vec::new(),
                        condition: is_fact(&atom, *fact),
                        atom: atom.clone(),
                        adds: true,
                    });
                }
            }
        }
    });
    world.in_domain(domain)
}

/// Returns the condition that the arguments of an atom are those of a fact.
fn is_fact(atom: &Atom, fact: Fact) -> Condition {
    let terms = atom.terms.iter().enumerate();
    let equal = terms.map(|(place, term)| Condition::Equal {
        left: *term,
        right: Term::Constant(fact.argument(place)),
        holds: true,
    });
    Condition::And(equal.collect())
}

/// Returns true if a step senses, and reveals none of these facts.
fn senses_others(domain: &Domain, step: &Step, facts: &[Fact]) -> bool {
    let atoms = &domain.action(step.action).senses;
    let mut outcomes = atoms.iter().map(|atom| ground(atom, &step.arguments));
    !atoms.is_empty() && !outcomes.any(|fact| facts.contains(&fact))
}

/// Returns the steps and edits of a repaired path. Steps that were inserted before sensing are moved after it where
/// possible, so that they affect this path only.
pub(super) fn behind_sensing(
    world: &World,
    observed: &World,
    repaired: Repaired,
    purpose: &Purpose,
    looped: &[Fact],
    pins: &Pins,
) -> (Vec<Step>, Vec<Edit>) {
    let domain = world.domain();
    let mut steps = repaired.plan.steps().to_vec();
    let mut edits = repaired.edits;
    // A moved step could end up where the user removed one.
    if !pins.unwanted.is_empty() {
        return (steps, edits);
    }
    // After a loop condition it would be executed in each iteration.
    let senses = |step: &Step| senses_others(domain, step, looped);
    for at in (0..steps.len().saturating_sub(1)).rev() {
        let mut place = at;
        while place + 1 < steps.len() {
            let inserted = edits
                .iter()
                .position(|edit| edit.at == place && edit.kind == EditKind::Insert);
            let Some(edit) = inserted.filter(|_| senses(&steps[place + 1])) else {
                break;
            };
            let mut swapped = steps.clone();
            swapped.swap(place, place + 1);
            if !check(observed, Plan::sequence(swapped.clone()), purpose)
                .violations
                .is_empty()
            {
                break;
            }
            steps = swapped;
            edits[edit].at = place + 1;
            place += 1;
        }
    }
    edits.sort_by_key(|edit| edit.at);
    (steps, edits)
}

impl Draft {
    /// Inserts sensing before conditions on unsensed facts, unless the user removed it there.
    pub(super) fn sense(&mut self, world: &World, violations: &[Violation], pins: &Pins) {
        for violation in violations {
            let plain = match violation {
                Violation::When { violation, .. } => violation,
                plain => plain,
            };
            let Violation::Unsensed { fact, .. } = plain else {
                continue;
            };
            let is_outcome = |atom: &Atom| atom.predicate == fact.predicate();
            let sensing = world
                .domain()
                .action_ids()
                .find(|(_, action)| action.senses.iter().any(is_outcome));
            let Some((action, declared)) = sensing else { continue };
            let Some(atom) = declared.senses.first() else { continue };
            let mut arguments: Vec<Option<EntityId>> = vec![None; declared.parameters.len()];
            for (place, term) in atom.terms.iter().enumerate() {
                if let Term::Variable(slot) = term {
                    arguments[*slot] = Some(fact.argument(place));
                }
            }
            let complete: Option<Vec<EntityId>> = arguments.iter().copied().collect();
            let Some(complete) = complete else { continue };
            let step = Step::explained(world, action, complete);
            let condition = Voice::Person.fact(world, *fact, true);
            for block in 0..self.blocks.len() {
                let tests = |part: &Part| matches!(part, Part::If(test, ..) | Part::While(test, _) if test.facts().any(|other| other == fact));
                let Some(place) = self.blocks[block].iter().position(tests) else {
                    continue;
                };
                let from = self.number_from(block, place);
                let is_same = |out: &Unwanted| (out.action, &out.arguments) == (step.action, &step.arguments);
                let was_here = |out: &Unwanted| out.before == from && is_same(out);
                let mut unwanted = pins.unwanted.iter();
                if unwanted.any(|out| out.forbids(step.action, &step.arguments) || was_here(out)) {
                    break;
                }
                self.items.push(Item {
                    step: (&step).into(),
                    bound: step.arguments.clone(),
                    written: step.call(world).to_string(),
                    from,
                    edit: Some((
                        EditKind::Insert,
                        format!("a condition asks whether {condition}, and nothing had sensed that"),
                    )),
                    settled: false,
                });
                let new = self.items.len() - 1;
                self.blocks[block].insert(place, Part::Step(new));
                break;
            }
        }
    }

    /// Returns the draft number of the first step at or after a place.
    fn number_from(&self, block: usize, place: usize) -> usize {
        let mut numbers = Vec::new();
        for part in &self.blocks[block][place..] {
            self.collect(part, &mut numbers);
        }
        let next = numbers.first().map(|number| self.items[*number].from);
        next.unwrap_or_else(|| self.items.iter().map(|item| item.from + 1).max().unwrap_or(0))
    }

    fn collect_block(&self, block: usize, numbers: &mut Vec<usize>) {
        self.blocks[block].iter().for_each(|part| self.collect(part, numbers));
    }

    fn collect(&self, part: &Part, numbers: &mut Vec<usize>) {
        match part {
            Part::Step(number) => numbers.push(*number),
            Part::If(test, then, otherwise) => {
                numbers.extend(test.steps().map(StepId::index));
                self.collect_block(*then, numbers);
                self.collect_block(*otherwise, numbers);
            }
            Part::While(test, body) => {
                numbers.extend(test.steps().map(StepId::index));
                self.collect_block(*body, numbers);
            }
            Part::Repeat(_, body) => self.collect_block(*body, numbers),
            Part::Remark(_) => {}
        }
    }
}
