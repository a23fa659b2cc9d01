//! Writer of behavior trees.

use std::collections::BTreeSet;

use super::element::{Element, is_unwritable};
use super::name::{LeafNames, outcomes, port};
use super::{ACTOR, CALL, FORMAT, GUARD, MAIN, OUTCOME, SYNC};
use crate::plan::{Lane, LaneItem, Node, Plan, StepId, Test};
use longstep_model::model::{ActionId, EntityId, Fact, PredicateId, World, ground};

/// The checks before each step of a behavior tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Guards {
    /// None: the plan was verified, and whoever ticks the tree watches the world.
    #[default]
    None,
    /// The preconditions of the step, so that the tree fails before a step that the world no longer allows.
    Preconditions,
}

/// A plan that no behavior tree can have.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// A name begins with `{` and ends with `}`, as an entry of the blackboard does.
    #[error("`{0}` would be read as an entry of the blackboard")]
    Argument(String),
    /// A name or a text has a control character that XML cannot have.
    #[error("XML has no character {character:?}, which is in {name:?}")]
    Character {
        /// The name or the text.
        name: String,
        /// The character.
        character: char,
    },
    /// The preconditions of a step are too many checks.
    #[error("the preconditions of step {step}, `{call}`, are more than {limit} checks")]
    Guard {
        /// The number of the step, from 1.
        step: usize,
        /// Its call.
        call: String,
        /// The maximum.
        limit: usize,
    },
}

impl WriteError {
    /// The next step for the user.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::Argument(_) => "give the entity another identifier in the environment",
            Self::Character { .. } => "write the name or the text without it",
            Self::Guard { .. } => "leave out the guards",
        }
    }
}

/// Writes a plan of a world as a behavior tree.
///
/// # Errors
///
/// [`WriteError`] for a plan that no behavior tree can have.
pub fn write(world: &World, plan: &Plan, guards: Guards) -> Result<String, WriteError> {
    let mut writer = Writer {
        world,
        plan,
        names: LeafNames::of(world.domain()),
        guards,
        flags: 0,
        actions: BTreeSet::new(),
        predicates: BTreeSet::new(),
        numbers: false,
    };
    let nodes = writer.nodes(plan.body())?;
    let tree = Element::new("BehaviorTree")
        .with("ID", MAIN)
        .holding([Element::sequence(nodes)]);
    let root = Element::new("root")
        .with("BTCPP_format", FORMAT)
        .with("main_tree_to_execute", MAIN)
        .holding([tree, writer.model()]);
    let mut xml = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    root.write(0, &mut xml);
    Ok(xml)
}

pub(super) struct Writer<'a> {
    pub(super) world: &'a World,
    pub(super) plan: &'a Plan,
    pub(super) names: LeafNames,
    pub(super) guards: Guards,
    /// The number of flags on the blackboard so far.
    flags: usize,
    /// The leaves of the tree.
    actions: BTreeSet<ActionId>,
    predicates: BTreeSet<PredicateId>,
    /// True if a guard checks numbers.
    pub(super) numbers: bool,
}

/// The leaf for a requirement on numbers.
pub(super) const NUMBERS: &str = "numbers_allow";

/// The port of a requirement on numbers.
pub(super) const TEST: &str = "test";

impl Writer<'_> {
    /// Returns a new entry of the blackboard.
    pub(super) fn flag(&mut self, what: &str) -> String {
        self.flags += 1;
        format!("{what}_{}", self.flags)
    }

    fn nodes(&mut self, nodes: &[Node]) -> Result<Vec<Element>, WriteError> {
        let mut elements = Vec::new();
        for node in nodes {
            self.node(node, &mut elements)?;
        }
        Ok(elements)
    }

    fn node(&mut self, node: &Node, elements: &mut Vec<Element>) -> Result<(), WriteError> {
        match node {
            Node::Step(step) => elements.push(self.step(*step)?),
            Node::Remark(text) => elements.push(Element::Comment(text.clone())),
            Node::If {
                condition,
                then,
                otherwise,
            } => {
                let test = self.condition(condition, elements)?;
                let (then, otherwise) = (self.nodes(then)?, self.nodes(otherwise)?);
                elements.push(Element::branch(
                    test,
                    Element::sequence(then),
                    Element::sequence(otherwise),
                ));
            }
            Node::While { condition, body } => self.repeat_while(condition, body, elements)?,
            Node::Repeat { times, body } => {
                let body = Element::sequence(self.nodes(body)?);
                elements.push(
                    Element::new("Repeat")
                        .with("num_cycles", times.to_string())
                        .holding([body]),
                );
            }
            Node::Parallel { lanes } => self.parallel(lanes, elements)?,
        }
        Ok(())
    }

    /// A loop ends when its child fails. A flag tells a condition that no longer holds from a step that failed.
    fn repeat_while(&mut self, condition: &Test, body: &[Node], elements: &mut Vec<Element>) -> Result<(), WriteError> {
        let ok = self.flag("ok");
        let guarded = |nodes: Vec<Element>| {
            let failed = Element::new("Sequence").with("_onFailure", format!("{ok}:=false"));
            failed.holding(Element::never_empty(nodes))
        };
        let mut sensing = Vec::new();
        let test = self.condition(condition, &mut sensing)?;
        let mut round = Vec::new();
        if !sensing.is_empty() {
            round.push(guarded(sensing));
        }
        round.push(test);
        round.push(guarded(self.nodes(body)?));
        let rounds = Element::new("KeepRunningUntilFailure").holding([Element::new("Sequence").holding(round)]);
        elements.push(Element::script(format!("{ok}:=true")));
        elements.push(Element::new("ForceSuccess").holding([rounds]));
        elements.push(Element::test(ok));
        Ok(())
    }

    fn parallel(&mut self, lanes: &[Lane], elements: &mut Vec<Element>) -> Result<(), WriteError> {
        let syncs = |lane: &Lane| -> Vec<String> {
            let name = |item: &LaneItem| match item {
                LaneItem::Sync(name) => Some(name.clone()),
                _ => None,
            };
            lane.items.iter().filter_map(name).collect()
        };
        let shared = lanes.first().map(syncs).unwrap_or_default();
        if !lanes.iter().all(|lane| syncs(lane) == shared) {
            return self.parallel_with_flags(lanes, elements);
        }
        // All lanes wait for each other at the same points: one node after another.
        for part in 0..=shared.len() {
            let mut parallel = parallel();
            if let Some(before) = part.checked_sub(1) {
                parallel = parallel.with(SYNC, shared[before].clone());
            }
            let mut children = Vec::new();
            for lane in lanes {
                let mut parts = lane.items.split(|item| matches!(item, LaneItem::Sync(_)));
                let items = parts.nth(part).unwrap_or_default();
                let mut inside = Vec::new();
                for item in items {
                    self.lane_item(item, &mut inside)?;
                }
                children.push(self.lane(lane.actor, inside));
            }
            elements.push(parallel.holding(children));
        }
        Ok(())
    }

    /// Lanes of which some wait for some others: each tells on the blackboard that it has come to a point.
    fn parallel_with_flags(&mut self, lanes: &[Lane], elements: &mut Vec<Element>) -> Result<(), WriteError> {
        let point = self.flag("sync");
        let mut names: Vec<&str> = Vec::new();
        for item in lanes.iter().flat_map(|lane| &lane.items) {
            if let LaneItem::Sync(name) = item
                && !names.contains(&name.as_str())
            {
                names.push(name);
            }
        }
        let passes = |lane: &Lane, name: &str| {
            lane.items
                .iter()
                .any(|item| matches!(item, LaneItem::Sync(other) if other == name))
        };
        let flags = |name: &str| -> Vec<(usize, String)> {
            let place = names.iter().position(|other| *other == name).unwrap_or_default();
            let waiting = lanes.iter().enumerate().filter(|(_, lane)| passes(lane, name));
            waiting
                .map(|(lane, _)| (lane, format!("{point}_{place}_{lane}")))
                .collect()
        };
        let all = names
            .iter()
            .flat_map(|name| flags(name))
            .map(|(_, flag)| flag + ":=false");
        elements.push(Element::script(all.collect::<Vec<_>>().join("; ")).with(SYNC, ""));
        let mut children = Vec::new();
        for (number, lane) in lanes.iter().enumerate() {
            let mut inside = Vec::new();
            for item in &lane.items {
                let LaneItem::Sync(name) = item else {
                    self.lane_item(item, &mut inside)?;
                    continue;
                };
                let flags = flags(name);
                let own = flags
                    .iter()
                    .find(|(lane, _)| *lane == number)
                    .map(|(_, flag)| flag.clone());
                let all: Vec<String> = flags.into_iter().map(|(_, flag)| flag).collect();
                let wait = Element::new("RetryUntilSuccessful").with("num_attempts", "-1");
                inside.push(Element::new("Sequence").with(SYNC, name.clone()).holding([
                    Element::script(format!("{}:=true", own.unwrap_or_default())),
                    wait.holding([Element::test(all.join(" && "))]),
                ]));
            }
            children.push(self.lane(lane.actor, inside));
        }
        elements.push(parallel().holding(children));
        Ok(())
    }

    fn lane(&self, actor: EntityId, items: Vec<Element>) -> Element {
        let lane = Element::new("Sequence").with(ACTOR, self.world.entity(actor).identifier.clone());
        lane.holding(Element::never_empty(items))
    }

    fn lane_item(&mut self, item: &LaneItem, elements: &mut Vec<Element>) -> Result<(), WriteError> {
        match item {
            LaneItem::Step(step) => elements.push(self.step(*step)?),
            LaneItem::Remark(text) => elements.push(Element::Comment(text.clone())),
            LaneItem::Sync(_) => {}
        }
        Ok(())
    }

    /// The leaf of a step, behind its preconditions if there are guards.
    pub(super) fn step(&mut self, id: StepId) -> Result<Element, WriteError> {
        let leaf = self.leaf(id)?;
        if self.guards == Guards::None {
            return Ok(leaf);
        }
        let checks = self.guard(id)?;
        if checks.is_empty() {
            return Ok(leaf);
        }
        Ok(Element::new("Sequence")
            .with(GUARD, "preconditions")
            .holding(checks)
            .holding([leaf]))
    }

    fn leaf(&mut self, id: StepId) -> Result<Element, WriteError> {
        let step = self.plan.step(id);
        let action = self.world.domain().action(step.action);
        self.actions.insert(step.action);
        let name = self.names.action(step.action).to_owned();
        let is_other = name != action.call;
        let mut leaf = Element::new(name);
        if !step.explanation.is_empty() {
            leaf = leaf.with("name", step.explanation.clone());
        }
        if is_other {
            leaf = leaf.with(CALL, action.call.clone());
        }
        for (parameter, argument) in action.parameters.iter().zip(&step.arguments) {
            leaf = leaf.with(port(&parameter.name), self.argument(*argument)?);
        }
        if !action.senses.is_empty() {
            leaf = leaf.with(OUTCOME, format!("{{{}}}", outcome_entry(id)));
        }
        Ok(leaf)
    }

    /// The leaf that checks a fact.
    pub(super) fn fact(&mut self, fact: Fact) -> Result<Element, WriteError> {
        let domain = self.world.domain();
        self.predicates.insert(fact.predicate());
        let mut leaf = Element::new(self.names.predicate(fact.predicate()).to_owned());
        let parameters = &domain.predicate(fact.predicate()).parameters;
        for (parameter, entity) in parameters.iter().zip(domain.arguments(fact)) {
            leaf = leaf.with(port(&parameter.name), self.argument(entity)?);
        }
        Ok(leaf)
    }

    fn argument(&self, entity: EntityId) -> Result<String, WriteError> {
        let identifier = &self.world.entity(entity).identifier;
        if identifier.starts_with('{') && identifier.ends_with('}') {
            return Err(WriteError::Argument(identifier.clone()));
        }
        if let Some(character) = identifier.chars().find(|own| is_unwritable(*own)) {
            let name = identifier.clone();
            return Err(WriteError::Character { name, character });
        }
        Ok(identifier.clone())
    }

    /// Returns the word for the first outcome of a sensing step.
    pub(super) fn first_outcome(&self, id: StepId) -> String {
        let step = self.plan.step(id);
        let action = self.world.domain().action(step.action);
        let facts: Vec<Fact> = action.senses.iter().map(|atom| ground(atom, &step.arguments)).collect();
        outcomes(self.world, action, &facts)
            .into_iter()
            .next()
            .unwrap_or_default()
    }

    /// The leaves with their ports.
    fn model(&self) -> Element {
        let domain = self.world.domain();
        let input = |name: &str, text: String| port_model("input_port", name, text);
        let actions = self.actions.iter().map(|id| {
            let action = domain.action(*id);
            let kind = |kind| domain.types.name(kind).to_owned();
            let ports = action
                .parameters
                .iter()
                .map(|one| input(&port(&one.name), kind(one.kind)));
            let outcome = (!action.senses.is_empty()).then(|| {
                let found = self
                    .plan
                    .steps()
                    .iter()
                    .enumerate()
                    .find(|(_, step)| step.action == *id);
                let words = found.map(|(_, step)| {
                    let facts: Vec<Fact> = action.senses.iter().map(|atom| ground(atom, &step.arguments)).collect();
                    outcomes(self.world, action, &facts).join(", ")
                });
                port_model("output_port", OUTCOME, format!("one of: {}", words.unwrap_or_default()))
            });
            Element::new("Action")
                .with("ID", self.names.action(*id).to_owned())
                .holding(ports)
                .holding(outcome)
        });
        let conditions = self.predicates.iter().map(|id| {
            let predicate = domain.predicate(*id);
            let ports = predicate.parameters.iter();
            let ports = ports.map(|one| input(&port(&one.name), domain.types.name(one.kind).to_owned()));
            Element::new("Condition")
                .with("ID", self.names.predicate(*id).to_owned())
                .holding(ports)
        });
        let numbers = self.numbers.then(|| {
            let test = input(TEST, "a requirement on numbers".to_owned());
            Element::new("Condition").with("ID", NUMBERS).holding([test])
        });
        Element::new("TreeNodesModel")
            .holding(actions)
            .holding(conditions)
            .holding(numbers)
    }
}

fn parallel() -> Element {
    Element::new("Parallel")
        .with("success_count", "-1")
        .with("failure_count", "1")
}

fn port_model(kind: &'static str, name: &str, text: String) -> Element {
    Element::new(kind)
        .with("name", name.to_owned())
        .with("type", "std::string")
        .holding([Element::Text(text)])
}

/// The entry of the blackboard with the outcome of a sensing step.
pub(super) fn outcome_entry(step: StepId) -> String {
    format!("{OUTCOME}_{}", step.index() + 1)
}
