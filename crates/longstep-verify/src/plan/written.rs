//! Written plans: the common form of all notations (JSON tree, Python script) before resolution.

use super::tree::{self, Lane, Node, Rebuild, Test};
use super::{Plan, StepId};
use longstep_model::call::{Call, is_script_keyword, unquoted};
use longstep_model::model::{Domain, EntityId, Fact, World, state_word};

/// A plan before resolution: its steps in reading order, and the tree over them.
///
/// Calls in conditions are not in the list of steps, because only a domain defines which of them are sensing actions
/// and which are state predicates. See [`super::resolve`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Written {
    /// The steps, without the calls in conditions.
    pub steps: Vec<WrittenStep>,
    /// The tree over the steps. All calls in conditions are [`super::Test::Holds`].
    pub body: Vec<WrittenNode>,
    /// The objects that the plan handles, for calls whose syntax omits them.
    pub objects: Vec<String>,
}

/// A node of a written plan.
pub type WrittenNode = Node<WrittenStep, String>;

/// A call before resolution.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WrittenStep {
    /// The call with its explicit arguments.
    pub call: Call,
    /// Arguments by name: parameter name and value. Most are implicit ones, which a call does not write.
    pub implicit: Vec<(String, String)>,
    /// Explanation of the step; may be empty.
    pub explanation: String,
}

impl WrittenStep {
    /// Creates a step of a call alone.
    pub(super) fn of_call(call: Call) -> Self {
        Self {
            call,
            implicit: Vec::new(),
            explanation: String::new(),
        }
    }

    /// Returns why no plan with a tree can have this step.
    pub(super) fn fault(&self) -> Option<&'static str> {
        if !is_name(&self.call.name) || is_script_keyword(&self.call.name) {
            Some("has a name that no script can write")
        } else if !self.call.arguments.iter().all(|argument| is_argument(argument)) {
            Some("has an argument that is no name")
        } else if !self.implicit.iter().all(|(name, _)| is_name(name)) {
            Some("names a parameter with what is no name")
        } else {
            None
        }
    }
}

impl Written {
    /// Returns true if the plan contains only steps and remarks.
    pub fn is_sequence(&self) -> bool {
        let flat = |node: &WrittenNode| matches!(node, Node::Step(_) | Node::Remark(_));
        self.body.iter().all(flat)
    }

    /// Returns true if the tree contains every step once, in reading order, and respects the depth limit.
    pub fn is_sound(&self) -> bool {
        tree::is_sound(&self.body, self.steps.len())
    }
}

impl Written {
    /// Converts a plan to written form; implicit arguments are given by name.
    pub fn of_plan(world: &World, plan: &Plan) -> Self {
        let domain = world.domain();
        let mut writer = Writer {
            domain,
            world,
            plan,
            steps: Vec::new(),
        };
        let body = writer.nodes(plan.body());
        Self {
            steps: writer.steps,
            body,
            objects: Vec::new(),
        }
    }
}

struct Writer<'a> {
    domain: &'a Domain,
    world: &'a World,
    plan: &'a Plan,
    steps: Vec<WrittenStep>,
}

impl Rebuild<Fact, EntityId> for Writer<'_> {
    type Fact = WrittenStep;
    type Actor = String;

    fn step(&mut self, step: StepId, nodes: &mut Vec<WrittenNode>) {
        nodes.push(Node::Step(self.add(step, None)));
    }

    fn condition(&mut self, condition: &Test) -> Test<WrittenStep> {
        condition.map(&mut |step| Test::Holds(self.words(step, None)), &mut |fact| {
            Test::Holds(WrittenStep::of_call(self.state_call(*fact)))
        })
    }

    fn lane(&mut self, lane: &Lane) -> Lane<String> {
        lane.map(self.identifier(lane.actor), |step| {
            Some(self.add(step, Some(lane.actor)))
        })
    }
}

impl Writer<'_> {
    fn identifier(&self, entity: EntityId) -> String {
        self.world.entity(entity).identifier.clone()
    }

    /// Converts a step; its implicit arguments are given by name, except for the actor of a lane.
    fn words(&self, id: StepId, actor: Option<EntityId>) -> WrittenStep {
        let step = self.plan.step(id);
        let action = self.domain.action(step.action);
        let hidden = action
            .implicit()
            .filter(|parameter| actor.is_none() || action.actor != Some(*parameter));
        let named = hidden.map(|parameter| {
            let name = action.parameters[parameter].name.clone();
            (name, self.identifier(step.arguments[parameter]))
        });
        WrittenStep {
            call: step.call(self.world),
            implicit: named.collect(),
            explanation: step.explanation.clone(),
        }
    }

    fn add(&mut self, id: StepId, actor: Option<EntityId>) -> StepId {
        let words = self.words(id, actor);
        self.steps.push(words);
        StepId::new(self.steps.len() - 1)
    }

    /// Returns the call for a state predicate. It has the environment's state word with the entity of the entry first,
    /// or the predicate's own name if no state word exists.
    fn state_call(&self, fact: Fact) -> Call {
        let Some(word) = state_word(self.domain, fact.predicate()) else {
            return Call {
                name: predicate_word(&self.domain.predicate(fact.predicate()).name),
                arguments: self
                    .domain
                    .arguments(fact)
                    .map(|entity| self.identifier(entity))
                    .collect(),
            };
        };
        let entities = word.places().flatten().map(|place| fact.argument(place));
        Call {
            name: word.word.clone(),
            arguments: entities.map(|entity| self.identifier(entity)).collect(),
        }
    }
}

/// Name in a script of a predicate without a state word.
pub(super) fn predicate_word(name: &str) -> String {
    name.replace('-', "_")
}

/// Returns true if the name of a call or a parameter may contain this character.
pub(super) fn in_name(character: char) -> bool {
    character.is_alphanumeric() || matches!(character, '_' | '-')
}

/// Returns true if both notations accept the text as the name of a call or a parameter.
pub(super) fn is_name(text: &str) -> bool {
    text.chars().all(in_name) && text.starts_with(|first: char| first.is_alphabetic() || first == '_')
}

/// Returns true if both notations accept the text as an argument.
pub(super) fn is_argument(text: &str) -> bool {
    let odd = |character: char| matches!(character, ',' | '(' | ')');
    let control = |character: char| character.is_control();
    let odd = unquoted(text).any(|(_, character)| odd(character));
    !text.is_empty()
        && text.trim() == text
        && !odd
        && !text.contains(control)
        && text.matches('"').count().is_multiple_of(2)
}
