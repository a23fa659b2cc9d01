//! Stages of a goal: which goals of earlier stages still hold at the end.

use super::{Goal, GoalFact};
use crate::effort;
use crate::model::{
    Arithmetic, Atom, Condition, Domain, EntityId, Fact, GroundTest, Moment, Number, PredicateId, RuleTime, State,
    Term, Wanted, World, broken_bindings, holds, unify,
};
use crate::search::{Formula, Literal, Meaning, ground_condition};
use crate::verify::Milestone;

/// Maximum number of predicates whose facts exclude each other by the effects of actions.
const GROUP: usize = 5;

impl Goal {
    /// Returns the ranges of facts of the stages, in order; one range for a goal without order.
    pub(super) fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> {
        let ends = self.stages.iter().copied().chain([self.facts.len()]);
        let starts = [0].into_iter().chain(self.stages.iter().copied());
        starts.zip(ends).map(|(start, end)| start..end)
    }

    /// Returns the conditions of each stage; `all` has the condition of each goal.
    ///
    /// A goal of a later stage must be achieved anew, unless it holds from the beginning, or it holds whenever the stage
    /// before it is achieved: a box is put down at the dock only by a robot that is there.
    pub(super) fn milestones(&self, world: &World, all: &[Wanted]) -> Vec<Vec<Milestone>> {
        let moment = Moment {
            world,
            state: &world.state,
        };
        let needs: Vec<Vec<Needs>> = self.facts.iter().map(|fact| Needs::of(world, fact)).collect();
        // One goal of a choice is achieved, and it is open which.
        let is_definite = |index: &usize| !matches!(self.facts[*index], GoalFact::Choice(_));
        let mut before = 0..0;
        let mut stages = Vec::new();
        for range in self.ranges() {
            let milestone = |index: usize| {
                let wanted = all[index].clone();
                let initially = holds(moment, &wanted.condition, &mut wanted.bindings.clone());
                let implied = || {
                    let earlier = before.clone().filter(is_definite).flat_map(|index| &needs[index]);
                    let earlier: Vec<&Needs> = earlier.collect();
                    let follows = |leaf: usize| needs[index][leaf].follow_from(world, &earlier);
                    match &self.facts[index] {
                        GoalFact::Choice(choice) => choice.is_possible(&follows),
                        _ => (0..needs[index].len()).all(follows),
                    }
                };
                let anew = range.start > 0 && !initially && !implied();
                Milestone { wanted, anew }
            };
            stages.push(range.clone().map(milestone).collect());
            before = range;
        }
        stages
    }

    /// By fact: true if it must hold at the end. A goal of an earlier stage need not if one of a later stage cannot
    /// hold together with it.
    pub(super) fn kept(&self, world: &World) -> Vec<bool> {
        let last = self.stages.last().copied().unwrap_or(0);
        let needs: Vec<Vec<Needs>> = match last {
            0 => Vec::new(),
            _ => self.facts.iter().map(|fact| Needs::of(world, fact)).collect(),
        };
        let mut kept = vec![true; self.facts.len()];
        for range in self.ranges() {
            for earlier in range.clone().take_while(|_| range.end < self.facts.len()) {
                let excludes = |one: &Needs, later: usize| {
                    let mut those = needs[later].iter();
                    match self.facts[later] {
                        GoalFact::Choice(_) => those.all(|other| one.excludes(world, other)),
                        _ => those.any(|other| one.excludes(world, other)),
                    }
                };
                let lasts = |leaf: usize| {
                    let one = &needs[earlier][leaf];
                    !(range.end..self.facts.len()).any(|later| excludes(one, later))
                };
                kept[earlier] = match &self.facts[earlier] {
                    GoalFact::Choice(choice) => choice.is_possible(&lasts),
                    _ => (0..needs[earlier].len()).all(lasts),
                };
            }
        }
        kept
    }
}

/// A conjunction of literals.
#[derive(Debug, Clone, Default)]
struct Literals {
    facts: Vec<(Fact, bool)>,
    tests: Vec<GroundTest>,
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
const ALTERNATIVES: usize = 32;

/// The needs of a goal: the literals of each of its alternatives.
struct Needs<'g> {
    fact: &'g GoalFact,
    /// Empty if there are too many alternatives.
    alternatives: Vec<Literals>,
}

impl<'g> Needs<'g> {
    /// Returns the needs of each goal without conditions and groups in a goal.
    fn of(world: &World, fact: &'g GoalFact) -> Vec<Self> {
        let leaves = fact.leaves().into_iter();
        leaves.map(|fact| Self::of_part(world, fact)).collect()
    }

    fn of_part(world: &World, fact: &'g GoalFact) -> Self {
        let wanted = fact.wanted(world.domain(), &[]);
        let ground = ground_condition(world, &wanted.condition, &wanted.bindings);
        let alternatives = alternatives(&ground.formula).unwrap_or_default();
        Self {
            fact,
            alternatives: alternatives
                .iter()
                .map(|literals| Literals::of(literals, &ground.facts))
                .collect(),
        }
    }

    /// Returns true if an alternative of the goal holds whenever the earlier goals are achieved.
    fn follow_from(&self, world: &World, earlier: &[&Needs]) -> bool {
        let achieved = earlier.iter().filter_map(|earlier| match &earlier.alternatives[..] {
            [literals] => Some(literals),
            _ => None,
        });
        let achieved: Vec<Fact> = achieved
            .flat_map(|literals| &literals.facts)
            .filter(|(_, holds)| *holds)
            .map(|(fact, _)| *fact)
            .collect();
        let follows = |(fact, holds): &(Fact, bool)| {
            *holds && (world.state.holds(*fact) || achieved.iter().any(|done| implies(world, *done, *fact)))
        };
        let holds = |test: &GroundTest| test.holds(&|fluent| world.state.number(*fluent));
        self.alternatives
            .iter()
            .any(|literals| literals.facts.iter().all(follows) && literals.tests.iter().all(holds))
    }

    /// Returns true if two goals cannot hold in one state.
    fn excludes(&self, world: &World, other: &Needs) -> bool {
        let pairs = || {
            let mut pairs = self
                .alternatives
                .iter()
                .flat_map(|own| other.alternatives.iter().map(move |them| (own, them)));
            pairs.all(|(own, them)| excludes(world, own, them))
        };
        let known = !self.alternatives.is_empty() && !other.alternatives.is_empty();
        self.is_of_the_group_of(world.domain(), other) || known && pairs()
    }

    /// Returns true if both are goals of one group of the domain with the same first argument.
    fn is_of_the_group_of(&self, domain: &Domain, other: &Needs) -> bool {
        let group = |fact: &GoalFact| match fact {
            GoalFact::Word { word, arguments } => {
                Some((domain.goal_word(*word).exclusive.clone()?, *arguments.first()?))
            }
            _ => None,
        };
        self.fact != other.fact && group(self.fact).is_some_and(|own| group(other.fact) == Some(own))
    }
}

/// Returns the conjunctions of which a condition is the disjunction; none if there are too many.
fn alternatives(formula: &Formula) -> Option<Vec<Vec<Literal>>> {
    let found = match formula {
        Formula::Literal(literal) => vec![vec![*literal]],
        Formula::Or(parts) => parts.iter().map(alternatives).collect::<Option<Vec<_>>>()?.concat(),
        Formula::And(parts) => parts
            .iter()
            .try_fold(vec![Vec::new()], |all: Vec<Vec<Literal>>, part| {
                let part = alternatives(part)?;
                let with = |literals: &Vec<Literal>| {
                    part.iter()
                        .map(|more| [&literals[..], more].concat())
                        .collect::<Vec<_>>()
                };
                let all: Vec<Vec<Literal>> = all.iter().flat_map(with).collect();
                (all.len() <= ALTERNATIVES).then_some(all)
            })?,
    };
    (found.len() <= ALTERNATIVES && effort::spend(1 + found.len())).then_some(found)
}

/// Returns true if the literals cannot all hold in one state. Events never exclude anything: they have happened.
fn excludes(world: &World, own: &Literals, other: &Literals) -> bool {
    let domain = world.domain();
    let lasting = |literals: &Literals| -> Literals {
        let lasts = |(fact, _): &&(Fact, bool)| !domain.words(fact.predicate()).event;
        Literals {
            facts: literals.facts.iter().filter(lasts).copied().collect(),
            tests: literals.tests.clone(),
        }
    };
    let (own, other) = (lasting(own), lasting(other));
    effort::spend(1 + own.facts.len() * other.facts.len() + own.tests.len() * other.tests.len());
    let contradicts = |one: &GroundTest| other.tests.iter().any(|other| are_contradictory(one, other));
    own.facts
        .iter()
        .any(|(fact, holds)| other.facts.contains(&(*fact, !holds)))
        || own.tests.iter().any(contradicts)
        || break_a_rule(world, &own, &other)
        || positive(&own).any(|fact| positive(&other).any(|other| displaced_by(world, fact, other)))
}

/// Returns true if no number satisfies both requirements, as far as comparisons of one fluent with constants show.
fn are_contradictory(one: &GroundTest, other: &GroundTest) -> bool {
    let bound = |test: &GroundTest| match test {
        GroundTest::Compare(Arithmetic::Value(fluent), comparison, Arithmetic::Constant(number)) => {
            Some((*fluent, *comparison, *number))
        }
        _ => None,
    };
    let (Some((fluent, first, least)), Some((same, second, most))) = (bound(one), bound(other)) else {
        return false;
    };
    // If any number satisfies both, so does one of the two, or one just beside them or between them.
    let beside = |number: Number| {
        let step = Number::of_millionths(1);
        [
            Some(number),
            step.and_then(|step| number.plus(step)),
            step.and_then(|step| number.minus(step)),
        ]
    };
    let satisfies = |number: Number| first.holds(number, least) && second.holds(number, most);
    fluent == same && !beside(least).into_iter().chain(beside(most)).flatten().any(satisfies)
}

fn positive(literals: &Literals) -> impl Iterator<Item = Fact> {
    literals.facts.iter().filter(|(_, holds)| *holds).map(|(fact, _)| *fact)
}

/// Returns true if both together break a rule about every environment or every state, and neither does alone.
fn break_a_rule(world: &World, own: &Literals, other: &Literals) -> bool {
    let domain = world.domain();
    let mut fixed = State::default();
    for fact in world.state.iter().filter(|fact| !domain.words(fact.predicate()).fluent) {
        fixed.set(fact, true);
    }
    let with = |literals: &[&Literals]| {
        let mut state = fixed.clone();
        for fact in literals.iter().flat_map(|literals| positive(literals)) {
            state.set(fact, true);
        }
        state
    };
    let (one, two, both) = (with(&[own]), with(&[other]), with(&[own, other]));
    let mut rules = domain
        .rules
        .iter()
        .filter(|rule| matches!(rule.time, RuleTime::Start | RuleTime::Always));
    rules.any(|rule| {
        let alone = [&one, &two].map(|state| broken_bindings(rule, world, state));
        let broken = broken_bindings(rule, world, &both);
        broken
            .iter()
            .any(|bindings| alone.iter().all(|alone| !alone.contains(bindings)))
    })
}

/// Returns true if the actions allow only one of two facts at a time.
fn displaced_by(world: &World, fact: Fact, other: Fact) -> bool {
    let arity = world.domain().arguments(fact).count();
    fact != other && (0..arity).any(|place| displaces(world, fact, other, place))
}

/// Returns true if two facts belong to one group of facts of which at most one holds; the argument of the first fact at
/// `place` tells the facts of the group apart.
fn displaces(world: &World, fact: Fact, other: Fact, place: usize) -> bool {
    let domain = world.domain();
    let first = Member {
        predicate: fact.predicate(),
        counted: Some(place),
    };
    let Some(group) = exclusive(domain, vec![first]) else {
        return false;
    };
    let key = first.key_of(domain, fact);
    let of_group = |member: &&Member| member.predicate == other.predicate() && member.key_of(domain, other) == key;
    group.iter().any(|member| of_group(&member)) && at_most_one(world, &group)
}

/// A predicate in a group of facts that exclude each other. Facts with the same key belong to one group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Member {
    predicate: PredicateId,
    /// The argument that is not part of the key; none if all are.
    counted: Option<usize>,
}

impl Member {
    /// Returns the values without the counted one.
    fn key<T>(self, values: impl Iterator<Item = T>) -> Vec<T> {
        let others = values.enumerate().filter(|(place, _)| Some(*place) != self.counted);
        others.map(|(_, value)| value).collect()
    }

    fn key_of(self, domain: &Domain, fact: Fact) -> Vec<EntityId> {
        self.key(domain.arguments(fact))
    }
}

/// Returns a group of which every action that adds a fact deletes one with the same key; starts with `group`. None if
/// there is no such group, or only a larger one.
///
/// These are the invariants of Helmert, *Concise finite-domain representations for PDDL planning tasks* (2009), with
/// one predicate at a time added to the group.
fn exclusive(domain: &Domain, group: Vec<Member>) -> Option<Vec<Member>> {
    if group.len() > GROUP || !effort::spend(domain.actions.len()) {
        return None;
    }
    for action in &domain.actions {
        let of = |adds: bool| action.effects.iter().filter(move |effect| effect.adds == adds);
        let keys = |adds: bool| {
            let keys = of(adds).flat_map(|effect| {
                let members = group.iter().filter(|member| member.predicate == effect.atom.predicate);
                members.map(|member| member.key(effect.atom.terms.iter().copied()))
            });
            keys.collect::<Vec<Vec<Term>>>()
        };
        let (adds, deletes) = (keys(true), keys(false));
        for (index, key) in adds.iter().enumerate() {
            if adds[..index].contains(key) {
                return None;
            }
            if deletes.contains(key) {
                continue;
            }
            // What the action deletes instead may belong to the group.
            let larger = of(false).flat_map(|effect| {
                let arity = effect.atom.terms.len();
                let member = |counted| Member {
                    predicate: effect.atom.predicate,
                    counted,
                };
                let members = (0..arity).map(Some).chain([None]).map(member);
                members.filter(|member| member.key(effect.atom.terms.iter().copied()) == *key)
            });
            let mut larger = larger.filter(|member| group.iter().all(|known| known.predicate != member.predicate));
            return larger.find_map(|member| exclusive(domain, group.iter().copied().chain([member]).collect()));
        }
    }
    Some(group)
}

/// Returns true if at most one fact of each group holds in the initial state.
fn at_most_one(world: &World, group: &[Member]) -> bool {
    let domain = world.domain();
    let facts = group.iter().flat_map(|member| {
        let facts = world.state.of_predicate(member.predicate).iter();
        facts.map(|fact| member.key_of(domain, *fact))
    });
    let mut keys: Vec<Vec<EntityId>> = facts.collect();
    let all = keys.len();
    keys.sort_unstable();
    keys.dedup();
    keys.len() == all
}

/// Returns true if some action can make the first fact true, and each that can requires the second one.
fn implies(world: &World, made: Fact, required: Fact) -> bool {
    let mut makers = 0;
    for action in &world.domain().actions {
        for effect in action.effects.iter().filter(|effect| effect.adds) {
            let mut arguments = vec![None; action.parameters.len()];
            if effect.atom.predicate != made.predicate() || !unify(&effect.atom, made, &mut arguments) {
                continue;
            }
            makers += 1;
            let mut conditions = action.precondition.conjuncts().chain(effect.condition.conjuncts());
            let requires = conditions.any(|part| match part {
                Condition::Atom {
                    atom,
                    holds: true,
                    initially: false,
                } => atom.predicate == required.predicate() && is(atom, required, &arguments),
                _ => false,
            });
            if !effort::spend(action.parameters.len()) || !requires {
                return false;
            }
        }
    }
    makers > 0
}

/// Returns true if an atom is the fact, whatever the open parameters are.
fn is(atom: &Atom, fact: Fact, arguments: &[Option<EntityId>]) -> bool {
    atom.terms.iter().enumerate().all(|(place, term)| {
        let entity = match *term {
            Term::Constant(constant) => Some(constant),
            Term::Variable(slot) => arguments.get(slot).copied().flatten(),
        };
        entity == Some(fact.argument(place))
    })
}
