//! Random plans of known calls: trees with hidden and given arguments, conditions, loops, lanes and claims.

use libfuzzer_sys::arbitrary::{Result, Unstructured};
use longstep::domain::{Action, Parameter};
use longstep_core::call::Call;
use longstep_core::environment::{Environment, Words};
use longstep_core::plan::{
    Lane, LaneItem, Node, PlanFile, StepId, TaskCohesion, Test, Written, WrittenNode, WrittenStep,
};

use crate::scenes::Scene;

/// Nodes of a plan at most, and levels below one another.
const NODES: usize = 24;
const DEEPEST: usize = 4;

/// Draws a plan from bytes.
pub fn plan(scene: &Scene, bytes: &mut Unstructured<'_>) -> Result<PlanFile> {
    let mut drawer = Drawer {
        scene,
        bytes,
        steps: Vec::new(),
        nodes: NODES,
    };
    let body = drawer.block(DEEPEST)?;
    let objects = match drawer.bytes.ratio(1, 3)? {
        true => vec![drawer.entity()?],
        false => Vec::new(),
    };
    let written = Written {
        steps: drawer.steps,
        body,
        objects,
    };
    let mut file = PlanFile::from(TaskCohesion::from_written(written));
    if bytes.ratio(1, 3)? {
        file.environment_after = Some(claimed(scene, bytes)?);
    }
    Ok(file)
}

/// The scene's environment with one object elsewhere.
fn claimed(scene: &Scene, bytes: &mut Unstructured<'_>) -> Result<Environment> {
    let mut after = scene.world.environment().clone();
    let object = bytes.choose(&after.objects)?.clone();
    let place = bytes.choose(&after.assets)?.clone();
    let word = *bytes.choose(&["on_something", "inside_something"])?;
    after
        .object_states
        .insert(object, Words::Many(vec![format!("{word}({place})")]));
    Ok(after)
}

struct Drawer<'a, 'b, 'c> {
    scene: &'a Scene,
    bytes: &'b mut Unstructured<'c>,
    steps: Vec<WrittenStep>,
    nodes: usize,
}

impl Drawer<'_, '_, '_> {
    fn entity(&mut self) -> Result<String> {
        let number = self.bytes.choose_index(self.scene.world.entities().count())?;
        let (_, entity) = self.scene.world.entities().nth(number).expect("there are as many");
        Ok(entity.identifier.clone())
    }

    /// An entity of the parameter's type; rarely of any.
    fn argument(&mut self, parameter: &Parameter) -> Result<String> {
        let fitting = self.scene.world.of_kind(parameter.kind);
        if fitting.is_empty() || self.bytes.ratio(1, 40)? {
            return self.entity();
        }
        let entity = *self.bytes.choose(fitting)?;
        Ok(self.scene.world.entity(entity).identifier.clone())
    }

    fn call(&mut self, action: &Action) -> Result<WrittenStep> {
        let mut arguments = Vec::new();
        for place in &action.explicit {
            arguments.push(self.argument(&action.parameters[*place])?);
        }
        let mut implicit = Vec::new();
        for place in action.implicit() {
            if self.bytes.ratio(1, 2)? {
                let parameter = &action.parameters[place];
                implicit.push((parameter.name.clone(), self.argument(parameter)?));
            }
        }
        let name = action.call.clone();
        Ok(WrittenStep {
            call: Call { name, arguments },
            implicit,
            explanation: String::new(),
        })
    }

    fn any_call(&mut self) -> Result<WrittenStep> {
        let scene = self.scene;
        let action = self.bytes.choose(&scene.domain.actions)?;
        self.call(action)
    }

    fn step(&mut self) -> Result<StepId> {
        let mut step = self.any_call()?;
        if self.bytes.ratio(1, 8)? {
            let fact = self.fact()?;
            // A claim stands behind the sentence: the entity, and the state in whose entry it is.
            let mut arguments = fact.call.arguments.into_iter();
            let subject = arguments.next().unwrap_or_default();
            let rest: Vec<String> = arguments.collect();
            step.explanation = format!("so; {subject}: {}({})", fact.call.name, rest.join(", "));
        }
        self.steps.push(step);
        Ok(StepId::new(self.steps.len() - 1))
    }

    /// A state of an entity, as a condition asks for it.
    fn fact(&mut self) -> Result<WrittenStep> {
        let word = self.bytes.choose(&self.scene.domain.states)?;
        let mut arguments = vec![self.entity()?];
        for _ in &word.parameters {
            arguments.push(self.entity()?);
        }
        let name = word.word.clone();
        Ok(WrittenStep {
            call: Call { name, arguments },
            implicit: Vec::new(),
            explanation: String::new(),
        })
    }

    fn condition(&mut self, depth: usize) -> Result<Test<WrittenStep>> {
        Ok(match self.bytes.int_in_range(0..=if depth == 0 { 1 } else { 5 })? {
            0 => Test::Holds(self.fact()?),
            1 => {
                let scene = self.scene;
                let sensing: Vec<&Action> = scene.domain.actions.iter().filter(|a| !a.senses.is_empty()).collect();
                match sensing.is_empty() {
                    true => Test::Holds(self.fact()?),
                    false => {
                        let action = *self.bytes.choose(&sensing)?;
                        Test::Holds(self.call(action)?)
                    }
                }
            }
            2 => Test::Not(Box::new(self.condition(depth - 1)?)),
            kind => {
                let count = self.bytes.int_in_range(2..=3)?;
                let parts = (0..count).map(|_| self.condition(depth - 1)).collect::<Result<_>>()?;
                match kind {
                    3 => Test::All(parts),
                    _ => Test::Any(parts),
                }
            }
        })
    }

    fn block(&mut self, depth: usize) -> Result<Vec<WrittenNode>> {
        let mut nodes = Vec::new();
        while self.nodes > 0 && !self.bytes.is_empty() && (nodes.is_empty() || self.bytes.ratio(3, 4)?) {
            self.nodes -= 1;
            nodes.push(self.node(depth)?);
        }
        Ok(nodes)
    }

    fn node(&mut self, depth: usize) -> Result<WrittenNode> {
        Ok(match self.bytes.int_in_range(0..=if depth == 0 { 5 } else { 9 })? {
            0..=4 => Node::Step(self.step()?),
            5 => Node::Remark("go on".to_owned()),
            6 => Node::If {
                condition: self.condition(2)?,
                then: self.block(depth - 1)?,
                otherwise: self.block(depth - 1)?,
            },
            7 => Node::While {
                condition: self.condition(2)?,
                body: self.block(depth - 1)?,
            },
            8 => Node::Repeat {
                times: *self.bytes.choose(&[0, 1, 2, 3, 7, 1_000, u32::MAX])?,
                body: self.block(depth - 1)?,
            },
            _ => Node::Parallel { lanes: self.lanes()? },
        })
    }

    fn lanes(&mut self) -> Result<Vec<Lane<String>>> {
        let mut lanes = Vec::new();
        for actor in ["left", "right"] {
            let mut items = Vec::new();
            while self.nodes > 0 && self.bytes.ratio(3, 4)? {
                self.nodes -= 1;
                items.push(match self.bytes.int_in_range(0..=4)? {
                    0 => LaneItem::Sync((*self.bytes.choose(&["a", "b"])?).to_owned()),
                    _ => LaneItem::Step(self.step()?),
                });
            }
            lanes.push(Lane {
                actor: actor.to_owned(),
                items,
            });
        }
        Ok(lanes)
    }
}
