//! Lints about actions, goals, rules and facts that no environment and no plan can bring about.

use super::notation::{shown, shown_term};
use super::places::Places;
use super::reach::{Obstacle, Reach, kinds};
use super::reads::Reads;
use super::{Finding, Lint, quoted};
use longstep::domain::{Action, Condition, Domain, Parameter, PredicateId, Term, When};

pub(super) fn findings(domain: &Domain, reach: &Reach<'_>, reads: &Reads, places: &Places<'_>) -> Vec<Finding> {
    let mut family = Family {
        domain,
        reach,
        places,
        cited: Vec::new(),
        findings: Vec::new(),
    };
    for (index, action) in domain.actions.iter().enumerate() {
        family.action(index, action);
    }
    family.goals();
    family.rules();
    family.facts(reads);
    family.one_way();
    family.findings
}

struct Family<'a> {
    domain: &'a Domain,
    reach: &'a Reach<'a>,
    places: &'a Places<'a>,
    /// Predicates that an earlier finding already reports as never true.
    cited: Vec<PredicateId>,
    findings: Vec<Finding>,
}

impl Family<'_> {
    fn action(&mut self, index: usize, action: &Action) {
        let (places, name) = (self.places, action.name.as_str());
        if let Some(obstacle) = self.reach.action(index) {
            let (why, hint) = self.explain(obstacle, &action.parameters);
            let part = if matches!(obstacle, Obstacle::Empty(_)) {
                ":parameters"
            } else {
                ":precondition"
            };
            let place = places.within_action(name, part, &self.keyword(obstacle));
            let message = format!("the action `{name}` can never apply: it {why}");
            self.findings
                .push(Finding::new(Lint::NeverApplicable, &[name], place, message, hint));
            return;
        }
        let mut last = None;
        for (index, effect) in action.effects.iter().enumerate() {
            // The effects of one `when` give one finding.
            if last == Some(&effect.condition) {
                continue;
            }
            let Some(obstacle) = self.reach.to_effect(action, index) else {
                continue;
            };
            last = Some(&effect.condition);
            let (why, hint) = self.explain(&obstacle, &action.parameters);
            let changed = self.domain.predicate(effect.atom.predicate).name.as_str();
            let place = places.within_action(name, ":effect", &self.keyword(&obstacle));
            let message = format!("the effect of `{name}` on `{changed}` never happens: it {why}");
            self.findings.push(Finding::new(
                Lint::NeverApplicable,
                &[name, changed],
                place,
                message,
                hint,
            ));
        }
    }

    fn goals(&mut self) {
        let places = self.places;
        for (word, entry) in self.domain.goal_words.iter().zip(&places.words.goal) {
            let form = entry.form.get_ref().as_str();
            let kinds = kinds(&word.parameters);
            let empty = kinds.iter().find(|kind| !self.reach.inhabited(**kind));
            let offered = || Some((self.reach.obstacle(&word.offered, &kinds)?, entry.offered.as_ref()?));
            let (obstacle, place, what) = if let Some(kind) = empty {
                (Obstacle::Empty(*kind), &entry.parameters, "be offered")
            } else if let Some((obstacle, text)) = offered() {
                (obstacle, text, "be offered")
            } else if let Some(obstacle) = self.reach.obstacle(&word.condition, &kinds) {
                (obstacle, &entry.condition, "be reached")
            } else {
                if !can_change(&word.condition, self.domain) {
                    self.findings.push(Finding::new(
                        Lint::UnreachableGoal,
                        &[form],
                        places.word(&entry.condition),
                        format!("no action works towards the goal `{form}`: it holds at the start or never"),
                        "ask for something that an action changes, or add an action that brings it about",
                    ));
                }
                continue;
            };
            let (why, hint) = self.explain(&obstacle, &word.parameters);
            let message = format!("the goal `{form}` can never {what}: it {why}");
            let place = places.word(place);
            self.findings
                .push(Finding::new(Lint::UnreachableGoal, &[form], place, message, hint));
        }
    }

    fn rules(&mut self) {
        for (rule, entry) in self.domain.rules.iter().zip(&self.places.words.rule) {
            let kinds = kinds(&rule.variables);
            let empty = kinds.iter().find(|kind| !self.reach.inhabited(**kind));
            let broken = rule.condition.clone().negated();
            let obstacle = match empty {
                Some(kind) => Some(Obstacle::Empty(*kind)),
                None => self.reach.obstacle(&broken, &kinds),
            };
            if let Some(obstacle) = obstacle {
                let (why, hint) = self.explain(&obstacle, &rule.variables);
                let name = rule.name.as_str();
                let message = format!("the rule `{name}` can never be broken, so it watches over nothing: that {why}");
                let place = self.places.word(&entry.condition);
                self.findings
                    .push(Finding::new(Lint::VacuousRule, &[name], place, message, hint));
            }
        }
    }

    /// Reports facts that are read and never true, unless a finding on an action, goal or rule names them.
    fn facts(&mut self, reads: &Reads) {
        for (index, predicate) in self.domain.predicates.iter().enumerate() {
            let id = PredicateId::new(index);
            if reads.tested[index] && !self.reach.can_be_true(id) && !self.cited.contains(&id) {
                let name = predicate.name.as_str();
                self.findings.push(Finding::new(
                    Lint::NeverTrue,
                    &[name],
                    self.places.predicate(name),
                    format!("`{name}` is asked about, and nothing makes it true: what asks always finds it false"),
                    source_of(name),
                ));
            }
        }
    }

    /// Reports a predicate that actions only make true, although the precondition of an action requires it to be false
    /// for all entities: a hand that never releases. (A permanent effect on one object is common: an empty bottle stays
    /// empty.)
    fn one_way(&mut self) {
        for (index, predicate) in self.domain.predicates.iter().enumerate() {
            let id = PredicateId::new(index);
            if self.domain.words(id).event || !changes(self.domain, id, true) || changes(self.domain, id, false) {
                continue;
            }
            let mut needing = self.domain.actions.iter().filter(|a| needs_none(&a.precondition, id));
            if let Some(action) = needing.next() {
                let (name, blocked) = (predicate.name.as_str(), action.name.as_str());
                self.findings.push(Finding::new(
                    Lint::OneWayState,
                    &[name],
                    self.places.predicate(name),
                    format!("no action takes `{name}` away again, and then `{blocked}` can never be done any more"),
                    format!("add an action that makes `{name}` false, or let an effect of one that is there do it"),
                ));
            }
        }
    }

    /// Describes an obstacle as a clause after "it" or "that", with a hint.
    fn explain(&mut self, obstacle: &Obstacle, parameters: &[Parameter]) -> (String, String) {
        let domain = self.domain;
        match obstacle {
            Obstacle::NeverTrue(predicate) => {
                self.cited.push(*predicate);
                let name = domain.predicate(*predicate).name.as_str();
                let adds = |action: &&Action| {
                    let mut effects = action.effects.iter();
                    effects.any(|effect| effect.adds && effect.atom.predicate == *predicate)
                        || action.senses.iter().any(|atom| atom.predicate == *predicate)
                };
                let adding: Vec<&str> = domain.actions.iter().filter(adds).map(|a| a.name.as_str()).collect();
                if adding.is_empty() {
                    return (format!("needs `{name}`, and nothing makes that true"), source_of(name));
                }
                let adding = quoted(&adding);
                (
                    format!("needs `{name}`, which only {adding} would make true, and that never happens"),
                    format!("see to {adding}, or let an environment say `{name}` or another action do it"),
                )
            }
            Obstacle::NotYet(predicate) => {
                let name = domain.predicate(*predicate).name.as_str();
                (
                    format!("needs `{name}` at the start, where no event has happened yet"),
                    "ask for the event without `initially`, or for what lasts of it".to_owned(),
                )
            }
            Obstacle::Contradiction { atom, forall: false } => (
                format!("needs `{}` and its opposite", shown(domain, atom, parameters)),
                "take one of the two out".to_owned(),
            ),
            Obstacle::Contradiction { atom, forall: true } => (
                format!(
                    "needs `{}`, and its opposite of everything",
                    shown(domain, atom, parameters)
                ),
                "leave the thing itself out of the `forall`, as in `(imply (not (= ?other ?item)) ...)`".to_owned(),
            ),
            Obstacle::Equality { left, right, holds } => {
                let (left, right) = (
                    shown_term(domain, *left, parameters),
                    shown_term(domain, *right, parameters),
                );
                let why = if *holds {
                    format!("needs `{left}` and `{right}` to be the same thing, and they never are")
                } else {
                    format!("needs `{left}` and `{right}` to differ, and they never do")
                };
                (why, "compare two things that can be the same and can differ".to_owned())
            }
            Obstacle::Empty(kind) => (
                format!("speaks of a `{}`, and no entity ever is one", domain.types.name(*kind)),
                self.types_of_entities(),
            ),
            Obstacle::Mismatch(atom) => (
                format!(
                    "needs `{}`, and no entity is of both types",
                    shown(domain, atom, parameters)
                ),
                self.types_of_entities(),
            ),
            Obstacle::Nothing => (
                "has an `or` of nothing".to_owned(),
                "say what may hold instead, or take the `or` out".to_owned(),
            ),
        }
    }

    fn types_of_entities(&self) -> String {
        let name = |kind| self.domain.types.name(kind);
        format!(
            "entities of an environment are each a `{}` or a `{}`: use one of these, a type above them, a type of values or a constant",
            name(self.domain.environment.asset),
            name(self.domain.environment.object)
        )
    }

    /// Returns the keyword in the file that the obstacle concerns.
    fn keyword(&self, obstacle: &Obstacle) -> String {
        match obstacle {
            Obstacle::NeverTrue(predicate) | Obstacle::NotYet(predicate) => {
                self.domain.predicate(*predicate).name.clone()
            }
            Obstacle::Contradiction { atom, .. } | Obstacle::Mismatch(atom) => {
                self.domain.predicate(atom.predicate).name.clone()
            }
            Obstacle::Equality { .. } => "=".to_owned(),
            Obstacle::Empty(kind) => self.domain.types.name(*kind).to_owned(),
            Obstacle::Nothing => "or".to_owned(),
        }
    }
}

fn source_of(name: &str) -> String {
    format!(
        "make `{name}` true by an effect, a `[[state]]`, a `[[property]]`, a `[[derive]]` or a `[[default]]`, \
         or do not ask for it"
    )
}

/// Returns true if an action makes the predicate true (`adds`) or false. A sensed predicate can become either.
/// Applicability is not considered, since other lints cover it.
fn changes(domain: &Domain, predicate: PredicateId, adds: bool) -> bool {
    let mut effects = domain.actions.iter().flat_map(|action| &action.effects);
    domain.is_sensed(predicate) || effects.any(|effect| effect.atom.predicate == predicate && effect.adds == adds)
}

/// Returns true if some action can change a fact in favour of the condition.
fn can_change(condition: &Condition, domain: &Domain) -> bool {
    condition.iter().any(|part| {
        matches!(part, Condition::Atom { atom, holds, at: When::Now } if changes(domain, atom.predicate, *holds))
    })
}

/// Returns true if the condition requires the predicate to be false for all entities.
fn needs_none(condition: &Condition, predicate: PredicateId) -> bool {
    condition.conjuncts().any(|part| {
        let mut everything = Vec::new();
        let mut inner = part;
        while let Condition::Forall(slot, _, next) = inner {
            everything.push(Term::Variable(*slot));
            inner = next;
        }
        inner.conjuncts().any(|literal| {
            matches!(literal, Condition::Atom { atom, holds: false, at: When::Now }
                if atom.predicate == predicate && atom.terms.iter().all(|term| everything.contains(term)))
        })
    })
}
