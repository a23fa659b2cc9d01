//! Removes keys and passwords from a server's texts, in any encoding.

use std::fmt;

/// Shorter values are placeholders such as `none` and `EMPTY`, which may occur in replies.
const KEY_LENGTH: usize = 8;

/// Minimal length at which a truncated key is recognized at the end of a text.
const PREFIX: usize = 4;

/// Replacement of a secret.
const REDACTED: &str = "[key]";

/// The secrets of an endpoint, in the encodings in which a server may repeat them: plain, percent-encoded, escaped for
/// JSON, Python or HTML, as hexadecimal digits, or base64 anywhere inside a longer text (`user:password`).
#[derive(Clone, Default)]
pub(super) struct Redaction {
    patterns: Vec<Pattern>,
}

/// Kind of text.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Text {
    /// An error message of a server.
    Message,
    /// A reply of a model.
    Reply,
}

#[derive(Clone)]
struct Pattern {
    bytes: Vec<u8>,
    form: Form,
    /// True if the secret is long enough to be removed from replies, too.
    is_key: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Form {
    Plain,
    Hexadecimal,
    Base64,
}

impl Redaction {
    /// Redaction of these secrets.
    pub(super) fn of<'s>(secrets: impl IntoIterator<Item = &'s str>) -> Self {
        let mut patterns = Vec::new();
        for secret in secrets.into_iter().filter(|secret| !secret.is_empty()) {
            let is_key = secret.len() >= KEY_LENGTH;
            let mut add = |bytes: Vec<u8>, form| patterns.push(Pattern { bytes, form, is_key });
            add(secret.as_bytes().to_vec(), Form::Plain);
            if is_key {
                let digits: String = secret.bytes().map(|byte| format!("{byte:02x}")).collect();
                add(digits.into_bytes(), Form::Hexadecimal);
                (0..3).for_each(|before| add(base64_core(secret.as_bytes(), before), Form::Base64));
            }
        }
        Self { patterns }
    }

    /// Returns a server's error message without secrets.
    pub(super) fn of_message(&self, text: &str) -> String {
        self.redacted(text, Text::Message)
    }

    /// Returns a model's reply without keys.
    pub(super) fn of_reply(&self, text: &str) -> String {
        self.redacted(text, Text::Reply)
    }

    fn redacted(&self, text: &str, of: Text) -> String {
        let mut text = text.to_owned();
        for pattern in self
            .patterns
            .iter()
            .filter(|pattern| of == Text::Message || pattern.is_key)
        {
            text = pattern.redacted(&text, of);
        }
        text
    }
}

impl fmt::Debug for Redaction {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(REDACTED)
    }
}

impl Pattern {
    fn redacted(&self, text: &str, of: Text) -> String {
        let mut shown = String::with_capacity(text.len());
        let mut at = 0;
        while let Some(next) = text.get(at..).and_then(|rest| rest.chars().next()) {
            match self.found(text.as_bytes(), at, of) {
                Some(mut end) => {
                    if self.form == Form::Base64 {
                        // The neighbouring characters contain bits of the key as well.
                        let kept = shown.trim_end_matches(is_base64).len();
                        shown.truncate(kept);
                        end += text
                            .get(end..)
                            .map_or(0, |rest| rest.len() - rest.trim_start_matches(is_base64).len());
                    }
                    shown.push_str(REDACTED);
                    at = end;
                }
                None => {
                    shown.push(next);
                    at += next.len_utf8();
                }
            }
        }
        shown
    }

    /// Returns the end of the pattern if it begins at `start`: complete, or truncated at the end of a message.
    fn found(&self, text: &[u8], start: usize, of: Text) -> Option<usize> {
        let cut_off = |matched| of == Text::Message && matched >= PREFIX;
        let mut at = start;
        for (matched, wanted) in self.bytes.iter().enumerate() {
            let rest = text.get(at..).unwrap_or_default();
            if rest.is_empty() {
                return cut_off(matched).then_some(at);
            }
            let literal = rest.first().copied().map(|byte| (byte, 1));
            let units = [escape(rest), literal];
            let fits = units.into_iter().flatten().find(|(byte, _)| self.same(*byte, *wanted));
            match fits {
                Some((_, length)) => at += length,
                // An escape may be truncated, too.
                None if cut_off(matched) && rest.len() < 6 && matches!(rest.first(), Some(b'%' | b'\\' | b'&')) => {
                    return std::str::from_utf8(rest).is_ok().then_some(text.len());
                }
                None => return None,
            }
        }
        Some(at)
    }

    fn same(&self, found: u8, wanted: u8) -> bool {
        match self.form {
            Form::Plain => found == wanted,
            Form::Hexadecimal => found.eq_ignore_ascii_case(&wanted),
            Form::Base64 => found == wanted || matches!((found, wanted), (b'-', b'+') | (b'_', b'/')),
        }
    }
}

fn is_base64(character: char) -> bool {
    character.is_ascii_alphanumeric() || matches!(character, '+' | '/' | '-' | '_' | '=')
}

/// The byte of an escape sequence at the beginning of the text, and the length of the sequence.
fn escape(text: &[u8]) -> Option<(u8, usize)> {
    let number = |from: usize, to: usize, base: u32| {
        let digits = std::str::from_utf8(text.get(from..to)?).ok()?;
        let plain = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
        u8::from_str_radix(digits, base).ok().filter(|_| plain)
    };
    match text {
        [b'%', ..] => {
            let again = text.get(1..).unwrap_or_default().chunks(2);
            let again = 2 * again.take_while(|digits| *digits == b"25").count();
            let twice = (again > 0).then(|| Some((number(again + 1, again + 3, 16)?, again + 3)));
            twice.flatten().or_else(|| Some((number(1, 3, 16)?, 3)))
        }
        [b'\\', ..] => {
            // A nested string has doubled backslashes.
            let at = text.iter().position(|byte| *byte != b'\\')?;
            match text.get(at..)? {
                [b'u', b'0', b'0', ..] => Some((number(at + 3, at + 5, 16)?, at + 5)),
                [b'x', ..] => Some((number(at + 1, at + 3, 16)?, at + 3)),
                [other @ (b'/' | b'"' | b'\''), ..] => Some((*other, at + 1)),
                _ => (at > 1).then_some((b'\\', at)),
            }
        }
        [b'&', b'#', b'x' | b'X', ..] => {
            let end = text.iter().take(8).position(|byte| *byte == b';')?;
            Some((number(3, end, 16)?, end + 1))
        }
        [b'&', b'#', ..] => {
            let end = text.iter().take(8).position(|byte| *byte == b';')?;
            Some((number(2, end, 10)?, end + 1))
        }
        _ => [
            (&b"&amp;"[..], b'&'),
            (b"&lt;", b'<'),
            (b"&gt;", b'>'),
            (b"&quot;", b'"'),
        ]
        .into_iter()
        .find_map(|(name, byte)| text.starts_with(name).then_some((byte, name.len()))),
    }
}

/// The base64 characters that depend on the secret alone, if it begins `before` bytes (0 to 2) into a group of three.
fn base64_core(secret: &[u8], before: usize) -> Vec<u8> {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bits = secret
        .iter()
        .flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1));
    // A character has six bits; characters shared with the preceding text are skipped.
    let skipped = (6 - before * 8 % 6) % 6;
    let bits: Vec<u8> = bits.skip(skipped).collect();
    bits.chunks_exact(6)
        .map(|six| six.iter().fold(0_usize, |value, bit| value << 1 | usize::from(*bit)))
        .filter_map(|value| ALPHABET.get(value).copied())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: &str = "sk-very/secret+0123\"456789";

    #[test]
    fn a_key_is_taken_out_in_every_form() {
        let redaction = Redaction::of([KEY, "hunter2 is long"]);
        for (text, shown) in [
            (format!("bad key {KEY}!"), "bad key [key]!"),
            (format!("Bearer {KEY}{KEY}"), "Bearer [key][key]"),
            ("?k=sk-very%2Fsecret%2b0123%22456789&x".to_owned(), "?k=[key]&x"),
            (
                r#"{"k": "sk-very\/secret+0123\"456789"}"#.to_owned(),
                r#"{"k": "[key]"}"#,
            ),
            (r"sk-\u0076ery\u002Fsecret\x2b0123\u0022456789.".to_owned(), "[key]."),
            (
                r"sk-very\\/secret\\u002b0123\\\\\u0022456789 sk-very%252Fsecret%25252b0123%22456789".to_owned(),
                "[key] [key]",
            ),
            (
                "<b>sk-very&#47;secret&#x2B;0123&quot;456789</b>".to_owned(),
                "<b>[key]</b>",
            ),
            (
                "736b2d766572792F7365637265742b30313233223435363738390a".to_owned(),
                "[key]0a",
            ),
            // base64 of the key, of `:key`, of `user:hunter2 is long`, and in the URL-safe alphabet.
            ("key c2stdmVyeS9zZWNyZXQrMDEyMyI0NTY3ODk= no".to_owned(), "key [key] no"),
            ("Basic OnNrLXZlcnkvc2VjcmV0KzAxMjMiNDU2Nzg5".to_owned(), "Basic [key]"),
            ("Basic dXNlcjpodW50ZXIyIGlzIGxvbmc=, no".to_owned(), "Basic [key], no"),
            // The message was truncated inside the key.
            ("bad key sk-very/sec".to_owned(), "bad key [key]"),
            ("bad key sk-very%2".to_owned(), "bad key [key]"),
            ("bad key sk-".to_owned(), "bad key sk-"),
            (
                "nothing of it, 100 % \\u00e9 &amp; é".to_owned(),
                "nothing of it, 100 % \\u00e9 &amp; é",
            ),
        ] {
            assert_eq!(redaction.of_message(&text), shown);
        }
    }

    #[test]
    fn redaction_of_replies_keeps_common_words() {
        let redaction = Redaction::of(["none"]);
        assert_eq!(redaction.of_reply(r#"{"question": "none"}"#), r#"{"question": "none"}"#);
        assert_eq!(redaction.of_message("key none"), "key [key]");
        assert_eq!(Redaction::of([KEY]).of_reply(&format!("it is {KEY}")), "it is [key]");
        assert_eq!(format!("{:?}", Redaction::of([KEY])), REDACTED);
    }
}
