//! Rules, and the bindings that break them.

use super::Purpose;
use crate::domain::{Atom, Condition, Domain, Rule, RuleTime, Term};
use crate::effort;
use crate::search::Wanted;
use crate::world::{Bindings, EntityId, Moment, State, World, holds};

/// A rule that is set aside for whatever an entity is part of, because the goal asks for the opposite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Waiver {
    /// The rule's place in the domain's list.
    pub rule: usize,
    /// The entity that the goal speaks of.
    pub entity: EntityId,
}

impl Waiver {
    fn covers(&self, rule: usize, bindings: &[EntityId]) -> bool {
        self.rule == rule && (bindings.is_empty() || bindings.contains(&self.entity))
    }
}

/// The bindings of the rule's variables under which it does not hold, in order.
///
/// A rule is mostly of the form "not (this and that)", so candidates come from the facts that hold rather
/// than from all combinations of entities.
pub fn broken_bindings(rule: &Rule, world: &World, state: &State) -> Vec<Bindings> {
    let parts = match &rule.condition {
        Condition::Or(parts) => parts.as_slice(),
        other => std::slice::from_ref(other),
    };
    // For the rule to be broken, each atom that must not hold in one of the alternatives has to hold.
    let mut partial = vec![vec![None; rule.variables.len()]];
    for (atom, initially) in parts.iter().flat_map(denied_atoms) {
        partial = join(&partial, atom, if initially { &world.state } else { state });
    }
    let mut broken = Vec::new();
    for bindings in partial {
        complete(rule, world, state, &bindings, &mut Vec::new(), &mut broken);
    }
    broken.sort();
    broken.dedup();
    broken
}

/// Atoms that have to hold for the alternative to fail, and whether they are asked of the start.
fn denied_atoms(part: &Condition) -> Vec<(&Atom, bool)> {
    match part {
        Condition::Atom {
            atom,
            holds: false,
            initially,
        } => vec![(atom, *initially)],
        Condition::Or(parts) => parts.iter().flat_map(denied_atoms).collect(),
        _ => Vec::new(),
    }
}

/// Each partial binding, extended in every way in which the atom holds.
fn join(partial: &[Vec<Option<EntityId>>], atom: &Atom, state: &State) -> Vec<Vec<Option<EntityId>>> {
    let mut joined = Vec::new();
    for bindings in partial {
        // Facts are sorted by their first argument: where that is known, only those are looked at.
        let first = match atom.terms.first() {
            Some(Term::Constant(constant)) => Some(*constant),
            Some(Term::Variable(slot)) => bindings.get(*slot).copied().flatten(),
            None => None,
        };
        let facts = match first {
            Some(first) => state.of_first(atom.predicate, first),
            None => state.of_predicate(atom.predicate),
        };
        if !effort::spend(1 + facts.len()) {
            break;
        }
        for fact in facts {
            let mut extended = bindings.clone();
            let fits = atom.terms.iter().enumerate().all(|(place, term)| {
                let entity = fact.argument(place);
                match term {
                    Term::Constant(constant) => *constant == entity,
                    // A variable that is quantified inside the rule is not one of the rule's own.
                    Term::Variable(slot) => extended
                        .get_mut(*slot)
                        .is_none_or(|bound| *bound.get_or_insert(entity) == entity),
                }
            });
            if fits {
                effort::spend(effort::KEPT);
                joined.push(extended);
            }
        }
    }
    joined
}

fn complete(
    rule: &Rule,
    world: &World,
    state: &State,
    partial: &[Option<EntityId>],
    bindings: &mut Bindings,
    broken: &mut Vec<Bindings>,
) {
    let Some(variable) = rule.variables.get(bindings.len()) else {
        if !holds(Moment { world, state }, &rule.condition, bindings) {
            // A list of its own, and a violation that is made of it.
            effort::spend(4 * effort::KEPT);
            broken.push(bindings.clone());
        }
        return;
    };
    let all = world.of_kind(variable.kind);
    let fixed = partial[bindings.len()];
    let candidates = fixed.as_ref().map_or(all, std::slice::from_ref);
    for entity in candidates
        .iter()
        .filter(|entity| fixed.is_none() || all.contains(entity))
    {
        if !effort::spend(1) {
            return;
        }
        bindings.push(*entity);
        complete(rule, world, state, partial, bindings, broken);
        bindings.pop();
    }
}

/// Returns whether a step from one state to another breaks a rule for every state that held before it.
pub(super) fn breaks_a_rule(domain: &Domain, world: &World, before: &State, after: &State) -> bool {
    let mut always = domain.rules.iter().filter(|rule| rule.time == RuleTime::Always);
    always.any(|rule| {
        let broken = broken_bindings(rule, world, after);
        !broken.is_empty() && {
            let known = broken_bindings(rule, world, before);
            broken.iter().any(|bindings| known.binary_search(bindings).is_err())
        }
    })
}

/// How many rules for the end a state breaks, each counted for every choice of entities.
pub(super) fn broken_rules_at_end(domain: &Domain, world: &World, state: &State) -> usize {
    let at_end = domain.rules.iter().filter(|rule| rule.time == RuleTime::End);
    at_end.map(|rule| broken_bindings(rule, world, state).len()).sum()
}

/// A rule that is broken in the last state of a plan.
pub(crate) struct Broken {
    /// The rule's place in the domain's list.
    pub(crate) rule: usize,
    /// The entities for which it is.
    pub(crate) bindings: Bindings,
    /// Whether the plan has to keep it; it is only remarked on otherwise.
    pub(crate) binds: bool,
}

/// The rules that are broken in a last state and that the purpose does not set aside, in the domain's order.
pub(crate) fn broken_at_end<'a>(
    domain: &'a Domain,
    world: &'a World,
    state: &'a State,
    purpose: &'a Purpose,
) -> impl Iterator<Item = Broken> + 'a {
    let rules = domain.rules.iter().enumerate();
    let at_end = rules.filter(|(_, rule)| matches!(rule.time, RuleTime::End | RuleTime::Tidy));
    at_end.flat_map(move |(number, rule)| {
        let waived = move |bindings: &Bindings| purpose.waivers.iter().any(|waiver| waiver.covers(number, bindings));
        let broken = broken_bindings(rule, world, state).into_iter();
        broken
            .filter(move |bindings| !waived(bindings))
            .map(move |bindings| Broken {
                rule: number,
                bindings,
                binds: rule.time == RuleTime::End || purpose.from_goal,
            })
    })
}

/// What the rules ask of the last state of a plan; those for tidiness only if it is made from a goal.
pub(crate) fn wanted_at_end(domain: &Domain, waivers: &[Waiver], from_goal: bool) -> Vec<Wanted> {
    let at_end = |rule: &Rule| rule.time == RuleTime::End || (from_goal && rule.time == RuleTime::Tidy);
    let rules = domain.rules.iter().enumerate().filter(|(_, rule)| at_end(rule));
    rules
        .map(|(number, rule)| {
            let waived = waivers.iter().filter(|waiver| waiver.rule == number);
            let mut rule = rule.clone();
            // For what is waived the rule says nothing; one without variables says nothing at all.
            let exceptions = waived.flat_map(|waiver| match rule.variables.len() {
                0 => vec![Condition::TRUE],
                variables => (0..variables).map(|slot| is(slot, waiver.entity)).collect(),
            });
            let mut alternatives: Vec<Condition> = exceptions.collect();
            alternatives.push(rule.condition);
            rule.condition = Condition::Or(alternatives);
            Wanted {
                condition: rule.everywhere(),
                bindings: Vec::new(),
            }
        })
        .collect()
}

fn is(slot: usize, entity: EntityId) -> Condition {
    Condition::Equal {
        left: Term::Variable(slot),
        right: Term::Constant(entity),
        holds: true,
    }
}
