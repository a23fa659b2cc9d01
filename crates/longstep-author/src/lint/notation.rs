//! Atoms of an action, goal or rule in the notation of PDDL, for messages.

use longstep::domain::{Atom, Domain, Parameter, Term};

/// Writes an atom with the names of its parameters: `(on ?box ?shelf)`.
pub(super) fn shown(domain: &Domain, atom: &Atom, parameters: &[Parameter]) -> String {
    let mut text = format!("({}", domain.predicate(atom.predicate).name);
    for term in &atom.terms {
        text.push(' ');
        text.push_str(&shown_term(domain, *term, parameters));
    }
    text + ")"
}

/// Writes a term: the name of a parameter or constant.
pub(super) fn shown_term(domain: &Domain, term: Term, parameters: &[Parameter]) -> String {
    match term {
        // The domain does not keep the names of quantified variables.
        Term::Variable(slot) => parameters
            .get(slot)
            .map_or_else(|| "?...".to_owned(), |parameter| format!("?{}", parameter.name)),
        Term::Constant(entity) => domain.constants[entity.index()].0.clone(),
    }
}
