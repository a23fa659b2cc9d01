//! The card of a step.

use super::StepNode;
use super::piece::{Piece, Shape, area, line_at, put};
use crate::draw::text::{Font, width};
use crate::draw::theme::{self, Paint};

const TEXT: Font = Font::regular(14.0);
const NUMBER: Font = Font::bold(12.0);
/// Font of details.
pub(super) const DETAIL: Font = Font::regular(12.0);

/// Width for the number of a step.
const NUMBER_WIDTH: f64 = 34.0;
/// Width from which the details of a step stand beside its text.
const BESIDE: f64 = 560.0;
/// Share of the width of a card for its text, where the details stand beside it.
const TEXT_SHARE: f64 = 0.44;
/// Lines of a text.
pub(super) const TEXT_LINES: usize = 4;
/// Lines of a detail.
pub(super) const DETAIL_LINES: usize = 3;
/// Changes that a card shows.
const CHANGES: usize = 4;

/// Lays out a step. The lane is shown where no heading shows it.
pub(super) fn card(step: &StepNode, full: f64, shows_lane: bool) -> Piece {
    let (paint, radius) = if step.senses {
        (theme::SENSING, 14.0)
    } else {
        (theme::CARD, 6.0)
    };
    let mut shape = Shape::new(paint, radius);
    shape.edited = step.edited.is_some();
    let mut piece = Piece::new(area(full, 0.0), shape);
    piece.step = Some(step.number);
    piece.title = Some(full_text(step));
    let (left, top, right) = (NUMBER_WIDTH + 4.0, 7.0, 10.0);
    let beside = full >= BESIDE;
    let room = full - left - right;
    let text_room = if beside { (room * TEXT_SHARE).floor() } else { room };
    let number = step.number.to_string();
    let indent = (NUMBER_WIDTH - width(&number, NUMBER)) / 2.0;
    piece
        .lines
        .push(line_at(indent.max(2.0), top + 1.0, number, NUMBER, theme::MUTED));
    let mut y = top;
    if let Some(lane) = step.lane.as_ref().filter(|_| shows_lane) {
        y = put(
            &mut piece.lines,
            (left, y),
            lane,
            DETAIL,
            theme::ROBOT_INK,
            text_room,
            1,
        );
    }
    y = put(
        &mut piece.lines,
        (left, y),
        &step.text,
        TEXT,
        theme::INK,
        text_room,
        TEXT_LINES,
    );
    let (x, mut below, detail_room) = if beside {
        (left + text_room + 12.0, top, room - text_room - 12.0)
    } else {
        (left, y + 2.0, room)
    };
    for (text, paint) in details(step) {
        below = put(
            &mut piece.lines,
            (x, below),
            &text,
            DETAIL,
            paint,
            detail_room,
            DETAIL_LINES,
        );
    }
    piece.area.height = y.max(below) + 7.0;
    piece
}

/// Returns the details of a step, with their paint.
fn details(step: &StepNode) -> Vec<(String, Paint)> {
    let mut details = Vec::new();
    let more = step.changes.len().saturating_sub(CHANGES);
    let changes = &step.changes[..step.changes.len() - more];
    details.extend(changes.iter().map(|text| (format!("→ {text}"), theme::INK)));
    if more > 0 {
        details.push((format!("→ and {more} more changes"), theme::INK));
    }
    if step.unreached {
        details.push(("no path reaches this step".to_owned(), theme::CHANGE_INK));
    }
    details.extend(step.brief_reason.iter().map(|text| (text.clone(), theme::MUTED)));
    details.extend(
        step.assumed
            .iter()
            .map(|text| (format!("assumed: {text}"), theme::MUTED)),
    );
    details.extend(
        step.edited
            .iter()
            .map(|text| (format!("edited: {text}"), theme::CHANGE_INK)),
    );
    details
}

/// Returns everything that is known of a step.
fn full_text(step: &StepNode) -> String {
    let mut parts = vec![format!("step {}: {}", step.number, step.text), step.call.clone()];
    parts.extend(step.lane.clone());
    parts.extend(step.changes.iter().cloned());
    parts.extend(step.reason.clone());
    parts.extend(step.assumed.iter().map(|text| format!("assumed: {text}")));
    parts.extend(step.edited.iter().map(|text| format!("edited: {text}")));
    parts.join("; ")
}
