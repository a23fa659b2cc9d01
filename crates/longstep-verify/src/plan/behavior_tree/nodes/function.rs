//! Functions of a robot: one for each leaf that a plan of a domain can have.

use std::collections::BTreeSet;

use super::identifier::Scope;
use crate::plan::behavior_tree::name::{LeafNames, outcome_stems, port};
use crate::plan::behavior_tree::write::{NUMBERS, TEST};
use longstep_model::model::{Action, ActionId, Condition, Domain, Parameter, PredicateId, Term};

/// The functions of a domain.
pub(super) struct Functions {
    /// The name of the domain.
    pub(super) domain: String,
    /// The name of the domain as a namespace.
    pub(super) namespace: String,
    /// The description of the domain.
    pub(super) about: String,
    pub(super) actions: Vec<Function>,
    pub(super) conditions: Vec<Function>,
}

/// A function for a leaf.
pub(super) struct Function {
    /// The name of the leaf.
    pub(super) leaf: String,
    /// The name of the function.
    pub(super) name: String,
    /// A sentence about it.
    pub(super) about: String,
    pub(super) arguments: Vec<Argument>,
    /// The result of a sensing action.
    pub(super) outcomes: Option<Outcomes>,
    /// True if a plan needs the function rarely: a condition on facts that no action changes, or that record an event.
    pub(super) is_rare: bool,
}

/// An argument of a function.
pub(super) struct Argument {
    pub(super) name: String,
    /// The port of the leaf.
    pub(super) port: String,
}

/// The outcomes of a sensing action.
pub(super) struct Outcomes {
    /// The name of their type.
    pub(super) name: String,
    pub(super) values: Vec<Outcome>,
}

/// An outcome of a sensing action.
pub(super) struct Outcome {
    pub(super) name: String,
    /// The sentence that is true then.
    pub(super) about: String,
    /// The word in the tree, in parts: more than one if the outcomes differ in their entities alone.
    pub(super) word: Vec<WordPart>,
}

/// A part of the word for an outcome.
pub(super) enum WordPart {
    Text(String),
    /// The entity that the argument of this index names.
    Argument(usize),
}

impl Function {
    /// Returns the type of an action's result.
    pub(super) fn result(&self) -> &str {
        self.outcomes.as_ref().map_or("Done", |outcomes| &outcomes.name)
    }
}

impl Outcomes {
    /// Returns true if a word depends on the arguments of the step.
    pub(super) fn depend_on_arguments(&self) -> bool {
        self.values.iter().any(|value| value.word.len() > 1)
    }
}

impl Functions {
    pub(super) fn of(domain: &Domain) -> Self {
        let leaves = LeafNames::of(domain);
        let mut scope = Scope::default();
        let namespace = Scope::default().identifier(&domain.name);
        let actions: Vec<Function> = domain
            .action_ids()
            .map(|(id, action)| action_function(domain, id, action, &leaves, &mut scope))
            .collect();
        let guarded = guarded(domain);
        let ids = (0..domain.predicates.len()).map(PredicateId::new);
        let mut conditions: Vec<Function> = ids
            .map(|id| condition_function(domain, id, guarded.contains(&id), &leaves, &mut scope))
            .collect();
        if has_numbers(domain) {
            conditions.push(Function {
                leaf: NUMBERS.to_owned(),
                name: scope.identifier(NUMBERS),
                about: "Returns true if a requirement on numbers holds, a sentence.".to_owned(),
                arguments: vec![Argument {
                    name: TEST.to_owned(),
                    port: TEST.to_owned(),
                }],
                outcomes: None,
                is_rare: false,
            });
        }
        Self {
            domain: domain.name.clone(),
            namespace,
            about: domain.about.clone(),
            actions,
            conditions,
        }
    }
}

fn action_function(domain: &Domain, id: ActionId, action: &Action, leaves: &LeafNames, scope: &mut Scope) -> Function {
    let name = scope.identifier(&action.call);
    let outcomes =
        (!action.senses.is_empty()).then(|| outcomes(domain, action, scope.identifier(&format!("{name}_outcome"))));
    Function {
        leaf: leaves.action(id).to_owned(),
        name,
        about: if action.means.trim().is_empty() {
            action.says.fill(|index| in_braces(&action.parameters[index]))
        } else {
            action.means.clone()
        },
        arguments: arguments(&action.parameters),
        outcomes,
        is_rare: false,
    }
}

fn condition_function(
    domain: &Domain,
    id: PredicateId,
    is_guarded: bool,
    leaves: &LeafNames,
    scope: &mut Scope,
) -> Function {
    let (predicate, words) = (domain.predicate(id), domain.words(id));
    let sentence = words.says.fill(|index| in_braces(&predicate.parameters[index]));
    Function {
        leaf: leaves.predicate(id).to_owned(),
        name: scope.identifier(leaves.predicate(id)),
        about: format!("Returns true if {sentence}."),
        arguments: arguments(&predicate.parameters),
        outcomes: None,
        is_rare: !is_guarded && (!words.fluent || words.event),
    }
}

fn arguments(parameters: &[Parameter]) -> Vec<Argument> {
    let mut scope = Scope::default();
    let argument = |parameter: &Parameter| Argument {
        name: scope.identifier(&parameter.name),
        port: port(&parameter.name),
    };
    parameters.iter().map(argument).collect()
}

fn outcomes(domain: &Domain, action: &Action, name: String) -> Outcomes {
    let mut scope = Scope::default();
    let stems = outcome_stems(domain, action);
    let value = |(atom, stem): (&longstep_model::model::Atom, String)| {
        let is_shared = action
            .senses
            .iter()
            .filter(|other| other.predicate == atom.predicate)
            .count()
            > 1;
        let mut word = vec![WordPart::Text(stem.clone())];
        let mut own = stem;
        let terms = if is_shared { &atom.terms[..] } else { &[] };
        for term in terms {
            let (part, text) = match *term {
                Term::Variable(slot) => (WordPart::Argument(slot), &action.parameters[slot].name),
                Term::Constant(entity) => {
                    let constant = &domain.constants[entity.index()].0;
                    (WordPart::Text(constant.clone()), constant)
                }
            };
            word.push(part);
            own.push('_');
            own.push_str(text);
        }
        let says = &domain.words(atom.predicate).says;
        let about = says.fill(|index| match atom.terms[index] {
            Term::Variable(slot) => in_braces(&action.parameters[slot]),
            Term::Constant(entity) => domain.constants[entity.index()].0.clone(),
        });
        Outcome {
            name: scope.identifier(&own),
            about,
            word,
        }
    };
    Outcomes {
        name,
        values: action.senses.iter().zip(stems).map(value).collect(),
    }
}

fn in_braces(parameter: &Parameter) -> String {
    format!("`{}`", parameter.name)
}

/// Returns the predicates of preconditions that change, which guards ask.
fn guarded(domain: &Domain) -> BTreeSet<PredicateId> {
    let atoms = domain.actions.iter().flat_map(|action| action.precondition.atoms());
    let changing = atoms.filter(|(atom, _)| domain.words(atom.predicate).fluent);
    changing.map(|(atom, _)| atom.predicate).collect()
}

fn has_numbers(domain: &Domain) -> bool {
    let mut preconditions = domain.actions.iter().map(|action| &action.precondition);
    preconditions.any(|condition: &Condition| condition.numbers().next().is_some())
}
