//! Amounts relative to the amount that is now: `now + 2 degC`, `now - 1`, `now * 2`.

use std::borrow::Cow;

use super::names::{entities, read_form};
use super::{GoalError, STAGE, UNTIL};
use longstep_model::model::{
    Domain, EntityId, Fact, GoalWord, Number, PredicateId, QuantityForm, Term, ValueForm, World,
};

/// The word for the amount that is now.
const NOW: &str = "now";
/// The largest number of values that one text adds to a world.
// Each value is an entity, and every action that takes values is grounded with it.
const VALUES: usize = 50;

/// A change of an amount, as written.
pub(super) struct Change<'t> {
    operation: char,
    number: Number,
    unit: &'t str,
}

impl<'t> Change<'t> {
    /// Reads `now + 2 degC`; none if the text has another form.
    pub(super) fn read(text: &'t str) -> Option<Self> {
        let rest = text.trim().strip_prefix(NOW)?.trim_start();
        let operation = rest.chars().next().filter(|own| "+-*".contains(*own))?;
        let rest = rest[operation.len_utf8()..].trim_start();
        let is_digit = |own: char| own.is_ascii_digit() || own == '.';
        let end = rest.find(|own| !is_digit(own)).unwrap_or(rest.len());
        Some(Self {
            operation,
            number: Number::parse(&rest[..end])?,
            unit: rest[end..].trim(),
        })
    }

    /// Returns the changed amount. `unit` is that in which the amount is written. None if the change has another unit, or the
    /// result is too large.
    pub(super) fn of(&self, now: Number, unit: &str) -> Option<Number> {
        if self.unit.is_empty() || self.unit == unit {
            self.changed(now, Number::from(1))
        } else {
            None
        }
    }

    fn changed(&self, now: Number, factor: Number) -> Option<Number> {
        match self.operation {
            '+' => now.plus(self.number.times(factor)?),
            '-' => now.minus(self.number.times(factor)?),
            _ => now.times(self.number).filter(|_| self.unit.is_empty()),
        }
    }

    /// Returns the changed value of a quantity, as it is written.
    fn of_quantity(&self, domain: &Domain, form: &QuantityForm, now: &str) -> Option<String> {
        let now = domain.value(now)?.ok()?.number?;
        let own = form.units.iter().find(|(unit, _)| *unit == self.unit);
        let factor = if self.unit.is_empty() {
            Number::from(1)
        } else {
            own.map(|(_, factor)| *factor)?
        };
        Some(form.written(self.changed(now, factor)?))
    }
}

/// Adds the values in a text of goals to a world, and those that are relative to what is now.
///
/// The text may be anything that a person or a model wrote: what has another form is left to [`parse`](super::parse). Values are those
/// that the domain's goals take, in its units; numbers of an environment need none.
///
/// ```
/// use longstep_model::{domain, environment};
/// use longstep_search::goal;
/// let household = domain::shipped("household").unwrap()?;
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let mut world = environment::parse(&household, "desk.json", text)?;
/// goal::add_values(&mut world, "put(pen, desk)");
/// assert!(goal::parse(&world, "put(pen, desk)").is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn add_values(world: &mut World, text: &str) {
    world.add_values(text);
    if !text.contains(NOW) {
        return;
    }
    let mut parts = vec![text];
    // A coarse split is enough: a part that is no goal adds no value.
    for separator in [" & ", STAGE, " and ", " else ", UNTIL] {
        parts = parts.into_iter().flat_map(|part| part.split(separator)).collect();
    }
    let changes = parts.into_iter().filter(|part| part.contains(NOW)).flat_map(|part| {
        let part = [super::NEVER, super::ALWAYS]
            .iter()
            .find_map(|word| part.strip_prefix(word))
            .unwrap_or(part);
        values_in(world, part.trim())
    });
    for value in changes.take(VALUES).collect::<Vec<_>>() {
        world.add_values(&value);
    }
}

/// Returns the values that a part of a goal may mean, whatever it is about.
fn values_in(world: &World, part: &str) -> Vec<String> {
    let domain = world.domain();
    let mut values = Vec::new();
    for word in &domain.goal_words {
        let Some(names) = read_form(word, part) else { continue };
        for (place, name) in names.iter().enumerate() {
            let (Some(change), Some(amount)) = (Change::read(name), Amount::of(domain, word, place)) else {
                continue;
            };
            // The names are not resolved yet, so any of these facts may be meant.
            let facts = world.state.iter().filter(|fact| fact.predicate() == amount.predicate);
            values.extend(facts.filter_map(|fact| amount.changed(world, &change, fact)));
        }
    }
    values
}

/// Returns the names of a goal with the values in place of amounts that are relative.
///
/// # Errors
///
/// The amount that is now is not known.
pub(super) fn resolved<'t>(
    world: &World,
    part: &str,
    word: &GoalWord,
    names: &[&'t str],
) -> Result<Vec<Cow<'t, str>>, GoalError> {
    let mut resolved: Vec<Cow<'t, str>> = names.iter().map(|name| Cow::Borrowed(*name)).collect();
    for (place, name) in names.iter().enumerate() {
        let Some(change) = Change::read(name) else { continue };
        let amount = match Amount::of(world.domain(), word, place) {
            Some(amount) => amount,
            None if is_quantity(world.domain(), word, place) => return Err(unknown(part, name)),
            None => continue,
        };
        let known = names
            .iter()
            .zip(&word.parameters)
            .enumerate()
            .map(|(other, (own, parameter))| {
                // A relative amount names no entity; the fact that is looked for has it.
                if other == place || Change::read(own).is_some() {
                    return Ok(None);
                }
                entities(world, part, &[own], &[parameter.kind]).map(|found| found.first().copied())
            });
        let known = known.collect::<Result<Vec<Option<EntityId>>, GoalError>>()?;
        let value = world.state.iter().find_map(|fact| {
            let is_own = fact.predicate() == amount.predicate && amount.is_about(fact, &known);
            is_own.then(|| amount.changed(world, &change, fact)).flatten()
        });
        resolved[place] = Cow::Owned(value.ok_or_else(|| unknown(part, name))?);
    }
    Ok(resolved)
}

fn is_quantity(domain: &Domain, word: &GoalWord, parameter: usize) -> bool {
    let kind = word.parameters[parameter].kind;
    let mut values = domain.values.iter();
    values.any(|value| value.kind == kind && value.form != ValueForm::Text)
}

/// The error for an amount that is not known.
pub(super) fn unknown(part: &str, text: &str) -> GoalError {
    GoalError::UnknownNow {
        part: part.to_owned(),
        text: text.to_owned(),
    }
}

/// Where a state has the amount of a goal word.
struct Amount<'d> {
    predicate: PredicateId,
    terms: &'d [Term],
    /// The place of the amount in the facts.
    place: usize,
    form: &'d QuantityForm,
}

impl<'d> Amount<'d> {
    fn of(domain: &'d Domain, word: &'d GoalWord, parameter: usize) -> Option<Self> {
        let kind = word.parameters[parameter].kind;
        let value = domain.values.iter().find(|value| value.kind == kind)?;
        let ValueForm::Quantity(form) = &value.form else {
            return None;
        };
        word.condition
            .atoms()
            .filter(|(_, holds)| *holds)
            .find_map(|(atom, _)| {
                let place = atom.terms.iter().position(|term| *term == Term::Variable(parameter))?;
                Some(Self {
                    predicate: atom.predicate,
                    terms: &atom.terms,
                    place,
                    form,
                })
            })
    }

    /// Returns true if a fact has these entities in the places of the goal's parameters.
    fn is_about(&self, fact: Fact, known: &[Option<EntityId>]) -> bool {
        self.terms.iter().enumerate().all(|(place, term)| match term {
            Term::Variable(slot) => known
                .get(*slot)
                .copied()
                .flatten()
                .is_none_or(|own| own == fact.argument(place)),
            Term::Constant(own) => *own == fact.argument(place),
        })
    }

    /// Returns the amount in a fact with the change, as it is written.
    fn changed(&self, world: &World, change: &Change<'_>, fact: Fact) -> Option<String> {
        let now = &world.entity(fact.argument(self.place)).identifier;
        change.of_quantity(world.domain(), self.form, now)
    }
}
