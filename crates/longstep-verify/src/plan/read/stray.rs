//! Calls in the words around steps: nothing that may be a step is left out of a plan without a word.

use rustc_hash::FxHashSet;

use super::line::call_length;
use crate::plan::WrittenStep;
use longstep_model::call::Call;

/// The number of calls in a line of words that are looked at: each takes a pass over the line.
const MOST: usize = 16;

/// The calls that a plan has, without their signs.
pub(super) struct Known(FxHashSet<(String, Vec<String>)>);

impl Known {
    pub(super) fn new<'s>(steps: impl Iterator<Item = &'s WrittenStep>) -> Self {
        Self(steps.map(|step| bare(&step.call)).collect())
    }

    /// Returns the first call in words that is no step of the plan, with its place. A call that does not end is one.
    pub(super) fn stray<'t>(&self, words: &'t str) -> Option<(usize, &'t str)> {
        calls(words).take(MOST).find(|(_, text)| {
            let is_known = |call: Call| self.0.contains(&bare(&call));
            !Call::parse(text).is_ok_and(is_known)
        })
    }
}

/// Returns the name and the arguments of a call without brackets and quotes.
fn bare(call: &Call) -> (String, Vec<String>) {
    let is_sign = |c: char| matches!(c, '<' | '>' | '"' | '\'' | '`') || c.is_whitespace();
    let argument = |argument: &String| argument.trim_matches(is_sign).to_owned();
    (call.name.to_lowercase(), call.arguments.iter().map(argument).collect())
}

/// Iterates over what is written like a call: a name directly before a bracket. `step(s)` is a word.
fn calls(words: &str) -> impl Iterator<Item = (usize, &str)> {
    let in_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-');
    words.match_indices('(').filter_map(move |(bracket, _)| {
        let name = words[..bracket].trim_end_matches(in_name).len();
        let text = &words[name..];
        if !text.starts_with(char::is_alphabetic) {
            return None;
        }
        let inside = &words[bracket + 1..];
        let ending = inside.trim_start_matches(char::is_alphabetic);
        if ending.starts_with(')') && (1..=2).contains(&inside[..inside.len() - ending.len()].chars().count()) {
            return None;
        }
        Some((name, call_length(text).map_or(text, |length| &text[..length])))
    })
}

/// Returns true for words that stand for steps which were left out.
pub(super) fn begins_with_ellipsis(words: &str) -> bool {
    words.starts_with("...") || words.starts_with('\u{2026}')
}

/// Returns true for words that may be a step without brackets, `Close <cabinet_7>`, or that stand for steps: `...`.
pub(super) fn may_be_steps(words: &str) -> bool {
    let is_mark = |c: char| matches!(c, '#' | '-' | '*' | '>' | '/' | '(' | '[') || c.is_whitespace();
    let words = words.trim().trim_start_matches(is_mark);
    let mut parts = words.split_whitespace();
    let is_verb = |verb: &str| verb.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-'));
    let begins = parts.next().is_some_and(is_verb);
    let mut named = parts.peekable();
    let is_entity = |part: &str| {
        let part = part.trim_end_matches(|c: char| c.is_ascii_punctuation() && c != '>');
        part.starts_with('<') && part.ends_with('>')
    };
    begins_with_ellipsis(words) || (begins && named.peek().is_some() && named.all(is_entity))
}
