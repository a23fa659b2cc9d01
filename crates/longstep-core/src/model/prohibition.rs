//! Prohibitions: what no state and no step of a plan may be, as a person has stated it.

use super::{ActionId, Condition, EntityId, Rule, RuleTime, Template, World};

/// A constraint on every state and step of a plan, stated with one instruction or for a whole session.
///
/// A world holds the prohibitions in force ([`World::with_prohibitions`]), so no plan for it is bound, found, repaired
/// or verified without them.
#[derive(Debug, Clone)]
pub struct Prohibition {
    /// The prohibition in the goal language, with identifiers: `never closed(<fridge>)`.
    pub written: String,
    /// The prohibition as a sentence.
    pub says: String,
    /// True for a prohibition that stays in force after the instruction.
    pub standing: bool,
    /// The condition that must hold in every state, if there is one. It binds from the first state in which it holds.
    pub(crate) always: Option<Rule>,
    /// The steps that are forbidden.
    pub(crate) steps: Vec<StepPattern>,
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

impl Prohibition {
    /// Creates a prohibition. `always` has no open variables: its entities are constants.
    pub(crate) fn new(written: String, says: String, always: Option<Condition>, steps: Vec<StepPattern>) -> Self {
        let rule = |condition: Condition| Rule {
            name: written.clone(),
            time: RuleTime::Always,
            variables: Vec::new(),
            condition,
            says: Template::default(),
            unless: Vec::new(),
        };
        Self {
            always: always.map(rule),
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
    /// Returns the world with further prohibitions in force.
    #[must_use]
    pub fn with_prohibitions(&self, more: impl IntoIterator<Item = Prohibition>) -> Self {
        let mut world = self.clone();
        world.set_prohibitions(self.prohibitions().iter().cloned().chain(more));
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
    pub(crate) fn always_rules(&self) -> impl Iterator<Item = (usize, &Rule)> {
        let rules = self.domain().rules.iter().enumerate();
        let own = self.prohibitions().iter().enumerate();
        let first = self.domain().rules.len();
        rules
            .filter(|(_, rule)| rule.time == RuleTime::Always)
            .chain(own.filter_map(move |(index, own)| Some((first + index, own.always.as_ref()?))))
    }

    /// Returns the prohibition with this number in [`World::always_rules`]; none for a rule of the domain.
    pub(crate) fn prohibition(&self, number: usize) -> Option<&Prohibition> {
        let index = number.checked_sub(self.domain().rules.len())?;
        self.prohibitions().get(index)
    }

    /// Returns the prohibition that forbids a step, if one does.
    pub(crate) fn forbids(&self, action: ActionId, arguments: &[EntityId]) -> Option<&Prohibition> {
        let fits = |own: &&Prohibition| own.steps.iter().any(|pattern| pattern.fits(action, arguments));
        self.prohibitions().iter().find(fits)
    }
}
