//! The text of a stream, put together from its deltas.

use longstep::dialogue::object_text;

/// Number of deltas, each of which begins with the one before, that are taken for the text so far.
const SURE: usize = 4;

/// A text that arrives in pieces. Most servers send what is new; some send the whole text so far in every delta.
#[derive(Debug, Default)]
pub(super) struct DeltaText {
    /// All deltas, one after another.
    appended: String,
    /// The last delta.
    last: String,
    /// Number of deltas.
    deltas: usize,
    /// True while every delta begins with the one before.
    is_growing: bool,
}

impl DeltaText {
    pub(super) fn push(&mut self, delta: &str) {
        if delta.is_empty() {
            return;
        }
        self.is_growing = self.deltas == 0 || self.is_growing && delta.starts_with(&self.last);
        self.deltas += 1;
        self.appended.push_str(delta);
        self.last.clear();
        self.last.push_str(delta);
    }

    /// Bytes of the text so far.
    pub(super) fn length(&self) -> usize {
        if self.is_cumulative() {
            self.last.len()
        } else {
            self.appended.len()
        }
    }

    pub(super) fn is_blank(&self) -> bool {
        self.appended.trim().is_empty()
    }

    /// The text. Few deltas that may be either are the text so far if the last one alone has an object.
    pub(super) fn text(self) -> String {
        let may_be = self.is_growing && self.deltas > 1;
        let is_cumulative = self.is_cumulative() || may_be && object_text(&self.last).is_some();
        if is_cumulative { self.last } else { self.appended }
    }

    /// True for many deltas that repeat each other. Equal deltas say nothing, such as a run of blanks.
    fn is_cumulative(&self) -> bool {
        self.is_growing && self.deltas >= SURE && self.last.len() * self.deltas > self.appended.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deltas_are_new_text_or_the_text_so_far() {
        for (deltas, expected) in [
            (&["{\"a\"", ": 1}"][..], "{\"a\": 1}"),
            (&["{\"a\"", "", "{\"a\": 1}"], "{\"a\": 1}"),
            (&["{", "{\"a\"", "{\"a\": 1", "{\"a\": 1}", "{\"a\": 1}"], "{\"a\": 1}"),
            (&["Put", "Put it", "Put it do", "Put it down"], "Put it down"),
            // A run of equal tokens.
            (&["ha", "ha", "ha", "ha", "ha"], "hahahahaha"),
            (&[" ", " ", " ", " ", "x"], "    x"),
            (&["a", "ab"], "aab"),
            (&["{\"a\": 1}"], "{\"a\": 1}"),
            (&[], ""),
        ] {
            let mut text = DeltaText::default();
            deltas.iter().for_each(|delta| text.push(delta));
            assert_eq!(text.text(), expected, "{deltas:?}");
        }
    }

    #[test]
    fn the_length_of_a_text_so_far_is_that_of_its_last_delta() {
        let mut text = DeltaText::default();
        (1..=100).for_each(|length| text.push(&"x".repeat(length)));
        assert_eq!((text.length(), text.text().len()), (100, 100));
    }
}
