//! Goals about numbers: `level(tank) >= 3`, `battery >= 20`, `level(tank) < level(bucket)`.

use super::relative::{self, Change};
use super::{GoalError, GoalFact, names};
use longstep_model::call::Call;
use longstep_model::model::{
    Application, Arithmetic, Comparison, Condition, Domain, EntityId, Fluent, Function, FunctionId, GroundTest, Number,
    NumberTest, Term, TypeId, Voice, Wanted, When, World,
};

/// A comparison of a fluent with a number or with another fluent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct NumberGoal {
    /// The left side.
    pub fluent: Fluent,
    /// The comparison.
    pub comparison: Comparison,
    /// The right side.
    pub operand: Operand,
}

/// The right side of a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Operand {
    /// A number.
    Number(Number),
    /// Another fluent.
    Fluent(Fluent),
}

/// A comparison as written, not yet resolved.
struct Written<'t> {
    function: FunctionId,
    call: Call,
    comparison: Comparison,
    right: &'t str,
}

impl NumberGoal {
    /// Reads a comparison; none if the text has another form.
    ///
    /// # Errors
    ///
    /// The error in the comparison.
    pub(super) fn read(world: &World, part: &str) -> Result<Option<Self>, GoalError> {
        let Some(written) = written(world.domain(), part) else {
            return Ok(None);
        };
        let fluent = fluent(world, part, written.function, &written.call)?;
        let operand = operand(world, part, fluent, written.right)?;
        Ok(Some(Self {
            fluent,
            comparison: written.comparison,
            operand,
        }))
    }

    /// Writes the comparison in the goal language; `name` gives the name of each entity.
    pub(super) fn written(&self, domain: &Domain, name: &dyn Fn(EntityId) -> String) -> String {
        let fluent = |fluent: Fluent| written_fluent(domain, fluent, name);
        let right = match self.operand {
            Operand::Number(number) => number.to_string(),
            Operand::Fluent(other) => fluent(other),
        };
        format!("{} {} {right}", fluent(self.fluent), self.comparison)
    }

    /// Writes the comparison as a sentence.
    pub(super) fn sentence(&self, voice: Voice, world: &World) -> String {
        let right = match self.operand {
            Operand::Number(number) => Arithmetic::Constant(number),
            Operand::Fluent(other) => Arithmetic::Value(other),
        };
        let test = GroundTest::Compare(Arithmetic::Value(self.fluent), self.comparison, right);
        voice.requirement(world, &test)
    }

    /// Returns the fluents of the comparison.
    fn fluents(&self) -> impl Iterator<Item = Fluent> + use<> {
        let other = match self.operand {
            Operand::Number(_) => None,
            Operand::Fluent(other) => Some(other),
        };
        std::iter::once(self.fluent).chain(other)
    }

    /// Returns the entities of the comparison, in order.
    pub(super) fn about(&self, domain: &Domain) -> Vec<EntityId> {
        self.fluents().flat_map(|fluent| domain.arguments_of(fluent)).collect()
    }

    /// Maps the comparison to another world; none if an entity is missing there.
    pub(super) fn carried(&self, domain: &Domain, there: impl Fn(EntityId) -> Option<EntityId>) -> Option<Self> {
        let carried = |fluent: Fluent| carried_fluent(domain, fluent, &there);
        Some(Self {
            fluent: carried(self.fluent)?,
            operand: match self.operand {
                Operand::Fluent(other) => Operand::Fluent(carried(other)?),
                number @ Operand::Number(_) => number,
            },
            ..*self
        })
    }

    /// Returns the condition to achieve.
    pub(super) fn wanted(&self, domain: &Domain) -> Wanted {
        let bindings = self.about(domain);
        let mut slots = (0..bindings.len()).map(Term::Variable);
        let left = application(domain, self.fluent, &mut slots);
        let right = match self.operand {
            Operand::Number(number) => Arithmetic::Constant(number),
            Operand::Fluent(other) => application(domain, other, &mut slots),
        };
        Wanted {
            condition: Condition::Number(NumberTest::Compare(left, self.comparison, right)),
            bindings,
        }
    }
}

fn written_fluent(domain: &Domain, fluent: Fluent, name: &dyn Fn(EntityId) -> String) -> String {
    let arguments: Vec<String> = domain.arguments_of(fluent).map(name).collect();
    format!("{}({})", domain.function(fluent.function()).word, arguments.join(", "))
}

fn carried_fluent(domain: &Domain, fluent: Fluent, there: impl Fn(EntityId) -> Option<EntityId>) -> Option<Fluent> {
    let arguments = domain.arguments_of(fluent).map(there).collect::<Option<Vec<_>>>()?;
    Some(Fluent::new(fluent.function(), arguments))
}

/// Returns the number of a fluent with the next slots as its arguments.
fn application(domain: &Domain, fluent: Fluent, slots: &mut impl Iterator<Item = Term>) -> Arithmetic<Application> {
    let arity = domain.function(fluent.function()).parameters.len();
    Arithmetic::Value(Application {
        function: fluent.function(),
        terms: slots.take(arity).collect(),
        at: When::Now,
    })
}

impl From<NumberGoal> for GoalFact {
    fn from(goal: NumberGoal) -> Self {
        Self::Number(goal)
    }
}

/// Splits a comparison whose left side is a numeric function. Identifiers may contain `<` and `>`, so the comparison comes
/// after the parenthesis of the call, or after a name without one.
fn written<'t>(domain: &Domain, part: &'t str) -> Option<Written<'t>> {
    let name_end = part.find(|c: char| !(c.is_alphanumeric() || matches!(c, '_' | '-')))?;
    let left_end = if part[name_end..].trim_start().starts_with('(') {
        part.find(')')? + 1
    } else {
        name_end
    };
    let call = Call::parse(&part[..left_end]).ok()?;
    let rest = part[left_end..].trim_start();
    // `ALL` has `<=` before its prefix `<`.
    let comparison = Comparison::ALL.into_iter().find(|own| rest.starts_with(own.symbol()))?;
    let place = domain
        .functions
        .iter()
        .position(|function| function.word == call.name)?;
    Some(Written {
        function: FunctionId::new(place),
        call,
        comparison,
        right: rest[comparison.symbol().len()..].trim(),
    })
}

/// Resolves the entities of a fluent.
fn fluent(world: &World, part: &str, function: FunctionId, call: &Call) -> Result<Fluent, GoalError> {
    let own = world.domain().function(function);
    if own.parameters.len() != call.arguments.len() {
        return Err(GoalError::NotANumber {
            part: part.to_owned(),
            text: call.to_string(),
            expected: form(own),
        });
    }
    let names: Vec<&str> = call.arguments.iter().map(String::as_str).collect();
    let kinds: Vec<TypeId> = own.parameters.iter().map(|parameter| parameter.kind).collect();
    let arguments = names::entities(world, part, &names, &kinds)?;
    Ok(Fluent::new(function, arguments))
}

/// Resolves the right side: a number, which may have the unit of the left side, a change of what is now, or another fluent.
fn operand(world: &World, part: &str, left: Fluent, text: &str) -> Result<Operand, GoalError> {
    let domain = world.domain();
    let own = domain.function(left.function());
    if let Some(change) = Change::read(text) {
        let unit = own.unit.as_deref().unwrap_or_default();
        let changed = world.state.number(left).and_then(|now| change.of(now, unit));
        return changed
            .map(Operand::Number)
            .ok_or_else(|| relative::unknown(part, text));
    }
    let without_unit = own.unit.as_ref().and_then(|unit| text.strip_suffix(unit.as_str()));
    if let Some(number) = Number::parse(text).or_else(|| Number::parse(without_unit?.trim_end())) {
        return Ok(Operand::Number(number));
    }
    let call = Call::parse(text).ok();
    let other = call.and_then(|call| {
        let place = domain
            .functions
            .iter()
            .position(|function| function.word == call.name)?;
        Some((FunctionId::new(place), call))
    });
    match other {
        Some((function, call)) => fluent(world, part, function, &call).map(Operand::Fluent),
        None => Err(GoalError::NotANumber {
            part: part.to_owned(),
            text: text.chars().take(80).collect(),
            expected: match &own.unit {
                Some(unit) => format!("a number in {unit}"),
                None => "a number".to_owned(),
            },
        }),
    }
}

/// Returns the notation of a fluent: `level(TANK)`.
fn form(function: &Function) -> String {
    let names: Vec<String> = function.parameters.iter().map(|own| own.name.to_uppercase()).collect();
    format!("`{}({})`", function.word, names.join(", "))
}
