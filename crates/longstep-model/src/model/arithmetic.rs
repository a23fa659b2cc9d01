//! Numeric fluents, expressions over them and comparisons.

use std::fmt;

use super::{EntityId, Moment, Number, Slot, Term, When, World, grounded_term, id};

id!(
    /// A numeric function of a domain.
    FunctionId
);

/// A numeric function applied to entities, packed like a [`Fact`](super::Fact).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Fluent(u128);

impl Fluent {
    /// Creates the fluent that applies `function` to `arguments`, at most seven.
    pub fn new(function: FunctionId, arguments: impl IntoIterator<Item = EntityId>) -> Self {
        let mut packed = (function.index() as u128) << 112;
        for (place, argument) in arguments.into_iter().enumerate() {
            debug_assert!(place < 7);
            packed |= (argument.index() as u128) << (96 - 16 * place);
        }
        Self(packed)
    }

    /// The function.
    pub fn function(self) -> FunctionId {
        FunctionId::new((self.0 >> 112) as usize)
    }

    /// The argument at `place`, from 0; the arity is in the domain's function.
    pub fn argument(self, place: usize) -> EntityId {
        EntityId::new((self.0 >> (96 - 16 * place)) as usize & 0xffff)
    }
}

/// A numeric function applied to terms.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Application {
    /// The function.
    pub function: FunctionId,
    /// The arguments.
    pub terms: Vec<Term>,
    /// The state in which it is evaluated.
    pub at: When,
}

impl Application {
    /// Returns the fluent under `bindings`.
    pub fn ground(&self, bindings: &[EntityId]) -> Fluent {
        let arguments = self.terms.iter().map(|term| grounded_term(*term, bindings));
        Fluent::new(self.function, arguments)
    }

    /// Returns the number at a moment; none if it has none.
    fn number(&self, moment: Moment<'_>, bindings: &[EntityId]) -> Option<Number> {
        moment.state_of(self.at).number(self.ground(bindings))
    }

    /// Returns the application with other terms.
    pub(crate) fn with_terms(&self, term: &impl Fn(Term) -> Term) -> Self {
        Self {
            terms: self.terms.iter().map(|own| term(*own)).collect(),
            ..*self
        }
    }
}

/// A binary operation on numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Operation {
    /// `+`
    Plus,
    /// `-`
    Minus,
    /// `*`
    Times,
    /// `/`
    Over,
}

impl Operation {
    /// Returns the operation with this symbol.
    pub fn of(symbol: &str) -> Option<Self> {
        Some(match symbol {
            "+" => Self::Plus,
            "-" => Self::Minus,
            "*" => Self::Times,
            "/" => Self::Over,
            _ => return None,
        })
    }

    /// Returns the symbol.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Plus => "+",
            Self::Minus => "-",
            Self::Times => "*",
            Self::Over => "/",
        }
    }

    /// Returns the result; none if it does not fit or is undefined.
    pub(crate) fn apply(self, left: Number, right: Number) -> Option<Number> {
        match self {
            Self::Plus => left.plus(right),
            Self::Minus => left.minus(right),
            Self::Times => left.times(right),
            Self::Over => left.over(right),
        }
    }
}

/// A numeric expression over values of one kind: applications, fluents, or numbers of variables of a search.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Arithmetic<V> {
    /// A number.
    Constant(Number),
    /// A value that depends on the state.
    Value(V),
    /// An operation on two expressions.
    Operation(Operation, Box<Arithmetic<V>>, Box<Arithmetic<V>>),
}

/// A numeric expression of a domain, over variables.
pub type NumericExpression = Arithmetic<Application>;

/// A numeric expression over the fluents of a world.
pub type GroundExpression = Arithmetic<Fluent>;

impl<V> Arithmetic<V> {
    /// Creates an operation.
    pub fn operation(operation: Operation, left: Self, right: Self) -> Self {
        Self::Operation(operation, Box::new(left), Box::new(right))
    }

    /// Evaluates the expression; none if a value is undefined, a division is by zero, or a result does not fit.
    pub fn evaluate(&self, value: &impl Fn(&V) -> Option<Number>) -> Option<Number> {
        match self {
            Self::Constant(number) => Some(*number),
            Self::Value(own) => value(own),
            Self::Operation(operation, left, right) => operation.apply(left.evaluate(value)?, right.evaluate(value)?),
        }
    }

    /// Replaces each value by an expression; operations on constants are computed if they can be.
    pub fn map<W>(&self, value: &mut impl FnMut(&V) -> Arithmetic<W>) -> Arithmetic<W> {
        match self {
            Self::Constant(number) => Arithmetic::Constant(*number),
            Self::Value(own) => value(own),
            Self::Operation(operation, left, right) => {
                let (left, right) = (left.map(value), right.map(value));
                if let (Arithmetic::Constant(left), Arithmetic::Constant(right)) = (&left, &right)
                    && let Some(result) = operation.apply(*left, *right)
                {
                    return Arithmetic::Constant(result);
                }
                Arithmetic::operation(*operation, left, right)
            }
        }
    }

    /// Calls `visit` with each value.
    pub fn for_each(&self, visit: &mut impl FnMut(&V)) {
        match self {
            Self::Constant(_) => {}
            Self::Value(own) => visit(own),
            Self::Operation(_, left, right) => {
                left.for_each(visit);
                right.for_each(visit);
            }
        }
    }

    /// Writes the expression with infix operators; `value` writes a value.
    pub fn written(&self, value: &impl Fn(&V) -> String) -> String {
        match self {
            Self::Constant(number) => number.to_string(),
            Self::Value(own) => value(own),
            Self::Operation(operation, left, right) => {
                let side = |side: &Self| match side {
                    Self::Operation(..) => format!("({})", side.written(value)),
                    _ => side.written(value),
                };
                format!("{} {} {}", side(left), operation.symbol(), side(right))
            }
        }
    }
}

impl NumericExpression {
    /// Replaces every term.
    pub(crate) fn with_terms(&self, term: &impl Fn(Term) -> Term) -> Self {
        self.map(&mut |own: &Application| Arithmetic::Value(own.with_terms(term)))
    }

    /// Returns the largest slot, if the expression has variables.
    pub(crate) fn last_slot(&self) -> Option<Slot> {
        let mut last = None;
        self.for_each(&mut |own| {
            let slots = own.terms.iter().filter_map(|term| match term {
                Term::Variable(slot) => Some(*slot),
                Term::Constant(_) => None,
            });
            last = last.max(slots.max());
        });
        last
    }

    /// Returns the functions in the expression.
    pub fn functions(&self) -> Vec<FunctionId> {
        let mut functions = Vec::new();
        self.for_each(&mut |own| functions.push(own.function));
        functions
    }

    /// Evaluates the expression at a moment.
    pub fn value(&self, moment: Moment<'_>, bindings: &[EntityId]) -> Option<Number> {
        self.evaluate(&|own| own.number(moment, bindings))
    }

    /// Grounds the expression; numbers of the past and fluents that never change are replaced by their values, undefined ones
    /// stay.
    pub fn ground(&self, world: &World, bindings: &[EntityId]) -> GroundExpression {
        let moment = Moment {
            world,
            state: &world.state,
        };
        self.map(&mut |own| {
            let fluent = own.ground(bindings);
            let fixed = own.at != When::Now || !world.domain().function(own.function).changes;
            match own.number(moment, bindings).filter(|_| fixed) {
                Some(number) => Arithmetic::Constant(number),
                None => Arithmetic::Value(fluent),
            }
        })
    }
}

/// A comparison of two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Comparison {
    /// `<`
    Less,
    /// `<=`
    AtMost,
    /// `=`
    Equal,
    /// `!=`, the negation of `=`
    NotEqual,
    /// `>=`
    AtLeast,
    /// `>`
    Greater,
}

impl Comparison {
    /// All comparisons, the longer symbols first.
    pub const ALL: [Self; 6] = [
        Self::AtMost,
        Self::AtLeast,
        Self::NotEqual,
        Self::Less,
        Self::Greater,
        Self::Equal,
    ];

    /// Returns the comparison with this symbol.
    pub fn of(symbol: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.symbol() == symbol)
    }

    /// Returns the symbol.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::AtMost => "<=",
            Self::Equal => "=",
            Self::NotEqual => "!=",
            Self::AtLeast => ">=",
            Self::Greater => ">",
        }
    }

    /// Compares two numbers.
    pub fn holds(self, left: Number, right: Number) -> bool {
        match self {
            Self::Less => left < right,
            Self::AtMost => left <= right,
            Self::Equal => left == right,
            Self::NotEqual => left != right,
            Self::AtLeast => left >= right,
            Self::Greater => left > right,
        }
    }

    /// Returns the comparison that holds when this one does not, if both numbers are known.
    #[must_use]
    pub fn negated(self) -> Self {
        match self {
            Self::Less => Self::AtLeast,
            Self::AtMost => Self::Greater,
            Self::Equal => Self::NotEqual,
            Self::NotEqual => Self::Equal,
            Self::AtLeast => Self::Less,
            Self::Greater => Self::AtMost,
        }
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol())
    }
}

/// A requirement on numbers: a comparison of two expressions, or that the value of an expression is known.
///
/// A comparison is false if one of its sides is unknown, and so is its negation.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NumberTest<V> {
    /// The comparison holds.
    Compare(Arithmetic<V>, Comparison, Arithmetic<V>),
    /// The value is known (`true`) or unknown: a fluent without a number, a division by zero, or a result that does not
    /// fit.
    Known(Arithmetic<V>, bool),
}

/// A requirement on the fluents of a world.
pub type GroundTest = NumberTest<Fluent>;

impl<V> NumberTest<V> {
    /// Evaluates the requirement.
    pub fn holds(&self, value: &impl Fn(&V) -> Option<Number>) -> bool {
        match self {
            Self::Compare(left, comparison, right) => match (left.evaluate(value), right.evaluate(value)) {
                (Some(left), Some(right)) => comparison.holds(left, right),
                _ => false,
            },
            Self::Known(expression, known) => expression.evaluate(value).is_some() == *known,
        }
    }

    /// Returns the negation.
    #[must_use]
    pub fn negated(self) -> Self {
        match self {
            Self::Compare(left, comparison, right) => Self::Compare(left, comparison.negated(), right),
            Self::Known(expression, known) => Self::Known(expression, !known),
        }
    }

    /// Replaces each value by an expression.
    pub fn map<W>(&self, value: &mut impl FnMut(&V) -> Arithmetic<W>) -> NumberTest<W> {
        match self {
            Self::Compare(left, comparison, right) => {
                NumberTest::Compare(left.map(value), *comparison, right.map(value))
            }
            Self::Known(expression, known) => NumberTest::Known(expression.map(value), *known),
        }
    }

    /// Calls `visit` with each value.
    pub fn for_each(&self, visit: &mut impl FnMut(&V)) {
        self.expressions().for_each(|own| own.for_each(visit));
    }

    /// Returns the expressions.
    pub fn expressions(&self) -> impl Iterator<Item = &Arithmetic<V>> {
        let (first, second) = match self {
            Self::Compare(left, _, right) => (left, Some(right)),
            Self::Known(expression, _) => (expression, None),
        };
        std::iter::once(first).chain(second)
    }
}

impl NumberTest<Application> {
    /// Replaces every term.
    pub(crate) fn with_terms(&self, term: &impl Fn(Term) -> Term) -> Self {
        match self {
            Self::Compare(left, comparison, right) => {
                Self::Compare(left.with_terms(term), *comparison, right.with_terms(term))
            }
            Self::Known(expression, known) => Self::Known(expression.with_terms(term), *known),
        }
    }

    /// Returns the largest slot, if the requirement has variables.
    pub fn last_slot(&self) -> Option<Slot> {
        self.expressions().filter_map(Arithmetic::last_slot).max()
    }

    /// Returns the functions in the requirement.
    pub fn functions(&self) -> Vec<FunctionId> {
        self.expressions().flat_map(Arithmetic::functions).collect()
    }

    /// Evaluates the requirement at a moment.
    pub(crate) fn holds_at(&self, moment: Moment<'_>, bindings: &[EntityId]) -> bool {
        self.holds(&|own| own.number(moment, bindings))
    }

    /// Returns the requirement, evaluated in the initial state.
    #[must_use]
    pub(crate) fn initially(self) -> Self {
        self.map(&mut |own: &Application| {
            Arithmetic::Value(Application {
                at: When::Initially,
                ..own.clone()
            })
        })
    }

    /// Grounds the requirement.
    pub fn ground(&self, world: &World, bindings: &[EntityId]) -> GroundTest {
        let mut is_unknown = false;
        self.for_each(&mut |own| {
            let past = world.past(own.at);
            is_unknown |= past.is_some_and(|state| state.number(own.ground(bindings)).is_none());
        });
        match self {
            // Nothing gives a number to what had none in that state.
            Self::Compare(..) if is_unknown => GroundTest::Known(Arithmetic::Constant(Number::ZERO), false),
            Self::Known(_, known) if is_unknown => GroundTest::Known(Arithmetic::Constant(Number::ZERO), !known),
            Self::Compare(left, comparison, right) => {
                GroundTest::Compare(left.ground(world, bindings), *comparison, right.ground(world, bindings))
            }
            Self::Known(expression, known) => GroundTest::Known(expression.ground(world, bindings), *known),
        }
    }

    /// Returns the value of a requirement on initial numbers and on fluents that never change; none if some may change.
    pub(crate) fn fixed(&self, moment: Moment<'_>, bindings: &[EntityId]) -> Option<bool> {
        let domain = moment.world.domain();
        let mut changes = false;
        self.for_each(&mut |own| changes |= own.at == When::Now && domain.function(own.function).changes);
        (!changes).then(|| self.holds_at(moment, bindings))
    }
}
