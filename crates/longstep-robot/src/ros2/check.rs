//! A configuration compared with a domain, and with an environment.

use std::ops::Range;

use longstep_core::call::Call;
use longstep_core::diagnostic::{Diagnostic, Diagnostics};
use longstep_core::environment::World;
use longstep_core::model::{Action, Domain, StateWord};

use super::configuration::{ANY, ActionRule, Configuration, SayRule};
use super::file::{Servers, Text};
use super::mapping::{ORDER_HOLES, SKILL};
use super::template::{Filter, Hole, Template};

/// The most names in one remark.
const NAMED: usize = 5;

/// The differences between a configuration and a domain.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Checked {
    /// Errors, sorted.
    pub mismatches: Vec<Diagnostic>,
    /// Doubts: lines that may be meant otherwise, sorted.
    pub remarks: Vec<Diagnostic>,
}

/// Compares a configuration with a domain, and with an environment where there is one.
pub fn check(configuration: &Configuration, domain: &Domain, world: Option<&World>) -> Checked {
    let mut checker = Checker {
        configuration,
        domain,
        world,
        checked: Checked::default(),
    };
    checker.actions();
    checker.observations();
    if let Err(Diagnostics(findings)) = configuration.autonomy(domain, world) {
        checker.checked.mismatches.extend(findings);
    }
    let Checked {
        mut mismatches,
        mut remarks,
    } = checker.checked;
    mismatches.sort();
    mismatches.dedup();
    remarks.sort();
    remarks.dedup();
    Checked { mismatches, remarks }
}

struct Checker<'a> {
    configuration: &'a Configuration,
    domain: &'a Domain,
    world: Option<&'a World>,
    checked: Checked,
}

impl Checker<'_> {
    fn report(&mut self, span: &Range<usize>, part: &str, message: String) {
        let finding = self.configuration.source.finding(span, part, message);
        self.checked.mismatches.push(finding);
    }

    fn remark(&mut self, span: &Range<usize>, part: &str, message: String) {
        let finding = self.configuration.source.finding(span, part, message);
        self.checked.remarks.push(finding);
    }

    fn unknown<'n>(&mut self, text: &Text, kind: &str, known: impl IntoIterator<Item = &'n str>) {
        let finding = self
            .configuration
            .source
            .unknown(&text.span(), kind, text.get_ref(), known);
        self.checked.mismatches.push(finding);
    }

    fn action_named(&mut self, name: &Text) -> bool {
        let domain = self.domain;
        let names = || domain.actions.iter().map(|action| action.name.as_str());
        let is_known = names().any(|own| own == name.get_ref());
        if !is_known {
            self.unknown(name, "action", names());
        }
        is_known
    }

    fn actions(&mut self) {
        let (configuration, domain) = (self.configuration, self.domain);
        for name in &configuration.allow {
            self.action_named(name);
        }
        for rule in &configuration.actions {
            let is_named = rule.name.get_ref() != ANY;
            if is_named {
                self.action_named(&rule.name);
                let allowed = configuration
                    .allow
                    .iter()
                    .any(|own| own.get_ref() == rule.name.get_ref());
                if !allowed {
                    let message = format!(
                        "`{}` is mapped, but not in `allow`: it is never performed",
                        rule.name.get_ref()
                    );
                    self.remark(&rule.name.span(), rule.name.get_ref(), message);
                }
            }
        }
        for action in &domain.actions {
            if let Some(rule) = configuration.rule(&action.name) {
                self.rule(rule, action);
            }
        }
        let missing = domain
            .actions
            .iter()
            .filter(|action| configuration.rule(&action.name).is_none());
        let missing: Vec<&str> = missing.map(|action| action.name.as_str()).collect();
        if let Some(first) = configuration.allow.first().filter(|_| !missing.is_empty()) {
            let message = format!("plans with these actions are refused: {}", some_of(&missing));
            self.remark(&first.span(), "", message);
        }
    }

    fn rule(&mut self, rule: &ActionRule, action: &Action) {
        for hole in rule.goal.holes() {
            self.hole(hole, &rule.goal_span, action);
        }
        for outcome in &rule.outcomes {
            for hole in outcome.fact.holes() {
                self.hole(hole, &outcome.span, action);
            }
        }
        self.lanes(rule, action);
        let has_outcome = rule.outcome.is_some() || !rule.outcomes.is_empty();
        let name = rule.name.get_ref();
        if !action.senses.is_empty() && !has_outcome {
            let message = format!("`{}` is a sensing action: add `outcome` or `outcomes`", action.name);
            self.report(&rule.name.span(), name, message);
        }
        if action.senses.is_empty() && has_outcome && name != ANY {
            let message = format!("`{}` is no sensing action: it has no outcome", action.name);
            self.report(&rule.name.span(), name, message);
        }
        if !action.senses.is_empty() {
            self.outcomes(rule, action);
        }
    }

    /// Compares the lanes of servers with the actors of the environment.
    fn lanes(&mut self, rule: &ActionRule, action: &Action) {
        let Servers::ByLane(servers) = &rule.servers else {
            return;
        };
        let Some(actor) = action.actor else {
            let message = format!(
                "`{}` has no actor in domain.toml, so its steps have no lane",
                action.name
            );
            return self.report(&rule.server_span, "", message);
        };
        let Some(world) = self.world else {
            return;
        };
        let actors = world.of_kind(action.parameters[actor].kind).iter();
        let actors: Vec<&str> = actors.map(|own| world.entity(*own).identifier.as_str()).collect();
        let missing: Vec<&str> = actors
            .iter()
            .copied()
            .filter(|own| !servers.contains_key(*own))
            .collect();
        if !missing.is_empty() {
            let message = format!("{} has no server: its steps are refused", some_of(&missing));
            self.remark(&rule.server_span, "", message);
        }
        for lane in servers.keys().filter(|own| !actors.contains(&own.as_str())) {
            let message = format!(
                "`{lane}` is no actor of `{}`; actors are {}",
                action.name,
                some_of(&actors)
            );
            self.report(&rule.server_span, lane, message);
        }
    }

    /// Compares the facts of `outcomes` with those that the action reveals.
    fn outcomes(&mut self, rule: &ActionRule, action: &Action) {
        let domain = self.domain;
        let revealed: Vec<&str> = action
            .senses
            .iter()
            .map(|atom| domain.predicate(atom.predicate).name.as_str())
            .collect();
        for outcome in &rule.outcomes {
            let Some(written) = skeleton(&outcome.fact) else {
                continue;
            };
            let name = written
                .trim_matches(['(', ')'])
                .split_whitespace()
                .next()
                .unwrap_or_default();
            if !revealed.contains(&name) {
                let message = format!(
                    "`{}` does not reveal `{name}`; it reveals {}",
                    action.name,
                    some_of(&revealed)
                );
                self.report(&outcome.span, name, message);
            }
        }
    }

    fn hole(&mut self, hole: &Hole, span: &Range<usize>, action: &Action) {
        let written = format!("{{{}}}", hole.written);
        if let Some(parameter) = action.parameters.iter().find(|own| own.name == hole.name) {
            let is_value = self.domain.values.iter().any(|own| own.kind == parameter.kind);
            match hole.filters.first() {
                Some(Filter::Number | Filter::Unit | Filter::Text) if !is_value => {
                    let kind = self.domain.types.name(parameter.kind).to_owned();
                    let message = format!("`{}` of `{}` is a `{kind}`, not a value", hole.name, action.name);
                    self.report(span, &written, message);
                }
                Some(Filter::Table(table)) => self.table(table, span, &written, parameter.kind, action),
                _ => {}
            }
            return;
        }
        if let Some(skill) = hole.name.strip_prefix(SKILL) {
            if !action.skills.iter().any(|own| own.name == skill) {
                let known: Vec<&str> = action.skills.iter().map(|own| own.name.as_str()).collect();
                let message = if known.is_empty() {
                    format!("`{}` has no skill parameters in domain.toml", action.name)
                } else {
                    format!(
                        "`{}` has no skill parameter `{skill}`; it has {}",
                        action.name,
                        some_of(&known)
                    )
                };
                self.report(span, &written, message);
            }
            return;
        }
        if !ORDER_HOLES.contains(&hole.name.as_str()) {
            let parameters = action.parameters.iter().map(|own| own.name.as_str());
            let known: Vec<&str> = parameters.chain(ORDER_HOLES).collect();
            let message = format!(
                "`{}` has no parameter `{}`; holes are {}",
                action.name,
                hole.name,
                known.join(", ")
            );
            self.report(span, &written, message);
        }
    }

    /// Looks for entities of the environment that a table lacks.
    fn table(
        &mut self,
        name: &str,
        span: &Range<usize>,
        written: &str,
        kind: longstep_core::model::TypeId,
        action: &Action,
    ) {
        let (Some(world), Some(table)) = (self.world, self.configuration.tables.get(name)) else {
            return;
        };
        let entities = world.of_kind(kind).iter().map(|entity| world.entity(*entity));
        let missing = entities.filter(|own| !own.is_value && !table.contains_key(&own.identifier));
        let missing: Vec<&str> = missing.map(|own| own.identifier.as_str()).collect();
        if !missing.is_empty() {
            let message = format!(
                "the table `{name}` lacks {}: steps of `{}` with them are refused",
                some_of(&missing),
                action.name
            );
            self.remark(span, written, message);
        }
    }

    fn observations(&mut self) {
        let configuration = self.configuration;
        if configuration.observations.is_empty() {
            let finding = Diagnostic::whole(
                &configuration.source.file,
                "there is no [[observation]]: without one, plans cannot be monitored and are not run",
            );
            self.checked.mismatches.push(finding);
        }
        for name in &configuration.reports {
            let domain = self.domain;
            let reportable = longstep_core::environment::ObservedFacts::reportable(domain);
            // What happened in an earlier plan must not count for this one.
            let lasting = reportable.iter().filter(|id| !domain.words(**id).event);
            let names = || lasting.clone().map(|id| domain.predicate(*id).name.as_str());
            if !names().any(|own| own == name.get_ref()) {
                self.unknown(name, "predicate", names());
            }
        }
        for rule in &configuration.observations {
            for say in &rule.say {
                self.statement(say);
            }
        }
        self.unsaid();
    }

    /// Compares a statement with the words of the domain.
    fn statement(&mut self, say: &SayRule) {
        let Some(written) = skeleton(&say.text) else {
            return;
        };
        let Ok(call) = Call::parse(&written) else {
            let message = format!("`{written}` is not written as `word(argument, ...)`");
            return self.report(&say.span, "", message);
        };
        let expected = if say.is_fact {
            self.fact_arguments(&call.name)
        } else {
            self.state_arguments(&call.name)
        };
        match expected {
            Err(known) => {
                let kind = if say.is_fact {
                    "statement without a subject"
                } else {
                    "state"
                };
                let mut finding =
                    self.configuration
                        .source
                        .unknown(&say.span, kind, &call.name, known.iter().map(String::as_str));
                if finding.hint.is_none() && !known.is_empty() {
                    let known: Vec<&str> = known.iter().map(String::as_str).collect();
                    finding = finding.hint(format!("the domain has {}", known.join(", ")));
                }
                self.checked.mismatches.push(finding);
            }
            Ok(expected) if expected != call.arguments.len() => {
                let message = format!("`{}` has {expected} arguments, not {}", call.name, call.arguments.len());
                self.report(&say.span, &call.name, message);
            }
            Ok(_) => {}
        }
    }

    /// Returns the number of arguments of a state's word, or all words.
    fn state_arguments(&self, word: &str) -> Result<usize, Vec<String>> {
        let states = &self.domain.states;
        if let Some(own) = states.iter().find(|own| own.word == word) {
            return Ok(own.parameters.len());
        }
        let functions = self.domain.functions.iter().filter(|own| !own.parameters.is_empty());
        if let Some(own) = functions.clone().find(|own| own.word == word) {
            return Ok(own.parameters.len());
        }
        let words = states.iter().map(|own| own.word.clone());
        Err(words.chain(functions.map(|own| own.word.clone())).collect())
    }

    /// Returns the number of arguments of a statement without a subject, or all names.
    fn fact_arguments(&self, name: &str) -> Result<usize, Vec<String>> {
        let reports = &self.configuration.reports;
        let is_stated = |own: &&longstep_core::model::Predicate| {
            own.parameters.is_empty() || reports.iter().any(|report| *report.get_ref() == own.name)
        };
        let predicates = self.domain.predicates.iter().filter(is_stated);
        let numbers = self.domain.functions.iter().filter(|own| own.parameters.is_empty());
        let same = |own: &str| own.replace('_', "-") == name.replace('_', "-");
        if let Some(own) = predicates.clone().find(|own| same(&own.name)) {
            return Ok(own.parameters.len());
        }
        if numbers.clone().any(|own| own.word == name) {
            return Ok(1);
        }
        let names = predicates.map(|own| own.name.clone());
        Err(names.chain(numbers.map(|own| own.word.clone())).collect())
    }

    /// Remarks on states that no observation can state: of an entity that is described, they do not hold.
    fn unsaid(&mut self) {
        let observations = &self.configuration.observations;
        let says: Vec<&SayRule> = observations
            .iter()
            .flat_map(|own| &own.say)
            .filter(|own| !own.is_fact)
            .collect();
        if says.is_empty() || observations.iter().any(|own| own.states.is_some()) {
            return;
        }
        let said: Vec<String> = says.iter().filter_map(|own| skeleton(&own.text)).collect();
        let is_said = |word: &StateWord| said.iter().any(|own| own.split('(').next() == Some(word.word.as_str()));
        let is_fluent = |word: &&StateWord| self.domain.words(word.atom.predicate).fluent;
        let unsaid = self
            .domain
            .states
            .iter()
            .filter(is_fluent)
            .filter(|word| !is_said(word));
        let unsaid: Vec<&str> = unsaid.map(|word| word.word.as_str()).collect();
        if !unsaid.is_empty() {
            let message = format!(
                "no observation states {}: what is described counts as not so",
                some_of(&unsaid)
            );
            let span = says[0].span.clone();
            self.remark(&span, "", message);
        }
    }
}

/// Returns a text with a letter in each hole; none for a template that is no text.
fn skeleton(template: &Template) -> Option<String> {
    match template {
        Template::Constant(value) => value.as_str().map(str::to_owned),
        Template::Text(pieces) => {
            let written = pieces.iter().map(|piece| match piece {
                super::template::Piece::Literal(text) => text.as_str(),
                super::template::Piece::Hole(_) => "x",
            });
            // A text that is one hole is whatever the message says.
            (pieces.len() > 1).then(|| written.collect())
        }
        _ => None,
    }
}

fn some_of(names: &[&str]) -> String {
    let shown: Vec<String> = names.iter().take(NAMED).map(|name| format!("`{name}`")).collect();
    match names.len().saturating_sub(NAMED) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
