//! Escapes for foreign text: control characters and characters that hide or reorder text become visible.
//!
//! Names, replies and files may hold terminal escape sequences, bidirectional overrides and zero-width characters.
//! Printed unchanged, they move the cursor, recolour or reorder the text around them, and can forge a verdict.
//!
//! ```
//! use longstep_model::visible;
//! assert_eq!(visible::line("\u{1b}[2Jmilk\nVerified: 3 steps"), r"\u{1b}[2Jmilk\nVerified: 3 steps");
//! assert_eq!(visible::block("one\r\ntwo\u{202e}"), "one\ntwo\\u{202e}");
//! assert_eq!(visible::json("{\"name\": \"\u{202e}\"}"), r#"{"name": "\u202e"}"#);
//! ```

use std::borrow::Cow;
use std::fmt::Write as _;

/// Ranges of characters that have no width or change the order of the text around them: bidirectional controls, line
/// and paragraph separators, and all other characters that Unicode lets a renderer omit
/// (`Default_Ignorable_Code_Point`, interlinear and musical controls, tag characters).
const HIDDEN: [(char, char); 22] = [
    ('\u{ad}', '\u{ad}'),
    ('\u{34f}', '\u{34f}'),
    ('\u{61c}', '\u{61c}'),
    ('\u{115f}', '\u{1160}'),
    ('\u{17b4}', '\u{17b5}'),
    ('\u{180b}', '\u{180f}'),
    ('\u{200b}', '\u{200f}'),
    ('\u{2028}', '\u{202e}'),
    ('\u{2060}', '\u{206f}'),
    ('\u{2800}', '\u{2800}'),
    ('\u{3164}', '\u{3164}'),
    ('\u{fe00}', '\u{fe0f}'),
    ('\u{feff}', '\u{feff}'),
    ('\u{ffa0}', '\u{ffa0}'),
    ('\u{fff0}', '\u{fffb}'),
    ('\u{13430}', '\u{13455}'),
    ('\u{1bca0}', '\u{1bca3}'),
    ('\u{1d159}', '\u{1d159}'),
    ('\u{1d173}', '\u{1d17a}'),
    ('\u{e0000}', '\u{e0fff}'),
    ('\u{1fffe}', '\u{1ffff}'),
    ('\u{fffe}', '\u{ffff}'),
];

/// Returns true for control characters, zero-width characters and characters that change the order of others.
pub fn is_hidden(character: char) -> bool {
    character.is_control()
        || (!character.is_ascii() && HIDDEN.iter().any(|(first, last)| (*first..=*last).contains(&character)))
}

/// Escapes all hidden characters of a text, including line breaks; the result is a single line.
///
/// A joiner or a variation selector next to non-ASCII letters or emoji that need it stays unescaped, but only one in a
/// row.
pub fn line(text: &str) -> Cow<'_, str> {
    if !text.contains(is_hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    let mut characters = text.chars().peekable();
    let mut before = Before::Plain;
    while let Some(character) = characters.next() {
        let next = characters.peek().copied();
        let beyond = |next: char| !next.is_ascii() && !is_hidden(next);
        let kept = match character {
            '\u{200c}' | '\u{200d}' => before != Before::Plain && next.is_some_and(beyond),
            '\u{fe0e}' | '\u{fe0f}' => before == Before::Beyond,
            other => !is_hidden(other),
        };
        before = match kept {
            true if beyond(character) => Before::Beyond,
            true if matches!(character, '\u{fe0e}' | '\u{fe0f}') => Before::Selected,
            _ => Before::Plain,
        };
        if kept {
            shown.push(character)
        } else {
            escape(character, &mut shown)
        }
    }
    Cow::Owned(shown)
}

/// The character before a joiner or a variation selector.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Before {
    /// An ASCII character, an escape, a joiner, or none.
    Plain,
    /// A visible non-ASCII character.
    Beyond,
    /// A visible non-ASCII character followed by its variation selector.
    Selected,
}

fn escape(character: char, shown: &mut String) {
    // Writing to a `String` cannot fail.
    let _ = write!(shown, "{}", character.escape_default());
}

/// Escapes all hidden characters of a text except line breaks; `\r\n` becomes `\n`.
pub fn block(text: &str) -> Cow<'_, str> {
    if !text.contains(|character| character != '\n' && is_hidden(character)) {
        return Cow::Borrowed(text);
    }
    let lines = text.split('\n').map(|one| line(one.strip_suffix('\r').unwrap_or(one)));
    Cow::Owned(lines.collect::<Vec<_>>().join("\n"))
}

/// Escapes all hidden characters of a JSON text except line breaks between its values. The value stays equal, since
/// hidden characters occur only inside JSON strings, which have escapes for them.
pub fn json(text: &str) -> Cow<'_, str> {
    let hidden = |character: char| character != '\n' && is_hidden(character);
    if !text.contains(hidden) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if hidden(character) {
            for unit in character.encode_utf16(&mut [0; 2]) {
                let _ = write!(shown, "\\u{unit:04x}");
            }
        } else {
            shown.push(character)
        }
    }
    Cow::Owned(shown)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_without_hidden_characters_is_unchanged() {
        for text in [
            "",
            "put(milk, shelf top)",
            "Käse, 牛乳, молоко",
            "نامه\u{200c}ها",
            "👩\u{200d}🔬 ❤\u{fe0f} ❤\u{fe0f}\u{200d}🔥",
        ] {
            assert_eq!(line(text), text);
            assert_eq!(block(text), text);
        }
    }

    #[test]
    fn line_shows_hidden_characters_as_escapes() {
        for (text, shown) in [
            ("\u{1b}[31mred", r"\u{1b}[31mred"),
            ("a\rb\tc\nd\u{8}e\u{7}f", r"a\rb\tc\nd\u{8}e\u{7}f"),
            ("\u{9b}31m\u{85}\u{7f}", r"\u{9b}31m\u{85}\u{7f}"),
            ("ju\u{202e}ice\u{2069}", r"ju\u{202e}ice\u{2069}"),
            ("a\u{2028}b\u{2029}", r"a\u{2028}b\u{2029}"),
            ("mi\u{200b}lk\u{200d}", r"mi\u{200b}lk\u{200d}"),
            ("milk\u{e0041}\u{e007f}", r"milk\u{e0041}\u{e007f}"),
            // A sequence of selectors can encode a hidden text.
            ("❤\u{fe0f}\u{fe01}\u{fe0f}", "❤\u{fe0f}\\u{fe01}\\u{fe0f}"),
            ("1\u{fe0f}", r"1\u{fe0f}"),
            ("é\u{200d}\u{200d}é", r"é\u{200d}\u{200d}é"),
        ] {
            assert_eq!(line(text), shown, "{text:?}");
        }
    }

    #[test]
    fn json_escapes_of_hidden_characters_keep_the_value() {
        let text: String = (0..=0x3000_u32)
            .chain(0xe000..=0xffff)
            .chain(0xe_0000..=0xe_0100)
            .filter_map(char::from_u32)
            .collect();
        let value = serde_json::json!({"name": text});
        let written = serde_json::to_string_pretty(&value).unwrap();
        let shown = json(&written);
        assert!(!shown.contains(|c| c != '\n' && is_hidden(c)));
        assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).unwrap(), value);
    }
}
