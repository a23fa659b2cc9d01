//! Parallel plans: a column for each actor, a line for each unit of time.

use longstep::report::Answer;
use longstep_core::environment::World;
use longstep_core::plan::{Lane, Node, Plan, StepId};
use longstep_core::schedule::{self, Row};
use longstep_core::verify::{Purpose, VerifiedPlan};
use longstep_core::visible;

use crate::output::{Line, Style, composed, wrapped};

/// Width of a line in characters.
const WIDTH: usize = 80;

/// Characters for the numbers of units and the space after them.
const MARGIN: usize = 6;

/// Distributes the steps of a plan over its actors and replaces the plan in the answer. Returns the lines to print;
/// empty if no parallel plan was found.
pub(crate) fn side_by_side(world: &World, plan: &VerifiedPlan, purpose: &Purpose, answer: &mut Answer) -> Vec<Line> {
    match schedule::share(world, plan, purpose) {
        Some(compacted) => {
            answer.side_by_side(world, &compacted);
            shown(world, compacted.plan.plan())
        }
        None => {
            let note = format!("no parallel plan was found: {}", schedule::makespan(plan.plan()));
            answer.notes.push(note);
            Vec::new()
        }
    }
}

/// The lines of a parallel plan.
fn shown(world: &World, plan: &Plan) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut unit = 0;
    for node in plan.body() {
        match node {
            Node::Step(id) => {
                unit += 1;
                let texts = wrapped(&explanation(plan, *id), WIDTH - MARGIN);
                lines.extend(line(unit, &[texts], WIDTH - MARGIN));
            }
            Node::Parallel { lanes } => lines.extend(beside(world, plan, lanes, &mut unit)),
            // A compacted list has no other nodes.
            _ => {}
        }
    }
    lines
}

/// The explanation of a step.
fn explanation(plan: &Plan, id: StepId) -> String {
    visible::line(&plan.step(id).explanation).into_owned()
}

fn beside(world: &World, plan: &Plan, lanes: &[Lane], unit: &mut usize) -> Vec<Line> {
    let column = (WIDTH - MARGIN).saturating_sub(2 * (lanes.len() - 1)) / lanes.len();
    let mut heads = composed!("{:MARGIN$}", "");
    for (place, lane) in lanes.iter().enumerate() {
        let name = visible::line(&world.entity(lane.actor).name);
        if place + 1 == lanes.len() {
            heads.push(format_args!("{}", name.bold()))
        } else {
            let padding = column.saturating_sub(name.chars().count()) + 2;
            heads.push(format_args!("{}{:padding$}", name.bold(), ""));
        }
    }
    let mut lines = vec![heads];
    for row in schedule::timetable(lanes) {
        match row {
            Row::Unit(steps) => {
                *unit += 1;
                let cells = steps.iter().map(|step| match step {
                    Some(id) => wrapped(&explanation(plan, *id), column),
                    None => vec![String::new()],
                });
                lines.extend(line(*unit, &cells.collect::<Vec<_>>(), column));
            }
            Row::Sync { name, lanes: met } => {
                let cells = (0..lanes.len()).map(|lane| {
                    if met.contains(&lane) {
                        format!(
                            "--- {name} {}",
                            "-".repeat(column.saturating_sub(name.chars().count() + 5))
                        )
                    } else {
                        " ".repeat(column)
                    }
                });
                let cells: Vec<String> = cells.collect();
                lines.push(composed!("{:MARGIN$}{}", "", cells.join("  ").trim_end().dimmed()));
            }
        }
    }
    lines
}

/// The lines for one unit of time: its cells side by side, each with its own wrapped lines.
fn line(unit: usize, cells: &[Vec<String>], column: usize) -> Vec<Line> {
    let height = cells.iter().map(Vec::len).max().unwrap_or(0);
    let of = |row: usize| {
        let number = match row {
            0 => format!("{unit:>3}."),
            _ => "    ".to_owned(),
        };
        let texts = cells.iter().map(|cell| cell.get(row).map_or("", String::as_str));
        let padded: Vec<String> = texts.map(|text| format!("{text:column$}")).collect();
        composed!("{}  {}", number.dimmed(), padded.join("  ").trim_end())
    };
    (0..height).map(of).collect()
}
