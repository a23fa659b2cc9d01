//! From the words of a plan file to actions and entities.

use super::tree::Lane;
use super::written::{Written, WrittenNode, WrittenStep};
use super::{Assumption, StepClaim, Violation};
use super::{LaneItem, Node, StepId, TaskCohesion, claims, fuzzy_names};
use crate::call::Call;
use crate::diagnostic::nearest;
use crate::environment::fact_of;
use crate::model::{ActionId, Domain, EntityId, World};

/// A step whose implicit arguments are not known yet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DraftStep {
    /// The action.
    pub action: ActionId,
    /// One entity for each parameter, none where the call syntax hides it.
    pub arguments: Vec<Option<EntityId>>,
    /// What the plan says that the step does; empty if it does not say.
    pub explanation: String,
}

/// A draft in terms of a domain and a world, as far as its words mean something there.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Resolved {
    /// The steps; none where the words of one mean nothing, which an issue tells.
    pub steps: Vec<Option<DraftStep>>,
    /// The calls as they were written.
    pub written: Vec<String>,
    /// The tree over the steps; a plain list of them if the plan is one.
    pub body: Vec<Node>,
    /// What the steps say that holds after them.
    pub claims: Vec<StepClaim>,
    /// What of that means nothing here, as sentences.
    pub ignored: Vec<String>,
    /// What the plan says is handled.
    pub objects: Vec<EntityId>,
    /// Everything that stands in the way of simulating it.
    pub issues: Vec<Violation>,
    /// Names that were nearly right, and what they were taken for.
    pub readings: Vec<Assumption>,
}

impl Resolved {
    /// The steps, if nothing stands in the way.
    ///
    /// # Errors
    ///
    /// The issues, of which there is at least one.
    pub fn complete(&self) -> Result<Vec<DraftStep>, &[Violation]> {
        if self.issues.is_empty() {
            Ok(self.steps.iter().flatten().cloned().collect())
        } else {
            Err(&self.issues)
        }
    }

    /// Whether it is a plain list of steps.
    pub fn is_sequence(&self) -> bool {
        self.body.iter().all(|node| matches!(node, Node::Step(_)))
    }
}

/// Gives every step its meaning, and tells everything that has none: unknown actions and entities, wrong numbers and
/// types of arguments, explanations that do not go with the steps.
///
/// In a condition, the call of a sensing action is a step that is done there; every other one asks for a state, with
/// the entity first in whose entry an environment says it: `expired(<milk>)`, `on_something(<cup>, <table>)`.
///
/// Names in other case, and names that are nearly right and can mean only one thing, are taken for what they must
/// mean and listed under [`Resolved::readings`].
///
/// ```
/// use longstep_core::plan::{TaskCohesion, resolve};
/// use longstep_core::{domain, json, environment};
/// let domain = domain::shipped("virtualhome").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk_1>"], "objects": ["<mug_2>"], "object_states": {"<mug_2>": "ON(<desk_1>)"}}"#;
/// let environment = environment::Environment::from_json(text).unwrap();
/// let world = environment::read(&domain, &environment, "env.json", text, &json::Path::default()).unwrap();
/// let written = TaskCohesion {
///     task_sequence: vec!["Walk(<desk_1>)".to_owned(), "grab(<mug>)".to_owned(), "Fly(<mug_2>)".to_owned()],
///     ..TaskCohesion::default()
/// };
/// let resolved = resolve(&domain, &world, &written);
/// assert_eq!((resolved.readings.len(), resolved.issues.len()), (3, 1));
/// ```
pub fn resolve(domain: &Domain, world: &World, written: &TaskCohesion) -> Resolved {
    let mut resolver = Resolver {
        domain,
        world,
        steps: Vec::new(),
        written: Vec::new(),
        objects: Vec::new(),
        claims: Vec::new(),
        ignored: Vec::new(),
        issues: Vec::new(),
        readings: Vec::new(),
    };
    let objects = written
        .objects()
        .filter_map(|name| resolver.entity(None, name))
        .collect();
    resolver.objects = objects;
    let body = match &written.task_tree {
        Some(tree) => resolver.tree(tree),
        None => resolver.list(written),
    };
    Resolved {
        steps: resolver.steps,
        written: resolver.written,
        body,
        claims: resolver.claims,
        ignored: resolver.ignored,
        objects: resolver.objects,
        issues: resolver.issues,
        readings: resolver.readings,
    }
}

pub(super) struct Resolver<'a> {
    pub(super) domain: &'a Domain,
    pub(super) world: &'a World,
    pub(super) steps: Vec<Option<DraftStep>>,
    pub(super) written: Vec<String>,
    pub(super) objects: Vec<EntityId>,
    claims: Vec<StepClaim>,
    ignored: Vec<String>,
    pub(super) issues: Vec<Violation>,
    readings: Vec<Assumption>,
}

impl Resolver<'_> {
    fn list(&mut self, written: &TaskCohesion) -> Vec<Node> {
        let (calls, explanations) = (written.task_sequence.len(), written.step_instructions.len());
        // Without any, steps explain themselves; with too few or too many, nobody knows which is whose.
        let paired = explanations == calls;
        if explanations > 0 && !paired {
            self.issues.push(Violation::LengthMismatch { calls, explanations });
        }
        let explanation = |index: usize| written.step_instructions.get(index).filter(|_| paired);
        if self.objects.is_empty() && paired {
            self.objects_of_claims(written.step_instructions.iter().map(String::as_str));
        }
        let mut body = Vec::with_capacity(calls);
        for (index, text) in written.task_sequence.iter().enumerate() {
            let explanation = explanation(index).cloned().unwrap_or_default();
            let step = match Call::parse(text) {
                Ok(call) => self.step(
                    &WrittenStep {
                        call,
                        implicit: Vec::new(),
                        explanation,
                    },
                    text,
                    None,
                ),
                Err(_) => {
                    self.unknown_action(index, text);
                    None
                }
            };
            self.steps.push(step);
            self.written.push(text.clone());
            body.push(Node::Step(StepId::new(index)));
        }
        body
    }

    fn tree(&mut self, written: &Written) -> Vec<Node> {
        if self.objects.is_empty() {
            self.objects_of_claims(written.steps.iter().map(|step| step.explanation.as_str()));
        }
        self.nodes(&written.body, written)
    }

    /// A plan that does not say what it handles handles what it tells about.
    fn objects_of_claims<'t>(&mut self, explanations: impl Iterator<Item = &'t str>) {
        for explanation in explanations {
            for (name, _) in claims::told(explanation).claims {
                let handled = self
                    .world
                    .find(name)
                    .filter(|entity| self.world.is_of_kind(*entity, self.domain.environment.object));
                if let Some(entity) = handled.filter(|entity| !self.objects.contains(entity)) {
                    self.objects.push(entity);
                }
            }
        }
    }

    fn nodes(&mut self, nodes: &[WrittenNode], written: &Written) -> Vec<Node> {
        nodes.iter().map(|node| self.node(node, written)).collect()
    }

    fn node(&mut self, node: &WrittenNode, written: &Written) -> Node {
        match node {
            Node::Step(id) => Node::Step(self.add(&written.steps[id.index()], None)),
            // The parts are read in the order in which they are written, which is the order of their numbers.
            Node::If {
                condition,
                then,
                otherwise,
            } => Node::If {
                condition: self.test(condition),
                then: self.nodes(then, written),
                otherwise: self.nodes(otherwise, written),
            },
            Node::While { condition, body } => Node::While {
                condition: self.test(condition),
                body: self.nodes(body, written),
            },
            Node::Repeat { times, body } => Node::Repeat {
                times: *times,
                body: self.nodes(body, written),
            },
            Node::Parallel { lanes } => Node::Parallel {
                lanes: lanes.iter().map(|lane| self.lane(lane, written)).collect(),
            },
            Node::Remark(words) => Node::Remark(words.clone()),
        }
    }

    fn lane(&mut self, lane: &Lane<String>, written: &Written) -> Lane {
        let actor = self
            .world
            .find(&lane.actor)
            .or_else(|| fuzzy_names::entity(self.world, &lane.actor));
        if actor.is_none() {
            let known = self.world.entities().map(|(_, entity)| entity.identifier.as_str());
            self.issues.push(Violation::UnknownActor {
                name: lane.actor.clone(),
                near: nearest(&lane.actor, known).map(str::to_owned),
            });
        }
        let items = lane.items.iter().map(|item| match item {
            LaneItem::Step(id) => LaneItem::Step(self.add(&written.steps[id.index()], actor)),
            other => other.clone(),
        });
        let items = items.collect();
        Lane {
            // Without an actor there is an issue, and nobody looks at the tree.
            actor: actor.unwrap_or(EntityId::new(0)),
            items,
        }
    }

    /// Adds a step; what its lane's actor does hides who does it.
    pub(super) fn add(&mut self, written: &WrittenStep, actor: Option<EntityId>) -> StepId {
        let step = self.step(written, &written.call.to_string(), actor);
        self.steps.push(step);
        self.written.push(written.call.to_string());
        StepId::new(self.steps.len() - 1)
    }

    fn read_as(&mut self, step: Option<usize>, written: &str, meant: &str) {
        if written != meant {
            self.readings.push(Assumption::Reading {
                step,
                written: written.to_owned(),
                meant: meant.to_owned(),
            });
        }
    }

    pub(super) fn entity(&mut self, step: Option<usize>, name: &str) -> Option<EntityId> {
        let found = self.world.find(name).or_else(|| fuzzy_names::entity(self.world, name));
        match found {
            Some(entity) => self.read_as(step, name, &self.world.entity(entity).identifier),
            None => {
                let known = self.world.entities().map(|(_, entity)| entity.identifier.as_str());
                self.issues.push(Violation::UnknownEntity {
                    step,
                    name: name.to_owned(),
                    near: nearest(name, known).map(str::to_owned),
                });
            }
        }
        found
    }

    fn action(&mut self, step: usize, call: &Call) -> Option<ActionId> {
        let mut actions = self.domain.action_ids();
        let exact = actions.find(|(_, action)| action.call == call.name).map(|(id, _)| id);
        let found = exact.or_else(|| fuzzy_names::action(self.domain, &call.name, call.arguments.len()));
        match found {
            Some(id) => self.read_as(Some(step), &call.name, &self.domain.action(id).call),
            None => self.unknown_action(step, &call.name),
        }
        found
    }

    fn unknown_action(&mut self, step: usize, name: &str) {
        let known = self.domain.actions.iter().map(|action| action.call.as_str());
        self.issues.push(Violation::UnknownAction {
            step,
            name: name.to_owned(),
            near: nearest(name, known).map(str::to_owned),
        });
    }

    /// The next step; `text` is its call as it was written.
    fn step(&mut self, written: &WrittenStep, text: &str, actor: Option<EntityId>) -> Option<DraftStep> {
        let index = self.steps.len();
        let call = &written.call;
        let id = self.action(index, call)?;
        let action = self.domain.action(id);
        if call.arguments.len() != action.explicit.len() {
            self.issues.push(Violation::WrongArguments {
                step: index,
                call: text.to_owned(),
                expected: action.explicit.len(),
            });
            return None;
        }
        let before = self.issues.len();
        let mut given: Vec<(usize, &String)> = action.explicit.iter().copied().zip(&call.arguments).collect();
        for (name, value) in &written.implicit {
            match action.implicit().find(|at| action.parameters[*at].name == *name) {
                Some(parameter) => given.push((parameter, value)),
                None => {
                    let hidden = action.implicit().map(|at| action.parameters[at].name.as_str());
                    self.issues.push(Violation::UnknownParameter {
                        step: index,
                        name: name.clone(),
                        near: nearest(name, hidden).map(str::to_owned),
                    });
                }
            }
        }
        let mut arguments = vec![None; action.parameters.len()];
        for (parameter, name) in given {
            let Some(entity) = self.entity(Some(index), name) else {
                continue;
            };
            let expected = action.parameters[parameter].kind;
            if !self.domain.types.is_a(self.world.entity(entity).kind, expected) {
                self.issues.push(Violation::WrongType {
                    step: index,
                    name: name.clone(),
                    expected: self.domain.types.name(expected).to_owned(),
                });
            }
            arguments[parameter] = Some(entity);
        }
        if let Some(parameter) = action.actor {
            arguments[parameter] = arguments[parameter].or(actor);
        }
        self.claims(index, &written.explanation);
        (self.issues.len() == before).then(|| DraftStep {
            action: id,
            arguments,
            explanation: written.explanation.clone(),
        })
    }

    /// What a step says that holds after it.
    fn claims(&mut self, step: usize, explanation: &str) {
        for (name, word) in claims::told(explanation).claims {
            let subject = self.world.find(name);
            let fact = subject.and_then(|subject| fact_of(self.domain, self.world, subject, &word.to_string()));
            match fact {
                Some(fact) => self.claims.push(StepClaim { step, fact }),
                None => self.ignored.push(format!("`{name}: {word}` of step {}", step + 1)),
            }
        }
    }
}
