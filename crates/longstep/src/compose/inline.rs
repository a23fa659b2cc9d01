//! Inlining of stored plans into a composition.

use std::rc::Rc;

use super::sensing::{called, spelled_out};
use super::{Misfit, Recalled, Stored};
use crate::diagnostic::nearest;
use crate::dialogue::actors;
use crate::environment::World;
use crate::model::Action;
use crate::plan::tree::{DEEPEST, Lane, LaneItem, Node, Rebuild, Test};
use crate::plan::{StepId, Written, WrittenNode, WrittenStep};
use longstep_core::model::Domain;

/// Maximum number of steps after inlining. Without it, a script of 20 kB could call a plan of 1,000 steps 2,000 times.
const LONGEST: usize = 2_000;

/// A composition with its stored plans inlined.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Inlined {
    /// The plan before resolution. Steps of stored plans name their arguments by identifier.
    pub written: Written,
    /// For each step, the stored plan that it comes from. Steps are in reading order and include the sensing steps of
    /// conditions.
    pub origins: Vec<Option<String>>,
}

/// Replaces calls of stored plans by the steps of these plans.
///
/// A remark before the steps names their plan; in a linear plan, each explanation names it instead. A stored plan was
/// bound in its own world, so its steps have all arguments, by identifier. Resolution checks later that these entities
/// exist in the current world.
///
/// # Errors
///
/// Every misfit, without duplicates, in the order of the composition.
pub fn inline(world: &World, composition: &Written, stored: &[Stored]) -> Result<Inlined, Vec<Misfit>> {
    let domain = world.domain();
    let mut inliner = Inliner {
        domain,
        world,
        composition,
        recalled: stored
            .iter()
            .map(|plan| (plan, Recalled::of(world, plan).map(Rc::new)))
            .collect(),
        steps: Vec::new(),
        origins: Vec::new(),
        misfits: Vec::new(),
    };
    let body = inliner.nodes(&composition.body);
    let mut written = Written {
        steps: inliner.steps,
        body,
        objects: Vec::new(),
    };
    if written.is_sequence() {
        tell_in_steps(&mut written, &inliner.origins);
    }
    let mut misfits = inliner.misfits;
    if misfits.is_empty() && !written.is_sound() {
        misfits.push(Misfit::TooDeep { limit: DEEPEST });
    }
    if misfits.is_empty() {
        Ok(Inlined {
            written,
            origins: inliner.origins,
        })
    } else {
        let mut distinct: Vec<Misfit> = Vec::new();
        misfits.into_iter().for_each(|misfit| {
            if !distinct.contains(&misfit) {
                distinct.push(misfit);
            }
        });
        Err(distinct)
    }
}

/// Names the stored plan in each step's explanation. Without remarks between the steps, a linear plan stays a list of
/// steps, which is the common case.
fn tell_in_steps(written: &mut Written, origins: &[Option<String>]) {
    written.body.retain(|node| matches!(node, Node::Step(_)));
    for (step, origin) in written.steps.iter_mut().zip(origins) {
        if let Some(name) = origin {
            step.explanation = format!("{name}: {}", step.explanation);
        }
    }
}

struct Inliner<'a> {
    domain: &'a Domain,
    world: &'a World,
    composition: &'a Written,
    recalled: Vec<(&'a Stored, Result<Rc<Recalled>, Misfit>)>,
    /// The steps of the result, without the sensing steps of conditions.
    steps: Vec<WrittenStep>,
    origins: Vec<Option<String>>,
    misfits: Vec<Misfit>,
}

impl Rebuild<WrittenStep, String> for Inliner<'_> {
    type Fact = WrittenStep;
    type Actor = String;

    fn step(&mut self, step: StepId, nodes: &mut Vec<WrittenNode>) {
        let step = &self.composition.steps[step.index()];
        match self.meant(step) {
            Some((name, recalled)) => nodes.extend(self.spliced(&name, &recalled)),
            None => nodes.extend(self.own(step).map(Node::Step)),
        }
    }

    /// Converts a condition of the composition itself.
    fn condition(&mut self, condition: &Test<WrittenStep>) -> Test<WrittenStep> {
        let condition = condition.map(&mut Test::Sense, &mut |step| {
            if self.recalled.iter().any(|(plan, _)| plan.name == step.call.name) {
                let name = step.call.name.clone();
                self.misfits.push(Misfit::PlanInCondition { name });
            }
            Test::Holds(spelled_out(self.world, step))
        });
        self.note_sensing(&condition, None);
        condition
    }

    fn lane(&mut self, lane: &Lane<String>) -> Lane<String> {
        let actors: Vec<(String, String)> = actors(self.world)
            .into_iter()
            .map(|actor| {
                (
                    self.world.entity(actor).identifier.clone(),
                    called(self.world.entity(actor)),
                )
            })
            .collect();
        if actors.is_empty() {
            let domain = self.domain.name.clone();
            self.misfits.push(Misfit::NoLanes { domain });
        }
        // Lane names are free text; a name that matches an actor stands for that actor.
        let called = |(identifier, name): &&(String, String)| {
            identifier.eq_ignore_ascii_case(&lane.actor) || name.eq_ignore_ascii_case(&lane.actor)
        };
        let mut actor = actors.iter().find(called).map(|(identifier, _)| identifier.clone());
        let mut items = Vec::new();
        for item in &lane.items {
            let step = match item {
                LaneItem::Step(id) => &self.composition.steps[id.index()],
                other => {
                    items.push(other.clone());
                    continue;
                }
            };
            let Some((name, recalled)) = self.meant(step) else {
                items.extend(self.own(step).map(LaneItem::Step));
                continue;
            };
            match self.doer(&name, &recalled, actor.as_deref(), &actors) {
                Ok(doer) => actor = actor.or(doer),
                Err(misfit) => self.misfits.push(misfit),
            }
            for node in self.spliced(&name, &recalled) {
                match node {
                    Node::Step(id) => items.push(LaneItem::Step(id)),
                    Node::Remark(text) => items.push(LaneItem::Remark(text)),
                    _ => self.misfits.push(Misfit::NoSequence { name: name.clone() }),
                }
            }
        }
        Lane {
            actor: actor.unwrap_or_else(|| lane.actor.clone()),
            items,
        }
    }
}

impl Inliner<'_> {
    /// Finds the stored plan that a call names. Returns none for the call of an action; a misuse of a stored plan is
    /// recorded as a misfit.
    fn meant(&mut self, step: &WrittenStep) -> Option<(String, Rc<Recalled>)> {
        let name = &step.call.name;
        let (plan, recalled) = self.recalled.iter().find(|(plan, _)| plan.name == *name)?;
        if !step.call.arguments.is_empty() || !step.implicit.is_empty() {
            self.misfits.push(Misfit::Arguments { name: name.clone() });
        }
        match recalled {
            Ok(recalled) => Some((plan.name.clone(), Rc::clone(recalled))),
            Err(misfit) => {
                self.misfits.push(misfit.clone());
                Some((plan.name.clone(), Rc::default()))
            }
        }
    }

    /// Adds a step that belongs to the composition itself.
    fn own(&mut self, step: &WrittenStep) -> Option<StepId> {
        let calls = self.domain.actions.iter().map(|action| action.call.as_str());
        if !calls.clone().any(|call| call == step.call.name) {
            let plans = self.recalled.iter().map(|(plan, _)| plan.name.as_str());
            let near = nearest(&step.call.name, plans.chain(calls)).map(str::to_owned);
            self.misfits.push(Misfit::UnknownPlan {
                name: step.call.name.clone(),
                near,
            });
            return None;
        }
        let step = spelled_out(self.world, step);
        Some(self.push(step, None))
    }

    fn push(&mut self, step: WrittenStep, origin: Option<&str>) -> StepId {
        self.steps.push(step);
        self.origins.push(origin.map(str::to_owned));
        StepId::new(self.steps.len() - 1)
    }

    /// Returns the nodes of a stored plan with its steps renumbered for the result.
    fn spliced(&mut self, name: &str, recalled: &Recalled) -> Vec<WrittenNode> {
        let before = self.steps.len();
        if before + recalled.written.steps.len() > LONGEST {
            self.misfits.push(Misfit::TooLong { limit: LONGEST });
            return Vec::new();
        }
        self.steps.extend(recalled.written.steps.iter().cloned());
        let mut body = vec![Node::Remark(recalled.remark(name))];
        let mut splice = Splice {
            inliner: self,
            name,
            before,
        };
        body.extend(splice.nodes(&recalled.written.body));
        body
    }

    /// Resolution turns each sensing call in a condition into a step, numbered at the position of the condition.
    fn note_sensing(&mut self, condition: &Test<WrittenStep>, origin: Option<&str>) {
        for step in condition.facts() {
            let senses = |action: &Action| action.call == step.call.name && !action.senses.is_empty();
            if self.domain.actions.iter().any(senses) {
                self.origins.push(origin.map(str::to_owned));
            }
        }
    }

    /// Returns the actor of a stored plan in a lane, or none if the plan has no steps.
    fn doer(
        &self,
        name: &str,
        recalled: &Recalled,
        lane: Option<&str>,
        all: &[(String, String)],
    ) -> Result<Option<String>, Misfit> {
        let name = name.to_owned();
        match (&recalled.actors[..], recalled.joint) {
            (_, true) => {
                let actors = all.iter().map(|(_, name)| name.clone()).collect();
                Err(Misfit::NoActor { name, actors })
            }
            ([], false) => Ok(None),
            ([actor], false) => match lane {
                Some(lane) if lane != actor => Err(Misfit::WrongLane {
                    name,
                    actor: actor.clone(),
                    lane: lane.to_owned(),
                }),
                _ => Ok(Some(actor.clone())),
            },
            (several, false) => Err(Misfit::SeveralActors {
                name,
                actors: several.to_vec(),
            }),
        }
    }
}

/// Renumbers the nodes of a stored plan for the result.
struct Splice<'i, 'a> {
    inliner: &'i mut Inliner<'a>,
    /// The stored plan's name.
    name: &'i str,
    /// The number of steps before its own.
    before: usize,
}

impl Splice<'_, '_> {
    fn number(&mut self, step: StepId) -> StepId {
        self.inliner.origins.push(Some(self.name.to_owned()));
        StepId::new(self.before + step.index())
    }
}

impl Rebuild<WrittenStep, String> for Splice<'_, '_> {
    type Fact = WrittenStep;
    type Actor = String;

    fn step(&mut self, step: StepId, nodes: &mut Vec<WrittenNode>) {
        nodes.push(Node::Step(self.number(step)));
    }

    fn condition(&mut self, condition: &Test<WrittenStep>) -> Test<WrittenStep> {
        self.inliner.note_sensing(condition, Some(self.name));
        condition.clone()
    }

    fn lane(&mut self, lane: &Lane<String>) -> Lane<String> {
        lane.map(lane.actor.clone(), |step| Some(self.number(step)))
    }
}
