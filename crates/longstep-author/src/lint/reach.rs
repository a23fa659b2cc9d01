//! Reachability analysis of a domain, independent of the environment.
//!
//! The analysis abstracts from arguments: a predicate that can be true for some entities can be true for all that fit
//! its types, and every fact can be false. It is sound for impossibility: what it rejects is impossible, but some of
//! what it accepts is impossible too.

use longstep::domain::{Action, Atom, Condition, Domain, Literal, Parameter, PredicateId, Term, TypeId, Unknown, When};

/// Reason why a condition can never hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Obstacle {
    /// Nothing makes the predicate true.
    NeverTrue(PredicateId),
    /// The predicate is an event, and the condition reads it in the initial state.
    NotYet(PredicateId),
    /// The condition requires the atom and its negation; with `forall`, one of the two for all entities.
    Contradiction { atom: Atom, forall: bool },
    /// Two terms that cannot be equal, or a term that would have to differ from itself.
    Equality { left: Term, right: Term, holds: bool },
    /// No entity has the type.
    Empty(TypeId),
    /// No entity has both the type of a term and that of its parameter.
    Mismatch(Atom),
    /// An `or` without alternatives.
    Nothing,
}

/// The predicates and actions that a domain can reach.
pub(super) struct Reach<'a> {
    domain: &'a Domain,
    /// For each predicate, true if it can ever be true.
    reached: Vec<bool>,
    /// For each action, the reason why it is never applicable.
    obstacles: Vec<Option<Obstacle>>,
}

impl<'a> Reach<'a> {
    /// Computes the fixpoint of facts from environments and effects of applicable actions.
    pub(super) fn of(domain: &'a Domain) -> Self {
        let mut reach = Self {
            domain,
            reached: vec![false; domain.predicates.len()],
            obstacles: vec![None; domain.actions.len()],
        };
        loop {
            let more: Vec<PredicateId> = reach.initial().into_iter().chain(reach.done()).collect();
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

    /// Returns the predicates that an environment can state or imply.
    fn initial(&self) -> Vec<PredicateId> {
        let domain = self.domain;
        let any = [TypeId::OBJECT, TypeId::OBJECT];
        let can_hold = |when: &Condition| self.obstacle(when, &any).is_none();
        let mut initial: Vec<PredicateId> = domain.states.iter().map(|state| state.atom.predicate).collect();
        let mut add = |literals: &[Literal]| {
            let holding = literals.iter().filter(|literal| literal.holds);
            initial.extend(holding.map(|literal| literal.atom.predicate));
        };
        domain.properties.iter().for_each(|property| add(&property.literals));
        for derivation in domain
            .derivations
            .iter()
            .filter(|derivation| can_hold(&derivation.when))
        {
            add(&derivation.literals);
        }
        for default in domain.defaults.iter().filter(|default| can_hold(&default.when)) {
            initial.push(default.atom.predicate);
        }
        for (index, words) in domain.predicate_words.iter().enumerate() {
            if words.unknown == Unknown::Assume {
                initial.push(PredicateId::new(index));
            }
        }
        initial
    }

    /// Returns the predicates that actions can make true or sense.
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

    /// Returns the reason why the action at `index` is never applicable, if any.
    pub(super) fn action(&self, index: usize) -> Option<&Obstacle> {
        self.obstacles[index].as_ref()
    }

    /// Returns the reason why an effect never happens, if any.
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

    /// Returns true if a predicate can ever be true.
    pub(super) fn can_be_true(&self, predicate: PredicateId) -> bool {
        self.reached[predicate.index()]
    }

    /// Returns true if an entity can have the type.
    pub(super) fn inhabited(&self, kind: TypeId) -> bool {
        self.overlap(kind, kind)
    }

    /// Returns true if an entity can have both types.
    pub(super) fn overlap(&self, left: TypeId, right: TypeId) -> bool {
        let types = &self.domain.types;
        // Types are a tree: what has both types has the lower one.
        let lower = if types.is_a(left, right) { left } else { right };
        if !types.is_a(lower, left) {
            return false;
        }
        let is_a = |kind: TypeId| types.is_a(kind, lower);
        let environment = &self.domain.environment;
        // The `types` of an environment may name any type below that of a list.
        if types.is_a(lower, environment.asset) || types.is_a(lower, environment.object) {
            return true;
        }
        let mut constants = self.domain.constants.iter().map(|(_, kind)| *kind);
        let mut values = self.domain.values.iter().map(|own| own.kind);
        is_a(environment.asset) || is_a(environment.object) || constants.any(is_a) || values.any(is_a)
    }

    /// Returns the reason why the condition can never hold, if any. `kinds` are the types of the enclosing variables.
    pub(super) fn obstacle(&self, condition: &Condition, kinds: &[TypeId]) -> Option<Obstacle> {
        self.obstacle_beside(condition, kinds, &[])
    }

    /// Finds the obstacle to a condition, given the conditions in `known`.
    fn obstacle_beside(&self, condition: &Condition, kinds: &[TypeId], known: &[&Condition]) -> Option<Obstacle> {
        let (own, compound): (Vec<&Condition>, Vec<&Condition>) = condition
            .conjuncts()
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
                // Adjacent quantifiers reuse a slot for different variables.
                let outer: Vec<&Condition> = literals.iter().copied().filter(|l| speaks_below(l, *slot)).collect();
                let mut kinds = kinds[..*slot.min(&kinds.len())].to_vec();
                kinds.push(*kind);
                self.obstacle_beside(inner, &kinds, &outer)
            }
            Condition::Forall(..) => self.to_everything(part, kinds, literals),
            _ => None,
        }
    }

    /// Finds a clash such as `(forall (?x) (not (p ?x)))` beside `(p ?a)`. A `forall` alone can always hold, since its
    /// type may have no entities.
    fn to_everything(&self, part: &Condition, kinds: &[TypeId], literals: &[&Condition]) -> Option<Obstacle> {
        let mut wild = Vec::new();
        let mut inner = part;
        while let Condition::Forall(slot, kind, next) = inner {
            wild.push((*slot, *kind));
            inner = next;
        }
        let lowest = wild.first()?.0;
        let clashes = |general: &Condition, literal: &&&Condition| {
            speaks_below(literal, lowest) && self.is_instance_of_opposite(literal, general, &wild, kinds)
        };
        inner
            .conjuncts()
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
        let (Some((atom, holds, at)), Some((pattern, pattern_holds, pattern_at))) =
            (parts_of(literal), parts_of(general))
        else {
            return false;
        };
        if atom.predicate != pattern.predicate || holds == pattern_holds || at != pattern_at {
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
            Condition::Atom { atom, holds: true, at } => {
                if !self.can_be_true(atom.predicate) {
                    return Some(Obstacle::NeverTrue(atom.predicate));
                }
                if *at != When::Now && self.domain.words(atom.predicate).event {
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

/// Returns the types of parameters.
pub(super) fn kinds(parameters: &[Parameter]) -> Vec<TypeId> {
    parameters.iter().map(|parameter| parameter.kind).collect()
}

fn parts_of(literal: &Condition) -> Option<(&Atom, bool, When)> {
    match literal {
        Condition::Atom { atom, holds, at } => Some((atom, *holds, *at)),
        _ => None,
    }
}

fn opposite(literal: &Condition, other: &Condition) -> bool {
    if let (Some((atom, holds, at)), Some((same, opposite, then))) = (parts_of(literal), parts_of(other)) {
        return atom == same && holds != opposite && at == then;
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

/// Returns true if a literal has no variable at `slot` or above.
fn speaks_below(literal: &Condition, slot: usize) -> bool {
    let below = |term: &Term| !matches!(term, Term::Variable(own) if *own >= slot);
    match literal {
        Condition::Atom { atom, .. } => atom.terms.iter().all(below),
        Condition::Equal { left, right, .. } => below(left) && below(right),
        _ => false,
    }
}
