//! From the words of a plan file to actions and entities.

use super::{TaskCohesion, near};
use crate::call::Call;
use crate::diagnostic::nearest;
use crate::domain::{ActionId, Domain};
use crate::verify::{Assumption, Violation};
use crate::world::{EntityId, World};

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
}

/// Gives every step its meaning, and tells everything that has none: unknown actions and entities, wrong numbers and
/// types of arguments, explanations that do not go with the steps.
///
/// Names in other case, and names that are nearly right and can mean only one thing, are taken for what they must
/// mean and listed under [`Resolved::readings`].
///
/// ```
/// use longstep::plan::{TaskCohesion, resolve};
/// use longstep::{domain, json, world};
/// let domain = domain::shipped("virtualhome").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk_1>"], "objects": ["<mug_2>"], "object_states": {"<mug_2>": "ON(<desk_1>)"}}"#;
/// let environment = world::Environment::from_json(text).unwrap();
/// let world = world::read(&domain, &environment, "env.json", text, &json::Path::default()).unwrap();
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
        issues: Vec::new(),
        readings: Vec::new(),
    };
    let objects = written
        .objects()
        .filter_map(|name| resolver.entity(None, name))
        .collect();
    let (calls, explanations) = (written.task_sequence.len(), written.step_instructions.len());
    // Without any, steps explain themselves; with too few or too many, nobody knows which is whose.
    let paired = explanations == calls;
    if explanations > 0 && !paired {
        resolver.issues.push(Violation::LengthMismatch { calls, explanations });
    }
    let mut steps = Vec::with_capacity(calls);
    for (index, text) in written.task_sequence.iter().enumerate() {
        let explanation = written.step_instructions.get(index).filter(|_| paired);
        steps.push(resolver.step(index, text, explanation.cloned().unwrap_or_default()));
    }
    Resolved {
        steps,
        written: written.task_sequence.clone(),
        objects,
        issues: resolver.issues,
        readings: resolver.readings,
    }
}

struct Resolver<'a> {
    domain: &'a Domain,
    world: &'a World,
    issues: Vec<Violation>,
    readings: Vec<Assumption>,
}

impl Resolver<'_> {
    fn read_as(&mut self, step: Option<usize>, written: &str, meant: &str) {
        if written != meant {
            self.readings.push(Assumption::Reading {
                step,
                written: written.to_owned(),
                meant: meant.to_owned(),
            });
        }
    }

    fn entity(&mut self, step: Option<usize>, name: &str) -> Option<EntityId> {
        let found = self.world.find(name).or_else(|| near::entity(self.world, name));
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
        let found = exact.or_else(|| near::action(self.domain, &call.name, call.arguments.len()));
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

    fn step(&mut self, index: usize, text: &str, explanation: String) -> Option<DraftStep> {
        let Ok(call) = Call::parse(text) else {
            self.unknown_action(index, text);
            return None;
        };
        let id = self.action(index, &call)?;
        let action = self.domain.action(id);
        if call.arguments.len() != action.explicit.len() {
            self.issues.push(Violation::WrongArguments {
                step: index,
                call: text.to_owned(),
                expected: action.explicit.len(),
            });
            return None;
        }
        let mut arguments = vec![None; action.parameters.len()];
        let before = self.issues.len();
        for (name, parameter) in call.arguments.iter().zip(&action.explicit) {
            let Some(entity) = self.entity(Some(index), name) else {
                continue;
            };
            let expected = action.parameters[*parameter].kind;
            if !self.domain.types.is_a(self.world.entity(entity).kind, expected) {
                self.issues.push(Violation::WrongType {
                    step: index,
                    name: name.clone(),
                    expected: self.domain.types.name(expected).to_owned(),
                });
            }
            arguments[*parameter] = Some(entity);
        }
        (self.issues.len() == before).then_some(DraftStep {
            action: id,
            arguments,
            explanation,
        })
    }
}
