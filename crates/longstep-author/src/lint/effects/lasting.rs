//! Facts that change once and never back.

use super::Rules;
use super::action_facts::{ActionFacts, is_certain};
use super::exchange::common_roles;
use crate::lint::notation::shown;
use crate::lint::{Finding, Lint, quoted};
use longstep::domain::{Atom, Condition, Domain, Effect, PredicateId};

/// The values of each predicate that conditions other than those of goals require.
pub(super) struct Required {
    pub(super) positive: Vec<bool>,
    pub(super) negative: Vec<bool>,
}

impl Required {
    pub(super) fn of(domain: &Domain) -> Self {
        let mut required = Self {
            positive: vec![false; domain.predicates.len()],
            negative: vec![false; domain.predicates.len()],
        };
        let effects = domain.actions.iter().flat_map(|action| &action.effects);
        let conditions = domain.actions.iter().map(|action| &action.precondition);
        let conditions = conditions.chain(effects.map(|effect| &effect.condition));
        let conditions = conditions.chain(domain.rules.iter().map(|rule| &rule.condition));
        for condition in conditions.chain(domain.derivations.iter().map(|derivation| &derivation.when)) {
            required.add(condition);
        }
        required
    }

    fn add(&mut self, condition: &Condition) {
        for (atom, holds) in condition.atoms() {
            if holds {
                self.positive[atom.predicate.index()] = true;
            }
        }
        self.add_negative(condition);
    }

    /// Notes what has to be false. The negation within `imply` and `or` is a case, and no requirement.
    fn add_negative(&mut self, condition: &Condition) {
        match condition {
            Condition::Atom { atom, holds: false, .. } => self.negative[atom.predicate.index()] = true,
            Condition::And(parts) => parts.iter().for_each(|part| self.add_negative(part)),
            Condition::Forall(_, _, inner) | Condition::Exists(_, _, inner) => self.add_negative(inner),
            _ => {}
        }
    }
}

/// Reports an action that changes a fact for good, although the action is meant to be done again.
pub(super) fn lost_facts(rules: &Rules<'_>, required: &Required, findings: &mut Vec<Finding>) {
    let mut found = Vec::new();
    for (index, facts) in rules.actions.iter().enumerate() {
        for effect in &facts.action.effects {
            let is_lost = if !effect.adds {
                is_lost(rules, facts, effect, required)
            } else {
                is_barred(rules, facts, effect, required)
            };
            if is_lost {
                found.push((index, effect));
            }
        }
    }
    for (index, effect) in found {
        let facts = &rules.actions[index];
        let name = facts.name();
        let text = shown(rules.domain, &effect.atom, &facts.action.parameters);
        let predicate = rules.domain.predicate(effect.atom.predicate).name.as_str();
        let (value, again, written) = if !effect.adds {
            ("false", "true", format!("(not {text})"))
        } else {
            ("true", "false", text.clone())
        };
        let needing = rules.needing(effect.atom.predicate, !effect.adds);
        let needing = match &needing[..] {
            [] => String::new(),
            actions => format!(
                ", and {} {} it {again}",
                quoted(actions),
                if actions.len() == 1 { "needs" } else { "need" }
            ),
        };
        let message = format!("the action `{name}` makes `{text}` {value}, no action makes it {again} again{needing}");
        let hint =
            format!("take `{written}` out of the effect of `{name}`, or add an action that makes it {again} again");
        rules.report(findings, Lint::LostFact, name, predicate, message, hint);
    }
}

/// Returns true if the deleted fact is gone for good, and the action is not about that.
fn is_lost(rules: &Rules<'_>, facts: &ActionFacts<'_>, effect: &Effect, required: &Required) -> bool {
    let predicate = effect.atom.predicate;
    let only_this =
        facts.action.numeric.is_empty() && facts.action.effects.iter().all(|own| own.atom.predicate == predicate);
    if only_this || !rules.is_state(predicate) || rules.changes(predicate, true) || required.negative[predicate.index()]
    {
        return false;
    }
    let named = facts.parameters_of(&effect.atom);
    let includes = |atom: &&&Atom| {
        let own = facts.parameters_of(atom);
        named.iter().all(|slot| own.contains(slot))
    };
    let about = facts.adds.iter().filter(includes);
    // What it makes true of the same entity lasts as well: it is a step of their history, such as "eaten".
    let is_history = |atom: &&&Atom| {
        rules.is_state(atom.predicate) && !rules.changes(atom.predicate, false) && !facts.needs.contains(*atom)
    };
    if about.clone().any(|atom| is_history(&atom)) {
        return false;
    }
    let is_repeated = about.clone().any(|atom| is_balanced(rules, facts, &effect.atom, atom));
    if !required.positive[predicate.index()] {
        return is_repeated && !named.is_empty();
    }
    let happens =
        about.clone().any(|atom| rules.domain.words(atom.predicate).event) || !facts.action.numeric.is_empty();
    is_repeated || happens || is_given(rules.domain, predicate) || {
        let is_about = about.clone().any(|atom| rules.is_state(atom.predicate));
        !is_about && is_of_places(rules, facts, &named)
    }
}

/// Returns true if all of the parameters are places: they stay, and so does most of what is true of them.
fn is_of_places(rules: &Rules<'_>, facts: &ActionFacts<'_>, named: &[usize]) -> bool {
    !named.is_empty()
        && named
            .iter()
            .all(|slot| rules.is_place(facts.action.parameters[*slot].kind))
}

/// Returns true if the domain treats the predicate as one that never changes.
fn is_given(domain: &Domain, predicate: PredicateId) -> bool {
    let properties = domain.properties.iter().flat_map(|own| &own.literals);
    let derived = domain.derivations.iter().flat_map(|own| &own.literals);
    let mut literals = properties.chain(derived);
    literals.any(|own| own.holds && own.atom.predicate == predicate)
}

/// Returns true if the added fact bars an action for good, and is a side effect.
fn is_barred(rules: &Rules<'_>, facts: &ActionFacts<'_>, effect: &Effect, required: &Required) -> bool {
    let predicate = effect.atom.predicate;
    let index = predicate.index();
    if !rules.is_state(predicate)
        || !is_certain(effect)
        || rules.changes(predicate, false)
        || required.positive[index]
        || !required.negative[index]
    {
        return false;
    }
    let named = facts.parameters_of(&effect.atom);
    // An object that changes once is common: an empty bottle stays empty.
    if facts.excludes.contains(&&effect.atom) && !is_of_places(rules, facts, &named) {
        return false;
    }
    facts.adds.iter().any(|atom| {
        let own = facts.parameters_of(atom);
        let includes = named.iter().all(|slot| own.contains(slot));
        atom.predicate != predicate && includes && is_balanced(rules, facts, &effect.atom, atom)
    })
}

/// Returns true if the action exchanges another fact for `gained` that some action gives back, such as a place for a place or
/// a shelf for the hand: then it is meant to be done again. Without such a fact, `changed` is the price of `gained`.
fn is_balanced(rules: &Rules<'_>, facts: &ActionFacts<'_>, changed: &Atom, gained: &Atom) -> bool {
    let named = facts.parameters_of(changed);
    let effects = facts.action.effects.iter();
    let mut given_up = effects.filter(|own| !own.adds && own.atom.predicate != changed.predicate);
    rules.is_state(gained.predicate)
        && given_up.any(|own| {
            let (from, to) = (own.atom.predicate, gained.predicate);
            let gives_back = |other: &ActionFacts<'_>| {
                let mut effects = other.action.effects.iter();
                let removes = effects.any(|effect| !effect.adds && effect.atom.predicate == to);
                removes && other.adds.iter().any(|atom| atom.predicate == from)
            };
            let own = facts.parameters_of(&own.atom);
            let shares = named.is_empty() || named.iter().any(|slot| own.contains(slot));
            rules.is_state(from) && (from == to || shares && rules.actions.iter().any(gives_back))
        })
}

/// Reports facts that actions only make true, although this cannot be meant.
pub(super) fn permanent_facts(rules: &Rules<'_>, findings: &mut Vec<Finding>) {
    let mut found = Vec::new();
    for index in 0..rules.domain.predicates.len() {
        let predicate = PredicateId::new(index);
        if rules.is_state(predicate) && !rules.changes(predicate, false) {
            found.extend(held_before(rules, predicate).or_else(|| left_behind(rules, predicate)));
        }
    }
    for (predicate, action, message, culprit) in found {
        let hint = format!("let the effect of `{culprit}` make `{predicate}` false");
        rules.report(findings, Lint::PermanentFact, &action, &predicate, message, hint);
    }
}

/// A predicate, the action that makes it true, a message, and the action that should make it false.
type Permanent = (String, String, String, String);

/// Finds a fact that each action makes true again that comes after it: `put` needs what only `pick` brings about, `pick` needs the
/// fact, and neither makes it false.
fn held_before(rules: &Rules<'_>, predicate: PredicateId) -> Option<Permanent> {
    let adding = rules.adding(predicate);
    let leads = |facts: &&ActionFacts<'_>| leading_to(rules, facts, predicate);
    let culprit = adding
        .iter()
        .map(leads)
        .collect::<Option<Vec<_>>>()?
        .into_iter()
        .next()?;
    let (own, name) = (rules.domain.predicate(predicate).name.clone(), adding[0].name());
    let message = format!(
        "the action `{name}` makes `{own}` true again and again, but no action makes it false: `{culprit}` needs it and leaves it true"
    );
    Some((own, name.to_owned(), message, culprit.to_owned()))
}

/// Returns the action that needs the fact and alone brings about another need of the action, about the same entity.
fn leading_to<'a>(rules: &Rules<'a>, facts: &ActionFacts<'_>, predicate: PredicateId) -> Option<&'a str> {
    let gained = facts.adds.iter().find(|atom| atom.predicate == predicate)?;
    let others = facts
        .needs
        .iter()
        .filter(|atom| atom.predicate != predicate && rules.is_state(atom.predicate));
    let mut found = None;
    for other in others {
        let roles = common_roles(gained, other);
        let needs_it = |source: &&ActionFacts<'a>| {
            let mut needed = source.needs.iter().filter(|atom| atom.predicate == predicate);
            needed.any(|atom| {
                let mut adds = source.adds.iter().filter(|added| added.predicate == other.predicate);
                adds.any(|added| common_roles(atom, added).iter().any(|own| roles.contains(own)))
            })
        };
        let sources = rules.adding(other.predicate);
        let source = sources.first().filter(|_| sources.iter().all(needs_it));
        found = found.or(source
            .filter(|source| source.name() != facts.name())
            .map(|source| source.name()));
    }
    found
}

/// Finds a place that an action leaves without leaving it: the fact holds of one entity before and of another one
/// afterwards, or says where the robot is.
fn left_behind(rules: &Rules<'_>, predicate: PredicateId) -> Option<Permanent> {
    let own = rules.domain.predicate(predicate).name.clone();
    let adding = rules.adding(predicate);
    let about_robot = !begins_with_argument(rules.domain, predicate);
    for facts in &adding {
        let gained = facts.adds.iter().filter(|atom| atom.predicate == predicate);
        for gained in gained {
            let mut before = facts.needs.iter().filter(|atom| atom.predicate == predicate);
            let differs = |before: &&&Atom| {
                let pairs = before.terms.iter().zip(&gained.terms).enumerate();
                let changed: Vec<usize> = pairs
                    .filter(|(_, (left, right))| left != right)
                    .map(|(at, _)| at)
                    .collect();
                // The first argument stays and the place changes; in the other case, a fact spreads.
                changed.len() == 1 && (changed != [0] || before.terms.len() == 1)
            };
            let Some(before) = before.find(differs) else {
                continue;
            };
            if gained.terms.len() == 1 && !about_robot {
                continue;
            }
            let text = |atom: &Atom| shown(rules.domain, atom, &facts.action.parameters);
            let name = facts.name();
            let message = format!(
                "after the action `{name}`, `{}` and `{}` are both true: no action makes `{own}` false",
                text(before),
                text(gained)
            );
            return Some((own, name.to_owned(), message, name.to_owned()));
        }
    }
    let read = |facts: &ActionFacts<'_>| {
        let needed = facts.needs.iter().any(|atom| atom.predicate == predicate);
        needed && adding.iter().all(|other| other.name() != facts.name())
    };
    let mover = adding.first().filter(|facts| !facts.makes_something_else(predicate))?;
    let reader = rules.actions.iter().find(|facts| read(facts))?;
    let is_place = rules.domain.predicate(predicate).parameters.len() == 1 && about_robot;
    let message = format!(
        "no action makes `{own}` false, so after several `{}` it is true of several entities at once, and `{}` is possible at each",
        mover.name(),
        reader.name()
    );
    is_place.then(|| (own, mover.name().to_owned(), message, mover.name().to_owned()))
}

impl ActionFacts<'_> {
    /// Returns true if the action makes another predicate true as well.
    fn makes_something_else(&self, predicate: PredicateId) -> bool {
        self.adds.iter().any(|atom| atom.predicate != predicate)
    }
}

/// Returns true if the sentence of the predicate begins with an argument: "the door is open", but not "the robot is at the
/// door".
pub(super) fn begins_with_argument(domain: &Domain, predicate: PredicateId) -> bool {
    const ARGUMENT: char = '\u{1}';
    domain
        .words(predicate)
        .says
        .fill(|_| ARGUMENT.to_string())
        .trim_start()
        .starts_with(ARGUMENT)
}
