//! Reasons why there is no plan: rules, the order, single goals, and facts that nothing can make true.
//!
//! A planner that answers "unsolvable" leaves a person alone with a goal of several parts. [`why_not`] solves the task
//! again without some of its requirements, and follows a goal that cannot be reached back to a fact that no action
//! brings about.

use super::grounder::{Grounder, Meaning};
use super::operator::Operator;
use super::{Formula, Limits, Literal, Outcome, Requirements, Scope, relevance, solve};
use longstep_model::effort;
use longstep_model::model::{
    Atom, Bindings, Condition, EntityId, Fact, GroundTest, Moment, PredicateId, Prohibition, Term, Voice, Wanted,
    World, ground, holds, static_value, unify,
};
use longstep_verify::verify::Purpose;

/// Work units of the whole analysis.
const EFFORT: u64 = 40_000_000;

/// Work units to copy a rule.
const RULE: usize = 16;

/// Maximum number of arguments that are tried for an action that cannot bring a fact about.
const CHOICES: usize = 2_000;

/// Reasons why no plan serves a purpose. Empty if none was found within the budget.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct WhyNot {
    /// The prohibitions that prevent a plan, in the goal language: without any one of them there is a plan, or, if no
    /// single one prevents it, without all of them.
    pub prohibitions: Vec<String>,
    /// True if all goals can be reached, but not in their order.
    pub order: bool,
    /// The indices of the goals that cannot be reached even by themselves.
    pub goals: Vec<usize>,
    /// True if each goal can be reached, but not all together.
    pub together: bool,
    /// The fact or number that a goal needs and no action can bring about.
    pub missing: Option<Missing>,
}

/// A requirement of a goal that no action can bring about.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Missing {
    /// A fact; with `false` for a fact that must not hold.
    Fact(Fact, bool),
    /// Anything that is of this kind, a predicate with one parameter: "a centrifuge".
    Any(PredicateId),
    /// A requirement on numbers.
    Number(GroundTest),
}

impl Missing {
    /// A sentence for a person: `it would need that the shelf is open, and no action can make that so`.
    pub fn sentence(&self, world: &World) -> String {
        let text = match self {
            Self::Fact(fact, holds) => Voice::Person.fact(world, *fact, *holds),
            Self::Any(predicate) => world.domain().words(*predicate).says.fill(|_| "something".to_owned()),
            Self::Number(test) => Voice::Person.requirement(world, test),
        };
        format!("it would need that {text}, and no action can make that so")
    }
}

/// Finds the reasons why there is no plan for a purpose that [`solve`] has proven unsolvable.
///
/// ```
/// use longstep_model::{domain, environment};
/// use longstep_search::{goal, search::{self, Limits}};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let goal = goal::parse(&world, "put(cup, shelf) & untouched(cup)").unwrap();
/// let why = search::why_not(&world, &goal.purpose(&world), &Limits::default());
/// assert_eq!(why.prohibitions, ["untouched(<cup>)"]);
/// ```
pub fn why_not(world: &World, purpose: &Purpose, limits: &Limits) -> WhyNot {
    effort::within(EFFORT, || analyzed(world, purpose, limits)).result
}

fn analyzed(world: &World, purpose: &Purpose, limits: &Limits) -> WhyNot {
    let world = &*purpose.world(world);
    // The world has these prohibitions too, and there each can be left out by itself.
    let purpose = &Purpose {
        prohibitions: Vec::new(),
        ..purpose.clone()
    };
    let is_solved = |world: &World, purpose: &Purpose| matches!(solve(world, purpose, limits), Outcome::Solved { .. });
    let mut why = WhyNot::default();
    let rules = world.prohibitions();
    // If the rules do not prevent a plan, this search saves one for each of them.
    if !rules.is_empty() && is_solved(&with_prohibitions(world, []), purpose) {
        let mut single = Vec::new();
        for index in 0..rules.len() {
            let others = || rules[..index].iter().chain(&rules[index + 1..]);
            // For a single rule, the search without all rules has already answered. Each try copies the other rules.
            if rules.len() == 1
                || effort::spend(RULE * rules.len()) && is_solved(&with_prohibitions(world, others()), purpose)
            {
                single.push(index);
            }
        }
        let which = if single.is_empty() {
            (0..rules.len()).collect()
        } else {
            single
        };
        why.prohibitions = which.into_iter().map(|index| rules[index].written.clone()).collect();
        return why;
    }
    let unordered = Purpose {
        stages: Vec::new(),
        ..purpose.clone()
    };
    if !purpose.stages.is_empty() && is_solved(world, &unordered) {
        why.order = true;
        return why;
    }
    let conditions = conditions(purpose);
    let count = conditions.len();
    let mut outcomes = Vec::with_capacity(count);
    for wanted in &conditions {
        let alone = Purpose {
            wanted: vec![wanted.clone()],
            ..unordered.clone()
        };
        outcomes.push(solve(world, &alone, limits));
    }
    // A search that gave up has neither reached the goal nor proven that nothing does.
    let is_impossible = |index: &usize| matches!(outcomes[*index], Outcome::ProvenUnsolvable { .. });
    why.goals = (0..count).filter(is_impossible).collect();
    why.together = count > 1 && outcomes.iter().all(|own| matches!(own, Outcome::Solved { .. }));
    let first = why.goals.first();
    why.missing = first.and_then(|index| missing(world, &conditions[*index]));
    // A search without budget makes a goal look unreachable.
    if effort::is_exhausted() { WhyNot::default() } else { why }
}

/// Returns the world with these prohibitions in place of its own.
fn with_prohibitions<'p>(world: &World, prohibitions: impl IntoIterator<Item = &'p Prohibition>) -> World {
    let mut world = world.clone();
    world.set_prohibitions(prohibitions.into_iter().cloned().collect::<Vec<_>>());
    world
}

/// Returns the condition of each goal, whether or not it must last.
fn conditions(purpose: &Purpose) -> Vec<Wanted> {
    if purpose.stages.is_empty() {
        purpose.wanted.clone()
    } else {
        let stages = purpose.stages.iter().flatten();
        stages.map(|milestone| milestone.wanted.clone()).collect()
    }
}

/// Returns what the condition needs and nothing brings about, following the conditions of actions back.
fn missing(world: &World, wanted: &Wanted) -> Option<Missing> {
    let scope = Scope::whole(world, &Requirements::of(world, [wanted], &[]));
    if !scope.is_bearable(world) {
        return None;
    }
    let mut grounder = Grounder::new(world, &scope);
    let goal = grounder.goal(std::slice::from_ref(wanted));
    let mut operators = grounder.operators(&wanted.bindings.iter().copied().collect());
    grounder.mark(&mut operators);
    let initial = grounder.initial.clone();
    let facts = grounder.facts();
    if goal.is_false() {
        let mut bindings = wanted.bindings.clone();
        let denied = denied(world, &wanted.condition, &mut bindings);
        return denied.map(|(atom, holds)| Missing::Fact(ground(atom, &bindings), holds));
    }
    // The delete relaxation reaches too much and never too little: no plan achieves what it misses.
    let reached = relevance::reached(&initial, &operators);
    let mut open = lacking(&goal, &reached);
    let mut seen: Vec<Literal> = Vec::new();
    let mut last = None;
    // Actions may need each other's effects in a circle, so each literal is followed once.
    while let Some(literal) = open.iter().copied().find(|literal| !seen.contains(literal)) {
        last = Some(literal);
        seen.push(literal);
        let needs = operators
            .iter()
            .filter_map(|operator| lacking_for(operator, literal, &reached));
        match needs.min_by_key(Vec::len) {
            Some(needs) => open = needs,
            None => break,
        }
    }
    let literal = last?;
    let fact = match &facts[literal.fact as usize] {
        Meaning::Fact(fact) => *fact,
        Meaning::Test(test) => return Some(Missing::Number(test.clone())),
    };
    let prevented = literal.holds.then(|| prevented(world, fact)).flatten();
    Some(prevented.unwrap_or(Missing::Fact(fact, literal.holds)))
}

/// Returns the fewest literals of a condition that are not reached.
fn lacking(formula: &Formula, reached: &[bool]) -> Vec<Literal> {
    match formula {
        Formula::Literal(literal) if reached[relevance::index(*literal)] => Vec::new(),
        Formula::Literal(literal) => vec![*literal],
        Formula::And(parts) => parts.iter().flat_map(|part| lacking(part, reached)).collect(),
        Formula::Or(parts) => {
            let parts = parts.iter().map(|part| lacking(part, reached));
            parts.min_by_key(Vec::len).unwrap_or_default()
        }
    }
}

/// Returns the fewest literals that an operator needs to achieve a literal and that are not reached; none if it does not
/// achieve the literal.
fn lacking_for(operator: &Operator, literal: Literal, reached: &[bool]) -> Option<Vec<Literal>> {
    let effects = operator.effects.iter().filter(|effect| effect.literal == literal);
    let conditions = effects.map(|effect| [&operator.precondition, &effect.condition]);
    let needs = conditions.map(|conditions| conditions.map(|condition| lacking(condition, reached)).concat());
    needs.min_by_key(Vec::len)
}

/// Returns a static part of a condition that is false, with the value that it would need.
fn denied<'a>(world: &World, condition: &'a Condition, bindings: &mut Bindings) -> Option<(&'a Atom, bool)> {
    let moment = Moment {
        world,
        state: &world.state,
    };
    match condition {
        Condition::Atom { atom, holds, .. } => match static_value(world, condition, bindings) {
            Some(false) => Some((atom, *holds)),
            _ => None,
        },
        Condition::And(parts) => parts.iter().find_map(|part| denied(world, part, bindings)),
        Condition::Or(parts) if !holds(moment, condition, bindings) => {
            parts.iter().find_map(|part| denied(world, part, bindings))
        }
        _ => None,
    }
}

/// Returns what prevents every action that would add a fact: the static fact that most nearly suffices for one of them.
fn prevented(world: &World, fact: Fact) -> Option<Missing> {
    let domain = world.domain();
    let mut best: Option<(usize, Missing)> = None;
    for action in &domain.actions {
        for effect in action.effects.iter().filter(|effect| effect.adds) {
            let mut arguments = vec![None; action.parameters.len()];
            if effect.atom.predicate != fact.predicate() || !unify(&effect.atom, fact, &mut arguments) {
                continue;
            }
            let mut choices: Vec<Bindings> = vec![Vec::new()];
            for (parameter, fixed) in action.parameters.iter().zip(&arguments) {
                let all = world.of_kind(parameter.kind);
                let candidates = fixed.as_ref().map_or(all, std::slice::from_ref);
                let longer = choices
                    .iter()
                    .flat_map(|choice| candidates.iter().map(move |entity| [&choice[..], &[*entity]].concat()));
                choices = longer.take(CHOICES).collect();
            }
            for mut choice in choices {
                if !effort::spend(action.parameters.len() + 1) {
                    return None;
                }
                let parts: Vec<&Condition> = action.precondition.conjuncts().collect();
                let denied: Vec<(&Atom, bool)> = parts
                    .iter()
                    .filter_map(|part| denied(world, part, &mut choice))
                    .collect();
                if let Some((atom, holds)) = denied.first().copied()
                    && best.as_ref().is_none_or(|(fewest, _)| denied.len() < *fewest)
                {
                    let missing = if holds && is_open(world, atom, &arguments) {
                        Missing::Any(atom.predicate)
                    } else {
                        Missing::Fact(ground(atom, &choice), holds)
                    };
                    best = Some((denied.len(), missing));
                }
            }
        }
    }
    best.map(|(_, missing)| missing)
}

/// Returns true if an atom is about one parameter that is not fixed, and is true of nothing.
fn is_open(world: &World, atom: &Atom, fixed: &[Option<EntityId>]) -> bool {
    let [Term::Variable(slot)] = atom.terms[..] else {
        return false;
    };
    fixed.get(slot).is_some_and(Option::is_none) && world.state.of_predicate(atom.predicate).is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pddl::read_problem;
    use longstep_model::domain;

    #[test]
    fn why_not_describes_a_free_parameter_as_something() {
        let text = "(define (domain kitchen) (:requirements :strips)
            (:predicates (oven ?x) (metal ?x) (hot ?x) (clean ?x))
            (:action heat :parameters (?x ?oven) :precondition (and (metal ?x) (oven ?oven)) :effect (hot ?x)))";
        let kitchen = domain::from_pddl("kitchen.pddl", text).unwrap();
        for (facts, expected) in [
            (
                "(metal cup)",
                "it would need that (oven something), and no action can make that so",
            ),
            (
                "(oven shelf)",
                "it would need that (metal cup), and no action can make that so",
            ),
            ("(metal cup) (oven shelf)", ""),
        ] {
            let problem = format!(
                "(define (problem one) (:domain kitchen) (:objects cup shelf) (:init {facts}) (:goal (hot cup)))"
            );
            let problem = read_problem(&kitchen, "problem.pddl", &problem).unwrap();
            let why = why_not(&problem.world, &Purpose::from(&problem), &Limits::default());
            let sentence = why.missing.map(|missing| missing.sentence(&problem.world));
            assert_eq!(sentence.unwrap_or_default(), expected, "{facts}");
        }
    }
}
