//! A diagram as SVG.

use super::layout::whole;
use super::piece::Piece;
use super::{Diagram, DiagramNode, LaneRow};
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
    let mut sentences = Vec::new();
    if diagram.nodes.is_empty() {
        sentences.push("There is nothing to do.".to_owned());
    }
    describe(&diagram.nodes, &mut sentences);
    sentences.join(" ")
}

fn describe(nodes: &[DiagramNode], sentences: &mut Vec<String>) {
    for node in nodes {
        match node {
            DiagramNode::Step(step) => sentences.push(format!("{}. {}.", step.number, step.text)),
            DiagramNode::Branch {
                condition,
                sensing,
                then,
                other,
                ..
            } => {
                sentences.extend(sensing.iter().map(|step| format!("{}. {}.", step.number, step.text)));
                sentences.push(format!("If {condition}:"));
                describe(then, sentences);
                sentences.push("Otherwise:".to_owned());
                describe(other, sentences);
                sentences.push("In both cases:".to_owned());
            }
            DiagramNode::Loop {
                condition,
                sensing,
                body,
            } => {
                sentences.push(format!("Again as long as {condition}:"));
                sentences.extend(sensing.iter().map(|step| format!("{}. {}.", step.number, step.text)));
                describe(body, sentences);
                sentences.push("After that:".to_owned());
            }
            DiagramNode::Repeat { times, body } => {
                sentences.push(format!("{times} times:"));
                describe(body, sentences);
                sentences.push("After that:".to_owned());
            }
            DiagramNode::Lanes { lanes, rows } => {
                sentences.push(format!("At the same time, {}:", lanes.join(" and ")));
                let cells = rows.iter().filter_map(|row| match row {
                    LaneRow::Unit { cells } => Some(cells.iter().flatten()),
                    _ => None,
                });
                sentences.extend(cells.flatten().map(|step| format!("{}. {}.", step.number, step.text)));
                sentences.push("After that:".to_owned());
            }
            DiagramNode::Remark { text } => sentences.push(text.clone()),
        }
    }
}
