//! Prohibitions: what no state and no step of a plan may be, as a person has stated it.

use std::sync::Arc;

use indexmap::IndexMap;
use indexmap::map::Entry;
use rustc_hash::{FxBuildHasher, FxHashMap};

use super::{ActionId, Condition, EntityId, Rule, RuleTime, Template, World};

/// A constraint on every state and step of a plan, stated with one instruction or for a whole session.
///
/// A world holds the prohibitions in force ([`World::with_prohibitions`]), so no plan for it is bound, found, repaired
/// or verified without them.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Prohibition {
    /// The prohibition in the goal language, with identifiers: `never closed(<fridge>)`.
    pub written: String,
    /// The prohibition as a sentence.
    pub says: String,
    /// True for a prohibition that stays in force after the instruction.
    pub standing: bool,
    /// The condition that must hold in every state, if there is one. It binds from the first state in which it holds.
    pub always: Option<Arc<Rule>>,
    /// The steps that are forbidden.
    pub steps: Vec<StepPattern>,
}

/// A pattern of steps.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct StepPattern {
    /// The action; none for every action.
    pub action: Option<ActionId>,
    /// By parameter: the entity in its place; none for any entity.
    pub arguments: Vec<Option<EntityId>>,
    /// An entity that is an argument in whatever place, if the pattern names one.
    pub anywhere: Option<EntityId>,
}

impl StepPattern {
    /// Returns true if the step fits the pattern.
    pub fn fits(&self, action: ActionId, arguments: &[EntityId]) -> bool {
        let same =
            |(pattern, argument): (&Option<EntityId>, &EntityId)| pattern.is_none_or(|entity| entity == *argument);
        self.action.is_none_or(|own| own == action)
            && self.arguments.iter().zip(arguments).all(same)
            && self.anywhere.is_none_or(|entity| arguments.contains(&entity))
    }
}

/// The forbidden steps of all prohibitions in force, filed so that a step is looked up and not compared with each of them.
#[derive(Debug, Default)]
pub(super) struct ForbiddenSteps {
    /// By action: its patterns, by the parameters that they fix.
    calls: FxHashMap<ActionId, Vec<FixedArguments>>,
    /// By entity: the first prohibition of every step with it.
    anywhere: FxHashMap<EntityId, usize>,
    /// All other patterns, with their prohibitions.
    others: Vec<(StepPattern, usize)>,
}

/// The patterns of an action that fix the same parameters.
#[derive(Debug)]
struct FixedArguments {
    parameters: Vec<usize>,
    /// By the fixed arguments: the first prohibition.
    first: FxHashMap<Vec<EntityId>, usize>,
}

impl ForbiddenSteps {
    pub(super) fn of(prohibitions: &[Prohibition]) -> Self {
        let mut forbidden = Self::default();
        for (number, own) in prohibitions.iter().enumerate() {
            own.steps.iter().for_each(|pattern| forbidden.add(pattern, number));
        }
        forbidden
    }

    fn add(&mut self, pattern: &StepPattern, number: usize) {
        let fixed = pattern.arguments.iter().enumerate();
        let (parameters, arguments): (Vec<usize>, Vec<EntityId>) = fixed
            .filter_map(|(parameter, argument)| Some((parameter, (*argument)?)))
            .unzip();
        match (pattern.action, pattern.anywhere) {
            (Some(action), None) => {
                let groups = self.calls.entry(action).or_default();
                let known = groups.iter().position(|group| group.parameters == parameters);
                let group = known.unwrap_or_else(|| {
                    let first = FxHashMap::default();
                    groups.push(FixedArguments { parameters, first });
                    groups.len() - 1
                });
                groups[group].first.entry(arguments).or_insert(number);
            }
            (None, Some(entity)) if arguments.is_empty() => {
                self.anywhere.entry(entity).or_insert(number);
            }
            _ => self.others.push((pattern.clone(), number)),
        }
    }

    /// Returns the number of the first prohibition that forbids a step.
    fn first(&self, action: ActionId, arguments: &[EntityId]) -> Option<usize> {
        let groups = self.calls.get(&action).into_iter().flatten();
        let of_calls = groups.filter_map(|group| {
            let fixed = group
                .parameters
                .iter()
                .map(|parameter| arguments.get(*parameter).copied());
            group.first.get(&fixed.collect::<Option<Vec<EntityId>>>()?).copied()
        });
        let anywhere = arguments.iter().filter_map(|entity| self.anywhere.get(entity).copied());
        let others = self
            .others
            .iter()
            .filter(|(pattern, _)| pattern.fits(action, arguments));
        of_calls.chain(anywhere).chain(others.map(|(_, number)| *number)).min()
    }
}

impl Prohibition {
    /// Creates a prohibition. `always` has no open variables: its entities are constants.
    pub fn new(written: String, says: String, always: Option<Condition>, steps: Vec<StepPattern>) -> Self {
        let rule = |condition: Condition| Rule {
            name: written.clone(),
            time: RuleTime::Always,
            variables: Vec::new(),
            condition,
            says: Template::default(),
            unless: Vec::new(),
        };
        Self {
            always: always.map(rule).map(Arc::new),
            steps,
            standing: false,
            written,
            says,
        }
    }

    /// Returns the prohibition, in force until it is lifted.
    #[must_use]
    pub fn standing(self) -> Self {
        Self { standing: true, ..self }
    }
}

impl World {
    /// Returns the world with further prohibitions in force. One that is stated twice is in force once.
    ///
    /// ```
    /// use longstep_model::{domain, environment};
    /// use longstep_search::goal;
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let text = r#"{"assets": ["<table>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
    /// let world = environment::parse(&household, "env.json", text).unwrap();
    /// let rules = goal::rules(&world, "untouched(cup) & untouched(cup)").unwrap();
    /// let world = world.with_prohibitions(rules.clone()).with_prohibitions(rules);
    /// assert_eq!(world.prohibitions().len(), 1);
    /// ```
    #[must_use]
    pub fn with_prohibitions(&self, more: impl IntoIterator<Item = Prohibition>) -> Self {
        let own = self.prohibitions().iter().cloned();
        let mut all: IndexMap<String, Prohibition, FxBuildHasher> = IndexMap::default();
        for prohibition in own.chain(more) {
            match all.entry(prohibition.written.clone()) {
                Entry::Vacant(place) => {
                    place.insert(prohibition);
                }
                // It is lifted with the later of the two.
                Entry::Occupied(mut known) => known.get_mut().standing |= prohibition.standing,
            }
        }
        let mut world = self.clone();
        world.set_prohibitions(all.into_values());
        world
    }

    /// Returns the world with its standing prohibitions only.
    #[must_use]
    pub(crate) fn with_standing_prohibitions(mut self) -> Self {
        if self.prohibitions().iter().any(|prohibition| !prohibition.standing) {
            let standing = self.prohibitions().iter().filter(|prohibition| prohibition.standing);
            let standing: Vec<Prohibition> = standing.cloned().collect();
            self.set_prohibitions(standing);
        }
        self
    }

    /// Iterates over the conditions that must hold in every state: the domain's rules by their index, then those of the
    /// prohibitions.
    pub fn always_rules(&self) -> impl Iterator<Item = (usize, &Rule)> {
        let rules = self.domain().rules.iter().enumerate();
        let own = self.prohibitions().iter().enumerate();
        let first = self.domain().rules.len();
        rules
            .filter(|(_, rule)| rule.time == RuleTime::Always)
            .chain(own.filter_map(move |(index, own)| Some((first + index, own.always.as_deref()?))))
    }

    /// Returns the prohibition with this number in [`World::always_rules`]; none for a rule of the domain.
    pub fn prohibition(&self, number: usize) -> Option<&Prohibition> {
        let index = number.checked_sub(self.domain().rules.len())?;
        self.prohibitions().get(index)
    }

    /// Returns the prohibition that forbids a step, if one does.
    pub fn forbids(&self, action: ActionId, arguments: &[EntityId]) -> Option<&Prohibition> {
        self.prohibitions()
            .get(self.forbidden_steps().first(action, arguments)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the number of the prohibition that is found against a comparison with every pattern.
    #[test]
    fn a_step_is_forbidden_by_the_first_pattern_that_it_fits() {
        let entity = |id: usize| EntityId::new(id);
        let pattern = |action: Option<usize>, arguments: &[Option<usize>], anywhere: Option<usize>| StepPattern {
            action: action.map(ActionId::new),
            arguments: arguments.iter().map(|argument| argument.map(entity)).collect(),
            anywhere: anywhere.map(entity),
        };
        let patterns = [
            pattern(Some(0), &[Some(1), None], None),
            pattern(None, &[], Some(5)),
            pattern(Some(0), &[None, Some(2)], None),
            pattern(Some(1), &[None, None], None),
            pattern(Some(0), &[Some(1), Some(3)], None),
            pattern(Some(0), &[Some(4), None], Some(6)),
            pattern(Some(0), &[Some(1), None], None),
            pattern(None, &[None, Some(0)], None),
        ];
        let rule = |pattern: &StepPattern| Prohibition::new(String::new(), String::new(), None, vec![pattern.clone()]);
        for mask in 0..1_usize << patterns.len() {
            let own = patterns.iter().enumerate().filter(|(at, _)| mask >> at & 1 == 1);
            let rules: Vec<Prohibition> = own.map(|(_, pattern)| rule(pattern)).collect();
            let forbidden = ForbiddenSteps::of(&rules);
            for (action, one, other) in (0..3).flat_map(|a| (0..49).map(move |pair| (a, pair / 7, pair % 7))) {
                let (action, arguments) = (ActionId::new(action), [entity(one), entity(other)]);
                let expected = rules.iter().position(|own| own.steps[0].fits(action, &arguments));
                assert_eq!(
                    forbidden.first(action, &arguments),
                    expected,
                    "{action:?} {arguments:?} {mask:b}"
                );
            }
        }
    }
}
