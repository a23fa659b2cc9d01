//! The answer of a model: the whole goal language, as a form for an engine that masks tokens, and its reading.

use indexmap::IndexMap;
use longstep_core::model::written_fact;

use super::left_out::{LeftOut, LeftOutKind};
use super::sayable;
use crate::dialogue::DialogueError;
use crate::dialogue::answer_grammar::Form;
use crate::environment::{EntityId, World};
use crate::goal::{self, ALWAYS, Dependence, Goal, IF, Mentions, NEVER, NOT, THEN};
use crate::model::{FormPiece, Function, GoalWord};

/// The largest number of goals in a stage, and of constraints.
const PARTS: usize = 8;
/// The largest number of stages.
const STAGES: usize = 6;
/// The word before the words of an instruction that the goal does not say, and their kind.
const LEFT_OUT: &str = " | left out ";
/// The beginning of an answer that asks the person.
const QUESTION: &str = "question:";

/// An answer to an instruction.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Answer {
    /// The goal; none if the model asks.
    pub goal: Option<Goal>,
    /// The words of the instruction that the goal does not say.
    pub left_out: Vec<LeftOut>,
}

/// Reads an answer.
///
/// # Errors
///
/// The answer is no goal in this world.
pub fn read(world: &World, text: &str) -> Result<Answer, DialogueError> {
    let text = text.trim();
    if text.starts_with(QUESTION) {
        return Ok(Answer::default());
    }
    let mut parts = text.split(LEFT_OUT);
    let goal = parts.next().unwrap_or_default();
    let left_out = parts.filter_map(|part| {
        let (kind, words) = part.split_once(": ")?;
        Some(LeftOut {
            text: words.trim().to_owned(),
            kind: LeftOutKind::read(kind)?,
        })
    });
    Ok(Answer {
        left_out: left_out.collect(),
        goal: Some(goal::parse(world, goal)?),
    })
}

/// Returns the form of an answer to an instruction in a world. `asks` admits a question.
pub(super) fn form(world: &World, instruction: &str, asks: bool) -> Form {
    let parts = Parts::of(world);
    let wish = parts.goals();
    let constraint = parts.constraints();
    let together = || Form::text(" & ");
    let mut ways = Vec::new();
    if asks {
        ways.push(Form::text(QUESTION));
    }
    if let Some(constraint) = constraint {
        let alone = constraint.clone().separated(together(), PARTS);
        if let Some(wish) = wish {
            let stages = wish.separated(together(), PARTS).separated(Form::text(" then "), STAGES);
            let more = Form::Row(vec![together(), alone.clone()]).optional();
            ways.push(with_left_out(Form::Row(vec![stages, more]), instruction));
        }
        ways.push(with_left_out(alone, instruction));
    } else if let Some(wish) = wish {
        let stages = wish.separated(together(), PARTS).separated(Form::text(" then "), STAGES);
        ways.push(with_left_out(stages, instruction));
    }
    Form::Either(ways)
}

fn with_left_out(answer: Form, instruction: &str) -> Form {
    match spans(instruction) {
        Some(spans) => Form::Row(vec![
            answer,
            Form::Row(vec![
                Form::text(LEFT_OUT),
                Form::texts(LeftOutKind::ALL.map(|kind| format!("{kind}: "))),
                spans,
            ])
            .optional(),
        ]),
        None => answer,
    }
}

/// Returns the form of any run of words of an instruction; of a script without spaces, any run of its letters.
fn spans(instruction: &str) -> Option<Form> {
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
        let own = match after.take() {
            None => Form::text(word),
            Some(after) => Form::Row(vec![
                Form::text(word),
                Form::Row(vec![Form::text(between), after]).optional(),
            ]),
        };
        let own = own.shared();
        all.push(own.clone());
        after = Some(own);
    }
    (!all.is_empty()).then(|| Form::Either(all))
}

/// The parts of which answers in a world consist.
struct Parts<'a> {
    world: &'a World,
    /// The forms of groups, by their lists of possible members.
    groups: std::cell::RefCell<IndexMap<Vec<EntityId>, Form>>,
}

impl<'a> Parts<'a> {
    fn of(world: &'a World) -> Self {
        Self {
            world,
            groups: Default::default(),
        }
    }

    /// Returns the form of a goal; none if the domain has nothing to ask for.
    fn goals(&self) -> Option<Form> {
        let domain = self.world.domain();
        let words = domain.goal_words.iter();
        let mut simple: Vec<Form> = words
            .flat_map(|word| self.word(word, sayable::arguments(self.world, word)))
            .collect();
        simple.extend(domain.functions.iter().filter_map(|function| self.comparison(function)));
        if simple.is_empty() {
            return None;
        }
        let simple = Form::Either(simple).shared();
        let conditions = goal::conditions(self.world, &Mentions::default());
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
        let states: Vec<Form> = words.flat_map(|word| self.word(word, self.products(word))).collect();
        let mut ways = Vec::new();
        if !states.is_empty() {
            let before = Form::texts([NEVER.to_owned(), ALWAYS.to_owned()]);
            ways.push(Form::Row(vec![before, Form::Either(states)]));
        }
        let all: Vec<EntityId> = self.world.entities().map(|(id, _)| id).skip(domain.constants.len()).collect();
        if !all.is_empty() {
            ways.push(Form::Row(vec![Form::text("untouched("), self.argument(&all), Form::text(")")]));
        }
        (!ways.is_empty()).then(|| Form::Either(ways).shared())
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
    fn word(&self, word: &GoalWord, arguments: Vec<Vec<EntityId>>) -> Vec<Form> {
        if arguments.is_empty() {
            return Vec::new();
        }
        let mut exact = Vec::new();
        exact_arguments(&word.form, self.world, &arguments, &mut exact);
        let mut forms = vec![Form::Row(exact)];
        for grouped in 0..word.parameters.len() {
            let members = column(&arguments, grouped);
            if members.iter().any(|member| self.world.entity(*member).is_value) {
                continue;
            }
            let pieces = word.form.iter().map(|piece| match piece {
                FormPiece::Text(text) => Form::text(text),
                FormPiece::Parameter(index) if *index == grouped => self.group(&members),
                FormPiece::Parameter(index) => self.argument(&column(&arguments, *index)),
            });
            forms.push(Form::Row(pieces.collect()));
        }
        forms
    }

    /// Returns the form of one of the entities, or of a group of them.
    fn argument(&self, entities: &[EntityId]) -> Form {
        let names = entities.iter().map(|entity| self.world.entity(*entity).name.clone());
        Form::Either(vec![Form::texts(names), self.group(entities)])
    }

    /// Returns the form of a group with some of these members.
    fn group(&self, members: &[EntityId]) -> Form {
        if let Some(known) = self.groups.borrow().get(members) {
            return known.clone();
        }
        let quantifiers = ["all ", "any "].map(str::to_owned).into_iter();
        let counts = (2..=members.len().clamp(2, 9)).flat_map(|count| [format!("{count} of "), format!("exactly {count} of ")]);
        let kinds = Form::texts(sayable::kinds(self.world, members));
        let mut parts = vec![Form::texts(quantifiers.chain(counts)), kinds];
        let states = sayable::states(self.world, members);
        if !states.is_empty() {
            let states = Form::texts(states).separated(Form::text(" & "), 2);
            parts.push(Form::Row(vec![Form::text(" where "), states]).optional());
        }
        let names = members.iter().map(|member| self.world.entity(*member).name.clone());
        let names = Form::texts(names).shared();
        let several = names.clone().separated(Form::text(", "), 4);
        let except = Form::Either(vec![
            names,
            Form::Row(vec![Form::text("("), several, Form::text(")")]),
        ]);
        parts.push(Form::Row(vec![Form::text(" except "), except]).optional());
        let form = Form::Row(parts).shared();
        self.groups.borrow_mut().insert(members.to_vec(), form.clone());
        form
    }

    /// Returns the form of a comparison of a number.
    fn comparison(&self, function: &Function) -> Option<Form> {
        if !function.changes {
            return None;
        }
        let mut parts = vec![Form::text(&function.word)];
        for (place, parameter) in function.parameters.iter().enumerate() {
            let own = self.world.of_kind(parameter.kind);
            if own.is_empty() {
                return None;
            }
            parts.push(Form::text(if place == 0 { "(" } else { ", " }));
            parts.push(self.argument(own));
        }
        if !function.parameters.is_empty() {
            parts.push(Form::text(")"));
        }
        let symbols = [" >= ", " <= ", " = ", " > ", " < "].map(str::to_owned);
        parts.push(Form::texts(symbols));
        parts.push(Form::Pattern("-?[0-9]{1,6}(\\.[0-9]{1,3})?".to_owned()));
        if let Some(unit) = &function.unit {
            parts.push(Form::text(format!(" {unit}")).optional());
        }
        Some(Form::Row(parts))
    }

    /// Returns the condition of a goal, up to "then".
    fn condition(&self, depends: &Dependence) -> String {
        let name = |entity: EntityId| self.world.entity(entity).name.clone();
        let not = if depends.negated { NOT } else { "" };
        format!("{IF}{not}{}{THEN}", written_fact(self.world.domain(), depends.fact, &name))
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
