//! The loader: reads the files of a domain's folder and builds a [`Domain`].

mod goals;
mod numbers;
mod sensing;
mod skills;
mod values;

use crate::spanned::Spanned;

use super::content_hash::content_hash;
use super::pddl::{Dialect, Reader, Scope, Semantics};
use super::words::{self, DomainFile, TimeEntry, UnknownEntry};
use super::{
    Action, ActionSchema, Atom, Condition, DefaultFact, Derivation, Domain, DomainData, Effect, EnvironmentTypes,
    Files, FormPiece, GoalWord, Lexicon, Literal, Parameter, Predicate, PredicateId, PredicateWords, PropertyWord,
    RepairCosts, Rule, RuleTime, SpatialRelation, StateWord, Template, TypeId, Unknown, base_name, pddl, plain_words,
    sexpr,
};
use crate::call::{Call, is_script_keyword};
use crate::diagnostic::{Diagnostic, Diagnostics, Position, nearest};
use crate::model::{When, phrase, unified};

/// Loads a domain from its files.
///
/// # Errors
///
/// All errors in the files and all inconsistencies between them, each with file, line and column. A file that is not
/// valid PDDL or TOML hides the errors in the rest of it.
pub fn load(files: &Files) -> Result<Domain, Diagnostics> {
    match load_with_findings(files) {
        (Some(domain), findings) if findings.is_empty() => Ok(domain),
        (_, findings) => Err(Diagnostics::sorted(findings)),
    }
}

/// Loads a domain as far as possible, and returns it with all errors. For callers that check further files against the
/// domain.
pub fn load_with_findings(files: &Files) -> (Option<Domain>, Vec<Diagnostic>) {
    let mut findings = Vec::new();
    let pddl_file = format!("{}domain.pddl", files.folder);
    let semantics = pddl::read(&pddl_file, &files.pddl, Dialect::Longstep, &mut findings);
    let words_file = format!("{}domain.toml", files.folder);
    let parsed: Option<DomainFile> = read_toml(&words_file, &files.words, &mut findings);
    let skills = files.skills.as_ref().and_then(|(path, text)| {
        let words = read_toml(path, text, &mut findings)?;
        Some(SkillsSource { path, text, words })
    });
    let domain = parsed.map(|mut parsed| {
        if let Some(words) = skills.as_ref().map(|skills| &skills.words) {
            parsed.name = words.name.clone().unwrap_or(parsed.name);
            parsed.about = words.about.clone().unwrap_or(parsed.about);
        }
        let mut loader = Loader {
            file: &words_file,
            text: &files.words,
            skills: skills.as_ref(),
            pddl_file: &pddl_file,
            semantics: &semantics,
            findings: &mut findings,
        };
        loader.domain(parsed, content_hash(&[&files.pddl, &files.words]))
    });
    (domain, findings)
}

/// Parses a TOML file; appends errors to `findings`.
pub fn read_toml<T: serde::de::DeserializeOwned>(file: &str, text: &str, findings: &mut Vec<Diagnostic>) -> Option<T> {
    toml::from_str(text)
        .map_err(|error| {
            let position = Position::of(text, error.span().map_or(0, |span| span.start));
            findings.push(Diagnostic::at(
                file,
                position,
                error.message().trim().replace('\n', "; "),
            ));
        })
        .ok()
}

/// Returns the position of the content of a TOML string, after its quotes.
pub fn content_position<T>(text: &str, value: &Spanned<T>) -> Position {
    let start = value.span().start;
    let raw = &text[start..];
    let quotes = if raw.starts_with("\"\"\"") || raw.starts_with("'''") {
        3 + usize::from(raw[3..].starts_with('\n'))
    } else {
        1
    };
    Position::of(text, start + quotes)
}

/// The article of domains that declare none.
const ARTICLE: &str = "the";

/// `skills.toml`, read.
struct SkillsSource<'a> {
    path: &'a str,
    text: &'a str,
    words: words::SkillsFile,
}

struct Loader<'a> {
    file: &'a str,
    text: &'a str,
    skills: Option<&'a SkillsSource<'a>>,
    pddl_file: &'a str,
    semantics: &'a Semantics,
    findings: &'a mut Vec<Diagnostic>,
}

impl Loader<'_> {
    fn report<T>(&mut self, place: &Spanned<T>, message: impl Into<String>) {
        let position = content_position(self.text, place);
        self.findings.push(Diagnostic::at(self.file, position, message));
    }

    fn report_unknown<'n>(
        &mut self,
        place: &Spanned<String>,
        what: &str,
        name: &str,
        known: impl IntoIterator<Item = &'n str>,
    ) {
        let position = content_position(self.text, place);
        let mut finding = Diagnostic::at(self.file, position, format!("unknown {what} `{name}`"));
        if let Some(near) = nearest(name, known) {
            finding = finding.hint(format!("did you mean `{near}`?"));
        }
        self.findings.push(finding);
    }

    fn read_with<T>(
        &mut self,
        text: &Spanned<String>,
        read: impl FnOnce(&mut Reader<'_>, &sexpr::Expression) -> Option<T>,
    ) -> Option<T> {
        let base = content_position(self.text, text);
        let expressions = match sexpr::read(self.file, text.get_ref()) {
            Ok(expressions) => expressions,
            Err(mut finding) => {
                finding.position = Some(base);
                self.findings.push(finding);
                return None;
            }
        };
        let [expression] = &expressions[..] else {
            self.report(text, "expected one expression in parentheses");
            return None;
        };
        let mut reader = Reader {
            file: self.file,
            base,
            dialect: Dialect::Longstep,
            findings: self.findings,
            expanded: 0,
        };
        read(&mut reader, expression)
    }

    fn condition(&mut self, text: &Spanned<String>, parameters: &[Parameter]) -> Condition {
        let semantics = self.semantics;
        let mut scope = scope_of(parameters);
        self.read_with(text, |reader, expression| {
            Some(reader.condition(expression, &mut scope, semantics))
        })
        .unwrap_or(Condition::TRUE)
    }

    fn literal(&mut self, text: &Spanned<String>, parameters: &[Parameter]) -> Option<Literal> {
        match self.condition(text, parameters) {
            Condition::Atom {
                atom,
                holds,
                at: When::Now,
            } => Some(Literal { atom, holds }),
            // Unreadable text was reported before.
            Condition::And(empty) if empty.is_empty() => None,
            _ => {
                self.report(text, "expected one fact, `(predicate ...)` or `(not (predicate ...))`");
                None
            }
        }
    }

    fn template(&mut self, text: &Spanned<String>, parameters: &[Parameter]) -> Template {
        let index = |name: &str| parameters.iter().position(|p| p.name == name);
        // It becomes a part of other sentences.
        Template::read(phrase(text.get_ref()), index).unwrap_or_else(|hole| {
            if hole == "{" {
                self.report(text, "a `{` is not closed");
            } else {
                self.report_unknown(
                    text,
                    "name in braces",
                    &hole,
                    parameters.iter().map(|p| p.name.as_str()),
                );
            }
            Template::default()
        })
    }

    fn parameter(&mut self, text: &Spanned<String>, parameters: &[Parameter]) -> Option<usize> {
        let name = text.get_ref().trim_start_matches('?');
        let index = parameters.iter().position(|p| p.name == name);
        if index.is_none() {
            self.report_unknown(text, "parameter", name, parameters.iter().map(|p| p.name.as_str()));
        }
        index
    }

    fn kind(&mut self, text: &Spanned<String>) -> TypeId {
        self.semantics.types.find(text.get_ref()).unwrap_or_else(|| {
            self.report_unknown(text, "type", text.get_ref(), self.semantics.types.names());
            TypeId::OBJECT
        })
    }

    fn domain(&mut self, file: DomainFile, hash: String) -> Domain {
        let environment = EnvironmentTypes {
            asset: self.kind(&file.environment.assets),
            object: self.kind(&file.environment.objects),
        };
        let mut predicate_words = self.predicates(&file.predicate);
        let actions = self.actions(&file.action);
        self.check_skills(&file.action);
        for atom in actions.iter().flat_map(|action| &action.senses) {
            predicate_words[atom.predicate.index()].fluent = true;
        }
        let states: Vec<StateWord> = file.state.iter().filter_map(|entry| self.state(entry)).collect();
        self.report_repeated_relations(&file.state);
        let properties = file.property.iter().map(|entry| self.property(entry)).collect();
        let derivations = file.derive.iter().map(|entry| self.derivation(entry)).collect();
        let myself = [self_parameter()];
        let defaults = file
            .default
            .iter()
            .filter_map(|entry| {
                let when = self.condition(&entry.when, &myself);
                let literal = self.literal(&entry.fact, &myself)?;
                if !literal.holds {
                    self.report(
                        &entry.fact,
                        "a default is a fact that usually holds, not the lack of one",
                    );
                }
                Some(DefaultFact {
                    atom: literal.atom,
                    when,
                    written: entry.when.get_ref().clone(),
                    line: self.line(&entry.fact),
                })
            })
            .collect();
        let goal_words: Vec<GoalWord> = file.goal.iter().filter_map(|entry| self.goal_word(entry)).collect();
        self.report_negated_outcomes(&file, &actions, &goal_words);
        let implied = self.implied(&file.implied);
        let rules: Vec<Rule> = file.rule.iter().map(|entry| self.rule(entry, &goal_words)).collect();
        let functions = self.functions(&file.number, &states);
        let rules = numbers::with_ranges(rules, &functions);
        let repair = self.repair_costs(&file.repair);
        let values = self.values(&file.value, &environment);
        let data = DomainData {
            name: file.name,
            hash,
            pddl_name: self.semantics.name.clone(),
            about: file.about,
            types: self.semantics.types.clone(),
            constants: self.semantics.constants.clone(),
            predicates: self.semantics.predicates.clone(),
            predicate_words,
            functions,
            actions,
            environment,
            states,
            properties,
            derived: self.semantics.derived.clone(),
            derivations,
            defaults,
            rules,
            goal_words,
            repair,
            values,
            lexicon: lexicon(file.lexicon),
            implied,
            article: self.article(file.article.as_ref()),
            speaker_names: self.entity_words(&file.speaker_names),
            robot_names: self.entity_words(&file.robot_names),
        };
        data.into()
    }

    fn predicates(&mut self, entries: &[words::PredicateEntry]) -> Vec<PredicateWords> {
        let semantics = self.semantics;
        for entry in entries {
            if !semantics.predicates.iter().any(|p| p.name == *entry.name.get_ref()) {
                let known = semantics.predicates.iter().map(|p| p.name.as_str());
                self.report_unknown(&entry.name, "predicate", entry.name.get_ref(), known);
            }
        }
        let changed = |index: usize| {
            let touches = |effect: &Effect| effect.atom.predicate.index() == index;
            semantics.actions.iter().any(|a| a.effects.iter().any(touches))
        };
        let mut all = Vec::with_capacity(semantics.predicates.len());
        for (index, predicate) in semantics.predicates.iter().enumerate() {
            let fluent = changed(index);
            let named = |entry: &&words::PredicateEntry| *entry.name.get_ref() == predicate.name;
            let Some(entry) = entries.iter().find(named) else {
                let position = semantics.predicate_positions[index];
                let message = format!("the predicate `{}` has no words in domain.toml", predicate.name);
                let hint = format!(
                    "add `[[predicate]] name = \"{}\"` with `says` and `denies`",
                    predicate.name
                );
                self.findings
                    .push(Diagnostic::at(self.pddl_file, position, message).hint(hint));
                all.push(PredicateWords {
                    says: Template::default(),
                    denies: Template::default(),
                    short: None,
                    event: false,
                    unknown: Unknown::False,
                    complete: false,
                    fluent,
                    past: None,
                });
                continue;
            };
            if entry.unknown == UnknownEntry::Assume && (fluent || predicate.parameters.len() != 1) {
                self.report(
                    &entry.name,
                    "`unknown = \"assume\"` is for facts about one entity that no action changes",
                );
            }
            if entry.event && !fluent {
                self.report(&entry.name, "an event needs an action that makes it true");
            }
            all.push(PredicateWords {
                says: self.template(&entry.says, &predicate.parameters),
                denies: self.template(&entry.denies, &predicate.parameters),
                short: entry
                    .short
                    .as_ref()
                    .map(|short| self.template(short, &predicate.parameters)),
                event: entry.event,
                unknown: match entry.unknown {
                    UnknownEntry::False => Unknown::False,
                    UnknownEntry::Assume => Unknown::Assume,
                },
                complete: entry.complete,
                fluent,
                past: entry.past.as_ref().and_then(|past| self.past(past, predicate, entries)),
            });
        }
        all
    }

    fn actions(&mut self, entries: &[words::ActionEntry]) -> Vec<Action> {
        let semantics = self.semantics;
        for (index, entry) in entries.iter().enumerate() {
            let name = entry.name.get_ref();
            if !semantics.actions.iter().any(|a| a.name == *name) {
                let known = semantics.actions.iter().map(|a| a.name.as_str());
                self.report_unknown(&entry.name, "action", name, known);
            }
            if entries[..index].iter().any(|earlier| earlier.name.get_ref() == name) {
                self.report(&entry.name, format!("the action `{name}` has words twice"));
            }
        }
        let mut actions = Vec::with_capacity(semantics.actions.len());
        for (index, schema) in semantics.actions.iter().enumerate() {
            let Some(entry) = entries.iter().find(|entry| *entry.name.get_ref() == schema.name) else {
                let position = semantics.action_positions[index];
                let message = format!("the action `{}` has no words in domain.toml", schema.name);
                let hint = format!(
                    "add `[[action]] name = \"{}\"` with `call`, `says` and `means`",
                    schema.name
                );
                self.findings
                    .push(Diagnostic::at(self.pddl_file, position, message).hint(hint));
                continue;
            };
            let call = match Call::parse(entry.call.get_ref()) {
                Ok(call) => call,
                Err(error) => {
                    self.report(&entry.call, error.to_string());
                    continue;
                }
            };
            let known: Vec<&str> = schema.parameters.iter().map(|p| p.name.as_str()).collect();
            let mut explicit = Vec::new();
            for argument in &call.arguments {
                let name = argument.trim_start_matches('?');
                match known.iter().position(|k| *k == name) {
                    Some(index) => explicit.push(index),
                    None => self.report_unknown(&entry.call, "parameter", name, known.iter().copied()),
                }
            }
            let object = entry
                .object
                .as_ref()
                .and_then(|object| self.parameter(object, &schema.parameters));
            let actor = entry
                .actor
                .as_ref()
                .and_then(|actor| self.parameter(actor, &schema.parameters));
            if let Some(shown) = object.filter(|index| explicit.contains(index)) {
                let message = format!("`{}` is shown in the call already", known[shown]);
                self.report(&entry.call, message);
            }
            if is_script_keyword(&call.name) {
                let message = format!("`{}` is a word of the notation of plans", call.name);
                self.report_with_hint(&entry.call, message, format!("write `do_{}`", call.name));
            }
            if let Some(other) = actions.iter().find(|a: &&Action| a.call == call.name) {
                let message = format!("the call `{}` is taken by the action `{}`", call.name, other.name);
                self.report(&entry.call, message);
            }
            actions.push(Action {
                name: schema.name.clone(),
                parameters: schema.parameters.clone(),
                precondition: schema.precondition.clone(),
                effects: schema.effects.clone(),
                numeric: schema.numeric.clone(),
                cost: schema.cost.clone(),
                call: call.name,
                explicit,
                object,
                actor,
                senses: self.senses(entry, schema),
                says: self.template(&entry.says, &schema.parameters),
                means: entry.means.clone(),
                retries: self.retries(entry),
                skills: self.skills(entry),
            });
        }
        actions
    }

    fn state(&mut self, entry: &words::StateEntry) -> Option<StateWord> {
        let call = match Call::parse(entry.word.get_ref()) {
            Ok(call) => call,
            Err(error) => {
                self.report(&entry.word, error.to_string());
                return None;
            }
        };
        self.check_goal_keyword(&entry.word, &call.name);
        let mut parameters = vec![self_parameter()];
        for argument in &call.arguments {
            parameters.push(any_parameter(argument.trim_start_matches('<').trim_end_matches('>')));
        }
        let literal = self.literal(&entry.fact, &parameters)?;
        if !literal.holds {
            self.report(&entry.fact, "a state word stands for a fact, not for the lack of one");
        }
        let predicate = literal.atom.predicate.index();
        let name = &self.semantics.predicates[predicate].name;
        if literal.atom.terms.len() != parameters.len() {
            let message = format!("`({name} ...)` and the word must speak of the same entities, `?self` included");
            self.report(&entry.fact, message);
        }
        let relations = entry.geometry.iter();
        let relations = relations.filter_map(|text| self.relation(text, call.arguments.len()));
        Some(StateWord {
            relations: relations.collect(),
            word: call.name,
            parameters: call.arguments,
            atom: literal.atom,
            means: entry.means.clone(),
        })
    }

    /// Reports relations in space that two state words say: a scene would not determine which of them is meant.
    fn report_repeated_relations(&mut self, entries: &[words::StateEntry]) {
        let given: Vec<_> = entries.iter().flat_map(|entry| &entry.geometry).collect();
        for (index, text) in given.iter().enumerate() {
            if given[..index].iter().any(|other| other.get_ref() == text.get_ref()) {
                let message = format!("`geometry` lists the relation `{}` twice", text.get_ref());
                self.report(text, message);
            }
        }
    }

    /// Returns a relation in space of a state word with so many arguments.
    fn relation(&mut self, text: &Spanned<String>, arguments: usize) -> Option<SpatialRelation> {
        let name = text.get_ref();
        let Some(relation) = SpatialRelation::ALL
            .into_iter()
            .find(|relation| relation.name() == name)
        else {
            let known = SpatialRelation::ALL.map(SpatialRelation::name);
            self.report_unknown(text, "relation of `geometry`", name, known);
            return None;
        };
        let fitting = relation.arguments();
        if !fitting.contains(&arguments) {
            let number = if fitting.start() == fitting.end() {
                fitting.end().to_string()
            } else {
                format!("{} or {}", fitting.start(), fitting.end())
            };
            let message =
                format!("a state of the relation `{name}` has {number} argument(s) in parentheses, not {arguments}");
            self.report(text, message);
        }
        Some(relation)
    }

    fn property(&mut self, entry: &words::PropertyEntry) -> PropertyWord {
        let literals = entry
            .facts
            .iter()
            .filter_map(|fact| self.literal(fact, &[self_parameter()]))
            .collect();
        PropertyWord {
            word: entry.word.get_ref().clone(),
            literals,
        }
    }

    fn derivation(&mut self, entry: &words::DeriveEntry) -> Derivation {
        let both = [self_parameter(), any_parameter("other")];
        let literals: Vec<Literal> = entry
            .facts
            .iter()
            .filter_map(|fact| self.literal(fact, &both))
            .collect();
        let when = entry
            .when
            .as_ref()
            .map_or(Condition::TRUE, |when| self.condition(when, &both));
        let mut binary = !entry.other_names.is_empty() || entry.pattern.is_some();
        for literal in &literals {
            binary |= literal.atom.terms.contains(&super::Term::Variable(1));
        }
        if let Some(pattern) = &entry.pattern
            && !pattern.get_ref().contains("{other}")
        {
            self.report(pattern, "a pattern needs `{other}` in it, as in `{other}_handle`");
        }
        let line = entry.facts.first().map_or(0, |fact| self.line(fact));
        Derivation {
            literals,
            names: self.name_endings(&entry.names),
            other_names: self.name_endings(&entry.other_names),
            pattern: entry.pattern.as_ref().map(|p| p.get_ref().to_lowercase()),
            when,
            written: entry.when.as_ref().map(|when| when.get_ref().clone()),
            binary,
            line,
        }
    }

    fn line(&self, text: &Spanned<String>) -> u32 {
        content_position(self.text, text).line
    }

    /// Returns the names of a derivation in the form that identifiers are compared in.
    fn name_endings(&mut self, names: &[Spanned<String>]) -> Vec<String> {
        let mut endings = Vec::with_capacity(names.len());
        for name in names {
            let ending = unified(name.get_ref());
            if ending.is_empty() {
                self.report(name, "a name without letters matches no identifier");
            } else {
                endings.push(ending);
            }
        }
        endings
    }

    /// Returns the article before everyday names; without one in the file it is the library's own.
    fn article(&mut self, written: Option<&Spanned<String>>) -> String {
        let Some(written) = written else {
            return ARTICLE.to_owned();
        };
        let article = written.get_ref().trim();
        if article.contains(char::is_whitespace) {
            self.report(written, "an article is one word; write an empty text for none");
        }
        article.to_owned()
    }

    /// Returns words for the speaker or the robot, as the names of an entity.
    fn entity_words(&mut self, words: &[Spanned<String>]) -> Vec<String> {
        let mut names = Vec::with_capacity(words.len());
        for word in words {
            let name = plain_words(word.get_ref()).join(" ");
            if name.is_empty() {
                self.report(word, "a name without letters names nothing");
            } else {
                names.push(name);
            }
        }
        names
    }
}

fn scope_of(parameters: &[Parameter]) -> Scope {
    parameters.iter().map(|p| (p.name.clone(), p.kind)).collect()
}

fn self_parameter() -> Parameter {
    any_parameter("self")
}

fn any_parameter(name: &str) -> Parameter {
    any_parameter_of(name, TypeId::OBJECT)
}

fn any_parameter_of(name: &str, kind: TypeId) -> Parameter {
    Parameter {
        name: name.to_owned(),
        kind,
    }
}

/// Returns the everyday names without their positions.
fn lexicon(entries: indexmap::IndexMap<Spanned<String>, Vec<Spanned<String>>>) -> Lexicon {
    let texts = |texts: Vec<Spanned<String>>| texts.into_iter().map(Spanned::into_inner).collect();
    let entries = entries.into_iter();
    Lexicon::new(entries.map(|(name, names)| (name.into_inner(), texts(names))).collect())
}

/// Returns the variables of the leading `forall`s of a condition, in order.
fn quantified_names(text: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut expression = sexpr::read("", text).ok().and_then(|mut e| e.pop());
    while let Some([variables, inner]) = expression.as_ref().and_then(|e| e.tail_of("forall")) {
        let words = variables
            .list()
            .unwrap_or_default()
            .iter()
            .filter_map(sexpr::Expression::word);
        names.extend(words.filter_map(|word| Some(word.strip_prefix('?')?.to_owned())));
        expression = Some(inner.clone());
    }
    names
}
