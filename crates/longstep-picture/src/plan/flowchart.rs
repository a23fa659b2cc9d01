//! A diagram as a flowchart, for Mermaid and for Graphviz.

use longstep_core::visible;

use super::{Diagram, DiagramNode, LaneRow, StepNode};

/// A shape in a flowchart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    /// The beginning or the end.
    Terminal,
    Step,
    /// A step that senses.
    Sensing,
    /// A question with two answers.
    Question,
    /// A point where paths meet or part.
    Bar,
    Remark,
}

/// A shape with its text, line by line. The first line is what it does.
#[derive(Debug)]
pub(super) struct Shown {
    pub(super) shape: Shape,
    pub(super) lines: Vec<String>,
    /// The lane that it is in.
    pub(super) lane: Option<usize>,
}

/// An arrow between two shapes.
#[derive(Debug)]
pub(super) struct Arrow {
    pub(super) from: usize,
    pub(super) to: usize,
    pub(super) label: String,
    /// True for a line to a remark, which nobody follows.
    pub(super) is_remark: bool,
}

/// A plan as shapes and arrows. Its texts are single lines, in which everything is visible.
#[derive(Debug, Default)]
pub(super) struct Flowchart {
    pub(super) shapes: Vec<Shown>,
    pub(super) arrows: Vec<Arrow>,
    /// The names of the lanes; those of several groups have places of their own.
    pub(super) lanes: Vec<String>,
}

/// The ends of arrows that wait for the next shape, with their labels.
type Open = Vec<(usize, String)>;

impl Flowchart {
    pub(super) fn of(diagram: &Diagram) -> Self {
        let mut chart = Self::default();
        let begin = chart.shape(Shape::Terminal, vec!["begin".to_owned()], None);
        let open = chart.nodes(&diagram.nodes, vec![(begin, String::new())], None);
        let mut end = vec!["end".to_owned()];
        end.extend(diagram.left_out.iter().map(|text| format!("left out: {text}")));
        let end = chart.shape(Shape::Terminal, end, None);
        chart.join(open, end);
        if !diagram.assumptions.is_empty() {
            let lines = diagram.assumptions.iter().map(|text| format!("assumed: {text}"));
            let remark = chart.shape(Shape::Remark, lines.collect(), None);
            chart.remark(begin, remark);
        }
        chart
    }

    /// Returns the shapes outside of lanes with their numbers, and then those of each lane with its number and name.
    pub(super) fn groups(
        &self,
    ) -> impl Iterator<Item = (Option<(usize, &str)>, impl Iterator<Item = (usize, &Shown)>)> {
        let lanes = self
            .lanes
            .iter()
            .enumerate()
            .map(|(lane, name)| Some((lane, name.as_str())));
        std::iter::once(None).chain(lanes).map(|group: Option<(usize, &str)>| {
            let lane = group.map(|(lane, _)| lane);
            let shapes = self.shapes.iter().enumerate();
            (group, shapes.filter(move |(_, shown)| shown.lane == lane))
        })
    }

    fn shape(&mut self, shape: Shape, lines: Vec<String>, lane: Option<usize>) -> usize {
        let lines = lines.iter().map(|line| visible::line(line).into_owned()).collect();
        self.shapes.push(Shown { shape, lines, lane });
        self.shapes.len() - 1
    }

    /// Lets all open arrows end at a shape.
    fn join(&mut self, open: Open, to: usize) {
        for (from, label) in open {
            self.arrows.push(Arrow {
                from,
                to,
                label: visible::line(&label).into_owned(),
                is_remark: false,
            });
        }
    }

    fn remark(&mut self, from: usize, to: usize) {
        self.arrows.push(Arrow {
            from,
            to,
            label: String::new(),
            is_remark: true,
        });
    }

    fn nodes(&mut self, nodes: &[DiagramNode], mut open: Open, lane: Option<usize>) -> Open {
        for node in nodes {
            open = self.node(node, open, lane);
        }
        open
    }

    fn node(&mut self, node: &DiagramNode, open: Open, lane: Option<usize>) -> Open {
        match node {
            DiagramNode::Step(step) => self.step(step, open, lane),
            DiagramNode::Remark { text } => {
                let remark = self.shape(Shape::Remark, vec![text.clone()], lane);
                if let Some((from, _)) = open.first() {
                    self.remark(*from, remark);
                }
                open
            }
            DiagramNode::Branch {
                condition,
                otherwise,
                sensing,
                then,
                other,
            } => {
                let open = self.steps(sensing, open, lane);
                let question = self.shape(Shape::Question, vec![condition.clone()], lane);
                self.join(open, question);
                let mut ends = self.nodes(then, vec![(question, "yes".to_owned())], lane);
                ends.extend(self.nodes(other, vec![(question, otherwise.clone())], lane));
                ends
            }
            DiagramNode::Loop {
                condition,
                sensing,
                body,
            } => {
                let first = self.shapes.len();
                let open = self.steps(sensing, open, lane);
                let question = self.shape(Shape::Question, vec![format!("while {condition}")], lane);
                self.join(open, question);
                let back = self.nodes(body, vec![(question, "yes".to_owned())], lane);
                self.join(back, first);
                vec![(question, "no".to_owned())]
            }
            DiagramNode::Repeat { times, body } => {
                let question = self.shape(Shape::Question, vec![format!("{times} times")], lane);
                self.join(open, question);
                let back = self.nodes(body, vec![(question, "again".to_owned())], lane);
                self.join(back, question);
                vec![(question, "done".to_owned())]
            }
            DiagramNode::Lanes { lanes, rows } => self.lanes(lanes, rows, open),
        }
    }

    fn steps(&mut self, steps: &[StepNode], mut open: Open, lane: Option<usize>) -> Open {
        for step in steps {
            open = self.step(step, open, lane);
        }
        open
    }

    fn step(&mut self, step: &StepNode, open: Open, lane: Option<usize>) -> Open {
        let shape = if step.senses { Shape::Sensing } else { Shape::Step };
        let added = self.shape(shape, lines(step), lane);
        self.join(open, added);
        vec![(added, String::new())]
    }

    fn lanes(&mut self, lanes: &[String], rows: &[LaneRow], open: Open) -> Open {
        let first = self.lanes.len();
        self.lanes
            .extend(lanes.iter().map(|name| visible::line(name).into_owned()));
        let fork = self.shape(Shape::Bar, vec!["together".to_owned()], None);
        self.join(open, fork);
        let mut ends: Vec<Open> = lanes.iter().map(|_| vec![(fork, String::new())]).collect();
        for row in rows {
            match row {
                LaneRow::Unit { cells } => {
                    for (lane, step) in cells.iter().enumerate() {
                        if let Some(step) = step {
                            let open = std::mem::take(&mut ends[lane]);
                            ends[lane] = self.step(step, open, Some(first + lane));
                        }
                    }
                }
                LaneRow::Sync { name, lanes } => {
                    let bar = self.shape(Shape::Bar, vec![name.clone()], None);
                    for lane in lanes {
                        let open = std::mem::replace(&mut ends[*lane], vec![(bar, String::new())]);
                        self.join(open, bar);
                    }
                }
                LaneRow::Remark { lane, text } => {
                    let remark = self.shape(Shape::Remark, vec![text.clone()], Some(first + lane));
                    if let Some((from, _)) = ends[*lane].first() {
                        self.remark(*from, remark);
                    }
                }
            }
        }
        let join = self.shape(Shape::Bar, vec!["all done".to_owned()], None);
        self.join(ends.concat(), join);
        vec![(join, String::new())]
    }
}

/// The statements of a diagram about a step.
fn lines(step: &StepNode) -> Vec<String> {
    let mut lines = vec![format!("{}. {}", step.number, step.text)];
    lines.extend(step.lane.as_ref().map(|lane| format!("by {lane}")));
    lines.extend(step.changes.iter().map(|change| format!("so that {change}")));
    lines.extend(step.brief_reason.clone());
    lines.extend(step.edited.iter().map(|edit| format!("changed: {edit}")));
    lines.extend(step.left_out.iter().map(|text| format!("left out before: {text}")));
    lines.extend(step.assumed.iter().map(|text| format!("assumed: {text}")));
    if step.unreached {
        lines.push("no path comes here".to_owned());
    }
    lines
}
