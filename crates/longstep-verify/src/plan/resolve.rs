//! Resolution of the names in a plan file to actions and entities.

use super::tree::{Lane, Rebuild};
use super::written::{Written, WrittenStep};
use super::{Assumption, Node, Step, StepClaim, StepId, TaskCohesion, Test, Violation, claims, fuzzy_names};
use longstep_model::call::Call;
use longstep_model::diagnostic::nearest;
use longstep_model::environment::fact_of;
use longstep_model::model::{ActionId, Domain, EntityId, Fact, World};

/// Maximum number of arguments whose names are not those of parameters and whose order is found by their types.
const MOST_NAMED: usize = 4;

/// A step whose implicit arguments may still be unknown.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DraftStep {
    /// The action.
    pub action: ActionId,
    /// One entity for each parameter; none for an implicit parameter without a value.
    pub arguments: Vec<Option<EntityId>>,
    /// Explanation of the step from the plan; empty if there is none.
    pub explanation: String,
}

impl From<&Step> for DraftStep {
    fn from(step: &Step) -> Self {
        Self {
            action: step.action,
            arguments: step.arguments.iter().copied().map(Some).collect(),
            explanation: step.explanation.clone(),
        }
    }
}

/// A plan resolved against a domain and a world, as far as its names are known there.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Resolved {
    /// The steps; none for a step that cannot be resolved, for which there is an issue.
    pub steps: Vec<Option<DraftStep>>,
    /// The calls as written in the plan.
    pub written: Vec<String>,
    /// The tree over the steps; in a sequential plan, one node per step.
    pub body: Vec<Node>,
    /// Facts that the steps claim to hold after them.
    pub claims: Vec<StepClaim>,
    /// Claims that cannot be resolved, as text.
    pub ignored: Vec<String>,
    /// The objects that the plan handles.
    pub objects: Vec<EntityId>,
    /// Violations that prevent simulation of the plan.
    pub issues: Vec<Violation>,
    /// Misspelled names with the names that they were matched to.
    pub readings: Vec<Assumption>,
}

impl Resolved {
    /// Returns the steps if there are no issues.
    ///
    /// # Errors
    ///
    /// The issues, at least one.
    pub fn complete(&self) -> Result<Vec<DraftStep>, &[Violation]> {
        if self.issues.is_empty() {
            Ok(self.steps.iter().flatten().cloned().collect())
        } else {
            Err(&self.issues)
        }
    }

    /// Returns true for a sequential plan: every node is a step.
    pub fn is_sequence(&self) -> bool {
        self.body.iter().all(|node| matches!(node, Node::Step(_)))
    }
}

/// Resolves every step, and reports everything that cannot be resolved: unknown actions and entities, wrong numbers and
/// types of arguments, explanations that do not match the steps in number.
///
/// In a condition, the call of a sensing action is a step. Any other call there is a state predicate; its first
/// argument is the entity whose environment entry states the fact: `expired(<milk>)`, `on_something(<cup>, <table>)`.
///
/// Names in other case and misspelled names with a single possible match are resolved to that match, which is listed in
/// [`Resolved::readings`].
///
/// ```
/// use longstep_verify::plan::{TaskCohesion, resolve};
/// use longstep_model::{domain, environment};
/// let domain = domain::shipped("virtualhome").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk_1>"], "objects": ["<mug_2>"], "object_states": {"<mug_2>": "ON(<desk_1>)"}}"#;
/// let world = environment::parse(&domain, "env.json", text).unwrap();
/// let written = TaskCohesion {
///     task_sequence: vec!["Walk(<desk_1>)".to_owned(), "grab(<mug>)".to_owned(), "Fly(<mug_2>)".to_owned()],
///     ..TaskCohesion::default()
/// };
/// let resolved = resolve(&world, &written);
/// assert_eq!((resolved.readings.len(), resolved.issues.len()), (3, 1));
/// ```
pub fn resolve(world: &World, written: &TaskCohesion) -> Resolved {
    let domain = world.domain();
    let mut resolver = Resolver {
        domain,
        world,
        calls: written.task_tree.as_ref().map_or(&[], |tree| &tree.steps),
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
    /// The steps of the tree as written, by number.
    calls: &'a [WrittenStep],
    pub(super) steps: Vec<Option<DraftStep>>,
    pub(super) written: Vec<String>,
    pub(super) objects: Vec<EntityId>,
    claims: Vec<StepClaim>,
    ignored: Vec<String>,
    pub(super) issues: Vec<Violation>,
    readings: Vec<Assumption>,
}

impl Rebuild<WrittenStep, String> for Resolver<'_> {
    type Fact = Fact;
    type Actor = EntityId;

    fn step(&mut self, step: StepId, nodes: &mut Vec<Node>) {
        nodes.push(Node::Step(self.add(&self.calls[step.index()], None)));
    }

    /// Resolves the condition; its sensing steps are numbered in reading order.
    fn condition(&mut self, condition: &Test<WrittenStep>) -> Test {
        condition.map(&mut Test::Sense, &mut |call| self.condition_call(call))
    }

    fn lane(&mut self, lane: &Lane<String>) -> Lane {
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
        // An unknown actor is an issue, and then the tree is not used.
        lane.map(actor.unwrap_or(EntityId::new(0)), |step| {
            Some(self.add(&self.calls[step.index()], actor))
        })
    }
}

impl Resolver<'_> {
    fn list(&mut self, written: &TaskCohesion) -> Vec<Node> {
        let (calls, explanations) = (written.task_sequence.len(), written.step_instructions.len());
        // With no explanations, the domain's own are used. With a wrong number, the pairing is unknown.
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
                Ok(call) => self.resolved(
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
        self.nodes(&written.body)
    }

    /// Sets the objects of a plan that lists none to the objects that its claims are about.
    fn objects_of_claims<'t>(&mut self, explanations: impl Iterator<Item = &'t str>) {
        for explanation in explanations {
            for (name, _) in claims::split_claims(explanation).claims {
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

    /// Adds a step. In a lane, the step's actor defaults to the lane's actor.
    pub(super) fn add(&mut self, written: &WrittenStep, actor: Option<EntityId>) -> StepId {
        let step = self.resolved(written, &written.call.to_string(), actor);
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
        let found = match self.domain.value(name) {
            Some(Err(error)) => {
                self.issues.push(Violation::OutOfRange { step, error });
                return None;
            }
            Some(Ok(_)) => self.world.exactly(name),
            None => self.world.find(name).or_else(|| fuzzy_names::entity(self.world, name)),
        };
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

    /// Resolves the next step; `text` is its call as written.
    fn resolved(&mut self, written: &WrittenStep, text: &str, actor: Option<EntityId>) -> Option<DraftStep> {
        let index = self.steps.len();
        let call = &written.call;
        let id = self.action(index, call)?;
        let action = self.domain.action(id);
        let before = self.issues.len();
        let given = self.given(index, id, written, text)?;
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

    /// Assigns the arguments of a call to parameters: those in order to the parameters that a call writes, those with a name to the
    /// parameter with that name.
    fn given<'s>(
        &mut self,
        index: usize,
        id: ActionId,
        written: &'s WrittenStep,
        text: &str,
    ) -> Option<Vec<(usize, &'s String)>> {
        let action = self.domain.action(id);
        let in_order = &written.call.arguments;
        let mut given: Vec<(usize, &String)> = action.explicit.iter().copied().zip(in_order).collect();
        let mut open: Vec<usize> = action.explicit.iter().copied().skip(in_order.len()).collect();
        let mut unknown = Vec::new();
        for (name, value) in &written.implicit {
            let parameter = (0..action.parameters.len())
                .filter(|at| !given.iter().any(|(parameter, _)| parameter == at))
                .find(|at| {
                    action.parameters[*at]
                        .name
                        .eq_ignore_ascii_case(&name.replace('_', "-"))
                        || action.parameters[*at].name == *name
                });
            match parameter {
                Some(parameter) => {
                    open.retain(|at| *at != parameter);
                    given.push((parameter, value));
                }
                None => unknown.push((name, value)),
            }
        }
        if in_order.len() > action.explicit.len() || unknown.len() < open.len() {
            self.issues.push(Violation::WrongArguments {
                step: index,
                call: text.to_owned(),
                expected: action.explicit.len(),
            });
            return None;
        }
        let values: Vec<&String> = unknown.iter().map(|(_, value)| *value).collect();
        if open.len() == unknown.len()
            && let Some(order) = self.only_order(id, &open, &values)
        {
            given.extend(order.into_iter().zip(values));
            return Some(given);
        }
        for (name, _) in unknown {
            let parameters = if open.is_empty() {
                action.implicit().collect()
            } else {
                open.clone()
            };
            let known = parameters.iter().map(|at| action.parameters[*at].name.as_str());
            self.issues.push(Violation::UnknownParameter {
                step: index,
                name: name.clone(),
                near: nearest(name, known).map(str::to_owned),
            });
        }
        Some(given)
    }

    /// Returns the only order of parameters in which entities fit by their types; none if several or none do.
    fn only_order(&self, action: ActionId, parameters: &[usize], names: &[&String]) -> Option<Vec<usize>> {
        let Some((name, rest)) = names.split_first() else {
            return Some(Vec::new());
        };
        if parameters.len() > MOST_NAMED {
            return None;
        }
        let only_one = parameters.len() == 1;
        let entity = self.world.find(name).or_else(|| fuzzy_names::entity(self.world, name));
        let fits = |parameter: usize| {
            let expected = self.domain.action(action).parameters[parameter].kind;
            // A single argument has a single place; its type is checked there.
            only_one || entity.is_some_and(|entity| self.domain.types.is_a(self.world.entity(entity).kind, expected))
        };
        let mut orders = (0..parameters.len())
            .filter(|place| fits(parameters[*place]))
            .filter_map(|place| {
                let mut others = parameters.to_vec();
                let parameter = others.remove(place);
                let mut order = vec![parameter];
                order.extend(self.only_order(action, &others, rest)?);
                Some(order)
            });
        let first = orders.next()?;
        orders.next().is_none().then_some(first)
    }

    /// Collects the claims in the explanation of a step.
    fn claims(&mut self, step: usize, explanation: &str) {
        for (name, word) in claims::split_claims(explanation).claims {
            let subject = self.world.find(name);
            let fact = subject.and_then(|subject| fact_of(self.world, subject, &word.to_string()));
            match fact {
                Some(fact) => self.claims.push(StepClaim { step, fact }),
                None => self.ignored.push(format!("`{name}: {word}` of step {}", step + 1)),
            }
        }
    }
}
