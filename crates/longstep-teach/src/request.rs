//! The steps of a plan that are to be shown.

use longstep_model::call::Call;
use longstep_model::environment::World;
use longstep_model::model::{EntityId, SkillFit, SkillParameter, SkillSource};
use longstep_verify::plan::{Plan, Step, StepId};

use crate::demonstration::Hand;

/// A step of a plan, with the skill parameters that a demonstration of it gives.
#[derive(Debug, Clone, PartialEq)]
pub struct Request {
    /// The step.
    pub step: StepId,
    /// The action, by its name in `domain.pddl`.
    pub action: String,
    /// The identifiers of its arguments.
    pub arguments: Vec<String>,
    /// The action with its arguments.
    pub call: String,
    /// The step as a sentence for a person.
    pub sentence: String,
    /// The parameters that a person teaches. A step without any needs no demonstration.
    pub parameters: Vec<SkillParameter>,
    /// The hand that the plan uses; none if it does not say.
    pub hand: Option<Hand>,
    /// The identifier of the manipulated object.
    pub object: Option<String>,
}

impl Request {
    /// Returns true if the hand closes in the step: its action is taught by an approach or a kind of grasp.
    pub fn closes(&self) -> bool {
        self.has(SkillFit::Approach) || self.has(SkillFit::Grasp)
    }

    /// Returns true if the hand opens in the step: its action is taught by a retreat.
    pub fn opens(&self) -> bool {
        self.has(SkillFit::Retreat)
    }

    /// Returns true if a demonstration of the step gives the value of a parameter with this fit.
    pub fn has(&self, fit: SkillFit) -> bool {
        self.parameters.iter().any(|own| own.fit == Some(fit))
    }

    /// The number of the step, from 1.
    pub fn number(&self) -> usize {
        self.step.index() + 1
    }
}

/// Returns the steps of a plan in order, with the parameters that a person teaches.
///
/// ```
/// use longstep_core::{domain, environment, goal, search};
/// use longstep_teach::requests;
/// let domain = domain::shipped("household-taught").unwrap().unwrap();
/// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
/// let world = environment::parse(&domain, "env.json", text).unwrap();
/// let goal = goal::parse(&world, "put(cup, shelf)").unwrap();
/// let search::Outcome::Solved { plan, .. } = search::solve(&world, &goal.purpose(&world), &Default::default()) else {
///     panic!("no plan");
/// };
/// let requests = requests(&world, &plan);
/// assert_eq!(requests[1].sentence, "grasp the cup");
/// assert!(requests[1].closes() && requests[5].opens());
/// ```
pub fn requests(world: &World, plan: &Plan) -> Vec<Request> {
    let domain = world.domain();
    let of = |(index, step): (usize, &Step)| {
        let action = domain.action(step.action);
        let identifier = |entity: &EntityId| world.entity(*entity).identifier.clone();
        let arguments: Vec<String> = step.arguments.iter().map(identifier).collect();
        let shown = |own: &&SkillParameter| own.from == SkillSource::Demonstration;
        // Robots with two arms name them: `<left_hand>`.
        let actor = step
            .actor(domain)
            .map(|actor| world.entity(actor).identifier.to_lowercase());
        let is_actor = |hand: &Hand| actor.as_ref().is_some_and(|actor| actor.contains(hand.name()));
        Request {
            step: StepId::new(index),
            action: action.name.clone(),
            arguments: arguments.clone(),
            call: Call {
                name: action.call.clone(),
                arguments: arguments.clone(),
            }
            .to_string(),
            sentence: Step::explained(world, step.action, step.arguments.clone()).explanation,
            parameters: action.skills.iter().filter(shown).cloned().collect(),
            hand: [Hand::Left, Hand::Right].into_iter().find(is_actor),
            object: step.object(domain).as_ref().map(identifier),
        }
    };
    plan.steps().iter().enumerate().map(of).collect()
}
