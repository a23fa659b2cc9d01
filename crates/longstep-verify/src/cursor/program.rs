//! A plan tree as a linear program, so that a position in it is one number.

use crate::plan::{LaneItem, Node, StepId, Test};
use longstep_model::model::Fact;

/// One instruction. Targets are indexes of instructions; the length of the program is its end.
#[derive(Debug)]
pub(super) enum Op {
    Step(StepId),
    /// A sensing step of a condition, with the targets for its first outcome and for the others.
    Sense {
        step: StepId,
        holds: usize,
        fails: usize,
    },
    /// A known fact of a condition.
    Holds {
        fact: Fact,
        holds: usize,
        fails: usize,
    },
    Jump(usize),
    /// The beginning of a counted loop.
    Repeat {
        number: usize,
        times: u32,
        end: usize,
    },
    /// The end of an iteration of it.
    Again {
        number: usize,
        begin: usize,
    },
    /// Lanes without their remarks.
    Lanes(Vec<Vec<LaneItem>>),
}

/// A compiled plan tree.
#[derive(Debug)]
pub(super) struct Program {
    pub(super) ops: Vec<Op>,
    /// The number of counted loops.
    pub(super) loops: usize,
}

impl Program {
    pub(super) fn new(body: &[Node]) -> Self {
        let mut compiler = Compiler::default();
        compiler.nodes(body);
        let Compiler { mut ops, labels, loops } = compiler;
        for op in &mut ops {
            match op {
                Op::Sense { holds, fails, .. } | Op::Holds { holds, fails, .. } => {
                    (*holds, *fails) = (labels[*holds], labels[*fails]);
                }
                Op::Jump(to) | Op::Repeat { end: to, .. } | Op::Again { begin: to, .. } => *to = labels[*to],
                Op::Step(_) | Op::Lanes(_) => {}
            }
        }
        Self { ops, loops }
    }
}

/// Compiles nodes; targets are labels, which get their place when it is known.
#[derive(Default)]
struct Compiler {
    ops: Vec<Op>,
    labels: Vec<usize>,
    loops: usize,
}

impl Compiler {
    fn label(&mut self) -> usize {
        self.labels.push(usize::MAX);
        self.labels.len() - 1
    }

    /// Gives a label its place: the next instruction.
    fn place(&mut self, label: usize) {
        self.labels[label] = self.ops.len();
    }

    fn nodes(&mut self, nodes: &[Node]) {
        nodes.iter().for_each(|node| self.node(node));
    }

    fn node(&mut self, node: &Node) {
        match node {
            Node::Step(id) => self.ops.push(Op::Step(*id)),
            Node::If {
                condition,
                then,
                otherwise,
            } => {
                let (holds, fails, end) = (self.label(), self.label(), self.label());
                self.test(condition, holds, fails);
                self.place(holds);
                self.nodes(then);
                self.ops.push(Op::Jump(end));
                self.place(fails);
                self.nodes(otherwise);
                self.place(end);
            }
            Node::While { condition, body } => {
                let (head, holds, fails) = (self.label(), self.label(), self.label());
                self.place(head);
                self.test(condition, holds, fails);
                self.place(holds);
                self.nodes(body);
                self.ops.push(Op::Jump(head));
                self.place(fails);
            }
            Node::Repeat { times, body } => {
                let (begin, end, number) = (self.label(), self.label(), self.loops);
                self.loops += 1;
                let times = *times;
                self.ops.push(Op::Repeat { number, times, end });
                self.place(begin);
                self.nodes(body);
                self.ops.push(Op::Again { number, begin });
                self.place(end);
            }
            Node::Parallel { lanes } => {
                let lanes = lanes.iter().map(|lane| lane.acts().cloned().collect());
                self.ops.push(Op::Lanes(lanes.collect()));
            }
            Node::Remark(_) => {}
        }
    }

    fn test(&mut self, test: &Test, holds: usize, fails: usize) {
        match test {
            Test::Sense(step) => self.ops.push(Op::Sense {
                step: *step,
                holds,
                fails,
            }),
            Test::Holds(fact) => self.ops.push(Op::Holds {
                fact: *fact,
                holds,
                fails,
            }),
            Test::Not(inner) => self.test(inner, fails, holds),
            Test::All(parts) => {
                for part in parts {
                    let next = self.label();
                    self.test(part, next, fails);
                    self.place(next);
                }
                self.ops.push(Op::Jump(holds));
            }
            Test::Any(parts) => {
                for part in parts {
                    let next = self.label();
                    self.test(part, holds, next);
                    self.place(next);
                }
                self.ops.push(Op::Jump(fails));
            }
        }
    }
}
