//! The purpose of a plan that is carried out.

use longstep_model::model::{
    Application, Arithmetic, Atom, Comparison, Condition, Domain, Ending, Fact, Fluent, Number, NumberTest,
    PredicateId, Prohibition, State, Term, Wanted, When, World, state_word,
};
use longstep_search::goal::{self, Goal, GoalError};
use longstep_verify::verify::{Purpose, VerifiedPlan, Waiver, broken_at_end};

/// Maximum number of facts in the purpose of a plan without a goal.
const FACTS: usize = 2_000;

/// The origin of the purpose that an execution pursues when the world changes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Aim {
    /// A goal in the goal language, with its constraints.
    Goal(String),
    /// The changes that the plan itself brings about: for plans that were not made from a goal.
    Endings,
}

impl From<Option<String>> for Aim {
    /// The aim of a plan that was made for a goal, or without one.
    fn from(goal: Option<String>) -> Self {
        goal.map_or(Self::Endings, Self::Goal)
    }
}

impl Aim {
    /// Returns the goal in a world that has its values; none for a plan without one.
    pub(super) fn goal(&self, world: &World) -> Option<Goal> {
        match self {
            Self::Goal(text) => goal::parse(world, text).ok(),
            Self::Endings => None,
        }
    }

    /// Returns the purpose of a plan, and the plan's world with the prohibitions of the purpose in force besides its own.
    ///
    /// # Errors
    ///
    /// The error in the goal.
    pub fn purpose(&self, plan: &VerifiedPlan) -> Result<(World, Purpose), GoalError> {
        let mut world = plan.world().clone();
        let Self::Goal(text) = self else {
            return Ok((world, of_endings(plan)));
        };
        world.add_values(text);
        let mut purpose = goal::parse(&world, text)?.purpose(&world);
        let known = |own: &Prohibition| world.prohibitions().iter().any(|known| known.written == own.written);
        let new: Vec<Prohibition> = purpose.prohibitions.drain(..).filter(|own| !known(own)).collect();
        Ok((world.with_prohibitions(new), purpose))
    }
}

/// Returns the purpose that a run ends in one of the endings of a plan: the facts and numbers that the plan changes, as far
/// as an environment can state them, and its events.
fn of_endings(plan: &VerifiedPlan) -> Purpose {
    let world = plan.world();
    let mut sides: Vec<Vec<Condition>> = plan.endings().iter().map(|ending| changes(world, ending)).collect();
    let wanted = match (sides.len(), sides.pop()) {
        (1, Some(only)) => only.into_iter().map(achieved).collect(),
        (_, last) => {
            sides.extend(last);
            let sides = sides.into_iter().map(Condition::And).collect();
            vec![achieved(Condition::Or(sides))]
        }
    };
    Purpose {
        wanted,
        waivers: waivers(plan),
        ..Purpose::default()
    }
}

fn achieved(condition: Condition) -> Wanted {
    Wanted {
        condition,
        bindings: Vec::new(),
    }
}

/// Returns the changes of a plan up to an ending, with the outcomes of sensing that lead to it.
fn changes(world: &World, ending: &Ending) -> Vec<Condition> {
    let domain = world.domain();
    let counts = |fact: &Fact| {
        let words = domain.words(fact.predicate());
        words.event || words.fluent && has_words(domain, fact.predicate()) && !domain.is_sensed(fact.predicate())
    };
    let differs = |from: &State, to: &State| -> Vec<Fact> {
        from.iter().filter(|fact| counts(fact) && !to.holds(*fact)).collect()
    };
    let known = ending.when.iter().map(|fact| literal(domain, *fact, true));
    let made = differs(&ending.after, &world.state);
    let ended = differs(&world.state, &ending.after);
    let made = made.into_iter().map(|fact| literal(domain, fact, true));
    let ended = ended.into_iter().map(|fact| literal(domain, fact, false));
    let facts: Vec<Condition> = known.chain(made).chain(ended).take(FACTS).collect();
    let numbers = ending.after.numbers().iter();
    let numbers = numbers.filter(|(fluent, number)| world.state.number(*fluent) != Some(*number));
    let numbers = numbers.map(|(fluent, number)| is_number(domain, *fluent, *number));
    facts.into_iter().chain(numbers.take(FACTS)).collect()
}

/// Returns true if an environment can state the facts of a predicate: those without arguments are statements by themselves.
fn has_words(domain: &Domain, predicate: PredicateId) -> bool {
    state_word(domain, predicate).is_some() || domain.predicate(predicate).parameters.is_empty()
}

fn is_number(domain: &Domain, fluent: Fluent, number: Number) -> Condition {
    let application = Application {
        function: fluent.function(),
        terms: domain.arguments_of(fluent).map(Term::Constant).collect(),
        at: When::Now,
    };
    Condition::Number(NumberTest::Compare(
        Arithmetic::Value(application),
        Comparison::Equal,
        Arithmetic::Constant(number),
    ))
}

fn literal(domain: &Domain, fact: Fact, holds: bool) -> Condition {
    Condition::Atom {
        atom: Atom {
            predicate: fact.predicate(),
            terms: domain.arguments(fact).map(Term::Constant).collect(),
        },
        holds,
        at: When::Now,
    }
}

/// Returns waivers for the rules that the plan itself breaks at its end: its own purpose allowed that.
fn waivers(plan: &VerifiedPlan) -> Vec<Waiver> {
    let purpose = Purpose::default();
    let mut waivers: Vec<Waiver> = Vec::new();
    for ending in plan.endings() {
        for broken in broken_at_end(plan.world(), &ending.after, &purpose) {
            for entity in broken.bindings {
                let waiver = Waiver {
                    rule: broken.rule,
                    entity,
                };
                if !waivers.contains(&waiver) {
                    waivers.push(waiver);
                }
            }
        }
    }
    waivers
}
