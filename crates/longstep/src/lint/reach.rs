//! What can ever be true and done in a domain, whatever its environment says.
//!
//! Predicates are taken as a whole: one that can be true of something can be true of anything that fits its types, and
//! every fact can also be false. So what is called impossible here is impossible; some of what is called possible is
//! not.

use crate::model::{Action, Domain, Literal, Parameter, PredicateId, TypeId, Unknown};
use crate::model::{Atom, Condition, Term};

/// Why a condition can never hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Obstacle {
    /// Nothing makes the predicate true.
    NeverTrue(PredicateId),
    /// The predicate is an event, and is asked of the state in which the instruction was given.
    NotYet(PredicateId),
    /// The condition asks for the atom and for its opposite; with `forall`, one of the two is asked of everything.
    Contradiction { atom: Atom, forall: bool },
    /// Two terms that cannot be the same, or one term that cannot differ from itself.
    Equality { left: Term, right: Term, holds: bool },
    /// No entity has the type.
    Empty(TypeId),
    /// No entity has the type that the atom asks for at this argument.
    Mismatch(Atom),
    /// An `or` of nothing.
    Nothing,
}

/// What can be, in a domain.
pub(super) struct Reach<'a> {
    domain: &'a Domain,
    /// By predicate: whether it can ever be true.
    reached: Vec<bool>,
    /// By action: why it can never apply, if it cannot.
    obstacles: Vec<Option<Obstacle>>,
}

impl<'a> Reach<'a> {
    /// Finds out what can be true, beginning with what an environment can say and adding what actions can do.
    pub(super) fn of(domain: &'a Domain) -> Self {
        let mut reach = Self {
            domain,
            reached: vec![false; domain.predicates.len()],
            obstacles: vec![None; domain.actions.len()],
        };
        loop {
            let more: Vec<PredicateId> = reach.said().into_iter().chain(reach.done()).collect();
            let before = reach.reached.clone();
            more.iter()
                .for_each(|predicate| reach.reached[predicate.index()] = true);
            if reach.reached == before {
                break;
            }
        }
        reach.obstacles = domain.actions.iter().map(|action| reach.to_action(action)).collect();
        reach
    }

    /// What an environment can say, and what can follow from it.
    fn said(&self) -> Vec<PredicateId> {
        let domain = self.domain;
        let any = [TypeId::OBJECT, TypeId::OBJECT];
        let can_hold = |when: &Condition| self.obstacle(when, &any).is_none();
        let mut said: Vec<PredicateId> = domain.states.iter().map(|state| state.atom.predicate).collect();
        let mut say = |literals: &[Literal]| {
            let holding = literals.iter().filter(|literal| literal.holds);
            said.extend(holding.map(|literal| literal.atom.predicate));
        };
        domain.properties.iter().for_each(|property| say(&property.literals));
        for derivation in domain
            .derivations
            .iter()
            .filter(|derivation| can_hold(&derivation.when))
        {
            say(&derivation.literals);
        }
        for default in domain.defaults.iter().filter(|default| can_hold(&default.when)) {
            said.push(default.atom.predicate);
        }
        for (index, words) in domain.predicate_words.iter().enumerate() {
            if words.unknown == Unknown::Assume {
                said.push(PredicateId::new(index));
            }
        }
        said
    }

    /// What actions can make true, or tell.
    fn done(&self) -> Vec<PredicateId> {
        let mut done = Vec::new();
        for action in self
            .domain
            .actions
            .iter()
            .filter(|action| self.to_action(action).is_none())
        {
            for (index, effect) in action.effects.iter().enumerate() {
                if effect.adds && self.to_effect(action, index).is_none() {
                    done.push(effect.atom.predicate);
                }
            }
            done.extend(action.senses.iter().map(|atom| atom.predicate));
        }
        done
    }

    fn to_action(&self, action: &Action) -> Option<Obstacle> {
        let kinds = kinds(&action.parameters);
        let empty = kinds.iter().find(|kind| !self.inhabited(**kind));
        empty
            .map(|kind| Obstacle::Empty(*kind))
            .or_else(|| self.obstacle(&action.precondition, &kinds))
    }

    /// Why the action at `index` can never apply, if it cannot.
    pub(super) fn action(&self, index: usize) -> Option<&Obstacle> {
        self.obstacles[index].as_ref()
    }

    /// Why an effect of an action never happens, if it does not.
    pub(super) fn to_effect(&self, action: &Action, index: usize) -> Option<Obstacle> {
        let effect = &action.effects[index];
        let mut kinds = kinds(&action.parameters);
        for (_, kind) in &effect.forall {
            if !self.inhabited(*kind) {
                return Some(Obstacle::Empty(*kind));
            }
            kinds.push(*kind);
        }
        let both = Condition::And(vec![action.precondition.clone(), effect.condition.clone()]);
        self.obstacle(&both, &kinds)
    }

    /// Whether a predicate can ever be true.
    pub(super) fn can_be_true(&self, predicate: PredicateId) -> bool {
        self.reached[predicate.index()]
    }

    /// Whether an entity can have the type.
    pub(super) fn inhabited(&self, kind: TypeId) -> bool {
        self.overlap(kind, kind)
    }

    /// Whether an entity can have both types.
    pub(super) fn overlap(&self, left: TypeId, right: TypeId) -> bool {
        let is_a = |kind: TypeId| self.domain.types.is_a(kind, left) && self.domain.types.is_a(kind, right);
        let environment = &self.domain.environment;
        is_a(environment.asset) || is_a(environment.object) || self.domain.constants.iter().any(|(_, kind)| is_a(*kind))
    }

    /// Why the condition can never hold, if it cannot; `kinds` are the types of the variables around it.
    pub(super) fn obstacle(&self, condition: &Condition, kinds: &[TypeId]) -> Option<Obstacle> {
        self.obstacle_beside(condition, kinds, &[])
    }

    /// The same where `known` holds as well.
    fn obstacle_beside(&self, condition: &Condition, kinds: &[TypeId], known: &[&Condition]) -> Option<Obstacle> {
        let mut parts = Vec::new();
        conjuncts(condition, &mut parts);
        let (own, compound): (Vec<&Condition>, Vec<&Condition>) = parts
            .into_iter()
            .partition(|part| matches!(part, Condition::Atom { .. } | Condition::Equal { .. }));
        for (index, literal) in own.iter().enumerate() {
            let obstacle = self.to_literal(literal, kinds);
            let beside = || known.iter().chain(&own[..index]).any(|other| opposite(literal, other));
            if obstacle.is_some() || beside() {
                return obstacle.or_else(|| contradiction(literal, false));
            }
        }
        let literals: Vec<&Condition> = known.iter().copied().chain(own).collect();
        compound
            .into_iter()
            .find_map(|part| self.to_compound(part, kinds, &literals))
    }

    fn to_compound(&self, part: &Condition, kinds: &[TypeId], literals: &[&Condition]) -> Option<Obstacle> {
        match part {
            Condition::Or(parts) => {
                let mut first = Some(Obstacle::Nothing);
                for (index, part) in parts.iter().enumerate() {
                    let obstacle = self.obstacle_beside(part, kinds, literals)?;
                    if index == 0 {
                        first = Some(obstacle);
                    }
                }
                first
            }
            Condition::Exists(slot, kind, inner) => {
                if !self.inhabited(*kind) {
                    return Some(Obstacle::Empty(*kind));
                }
                // Two quantifiers beside one another use the same slot for different variables.
                let outer: Vec<&Condition> = literals.iter().copied().filter(|l| speaks_below(l, *slot)).collect();
                let mut kinds = kinds[..*slot.min(&kinds.len())].to_vec();
                kinds.push(*kind);
                self.obstacle_beside(inner, &kinds, &outer)
            }
            Condition::Forall(..) => self.to_everything(part, kinds, literals),
            _ => None,
        }
    }

    /// `(forall (?x) (not (p ?x)))` beside `(p ?a)`. By itself a `forall` can always hold: there may be nothing that
    /// it speaks of.
    fn to_everything(&self, part: &Condition, kinds: &[TypeId], literals: &[&Condition]) -> Option<Obstacle> {
        let mut wild = Vec::new();
        let mut inner = part;
        while let Condition::Forall(slot, kind, next) = inner {
            wild.push((*slot, *kind));
            inner = next;
        }
        let lowest = wild.first()?.0;
        let mut parts = Vec::new();
        conjuncts(inner, &mut parts);
        let clashes = |general: &&Condition, literal: &&&Condition| {
            speaks_below(literal, lowest) && self.is_instance_of_opposite(literal, general, &wild, kinds)
        };
        parts
            .iter()
            .find_map(|general| literals.iter().find(|literal| clashes(general, literal)))
            .and_then(|literal| contradiction(literal, true))
    }

    fn is_instance_of_opposite(
        &self,
        literal: &Condition,
        general: &Condition,
        wild: &[(usize, TypeId)],
        kinds: &[TypeId],
    ) -> bool {
        let (Some((atom, holds, initially)), Some((pattern, pattern_holds, pattern_initially))) =
            (parts_of(literal), parts_of(general))
        else {
            return false;
        };
        if atom.predicate != pattern.predicate || holds == pattern_holds || initially != pattern_initially {
            return false;
        }
        let mut bound: Vec<(usize, Term)> = Vec::new();
        atom.terms.iter().zip(&pattern.terms).all(|(term, hole)| {
            let Term::Variable(slot) = *hole else {
                return term == hole;
            };
            let Some((_, kind)) = wild.iter().find(|(wild, _)| *wild == slot) else {
                return term == hole;
            };
            let earlier = bound.iter().find(|(known, _)| *known == slot).map(|(_, term)| *term);
            bound.push((slot, *term));
            earlier.is_none_or(|earlier| earlier == *term) && self.domain.types.is_a(self.kind_of(*term, kinds), *kind)
        })
    }

    fn to_literal(&self, literal: &Condition, kinds: &[TypeId]) -> Option<Obstacle> {
        match literal {
            Condition::Atom {
                atom,
                holds: true,
                initially,
            } => {
                if !self.can_be_true(atom.predicate) {
                    return Some(Obstacle::NeverTrue(atom.predicate));
                }
                if *initially && self.domain.words(atom.predicate).event {
                    return Some(Obstacle::NotYet(atom.predicate));
                }
                let parameters = &self.domain.predicate(atom.predicate).parameters;
                let mut pairs = atom.terms.iter().zip(parameters);
                let fits = pairs.all(|(term, parameter)| self.overlap(self.kind_of(*term, kinds), parameter.kind));
                (!fits).then(|| Obstacle::Mismatch(atom.clone()))
            }
            Condition::Equal { left, right, holds } => {
                let same = left == right;
                let constants = matches!((left, right), (Term::Constant(_), Term::Constant(_)));
                let possible = if *holds {
                    same || !constants && self.overlap(self.kind_of(*left, kinds), self.kind_of(*right, kinds))
                } else {
                    !same
                };
                (!possible).then_some(Obstacle::Equality {
                    left: *left,
                    right: *right,
                    holds: *holds,
                })
            }
            _ => None,
        }
    }

    fn kind_of(&self, term: Term, kinds: &[TypeId]) -> TypeId {
        let kind = match term {
            Term::Variable(slot) => kinds.get(slot).copied(),
            Term::Constant(entity) => self.domain.constants.get(entity.index()).map(|(_, kind)| *kind),
        };
        kind.unwrap_or(TypeId::OBJECT)
    }
}

/// The types of parameters.
pub(super) fn kinds(parameters: &[Parameter]) -> Vec<TypeId> {
    parameters.iter().map(|parameter| parameter.kind).collect()
}

/// The parts of a condition that all have to hold, through nested `and`s.
pub(super) fn conjuncts<'c>(condition: &'c Condition, parts: &mut Vec<&'c Condition>) {
    match condition {
        Condition::And(inner) => inner.iter().for_each(|part| conjuncts(part, parts)),
        part => parts.push(part),
    }
}

fn parts_of(literal: &Condition) -> Option<(&Atom, bool, bool)> {
    match literal {
        Condition::Atom { atom, holds, initially } => Some((atom, *holds, *initially)),
        _ => None,
    }
}

fn opposite(literal: &Condition, other: &Condition) -> bool {
    if let (Some((atom, holds, initially)), Some((same, opposite, then))) = (parts_of(literal), parts_of(other)) {
        return atom == same && holds != opposite && initially == then;
    }
    match (literal, other) {
        (
            Condition::Equal { left, right, holds },
            Condition::Equal {
                left: first,
                right: second,
                holds: opposite,
            },
        ) => holds != opposite && ((left, right) == (first, second) || (left, right) == (second, first)),
        _ => false,
    }
}

fn contradiction(literal: &Condition, forall: bool) -> Option<Obstacle> {
    match literal {
        Condition::Atom { atom, .. } => Some(Obstacle::Contradiction {
            atom: atom.clone(),
            forall,
        }),
        Condition::Equal { left, right, holds } => Some(Obstacle::Equality {
            left: *left,
            right: *right,
            holds: *holds,
        }),
        _ => None,
    }
}

/// Whether a literal has no variable at `slot` or beyond.
fn speaks_below(literal: &Condition, slot: usize) -> bool {
    let below = |term: &Term| !matches!(term, Term::Variable(own) if *own >= slot);
    match literal {
        Condition::Atom { atom, .. } => atom.terms.iter().all(below),
        Condition::Equal { left, right, .. } => below(left) && below(right),
        _ => false,
    }
}
