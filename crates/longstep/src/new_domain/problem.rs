//! A made-up problem for a PDDL domain: a few objects of each kind, and facts under which the actions are possible.
//!
//! Facts that never change hold wherever the actions may ask for them. Of the others, those are added, action by action,
//! that no earlier action achieves (delete relaxation). A fact with an argument that actions move ("the robot is at a
//! room") is given once, others for every object of their kind.

use std::fmt::Write;

use rustc_hash::FxHashSet;

use super::words::unary_statics;
use crate::model::{Action, Atom, Condition, Term, TypeId};
use longstep_core::model::Domain;

/// Argument lists of one action that are looked at.
const BINDINGS: usize = 5_000;
/// Facts of one relation that never changes.
const RELATION: usize = 60;

/// A ground fact: predicate and objects.
type Ground = (usize, Vec<usize>);

/// A kind of object: a type, and the facts that tell kinds apart in untyped files.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Kind {
    of: TypeId,
    statics: Vec<usize>,
}

struct Sketch<'d> {
    domain: &'d Domain,
    /// Name, type and static facts; constants first.
    objects: Vec<(String, Kind)>,
}

/// Writes a problem for the domain.
pub(super) fn write(domain: &Domain) -> String {
    let sketch = Sketch::new(domain);
    let facts = sketch.initial_facts();
    let mut text = format!("(define (problem example) (:domain {})\n(:objects", domain.pddl_name);
    for (name, kind) in &sketch.objects[domain.constants.len()..] {
        // Writing to a string does not fail.
        let _ = write!(text, " {name} - {}", domain.types.name(kind.of));
    }
    text.push_str(")\n(:init");
    for (predicate, objects) in &facts {
        let names: String = objects.iter().map(|o| format!(" {}", sketch.objects[*o].0)).collect();
        let _ = write!(text, " ({}{names})", domain.predicates[*predicate].name);
    }
    for function in &domain.functions {
        let kinds: Vec<TypeId> = function.parameters.iter().map(|p| p.kind).collect();
        for objects in sketch.lists(&kinds, RELATION) {
            let names: String = objects.iter().map(|o| format!(" {}", sketch.objects[*o].0)).collect();
            let number = if function.changes { 10 } else { 1 };
            let _ = write!(text, " (= ({}{names}) {number})", function.name);
        }
    }
    text.push_str(")\n(:goal (and)))\n");
    text
}

fn is_leaf(domain: &Domain, kind: TypeId) -> bool {
    (1..domain.types.names().count()).all(|other| {
        let other = TypeId::new(other);
        other == kind || !domain.types.is_a(other, kind)
    })
}

/// Returns the facts that the top level of a precondition requires.
fn required(action: &Action) -> impl Iterator<Item = &Atom> {
    action.precondition.conjuncts().filter_map(|part| match part {
        Condition::Atom { atom, holds: true, .. } => Some(atom),
        _ => None,
    })
}

impl<'d> Sketch<'d> {
    fn new(domain: &'d Domain) -> Self {
        let mut kinds: Vec<Kind> = Vec::new();
        let mut wanted = 2;
        for action in &domain.actions {
            let mut own: Vec<Kind> = Vec::new();
            for (slot, parameter) in action.parameters.iter().enumerate() {
                let statics = unary_statics(domain, &action.precondition, slot);
                let leaves = (0..domain.types.names().count()).map(TypeId::new).filter(|kind| {
                    domain.types.is_a(*kind, parameter.kind) && (is_leaf(domain, *kind) || *kind == parameter.kind)
                });
                let leaves: Vec<TypeId> = leaves.collect();
                for of in leaves
                    .iter()
                    .copied()
                    .filter(|of| leaves.len() == 1 || is_leaf(domain, *of))
                {
                    let statics = statics.clone();
                    own.push(Kind { of, statics });
                }
            }
            let twice = own
                .iter()
                .any(|kind| own.iter().filter(|other| *other == kind).count() > 1);
            wanted = if twice { 3 } else { wanted };
            kinds.extend(own);
        }
        let all = kinds.clone();
        let within = |kind: &Kind| {
            let more = |other: &Kind| {
                other.of == kind.of
                    && other.statics.len() > kind.statics.len()
                    && kind.statics.iter().all(|fact| other.statics.contains(fact))
            };
            all.iter().any(more)
        };
        kinds.retain(|kind| !within(kind));
        let mut unique: Vec<Kind> = Vec::new();
        for kind in kinds {
            if !unique.contains(&kind) {
                unique.push(kind);
            }
        }
        let constants = domain.constants.iter();
        let constant = |(name, of): &(String, TypeId)| {
            let known = unique.iter().find(|kind| kind.of == *of);
            let statics = known.map(|kind| kind.statics.clone()).unwrap_or_default();
            (name.clone(), Kind { of: *of, statics })
        };
        let mut objects: Vec<(String, Kind)> = constants.map(constant).collect();
        let mut taken: FxHashSet<String> = objects.iter().map(|(name, _)| name.clone()).collect();
        for kind in &unique {
            let named = kind.statics.first().map(|fact| domain.predicates[*fact].name.as_str());
            let base = match kind.of {
                TypeId::OBJECT => named.unwrap_or("item"),
                of => domain.types.name(of),
            };
            for number in 1..=wanted {
                let mut name = format!("{base}_{number}");
                while !taken.insert(name.clone()) {
                    name.push_str("_b");
                }
                objects.push((name, kind.clone()));
            }
        }
        Self { domain, objects }
    }

    /// Returns lists of different objects of the types.
    fn lists(&self, kinds: &[TypeId], limit: usize) -> Vec<Vec<usize>> {
        let mut lists = vec![Vec::new()];
        for kind in kinds {
            let mut longer = Vec::new();
            for list in &lists {
                for (object, (_, own)) in self.objects.iter().enumerate() {
                    if self.domain.types.is_a(own.of, *kind) && !list.contains(&object) && longer.len() < limit {
                        longer.push([list.as_slice(), &[object]].concat());
                    }
                }
            }
            lists = longer;
        }
        lists
    }

    fn ground(&self, atom: &Atom, binding: &[usize]) -> Option<Ground> {
        let objects = atom.terms.iter().map(|term| match term {
            Term::Variable(slot) => binding.get(*slot).copied(),
            Term::Constant(constant) => Some(constant.index()),
        });
        Some((atom.predicate.index(), objects.collect::<Option<_>>()?))
    }

    /// Returns the bindings of an action that respect types and kinds.
    fn bindings(&self, action: &Action) -> Vec<Vec<usize>> {
        let kinds: Vec<TypeId> = action.parameters.iter().map(|p| p.kind).collect();
        let mut lists = self.lists(&kinds, BINDINGS);
        let statics: Vec<Vec<usize>> = (0..kinds.len())
            .map(|slot| unary_statics(self.domain, &action.precondition, slot))
            .collect();
        lists.retain(|list| {
            let mut pairs = list.iter().zip(&statics);
            pairs.all(|(object, needed)| needed.iter().all(|fact| self.objects[*object].1.statics.contains(fact)))
        });
        lists
    }

    /// True if an action exchanges the argument: it takes the fact away for one object and gives it to another.
    fn is_moving(&self, predicate: usize) -> bool {
        self.domain.actions.iter().any(|action| {
            let of = |adds: bool| {
                let effects = action.effects.iter();
                effects.filter(move |e| e.adds == adds && e.atom.predicate.index() == predicate)
            };
            of(true).any(|added| of(false).any(|removed| removed.atom.terms != added.atom.terms))
        })
    }

    fn initial_facts(&self) -> Vec<Ground> {
        let domain = self.domain;
        let mut facts: Vec<Ground> = Vec::new();
        let add = |facts: &mut Vec<Ground>, fact: Ground| {
            if !facts.contains(&fact) {
                facts.push(fact);
            }
        };
        for (object, (_, kind)) in self.objects.iter().enumerate() {
            for fact in &kind.statics {
                add(&mut facts, (*fact, vec![object]));
            }
        }
        let bindings: Vec<Vec<Vec<usize>>> = domain.actions.iter().map(|action| self.bindings(action)).collect();
        let fluent = |predicate: usize| domain.predicate_words[predicate].fluent;
        for (action, bindings) in domain.actions.iter().zip(&bindings) {
            for atom in required(action).filter(|atom| !fluent(atom.predicate.index())) {
                for binding in bindings.iter().take(RELATION) {
                    if let Some(fact) = self.ground(atom, binding) {
                        add(&mut facts, fact);
                    }
                }
            }
        }
        for _ in 0..2 * domain.actions.len() {
            let reached = self.relaxed(&facts, &bindings);
            let missing = |action: usize, binding: &Vec<usize>| -> Vec<Ground> {
                let needed = required(&domain.actions[action]);
                let ground = needed.filter_map(|atom| self.ground(atom, binding));
                ground.filter(|fact| !reached.contains(fact)).collect()
            };
            let cheapest = |action: usize| {
                let all = bindings[action].iter().map(|binding| missing(action, binding));
                all.min_by_key(|facts| (facts.len(), facts.iter().map(|fact| fact.1.len()).sum::<usize>()))
            };
            // In the order of the file: authors begin with what is possible at the start.
            let mut open = (0..domain.actions.len()).filter_map(cheapest);
            let Some(next) = open.find(|facts| !facts.is_empty()) else {
                break;
            };
            for fact in next {
                for spread in self.spread(fact) {
                    add(&mut facts, spread);
                }
            }
        }
        facts
    }

    /// Returns a fact for every object of the kind of its first argument, unless actions move it.
    fn spread(&self, (predicate, objects): Ground) -> Vec<Ground> {
        let same = |object: usize| {
            let kind = &self.objects[object].1;
            let all = self.objects.iter().enumerate();
            all.filter(move |(_, (_, own))| own == kind).map(|(index, _)| index)
        };
        match objects[..] {
            [one] if !self.is_moving(predicate) => same(one).map(|object| (predicate, vec![object])).collect(),
            [one, other] if self.objects[one].1 != self.objects[other].1 => {
                let others: Vec<usize> = same(other).collect();
                let turns = same(one).enumerate();
                turns
                    .map(|(turn, object)| (predicate, vec![object, others[turn % others.len()]]))
                    .collect()
            }
            _ => vec![(predicate, objects)],
        }
    }

    /// Returns all facts that can be reached if nothing is ever taken away.
    fn relaxed(&self, facts: &[Ground], bindings: &[Vec<Vec<usize>>]) -> FxHashSet<Ground> {
        let mut reached: FxHashSet<Ground> = facts.iter().cloned().collect();
        loop {
            let before = reached.len();
            for (action, bindings) in self.domain.actions.iter().zip(bindings) {
                for binding in bindings {
                    let mut needed = required(action).filter_map(|atom| self.ground(atom, binding));
                    if needed.all(|fact| reached.contains(&fact)) {
                        let added = action.effects.iter().filter(|effect| effect.adds);
                        reached.extend(added.filter_map(|effect| self.ground(&effect.atom, binding)));
                    }
                }
            }
            if reached.len() == before {
                return reached;
            }
        }
    }
}
