//! Resolution of conditions: each call in a condition is a sensing action or a state predicate.

use super::resolve::Resolver;
use super::written::{WrittenStep, predicate_word};
use super::{StepId, Test, Violation, fuzzy_names};
use longstep_model::diagnostic::nearest;
use longstep_model::model::{Action, ActionId, Atom, Domain, EntityId, Fact, PredicateId, StateWord, Term, ground};

/// Meaning of a call in a condition.
enum Meaning {
    Senses,
    /// A state predicate, as an atom with this number of arguments.
    Holds(Atom, usize),
    /// An action that is not a sensing action.
    Acts,
}

impl Resolver<'_> {
    /// Resolves one call of a condition. An unresolvable call takes a step number, so that findings can refer to it.
    pub(super) fn condition_call(&mut self, written: &WrittenStep) -> Test {
        let index = self.steps.len();
        let call = &written.call;
        match self.meaning(written) {
            Some(Meaning::Senses) => return Test::Sense(self.add(written, None)),
            Some(Meaning::Holds(atom, arity)) => {
                if let Some(fact) = self.fact(index, written, &atom, arity) {
                    return Test::Holds(fact);
                }
            }
            Some(Meaning::Acts) => {
                let senses = self.domain.actions.iter().filter(|action| !action.senses.is_empty());
                let senses = senses.map(|action| format!("`{}`", shown(action))).collect();
                self.issues.push(Violation::NotSensing {
                    step: index,
                    call: call.to_string(),
                    senses,
                });
            }
            None => {
                let actions = self.domain.actions.iter().filter(|action| !action.senses.is_empty());
                let states = self.domain.states.iter().map(|state| state.word.as_str());
                let known = actions.map(|action| action.call.as_str()).chain(states);
                self.issues.push(Violation::UnknownCondition {
                    step: index,
                    name: call.name.clone(),
                    near: nearest(&call.name, known).map(str::to_owned),
                });
            }
        }
        self.written.push(call.to_string());
        self.steps.push(None);
        Test::Sense(StepId::new(index))
    }

    fn meaning(&self, written: &WrittenStep) -> Option<Meaning> {
        let (name, count) = (&written.call.name, written.call.arguments.len());
        let domain: &Domain = self.domain;
        let named = |(_, action): &(ActionId, &Action)| action.call == *name;
        let exact = domain.action_ids().find(named);
        if exact.is_some_and(|(_, action)| !action.senses.is_empty()) {
            return Some(Meaning::Senses);
        }
        let arity = |state: &StateWord| state.parameters.len() + 1;
        let words = || domain.states.iter().filter(|state| state.word == *name);
        let word = words().find(|state| arity(state) == count).or_else(|| words().next());
        if let Some(word) = word {
            return Some(Meaning::Holds(word.atom.clone(), arity(word)));
        }
        if exact.is_some() {
            return Some(Meaning::Acts);
        }
        let predicate = domain
            .predicates
            .iter()
            .position(|predicate| predicate_word(&predicate.name) == *name);
        if let Some(index) = predicate {
            let arity = domain.predicates[index].parameters.len();
            let atom = Atom {
                predicate: PredicateId::new(index),
                terms: (0..arity).map(Term::Variable).collect(),
            };
            return Some(Meaning::Holds(atom, arity));
        }
        let near = fuzzy_names::action(domain, name, count)?;
        Some(if domain.action(near).senses.is_empty() {
            Meaning::Acts
        } else {
            Meaning::Senses
        })
    }

    /// Grounds the atom with the arguments of the call; the entity whose environment entry states the fact comes first.
    /// The call may omit its only argument if the plan handles a single object.
    fn fact(&mut self, step: usize, written: &WrittenStep, atom: &Atom, arity: usize) -> Option<Fact> {
        let names = &written.call.arguments;
        if let Some((name, _)) = written.implicit.first() {
            let (name, near) = (name.clone(), None);
            self.issues.push(Violation::UnknownParameter { step, name, near });
            return None;
        }
        let bindings: Vec<EntityId> = match (names.as_slice(), self.objects.as_slice()) {
            ([], [only]) if arity == 1 => vec![*only],
            _ if names.len() != arity => {
                let (call, expected) = (written.call.to_string(), arity);
                self.issues.push(Violation::WrongArguments { step, call, expected });
                return None;
            }
            _ => {
                let found: Vec<_> = names.iter().map(|name| self.entity(Some(step), name)).collect();
                found.into_iter().collect::<Option<_>>()?
            }
        };
        let kinds = &self.domain.predicate(atom.predicate).parameters;
        for (term, parameter) in atom.terms.iter().zip(kinds) {
            let Term::Variable(slot) = term else { continue };
            if !self.world.is_of_kind(bindings[*slot], parameter.kind) {
                self.issues.push(Violation::WrongType {
                    step,
                    name: self.world.entity(bindings[*slot]).identifier.clone(),
                    expected: self.domain.types.name(parameter.kind).to_owned(),
                });
                return None;
            }
        }
        Some(ground(atom, &bindings))
    }
}

/// Signature of an action, for messages.
fn shown(action: &Action) -> String {
    let names: Vec<&str> = action
        .explicit
        .iter()
        .map(|at| action.parameters[*at].name.as_str())
        .collect();
    format!("{}({})", action.call, names.join(", "))
}
