//! Scripts in a reply: in code blocks, or the whole reply.

use std::ops::Range;

use super::objects::no_step;
use super::stray::begins_with_ellipsis;
use super::unreadable::Unreadable;
use super::{Block, FoundPlan, around, blocks};
use crate::plan::{Node, PlanFile, TaskCohesion, Written, script};
use longstep_model::diagnostic::Position;
use longstep_model::literal::{FENCE, LeniencyKind, Notes};

/// Finds the script in a reply; none if the reply contains no script.
pub(super) fn find(text: &str) -> Option<Result<FoundPlan, Unreadable>> {
    let blocks: Vec<Block> = blocks(text)
        .filter(|block| is_meant(&text[block.inside.clone()]))
        .collect();
    if blocks.is_empty() {
        return (!text.contains(FENCE) && is_meant(text)).then(|| whole(text));
    }
    Some(fenced(text, &blocks))
}

fn whole(text: &str) -> Result<FoundPlan, Unreadable> {
    let written = part(text, 0..text.len())?;
    Ok(found(written, 0, Notes::default()))
}

fn fenced(text: &str, blocks: &[Block]) -> Result<FoundPlan, Unreadable> {
    let mut notes = Notes::default();
    let mut first: Option<(Written, &Block)> = None;
    let mut read_to = 0;
    for block in blocks {
        if !block.closed {
            return Err(Unreadable::CutOff {
                position: Position::of(text, text.len()),
                opened: Position::of(text, block.opened),
            });
        }
        around(text, read_to..block.inside.start, &mut notes);
        read_to = block.inside.end;
        let written = part(text, block.inside.clone())?;
        match &first {
            None => first = Some((written, block)),
            Some((same, _)) if *same == written => notes.add(LeniencyKind::RepeatedPlan, block.inside.start),
            Some((_, earlier)) => {
                return Err(Unreadable::SeveralPlans {
                    count: blocks.len(),
                    first: Position::of(text, earlier.inside.start),
                    other: Position::of(text, block.inside.start),
                });
            }
        }
    }
    around(text, read_to..text.len(), &mut notes);
    match first {
        Some((written, block)) => Ok(found(written, block.inside.start, notes)),
        None => Err(Unreadable::Empty),
    }
}

fn part(text: &str, inside: Range<usize>) -> Result<Written, Unreadable> {
    let mut at = inside.start;
    for line in text[inside.clone()].split_inclusive('\n') {
        let comment = line.trim_start().strip_prefix('#').map(str::trim_start);
        if comment.is_some_and(begins_with_ellipsis) {
            return Err(no_step(text, at + line.len() - line.trim_start().len(), line));
        }
        at += line.len();
    }
    script::read_part(text, inside).map_err(|error| Unreadable::Script { inside: None, error })
}

fn found(written: Written, start: usize, mut notes: Notes) -> FoundPlan {
    let remarks = written.body.iter().any(|node| matches!(node, Node::Remark(_)));
    let task_cohesion = TaskCohesion::from_written(written);
    if remarks && task_cohesion.task_tree.is_none() {
        notes.add(LeniencyKind::Comment, start);
    }
    FoundPlan {
        file: PlanFile::from(task_cohesion),
        start,
        notes,
    }
}

/// Returns true if the first line that is not a comment begins like a script statement or other Python code.
pub(super) fn is_meant(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let Some(line) = lines.find(|line| !line.starts_with('#')) else {
        return false;
    };
    let word_end = line
        .find(|c: char| !(c.is_alphanumeric() || c == '_'))
        .unwrap_or(line.len());
    let (word, rest) = line.split_at(word_end);
    let code = line.split('#').next().unwrap_or_default().trim_end();
    match word {
        "" => false,
        "if" | "while" | "for" | "with" => rest.starts_with([' ', '(']) && (code.ends_with(':') || code.contains("):")),
        "def" | "class" | "async" => code.ends_with(':'),
        "import" | "from" => code.split_whitespace().count() <= 4,
        "pass" => code == "pass",
        _ => rest.starts_with('(') || assigned(rest).is_some_and(|value| value.contains('(')),
    }
}

/// Returns the right-hand side of an assignment.
fn assigned(rest: &str) -> Option<&str> {
    let value = rest.trim_start().strip_prefix('=')?;
    (!value.starts_with('=') && !value.contains('{')).then_some(value)
}
