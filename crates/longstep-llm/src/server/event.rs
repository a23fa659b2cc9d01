//! Reader of server-sent events.
//!
//! It keeps one line and one event, both with a limit, so a server cannot exhaust memory. The crates for this format
//! have no such limits.

use std::str::Utf8Error;

use serde::de::IgnoredAny;

use super::limit::{COMPLAINT_BYTES, EVENT_BYTES, LINES};
use crate::AnswerLimit;

/// The name of an event that reports an error.
pub(super) const ERROR: &str = "error";

/// An event of a stream.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Event {
    /// The value of the last `event` field; empty if there is none.
    pub(super) name: String,
    /// The values of the `data` fields, joined with line ends.
    pub(super) data: String,
}

/// Reason why reading a stream stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Broken {
    TooLarge(AnswerLimit),
    NoText(Utf8Error),
}

/// Reads events from the chunks of a stream, at any chunk boundaries.
#[derive(Debug, Default)]
pub(super) struct EventReader {
    /// The incomplete line.
    line: Vec<u8>,
    /// The incomplete event.
    event: Event,
    lines: u64,
    /// The first lines that belong to no event: the body of a server that streams nothing.
    stray: String,
    /// True if a line alone may be an event: Ollama's own streams have an object in each line.
    has_bare_lines: bool,
    /// The last byte was a carriage return: a line feed after it belongs to the same line end.
    after_return: bool,
}

impl EventReader {
    /// A reader for streams with an object in each line, which may also have events.
    pub(super) fn of_lines() -> Self {
        Self {
            has_bare_lines: true,
            ..Self::default()
        }
    }

    /// Consumes `input` until an event is complete. Returns `None` when all of it is consumed.
    pub(super) fn next(&mut self, input: &mut &[u8]) -> Result<Option<Event>, Broken> {
        while let Some(&first) = input.first() {
            if std::mem::take(&mut self.after_return) && first == b'\n' {
                *input = input.get(1..).unwrap_or_default();
                continue;
            }
            let end = input.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let (part, rest) = input.split_at(end.unwrap_or(input.len()));
            if self.line.len() + part.len() > EVENT_BYTES {
                return Err(Broken::TooLarge(AnswerLimit::LineBytes(EVENT_BYTES as u64)));
            }
            self.line.extend_from_slice(part);
            self.after_return = rest.first() == Some(&b'\r');
            *input = rest.get(1..).unwrap_or_default();
            if end.is_some()
                && let Some(event) = self.end_line()?
            {
                return Ok(Some(event));
            }
        }
        Ok(None)
    }

    /// Returns the event that the end of the stream completes. The format requires an empty line after every event, but
    /// not all servers write the last one.
    pub(super) fn end(&mut self) -> Result<Option<Event>, Broken> {
        if !self.line.is_empty()
            && let Some(event) = self.end_line()?
        {
            return Ok(Some(event));
        }
        Ok(self.complete())
    }

    fn end_line(&mut self) -> Result<Option<Event>, Broken> {
        self.lines += 1;
        if self.lines > LINES {
            return Err(Broken::TooLarge(AnswerLimit::Lines(LINES)));
        }
        let line = std::mem::take(&mut self.line);
        let text = std::str::from_utf8(&line).map_err(Broken::NoText)?;
        let text = text.trim_start_matches('\u{feff}').trim();
        if text.is_empty() {
            return Ok(self.complete());
        }
        if let Some(data) = text.strip_prefix("data:") {
            let data = data.trim();
            if self.is_whole() && (data.starts_with('{') || data == "[DONE]") {
                let data = data.to_owned();
                let whole = std::mem::take(&mut self.event);
                self.event.data = data;
                return Ok(Some(whole));
            }
            if self.event.data.len() + data.len() > EVENT_BYTES {
                return Err(Broken::TooLarge(AnswerLimit::EventBytes(EVENT_BYTES as u64)));
            }
            if !self.event.data.is_empty() {
                self.event.data.push('\n');
            }
            self.event.data.push_str(data);
        } else if let Some(name) = text.strip_prefix("event:") {
            self.event.name = name.trim().to_owned();
        } else if let Some(error) = text.strip_prefix("error:") {
            // The form of older llama.cpp.
            let whole = std::mem::take(&mut self.event);
            self.event = Event {
                name: ERROR.to_owned(),
                data: error.trim().to_owned(),
            };
            return Ok(Some(whole).filter(|event| !event.data.is_empty()));
        } else if self.has_bare_lines && text.starts_with('{') {
            return Ok(Some(Event {
                name: String::new(),
                data: text.to_owned(),
            }));
        } else if !text.starts_with(':') && self.stray.len() + text.len() < COMPLAINT_BYTES {
            self.stray.push_str(text);
            self.stray.push('\n');
        }
        Ok(None)
    }

    /// Returns true if the data so far are a whole event: some servers write one line end between events.
    fn is_whole(&self) -> bool {
        const MOST: usize = 16 << 10;
        let data = &self.event.data;
        data.ends_with('}') && data.len() <= MOST && serde_json::from_str::<IgnoredAny>(data).is_ok()
    }

    /// The beginning of what was no event.
    pub(super) fn stray(&self) -> &str {
        self.stray.trim()
    }

    fn complete(&mut self) -> Option<Event> {
        let event = std::mem::take(&mut self.event);
        Some(event).filter(|event| !event.data.is_empty())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Reads a stream in chunks of this size: names and data of its events, or the error.
    fn read(stream: &[u8], piece: usize) -> Result<Vec<(String, String)>, Broken> {
        let mut reader = EventReader::default();
        let mut events = Vec::new();
        for mut piece in stream.chunks(piece) {
            while let Some(event) = reader.next(&mut piece)? {
                events.push((event.name, event.data));
            }
        }
        events.extend(reader.end()?.map(|event| (event.name, event.data)));
        Ok(events)
    }

    #[test]
    fn events_are_read_wherever_the_stream_is_cut() {
        for (stream, expected) in [
            ("data: a\n\ndata: b\n\n", vec![("", "a"), ("", "b")]),
            ("data: a\r\n\r\ndata:b\r\n\r\n", vec![("", "a"), ("", "b")]),
            ("data: a\r\rdata: b\r\r", vec![("", "a"), ("", "b")]),
            ("event: x\ndata: a\ndata: b\n\n", vec![("x", "a\nb")]),
            (": comment\n\n\n\nid: 1\nretry: 2\n\ndata: ä€😀\n\n", vec![("", "ä€😀")]),
            // Without the last empty line; without the last line end.
            ("data: a\n", vec![("", "a")]),
            ("data: [DONE]", vec![("", "[DONE]")]),
            ("<html>hello</html>", vec![]),
            ("\u{feff}data: a\n\n", vec![("", "a")]),
            // One line end between events, and an event of two lines.
            (
                "data: {\"a\":1}\ndata: {\"b\":2}\ndata: [DONE]\n\n",
                vec![("", "{\"a\":1}"), ("", "{\"b\":2}"), ("", "[DONE]")],
            ),
            ("data: {\"a\":\ndata: 1}\n\n", vec![("", "{\"a\":\n1}")]),
            (
                "error: {\"code\":400}\n\ndata: [DONE]\n\n",
                vec![("error", "{\"code\":400}"), ("", "[DONE]")],
            ),
            ("", vec![]),
        ] {
            let expected: Vec<(String, String)> = expected
                .into_iter()
                .map(|(name, data)| (name.to_owned(), data.to_owned()))
                .collect();
            for piece in 1..=stream.len().max(1) {
                assert_eq!(read(stream.as_bytes(), piece).unwrap(), expected, "{stream:?} {piece}");
            }
        }
    }

    #[test]
    fn every_part_of_a_stream_has_a_limit() {
        let line = b"data: ".repeat(EVENT_BYTES / 6 + 1);
        let event = format!("data: {}\n", "x".repeat(1000)).repeat(EVENT_BYTES / 1000 + 1);
        let lines = vec![b'\n'; LINES as usize + 1];
        let most = EVENT_BYTES as u64;
        for (stream, expected) in [
            (line.as_slice(), AnswerLimit::LineBytes(most)),
            (event.as_bytes(), AnswerLimit::EventBytes(most)),
            (&lines, AnswerLimit::Lines(LINES)),
        ] {
            assert_eq!(read(stream, 4096), Err(Broken::TooLarge(expected)));
        }
        assert!(matches!(read(b"data: \xff\xfe\n\n", 100), Err(Broken::NoText(_))));
        assert!(matches!(read(b"data: \xe2\x82", 3), Err(Broken::NoText(_))));
    }
}
