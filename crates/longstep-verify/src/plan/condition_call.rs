//! Resolution of conditions: each call in a condition is a sensing action or a state predicate.

use super::behavior_tree::{IS, OUTCOME, outcomes};
use super::resolve::Resolver;
use super::written::{WrittenStep, predicate_word};
use super::{StepId, Test, Violation, fuzzy_names};
use longstep_model::diagnostic::nearest;
use longstep_model::model::{
    Action, ActionId, Atom, Domain, EntityId, Fact, Parameter, PredicateId, StateWord, Term, ground,
};

/// Meaning of a call in a condition.
enum Meaning {
    Senses,
    /// A state predicate, as an atom with this number of arguments.
    Holds(Atom, usize),
    /// An action that is not a sensing action.
    Acts,
}

impl Meaning {
    fn of_predicate(domain: &Domain, index: usize) -> Self {
        let arity = domain.predicates[index].parameters.len();
        let atom = Atom {
            predicate: PredicateId::new(index),
            terms: (0..arity).map(Term::Variable).collect(),
        };
        Self::Holds(atom, arity)
    }
}

impl Resolver<'_> {
    /// Resolves one call of a condition. An unresolvable call takes a step number, so that findings can refer to it.
    pub(super) fn condition_call(&mut self, written: &WrittenStep) -> Test {
        let index = self.steps.len();
        let call = &written.call;
        match self.meaning(written) {
            Some(Meaning::Senses) => return self.sensing(written),
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

    /// Resolves the call of a sensing action. Without a word for the outcome, it asks for the first one.
    fn sensing(&mut self, written: &WrittenStep) -> Test {
        let asked = written.implicit.iter().position(|(name, _)| name == OUTCOME);
        let Some(asked) = asked.filter(|_| !self.has_parameter(written, OUTCOME)) else {
            return Test::Sense(self.add(written, None));
        };
        let mut written = written.clone();
        let (_, word) = written.implicit.remove(asked);
        let id = self.add(&written, None);
        let Some(step) = self.steps[id.index()].clone() else {
            return Test::Sense(id);
        };
        let action = self.domain.action(step.action);
        let arguments: Option<Vec<EntityId>> = step.arguments.into_iter().collect();
        let facts = arguments.map(|arguments| action.senses.iter().map(|atom| ground(atom, &arguments)).collect());
        let facts: Vec<Fact> = facts.unwrap_or_default();
        let words = outcomes(self.world, action, &facts);
        match words.iter().position(|other| *other == word) {
            Some(0) => Test::Sense(id),
            Some(1) if words.len() == 2 => Test::Not(Box::new(Test::Sense(id))),
            // It is known after the step, which is asked first.
            Some(index) if index < facts.len() => {
                Test::All(vec![Test::Not(Box::new(Test::Sense(id))), Test::Holds(facts[index])])
            }
            _ => {
                self.issues.push(Violation::UnknownCondition {
                    step: id.index(),
                    near: nearest(&word, words.iter().map(String::as_str)).map(str::to_owned),
                    name: word,
                });
                Test::Sense(id)
            }
        }
    }

    /// Returns true if the action of a call has a parameter with this name.
    fn has_parameter(&self, written: &WrittenStep, name: &str) -> bool {
        let mut actions = self
            .domain
            .actions
            .iter()
            .filter(|action| action.call == written.call.name);
        actions.any(|action| action.parameters.iter().any(|parameter| parameter.name == name))
    }

    /// Returns the predicate of a call whose arguments have names, with the leaf's name in a behavior tree or its own.
    fn named_predicate(&self, written: &WrittenStep) -> Option<usize> {
        if written.implicit.is_empty() || !written.call.arguments.is_empty() {
            return None;
        }
        let of_name = |name: &str| {
            let mut predicates = self.domain.predicates.iter();
            predicates.position(|predicate| predicate_word(&predicate.name) == name)
        };
        let name = &written.call.name;
        of_name(name).or_else(|| of_name(name.strip_prefix(IS)?))
    }

    fn meaning(&self, written: &WrittenStep) -> Option<Meaning> {
        let (name, count) = (&written.call.name, written.call.arguments.len());
        let domain: &Domain = self.domain;
        let named = |(_, action): &(ActionId, &Action)| action.call == *name;
        let exact = domain.action_ids().find(named);
        if exact.is_some_and(|(_, action)| !action.senses.is_empty()) {
            return Some(Meaning::Senses);
        }
        if let Some(index) = self.named_predicate(written) {
            return Some(Meaning::of_predicate(domain, index));
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
            return Some(Meaning::of_predicate(domain, index));
        }
        let near = fuzzy_names::action(domain, name, count)?;
        Some(if domain.action(near).senses.is_empty() {
            Meaning::Acts
        } else {
            Meaning::Senses
        })
    }

    /// Returns the arguments of a call of a state predicate in order. Names count where all arguments have one.
    fn in_order(
        &self,
        step: usize,
        written: &WrittenStep,
        atom: &Atom,
        arity: usize,
    ) -> Result<Vec<String>, Violation> {
        let Some((first, _)) = written.implicit.first() else {
            return Ok(written.call.arguments.clone());
        };
        let parameters = &self.domain.predicate(atom.predicate).parameters;
        let unknown = |name: &str| Violation::UnknownParameter {
            step,
            name: name.to_owned(),
            near: nearest(name, parameters.iter().map(|parameter| parameter.name.as_str())).map(str::to_owned),
        };
        if !written.call.arguments.is_empty() || arity != parameters.len() {
            return Err(unknown(first));
        }
        if let Some((name, _)) = written
            .implicit
            .iter()
            .find(|(name, _)| !parameters.iter().any(|parameter| parameter.name == *name))
        {
            return Err(unknown(name));
        }
        let named = |parameter: &Parameter| {
            let found = written.implicit.iter().find(|(name, _)| *name == parameter.name);
            found.map(|(_, value)| value.clone())
        };
        let names: Option<Vec<String>> = parameters.iter().map(named).collect();
        names.ok_or_else(|| Violation::WrongArguments {
            step,
            call: written.call.to_string(),
            expected: arity,
        })
    }

    /// Grounds the atom with the arguments of the call; the entity whose environment entry states the fact comes first.
    /// The call may omit its only argument if the plan handles a single object.
    fn fact(&mut self, step: usize, written: &WrittenStep, atom: &Atom, arity: usize) -> Option<Fact> {
        let names = match self.in_order(step, written, atom, arity) {
            Ok(names) => names,
            Err(issue) => {
                self.issues.push(issue);
                return None;
            }
        };
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
