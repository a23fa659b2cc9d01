//! Lints about facts that nothing reads and types that nothing uses.

use super::places::Places;
use super::{Finding, Lint, quoted};
use longstep::domain::{Action, Condition, Domain, Effect, Parameter, PredicateId, TypeId, Unknown};

/// Readers of each predicate, by predicate.
pub(super) struct Reads {
    /// Read by a condition: of an action, effect, goal, rule, derivation or default.
    pub(super) tested: Vec<bool>,
    /// Shown to a model or a person: in the scene, or in the environment after a plan.
    shown: Vec<bool>,
}

impl Reads {
    pub(super) fn of(domain: &Domain) -> Self {
        let mut tested = vec![false; domain.predicates.len()];
        for_each_condition(domain, &mut |condition| {
            condition
                .atoms()
                .for_each(|(atom, _)| tested[atom.predicate.index()] = true);
        });
        let mut shown: Vec<bool> = domain
            .predicate_words
            .iter()
            .map(|words| words.short.is_some())
            .collect();
        for state in &domain.states {
            shown[state.atom.predicate.index()] = true;
        }
        // A goal with a condition also reads the event that its fact held.
        for words in &domain.predicate_words {
            if let Some(past) = words.past {
                tested[past.index()] = true;
            }
        }
        Self { tested, shown }
    }

    fn nothing_reads(&self, predicate: PredicateId) -> bool {
        !self.tested[predicate.index()] && !self.shown[predicate.index()]
    }
}

fn for_each_condition(domain: &Domain, visit: &mut impl FnMut(&Condition)) {
    for action in &domain.actions {
        visit(&action.precondition);
        action.effects.iter().for_each(|effect| visit(&effect.condition));
        action.numeric.iter().for_each(|effect| visit(&effect.condition));
    }
    for word in &domain.goal_words {
        visit(&word.condition);
        visit(&word.offered);
    }
    domain.rules.iter().for_each(|rule| visit(&rule.condition));
    domain.derivations.iter().for_each(|derivation| visit(&derivation.when));
    domain.defaults.iter().for_each(|default| visit(&default.when));
}

pub(super) fn findings(domain: &Domain, reads: &Reads, places: &Places<'_>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for action in &domain.actions {
        effects(domain, reads, places, action, &mut findings);
    }
    for (index, words) in domain.predicate_words.iter().enumerate() {
        let tell = if words.fluent { changed } else { unchanged };
        tell(domain, reads, places, PredicateId::new(index), &mut findings);
    }
    types(domain, places, &mut findings);
    findings
}

fn effects(domain: &Domain, reads: &Reads, places: &Places<'_>, action: &Action, findings: &mut Vec<Finding>) {
    let name = action.name.as_str();
    if is_useless(reads, action) {
        let mut changed: Vec<&str> = Vec::new();
        let effects = action.effects.iter().map(|effect| &effect.atom);
        for atom in effects.chain(&action.senses) {
            let predicate = domain.predicate(atom.predicate).name.as_str();
            if !changed.contains(&predicate) {
                changed.push(predicate);
            }
        }
        let (message, hint) = if changed.is_empty() {
            (
                format!("the action `{name}` changes nothing, so no plan is ever better for it"),
                "say in its effect what is different afterwards; for what only happens, a predicate with \
                 `event = true` and a goal word that asks for it"
                    .to_owned(),
            )
        } else {
            (
                format!(
                    "the action `{name}` only {} {}, which nothing reads",
                    if action.senses.is_empty() { "changes" } else { "tells" },
                    quoted(&changed)
                ),
                let_it_be_read(changed[0], "take the action out"),
            )
        };
        findings.push(Finding::new(
            Lint::UselessAction,
            &[name],
            places.action(name),
            message,
            hint,
        ));
    }
    for (index, effect) in action.effects.iter().enumerate() {
        let opposite = |other: &&Effect| {
            other.adds != effect.adds
                && (&other.atom, &other.forall, &other.condition) == (&effect.atom, &effect.forall, &effect.condition)
        };
        if action.effects[..index].iter().any(|other| opposite(&other)) {
            let changed = domain.predicate(effect.atom.predicate).name.as_str();
            findings.push(Finding::new(
                Lint::ContradictoryEffect,
                &[name, changed],
                places.within_action(name, ":effect", changed),
                format!("the action `{name}` makes `{changed}` true and false of the same thing; true wins"),
                "keep the one that is meant",
            ));
        }
    }
}

/// Returns true if nothing reads the effects and sensing outcomes of the action.
fn is_useless(reads: &Reads, action: &Action) -> bool {
    let changed = action.effects.iter().map(|effect| effect.atom.predicate);
    let sensed = action.senses.iter().map(|atom| atom.predicate);
    // A number is in the environment after a plan, where a person sees it.
    action.numeric.is_empty() && changed.chain(sensed).all(|predicate| reads.nothing_reads(predicate))
}

fn let_it_be_read(name: &str, otherwise: &str) -> String {
    format!("let a precondition, a goal, a rule or a `[[state]]` speak of `{name}`, or {otherwise}")
}

/// Checks a predicate that actions change.
fn changed(domain: &Domain, reads: &Reads, places: &Places<'_>, id: PredicateId, findings: &mut Vec<Finding>) {
    let changes = |action: &&Action| action.effects.iter().any(|effect| effect.atom.predicate == id);
    let changing: Vec<&Action> = domain.actions.iter().filter(changes).collect();
    // If all of these actions are useless, their own findings suffice.
    if !reads.nothing_reads(id) || changing.iter().all(|action| is_useless(reads, action)) {
        return;
    }
    let name = domain.predicate(id).name.as_str();
    let actions: Vec<&str> = changing.iter().map(|action| action.name.as_str()).collect();
    findings.push(Finding::new(
        Lint::UnreadEffect,
        &[name],
        places.within_action(actions[0], ":effect", name),
        format!("nothing reads `{name}`, which {} changes", quoted(&actions)),
        let_it_be_read(name, "take it out of the effects"),
    ));
}

/// Checks a predicate that no action changes.
fn unchanged(domain: &Domain, reads: &Reads, places: &Places<'_>, id: PredicateId, findings: &mut Vec<Finding>) {
    // A state word alone does not use a predicate; a `short` that the model sees does.
    if reads.tested[id.index()] || domain.words(id).short.is_some() {
        return;
    }
    let name = domain.predicate(id).name.as_str();
    let states = domain.states.iter().zip(&places.words.state);
    let state = states
        .filter(|(word, _)| word.atom.predicate == id)
        .map(|(_, entry)| &entry.word);
    let properties = domain.properties.iter().zip(&places.words.property);
    let property = properties
        .filter(|(word, _)| word.literals.iter().any(|literal| literal.atom.predicate == id))
        .map(|(_, entry)| &entry.word);
    let place = state.chain(property).next().map(|word| places.word(word));
    let follows = domain.derivations.iter().flat_map(|derivation| &derivation.literals);
    let follows = follows.map(|literal| literal.atom.predicate);
    let usual = domain.defaults.iter().map(|default| default.atom.predicate);
    let given = place.is_some()
        || domain.words(id).unknown == Unknown::Assume
        || follows.chain(usual).any(|predicate| predicate == id);
    findings.push(if given {
        Finding::new(
            Lint::DeadState,
            &[name],
            place.unwrap_or_else(|| places.predicate(name)),
            format!("environments say `{name}`, and no action changes it and nothing reads it"),
            format!(
                "let a precondition, a goal or a rule speak of `{name}`, give it a `short` so that a model sees it, \
                 or leave it out"
            ),
        )
    } else {
        Finding::new(
            Lint::UnusedPredicate,
            &[name],
            places.predicate(name),
            format!("nothing uses the predicate `{name}`"),
            "use it in a condition or an effect, or take it out of both files",
        )
    });
}

/// Reports types that no declaration uses, directly or through a subtype.
fn types(domain: &Domain, places: &Places<'_>, findings: &mut Vec<Finding>) {
    let mut used = vec![domain.environment.asset, domain.environment.object];
    let of = |parameters: &[Parameter]| {
        parameters
            .iter()
            .map(|parameter| parameter.kind)
            .collect::<Vec<TypeId>>()
    };
    used.extend(domain.constants.iter().map(|(_, kind)| *kind));
    domain
        .predicates
        .iter()
        .for_each(|predicate| used.extend(of(&predicate.parameters)));
    domain
        .goal_words
        .iter()
        .for_each(|word| used.extend(of(&word.parameters)));
    domain.rules.iter().for_each(|rule| used.extend(of(&rule.variables)));
    for action in &domain.actions {
        used.extend(of(&action.parameters));
        used.extend(
            action
                .effects
                .iter()
                .flat_map(|effect| &effect.forall)
                .map(|(_, kind)| *kind),
        );
    }
    for_each_condition(domain, &mut |condition| {
        used.extend(condition.iter().filter_map(|part| match part {
            Condition::Forall(_, kind, _) | Condition::Exists(_, kind, _) => Some(*kind),
            _ => None,
        }));
    });
    for index in 1..domain.types.names().count() {
        let kind = TypeId::new(index);
        if !used.iter().any(|used| domain.types.is_a(*used, kind)) {
            let name = domain.types.name(kind);
            findings.push(Finding::new(
                Lint::UnusedType,
                &[name],
                places.kind(name),
                format!("nothing is of the type `{name}` and nothing asks for it"),
                "use it for a parameter or in `[environment]`, or take it out",
            ));
        }
    }
}
