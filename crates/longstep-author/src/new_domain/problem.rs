//! A made-up problem for a PDDL domain: a few objects of each kind, and facts under which the actions are possible.
//!
//! Facts that never change hold wherever the actions may ask for them. Of the others, those are added, action by action,
//! that no earlier action achieves (delete relaxation). A fact with an argument that actions move ("the robot is at a
//! room") is given once, others for every object of their kind.

use std::collections::BTreeMap;
use std::fmt::Write;

use indexmap::IndexSet;
use rustc_hash::FxHashSet;

use super::words::unary_statics;
use longstep::domain::{Action, Atom, Condition, Term, TypeId};
use longstep_core::diagnostic::Diagnostic;
use longstep_core::effort;
use longstep_core::model::Domain;

/// Work units for the facts of a made-up world.
const EFFORT: u64 = 5_000_000;
/// Kinds of objects in a made-up world.
const KINDS: usize = 300;
/// Argument lists of one action that are looked at.
const BINDINGS: usize = 5_000;
/// Work units for one argument list that is kept or looked at.
const KEPT: usize = 8;
/// Facts of one relation that never changes.
const RELATION: usize = 60;

/// A ground fact: predicate and objects.
type Ground = (usize, Vec<usize>);

/// A kind of object: a type, and the facts that tell kinds apart in untyped files.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Kind {
    of: TypeId,
    statics: Vec<usize>,
}

struct Sketch<'d> {
    domain: &'d Domain,
    /// Name, type and static facts; constants first.
    objects: Vec<(String, Kind)>,
    /// True if there are objects of some kinds only.
    is_partial: bool,
}

/// A made-up problem.
pub(super) struct MadeUp {
    pub(super) text: String,
    /// True if objects or facts are missing, since the domain is too large for an example.
    pub(super) is_partial: bool,
}

impl MadeUp {
    /// Returns the note for the author of a domain that is too large for an example.
    pub(super) fn note(&self, file: &str) -> Option<Diagnostic> {
        let message = "the domain is too large for a complete example world: some kinds or facts are missing in it";
        self.is_partial.then(|| Diagnostic::whole(file, message))
    }
}

/// Names of things, by the name of their kind.
pub(super) type Names = BTreeMap<String, Vec<String>>;

/// Writes a problem for the domain. Kinds that are not among the `names` get numbered things.
pub(super) fn write(domain: &Domain, names: &Names) -> MadeUp {
    let sketch = Sketch::new(domain, names);
    let facts = effort::within(EFFORT, || sketch.initial_facts());
    MadeUp {
        text: written(domain, &sketch, &facts.result),
        is_partial: sketch.is_partial || facts.exhausted,
    }
}

fn written(domain: &Domain, sketch: &Sketch<'_>, facts: &IndexSet<Ground>) -> String {
    let mut text = format!("(define (problem example) (:domain {})\n(:objects", domain.pddl_name);
    for (name, kind) in &sketch.objects[domain.constants.len()..] {
        // Writing to a string does not fail.
        let _ = write!(text, " {name} - {}", domain.types.name(kind.of));
    }
    text.push_str(")\n(:init");
    for (predicate, objects) in facts {
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
    fn new(domain: &'d Domain, names: &Names) -> Self {
        let all = TypeId::OBJECT.index()..domain.types.names().count();
        let leaves: Vec<bool> = all.clone().map(|kind| is_leaf(domain, TypeId::new(kind))).collect();
        let mut kinds: IndexSet<Kind> = IndexSet::new();
        let (mut wanted, mut is_partial) = (2, false);
        for action in &domain.actions {
            let mut own: FxHashSet<Kind> = FxHashSet::default();
            for (slot, parameter) in action.parameters.iter().enumerate() {
                let statics = unary_statics(domain, &action.precondition, slot);
                let below = all.clone().filter(|kind| {
                    domain.types.is_a(TypeId::new(*kind), parameter.kind)
                        && (leaves[*kind] || *kind == parameter.kind.index())
                });
                let below: Vec<usize> = below.collect();
                for of in below.iter().filter(|of| below.len() == 1 || leaves[**of]) {
                    let kind = Kind {
                        of: TypeId::new(*of),
                        statics: statics.clone(),
                    };
                    is_partial |= kinds.len() == KINDS && !kinds.contains(&kind);
                    if kinds.len() < KINDS {
                        kinds.insert(kind.clone());
                    }
                    wanted = if own.insert(kind) { wanted } else { 3 };
                }
            }
        }
        let within = |kind: &Kind| {
            let more = |other: &Kind| {
                other.of == kind.of
                    && other.statics.len() > kind.statics.len()
                    && kind.statics.iter().all(|fact| other.statics.contains(fact))
            };
            kinds.iter().any(more)
        };
        let unique: Vec<Kind> = kinds.iter().filter(|kind| !within(kind)).cloned().collect();
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
            let numbered = || (1..=wanted).map(|number| format!("{base}_{number}")).collect();
            let given = names
                .get(base)
                .filter(|given| !given.iter().any(|name| taken.contains(name)));
            for mut name in given.cloned().unwrap_or_else(numbered) {
                while !taken.insert(name.clone()) {
                    name.push_str("_b");
                }
                objects.push((name, kind.clone()));
            }
        }
        Self {
            domain,
            objects,
            is_partial,
        }
    }

    /// Returns lists of different objects of the types.
    fn lists(&self, kinds: &[TypeId], limit: usize) -> Vec<Vec<usize>> {
        let mut lists = vec![Vec::new()];
        for kind in kinds {
            let mut longer = Vec::new();
            for list in &lists {
                if longer.len() >= limit || !effort::spend(self.objects.len() / 4 + 1) {
                    break;
                }
                for (object, (_, own)) in self.objects.iter().enumerate() {
                    if self.domain.types.is_a(own.of, *kind) && !list.contains(&object) && longer.len() < limit {
                        effort::spend(KEPT);
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

    fn initial_facts(&self) -> IndexSet<Ground> {
        let domain = self.domain;
        let mut facts: IndexSet<Ground> = IndexSet::new();
        for (object, (_, kind)) in self.objects.iter().enumerate() {
            for fact in &kind.statics {
                facts.insert((*fact, vec![object]));
            }
        }
        let bindings: Vec<Vec<Vec<usize>>> = domain.actions.iter().map(|action| self.bindings(action)).collect();
        let fluent = |predicate: usize| domain.predicate_words[predicate].fluent;
        for (action, bindings) in domain.actions.iter().zip(&bindings) {
            for atom in required(action).filter(|atom| !fluent(atom.predicate.index())) {
                for binding in bindings.iter().take(RELATION) {
                    if let Some(fact) = self.ground(atom, binding) {
                        facts.insert(fact);
                    }
                }
            }
        }
        for _ in 0..2 * domain.actions.len() {
            let reached = self.relaxed(&facts, &bindings);
            let missing = |action: usize, binding: &Vec<usize>| -> Vec<Ground> {
                effort::spend(KEPT);
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
            let Some(next) = open.find(|facts| !facts.is_empty()).filter(|_| effort::spend(1)) else {
                break;
            };
            for fact in next {
                for spread in self.spread(fact) {
                    facts.insert(spread);
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
    fn relaxed(&self, facts: &IndexSet<Ground>, bindings: &[Vec<Vec<usize>>]) -> FxHashSet<Ground> {
        let mut reached: FxHashSet<Ground> = facts.iter().cloned().collect();
        loop {
            let before = reached.len();
            for (action, bindings) in self.domain.actions.iter().zip(bindings) {
                for binding in bindings {
                    if !effort::spend(KEPT) {
                        return reached;
                    }
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
