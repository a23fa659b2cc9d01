//! A draft during repair: nodes in numbered blocks.

use super::super::EditKind;
use longstep_model::model::{EntityId, World};
use longstep_verify::plan::{DraftStep, Node, Plan, Resolved, StepId, Test, lanes};

/// Maximum number of steps and of blocks after unfolding. Blocks are limited too, since empty branches also double.
const MOST: usize = 2_000;

/// A step of the draft during repair.
#[derive(Debug, Clone)]
pub(super) struct Item {
    pub(super) step: DraftStep,
    /// Bound values of its implicit arguments.
    pub(super) bound: Vec<EntityId>,
    pub(super) written: String,
    /// Its number in the draft; for a new step, the number of the step before which it was inserted.
    pub(super) from: usize,
    /// The edit that created it; none for a step as in the draft.
    pub(super) edit: Option<(EditKind, String)>,
    /// True if a repaired path contains it.
    pub(super) settled: bool,
}

impl Item {
    /// Returns the step's arguments, with bound values for implicit ones. A step on no path keeps its own.
    pub(super) fn arguments(&self) -> Vec<EntityId> {
        let written = self.step.arguments.iter().zip(&self.bound);
        written.map(|(written, bound)| written.unwrap_or(*bound)).collect()
    }

    /// Returns its number in the draft; none for an inserted step.
    pub(super) fn drafted(&self) -> Option<usize> {
        let inserted = matches!(self.edit, Some((EditKind::Insert, _)));
        (!inserted).then_some(self.from)
    }
}

/// The draft during repair: numbered steps in any order, and the tree.
#[derive(Debug, Clone, Default)]
pub(super) struct Draft {
    pub(super) items: Vec<Item>,
    pub(super) blocks: Vec<Vec<Part>>,
    /// Dropped steps: number, call, reason, and the step before which they stood.
    pub(super) dropped: Vec<(usize, String, String, Option<usize>)>,
}

/// A node of a block; blocks are referred to by number.
#[derive(Debug, Clone)]
pub(super) enum Part {
    Step(usize),
    If(Test, usize, usize),
    While(Test, usize),
    Repeat(u32, usize),
    Remark(String),
}

impl Part {
    /// Returns true if the part is a step, or has it in its condition.
    pub(super) fn executes(&self, step: usize) -> bool {
        match self {
            Self::Step(number) => *number == step,
            Self::If(test, ..) | Self::While(test, _) => test.steps().any(|own| own.index() == step),
            Self::Repeat(..) | Self::Remark(_) => false,
        }
    }
}

impl Draft {
    pub(super) fn of(world: &World, resolved: &Resolved, plan: &Plan) -> Self {
        let mut items = Vec::with_capacity(plan.steps().len());
        for (from, step) in plan.steps().iter().enumerate() {
            items.push(Item {
                // Repair may change the implicit arguments of a step, but not those of a sensing step.
                step: match &resolved.steps[from] {
                    Some(draft) if world.domain().action(step.action).senses.is_empty() => draft.clone(),
                    _ => step.into(),
                },
                bound: step.arguments.clone(),
                written: step.call(world).to_string(),
                from,
                edit: None,
                settled: false,
            });
        }
        let mut draft = Self {
            items,
            blocks: vec![Vec::new()],
            dropped: Vec::new(),
        };
        draft.blocks[0] = draft.parts(plan.body());
        draft
    }

    fn parts(&mut self, nodes: &[Node]) -> Vec<Part> {
        let mut parts = Vec::new();
        for node in nodes {
            match node {
                Node::Step(id) => parts.push(Part::Step(id.index())),
                Node::If {
                    condition,
                    then,
                    otherwise,
                } => {
                    let (then, otherwise) = (self.block(then), self.block(otherwise));
                    parts.push(Part::If(condition.clone(), then, otherwise));
                }
                Node::While { condition, body } => {
                    let body = self.block(body);
                    parts.push(Part::While(condition.clone(), body));
                }
                Node::Repeat { times, body } => {
                    let body = self.block(body);
                    parts.push(Part::Repeat(*times, body));
                }
                // Repair works on lists. This order is one that the synchronization points allow.
                Node::Parallel { lanes } => {
                    let steps = lanes::sequence(lanes).into_iter();
                    parts.extend(steps.map(|step| Part::Step(step.index())));
                }
                Node::Remark(text) => parts.push(Part::Remark(text.clone())),
            }
        }
        parts
    }

    fn block(&mut self, nodes: &[Node]) -> usize {
        let parts = self.parts(nodes);
        self.blocks.push(parts);
        self.blocks.len() - 1
    }

    /// Copies the nodes after each branch into both of its sides; returns false if the draft becomes too large.
    pub(super) fn unfold(&mut self, block: usize) -> bool {
        let Some(place) = self.blocks[block].iter().position(|part| matches!(part, Part::If(..))) else {
            return self.blocks[block].clone().iter().all(|part| match part {
                Part::While(_, body) | Part::Repeat(_, body) => self.unfold(*body),
                _ => true,
            });
        };
        let tail = self.blocks[block].split_off(place + 1);
        let Part::If(_, then, otherwise) = self.blocks[block][place].clone() else {
            return true;
        };
        let copy = self.copied(&tail);
        self.blocks[then].extend(tail);
        self.blocks[otherwise].extend(copy);
        self.items.len().max(self.blocks.len()) <= MOST && self.unfold(then) && self.unfold(otherwise)
    }

    /// Copies the parts with new step numbers.
    fn copied(&mut self, parts: &[Part]) -> Vec<Part> {
        parts
            .iter()
            .map(|part| match part {
                Part::Step(number) => Part::Step(self.another(*number)),
                Part::If(test, then, otherwise) => {
                    let test = self.test(test);
                    let (then, otherwise) = (self.copied_block(*then), self.copied_block(*otherwise));
                    Part::If(test, then, otherwise)
                }
                Part::While(test, body) => {
                    let test = self.test(test);
                    Part::While(test, self.copied_block(*body))
                }
                Part::Repeat(times, body) => Part::Repeat(*times, self.copied_block(*body)),
                Part::Remark(text) => Part::Remark(text.clone()),
            })
            .collect()
    }

    fn copied_block(&mut self, block: usize) -> usize {
        let parts = self.blocks[block].clone();
        let copy = self.copied(&parts);
        self.blocks.push(copy);
        self.blocks.len() - 1
    }

    fn another(&mut self, number: usize) -> usize {
        self.items.push(self.items[number].clone());
        self.items.len() - 1
    }

    /// Copies the condition with its sensing steps.
    fn test(&mut self, test: &Test) -> Test {
        test.renumbered(&mut |step| StepId::new(self.another(step.index())))
    }

    /// Moves the common end of both sides of a branch after the branch.
    pub(super) fn fold(&mut self, block: usize) {
        let mut parts = std::mem::take(&mut self.blocks[block]);
        if let Some(Part::If(_, then, otherwise)) = parts.last().cloned() {
            self.fold(then);
            self.fold(otherwise);
            let mut tail = Vec::new();
            while let (Some(one), Some(other)) = (self.blocks[then].last(), self.blocks[otherwise].last()) {
                if !self.same(one, other) {
                    break;
                }
                self.blocks[otherwise].pop();
                tail.extend(self.blocks[then].pop());
            }
            parts.extend(tail.into_iter().rev());
        }
        self.blocks[block] = parts;
    }

    fn same(&self, one: &Part, other: &Part) -> bool {
        match (one, other) {
            (Part::Step(one), Part::Step(other)) => {
                let (one, other) = (&self.items[*one], &self.items[*other]);
                one.step == other.step
            }
            (Part::Remark(one), Part::Remark(other)) => one == other,
            _ => false,
        }
    }

    /// Converts a block to nodes; appends its steps to `order`, and numbers them accordingly.
    pub(super) fn nodes(&self, block: usize, order: &mut Vec<usize>) -> Vec<Node> {
        let mut nodes = Vec::new();
        for part in &self.blocks[block] {
            nodes.push(match part {
                Part::Step(number) => {
                    order.push(*number);
                    Node::Step(StepId::new(order.len() - 1))
                }
                Part::If(test, then, otherwise) => Node::If {
                    condition: numbered(test, order),
                    then: self.nodes(*then, order),
                    otherwise: self.nodes(*otherwise, order),
                },
                Part::While(test, body) => Node::While {
                    condition: numbered(test, order),
                    body: self.nodes(*body, order),
                },
                Part::Repeat(times, body) => Node::Repeat {
                    times: *times,
                    body: self.nodes(*body, order),
                },
                Part::Remark(text) => Node::Remark(text.clone()),
            });
        }
        nodes
    }
}

/// Adds the sensing steps of the condition to `order` and renumbers them.
fn numbered(test: &Test, order: &mut Vec<usize>) -> Test {
    test.renumbered(&mut |step| {
        order.push(step.index());
        StepId::new(order.len() - 1)
    })
}
