//! Goals that depend on what sensing tells: `if expired(milk) then put(milk, bin) else put(milk, fridge)`.

use super::GoalFact;
use crate::model::{Atom, Condition, Domain, EntityId, Fact, PredicateId, Term, Voice, Wanted, World, written_fact};

/// A goal that depends on a fact that sensing tells.
///
/// It is reached when it is known which outcome holds and what is asked for in that case holds too. What is asked for in
/// the other case alone must not have been brought about: nobody wipes the table first and then looks whether it was
/// dirty. And what was only looked at, or would have been needed in the other case, is back where it was: "throw the milk
/// away if it is past its date" does not say where milk goes that is not.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Conditional {
    /// The fact.
    pub condition: Fact,
    /// What is wanted if it holds.
    pub then: Vec<GoalFact>,
    /// What is wanted if another outcome holds.
    pub otherwise: Vec<GoalFact>,
}

/// Beginning of a conditional goal.
pub const IF: &str = "if ";
/// Word before a condition that must not hold.
pub const NOT: &str = "not ";
/// Word between the condition and the goals for the case that it holds.
pub const THEN: &str = " then";
/// Word between two goals of a side.
pub const AND: &str = " and";
/// Word before the goals for the other case.
pub const ELSE: &str = " else";

/// A conditional goal as it is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written<'t> {
    /// Whether the condition stands after "not".
    pub negated: bool,
    /// The condition.
    pub condition: &'t str,
    /// Goals for the case that it holds.
    pub then: Vec<&'t str>,
    /// Goals for the other case.
    pub otherwise: Vec<&'t str>,
}

impl<'t> Written<'t> {
    /// Takes a conditional goal apart; none if the text does not begin with "if" and go on with "then".
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

/// The text before and after a word that stands outside parentheses, a blank behind it.
fn split_once<'t>(text: &'t str, word: &str) -> Option<(&'t str, &'t str)> {
    let mut depth = 0_usize;
    for (at, letter) in text.char_indices() {
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
    /// How it is written, with `name` called for each entity.
    pub(super) fn written(&self, domain: &Domain, name: &dyn Fn(EntityId) -> String) -> String {
        let side = |facts: &[GoalFact]| {
            let facts: Vec<String> = facts.iter().map(|fact| fact.written(domain, name)).collect();
            facts.join(&format!("{AND} "))
        };
        let condition = written_fact(domain, self.condition, name);
        match (&self.then[..], &self.otherwise[..]) {
            ([], otherwise) => format!("{IF}{NOT}{condition}{THEN} {}", side(otherwise)),
            (then, []) => format!("{IF}{condition}{THEN} {}", side(then)),
            (then, otherwise) => format!("{IF}{condition}{THEN} {}{ELSE} {}", side(then), side(otherwise)),
        }
    }

    /// As a sentence.
    pub(super) fn sentence(&self, voice: Voice, domain: &Domain, world: &World) -> String {
        let side = |facts: &[GoalFact]| {
            let facts = facts.iter().map(|fact| fact.sentence_in(voice, domain, world));
            facts.collect::<Vec<_>>().join(" and ")
        };
        let condition = voice.fact(domain, world, self.condition, true);
        match (&self.then[..], &self.otherwise[..]) {
            ([], otherwise) => format!("unless {condition}, {}", side(otherwise)),
            (then, []) => format!("if {condition}, {}", side(then)),
            (then, otherwise) => format!("if {condition}, {}, and otherwise {}", side(then), side(otherwise)),
        }
    }

    /// The same about the things of another world, if they are there.
    pub(super) fn carried(&self, domain: &Domain, from: &World, to: &World) -> Option<Self> {
        let side = |facts: &[GoalFact]| -> Option<Vec<GoalFact>> {
            facts.iter().map(|fact| fact.carried(domain, from, to)).collect()
        };
        let GoalFact::Plain(condition) = GoalFact::Plain(self.condition).carried(domain, from, to)? else {
            return None;
        };
        Some(Self {
            condition,
            then: side(&self.then)?,
            otherwise: side(&self.otherwise)?,
        })
    }

    /// What must hold for it. What `others` ask for as well may be brought about in any case.
    pub(super) fn wanted(&self, domain: &Domain, others: &[GoalFact]) -> Wanted {
        let alone = |facts: &[GoalFact], side: &[GoalFact]| -> Vec<GoalFact> {
            let alone = |fact: &&GoalFact| !side.contains(fact) && !others.contains(fact);
            facts.iter().filter(alone).cloned().collect()
        };
        let not_then = alone(&self.then, &self.otherwise);
        let not_otherwise = alone(&self.otherwise, &self.then);
        let joined = Joined::new(domain, self);
        let same = not_then.is_empty() && not_otherwise.is_empty() && self.then.len() == self.otherwise.len();
        let condition = if same {
            // What it depends on makes no difference.
            Condition::And(joined.all(&self.then))
        } else {
            let outcomes = domain.outcomes(self.condition);
            let case = |outcome: Fact| {
                let (wanted, unwanted) = match outcome == self.condition {
                    true => (&self.then, &not_otherwise),
                    false => (&self.otherwise, &not_then),
                };
                let mut parts = vec![joined.known(outcome)];
                parts.extend(joined.all(wanted));
                parts.extend(self.left_alone(domain, wanted, others, &joined.bindings));
                parts.extend(unwanted.iter().map(|fact| joined.not_brought_about(fact)));
                Condition::And(parts)
            };
            Condition::Or(outcomes.into_iter().map(case).collect())
        };
        Wanted {
            condition,
            bindings: joined.bindings,
        }
    }

    /// That what only the other case is about is where it was, and so is what was only looked at. `bindings` are those
    /// of the whole condition.
    fn left_alone(
        &self,
        domain: &Domain,
        wanted: &[GoalFact],
        others: &[GoalFact],
        bindings: &[EntityId],
    ) -> Vec<Condition> {
        let own = GoalFact::If(self.clone());
        let elsewhere = others.iter().filter(|other| **other != own).flat_map(GoalFact::parts);
        let spoken: Vec<&GoalFact> = elsewhere.chain(wanted).collect();
        let looked_at: Vec<EntityId> = domain.arguments(self.condition).collect();
        let is_free = |thing: &EntityId| match looked_at.contains(thing) {
            // A place where something is put may have been looked at, too.
            true => !spoken.iter().any(|fact| fact.subject(domain) == Some(*thing)),
            false => !spoken.iter().any(|fact| fact.about(domain).contains(thing)),
        };
        let slots = (0..bindings.len()).filter(|slot| bindings[..*slot].iter().all(|other| *other != bindings[*slot]));
        let alone = slots.filter(|slot| is_free(&bindings[*slot]));
        let stays = |slot: usize| move |predicate: &PredicateId| stays(domain, *predicate, slot, bindings.len());
        let places = places(domain);
        alone.flat_map(|slot| places.iter().map(stays(slot))).collect()
    }
}

/// The predicates with which an environment says where things are, as far as actions change it.
fn places(domain: &Domain) -> Vec<PredicateId> {
    let effects = || domain.actions.iter().flat_map(|action| &action.effects);
    let brought_about =
        |predicate: PredicateId| effects().any(|effect| effect.adds && effect.atom.predicate == predicate);
    let mut places: Vec<PredicateId> = domain.states.iter().map(|word| word.atom.predicate).collect();
    places.sort_unstable();
    places.dedup();
    places.retain(|predicate| domain.predicate(*predicate).parameters.len() == 2 && brought_about(*predicate));
    places
}

/// That a thing is still related to whatever it was related to at the start. `free` is a slot that nothing has.
fn stays(domain: &Domain, predicate: PredicateId, slot: usize, free: usize) -> Condition {
    let there = |holds: bool, initially: bool| Condition::Atom {
        atom: Atom {
            predicate,
            terms: vec![Term::Variable(slot), Term::Variable(free)],
        },
        holds,
        initially,
    };
    let back = Condition::Or(vec![there(false, true), there(true, false)]);
    Condition::Forall(free, domain.predicate(predicate).parameters[1].kind, Box::new(back))
}

/// Conditions of several goals as parts of one, over the bindings of all of them.
struct Joined<'a> {
    domain: &'a Domain,
    bindings: Vec<EntityId>,
    /// The conditions of the parts, over those bindings.
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
        let shift = |((fact, wanted), (offset, own)): ((GoalFact, Wanted), (usize, usize))| {
            let slot = |slot: usize| if slot < own { offset + slot } else { all + slot - own };
            (fact, moved(wanted.condition, &slot))
        };
        Self {
            domain,
            bindings,
            parts: wanted.into_iter().zip(places).map(shift).collect(),
        }
    }

    fn all(&self, facts: &[GoalFact]) -> Vec<Condition> {
        facts.iter().map(|fact| self.part(fact)).collect()
    }

    fn part(&self, fact: &GoalFact) -> Condition {
        let part = self.parts.iter().find(|(known, _)| known == fact);
        part.map_or(Condition::TRUE, |(_, condition)| condition.clone())
    }

    /// That the goal does not hold, unless it did at the start.
    fn not_brought_about(&self, fact: &GoalFact) -> Condition {
        let part = self.part(fact);
        Condition::Or(vec![part.clone().negated(), asked_initially(part)])
    }

    /// That the outcome is known to hold, or to have held until something was done about it.
    fn known(&self, outcome: Fact) -> Condition {
        let terms: Vec<Term> = (0..self.domain.arguments(outcome).count())
            .map(Term::Variable)
            .collect();
        let atom = |predicate| Condition::Atom {
            atom: Atom {
                predicate,
                terms: terms.clone(),
            },
            holds: true,
            initially: false,
        };
        let past = self.domain.words(outcome.predicate()).past;
        match past {
            Some(past) => Condition::Or(vec![atom(outcome.predicate()), atom(past)]),
            None => atom(outcome.predicate()),
        }
    }
}

/// The condition with its slots elsewhere.
fn moved(condition: Condition, slot: &impl Fn(usize) -> usize) -> Condition {
    let term = |term: Term| match term {
        Term::Variable(variable) => Term::Variable(slot(variable)),
        constant => constant,
    };
    let all = |parts: Vec<Condition>| parts.into_iter().map(|part| moved(part, slot)).collect();
    match condition {
        Condition::And(parts) => Condition::And(all(parts)),
        Condition::Or(parts) => Condition::Or(all(parts)),
        Condition::Forall(own, kind, inner) => Condition::Forall(slot(own), kind, Box::new(moved(*inner, slot))),
        Condition::Exists(own, kind, inner) => Condition::Exists(slot(own), kind, Box::new(moved(*inner, slot))),
        Condition::Atom { atom, holds, initially } => Condition::Atom {
            atom: Atom {
                predicate: atom.predicate,
                terms: atom.terms.into_iter().map(term).collect(),
            },
            holds,
            initially,
        },
        Condition::Equal { left, right, holds } => Condition::Equal {
            left: term(left),
            right: term(right),
            holds,
        },
    }
}

/// The condition, asked of the state in which the instruction was given.
fn asked_initially(condition: Condition) -> Condition {
    let all = |parts: Vec<Condition>| parts.into_iter().map(asked_initially).collect();
    match condition {
        Condition::And(parts) => Condition::And(all(parts)),
        Condition::Or(parts) => Condition::Or(all(parts)),
        Condition::Forall(slot, kind, inner) => Condition::Forall(slot, kind, Box::new(asked_initially(*inner))),
        Condition::Exists(slot, kind, inner) => Condition::Exists(slot, kind, Box::new(asked_initially(*inner))),
        Condition::Atom { atom, holds, .. } => Condition::Atom {
            atom,
            holds,
            initially: true,
        },
        equal @ Condition::Equal { .. } => equal,
    }
}
