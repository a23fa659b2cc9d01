//! `longstep show`: a plan as a tree, with the reason and the changes of every step.

use std::time::Instant;

use anyhow::Result;
use longstep::report::{Answer, Status};
use longstep_core::plan::OutlineLine;
use longstep_picture::plan::{Diagram, DiagramNode, LaneRow, StepNode};

use crate::arguments::ShowArguments;
use crate::draft::{Draft, timed_verdict};
use crate::output::{self, Item, Style, Tone, print_line};
use crate::{exit_code, show};

pub(crate) fn run(arguments: &ShowArguments) -> Result<u8> {
    let started = Instant::now();
    let draft = Draft::read(&arguments.draft)?;
    let assessment = draft.assessment();
    let answer = timed_verdict(&assessment, started);
    let code = exit_code::of_status(answer.status);
    let verified = assessment.verified();
    let mut assumed = Vec::new();
    let items = match &verified {
        Some(plan) => {
            let annotations = draft.annotations();
            let diagram = Diagram::of(plan, &annotations);
            assumed.extend(diagram.steps().iter().flat_map(|step| &step.assumed).cloned());
            let mut items = of_diagram(&diagram);
            items.extend(
                annotations
                    .goals
                    .iter()
                    .map(|goal| Item::new(Tone::Green, format!("goal reached: {goal}"))),
            );
            items
        }
        None => of_outline(&answer),
    };
    if answer.status != Status::Question && !answer.plan.instruction_summary.is_empty() {
        print_line!("{}", answer.plan.instruction_summary.bold());
    }
    let lines = output::tree(&items, output::columns(), output::draws_lines());
    let body = show::Body {
        lines: &lines,
        assumed: &assumed,
        has_violations: verified.is_none(),
        stated: draft.assumptions(),
    };
    show::answer_with(&answer, show::Changes::Shown, body);
    Ok(code)
}

/// Returns the items of a valid plan.
fn of_diagram(diagram: &Diagram) -> Vec<Item> {
    let mut items = nodes(&diagram.nodes);
    items.extend(diagram.left_out.iter().map(|step| left_out(step)));
    items
}

fn nodes(nodes: &[DiagramNode]) -> Vec<Item> {
    nodes.iter().flat_map(node).collect()
}

fn node(node: &DiagramNode) -> Vec<Item> {
    match node {
        DiagramNode::Step(own) => step(own),
        DiagramNode::Branch {
            condition,
            otherwise,
            sensing,
            then,
            other,
            ..
        } => {
            let mut items: Vec<Item> = sensing.iter().flat_map(step).collect();
            let case = |condition: &str, parts: &[DiagramNode]| {
                let inside = match parts {
                    [] => vec![Item::new(Tone::Dimmed, "nothing to do")],
                    parts => nodes(parts),
                };
                Item::new(Tone::Cyan, format!("if {condition}")).over(inside)
            };
            items.push(case(condition, then));
            items.push(case(otherwise, other));
            items
        }
        DiagramNode::Loop {
            condition,
            sensing,
            body,
            ..
        } => {
            let mut inside: Vec<Item> = sensing.iter().flat_map(step).collect();
            inside.extend(nodes(body));
            vec![Item::new(Tone::Cyan, format!("as long as {condition}")).over(inside)]
        }
        DiagramNode::Repeat { times, body, .. } => {
            vec![Item::new(Tone::Cyan, format!("{times} times")).over(nodes(body))]
        }
        DiagramNode::Lanes { lanes, rows, .. } => vec![side_by_side(lanes, rows)],
        DiagramNode::Remark { text, .. } => vec![Item::new(Tone::Dimmed, format!("# {text}"))],
        _ => Vec::new(),
    }
}

/// Returns a step, behind the steps that a repair left out before it.
fn step(step: &StepNode) -> Vec<Item> {
    let mut items: Vec<Item> = step.left_out.iter().map(|own| left_out(own)).collect();
    let mut item = Item::new(Tone::Plain, &step.text);
    item.mark = format!("{}.", step.number);
    item.notes.push((Tone::Dimmed, step.call.clone()));
    let change = |text: &String| (Tone::Green, format!("-> {text}"));
    item.notes.extend(step.changes.iter().map(change));
    let reason = step.brief_reason.iter();
    item.notes.extend(reason.map(|reason| (Tone::Dimmed, reason.clone())));
    let edited = step.edited.iter();
    item.notes
        .extend(edited.map(|edit| (Tone::Yellow, format!("edited: {edit}"))));
    let assumed = step.assumed.iter();
    item.notes
        .extend(assumed.map(|text| (Tone::Yellow, format!("assumed: {text}"))));
    if step.unreached {
        item.notes
            .push((Tone::Yellow, "no path through the plan reaches this step".to_owned()));
    }
    items.push(item);
    items
}

fn left_out(step: &str) -> Item {
    Item::new(Tone::Yellow, format!("left out: {step}"))
}

/// Returns lanes as one list of steps for each actor.
fn side_by_side(names: &[String], rows: &[LaneRow]) -> Item {
    let mut lanes: Vec<Vec<Item>> = vec![Vec::new(); names.len()];
    for row in rows {
        match row {
            LaneRow::Unit { cells, .. } => {
                for (lane, cell) in lanes.iter_mut().zip(cells) {
                    lane.extend(cell.iter().flat_map(step));
                }
            }
            LaneRow::Sync { name, lanes: met, .. } => {
                for own in met {
                    let others = met.iter().filter(|other| *other != own);
                    let others: Vec<&str> = others.map(|other| names[*other].as_str()).collect();
                    let text = format!("= {name}: waits for {}", others.join(" and "));
                    lanes[*own].push(Item::new(Tone::Cyan, text));
                }
            }
            LaneRow::Remark { lane, text, .. } => lanes[*lane].push(Item::new(Tone::Dimmed, format!("# {text}"))),
            _ => {}
        }
    }
    let lane = |(name, steps): (&String, Vec<Item>)| Item::new(Tone::Bold, name).over(steps);
    let children = names.iter().zip(lanes).map(lane).collect();
    Item::new(Tone::Cyan, "at the same time").over(children)
}

/// Returns the items of a plan that is not valid: its lines, with the violations at their steps.
fn of_outline(answer: &Answer) -> Vec<Item> {
    let mut lines = answer.outline.iter().peekable();
    let mut items = inside(&mut lines, 0, answer);
    let general = answer.violations.iter().filter(|violation| violation.step.is_none());
    items.extend(general.map(|violation| Item::new(Tone::Red, &violation.message)));
    items
}

/// Takes the lines of a depth, with those below them.
fn inside<'a>(
    lines: &mut std::iter::Peekable<impl Iterator<Item = &'a OutlineLine>>,
    depth: usize,
    answer: &Answer,
) -> Vec<Item> {
    let mut items = Vec::new();
    while let Some(line) = lines.next_if(|line| line.depth >= depth) {
        let mut item = of_line(line, answer);
        if lines.peek().is_some_and(|next| next.depth > line.depth) {
            item.children = inside(lines, line.depth + 1, answer);
        }
        items.push(item);
    }
    items
}

fn of_line(line: &OutlineLine, answer: &Answer) -> Item {
    let Some(step) = line.step else {
        return Item::new(Tone::Cyan, &line.text);
    };
    let violations: Vec<_> = answer
        .violations
        .iter()
        .filter(|violation| violation.step == Some(step))
        .collect();
    let tone = if violations.is_empty() { Tone::Plain } else { Tone::Red };
    let (text, call) = match line.explanation.as_str() {
        "" => (&line.text, None),
        _ => (&line.explanation, Some(&line.text)),
    };
    let mut item = Item::new(tone, text);
    item.mark = format!("{}.", step + 1);
    item.notes.extend(call.map(|call| (Tone::Dimmed, call.clone())));
    item.notes.extend(
        violations
            .iter()
            .map(|violation| (Tone::Red, violation.message.clone())),
    );
    item
}
