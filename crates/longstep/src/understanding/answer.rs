//! The answer of a model: the whole goal language, as a form for an engine that masks tokens, and its reading.

use std::cell::RefCell;

use indexmap::IndexMap;
use longstep_core::model::written_fact;

use super::sayable::{self, fact_word, other_predicates};
use crate::coverage::{Gap, LeftOut};
use crate::dialogue::DialogueError;
use crate::dialogue::answer_grammar::Form;
use crate::environment::{EntityId, World};
use crate::goal::{self, ALWAYS, Goal, IF, NEVER, NOT, THEN, UNTIL};
use crate::instruction::{self, Dependence};
use crate::model::{FormPiece, Function, GoalWord, Parameter, PredicateId, TypeId, ValueForm};

/// The largest number of goals in a stage, and of constraints.
const PARTS: usize = 8;
/// The largest number of stages.
const STAGES: usize = 6;
/// The largest number of parts of an instruction that an answer leaves out.
const LEFT_OUT_PARTS: usize = 3;
/// The word before the words of an instruction that the goal does not say, and their kind.
const LEFT_OUT: &str = " | left out ";
/// The notation of any entity in a goal that is forbidden.
const ANYTHING: &str = "_";
/// A number.
const NUMBER: &str = "-?[0-9]{1,6}(\\.[0-9]{1,3})?";
/// The largest number of names in a list.
const LISTED: usize = 4;
/// The beginning of an answer that asks the person.
const QUESTION: &str = goal::QUESTION.trim_ascii_end();

/// An answer to an instruction.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct ModelAnswer {
    /// The goal; none if the model asks.
    pub(super) goal: Option<Goal>,
    /// The words of the instruction that the goal does not say.
    pub(super) left_out: Vec<LeftOut>,
}

/// Returns the form of the prohibitions behind a goal; none if nothing can be forbidden in the world.
pub(super) fn more_constraints(world: &World) -> Option<Form> {
    let parts = Parts::of(world, "");
    let more = parts.constraints()?.separated(Form::text(" & "), PARTS);
    Some(Form::Row(vec![Form::text(" & "), more]))
}

/// Splits an answer into its goal and the words that the goal does not say.
pub(super) fn split(text: &str) -> (&str, Vec<LeftOut>) {
    let mut parts = text.trim().split(LEFT_OUT);
    let goal = parts.next().unwrap_or_default();
    let left_out = parts.filter_map(|part| {
        let (kind, words) = part.split_once(": ")?;
        Some(LeftOut {
            text: words.trim().to_owned(),
            kind: Gap::named(kind)?,
        })
    });
    (goal, left_out.collect())
}

/// Reads an answer: a goal, or a question, which has none. What cannot hold together is meant one after the other: "take the cup to the sink
/// and then bring it back".
///
/// # Errors
///
/// The answer is no goal in this world.
pub(super) fn read(world: &World, text: &str) -> Result<ModelAnswer, DialogueError> {
    if text.trim().starts_with(QUESTION) {
        return Ok(ModelAnswer::default());
    }
    let (goal, left_out) = split(text);
    let goal = goal::parse(world, goal)?;
    Ok(ModelAnswer {
        goal: Some(goal.in_order(world).unwrap_or(goal)),
        left_out,
    })
}

/// Returns true if there is anything to ask for, or to forbid, in a world.
pub(super) fn can_say_goals(world: &World) -> bool {
    let parts = Parts::of(world, "");
    parts.goals().is_some() || parts.constraints().is_some()
}

/// Returns the form of an answer to an instruction in a world. `asks` admits a question.
pub(super) fn form(world: &World, instruction: &str, asks: bool) -> Form {
    let parts = Parts::of(world, instruction);
    let together = || Form::text(" & ");
    let wish = parts.goals().map(|wish| {
        wish.separated(together(), PARTS)
            .separated(Form::text(" then "), STAGES)
    });
    let alone = parts
        .constraints()
        .map(|constraint| constraint.separated(together(), PARTS).shared());
    let mut ways = Vec::new();
    if asks {
        ways.push(Form::text(QUESTION));
    }
    if let Some(wish) = wish {
        let more = alone.clone().map(|alone| Form::Row(vec![together(), alone]).optional());
        let goal = std::iter::once(wish).chain(more).collect();
        ways.push(parts.with_left_out(Form::Row(goal)));
    }
    ways.extend(alone.map(|alone| parts.with_left_out(alone)));
    Form::Either(ways)
}

/// Returns the form of any run of words of an instruction; of a script without spaces, any run of its letters. A run may begin and end
/// without the punctuation of its words: of "only half?" it is "only half".
fn spans(instruction: &str) -> Option<Form> {
    // A text in a goal stands between double quotes.
    let instruction = instruction.replace(['"', '\\'], " ");
    let mut words: Vec<String> = instruction.split_whitespace().map(str::to_owned).collect();
    let mut between = " ";
    let has_no_spaces = |word: &String| word.chars().filter(|letter| !letter.is_ascii()).count() > 8;
    if words.iter().any(has_no_spaces) {
        words = instruction.chars().map(String::from).collect();
        between = "";
    }
    words.truncate(160);
    // From the last word on: this word, and perhaps what follows it.
    let mut after: Option<Form> = None;
    let mut all = Vec::new();
    for word in words.iter().rev() {
        let bare = word.trim_start_matches(|letter: char| !letter.is_alphanumeric());
        let inner = bare.trim_end_matches(|letter: char| !letter.is_alphanumeric());
        let (before, bare, behind) = if inner.is_empty() {
            ("", word.as_str(), "")
        } else {
            (&word[..word.len() - bare.len()], inner, &bare[inner.len()..])
        };
        let more = after.take().map(|after| Form::Row(vec![Form::text(between), after]));
        let more = match behind {
            "" => more,
            _ => {
                let rest = std::iter::once(Form::text(behind)).chain(more.map(Form::optional));
                Some(Form::Row(rest.collect()))
            }
        };
        let from_here = std::iter::once(Form::text(bare)).chain(more.map(Form::optional));
        let own = Form::Row(from_here.collect()).shared();
        all.push(own.clone());
        after = Some(if before.is_empty() {
            own
        } else {
            let whole = Form::Row(vec![Form::text(before), own]).shared();
            all.push(whole.clone());
            whole
        });
    }
    (!all.is_empty()).then_some(Form::Either(all))
}

/// The parts of which answers in a world consist.
struct Parts<'a> {
    world: &'a World,
    /// Runs of words of the instruction; none if it has no words.
    spans: Option<Form>,
    /// The forms of groups, by their lists of possible members.
    groups: RefCell<IndexMap<Vec<EntityId>, Form>>,
    /// The form of a goal without a condition, once it is known.
    simple: RefCell<Option<Option<Form>>>,
}

impl<'a> Parts<'a> {
    fn of(world: &'a World, instruction: &str) -> Self {
        Self {
            world,
            spans: spans(instruction).map(Form::shared),
            groups: RefCell::default(),
            simple: RefCell::default(),
        }
    }

    fn with_left_out(&self, answer: Form) -> Form {
        let Some(spans) = self.spans.clone() else {
            return answer;
        };
        let kinds = Form::texts(Gap::ALL.map(|kind| format!("{}: ", kind.name())));
        let words = Form::Row(vec![Form::text(LEFT_OUT), kinds, spans]);
        Form::Row(vec![answer, words.times(0, LEFT_OUT_PARTS)])
    }

    /// Returns the form of a goal without a condition; none if the domain has nothing to ask for.
    fn simple_goals(&self) -> Option<Form> {
        if let Some(known) = &*self.simple.borrow() {
            return known.clone();
        }
        let domain = self.world.domain();
        let words = domain.goal_words.iter();
        let mut simple: Vec<Form> = words
            .flat_map(|word| {
                if self.takes_values(word) {
                    self.word_with_values(word).into_iter().collect()
                } else {
                    self.word(word, instruction::sayable(self.world, word), false)
                }
            })
            .collect();
        simple.extend(domain.functions.iter().filter_map(|function| self.comparison(function)));
        let form = (!simple.is_empty()).then(|| Form::Either(simple).shared());
        self.simple.borrow_mut().replace(form.clone());
        form
    }

    /// Returns the form of a goal; none if the domain has nothing to ask for.
    fn goals(&self) -> Option<Form> {
        let simple = self.simple_goals()?;
        let conditions = instruction::conditions(self.world);
        if conditions.is_empty() {
            return Some(simple);
        }
        let conditions = Form::texts(conditions.iter().map(|depends| self.condition(depends)));
        let branch = simple.clone().separated(Form::text(" and "), 3).shared();
        let otherwise = Form::Row(vec![Form::text(" else "), branch.clone()]).optional();
        let conditional = Form::Row(vec![conditions, Form::text(" "), branch, otherwise]);
        Some(Form::Either(vec![simple, conditional]).shared())
    }

    /// Returns the form of a constraint.
    fn constraints(&self) -> Option<Form> {
        let domain = self.world.domain();
        let words = domain.goal_words.iter();
        let mut states: Vec<Form> = words
            .flat_map(|word| {
                if self.takes_values(word) {
                    self.word_with_values(word).into_iter().collect()
                } else {
                    self.word(word, self.products(word), true)
                }
            })
            .collect();
        states.extend(other_predicates(domain).into_iter().filter_map(|id| self.predicate(id)));
        let mut ways = Vec::new();
        if !states.is_empty() {
            let before = Form::texts([NEVER.to_owned(), ALWAYS.to_owned()]);
            ways.push(Form::Row(vec![before, Form::Either(states)]));
        }
        let all: Vec<EntityId> = self
            .world
            .entities()
            .filter(|(_, entity)| !entity.is_value)
            .map(|(id, _)| id)
            .skip(domain.constants.len())
            .collect();
        if !all.is_empty() {
            ways.push(Form::Row(vec![
                Form::text("untouched("),
                self.argument(&all, false),
                Form::text(")"),
            ]));
        }
        let until = self
            .simple_goals()
            .map(|goal| Form::Row(vec![Form::text(UNTIL), goal]).optional());
        (!ways.is_empty()).then(|| Form::Row(std::iter::once(Form::Either(ways)).chain(until).collect()).shared())
    }

    /// Returns the form of a fact that no goal word is about; none if no entity fits.
    fn predicate(&self, id: PredicateId) -> Option<Form> {
        let domain = self.world.domain();
        self.call(&fact_word(domain, id), &domain.predicate(id).parameters, true)
    }

    /// Returns the form of a word with arguments; none if no entity fits. `is_forbidden` admits any entity.
    fn call(&self, word: &str, parameters: &[Parameter], is_forbidden: bool) -> Option<Form> {
        let mut parts = vec![Form::text(word), Form::text("(")];
        for (place, parameter) in parameters.iter().enumerate() {
            let own = self.world.of_kind(parameter.kind);
            if own.is_empty() {
                return None;
            }
            if place > 0 {
                parts.push(Form::text(", "));
            }
            parts.push(self.argument(own, is_forbidden));
        }
        parts.push(Form::text(")"));
        Some(Form::Row(parts))
    }

    /// Returns true if a goal word has a number or a text.
    fn takes_values(&self, word: &GoalWord) -> bool {
        word.parameters.iter().any(|own| self.value(own.kind).is_some())
    }

    /// Returns the form of the values of a type; none if it has none.
    fn value(&self, kind: TypeId) -> Option<Form> {
        let domain = self.world.domain();
        let value = domain.values.iter().find(|value| value.kind == kind)?;
        match &value.form {
            ValueForm::Text => {
                let spans = self.spans.clone()?;
                Some(Form::Row(vec![Form::text("\""), spans, Form::text("\"")]))
            }
            ValueForm::Quantity(form) => {
                let number = Form::Pattern(format!("(now [-+] )?{NUMBER}"));
                let units = std::iter::once(&form.unit).chain(form.units.iter().map(|(unit, _)| unit));
                let units = Form::texts(units.filter(|unit| !unit.is_empty()).map(|unit| format!(" {unit}")));
                let twice = Form::Pattern(format!("now \\* {NUMBER}"));
                Some(if form.unit.is_empty() {
                    Form::Either(vec![number, twice])
                } else {
                    Form::Either(vec![Form::Row(vec![number, units]), twice])
                })
            }
        }
    }

    /// Returns the form of a goal word with any number or text in its place; none if no entity fits.
    fn word_with_values(&self, word: &GoalWord) -> Option<Form> {
        let mut parts = Vec::new();
        for piece in &word.form {
            parts.push(match piece {
                FormPiece::Text(text) => Form::text(text),
                FormPiece::Parameter(index) => {
                    let kind = word.parameters[*index].kind;
                    match self.value(kind) {
                        Some(value) => value,
                        None if self.world.of_kind(kind).is_empty() => return None,
                        None => self.argument(&self.fitting(word, *index), false),
                    }
                }
            });
        }
        Some(Form::Row(parts))
    }

    /// Returns the entities for which a goal word with a value makes sense, as far as a known value shows it.
    fn fitting(&self, word: &GoalWord, parameter: usize) -> Vec<EntityId> {
        match column(&instruction::sayable(self.world, word), parameter) {
            known if known.is_empty() => self.world.of_kind(word.parameters[parameter].kind).to_vec(),
            known => known,
        }
    }

    /// Returns all argument lists of a word by the types of its parameters.
    fn products(&self, word: &GoalWord) -> Vec<Vec<EntityId>> {
        let mut all: Vec<Vec<EntityId>> = vec![Vec::new()];
        for parameter in &word.parameters {
            let own = self.world.of_kind(parameter.kind);
            if all.len() * own.len() > 20_000 {
                return Vec::new();
            }
            all = all
                .iter()
                .flat_map(|before| {
                    let own = own.iter().filter(|entity| !before.contains(entity));
                    own.map(|entity| [&before[..], &[*entity]].concat())
                })
                .collect();
        }
        all
    }

    /// Returns the forms of a goal word: with these arguments, and with groups in their places.
    fn word(&self, word: &GoalWord, arguments: Vec<Vec<EntityId>>, is_forbidden: bool) -> Vec<Form> {
        if arguments.is_empty() {
            return Vec::new();
        }
        let mut exact = Vec::new();
        exact_arguments(&word.form, self.world, &arguments, &mut exact);
        let mut forms = vec![Form::Row(exact)];
        for grouped in 0..word.parameters.len() {
            let members = column(&arguments, grouped);
            let pieces = word.form.iter().map(|piece| match piece {
                FormPiece::Text(text) => Form::text(text),
                FormPiece::Parameter(index) if *index == grouped && is_forbidden => {
                    Form::Either(vec![Form::text(ANYTHING), self.group(&members)])
                }
                FormPiece::Parameter(index) if *index == grouped => self.group(&members),
                FormPiece::Parameter(index) => self.argument(&column(&arguments, *index), is_forbidden),
            });
            forms.push(Form::Row(pieces.collect()));
        }
        forms
    }

    /// Returns the form of one of the entities, or of a group of them; of anything where the goal is forbidden.
    fn argument(&self, entities: &[EntityId], is_forbidden: bool) -> Form {
        let names = entities.iter().map(|entity| self.world.entity(*entity).name.clone());
        let anything = is_forbidden.then(|| Form::text(ANYTHING));
        let named = [Form::texts(names), self.group(entities)];
        Form::Either(named.into_iter().chain(anything).collect())
    }

    /// Returns the form of a group with some of these members.
    fn group(&self, members: &[EntityId]) -> Form {
        if let Some(known) = self.groups.borrow().get(members) {
            return known.clone();
        }
        let most = members.len().clamp(2, 9);
        let counts = (2..=most).flat_map(|count| [format!("{count} of "), format!("exactly {count} of ")]);
        let but = (1..most).map(|count| format!("all but {count} of "));
        let quantifiers = ["all ", "any "].map(str::to_owned).into_iter().chain(counts).chain(but);
        let kinds = Form::texts(sayable::kinds(self.world, members));
        let mut parts = vec![Form::texts(quantifiers), kinds];
        let states = sayable::states(self.world, members);
        if !states.is_empty() {
            let states = Form::texts(states).shared();
            let more = Form::Row(vec![Form::texts([" & ", " or "].map(str::to_owned)), states.clone()]);
            parts.push(Form::Row(vec![Form::text(" where "), states, more.optional()]).optional());
        }
        let names = members.iter().map(|member| self.world.entity(*member).name.clone());
        let names = Form::texts(names).shared();
        let several = names.clone().separated(Form::text(", "), LISTED).shared();
        let except = Form::Either(vec![
            names,
            Form::Row(vec![Form::text("("), several.clone(), Form::text(")")]),
        ]);
        parts.push(Form::Row(vec![Form::text(" except "), except]).optional());
        let of_kind = Form::Row(parts);
        let before = ["any of (", "2 of (", "3 of ("].map(str::to_owned);
        let listed = Form::Row(vec![Form::texts(before), several, Form::text(")")]);
        let form = Form::Either(vec![of_kind, listed]).shared();
        self.groups.borrow_mut().insert(members.to_vec(), form.clone());
        form
    }

    /// Returns the form of a comparison of a number.
    fn comparison(&self, function: &Function) -> Option<Form> {
        if !function.changes {
            return None;
        }
        let mut parts = vec![self.call(&function.word, &function.parameters, false)?];
        let symbols = [" >= ", " <= ", " = ", " > ", " < "].map(str::to_owned);
        parts.push(Form::texts(symbols));
        parts.push(Form::Pattern(format!("(now [-+*] )?{NUMBER}")));
        if let Some(unit) = &function.unit {
            parts.push(Form::text(format!(" {unit}")).optional());
        }
        Some(Form::Row(parts))
    }

    /// Returns the condition of a goal, up to "then".
    fn condition(&self, depends: &Dependence) -> String {
        let name = |entity: EntityId| self.world.entity(entity).name.clone();
        let not = if depends.negated { NOT } else { "" };
        format!(
            "{IF}{not}{}{THEN}",
            written_fact(self.world.domain(), depends.fact, &name)
        )
    }
}

/// Returns the entities in one place of argument lists, in the order of the world.
fn column(arguments: &[Vec<EntityId>], place: usize) -> Vec<EntityId> {
    let mut column: Vec<EntityId> = arguments.iter().map(|own| own[place]).collect();
    column.sort_unstable();
    column.dedup();
    column
}

/// Appends the rest of a form, given the remaining argument lists. Entities with equal continuations share one form.
fn exact_arguments(form: &[FormPiece], world: &World, arguments: &[Vec<EntityId>], parts: &mut Vec<Form>) {
    let Some((piece, rest)) = form.split_first() else {
        return;
    };
    let index = match piece {
        FormPiece::Text(text) => {
            parts.push(Form::text(text));
            return exact_arguments(rest, world, arguments, parts);
        }
        FormPiece::Parameter(index) => *index,
    };
    let mut continuations: IndexMap<EntityId, Vec<Vec<EntityId>>> = IndexMap::new();
    for bindings in arguments {
        let mut others = bindings.clone();
        others[index] = EntityId::new(0);
        continuations.entry(bindings[index]).or_default().push(others);
    }
    let mut groups: IndexMap<Vec<Vec<EntityId>>, Vec<EntityId>> = IndexMap::new();
    for (entity, others) in continuations {
        groups.entry(others).or_default().push(entity);
    }
    let alternatives = groups.into_iter().map(|(others, entities)| {
        let names = entities.iter().map(|entity| world.entity(*entity).name.clone());
        let mut parts = vec![Form::texts(names)];
        exact_arguments(rest, world, &others, &mut parts);
        Form::Row(parts)
    });
    parts.push(Form::Either(alternatives.collect()));
}
