//! Indented text lines of a plan for display.

use super::{Lane, LaneItem, Node, Plan, StepId, Test};
use longstep_model::model::{Domain, World, phrase, written_fact};

/// A line of an [`outline`].
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct OutlineLine {
    /// The step that the line shows, from 0; none for a header line such as `else`.
    pub step: Option<usize>,
    /// Number of branches, loops and lanes around the line.
    pub depth: usize,
    /// The call, or `if check_best_by_date()`, `else`, `repeat 3 times`, `left:`.
    pub text: String,
    /// Explanation of the step; empty for a header line.
    pub explanation: String,
}

/// Returns the lines of a plan, in reading order.
///
/// ```
/// use longstep_verify::plan::{Plan, outline};
/// use longstep_model::{domain, environment};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let world = environment::read(&household, &Default::default(), "", "", &Default::default()).unwrap();
/// assert!(outline(&world, &Plan::default()).is_empty());
/// ```
pub fn outline(world: &World, plan: &Plan) -> Vec<OutlineLine> {
    let domain = world.domain();
    let mut writer = Writer {
        domain,
        world,
        plan,
        lines: Vec::new(),
    };
    writer.nodes(plan.body(), 0);
    writer.lines
}

struct Writer<'a> {
    domain: &'a Domain,
    world: &'a World,
    plan: &'a Plan,
    lines: Vec<OutlineLine>,
}

impl Writer<'_> {
    fn nodes(&mut self, nodes: &[Node], depth: usize) {
        for node in nodes {
            match node {
                Node::Step(step) => self.step(*step, depth),
                Node::If {
                    condition,
                    then,
                    otherwise,
                } => {
                    self.condition_line("if", condition, depth);
                    self.nodes(then, depth + 1);
                    if !otherwise.is_empty() {
                        self.lead("else", depth);
                        self.nodes(otherwise, depth + 1);
                    }
                }
                Node::While { condition, body } => {
                    self.condition_line("while", condition, depth);
                    self.nodes(body, depth + 1);
                }
                Node::Repeat { times, body } => {
                    self.lead(&format!("repeat {times} times"), depth);
                    self.nodes(body, depth + 1);
                }
                Node::Parallel { lanes } => {
                    self.lead("at the same time", depth);
                    lanes.iter().for_each(|lane| self.lane(lane, depth + 1));
                }
                Node::Remark(text) => self.lead(&format!("# {text}"), depth),
            }
        }
    }

    fn lane(&mut self, lane: &Lane, depth: usize) {
        self.lead(&format!("{}:", self.world.entity(lane.actor).identifier), depth);
        for item in &lane.items {
            match item {
                LaneItem::Step(step) => self.step(*step, depth + 1),
                LaneItem::Sync(name) => self.lead(&format!("wait for the others at {name}"), depth + 1),
                LaneItem::Remark(text) => self.lead(&format!("# {text}"), depth + 1),
            }
        }
    }

    fn lead(&mut self, text: &str, depth: usize) {
        self.lines.push(OutlineLine {
            depth,
            text: text.to_owned(),
            ..OutlineLine::default()
        });
    }

    fn step(&mut self, id: StepId, depth: usize) {
        let step = self.plan.step(id);
        self.lines.push(OutlineLine {
            step: Some(id.index()),
            depth,
            text: step.call(self.world).to_string(),
            explanation: step.explanation.clone(),
        });
    }

    fn condition_line(&mut self, word: &str, condition: &Test, depth: usize) {
        let steps: Vec<StepId> = condition.steps().collect();
        let explanations: Vec<&str> = steps
            .iter()
            .map(|id| phrase(&self.plan.step(*id).explanation))
            .collect();
        self.lines.push(OutlineLine {
            step: steps.first().map(|id| id.index()),
            depth,
            text: format!("{word} {}", self.test(condition, false)),
            explanation: explanations.join("; "),
        });
    }

    /// Formats a condition; `within` another condition, several parts are put in parentheses.
    fn test(&self, test: &Test, within: bool) -> String {
        let several = |parts: &[Test], word: &str| {
            let parts: Vec<String> = parts.iter().map(|part| self.test(part, true)).collect();
            let text = parts.join(word);
            if within && parts.len() > 1 {
                format!("({text})")
            } else {
                text
            }
        };
        match test {
            Test::Sense(id) => self.plan.step(*id).call(self.world).to_string(),
            Test::Holds(fact) => written_fact(self.domain, *fact, &|entity| {
                self.world.entity(entity).identifier.clone()
            }),
            Test::Not(inner) => format!("not {}", self.test(inner, true)),
            Test::All(parts) => several(parts, " and "),
            Test::Any(parts) => several(parts, " or "),
        }
    }
}
