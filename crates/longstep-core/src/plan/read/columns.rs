//! Steps in the columns of a table, in Markdown or CSV: one column has the action, the others its arguments.

use super::Found;
use super::objects::beginning;
use super::step_value::{Column, step_of_row};
use super::unreadable::Unreadable;
use crate::diagnostic::Position;
use crate::literal::{FENCE, LeniencyKind, Notes};

/// Finds the only table of a text whose heads name an action and arguments; none without one.
pub(super) fn find(text: &str) -> Option<Result<Found, Unreadable>> {
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
            let (position, text) = (Position::of(text, start), beginning(bare));
            return Some(Err(Unreadable::NoStep { position, text }));
        };
        steps.push(step);
    }
    let (start, ..) = columns?;
    if steps.is_empty() {
        return None;
    }
    let mut notes = Notes::default();
    notes.add(LeniencyKind::Notation("a table with columns"), start);
    Some(Found::of_steps(text, steps, start, notes))
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
