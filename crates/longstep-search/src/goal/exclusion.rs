//! Exclusion: goals that cannot hold in one state.

use super::bounds::are_contradictory;
use super::invariant::are_exclusive;
use crate::search::{Formula, GroundCondition, Literal, Meaning, ground_condition};
use longstep_model::effort;
use longstep_model::model::{Bindings, EntityId, Fact, GroundTest, Rule, RuleTime, State, World, broken_bindings};

/// A conjunction of literals.
#[derive(Debug, Clone, Default)]
pub(super) struct Literals {
    pub(super) facts: Vec<(Fact, bool)>,
    pub(super) tests: Vec<GroundTest>,
}

impl Literals {
    /// Returns the literals of a ground condition.
    fn of(literals: &[Literal], meanings: &[Meaning]) -> Self {
        let mut all = Self::default();
        for literal in literals {
            match &meanings[literal.fact as usize] {
                Meaning::Fact(fact) => all.facts.push((*fact, literal.holds)),
                Meaning::Test(test) if literal.holds => all.tests.push(test.clone()),
                Meaning::Test(test) => all.tests.push(test.clone().negated()),
            }
        }
        all
    }
}

/// Maximum number of alternatives of a goal that are considered.
// The disjunctive normal form may be exponential. A longer one excludes nothing, so no goal is given up by mistake.
const ALTERNATIVES: usize = 32;

/// Returns the conjunctions of which a condition is the disjunction; none if there are too many.
pub(super) fn alternatives(condition: &GroundCondition) -> Option<Vec<Literals>> {
    let all = conjunctions(&condition.formula)?.into_iter();
    Some(all.map(|literals| Literals::of(&literals, &condition.facts)).collect())
}

fn conjunctions(formula: &Formula) -> Option<Vec<Vec<Literal>>> {
    let found = match formula {
        Formula::Literal(literal) => vec![vec![*literal]],
        Formula::Or(parts) => parts.iter().map(conjunctions).collect::<Option<Vec<_>>>()?.concat(),
        Formula::And(parts) => parts
            .iter()
            .try_fold(vec![Vec::new()], |all: Vec<Vec<Literal>>, part| {
                let part = conjunctions(part)?;
                let pairs = all.iter().flat_map(|own| part.iter().map(move |more| (own, more)));
                let all: Vec<Vec<Literal>> = pairs.map(|(own, more)| [&own[..], more].concat()).collect();
                (all.len() <= ALTERNATIVES).then_some(all)
            })?,
    };
    (found.len() <= ALTERNATIVES && effort::spend(1 + found.len())).then_some(found)
}

/// Returns true if the literals cannot all hold in one state: the facts contradict each other, or the numbers, or an
/// invariant, or a rule of the domain. Events never exclude anything: they have happened.
pub(super) fn excludes(world: &World, own: &Literals, other: &Literals) -> bool {
    let lasts = |(fact, _): &&(Fact, bool)| !world.domain().words(fact.predicate()).event;
    let lasting = |literals: &Literals| -> Vec<(Fact, bool)> { literals.facts.iter().filter(lasts).copied().collect() };
    let (one, two) = (lasting(own), lasting(other));
    effort::spend(1 + one.len() * two.len());
    let both = Literals {
        facts: [&one[..], &two].concat(),
        tests: [&own.tests[..], &other.tests].concat(),
    };
    one.iter().any(|(fact, holds)| two.contains(&(*fact, !holds)))
        || !both.tests.is_empty() && are_contradictory(&both.tests)
        || positive(&one).any(|fact| positive(&two).any(|other| are_exclusive(world, fact, other)))
        || both.break_a_rule(world)
}

fn positive(facts: &[(Fact, bool)]) -> impl Iterator<Item = Fact> {
    facts.iter().filter(|(_, holds)| *holds).map(|(fact, _)| *fact)
}

impl Literals {
    /// Returns true if a rule of the domain that holds now is false in every state in which the literals hold.
    fn break_a_rule(&self, world: &World) -> bool {
        let domain = world.domain();
        let mut least = State::default();
        for fact in world.state.iter().filter(|fact| !domain.words(fact.predicate()).fluent) {
            least.set(fact, true);
        }
        for fact in positive(&self.facts) {
            least.set(fact, true);
        }
        let mut rules = domain.rules.iter().filter(|rule| rule.time == RuleTime::Always);
        rules.any(|rule| {
            let is_numeric = rule.condition.numbers().next().is_some();
            // The state with the fewest facts has no numbers, so rules about numbers cannot be judged in it.
            let instances = if is_numeric && !self.tests.is_empty() {
                all_bindings(world, rule)
            } else {
                // A rule that is false in every such state is false in the one with the fewest facts.
                broken_bindings(rule, world, &least)
            };
            instances.iter().any(|bindings| self.denies(world, rule, bindings))
        })
    }

    /// Returns true if an instance of a rule holds now, and is false in every state in which the literals hold.
    fn denies(&self, world: &World, rule: &Rule, bindings: &[EntityId]) -> bool {
        let GroundCondition { formula, facts } = ground_condition(world, &rule.condition, bindings);
        let now = |literal: Literal| facts[literal.fact as usize].holds(&world.state) == literal.holds;
        // A rule that is broken now does not bind yet, so it excludes nothing.
        formula.holds(&now) && self.deny(&formula, &facts)
    }

    /// Returns true if neither the facts nor the tests contradict a literal with this meaning.
    fn permit(&self, meaning: &Meaning, holds: bool) -> bool {
        match meaning {
            Meaning::Fact(fact) => !self.facts.contains(&(*fact, !holds)),
            Meaning::Test(test) => {
                let test = if holds { test.clone() } else { test.clone().negated() };
                !are_contradictory(self.tests.iter().chain([&test]))
            }
        }
    }

    /// Returns true if a formula is false in every state in which the literals hold.
    fn deny(&self, formula: &Formula, meanings: &[Meaning]) -> bool {
        let is_possible = |literal: Literal| self.permit(&meanings[literal.fact as usize], literal.holds);
        // Without budget nothing is excluded.
        effort::spend(formula.size() * (1 + self.facts.len() / 4 + self.tests.len())) && !formula.holds(&is_possible)
    }
}

/// Returns all bindings of the variables of a rule.
fn all_bindings(world: &World, rule: &Rule) -> Vec<Bindings> {
    let mut all = vec![Bindings::new()];
    for variable in &rule.variables {
        let longer = all.iter().flat_map(|bindings| {
            let entities = world
                .of_kind(variable.kind)
                .iter()
                .take_while(|_| effort::spend(effort::KEPT));
            entities.map(|entity| [&bindings[..], &[*entity]].concat())
        });
        all = longer.collect();
    }
    all
}
