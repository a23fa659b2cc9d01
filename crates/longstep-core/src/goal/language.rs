//! The parser of goals.

use super::conditional::{IF, THEN, split_once};
use super::expansion::{self, Expansion};
use super::{Conditional, Goal, GoalFact, Group, NumberGoal, WrittenConditional};
use crate::call::{Call, find_unquoted, unquoted};
use crate::diagnostic::nearest;
use crate::model::{
    Distinctions, EntityId, Fact, FormPiece, GoalWord, GoalWordId, OutOfRange, Predicate, PredicateId, Prohibition,
    TypeId, ValueForm, World, ground, state_word,
};

/// The prefix of a question in a model's answer.
pub const QUESTION: &str = "question: ";

/// The word before the first goal of a stage.
pub const STAGE: &str = "then ";

/// Maximum number of stages.
const STAGES: usize = 30;

/// The largest number of entities that an error offers for a part of their names.
const LONGER_NAMES: usize = 4;

/// The separator after a goal, without the blank before the next one. Models write a blank and the following word as
/// one token, so the grammar must not split them.
pub const JOINT: &str = " &";

/// The reason why a text is not a goal.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum GoalError {
    /// An empty part between two `&`.
    #[error("the goal has an empty part")]
    Empty,
    /// A word that is not a goal word of the domain.
    #[error("`{part}` is not a goal of this domain; write {forms}")]
    UnknownWord {
        /// The part of the goal.
        part: String,
        /// The notations of the domain's goal words.
        forms: String,
    },
    /// More than thirty stages.
    #[error("the goal has more than {STAGES} stages; give the later ones as another instruction")]
    TooManyStages,
    /// A constraint on a fact that can hold in no state.
    #[error("`{part}` can hold in no state of this world, so a rule about it would forbid nothing")]
    NeverHolds {
        /// The constraint.
        part: String,
    },
    /// A goal in place of a rule.
    #[error("`{part}` is a goal and no rule; write `never {part}` or `always {part}`")]
    NotARule {
        /// The goal.
        part: String,
    },
    /// A name that no entity has.
    #[error("`{name}` in `{part}` is nothing in the environment{}", did_you_mean(near))]
    UnknownName {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// Entity names that resemble it: a few of which it is a part, or else the nearest one.
        near: Vec<String>,
    },
    /// A name in place of a value.
    #[error("`{name}` in `{part}` is no {kind}; write {form}")]
    NotAValue {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// The type of the values.
        kind: String,
        /// Their notation.
        form: String,
    },
    /// A quantity that is out of range for its type.
    #[error(transparent)]
    OutOfRange(#[from] OutOfRange),
    /// A value that the world does not have, since no text with it was given to [`World::add_values`].
    #[error("`{written}` is a value that was not added to the world")]
    NewValue {
        /// The value.
        written: String,
    },
    /// A name that several entities have.
    #[error("`{name}` in `{part}` is the name of several entities: {}; write one of these names", candidates.join(", "))]
    SharedName {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// The entities, each with its own name and what distinguishes it.
        candidates: Vec<String>,
    },
    /// A word for the speaker or the robot, in an environment that does not say which entity that is.
    #[error(
        "`{name}` in `{part}` is the {key}, and the environment does not say which entity that is; add `\"{key}\": \"<identifier>\"` to it"
    )]
    NobodyNamed {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// The key of the environment.
        key: &'static str,
    },
    /// A condition that no sensing action reveals.
    #[error("`{condition}` is nothing that sensing tells here, so no goal can depend on it{}", if forms.is_empty() { String::new() } else { format!("; write {forms}") })]
    NotSensed {
        /// The condition.
        condition: String,
        /// The facts that sensing actions reveal.
        forms: String,
    },
    /// A kind that no type and no entity has.
    #[error("`{kind}` in `{group}` is no type of the domain and no name in the environment{}", near.as_ref().map_or(String::new(), |n| format!("; did you mean `{n}`?")))]
    UnknownKind {
        /// The group.
        group: String,
        /// The kind.
        kind: String,
        /// A kind that resembles it.
        near: Option<String>,
    },
    /// A condition of a group that is no state, property or predicate.
    #[error(
        "`{state}` in `{group}` is no state; write it as an environment does, for example `dirty` or `on_something(table)`"
    )]
    UnknownState {
        /// The group.
        group: String,
        /// The condition.
        state: String,
    },
    /// A group without members.
    #[error("`{group}` has no member: {why}")]
    NoMember {
        /// The group.
        group: String,
        /// The entities of the kind, with the conditions that they fail.
        why: String,
    },
    /// A group that depends on an outcome of sensing that is not known.
    #[error(
        "the members of `{group}` are not known before sensing reveals whether {fact}; write a goal with `if` instead"
    )]
    NotSensedYet {
        /// The group.
        group: String,
        /// The fact.
        fact: String,
    },
    /// Fewer members than the goal requires.
    #[error("`{part}` requires {wanted} members, and the group has {members}; give a number from 1 to that")]
    TooFewMembers {
        /// The part of the goal.
        part: String,
        /// The number of members that the goal requires.
        wanted: usize,
        /// The number of members.
        members: usize,
    },
    /// Groups with too many combinations of members.
    #[error("`{part}` has more than {limit} combinations of members; add a condition with `where`")]
    TooManyMembers {
        /// The part of the goal.
        part: String,
        /// The limit.
        limit: usize,
    },
    /// A member of `all` that does not fit into the goal.
    #[error("`{name}` belongs to `{part}`, and this goal makes no sense for it; leave it out with `except {name}`")]
    DoesNotFit {
        /// The part of the goal.
        part: String,
        /// The member.
        name: String,
    },
    /// A count in a prohibition of steps.
    #[error("`{part}` counts the members of a group, which only goals can; write `all` or `any`")]
    CountOfSteps {
        /// The part of the goal.
        part: String,
    },
    /// A side of a comparison that is no number of the domain.
    #[error("`{text}` in `{part}` should be {expected}")]
    NotANumber {
        /// The part of the goal.
        part: String,
        /// The side of the comparison.
        text: String,
        /// The expected notation.
        expected: String,
    },
    /// An entity of the wrong type.
    #[error("`{name}` in `{part}` is no {expected}")]
    WrongType {
        /// The part of the goal.
        part: String,
        /// The name.
        name: String,
        /// The expected type.
        expected: String,
    },
}

/// Parses a goal: parts joined by `&`. A part is a goal word, or a state word with the subject as first argument:
/// `INSIDE(<pie>, <oven>)`. Entities are given by everyday name or identifier.
///
/// A part may depend on a sensed fact, in the form
/// `if expired(milk) then put(milk, bin) and closed(fridge) else put(milk, fridge)`. The word "and" joins the goals of
/// a branch, and the `else` branch is optional.
///
/// Goals after "then" are achieved after those before it: `wiped(table, cloth) then put(plate, table) & put(cup, table)`
/// ([`Purpose::stages`](crate::verify::Purpose::stages)). A goal of an earlier stage holds at the end too, unless a
/// later one excludes it: `at(robot, dock) then at(robot, office)`.
///
/// Constraints hold for the whole plan: `never opened(fridge)`, `always closed(door)`, `never grasp(cup, _)` for the calls
/// of an action, `untouched(vase)` for everything that concerns an entity.
///
/// A group stands for its members wherever a name can stand: `put(all cup where dirty & on_something(table) except mug, sink)`,
/// `put(any cup, table)`, `put(2 of plate, any shelf)`, `untouched(all glass)`. Its members are those in the given world.
///
/// # Errors
///
/// The error in the first unreadable part.
pub fn parse(world: &World, text: &str) -> Result<Goal, GoalError> {
    let mut goal = Goal::default();
    for part in parts_of(text) {
        let (begins, part) = match part.strip_prefix(STAGE) {
            Some(part) => (true, part.trim()),
            None => (false, part),
        };
        for (index, piece) in stages_of(part).into_iter().enumerate() {
            if piece.is_empty() {
                return Err(GoalError::Empty);
            }
            if begins || index > 0 {
                goal.begin_stage();
            }
            if goal.stages.len() >= STAGES {
                return Err(GoalError::TooManyStages);
            }
            goal.add(piece, self::part(world, piece)?);
        }
    }
    goal.end_stages();
    Ok(goal)
}

/// Splits a goal at each `&` outside of parentheses; within them it joins the conditions of a group.
fn parts_of(text: &str) -> Vec<&str> {
    let (mut depth, mut start) = (0_usize, 0);
    let mut parts = Vec::new();
    for (at, letter) in unquoted(text) {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            '&' if depth == 0 => {
                parts.push(text[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[start..].trim());
    parts
}

/// Parses rules that bind every plan until they are lifted: constraints of the goal language, joined by `&`.
///
/// ```
/// use longstep_core::{domain, environment, goal, search, search::Limits};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let rules = goal::rules(&world, "untouched(cup)").unwrap();
/// let world = world.with_prohibitions(rules);
/// let goal = goal::parse(&world, "put(cup, shelf)").unwrap();
/// let outcome = search::solve(&world, &goal.purpose(&world), &Limits::default());
/// assert!(matches!(outcome, search::Outcome::ProvenUnsolvable { .. }));
/// ```
///
/// # Errors
///
/// [`GoalError::NotARule`] for a goal; else the error in the first unreadable part.
pub fn rules(world: &World, text: &str) -> Result<Vec<Prohibition>, GoalError> {
    let goal = parse(world, text)?;
    if let Some(fact) = goal.facts.first() {
        return Err(GoalError::NotARule {
            part: fact.everyday(world),
        });
    }
    let rules = goal.constraints.iter();
    Ok(rules
        .map(|constraint| constraint.prohibition(world).standing())
        .collect())
}

/// Splits a part of a goal at each "then" that begins a stage; the "then" of a conditional goal does not.
fn stages_of(part: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let mut rest = part;
    loop {
        let of_conditional = match rest.strip_prefix(IF) {
            Some(_) => split_once(rest, THEN).map_or(0, |(condition, _)| condition.len() + THEN.len()),
            None => 0,
        };
        let Some((piece, after)) = split_once(&rest[of_conditional..], THEN) else {
            pieces.push(rest.trim());
            return pieces;
        };
        pieces.push(rest[..of_conditional + piece.len()].trim());
        rest = after.trim_start();
    }
}

/// Reads a part of a goal.
pub(super) fn part(world: &World, text: &str) -> Result<Expansion, GoalError> {
    match WrittenConditional::read(text) {
        Some(written) => conditional(world, &written),
        None => expansion::part(world, text),
    }
}

/// Reads a conditional goal; its branches cannot contain conditions.
fn conditional(world: &World, written: &WrittenConditional<'_>) -> Result<Expansion, GoalError> {
    let domain = world.domain();
    let condition = match state(world, written.condition)? {
        Some(fact) if domain.is_sensed(fact.predicate()) => fact,
        _ => {
            let sensed = domain
                .states
                .iter()
                .filter(|word| domain.is_sensed(word.atom.predicate));
            let forms: Vec<String> = sensed.map(|word| format!("`{}(...)`", word.word)).collect();
            return Err(GoalError::NotSensed {
                condition: written.condition.to_owned(),
                forms: forms.join(", "),
            });
        }
    };
    let mut groups: Vec<Group> = Vec::new();
    let mut side = |parts: &[&str]| {
        let mut facts: Vec<GoalFact> = Vec::new();
        for text in parts {
            if text.is_empty() {
                return Err(GoalError::Empty);
            }
            let part = expansion::goals(world, text)?;
            groups.extend(part.groups);
            for fact in part.facts {
                if !facts.contains(&fact) {
                    facts.push(fact);
                }
            }
        }
        Ok(facts)
    };
    let (then, otherwise) = (side(&written.then)?, side(&written.otherwise)?);
    let others: Vec<Fact> = domain
        .outcomes(condition)
        .into_iter()
        .filter(|o| *o != condition)
        .collect();
    let conditional = match (written.negated, &others[..]) {
        (false, _) => Conditional {
            condition,
            then,
            otherwise,
        },
        (true, [other]) => Conditional {
            condition: *other,
            then,
            otherwise,
        },
        (true, _) => Conditional {
            condition,
            then: otherwise,
            otherwise: then,
        },
    };
    Ok(Expansion {
        groups,
        ..GoalFact::If(conditional).into()
    })
}

/// Reads a fact in a state word, with the subject as first argument; none if the text has another form.
fn state(world: &World, part: &str) -> Result<Option<Fact>, GoalError> {
    let Ok(call) = Call::parse(part) else { return Ok(None) };
    let word = world
        .domain()
        .states
        .iter()
        .find(|s| s.word == call.name && s.parameters.len() + 1 == call.arguments.len());
    let Some(word) = word else {
        return bare(world, part, &call);
    };
    let names: Vec<&str> = call.arguments.iter().map(String::as_str).collect();
    let bindings = entities(world, part, &names, &vec![TypeId::OBJECT; names.len()])?;
    Ok(Some(ground(&word.atom, &bindings)))
}

/// Reads a fact of a predicate without a state word, by its name in PDDL; none if there is no such predicate.
fn bare(world: &World, part: &str, call: &Call) -> Result<Option<Fact>, GoalError> {
    let domain = world.domain();
    let is = |predicate: &Predicate| predicate.name == call.name && predicate.parameters.len() == call.arguments.len();
    let Some(index) = domain.predicates.iter().position(is) else {
        return Ok(None);
    };
    let id = PredicateId::new(index);
    if state_word(domain, id).is_some() || !domain.words(id).fluent {
        return Ok(None);
    }
    let names: Vec<&str> = call.arguments.iter().map(String::as_str).collect();
    let kinds = domain.predicates[index]
        .parameters
        .iter()
        .map(|parameter| parameter.kind);
    let arguments = entities(world, part, &names, &kinds.collect::<Vec<_>>())?;
    Ok(Some(Fact::new(id, arguments)))
}

pub(super) fn plain(world: &World, part: &str) -> Result<GoalFact, GoalError> {
    let domain = world.domain();
    if let Some(comparison) = NumberGoal::read(world, part)? {
        return Ok(comparison.into());
    }
    let mut error = None;
    for (index, word) in domain.goal_words.iter().enumerate() {
        let Some(names) = read_form(word, part) else { continue };
        let kinds: Vec<TypeId> = word.parameters.iter().map(|parameter| parameter.kind).collect();
        match entities(world, part, &names, &kinds) {
            Ok(arguments) => {
                return Ok(GoalFact::Word {
                    word: GoalWordId::new(index),
                    arguments,
                });
            }
            // Several forms of one word may match; the first error is the clearest, and best one in a form with known names
            // or with a shorter unknown one: `bench` and not `under bench`.
            Err(found) => match (&error, &found) {
                (Some(GoalError::UnknownName { .. }), GoalError::WrongType { .. }) | (None, _) => error = Some(found),
                (Some(GoalError::UnknownName { name: earlier, .. }), GoalError::UnknownName { name, .. })
                    if name.len() < earlier.len() =>
                {
                    error = Some(found)
                }
                _ => {}
            },
        }
    }
    if let Some(fact) = state(world, part)? {
        return Ok(GoalFact::Plain(fact));
    }
    Err(error.unwrap_or_else(|| {
        let mut forms: Vec<String> = domain
            .goal_words
            .iter()
            .map(|word| format!("`{}`", word.shown()))
            .collect();
        forms.dedup();
        GoalError::UnknownWord {
            part: part.chars().take(80).collect(),
            forms: forms.join(", "),
        }
    }))
}

/// Returns the names in a goal of this form, by parameter; none if the text has another form.
pub fn read_form<'t>(word: &GoalWord, text: &'t str) -> Option<Vec<&'t str>> {
    let mut names = vec![""; word.parameters.len()];
    let mut rest = text;
    let mut pieces = word.form.iter().peekable();
    while let Some(piece) = pieces.next() {
        match piece {
            FormPiece::Text(text) => rest = rest.strip_prefix(text.as_str())?,
            FormPiece::Parameter(index) => {
                let end = match pieces.peek() {
                    Some(FormPiece::Text(next)) if !next.is_empty() => find_unquoted(rest, next)?,
                    _ => rest.len(),
                };
                names[*index] = rest[..end].trim();
                rest = &rest[end..];
            }
        }
    }
    rest.is_empty().then_some(names)
}

pub(super) fn entities(
    world: &World,
    part: &str,
    names: &[&str],
    kinds: &[TypeId],
) -> Result<Vec<EntityId>, GoalError> {
    let domain = world.domain();
    let mut entities = Vec::with_capacity(names.len());
    for (name, kind) in names.iter().zip(kinds) {
        let named = world.named(name);
        let fitting = named.iter().copied();
        let fitting: Vec<EntityId> = fitting.filter(|entity| world.is_of_kind(*entity, *kind)).collect();
        let (part, name) = (part.to_owned(), (*name).to_owned());
        match (&fitting[..], &named[..]) {
            ([entity], _) => entities.push(*entity),
            ([], []) => return Err(unknown_name(world, part, name, *kind)),
            ([], _) => {
                let expected = domain.types.name(*kind).to_owned();
                return Err(GoalError::WrongType { part, name, expected });
            }
            _ => {
                let mut candidates = Distinctions::of(world).describe(&fitting);
                if candidates.len() < fitting.len() {
                    candidates.push(format!("and {} more", fitting.len() - candidates.len()));
                }
                return Err(GoalError::SharedName { part, name, candidates });
            }
        }
    }
    Ok(entities)
}

fn did_you_mean(near: &[String]) -> String {
    match near {
        [] => String::new(),
        near => format!("; did you mean `{}`?", near.join("` or `")),
    }
}

fn unknown_name(world: &World, part: String, name: String, kind: TypeId) -> GoalError {
    let domain = world.domain();
    match domain.value(&name) {
        Some(Err(beyond)) => return GoalError::OutOfRange(beyond),
        Some(Ok(value)) => return GoalError::NewValue { written: value.written },
        None => {}
    }
    let folded = name.to_lowercase();
    let keys = [("speaker", &domain.speaker_names), ("robot", &domain.robot_names)];
    if let Some((key, _)) = keys.into_iter().find(|(_, names)| names.contains(&folded)) {
        return GoalError::NobodyNamed { part, name, key };
    }
    if let Some(values) = domain.values.iter().find(|values| values.kind == kind) {
        return GoalError::NotAValue {
            kind: domain.types.name(kind).to_owned(),
            form: match &values.form {
                ValueForm::Text => format!("a text in double quotes: `{name:?}`"),
                ValueForm::Quantity(form) if form.unit.is_empty() => "a number".to_owned(),
                ValueForm::Quantity(form) => format!("a number with its unit, `{}`", form.unit),
            },
            part,
            name,
        };
    }
    let known = || world.entities().map(|(_, entity)| entity.name.as_str());
    let is_part_of = |known: &&str| {
        let known = known.to_lowercase();
        known.strip_suffix(&folded).is_some_and(|rest| rest.ends_with(' '))
    };
    let longer = known().filter(is_part_of).take(LONGER_NAMES);
    let mut near: Vec<String> = longer.map(str::to_owned).collect();
    if near.is_empty() {
        near.extend(nearest(&name, known()).map(str::to_owned));
    }
    GoalError::UnknownName { part, name, near }
}
