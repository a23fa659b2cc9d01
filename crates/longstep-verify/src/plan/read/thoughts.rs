//! Thoughts of a model around its answer.

use std::borrow::Cow;
use std::ops::Range;

/// Tags that enclose thoughts.
const TAGS: [(&str, &str); 4] = [
    ("<think>", "</think>"),
    ("<thinking>", "</thinking>"),
    ("<thought>", "</thought>"),
    ("<reasoning>", "</reasoning>"),
];

/// The mark before the last message of an answer in channels.
const CHANNEL: &str = "<|message|>";

/// Returns the parts of a reply that are thoughts, in order. Thoughts without an opening tag begin with the reply, and thoughts
/// without a closing tag end with it.
fn ranges(text: &str) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    if text.contains("<|channel|>")
        && let Some(at) = text.rfind(CHANNEL)
    {
        found.push(0..at + CHANNEL.len());
    }
    for (open, close) in TAGS {
        let (mut at, mut without_begin) = (0, 0);
        loop {
            let opened = text[at..].find(open).map_or(text.len(), |place| at + place);
            // Ends before the next begin have none; the last of them counts.
            if let Some(place) = text[at..opened].rfind(close) {
                without_begin = at + place + close.len();
            }
            if opened == text.len() {
                break;
            }
            let closed = text[opened..].find(close).map(|place| opened + place + close.len());
            found.push(opened..closed.unwrap_or(text.len()));
            at = closed.unwrap_or(text.len());
        }
        if without_begin > 0 {
            found.push(0..without_begin);
        }
    }
    found
}

/// Returns the text with blanks in place of the thoughts, and of the same length, with the place of the first of them.
pub(super) fn blanked(text: &str) -> (Cow<'_, str>, Option<usize>) {
    let ranges = ranges(text);
    let first = ranges.iter().map(|range| range.start).min();
    (blank(text, &ranges), first)
}

/// Returns the text with blanks in place of some parts; line breaks and the length stay.
pub(super) fn blank<'t>(text: &'t str, parts: &[Range<usize>]) -> Cow<'t, str> {
    if parts.is_empty() {
        return Cow::Borrowed(text);
    }
    let mut shown = text.to_owned().into_bytes();
    for part in parts {
        for byte in &mut shown[part.clone()] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
    }
    // Whole characters were replaced, so the text is still UTF-8.
    Cow::Owned(String::from_utf8(shown).unwrap_or_default())
}
