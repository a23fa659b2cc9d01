//! Conditional goals, which depend on sensed facts: `if expired(milk) then put(milk, bin) else put(milk, fridge)`.

use rustc_hash::FxHashSet;

use super::{GoalFact, literal};
use longstep_model::call::unquoted;
use longstep_model::model::{
    Condition, Domain, EntityId, Fact, PredicateId, Term, Voice, Wanted, When, World, written_fact,
};

/// A goal that depends on a sensed fact.
///
/// It is achieved when the outcome is known and the goals of its branch hold. Goals of the other branch alone must not
/// have been achieved by the plan: wiping a table before checking whether it was dirty does not count. Objects that
/// were only inspected, or that only the other branch mentions, are back in their initial places: "throw the milk away
/// if it is past its date" gives no place for milk that is not.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Conditional {
    /// The sensed fact.
    pub condition: Fact,
    /// The goals if the fact holds.
    pub then: Vec<GoalFact>,
    /// The goals if another outcome holds.
    pub otherwise: Vec<GoalFact>,
}

/// The beginning of a conditional goal.
pub const IF: &str = "if ";
/// The word before a negated condition.
pub const NOT: &str = "not ";
/// The word between the condition and the goals of the first branch.
pub const THEN: &str = " then";
/// The word between two goals of a branch.
pub const AND: &str = " and";
/// The word before the goals of the other branch.
pub const ELSE: &str = " else";

/// A conditional goal as text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenConditional<'t> {
    /// True if the condition follows "not".
    pub negated: bool,
    /// The condition.
    pub condition: &'t str,
    /// The goals of the first branch.
    pub then: Vec<&'t str>,
    /// The goals of the other branch.
    pub otherwise: Vec<&'t str>,
}

impl<'t> WrittenConditional<'t> {
    /// Splits a conditional goal into its texts; none if the text has no "if" at its beginning or no "then" after it.
    pub fn read(text: &'t str) -> Option<Self> {
        let (condition, sides) = split_once(text.strip_prefix(IF)?, THEN)?;
        let (then, otherwise) = match split_once(sides, ELSE) {
            Some((then, otherwise)) => (then, Some(otherwise)),
            None => (sides, None),
        };
        let condition = condition.trim();
        Some(Self {
            negated: condition.starts_with(NOT),
            condition: condition.strip_prefix(NOT).unwrap_or(condition).trim(),
            then: parts(then),
            otherwise: otherwise.map(parts).unwrap_or_default(),
        })
    }
}

fn parts(mut text: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    while let Some((part, rest)) = split_once(text, AND) {
        parts.push(part.trim());
        text = rest;
    }
    parts.push(text.trim());
    parts
}

/// Splits a text at the first occurrence of a word outside parentheses with a blank after it.
pub(super) fn split_once<'t>(text: &'t str, word: &str) -> Option<(&'t str, &'t str)> {
    let mut depth = 0_usize;
    for (at, letter) in unquoted(text) {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            ' ' if depth == 0 => {
                if let Some(rest) = text[at..].strip_prefix(word)
                    && rest.starts_with(' ')
                {
                    return Some((&text[..at], rest));
                }
            }
            _ => {}
        }
    }
    None
}

impl Conditional {
    /// Writes the conditional goal; `name` gives the name of each entity.
    pub(super) fn written(&self, domain: &Domain, name: &dyn Fn(EntityId) -> String) -> String {
        let side = |facts: &[GoalFact]| joined(facts, &format!("{AND} "), |fact| fact.written(domain, name));
        let condition = written_fact(domain, self.condition, name);
        match (&self.then[..], &self.otherwise[..]) {
            ([], otherwise) => format!("{IF}{NOT}{condition}{THEN} {}", side(otherwise)),
            (then, []) => format!("{IF}{condition}{THEN} {}", side(then)),
            (then, otherwise) => format!("{IF}{condition}{THEN} {}{ELSE} {}", side(then), side(otherwise)),
        }
    }

    /// Writes the conditional goal as a sentence.
    pub(super) fn sentence(&self, voice: Voice, world: &World) -> String {
        let side = |facts: &[GoalFact]| joined(facts, " and ", |fact| fact.sentence_in(voice, world));
        let condition = voice.fact(world, self.condition, true);
        match (&self.then[..], &self.otherwise[..]) {
            ([], otherwise) => format!("unless {condition}, {}", side(otherwise)),
            (then, []) => format!("if {condition}, {}", side(then)),
            (then, otherwise) => format!("if {condition}, {}, and otherwise {}", side(then), side(otherwise)),
        }
    }

    /// Maps the goal to another world by identifiers; none if an entity is missing there.
    pub(super) fn carried(&self, domain: &Domain, from: &World, to: &World) -> Option<Self> {
        let carried = |fact: &GoalFact| fact.carried(domain, from, to);
        let GoalFact::Plain(condition) = carried(&GoalFact::Plain(self.condition))? else {
            return None;
        };
        Some(Self {
            condition,
            then: self.then.iter().map(carried).collect::<Option<Vec<_>>>()?,
            otherwise: self.otherwise.iter().map(carried).collect::<Option<Vec<_>>>()?,
        })
    }

    /// Returns the condition to achieve. Goals that are also in `others` may be achieved in either branch.
    pub(super) fn wanted(&self, domain: &Domain, others: &[GoalFact]) -> Wanted {
        let not_then = without(&self.then, [&self.otherwise, others]);
        let not_otherwise = without(&self.otherwise, [&self.then, others]);
        let joined = Joined::new(domain, self);
        let same = not_then.is_empty() && not_otherwise.is_empty() && self.then.len() == self.otherwise.len();
        let condition = if same {
            // Both branches are equal, so the outcome does not matter.
            Condition::And(joined.all(&self.then))
        } else {
            let mut cases = Vec::new();
            for outcome in domain.outcomes(self.condition) {
                let (wanted, unwanted) = if outcome == self.condition {
                    (&self.then, &not_otherwise)
                } else {
                    (&self.otherwise, &not_then)
                };
                let mut parts = vec![joined.known(outcome)];
                parts.extend(joined.all(wanted));
                parts.extend(self.left_alone(domain, wanted, others, &joined.bindings));
                parts.extend(unwanted.iter().map(|fact| joined.not_brought_about(fact)));
                cases.push(Condition::And(parts));
            }
            Condition::Or(cases)
        };
        Wanted {
            condition,
            bindings: joined.bindings,
        }
    }

    /// Returns the conditions that entities which only the other branch mentions, or which were only inspected, are in
    /// their initial places. `bindings` are those of the whole condition.
    fn left_alone(
        &self,
        domain: &Domain,
        wanted: &[GoalFact],
        others: &[GoalFact],
        bindings: &[EntityId],
    ) -> Vec<Condition> {
        let own = GoalFact::If(self.clone());
        let elsewhere = others.iter().filter(|other| **other != own).flat_map(GoalFact::parts);
        let mentioned: Vec<&GoalFact> = elsewhere.chain(wanted).collect();
        let looked_at: Vec<EntityId> = domain.arguments(self.condition).collect();
        // Goals of both branches may bind one entity several times.
        let slots = (0..bindings.len()).filter(|slot| bindings[..*slot].iter().all(|other| *other != bindings[*slot]));
        let alone = slots.filter(|slot| {
            let thing = bindings[*slot];
            if looked_at.contains(&thing) {
                // An inspected entity may be a place in another goal.
                !mentioned.iter().any(|fact| fact.may_move(domain, thing))
            } else {
                !mentioned.iter().any(|fact| fact.about(domain).contains(&thing))
            }
        });
        let stays = |slot: usize| move |predicate: &PredicateId| stays(domain, *predicate, slot, bindings.len());
        let places = places(domain);
        alone.flat_map(|slot| places.iter().map(stays(slot))).collect()
    }
}

/// Writes goals with a word between them.
fn joined(facts: &[GoalFact], between: &str, write: impl Fn(&GoalFact) -> String) -> String {
    facts.iter().map(write).collect::<Vec<_>>().join(between)
}

/// Returns the goals that are in none of the other lists.
fn without(facts: &[GoalFact], others: [&[GoalFact]; 2]) -> Vec<GoalFact> {
    let is_left = |fact: &&GoalFact| !others.iter().any(|others| others.contains(fact));
    facts.iter().filter(is_left).cloned().collect()
}

/// Returns the binary predicates of state words that actions can achieve: the places of objects.
fn places(domain: &Domain) -> Vec<PredicateId> {
    let effects = domain.actions.iter().flat_map(|action| &action.effects);
    let added = effects.filter(|effect| effect.adds).map(|effect| effect.atom.predicate);
    let added: FxHashSet<PredicateId> = added.collect();
    let mut places: Vec<PredicateId> = domain.states.iter().map(|word| word.atom.predicate).collect();
    places.sort_unstable();
    places.dedup();
    places.retain(|predicate| domain.predicate(*predicate).parameters.len() == 2 && added.contains(predicate));
    places
}

/// Returns the condition that an entity is in every relation in which it was initially. `free` is an unused slot.
fn stays(domain: &Domain, predicate: PredicateId, slot: usize, free: usize) -> Condition {
    // Further relations are permitted: only the initial ones must hold again.
    let terms = [slot, free].map(Term::Variable);
    let back = Condition::Or(vec![
        literal(predicate, &terms, false, When::Initially),
        literal(predicate, &terms, true, When::Now),
    ]);
    Condition::Forall(free, domain.predicate(predicate).parameters[1].kind, Box::new(back))
}

/// The conditions of several goals over common bindings.
struct Joined<'a> {
    domain: &'a Domain,
    bindings: Vec<EntityId>,
    /// The goals with their conditions over those bindings.
    parts: Vec<(GoalFact, Condition)>,
}

impl<'a> Joined<'a> {
    fn new(domain: &'a Domain, goal: &Conditional) -> Self {
        let mut wanted: Vec<(GoalFact, Wanted)> = Vec::new();
        for fact in goal.then.iter().chain(&goal.otherwise) {
            wanted.push((fact.clone(), fact.wanted(domain, &[])));
        }
        let mut bindings: Vec<EntityId> = domain.arguments(goal.condition).collect();
        let mut places = Vec::new();
        for (_, wanted) in &wanted {
            places.push((bindings.len(), wanted.bindings.len()));
            bindings.extend(&wanted.bindings);
        }
        let all = bindings.len();
        let mut parts = Vec::with_capacity(wanted.len());
        for ((fact, wanted), (offset, own)) in wanted.into_iter().zip(places) {
            // The bindings of all goals come first. The slots behind them are shared, since no quantifier of one goal
            // encloses another goal.
            let slot = |slot: usize| if slot < own { offset + slot } else { all + slot - own };
            parts.push((fact, wanted.condition.with_slots(&slot)));
        }
        Self {
            domain,
            bindings,
            parts,
        }
    }

    fn all(&self, facts: &[GoalFact]) -> Vec<Condition> {
        facts.iter().map(|fact| self.part(fact)).collect()
    }

    fn part(&self, fact: &GoalFact) -> Condition {
        let part = self.parts.iter().find(|(known, _)| known == fact);
        part.map_or(Condition::TRUE, |(_, condition)| condition.clone())
    }

    /// Returns the condition that the goal does not hold, or held initially.
    fn not_brought_about(&self, fact: &GoalFact) -> Condition {
        let part = self.part(fact);
        Condition::Or(vec![part.clone().complement(), part.initially()])
    }

    /// Returns the condition that the outcome is known to hold, or to have held until an action changed it.
    fn known(&self, outcome: Fact) -> Condition {
        let terms: Vec<Term> = (0..self.domain.arguments(outcome).count())
            .map(Term::Variable)
            .collect();
        let atom = |predicate: PredicateId| literal(predicate, &terms, true, When::Now);
        let past = self.domain.words(outcome.predicate()).past;
        match past {
            Some(past) => Condition::Or(vec![atom(outcome.predicate()), atom(past)]),
            None => atom(outcome.predicate()),
        }
    }
}
