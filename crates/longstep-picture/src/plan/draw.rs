//! A diagram as SVG.

use super::layout::whole;
use super::piece::Piece;
use super::{Diagram, DiagramNode, LaneRow, StepNode};
use crate::draw::SvgOptions;
use crate::draw::canvas::Canvas;
use crate::draw::theme;

/// Draws a plan as a column of numbered cards, with the sides of branches and the lanes beside each other where there is
/// room. The height follows from the content.
///
/// The card of a step has its number as `data-step`, and a title with everything that the diagram says of it.
///
/// ```
/// use longstep_core::{domain, environment, plan, verify};
/// use longstep_picture::SvgOptions;
/// use longstep_picture::plan::{Annotations, Diagram, svg};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// let plan = verify::check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// let picture = svg(&Diagram::of(&plan, &Annotations::default()), &SvgOptions::new(700.0));
/// assert!(picture.contains("move the hand to the pen"));
/// ```
pub fn svg(diagram: &Diagram, options: &SvgOptions) -> String {
    let piece = whole(diagram, options.width);
    let mut canvas = Canvas::default();
    content(&mut canvas, &piece);
    let title = if options.title.is_empty() {
        "Plan"
    } else {
        &options.title
    };
    canvas.finish(
        options,
        (piece.area.width, piece.area.height),
        title,
        &description(diagram),
    )
}

fn content(canvas: &mut Canvas, piece: &Piece) {
    for rail in &piece.rails {
        canvas.line(&rail.points, (0.0, 0.0), rail.paint);
    }
    piece.lines.iter().for_each(|line| canvas.text(line));
    for child in &piece.children {
        part(canvas, child);
    }
}

fn part(canvas: &mut Canvas, piece: &Piece) {
    let number = piece.step.map(|number| number.to_string());
    let data: Vec<(&str, &str)> = number.iter().map(|number| ("step", number.as_str())).collect();
    canvas.begin("ls-part", &data);
    if let Some(title) = &piece.title {
        canvas.title(title);
    }
    canvas.rect(piece.area, piece.shape.radius, piece.shape.paint);
    if piece.shape.edited {
        canvas.rect(piece.area, piece.shape.radius, theme::CHANGED);
    }
    content(canvas, piece);
    canvas.end();
}

/// Describes the plan for readers who do not see it: its steps in order, with their branches.
fn description(diagram: &Diagram) -> String {
    if diagram.nodes.is_empty() {
        return "There is nothing to do.".to_owned();
    }
    let mut telling = Telling::default();
    telling.nodes(&diagram.nodes);
    telling.sentences.join(" ")
}

/// Sentences about a plan.
#[derive(Default)]
struct Telling {
    sentences: Vec<String>,
    /// The words that lead on, if anything follows.
    then: Option<&'static str>,
}

impl Telling {
    fn say(&mut self, sentence: String) {
        self.sentences.extend(self.then.take().map(str::to_owned));
        self.sentences.push(sentence);
    }

    fn steps<'s>(&mut self, steps: impl IntoIterator<Item = &'s StepNode>) {
        for step in steps {
            self.say(format!("{}. {}.", step.number, step.text));
        }
    }

    fn nodes(&mut self, nodes: &[DiagramNode]) {
        for node in nodes {
            self.node(node);
        }
    }

    fn node(&mut self, node: &DiagramNode) {
        match node {
            DiagramNode::Step(step) => self.steps([step]),
            DiagramNode::Branch {
                condition,
                sensing,
                then,
                other,
                ..
            } => {
                self.steps(sensing);
                self.say(format!("If {condition}:"));
                self.nodes(then);
                self.then = None;
                self.say(
                    if other.is_empty() {
                        "Otherwise nothing."
                    } else {
                        "Otherwise:"
                    }
                    .to_owned(),
                );
                self.nodes(other);
                self.then = Some("In both cases:");
            }
            DiagramNode::Loop {
                condition,
                sensing,
                body,
            } => {
                self.say(format!("Again as long as {condition}:"));
                self.steps(sensing);
                self.nodes(body);
                self.then = Some("After that:");
            }
            DiagramNode::Repeat { times, body } => {
                self.say(format!("{times} times:"));
                self.nodes(body);
                self.then = Some("After that:");
            }
            DiagramNode::Lanes { lanes, rows } => {
                self.say(format!("At the same time, {}:", lanes.join(" and ")));
                for row in rows {
                    if let LaneRow::Unit { cells } = row {
                        self.steps(cells.iter().flatten());
                    }
                }
                self.then = Some("After that:");
            }
            DiagramNode::Remark { text } => self.say(text.clone()),
        }
    }
}
