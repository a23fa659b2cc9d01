//! Constraints in a goal: what must never happen, or always hold, while the plan runs.

use super::{GoalError, GoalFact, fact, literal, names};
use longstep_model::call::Call;
use longstep_model::model::{
    Action, ActionId, Application, Arithmetic, Atom, Comparison, Condition, Domain, EntityId, FunctionId, Moment,
    NumberTest, Parameter, PredicateId, Prohibition, Slot, StepPattern, Term, TypeId, Voice, Wanted, When, World,
};
use longstep_verify::verify::{can_be_brought_about, possibly};

/// A constraint on every state and step of a plan.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Constraint {
    /// The goal must hold in every state (`always`), or in none (`never`). It binds from the first state that keeps it.
    State {
        /// The goal, without conditions.
        fact: GoalFact,
        /// True for `always`.
        holds: bool,
    },
    /// No step may call the action with these arguments.
    Step {
        /// The action.
        action: ActionId,
        /// By explicit parameter of the call: the argument; none for any.
        arguments: Vec<Option<EntityId>>,
    },
    /// No step may have the entity as an argument, nor change its states or its numbers.
    Untouched(EntityId),
    /// A constraint on states that binds as long as a goal does not hold.
    Until {
        /// The constraint: [`Self::State`], or [`Self::Untouched`] without its steps.
        constraint: Box<Constraint>,
        /// The goal, without conditions.
        goal: Box<GoalFact>,
    },
}

/// The word before a goal that must hold in no state, or before a call that no step may make.
pub const NEVER: &str = "never ";
/// The word before a goal that must hold in every state.
pub const ALWAYS: &str = "always ";
/// The word for an entity that must be left alone.
const UNTOUCHED: &str = "untouched";
/// The word between a constraint and the goal with which it ends.
pub const UNTIL: &str = " until ";
/// The notation of any argument of a call.
pub(super) const ANY: &str = "_";

impl Constraint {
    /// Reads a constraint; none if the text is a goal.
    ///
    /// # Errors
    ///
    /// The error in the constraint.
    pub(super) fn read(world: &World, text: &str) -> Result<Option<Self>, GoalError> {
        if let Some((constraint, goal)) = text.split_once(UNTIL) {
            let Some(constraint) = Self::read(world, constraint.trim())? else {
                return Ok(None);
            };
            // The rules of a world are conditions on states, and steps are forbidden without regard to the state.
            if let Self::Step { .. } = constraint {
                return Err(GoalError::StepsUntil { part: text.to_owned() });
            }
            return Ok(Some(Self::Until {
                constraint: Box::new(constraint),
                goal: Box::new(fact::plain(world, goal.trim())?),
            }));
        }
        if let Some(inner) = text.strip_prefix(ALWAYS) {
            let fact = fact::plain(world, inner.trim())?;
            return Self::state(world, text, fact, true).map(Some);
        }
        if let Some(inner) = text.strip_prefix(NEVER) {
            return Self::never(world, inner.trim()).map(Some);
        }
        match Call::parse(text) {
            Ok(call) if call.name == UNTOUCHED && call.arguments.len() == 1 => {
                let names = [call.arguments[0].as_str()];
                let entities = names::entities(world, text, &names, &[TypeId::OBJECT])?;
                Ok(Some(Self::Untouched(entities[0])))
            }
            _ => Ok(None),
        }
    }

    /// Returns true if a text is written as the constraint that leaves an entity alone.
    pub(super) fn is_untouched(text: &str) -> bool {
        let rest = text.strip_prefix(UNTOUCHED).map(str::trim_start);
        rest.is_some_and(|rest| rest.starts_with('('))
    }

    /// Returns the constraint on states, unless the goal can hold in no state at all.
    pub(super) fn state(world: &World, text: &str, fact: GoalFact, holds: bool) -> Result<Self, GoalError> {
        let wanted = fact.wanted(world.domain(), &[]);
        let moment = Moment {
            world,
            state: &world.state,
        };
        // A rule about a fact that can never hold forbids nothing, and is more likely a mistake.
        let possible = match &fact {
            GoalFact::Plain(fact) => can_be_brought_about(world, *fact),
            _ => possibly(world, &wanted.condition, &mut wanted.bindings.clone()),
        };
        if !possible && !longstep_model::model::holds(moment, &wanted.condition, &mut wanted.bindings.clone()) {
            return Err(GoalError::NeverHolds { part: text.to_owned() });
        }
        Ok(Self::State { fact, holds })
    }

    fn never(world: &World, text: &str) -> Result<Self, GoalError> {
        let error = match fact::plain(world, text) {
            Ok(fact) => return Self::state(world, text, fact, false),
            Err(error) => error,
        };
        // A goal word that is read with another name is an error of that name, unless an action is called the same.
        let domain = world.domain();
        let Ok(call) = Call::parse(text) else { return Err(error) };
        let mut actions = domain.action_ids();
        let Some((id, action)) = actions.find(|(_, action)| is_called(action, &call)) else {
            return Err(error);
        };
        let mut arguments = Vec::new();
        for (name, parameter) in call.arguments.iter().zip(&action.explicit) {
            arguments.push(match name.as_str() {
                ANY => None,
                name => {
                    let kind = action.parameters[*parameter].kind;
                    // A goal of entities that it does not take is no call of an action with the same name.
                    let read = names::entities(world, text, &[name], &[kind]);
                    Some(
                        read.map_err(|own| match &error {
                            GoalError::WrongType { .. } => error.clone(),
                            _ => own,
                        })?[0],
                    )
                }
            });
        }
        // Omitted arguments stand for any.
        arguments.resize(action.explicit.len(), None);
        Ok(Self::Step { action: id, arguments })
    }

    /// Writes the constraint in the goal language; `name` gives the name of each entity.
    pub(super) fn written(&self, domain: &Domain, name: &dyn Fn(EntityId) -> String) -> String {
        match self {
            Self::State { fact, holds } => {
                let word = if *holds { ALWAYS } else { NEVER };
                format!("{word}{}", fact.written(domain, name))
            }
            Self::Step { action, arguments } => {
                let arguments = arguments
                    .iter()
                    .map(|entity| entity.map_or_else(|| ANY.to_owned(), name));
                let arguments: Vec<String> = arguments.collect();
                format!("{NEVER}{}({})", domain.action(*action).call, arguments.join(", "))
            }
            Self::Untouched(entity) => format!("{UNTOUCHED}({})", name(*entity)),
            Self::Until { constraint, goal } => {
                format!(
                    "{}{UNTIL}{}",
                    constraint.written(domain, name),
                    goal.written(domain, name)
                )
            }
        }
    }

    /// Writes the constraint with everyday names.
    pub fn everyday(&self, world: &World) -> String {
        self.written(world.domain(), &|entity| world.entity(entity).name.clone())
    }

    /// Writes the constraint with the environment's identifiers.
    pub fn exact(&self, world: &World) -> String {
        self.written(world.domain(), &|entity| world.entity(entity).identifier.clone())
    }

    /// Writes the constraint as a sentence for a person or a model.
    pub fn sentence_in(&self, voice: Voice, world: &World) -> String {
        match self {
            Self::State { fact, holds: true } => format!("at all times: {}", fact.sentence_in(voice, world)),
            Self::State { fact, holds: false } => format!("at no time: {}", fact.sentence_in(voice, world)),
            Self::Step { .. } => {
                let call = self.everyday(world);
                format!("no step is `{}`", call.strip_prefix(NEVER).unwrap_or(&call))
            }
            Self::Untouched(entity) => format!("no step touches {}", voice.name(world, *entity)),
            Self::Until { constraint, goal } => format!(
                "{}, until {}",
                constraint.sentence_in(voice, world),
                goal.sentence_in(voice, world)
            ),
        }
    }

    /// Writes the constraint as a sentence for a person.
    pub fn sentence(&self, world: &World) -> String {
        self.sentence_in(Voice::Person, world)
    }

    /// Returns the entities in the constraint.
    pub fn about(&self, domain: &Domain) -> Vec<EntityId> {
        match self {
            Self::State { fact, .. } => fact.about(domain),
            Self::Step { arguments, .. } => arguments.iter().flatten().copied().collect(),
            Self::Untouched(entity) => vec![*entity],
            Self::Until { constraint, goal } => [constraint.about(domain), goal.about(domain)].concat(),
        }
    }

    /// Maps the constraint to another world by identifiers; none if an entity is missing there.
    pub(super) fn carried(&self, domain: &Domain, from: &World, to: &World) -> Option<Self> {
        let there = |entity: EntityId| to.find(&from.entity(entity).identifier);
        Some(match self {
            Self::State { fact, holds } => Self::State {
                fact: fact.carried(domain, from, to)?,
                holds: *holds,
            },
            Self::Step { action, arguments } => Self::Step {
                action: *action,
                arguments: arguments
                    .iter()
                    .map(|entity| entity.map_or(Some(None), |entity| there(entity).map(Some)))
                    .collect::<Option<Vec<_>>>()?,
            },
            Self::Untouched(entity) => Self::Untouched(there(*entity)?),
            Self::Until { constraint, goal } => Self::Until {
                constraint: Box::new(constraint.carried(domain, from, to)?),
                goal: Box::new(goal.carried(domain, from, to)?),
            },
        })
    }

    /// Returns the constraint for a world, where it can be put in force.
    pub fn prohibition(&self, world: &World) -> Prohibition {
        let domain = world.domain();
        let (written, says) = (self.exact(world), self.sentence(world));
        match self {
            Self::State { .. } => Prohibition::new(written, says, Some(self.condition(world)), Vec::new()),
            Self::Step { action, arguments } => {
                let own = domain.action(*action);
                let mut all = vec![None; own.parameters.len()];
                for (parameter, argument) in own.explicit.iter().zip(arguments) {
                    all[*parameter] = *argument;
                }
                let pattern = StepPattern {
                    action: Some(*action),
                    arguments: all,
                    anywhere: None,
                };
                Prohibition::new(written, says, None, vec![pattern])
            }
            Self::Untouched(entity) => {
                let pattern = StepPattern {
                    action: None,
                    arguments: Vec::new(),
                    anywhere: Some(*entity),
                };
                Prohibition::new(written, says, Some(unchanged(world, *entity)), vec![pattern])
            }
            Self::Until { constraint, goal } => {
                let Wanted { condition, bindings } = goal.wanted(domain, &[]);
                let holds = constraint.condition(world);
                let condition = Condition::Or(vec![holds, condition.bound(&bindings)]);
                Prohibition::new(written, says, Some(condition), Vec::new())
            }
        }
    }
}

impl Constraint {
    /// Returns the condition that must hold in every state.
    fn condition(&self, world: &World) -> Condition {
        match self {
            Self::State { fact, holds } => {
                let Wanted { condition, bindings } = fact.wanted(world.domain(), &[]);
                let condition = condition.bound(&bindings);
                if *holds { condition } else { condition.complement() }
            }
            Self::Untouched(entity) => unchanged(world, *entity),
            Self::Step { .. } | Self::Until { .. } => Condition::TRUE,
        }
    }
}

fn is_called(action: &Action, call: &Call) -> bool {
    (action.call == call.name || action.name == call.name) && call.arguments.len() <= action.explicit.len()
}

/// Returns the condition that an entity is as it was when the plan, or the rest of it, began: in the facts that the environment states among its states,
/// and in the numbers whose first argument it is. What sensing reveals is no change.
fn unchanged(world: &World, entity: EntityId) -> Condition {
    let domain = world.domain();
    let mut atoms: Vec<&Atom> = Vec::new();
    for word in &domain.states {
        // To look at an entity is not to touch it.
        let changes = domain.words(word.atom.predicate).fluent && !domain.is_sensed(word.atom.predicate);
        if changes && !atoms.contains(&&word.atom) {
            atoms.push(&word.atom);
        }
    }
    let facts = atoms.into_iter().map(|atom| {
        let parameters = &domain.predicate(atom.predicate).parameters;
        let slots = atom.terms.iter().map(|term| match *term {
            Term::Variable(slot) => slot,
            Term::Constant(_) => 0,
        });
        let others = (1..=slots.max().unwrap_or(0)).map(|slot| kind_of_slot(atom, parameters, slot));
        let others: Vec<TypeId> = others.collect();
        let terms = atom.terms.iter().map(|term| of_entity(*term, entity)).collect();
        everywhere(&others, fact_as_before(atom.predicate, terms))
    });
    let functions = domain.functions.iter().enumerate();
    let numbers = functions.filter_map(|(index, function)| {
        let (first, others) = function.parameters.split_first()?;
        let others: Vec<TypeId> = others.iter().map(|parameter| parameter.kind).collect();
        let terms = (0..=others.len()).map(|slot| of_entity(Term::Variable(slot), entity));
        let is_own = function.changes && world.is_of_kind(entity, first.kind);
        is_own.then(|| everywhere(&others, number_as_before(FunctionId::new(index), terms.collect())))
    });
    Condition::And(facts.chain(numbers).collect())
}

/// Returns the type of the first place of an atom that has the variable.
fn kind_of_slot(atom: &Atom, parameters: &[Parameter], slot: Slot) -> TypeId {
    let place = atom.terms.iter().position(|term| *term == Term::Variable(slot));
    place.map_or(TypeId::OBJECT, |place| parameters[place].kind)
}

/// Returns a term with the entity in place of the first slot; later slots move down.
fn of_entity(term: Term, entity: EntityId) -> Term {
    match term {
        Term::Variable(0) => Term::Constant(entity),
        Term::Variable(slot) => Term::Variable(slot - 1),
        constant @ Term::Constant(_) => constant,
    }
}

/// Returns the condition for all entities of these types in its slots.
fn everywhere(kinds: &[TypeId], condition: Condition) -> Condition {
    let slots = kinds.iter().enumerate().rev();
    slots.fold(condition, |inner, (slot, kind)| {
        Condition::Forall(slot, *kind, Box::new(inner))
    })
}

/// Returns the condition that an atom has the value of the start.
fn fact_as_before(predicate: PredicateId, terms: Vec<Term>) -> Condition {
    let atom = |holds: bool, at: When| literal(predicate, &terms, holds, at);
    Condition::And(vec![
        Condition::Or(vec![atom(false, When::Now), atom(true, When::Start)]),
        Condition::Or(vec![atom(true, When::Now), atom(false, When::Start)]),
    ])
}

/// Returns the condition that a number is the one of the start, or unknown as it was.
fn number_as_before(function: FunctionId, terms: Vec<Term>) -> Condition {
    let number = |at: When| number_at(function, &terms, at);
    let is = Condition::Number;
    // An unknown number satisfies no comparison, so "unknown as before" is an alternative of its own.
    let unknown = [When::Now, When::Start].map(|at| is(NumberTest::Known(number(at), false)));
    Condition::Or(vec![
        is(NumberTest::Compare(
            number(When::Now),
            Comparison::Equal,
            number(When::Start),
        )),
        Condition::And(unknown.to_vec()),
    ])
}

fn number_at(function: FunctionId, terms: &[Term], at: When) -> Arithmetic<Application> {
    let terms = terms.to_vec();
    Arithmetic::Value(Application { function, terms, at })
}
