//! Stages of a goal: which goals of earlier stages still hold at the end.

use super::exclusion::{Literals, alternatives, excludes};
use super::{Goal, GoalFact};
use crate::search::ground_condition;
use longstep_model::effort;
use longstep_model::model::{
    Atom, Condition, Domain, EntityId, Fact, GroundTest, Moment, Term, Wanted, When, World, holds, unify,
};
use longstep_verify::verify::Milestone;

impl Goal {
    /// Returns the ranges of facts of the stages, in order; one range for a goal without order.
    pub(super) fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> {
        let ends = self.stages.iter().copied().chain([self.facts.len()]);
        let starts = [0].into_iter().chain(self.stages.iter().copied());
        starts.zip(ends).map(|(start, end)| start..end)
    }

    /// Returns the goal with an order where it has none and asks for what cannot hold together of one thing: such goals are achieved one
    /// after the other, as they were said. None if nothing has to be ordered, or if the goal has groups. Two things in one hand remain a
    /// goal without a plan.
    ///
    /// ```
    /// use longstep_model::{domain, environment};
    /// use longstep_search::goal;
    /// let household = domain::shipped("household").unwrap()?;
    /// let world = environment::parse(&household, "desk.json", r#"{"assets": ["<desk>", "<shelf>"],
    ///     "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// let goal = goal::parse(&world, "put(pen, shelf) & put(pen, desk)")?;
    /// assert_eq!(goal.in_order(&world).unwrap().text(&world), "put(pen, shelf) then put(pen, desk)");
    /// assert!(goal::parse(&world, "put(pen, shelf)")?.in_order(&world).is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn in_order(&self, world: &World) -> Option<Self> {
        if !self.stages.is_empty() || !self.groups.is_empty() {
            return None;
        }
        let mut stages: Vec<usize> = Vec::new();
        for next in 1..self.facts.len() {
            let start = stages.last().copied().unwrap_or(0);
            // With the next goal as a stage of its own, `kept` says which goals it excludes.
            let two = Self {
                facts: self.facts[start..=next].to_vec(),
                stages: vec![next - start],
                ..Self::default()
            };
            let subject = |index: usize| self.facts[index].subject(world.domain());
            let kept = two.kept(world);
            // Goals about different subjects stay without a plan: nobody asked for one after the other.
            if (start..next).any(|index| !kept[index - start] && subject(index) == subject(next)) {
                stages.push(next);
            }
        }
        (!stages.is_empty()).then(|| Self { stages, ..self.clone() })
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
            let earlier: Vec<&Needs> = before.filter(is_definite).flat_map(|index| &needs[index]).collect();
            let mut milestones = Vec::with_capacity(range.len());
            for index in range.clone() {
                let wanted = all[index].clone();
                let initially = holds(moment, &wanted.condition, &mut wanted.bindings.clone());
                let implied = || self.facts[index].follows_from(world, &needs[index], &earlier);
                let anew = range.start > 0 && !initially && !implied();
                milestones.push(Milestone { wanted, anew });
            }
            stages.push(milestones);
            before = range;
        }
        stages
    }

    /// By fact: true if it must hold at the end. A goal of an earlier stage need not if one of a later stage cannot
    /// hold together with it.
    pub(super) fn kept(&self, world: &World) -> Vec<bool> {
        let mut kept = vec![true; self.facts.len()];
        if self.stages.is_empty() {
            return kept;
        }
        let needs: Vec<GoalNeeds> = self.facts.iter().map(|fact| GoalNeeds::of(world, fact)).collect();
        for range in self.ranges() {
            for earlier in range.clone() {
                kept[earlier] = needs[earlier].last(world, &needs[range.end..]);
            }
        }
        kept
    }
}

/// The needs of a goal as a whole, and of the goals without conditions and groups in it.
struct GoalNeeds<'g> {
    fact: &'g GoalFact,
    whole: Needs<'g>,
    parts: Vec<Needs<'g>>,
}

impl GoalFact {
    /// Returns true if the goal, of which these are the needs, holds whenever the earlier goals are achieved.
    fn follows_from(&self, world: &World, needs: &[Needs], earlier: &[&Needs]) -> bool {
        let follows = |leaf: usize| needs[leaf].follow_from(world, earlier);
        match self {
            Self::Choice(choice) => choice.is_possible(&follows),
            _ => (0..needs.len()).all(follows),
        }
    }
}

impl<'g> GoalNeeds<'g> {
    fn of(world: &World, fact: &'g GoalFact) -> Self {
        Self {
            fact,
            whole: Needs::of_part(world, fact),
            parts: Needs::of(world, fact),
        }
    }

    /// Returns false if one of the later goals excludes this one.
    fn last(&self, world: &World, later: &[GoalNeeds]) -> bool {
        let lasts = |part: usize| !later.iter().any(|other| other.excludes_part(world, &self.parts[part]));
        let possible = match self.fact {
            GoalFact::Choice(choice) => choice.is_possible(&lasts),
            _ => (0..self.parts.len()).all(lasts),
        };
        possible && !later.iter().any(|other| self.excludes_choice(world, other))
    }

    /// Returns true if one of two goals is a choice, and they cannot hold together.
    fn excludes_choice(&self, world: &World, other: &GoalNeeds) -> bool {
        let is_choice = |own: &GoalNeeds| matches!(own.fact, GoalFact::Choice(_));
        let has_conditions = self.fact.is_conditional() || other.fact.is_conditional();
        (is_choice(self) || is_choice(other)) && !has_conditions && self.whole.excludes(world, &other.whole)
    }

    /// Returns true if this goal cannot hold together with a part of another one.
    fn excludes_part(&self, world: &World, part: &Needs) -> bool {
        let mut own = self.parts.iter();
        match self.fact {
            GoalFact::Choice(_) => own.all(|own| own.excludes(world, part)),
            _ => own.any(|own| own.excludes(world, part)),
        }
    }
}

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
        Self {
            fact,
            alternatives: alternatives(&ground).unwrap_or_default(),
        }
    }

    /// Returns true if an alternative of the goal holds whenever the earlier goals are achieved.
    fn follow_from(&self, world: &World, earlier: &[&Needs]) -> bool {
        let achieved = earlier.iter().filter_map(|earlier| match &earlier.alternatives[..] {
            // Of several alternatives it is open which one is achieved.
            [literals] => Some(literals),
            _ => None,
        });
        let achieved: Vec<Fact> = achieved
            .flat_map(|literals| &literals.facts)
            .filter(|(_, holds)| *holds)
            .map(|(fact, _)| *fact)
            .collect();
        let is_implied = |fact: Fact| achieved.iter().any(|done| implies(world, *done, fact));
        let holds = |fact: Fact| world.state.holds(fact) || is_implied(fact);
        let is_so = |test: &GroundTest| test.holds(&|fluent| world.state.number(*fluent));
        self.alternatives.iter().any(|literals| {
            let mut facts = literals.facts.iter();
            facts.all(|(fact, positive)| *positive && holds(*fact)) && literals.tests.iter().all(is_so)
        })
    }

    /// Returns true if two goals cannot hold in one state.
    fn excludes(&self, world: &World, other: &Needs) -> bool {
        if self.is_of_the_group_of(world.domain(), other) {
            return true;
        }
        // Without alternatives there are no pairs, and "all pairs" would be true.
        let known = !self.alternatives.is_empty() && !other.alternatives.is_empty();
        let excludes_all = |own: &Literals| other.alternatives.iter().all(|them| excludes(world, own, them));
        known && self.alternatives.iter().all(excludes_all)
    }

    /// Returns true if both are goals of one group of the domain with the same first argument.
    fn is_of_the_group_of(&self, domain: &Domain, other: &Needs) -> bool {
        let group = |fact: &GoalFact| exclusive_group(domain, fact);
        self.fact != other.fact && group(self.fact).is_some_and(|own| group(other.fact) == Some(own))
    }
}

/// Returns the group of goals of which one holds at a time for an entity, and that entity; none for a goal in no group.
fn exclusive_group(domain: &Domain, fact: &GoalFact) -> Option<(String, EntityId)> {
    match fact {
        GoalFact::Word { word, arguments } => Some((domain.goal_word(*word).exclusive.clone()?, *arguments.first()?)),
        _ => None,
    }
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
                    at: When::Now,
                } => atom.predicate == required.predicate() && is(atom, required, &arguments),
                _ => false,
            });
            if !effort::spend(action.parameters.len()) || !requires {
                return false;
            }
        }
    }
    // A fact that no action achieves implies nothing.
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
