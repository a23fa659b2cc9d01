//! The writer of PDDL problems.

use std::fmt::Write;

use indexmap::IndexSet;

use super::names::plain;
use super::object_names;
use crate::search::{Formula, GroundCondition, Literal, Meaning, Wanted, ground_condition};
use longstep_model::effort;
use longstep_model::model::{
    Arithmetic, Comparison, Domain, Fact, Fluent, GroundExpression, GroundTest, State, World, changed_facts,
};
use longstep_verify::verify::Purpose;

/// The reason why a task cannot be written as a PDDL problem.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// A rule must hold in every state, but a PDDL problem constrains only the first and the last one.
    #[error("the rule `{rule}` must hold in every state on the way, which a PDDL problem cannot say")]
    Always {
        /// The rule's name.
        rule: String,
    },
    /// The goals must be achieved in an order.
    #[error("the goals must be achieved in an order, which a PDDL problem cannot say")]
    Order,
    /// The plan has branches, loops or lanes.
    #[error("a plan with branches, loops or lanes has no form in PDDL")]
    Branches,
    /// An action depends on the state before the plan.
    #[error("the action `{action}` depends on the state before the plan, which a PDDL domain cannot say")]
    Past {
        /// The action's name.
        action: String,
    },
    /// A goal depends on sensing.
    #[error("the goal depends on sensing, which PDDL cannot say")]
    Sensing,
    /// The goal or a rule has too many instances in the world.
    #[error("the goal has too many instances in this world to be written without quantifiers")]
    TooLarge,
}

/// The budget for writing a problem or a goal, in units of work.
const EFFORT: u64 = 25_000_000;

/// Writes a problem that any planner reads together with the domain's `domain.pddl`, or with that of [`write_domain`](super::write_domain).
///
/// The goal is written ground, since conditions may refer to the initial state, which PDDL cannot express. Parts whose
/// truth is known initially are left out; the rest are facts with `and`, `or` and `not`. Assumed facts are written like
/// all others. Objects are named by [`object_names`]; a comment gives the identifier where it differs. The output is
/// sorted, so equal tasks yield equal texts.
///
/// # Errors
///
/// [`WriteError::Always`] if a rule or a prohibition must hold in every state; [`WriteError::Order`] if the purpose has
/// stages; [`WriteError::TooLarge`] if the goal has too many instances.
pub fn write_problem(world: &World, purpose: &Purpose, name: &str) -> Result<String, WriteError> {
    write_problem_for(world, purpose, name, None)
}

/// Writes a problem; the final state of a plan without a goal gives it one: whatever the plan has changed.
pub(super) fn write_problem_for(
    world: &World,
    purpose: &Purpose,
    name: &str,
    ending: Option<&State>,
) -> Result<String, WriteError> {
    affordable(|| problem(&purpose.world(world), purpose, name, ending))?
}

pub(super) fn affordable<T>(write: impl FnOnce() -> T) -> Result<T, WriteError> {
    let spent = effort::within(EFFORT, write);
    if spent.exhausted {
        Err(WriteError::TooLarge)
    } else {
        Ok(spent.result)
    }
}

fn problem(world: &World, purpose: &Purpose, name: &str, ending: Option<&State>) -> Result<String, WriteError> {
    if !purpose.stages.is_empty() {
        return Err(WriteError::Order);
    }
    let domain = world.domain();
    for (_, rule) in world.always_rules() {
        let GroundCondition { formula, .. } = ground_condition(world, &rule.everywhere(), &[]);
        if !formula.is_true() {
            return Err(WriteError::Always {
                rule: rule.name.clone(),
            });
        }
    }
    let names = object_names(world);
    let mut text = format!("(define (problem {})\n  (:domain {})\n", plain(name), domain.pddl_name);
    text.push_str("  (:objects");
    for (id, entity) in world.entities().skip(domain.constants.len()) {
        let object = &names[id.index()];
        let kind = domain.types.name(entity.kind);
        // Writing to a `String` cannot fail.
        let _ = write!(text, "\n    {object} - {kind}");
        if *object != entity.identifier {
            let _ = write!(text, " ; {}", entity.identifier.escape_debug());
        }
    }
    text.push_str("\n  )\n  (:init");
    for fact in world.state.iter() {
        let _ = write!(text, "\n    {}", atom(domain, &names, fact));
    }
    for (own, number) in world.state.numbers() {
        let _ = write!(text, "\n    (= {} {number})", fluent(domain, &names, *own));
    }
    if domain.has_costs() {
        text.push_str("\n    (= (total-cost) 0)");
    }
    text.push_str("\n  )\n");
    let mut goal = IndexSet::new();
    if let Some(ending) = ending {
        text.push_str("  ; The plan was made without a goal: this one is what it changes.\n");
        goal.extend(changes(world, &names, ending));
    }
    goal.extend(ground_goal(world, &names, &purpose.at_end(domain)));
    text.push_str("  (:goal (and");
    for part in goal {
        let _ = write!(text, "\n    {part}");
    }
    text.push_str("\n  ))");
    if domain.has_costs() {
        text.push_str("\n  (:metric minimize (total-cost))");
    }
    text.push_str("\n)\n");
    Ok(text)
}

/// Returns the parts of the goal in the notation of [`write_problem`].
///
/// # Errors
///
/// [`WriteError::TooLarge`] if the goal has too many instances.
pub fn write_goal(world: &World, wanted: &[Wanted]) -> Result<Vec<String>, WriteError> {
    affordable(|| ground_goal(world, &object_names(world), wanted))
}

fn ground_goal(world: &World, names: &[String], wanted: &[Wanted]) -> Vec<String> {
    let mut written: IndexSet<String> = IndexSet::new();
    for wanted in wanted {
        let ground = ground_condition(world, &wanted.condition, &wanted.bindings);
        let parts = match &ground.formula {
            Formula::And(parts) => parts.as_slice(),
            other => std::slice::from_ref(other),
        };
        for part in parts {
            if effort::spend(part.size()) {
                written.insert(condition(world.domain(), names, &ground.facts, part));
            }
        }
    }
    written.into_iter().collect()
}

/// Writes the facts and numbers of a final state that differ from the initial one.
fn changes(world: &World, names: &[String], ending: &State) -> Vec<String> {
    let domain = world.domain();
    let facts = changed_facts(&world.state, ending).into_iter().map(|change| {
        let atom = atom(domain, names, change.fact);
        if change.now_holds {
            atom
        } else {
            format!("(not {atom})")
        }
    });
    let numbers = ending.numbers().iter();
    let numbers = numbers.filter(|(own, number)| world.state.number(*own) != Some(*number));
    let numbers = numbers.map(|(own, number)| format!("(= {} {number})", fluent(domain, names, *own)));
    facts.chain(numbers).collect()
}

fn atom(domain: &Domain, names: &[String], fact: Fact) -> String {
    let predicate = domain.predicate(fact.predicate());
    let mut text = format!("({}", predicate.name);
    for place in 0..predicate.parameters.len() {
        text.push(' ');
        text.push_str(&names[fact.argument(place).index()]);
    }
    text.push(')');
    text
}

/// Writes a requirement on numbers. A planner knows a number wherever a comparison with it holds, so the requirement that
/// it is known is left out.
fn requirement(domain: &Domain, names: &[String], test: &GroundTest) -> String {
    match test {
        GroundTest::Compare(left, comparison, right) => {
            let (left, right) = (number(domain, names, left), number(domain, names, right));
            match comparison {
                Comparison::NotEqual => format!("(not (= {left} {right}))"),
                comparison => format!("({comparison} {left} {right})"),
            }
        }
        GroundTest::Known(..) => "(and)".to_owned(),
    }
}

fn number(domain: &Domain, names: &[String], expression: &GroundExpression) -> String {
    match expression {
        Arithmetic::Constant(number) => number.to_string(),
        Arithmetic::Value(own) => fluent(domain, names, *own),
        Arithmetic::Operation(operation, left, right) => {
            let (left, right) = (number(domain, names, left), number(domain, names, right));
            format!("({} {left} {right})", operation.symbol())
        }
    }
}

fn fluent(domain: &Domain, names: &[String], fluent: Fluent) -> String {
    let mut text = format!("({}", domain.function(fluent.function()).name);
    for argument in domain.arguments_of(fluent) {
        text.push(' ');
        text.push_str(&names[argument.index()]);
    }
    text.push(')');
    text
}

fn condition(domain: &Domain, names: &[String], facts: &[Meaning], formula: &Formula) -> String {
    let list = |word: &str, parts: &[Formula]| {
        let parts: Vec<String> = parts.iter().map(|part| condition(domain, names, facts, part)).collect();
        format!("({word} {})", parts.join(" "))
    };
    match formula {
        Formula::And(parts) => list("and", parts),
        Formula::Or(parts) => list("or", parts),
        Formula::Literal(Literal { fact, holds }) => {
            let atom = match &facts[*fact as usize] {
                Meaning::Fact(fact) => atom(domain, names, *fact),
                Meaning::Test(test) => requirement(domain, names, test),
            };
            if *holds { atom } else { format!("(not {atom})") }
        }
    }
}
