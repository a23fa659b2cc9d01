//! Steps in the columns of a table, in Markdown or CSV: one column has the action, the others its arguments.

use super::FoundPlan;
use super::objects::no_step;
use super::step_value::{ACTION_KEYS, COUNT_KEYS, EXPLANATION_KEYS, add_arguments, bare_step, snake_case};
use super::unreadable::Unreadable;
use crate::plan::WrittenStep;
use longstep_model::literal::{FENCE, LeniencyKind, LiteralValue, Notes};

/// Finds the only table of a text whose heads name an action and arguments; none without one.
pub(super) fn find(text: &str) -> Option<Result<FoundPlan, Unreadable>> {
    let mut columns: Option<(usize, Vec<Column>, char)> = None;
    let mut steps = Vec::new();
    let mut at = 0;
    let mut is_over = false;
    for line in text.split_inclusive('\n') {
        let start = at;
        at += line.len();
        let bare = line.trim();
        let Some((_, heads, sign)) = &columns else {
            columns = heads_of(bare).map(|(heads, sign)| (start, heads, sign));
            continue;
        };
        let is_row = bare.contains(*sign) && !bare.starts_with(FENCE);
        if bare.chars().all(|c| matches!(c, '|' | '-' | ':' | ' ')) && *sign == '|' && is_row {
            continue;
        }
        is_over |= !is_row;
        if !is_row {
            continue;
        }
        let step = step_of_row(heads, &cells(bare, *sign)).filter(|_| !is_over);
        let Some(step) = step else {
            return Some(Err(no_step(text, start, bare)));
        };
        steps.push(step);
    }
    let (start, ..) = columns?;
    if steps.is_empty() {
        return None;
    }
    let mut notes = Notes::default();
    notes.add(LeniencyKind::Notation("a table with columns"), start);
    Some(FoundPlan::of_steps(text, steps, start, notes))
}

/// Returns the columns of a row of heads, and the sign between its cells.
fn heads_of(line: &str) -> Option<(Vec<Column>, char)> {
    ['|', ',', ';', '\t'].into_iter().find_map(|sign| {
        let heads: Vec<Column> = cells(line, sign).iter().map(|head| Column::of_head(head)).collect();
        let actions = heads.iter().filter(|head| **head == Column::Action).count();
        let has_arguments = heads.contains(&Column::Argument);
        (actions == 1 && has_arguments && line.contains(sign)).then_some((heads, sign))
    })
}

fn cells(line: &str, sign: char) -> Vec<&str> {
    let line = match sign {
        '|' => line.trim_matches('|'),
        _ => line,
    };
    let is_mark = |c: char| matches!(c, '*' | '`' | '"') || c.is_whitespace();
    line.split(sign).map(|cell| cell.trim_matches(is_mark)).collect()
}

/// The part of a step that a column of a table has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Action,
    /// One argument, or several with commas between them.
    Argument,
    Explanation,
    Count,
}

impl Column {
    /// Returns the meaning of a column by its head; the heads are the keys of an object that is a step.
    fn of_head(head: &str) -> Self {
        let head = snake_case(head);
        let is_key = |keys: &[&str]| keys.contains(&head.as_str());
        if head.is_empty() || head == "#" || is_key(&COUNT_KEYS) {
            Self::Count
        } else if is_key(&ACTION_KEYS) {
            Self::Action
        } else if is_key(&EXPLANATION_KEYS) {
            Self::Explanation
        } else {
            Self::Argument
        }
    }
}

/// Returns the step of a row: its arguments stand in the order of the columns.
fn step_of_row(columns: &[Column], cells: &[&str]) -> Option<WrittenStep> {
    let own = |column: Column| {
        let cells = columns.iter().zip(cells);
        cells.filter(move |(own, _)| **own == column).map(|(_, cell)| *cell)
    };
    if cells.len() != columns.len() {
        return None;
    }
    let mut step = bare_step(own(Column::Action).next()?)?;
    for cell in own(Column::Argument).filter(|cell| !matches!(*cell, "" | "-" | "\u{2013}" | "\u{2014}")) {
        add_arguments(&mut step, &LiteralValue::Text(cell.to_owned()))?;
    }
    step.explanation = own(Column::Explanation).collect::<Vec<_>>().join("; ");
    Some(step)
}
