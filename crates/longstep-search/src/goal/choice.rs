//! Goals that must hold for some members of a group: `put(any cup, table)`, `put(2 of plate, any shelf)`.

use rustc_hash::FxHashMap;

use super::{GoalFact, Group, Quantifier};
use longstep_model::model::{Condition, Domain, EntityId, Moment, State, Voice, Wanted, World, apply, holds};
use longstep_verify::verify::Report;

/// A goal over groups that leaves the members to search.
///
/// The groups are nested in their order: `put(2 of plate, any shelf)` requires of two plates that each is on some shelf.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Choice {
    /// The groups, none of which is `all`, outermost first.
    pub groups: Vec<Group>,
    /// For each combination of members that makes sense: a member of each group, and the goal for them.
    pub goals: Vec<(Vec<EntityId>, GoalFact)>,
}

impl Choice {
    /// Returns the goals among which search chooses.
    pub fn alternatives(&self) -> impl Iterator<Item = &GoalFact> {
        self.goals.iter().map(|(_, goal)| goal)
    }

    /// Returns the alternatives that a plan achieves: those that hold at its end, on as many of its branches as possible, or
    /// else in some state on the way.
    pub fn achieved(&self, report: &Report) -> Vec<&GoalFact> {
        let world = &report.world;
        let domain = world.domain();
        let wanted: Vec<(&GoalFact, Wanted)> = self
            .alternatives()
            .map(|goal| (goal, goal.wanted(domain, &[])))
            .collect();
        let endings: Vec<State> = report.endings.iter().map(|ending| ending.after.clone()).collect();
        let mut state = world.state.clone();
        let mut on_the_way = vec![state.clone()];
        for step in report.plan.steps() {
            apply(world, &mut state, domain.action(step.action), &step.arguments);
            on_the_way.push(state.clone());
        }
        let mut found = [(&endings, true), (&endings, false), (&on_the_way, false)]
            .into_iter()
            .map(|(states, everywhere)| holding(world, &wanted, states, everywhere));
        found.find(|found| !found.is_empty()).unwrap_or_default()
    }

    /// Writes the choice in the goal language; `name` gives the name of each entity.
    pub(super) fn written(&self, domain: &Domain, name: &dyn Fn(EntityId) -> String) -> String {
        self.of_first(
            |goal, name| goal.written(domain, name),
            &|group| group.written(name),
            name,
        )
    }

    /// Writes the choice as a sentence.
    pub(super) fn sentence(&self, voice: Voice, world: &World) -> String {
        let counted = self.groups.iter().filter(|group| group.quantifier != Quantifier::Any);
        let counted = counted.map(|group| {
            let number = match group.count() {
                Quantifier::Exactly(number) => format!("exactly {number}"),
                other => format!("at least {}", other.least()),
            };
            format!("for {number} of ({}): ", group.members_in(voice, world))
        });
        let counted: String = counted.collect();
        let sentence = self.of_first(
            |goal, name| goal.sentence_with(voice, world, name),
            &|group| match group.quantifier {
                Quantifier::Any => group.sentence_in(voice, world),
                _ => "it".to_owned(),
            },
            &|entity| voice.name(world, entity),
        );
        format!("{counted}{sentence}")
    }

    /// Writes the first alternative with each group in place of its member.
    fn of_first(
        &self,
        write: impl Fn(&GoalFact, &dyn Fn(EntityId) -> String) -> String,
        group: &dyn Fn(&Group) -> String,
        name: &dyn Fn(EntityId) -> String,
    ) -> String {
        let Some((members, goal)) = self.goals.first() else {
            return String::new();
        };
        write(
            goal,
            &|entity| match members.iter().position(|member| *member == entity) {
                Some(place) => group(&self.groups[place]),
                None => name(entity),
            },
        )
    }

    /// Maps the choice to another world by identifiers; none if an entity is missing there.
    pub(super) fn carried(&self, domain: &Domain, from: &World, to: &World) -> Option<Self> {
        let there = |entity: &EntityId| to.find(&from.entity(*entity).identifier);
        let goals = self.goals.iter().map(|(members, goal)| {
            let members = members.iter().map(there).collect::<Option<Vec<_>>>()?;
            Some((members, goal.carried(domain, from, to)?))
        });
        Some(Self {
            groups: self
                .groups
                .iter()
                .map(|group| group.carried(from, to))
                .collect::<Option<Vec<_>>>()?,
            goals: goals.collect::<Option<Vec<_>>>()?,
        })
    }

    /// Returns all entities in the choice, sorted.
    pub(super) fn about(&self, domain: &Domain) -> Vec<EntityId> {
        let mut all: Vec<EntityId> = self.alternatives().flat_map(|goal| goal.about(domain)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Returns the subject of the goal, unless it is a group.
    pub(super) fn subject(&self, domain: &Domain) -> Option<EntityId> {
        let (members, goal) = self.goals.first()?;
        goal.subject(domain).filter(|subject| !members.contains(subject))
    }

    /// Returns true if the choice can be achieved with the alternatives for which `allowed` is true of their index.
    pub(super) fn is_possible(&self, allowed: &dyn Fn(usize) -> bool) -> bool {
        let all: Vec<usize> = (0..self.goals.len()).collect();
        let part = &|index: usize| truth(allowed(index));
        let condition = self.nested(0, &all, part, &|quantifier, parts| {
            let met = parts.iter().filter(|part| **part == Condition::TRUE).count();
            // More members than wanted are no obstacle: a plan may leave them out.
            truth(met >= quantifier.least())
        });
        condition == Condition::TRUE
    }

    /// Returns the condition to achieve.
    pub(super) fn wanted(&self, domain: &Domain) -> Wanted {
        let bindings = self.about(domain);
        let part = &|index: usize| {
            let Wanted { condition, bindings } = self.goals[index].1.wanted(domain, &[]);
            condition.bound(&bindings)
        };
        let all: Vec<usize> = (0..self.goals.len()).collect();
        let condition = self.nested(0, &all, part, &|quantifier, parts| match quantifier {
            Quantifier::All | Quantifier::AllBut(_) => Condition::And(parts),
            Quantifier::Any => Condition::Or(parts),
            Quantifier::AtLeast(number) => at_least(number, &parts),
            Quantifier::Exactly(number) => Condition::And(vec![
                at_least(number, &parts),
                at_least(number + 1, &parts).complement(),
            ]),
        });
        let shift = bindings.len();
        Wanted {
            condition: condition.with_slots(&|slot| slot + shift),
            bindings,
        }
    }

    /// Combines the alternatives from the innermost group outwards.
    fn nested(
        &self,
        level: usize,
        indices: &[usize],
        part: &dyn Fn(usize) -> Condition,
        count: &dyn Fn(Quantifier, Vec<Condition>) -> Condition,
    ) -> Condition {
        let Some(group) = self.groups.get(level) else {
            return indices.first().map_or(truth(false), |index| part(*index));
        };
        let mut parts = Vec::with_capacity(group.members.len());
        for member in &group.members {
            let is_own = |index: &usize| self.goals[*index].0[level] == *member;
            let own: Vec<usize> = indices.iter().copied().filter(is_own).collect();
            parts.push(self.nested(level + 1, &own, part, count));
        }
        count(group.count(), parts)
    }

    /// Returns the number of copies of alternatives in the condition; see [`at_least`].
    pub(super) fn size(&self) -> usize {
        let mut known = FxHashMap::default();
        let mut copies = |number: usize, group: &Group| copies(number, group.members.len(), &mut known);
        let mut size = 1_usize;
        for group in &self.groups {
            size = size.saturating_mul(match group.count() {
                Quantifier::All | Quantifier::Any | Quantifier::AllBut(_) => group.members.len(),
                Quantifier::AtLeast(number) => copies(number, group),
                Quantifier::Exactly(number) => copies(number, group).saturating_add(copies(number + 1, group)),
            });
        }
        size
    }
}

/// Returns the goals whose conditions hold in all states, if `everywhere`, or else in some of them.
fn holding<'g>(
    world: &World,
    wanted: &[(&'g GoalFact, Wanted)],
    states: &[State],
    everywhere: bool,
) -> Vec<&'g GoalFact> {
    let mut found = Vec::new();
    for (goal, Wanted { condition, bindings }) in wanted {
        let is_so = |state: &State| holds(Moment { world, state }, condition, &mut bindings.clone());
        if everywhere && states.iter().all(is_so) || !everywhere && states.iter().any(is_so) {
            found.push(*goal);
        }
    }
    found
}

fn truth(value: bool) -> Condition {
    if value {
        Condition::TRUE
    } else {
        Condition::Or(Vec::new())
    }
}

/// Returns the condition that at least `number` of the parts hold.
///
/// The parts are halved: some number holds in the first half and the rest in the second one. For small numbers that is
/// much shorter than a list of all combinations: two of 64 take 384 parts instead of 4,032.
fn at_least(number: usize, parts: &[Condition]) -> Condition {
    match number {
        0 => truth(true),
        _ if number > parts.len() => truth(false),
        1 => Condition::Or(parts.to_vec()),
        _ if number == parts.len() => Condition::And(parts.to_vec()),
        _ => {
            let (first, second) = parts.split_at(parts.len() / 2);
            let ways = splits(number, first.len(), second.len());
            let ways = ways.map(|own| Condition::And(vec![at_least(own, first), at_least(number - own, second)]));
            Condition::Or(ways.collect())
        }
    }
}

/// Returns the numbers of parts that may hold in the first half.
fn splits(number: usize, first: usize, second: usize) -> std::ops::RangeInclusive<usize> {
    number.saturating_sub(second)..=number.min(first)
}

/// Returns the number of parts that [`at_least`] writes.
fn copies(number: usize, parts: usize, known: &mut FxHashMap<(usize, usize), usize>) -> usize {
    if number == 0 || number > parts {
        return 0;
    }
    if number == 1 || number == parts {
        return parts;
    }
    if let Some(copies) = known.get(&(number, parts)) {
        return *copies;
    }
    // Counted as in `at_least`, because a condition of that size must not be built to measure it.
    let (first, second) = (parts / 2, parts - parts / 2);
    let mut all = 0_usize;
    for own in splits(number, first, second) {
        all = all.saturating_add(copies(own, first, known));
        all = all.saturating_add(copies(number - own, second, known));
    }
    known.insert((number, parts), all);
    all
}
