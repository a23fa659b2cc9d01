//! The text of a new `domain.toml`.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::Blueprint;
use longstep_core::domain::DeclarationPositions;

use super::wording::{self, PredicateText, capitalized, identifier};
use longstep::domain::{ActionId, Atom, Condition, Parameter, Predicate, Term, TypeId};
use longstep_core::call::{is_goal_keyword, is_script_keyword};
use longstep_core::diagnostic::Diagnostic;
use longstep_core::model::{DerivedPredicate, Domain, PredicateId};

/// The words of a domain: one entry for each predicate, function and action, in the order of the PDDL file.
pub(super) struct Words {
    pub(super) predicates: Vec<(String, PredicateText)>,
    actions: Vec<(String, String)>,
    functions: Vec<String>,
    /// The names that a notation reserves, in the order of the lists of predicates, numeric functions and actions.
    pub(super) renamed: Vec<Renamed>,
}

/// The list of a domain that a name is in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Declared {
    Predicate,
    Function,
    Action,
}

/// A name of the PDDL file that has another word, since a notation reserves it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Renamed {
    pub(super) list: Declared,
    pub(super) index: usize,
    /// The name as a word.
    pub(super) name: String,
    /// The word in `domain.toml`.
    pub(super) word: String,
}

impl Renamed {
    /// Returns the note for the author, at the place of the name.
    pub(super) fn note(&self, file: &str, positions: &DeclarationPositions) -> Diagnostic {
        let (all, notation) = match self.list {
            Declared::Predicate => (&positions.predicates, "the goal language"),
            Declared::Function => (&positions.functions, "the goal language"),
            Declared::Action => (&positions.actions, "the notation of plans"),
        };
        let message = format!(
            "`{}` is a word of {notation}; domain.toml has `{}` for it",
            self.name, self.word
        );
        match all.get(self.index) {
            Some(position) => Diagnostic::at(file, *position, message),
            None => Diagnostic::whole(file, message),
        }
    }
}

/// Gives names their words, each another one.
#[derive(Default)]
struct Naming {
    taken: BTreeMap<String, usize>,
    renamed: Vec<Renamed>,
}

impl Naming {
    fn word(&mut self, list: Declared, index: usize, pddl_name: &str) -> String {
        let name = identifier(pddl_name);
        let other = match list {
            Declared::Predicate => is_goal_keyword(&name).then(|| format!("is_{name}")),
            Declared::Function => is_goal_keyword(&name).then(|| format!("{name}_number")),
            Declared::Action => is_script_keyword(&name).then(|| format!("do_{name}")),
        };
        let Some(other) = other else {
            return unique(name, &mut self.taken);
        };
        let word = unique(other, &mut self.taken);
        self.renamed.push(Renamed {
            list,
            index,
            name,
            word: word.clone(),
        });
        word
    }
}

impl Words {
    pub(super) fn of(domain: &Domain, blueprint: &Blueprint) -> Self {
        let mut words = Naming::default();
        let predicates = domain.predicates.iter().zip(&domain.predicate_words).enumerate();
        let predicates = predicates.map(|(index, (predicate, own))| {
            let given = blueprint.predicates.get(&predicate.name).cloned();
            let text = given.unwrap_or_else(|| wording::predicate(domain, predicate, own.fluent));
            (words.word(Declared::Predicate, index, &predicate.name), text)
        });
        let predicates = predicates.collect();
        let functions = domain.functions.iter().enumerate();
        let functions = functions.map(|(index, own)| words.word(Declared::Function, index, &own.name));
        let functions = functions.collect();
        let mut calls = Naming::default();
        let actions = domain.action_ids().enumerate().map(|(index, (id, action))| {
            let given = blueprint.actions.get(&action.name).cloned();
            let says = given.unwrap_or_else(|| wording::action(domain, id));
            (calls.word(Declared::Action, index, &action.name), says)
        });
        let actions = actions.collect();
        words.renamed.append(&mut calls.renamed);
        Self {
            predicates,
            actions,
            functions,
            renamed: words.renamed,
        }
    }
}

/// Returns the name, with a number if it is taken.
fn unique(name: String, taken: &mut BTreeMap<String, usize>) -> String {
    let count = taken.entry(name.clone()).or_insert(0);
    *count += 1;
    match *count {
        1 => name,
        count => unique(format!("{name}_{count}"), taken),
    }
}

/// Quotes a text for TOML; JSON's escapes are TOML's.
pub(super) fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// Fills the holes of a sentence.
fn filled(says: &str, parameters: &[Parameter], fill: impl Fn(usize, &str) -> String) -> String {
    let holes = parameters.iter().enumerate();
    holes.fold(says.to_owned(), |text, (index, parameter)| {
        text.replace(&format!("{{{}}}", parameter.name), &fill(index, &parameter.name))
    })
}

fn typed(domain: &Domain, parameters: &[Parameter]) -> String {
    let typed = parameters.iter().map(|parameter| match parameter.kind {
        TypeId::OBJECT => format!("?{} - object", parameter.name),
        kind => format!("?{} - {}", parameter.name, domain.types.name(kind)),
    });
    typed.collect::<Vec<_>>().join(" ")
}

/// A kind of goal in the new domain: a predicate, or its opposite.
struct NewGoal<'d> {
    index: usize,
    predicate: &'d Predicate,
    holds: bool,
    /// The actions that achieve it.
    by: Vec<usize>,
}

/// Returns the goals of a domain: every fact that an action makes true, and the opposite of facts about one entity
/// that an action does nothing but take away ("close", "switch off").
fn goals(domain: &Domain) -> Vec<NewGoal<'_>> {
    let mut goals = Vec::new();
    for (index, predicate) in domain.predicates.iter().enumerate() {
        let touches = |adds: bool| {
            let actions = domain.actions.iter().enumerate();
            let touching = actions.filter(move |(_, action)| {
                let mut effects = action.effects.iter();
                effects.any(|effect| effect.adds == adds && effect.atom.predicate.index() == index)
            });
            touching.map(|(index, _)| index)
        };
        let by: Vec<usize> = match domain.derived.iter().find(|own| own.predicate.index() == index) {
            Some(derived) => bringing(domain, derived),
            None => touches(true).collect(),
        };
        if !by.is_empty() {
            goals.push(NewGoal {
                index,
                predicate,
                holds: true,
                by,
            });
        }
        let only_removes = |action: &usize| domain.actions[*action].effects.iter().all(|effect| !effect.adds);
        let by: Vec<usize> = touches(false).filter(only_removes).collect();
        if !by.is_empty() && predicate.parameters.len() == 1 {
            goals.push(NewGoal {
                index,
                predicate,
                holds: false,
                by,
            });
        }
    }
    goals
}

/// Returns the actions that change what a derived predicate is made from, at most three.
fn bringing(domain: &Domain, derived: &DerivedPredicate) -> Vec<usize> {
    let parts: Vec<PredicateId> = derived.condition.atoms().map(|(atom, _)| atom.predicate).collect();
    let actions = domain.actions.iter().enumerate();
    let touching = actions.filter(|(_, action)| action.effects.iter().any(|own| parts.contains(&own.atom.predicate)));
    touching.map(|(index, _)| index).take(3).collect()
}

/// Returns the condition on the arguments of a goal: different ones, of the kinds that the actions ask for with facts
/// that never change (`(ball ?x)`), which is how untyped files say types.
fn offered(domain: &Domain, goal: &NewGoal<'_>) -> Option<String> {
    let parameters = &goal.predicate.parameters;
    let mut parts = Vec::new();
    for (place, left) in parameters.iter().enumerate() {
        for right in &parameters[place + 1..] {
            if domain.types.is_a(left.kind, right.kind) || domain.types.is_a(right.kind, left.kind) {
                parts.push(format!("(not (= ?{} ?{}))", left.name, right.name));
            }
        }
        let kinds = goal.by.iter().map(|index| {
            let action = &domain.actions[*index];
            let mut effects = action.effects.iter();
            let own = effects.find(|e| e.adds == goal.holds && e.atom.predicate.index() == goal.index);
            match own.and_then(|effect| effect.atom.terms.get(place)) {
                Some(Term::Variable(slot)) if *slot < action.parameters.len() => {
                    unary_statics(domain, &action.precondition, *slot)
                }
                _ => Vec::new(),
            }
        });
        let shared = kinds.reduce(|left, right| left.into_iter().filter(|kind| right.contains(kind)).collect());
        for kind in shared.unwrap_or_default() {
            parts.push(format!("({} ?{})", domain.predicates[kind].name, left.name));
        }
    }
    match parts.len() {
        0 => None,
        1 => parts.pop(),
        _ => Some(format!("(and {})", parts.join(" "))),
    }
}

/// Returns the predicates about one entity that no action changes and that the condition asks of a variable.
pub(super) fn unary_statics(domain: &Domain, condition: &Condition, slot: usize) -> Vec<usize> {
    let parts = condition.conjuncts().filter_map(|part| match part {
        Condition::Atom {
            atom: Atom { predicate, terms },
            holds: true,
            ..
        } => Some((predicate.index(), terms)),
        _ => None,
    });
    let about = parts.filter(|(predicate, terms)| {
        terms.as_slice() == [Term::Variable(slot)] && !domain.predicate_words[*predicate].fluent
    });
    about.map(|(predicate, _)| predicate).collect()
}

/// Writes `domain.toml`.
pub(super) fn write(blueprint: &Blueprint, domain: &Domain, words: &Words, lists: (TypeId, TypeId)) -> String {
    let mut text = String::new();
    // Writing to a string does not fail.
    let _ = write_all(&mut text, blueprint, domain, words, lists);
    text
}

fn write_all(
    text: &mut String,
    blueprint: &Blueprint,
    domain: &Domain,
    words: &Words,
    (assets, objects): (TypeId, TypeId),
) -> std::fmt::Result {
    writeln!(
        text,
        "#:schema ./schemas/domain.schema.json\n\
         # The words for domain.pddl. Read every sentence aloud and change those that sound wrong: people and models\n\
         # read them. docs/reference/domains.md explains each key.\n\n\
         name = {}\nabout = {}\n\n\
         # What the two lists of an environment hold.\n[environment]\nassets = {}\nobjects = {}\n\n\
         # A sentence for every fact, and for its opposite. `short` is how a language model sees it in the line of its\n\
         # first argument.",
        quoted(&blueprint.name),
        quoted(&blueprint.about),
        quoted(domain.types.name(assets)),
        quoted(domain.types.name(objects)),
    )?;
    for (predicate, (_, sentence)) in domain.predicates.iter().zip(&words.predicates) {
        let (name, says, denies) = (&predicate.name, &sentence.says, &sentence.denies);
        writeln!(text, "[[predicate]]\nname = {}", quoted(name))?;
        writeln!(text, "says = {}\ndenies = {}", quoted(says), quoted(denies))?;
        if let Some(short) = &sentence.short {
            writeln!(text, "short = {}", quoted(short))?;
        }
        text.push('\n');
    }
    text.push_str("# How an environment writes a fact under the entry of an entity, which is ?self.\n");
    let is_derived = |index: usize| domain.derived.iter().any(|own| own.predicate.index() == index);
    let stated = domain.predicates.iter().zip(&words.predicates).enumerate();
    // What is derived follows from other facts.
    for (_, (predicate, (word, sentence))) in stated.filter(|(index, _)| !is_derived(*index)) {
        let Some((_, others)) = predicate.parameters.split_first() else {
            continue;
        };
        let holes: Vec<String> = others.iter().map(|p| format!("<{}>", p.name)).collect();
        let variables: String = others.iter().map(|p| format!(" ?{}", p.name)).collect();
        let means = filled(&sentence.says, &predicate.parameters, |index, name| match index {
            0 => "this".to_owned(),
            _ => format!("<{name}>"),
        });
        writeln!(
            text,
            "[[state]]\nword = {}",
            quoted(&format!("{word}({})", holes.join(", ")))
        )?;
        writeln!(
            text,
            "fact = {}",
            quoted(&format!("({} ?self{variables})", predicate.name))
        )?;
        writeln!(text, "means = {}\n", quoted(&format!("{}.", capitalized(&means))))?;
    }
    for (function, word) in domain.functions.iter().zip(&words.functions) {
        let holes: Vec<String> = function.parameters.iter().map(|p| format!("{{{}}}", p.name)).collect();
        let spoken = wording::words(&function.name).join(" ");
        let says = match holes.len() {
            0 => format!("the {spoken}"),
            1 => format!("the {spoken} of {}", holes[0]),
            _ => format!("the {spoken} between {}", holes.join(" and ")),
        };
        writeln!(
            text,
            "[[number]]\nname = {}\nword = {}",
            quoted(&function.name),
            quoted(word)
        )?;
        writeln!(text, "says = {}\n", quoted(&says))?;
    }
    text.push_str("# How a plan writes an action, and the sentence for a step.\n");
    for ((id, action), (call, says)) in domain.action_ids().zip(&words.actions) {
        // An argument that the sentence leaves out is found by the verifier.
        let is_said = |name: &str| says.contains(&format!("{{{name}}}"));
        let shown = action.parameters.iter().filter(|p| is_said(&p.name));
        let shown: Vec<String> = shown.map(|p| format!("?{}", p.name)).collect();
        writeln!(text, "[[action]]\nname = {}", quoted(&action.name))?;
        writeln!(text, "call = {}", quoted(&format!("{call}({})", shown.join(", "))))?;
        writeln!(text, "says = {}", quoted(says))?;
        writeln!(text, "means = {}\n", quoted(&purpose(domain, words, id, says)))?;
    }
    text.push_str("# What a person can ask for. A model answers in these words, and search finds the steps.\n");
    for goal in goals(domain) {
        let (word, sentence) = &words.predicates[goal.index];
        let parameters = &goal.predicate.parameters;
        let holes: Vec<String> = parameters.iter().map(|p| format!("{{{}}}", p.name)).collect();
        let variables: String = parameters.iter().map(|p| format!(" ?{}", p.name)).collect();
        let fact = format!("({}{variables})", goal.predicate.name);
        let (word, fact, says) = if goal.holds {
            (word.clone(), fact, &sentence.says)
        } else {
            (format!("not_{word}"), format!("(not {fact})"), &sentence.denies)
        };
        let by: Vec<&str> = goal.by.iter().map(|index| words.actions[*index].0.as_str()).collect();
        let means = filled(says, parameters, |_, name| format!("the {name}"));
        writeln!(
            text,
            "[[goal]]\nform = {}",
            quoted(&format!("{word}({})", holes.join(", ")))
        )?;
        writeln!(text, "parameters = {}", quoted(&typed(domain, parameters)))?;
        writeln!(text, "condition = {}", quoted(&fact))?;
        if let Some(offered) = offered(domain, &goal) {
            writeln!(text, "offered = {}", quoted(&offered))?;
        }
        writeln!(text, "says = {}", quoted(says))?;
        writeln!(
            text,
            "means = {}\n",
            quoted(&format!("{means} (by {})", by.join(" or ")))
        )?;
    }
    text.push_str(
        "# Everyday names for identifiers: the one that is shown, a longer one, and other words for it, for example\n\
         # tube = [\"tube\", \"sample tube\", \"vial\"]\n[lexicon]\n",
    );
    for (identifier, names) in &blueprint.lexicon {
        let names: Vec<String> = names.iter().map(|name| quoted(name)).collect();
        writeln!(text, "{} = [{}]", quoted(identifier), names.join(", "))?;
    }
    Ok(())
}

/// Returns the explanation of an action for a model: its sentence, and what it makes true.
fn purpose(domain: &Domain, words: &Words, id: ActionId, says: &str) -> String {
    let action = domain.action(id);
    let mut results = Vec::new();
    for effect in action.effects.iter().filter(|effect| effect.forall.is_empty()) {
        let predicate = domain.predicate(effect.atom.predicate);
        let sentence = &words.predicates[effect.atom.predicate.index()].1;
        let name = |index: usize| match effect.atom.terms[index] {
            Term::Variable(slot) => action.parameters.get(slot).map(|p| format!("the {}", p.name)),
            Term::Constant(constant) => domain.constants.get(constant.index()).map(|(name, _)| name.clone()),
        };
        let says = if effect.adds { &sentence.says } else { &sentence.denies };
        let text = filled(says, &predicate.parameters, |index, _| name(index).unwrap_or_default());
        // What becomes true says more than what stops being true.
        results.push((!effect.adds, text));
    }
    results.sort_by_key(|(removed, _)| *removed);
    results.truncate(3);
    let spoken = filled(says, &action.parameters, |_, name| format!("the {name}"));
    let results: Vec<String> = results.into_iter().map(|(_, text)| text).collect();
    if results.is_empty() {
        format!("{}.", capitalized(&spoken))
    } else {
        format!("{}. After it: {}.", capitalized(&spoken), results.join("; "))
    }
}
