//! The rest of a plan behind a position in it, as a plan.

use super::Cursor;
use super::program::Op;
use crate::plan::tree::Rebuild;
use crate::plan::{Lane, Node, Plan, StepId, Test};
use longstep_model::model::{EntityId, Fact};

/// The rest of a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Rest {
    /// The rest as a plan. Loops that have begun are unrolled by the iteration that is under way.
    pub plan: Plan,
    /// For each of its steps, the step of the whole plan.
    pub steps: Vec<StepId>,
}

impl Cursor {
    /// Returns the rest of the plan: everything behind the completed steps. None if unrolling a loop would nest the tree
    /// too deep. Takes time linear in the length of the plan.
    ///
    /// ```
    /// # use longstep_model::{domain, environment};
    /// # use longstep_verify::{plan, verify::check_file};
    /// # let household = domain::shipped("household").unwrap().unwrap();
    /// # let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    /// # let world = environment::parse(&household, "env.json", text).unwrap();
    /// # let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
    /// # let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
    /// let mut cursor = plan.cursor();
    /// let first = cursor.ready()[0];
    /// cursor.complete(first, None)?;
    /// let rest = cursor.rest().unwrap();
    /// assert_eq!((rest.plan.steps().len(), rest.steps[0].index()), (2, 1));
    /// # Ok::<(), longstep_verify::cursor::CursorError>(())
    /// ```
    pub fn rest(&self) -> Option<Rest> {
        let whole = self.plan.plan();
        let Some(next) = self.ready.first().copied() else {
            return Some(Rest {
                plan: Plan::default(),
                steps: Vec::new(),
            });
        };
        let mut behind = Behind {
            cursor: self,
            next,
            loops: 0,
        };
        let nodes = behind.nodes(whole.body())?;
        let mut numbering = Numbering(Vec::new());
        let body = numbering.nodes(&nodes);
        let steps = numbering.0;
        let own = steps.iter().map(|step| whole.step(*step).clone()).collect();
        let plan = Plan::tree(own, body)?;
        Some(Rest { plan, steps })
    }
}

impl Rest {
    /// Returns the rest without its first nodes; in a sequence each node is a step.
    pub fn without_first(&self, nodes: usize) -> Option<Self> {
        let mut numbering = Numbering(Vec::new());
        let body = numbering.nodes(self.plan.body().get(nodes..)?);
        let own = numbering.0;
        let plan = Plan::tree(own.iter().map(|step| self.plan.step(*step).clone()).collect(), body)?;
        let steps = own.iter().map(|step| self.steps[step.index()]).collect();
        Some(Self { plan, steps })
    }
}

/// Collects the nodes from the next step on; their steps keep their numbers.
struct Behind<'a> {
    cursor: &'a Cursor,
    next: StepId,
    /// The counted loops before the node that is visited.
    loops: usize,
}

impl Behind<'_> {
    /// Returns the rest of a block that contains the next step; none for any other block.
    fn nodes(&mut self, nodes: &[Node]) -> Option<Vec<Node>> {
        for (index, node) in nodes.iter().enumerate() {
            if let Some(mut rest) = self.node(node) {
                rest.extend_from_slice(&nodes[index + 1..]);
                return Some(rest);
            }
        }
        None
    }

    fn node(&mut self, node: &Node) -> Option<Vec<Node>> {
        let number = self.loops;
        self.loops += usize::from(matches!(node, Node::Repeat { .. }));
        let in_condition = node.condition().and_then(|condition| self.test(condition));
        match node {
            Node::Step(step) => (*step == self.next).then(|| vec![node.clone()]),
            Node::If { then, otherwise, .. } => match in_condition {
                Some(condition) => Some(vec![Node::If {
                    condition,
                    then: then.clone(),
                    otherwise: otherwise.clone(),
                }]),
                None => self.nodes(then).or_else(|| self.nodes(otherwise)),
            },
            Node::While { condition, body } => match in_condition {
                // The loop from its beginning.
                Some(rest) if rest == *condition => Some(vec![node.clone()]),
                Some(condition) => {
                    let mut then = body.clone();
                    then.push(node.clone());
                    Some(vec![Node::If {
                        condition,
                        then,
                        otherwise: Vec::new(),
                    }])
                }
                None => {
                    let mut rest = self.nodes(body)?;
                    rest.push(node.clone());
                    Some(rest)
                }
            },
            Node::Repeat { body, .. } => {
                let mut rest = self.nodes(body)?;
                let (left, _) = self.cursor.position.loops[number];
                if left > 1 {
                    rest.push(Node::Repeat {
                        times: left - 1,
                        body: body.clone(),
                    });
                }
                Some(rest)
            }
            Node::Parallel { lanes } => {
                let inside = lanes.iter().flat_map(Lane::steps).any(|step| step == self.next);
                inside.then(|| self.lanes(lanes))
            }
            Node::Remark(_) => None,
        }
    }

    fn lanes(&self, lanes: &[Lane]) -> Vec<Node> {
        let begun = matches!(self.cursor.program.ops[self.cursor.position.at], Op::Lanes(_));
        let place = |index: usize| if begun { self.cursor.position.lanes[index] } else { 0 };
        let rest = lanes.iter().enumerate().map(|(index, lane)| Lane {
            actor: lane.actor,
            items: lane.acts().skip(place(index)).cloned().collect(),
        });
        let lanes: Vec<Lane> = rest.filter(|lane| !lane.items.is_empty()).collect();
        vec![Node::Parallel { lanes }]
    }

    /// Returns the part of a condition that is not evaluated yet; none if the next step is not in it.
    fn test(&self, test: &Test) -> Option<Test> {
        let of_parts = |parts: &[Test]| {
            let (index, rest) = parts
                .iter()
                .enumerate()
                .find_map(|(index, part)| Some((index, self.test(part)?)))?;
            Some([rest].into_iter().chain(parts[index + 1..].iter().cloned()).collect())
        };
        match test {
            Test::Sense(step) => (*step == self.next).then(|| test.clone()),
            Test::Holds(_) => None,
            Test::Not(inner) => Some(Test::Not(Box::new(self.test(inner)?))),
            // The parts before the step held, or did not hold, or it would not be evaluated.
            Test::All(parts) => Some(Test::All(of_parts(parts)?)),
            Test::Any(parts) => Some(Test::Any(of_parts(parts)?)),
        }
    }
}

/// Numbers the steps of a tree in reading order; holds the number that each had before.
struct Numbering(Vec<StepId>);

impl Numbering {
    fn number(&mut self, step: StepId) -> StepId {
        self.0.push(step);
        StepId::new(self.0.len() - 1)
    }
}

impl Rebuild<Fact, EntityId> for Numbering {
    type Fact = Fact;
    type Actor = EntityId;

    fn step(&mut self, step: StepId, nodes: &mut Vec<Node>) {
        nodes.push(Node::Step(self.number(step)));
    }

    fn condition(&mut self, condition: &Test) -> Test {
        condition.renumbered(&mut |step| self.number(step))
    }

    fn lane(&mut self, lane: &Lane) -> Lane {
        lane.map(lane.actor, |step| Some(self.number(step)))
    }
}
