//! Invariants: groups of facts of which at most one holds in any state.
//!
//! These are the invariants of Helmert, *Concise finite-domain representations for PDDL planning tasks* (2009): a group of
//! predicates, each with one argument or none that does not tell the facts of the group apart. At most one fact of the
//! group holds for given other arguments if that is so initially and no step changes it ([`exclusive`]).

use longstep_model::effort;
use longstep_model::model::{
    Action, Atom, Condition, Domain, Effect, EntityId, Fact, PredicateId, Slot, Term, TypeId, When, World,
};

/// Maximum number of predicates whose facts exclude each other.
// Each further member is tried in depth, so the size of groups bounds the search.
const GROUP: usize = 5;

/// Returns true if the actions allow only one of two facts at a time.
pub(super) fn are_exclusive(world: &World, fact: Fact, other: Fact) -> bool {
    let members = |fact: Fact| Member::all_of(fact.predicate(), world.domain().arguments(fact).count());
    let mut pairs = members(fact).flat_map(|first| members(other).map(move |second| (first, second)));
    fact != other && pairs.any(|(first, second)| are_of_one_group(world, (first, fact), (second, other)))
}

/// Returns true if two facts with these members belong to one group of facts of which at most one holds.
fn are_of_one_group(world: &World, (first, fact): (Member, Fact), (second, other): (Member, Fact)) -> bool {
    let domain = world.domain();
    let key = first.key_of(domain, fact);
    let mut group = vec![first];
    if first != second {
        group.push(second);
    }
    // Two members with one predicate would count each of its facts twice.
    let is_one = group.len() == 1 || first.predicate != second.predicate;
    is_one
        && second.key_of(domain, other) == key
        && exclusive(domain, group).is_some_and(|group| at_most_one(world, &group, &key))
}

/// A predicate in a group of facts that exclude each other. Facts with the same key belong to one group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Member {
    predicate: PredicateId,
    /// The argument that is not part of the key; none if all are.
    counted: Option<usize>,
}

impl Member {
    /// Returns the predicate with each argument as the counted one, and with none.
    fn all_of(predicate: PredicateId, arity: usize) -> impl Iterator<Item = Self> {
        let counted = (0..arity).map(Some).chain([None]);
        counted.map(move |counted| Self { predicate, counted })
    }

    /// Returns the values without the counted one.
    fn key<T>(self, values: impl Iterator<Item = T>) -> Vec<T> {
        let others = values.enumerate().filter(|(place, _)| Some(*place) != self.counted);
        others.map(|(_, value)| value).collect()
    }

    fn key_of(self, domain: &Domain, fact: Fact) -> Vec<EntityId> {
        self.key(domain.arguments(fact))
    }

    fn key_terms(self, atom: &Atom) -> Vec<Term> {
        self.key(atom.terms.iter().copied())
    }
}

/// Returns true if at most one fact of the group with this key holds in the initial state, and has the declared types.
fn at_most_one(world: &World, group: &[Member], key: &[EntityId]) -> bool {
    let domain = world.domain();
    let facts = group.iter().flat_map(|member| {
        let facts = world.state.of_predicate(member.predicate).iter();
        facts.filter(|fact| member.key_of(domain, **fact) == key)
    });
    let facts: Vec<&Fact> = facts.collect();
    facts.len() <= 1 && facts.iter().all(|fact| is_typed(world, **fact))
}

/// Returns true if the arguments of a fact have the declared types. The actions are analyzed by these types, which facts of a
/// foreign problem may lack.
fn is_typed(world: &World, fact: Fact) -> bool {
    let domain = world.domain();
    let parameters = &domain.predicate(fact.predicate()).parameters;
    let mut arguments = domain.arguments(fact).zip(parameters);
    arguments.all(|(argument, parameter)| world.is_of_kind(argument, parameter.kind))
}

/// Returns a group for which no step adds a fact while another one with the same key holds; it begins with `group`. None if
/// there is no such group, or only a larger one.
fn exclusive(domain: &Domain, group: Vec<Member>) -> Option<Vec<Member>> {
    if group.len() > GROUP || !effort::spend(domain.actions.len()) {
        return None;
    }
    for action in &domain.actions {
        let step = Step {
            domain,
            action,
            group: &group,
        };
        if !step.senses_one() {
            return None;
        }
        let adds: Vec<Addition<'_>> = step.additions().collect();
        for (index, own) in adds.iter().enumerate() {
            if adds[..index].iter().any(|other| step.may_add_both(own, other)) || !own.is_single(action) {
                return None;
            }
            if step.held_before(own) || step.is_exchanged(own) || step.is_alone(own) {
                continue;
            }
            // What the action deletes instead may belong to the group.
            let mut larger = step.deleted_with(own);
            return larger.find_map(|member| exclusive(domain, group.iter().copied().chain([member]).collect()));
        }
    }
    Some(group)
}

/// An effect that adds a fact of a group.
struct Addition<'a> {
    effect: &'a Effect,
    member: Member,
    key: Vec<Term>,
}

impl Addition<'_> {
    /// Returns true if one step adds one fact for each key: no quantified variable is counted.
    fn is_single(&self, action: &Action) -> bool {
        let counted = self.member.counted.map(|place| self.effect.atom.terms[place]);
        !matches!(counted, Some(Term::Variable(slot)) if slot >= action.parameters.len())
    }
}

/// The steps of an action, and a group.
struct Step<'a> {
    domain: &'a Domain,
    action: &'a Action,
    group: &'a [Member],
}

impl<'a> Step<'a> {
    /// Returns the effects that add facts of the group.
    fn additions(&self) -> impl Iterator<Item = Addition<'a>> {
        let group = self.group;
        let adds = self.action.effects.iter().filter(|effect| effect.adds);
        adds.flat_map(move |effect| {
            let members = group.iter().filter(|member| member.predicate == effect.atom.predicate);
            members.map(|member| Addition {
                effect,
                member: *member,
                key: member.key_terms(&effect.atom),
            })
        })
    }

    /// Returns true if sensing reveals no fact of the group, or one of them where none was known.
    fn senses_one(&self) -> bool {
        let first = self
            .group
            .iter()
            .find_map(|member| Some((member, self.sensed(member).next()?)));
        let Some((first, atom)) = first else {
            return true;
        };
        let key = first.key_terms(atom);
        let reveals = |member: &Member| self.sensed(member).any(|atom| member.key_terms(atom) == key);
        self.group
            .iter()
            .all(|member| member.counted.is_none() && reveals(member))
    }

    /// Returns the outcomes of sensing with the predicate of a member.
    fn sensed(&self, member: &Member) -> impl Iterator<Item = &'a Atom> + use<'a> {
        let predicate = member.predicate;
        self.action
            .senses
            .iter()
            .filter(move |atom| atom.predicate == predicate)
    }

    /// Returns the conjuncts that hold before the step where the effect fires.
    fn given(&self, effect: &'a Effect) -> impl Iterator<Item = &'a Condition> {
        self.action.precondition.conjuncts().chain(effect.condition.conjuncts())
    }

    /// Returns true if the step requires the fact that it adds.
    fn held_before(&self, own: &Addition<'a>) -> bool {
        self.given(own.effect)
            .any(|part| is_literal(part, &own.effect.atom, true))
    }

    /// Returns true if the step requires another fact of the group, and deletes it.
    fn is_exchanged(&self, own: &Addition<'a>) -> bool {
        self.given(own.effect).any(|part| match part {
            Condition::Atom {
                atom,
                holds: true,
                at: When::Now,
            } => {
                let mut members = self.group.iter().filter(|member| member.predicate == atom.predicate);
                members.any(|member| member.key_terms(atom) == own.key)
                    && self.deletes(own, &atom.terms, atom.predicate)
            }
            _ => false,
        })
    }

    /// Returns true if no other fact of the group can hold after the step: each is deleted, or excluded by a condition.
    fn is_alone(&self, own: &Addition<'a>) -> bool {
        self.group.iter().all(|member| {
            let mut key = own.key.iter().copied();
            let arity = self.domain.predicate(member.predicate).parameters.len();
            let terms: Option<Vec<Term>> = (0..arity)
                .map(|place| {
                    if Some(place) == member.counted {
                        Some(Term::Variable(ANY))
                    } else {
                        key.next()
                    }
                })
                .collect();
            let Some(terms) = terms.filter(|_| key.next().is_none()) else {
                return false;
            };
            let is_added = member.predicate == own.effect.atom.predicate && terms == own.effect.atom.terms;
            is_added || self.deletes(own, &terms, member.predicate) || self.is_absent(own, &terms, member.predicate)
        })
    }

    /// Returns true if a condition says that no such fact holds; [`ANY`] stands for every entity.
    fn is_absent(&self, own: &Addition<'a>, terms: &[Term], predicate: PredicateId) -> bool {
        self.given(own.effect).any(|part| {
            let (all, part) = match part {
                Condition::Forall(slot, kind, inner) => (Some((*slot, *kind)), &**inner),
                other => (None, other),
            };
            let Condition::Atom {
                atom,
                holds: false,
                at: When::Now,
            } = part
            else {
                return false;
            };
            let mut bound = None;
            let mut places = atom.terms.iter().zip(terms).enumerate();
            atom.predicate == predicate
                && places.all(|(place, (term, wanted))| match all {
                    Some((slot, kind)) if *term == Term::Variable(slot) => {
                        *bound.get_or_insert(*wanted) == *wanted
                            && self.domain.types.is_a(self.kind(*wanted, predicate, place, own), kind)
                    }
                    _ => term == wanted,
                })
        })
    }

    /// Returns true if the step deletes the fact with these terms whenever the addition fires; [`ANY`] stands for every
    /// entity.
    fn deletes(&self, own: &Addition<'a>, terms: &[Term], predicate: PredicateId) -> bool {
        let mut deletions = self.action.effects.iter().filter(|effect| !effect.adds);
        deletions.any(|deletion| deletion.atom.predicate == predicate && self.fires_for(deletion, terms, own))
    }

    /// Returns true if a deletion fires for these terms whenever the addition does.
    fn fires_for(&self, deletion: &Effect, terms: &[Term], own: &Addition<'a>) -> bool {
        let parameters = self.action.parameters.len();
        let mut bound: Vec<Option<Term>> = vec![None; deletion.forall.len()];
        for (place, (term, wanted)) in deletion.atom.terms.iter().zip(terms).enumerate() {
            let fits = match *term {
                Term::Variable(slot) if slot >= parameters => {
                    let Some((_, all)) = deletion.forall.get(slot - parameters) else {
                        return false;
                    };
                    let kind = self.kind(*wanted, deletion.atom.predicate, place, own);
                    let known = &mut bound[slot - parameters];
                    let is_new = known.is_none() || *known == Some(*wanted);
                    *known = Some(*wanted);
                    is_new && self.domain.types.is_a(kind, *all)
                }
                term => term == *wanted,
            };
            if !fits {
                return false;
            }
        }
        let term = |term: Term| self.bound_term(term, &bound);
        deletion.condition.conjuncts().all(|part| match part {
            Condition::Atom {
                atom,
                holds,
                at: When::Now,
            } => {
                let bound: Option<Vec<Term>> = atom.terms.iter().map(|own| term(*own)).collect();
                let atom = bound.map(|terms| Atom { terms, ..*atom });
                atom.is_some_and(|atom| {
                    // It deletes what holds.
                    let is_itself = *holds && atom.predicate == deletion.atom.predicate && atom.terms == terms;
                    is_itself || self.given(own.effect).any(|given| is_literal(given, &atom, *holds))
                })
            }
            // It deletes all but the added fact.
            Condition::Equal {
                left,
                right,
                holds: false,
            } => {
                let added = own.member.counted.map(|place| own.effect.atom.terms[place]);
                let sides = [term(*left), term(*right)];
                deletion.atom.predicate == own.effect.atom.predicate
                    && sides.contains(&Some(Term::Variable(ANY)))
                    && sides.contains(&added)
            }
            other => self
                .given(own.effect)
                .any(|given| given == other && deletion.forall.is_empty()),
        })
    }

    /// Returns a term with a quantified variable replaced by what it is bound to; none for one that is not bound.
    fn bound_term(&self, term: Term, bound: &[Option<Term>]) -> Option<Term> {
        let parameters = self.action.parameters.len();
        match term {
            Term::Variable(slot) if slot >= parameters => bound.get(slot - parameters).copied().flatten(),
            term => Some(term),
        }
    }

    /// Returns the type of a term in a place of a predicate.
    fn kind(&self, term: Term, predicate: PredicateId, place: usize, own: &Addition<'a>) -> TypeId {
        let parameters = &self.action.parameters;
        match term {
            Term::Variable(slot) if slot < parameters.len() => parameters[slot].kind,
            Term::Variable(slot) if slot != ANY => {
                let quantified = own.effect.forall.get(slot - parameters.len());
                quantified.map_or(TypeId::OBJECT, |(_, kind)| *kind)
            }
            _ => self.domain.predicate(predicate).parameters[place].kind,
        }
    }

    /// Returns true if the step may add two different facts with the same key.
    fn may_add_both(&self, one: &Addition<'a>, other: &Addition<'a>) -> bool {
        if one.effect.atom == other.effect.atom {
            return false;
        }
        let mut keys = one.key.iter().zip(&other.key);
        if keys.any(|(left, right)| self.are_different(left, right)) {
            return false;
        }
        // Two effects with the same key, one of which fires where a fact holds and the other one where it does not.
        let mut conditions = one.effect.condition.conjuncts();
        let exclude_each_other = conditions.any(|part| match part {
            Condition::Atom {
                atom,
                holds,
                at: When::Now,
            } => {
                let mut others = other.effect.condition.conjuncts();
                others.any(|part| is_literal(part, atom, !holds)) && self.is_fixed(atom, &one.key)
            }
            _ => false,
        });
        one.key != other.key || !exclude_each_other
    }

    /// Returns true if two terms of the action never are the same entity.
    fn are_different(&self, left: &Term, right: &Term) -> bool {
        match (left, right) {
            (Term::Constant(left), Term::Constant(right)) => left != right,
            _ if self.are_disjoint(left, right) => true,
            _ => self.action.precondition.conjuncts().any(|part| match part {
                Condition::Equal {
                    left: own,
                    right: second,
                    holds: false,
                } => (own, second) == (left, right) || (own, second) == (right, left),
                _ => false,
            }),
        }
    }

    /// Returns true if two terms are parameters whose types have no entity in common.
    fn are_disjoint(&self, left: &Term, right: &Term) -> bool {
        let types = &self.domain.types;
        let (Some(left), Some(right)) = (self.parameter_type(left), self.parameter_type(right)) else {
            return false;
        };
        !types.is_a(left, right) && !types.is_a(right, left)
    }

    fn parameter_type(&self, term: &Term) -> Option<TypeId> {
        match term {
            Term::Variable(slot) => self.action.parameters.get(*slot).map(|own| own.kind),
            Term::Constant(_) => None,
        }
    }

    /// Returns true if parameters and the key determine the terms of an atom.
    fn is_fixed(&self, atom: &Atom, key: &[Term]) -> bool {
        atom.terms.iter().all(|term| match term {
            Term::Variable(slot) => *slot < self.action.parameters.len() || key.contains(term),
            Term::Constant(_) => true,
        })
    }

    /// Returns the members that are not in the group and that the action deletes with the key of an addition.
    fn deleted_with(&self, own: &Addition<'a>) -> impl Iterator<Item = Member> {
        let deletions = self.action.effects.iter().filter(|effect| !effect.adds);
        let members = deletions.flat_map(move |effect| {
            let members = Member::all_of(effect.atom.predicate, effect.atom.terms.len());
            members.filter(|member| member.key_terms(&effect.atom) == own.key)
        });
        members.filter(|member| self.group.iter().all(|known| known.predicate != member.predicate))
    }
}

/// The variable that stands for every entity.
const ANY: Slot = Slot::MAX;

/// Returns true if a condition is an atom of the current state, or its negation.
fn is_literal(part: &Condition, atom: &Atom, holds: bool) -> bool {
    match part {
        Condition::Atom {
            atom: own,
            holds: sign,
            at: When::Now,
        } => own == atom && *sign == holds,
        _ => false,
    }
}
