//! Widths of texts, from a fixed table, so that a picture does not depend on the fonts of a machine.
//!
//! The table has the greater width of each character in DejaVu Sans and Liberation Sans (the metrics of Arial), so that
//! text fits with either of them. Scripts are estimated by their wide characters.

use longstep_core::visible;

/// A size and weight of text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Font {
    pub(crate) size: f64,
    pub(crate) bold: bool,
}

impl Font {
    pub(crate) const fn regular(size: f64) -> Self {
        Self { size, bold: false }
    }

    pub(crate) const fn bold(size: f64) -> Self {
        Self { size, bold: true }
    }

    /// The distance between two baselines.
    pub(crate) fn line_height(self) -> f64 {
        (self.size * 1.3).ceil()
    }
}

/// Widths from U+0020 to U+007E in hundredths of the size.
const REGULAR: [u8; 95] = [
    32, 41, 46, 84, 64, 96, 78, 28, 40, 40, 50, 84, 32, 37, 32, 34, 64, 64, 64, 64, 64, 64, 64, 64, 64, 64, 34, 34, 84,
    84, 84, 56, 102, 69, 69, 73, 78, 67, 62, 78, 76, 30, 50, 67, 56, 87, 75, 79, 67, 79, 73, 67, 62, 74, 69, 99, 69,
    67, 69, 40, 34, 40, 84, 56, 50, 62, 64, 55, 64, 62, 36, 64, 64, 28, 28, 58, 28, 98, 64, 62, 64, 64, 42, 53, 40, 64,
    60, 82, 60, 60, 53, 64, 34, 64, 84,
];
const BOLD: [u8; 95] = [
    35, 46, 53, 84, 70, 101, 88, 31, 46, 46, 53, 84, 38, 42, 38, 37, 70, 70, 70, 70, 70, 70, 70, 70, 70, 70, 40, 40,
    84, 84, 84, 62, 100, 78, 77, 74, 84, 69, 69, 83, 84, 38, 56, 78, 64, 100, 84, 86, 74, 86, 78, 73, 69, 82, 78, 111,
    78, 73, 73, 46, 37, 46, 84, 56, 50, 68, 72, 60, 72, 68, 44, 72, 72, 35, 35, 67, 35, 105, 72, 69, 72, 72, 50, 60,
    48, 72, 66, 93, 65, 66, 59, 72, 37, 72, 84,
];

/// Widths beyond ASCII in hundredths, regular and bold: the last character of each range with its width.
const RANGES: [(char, u8, u8); 16] = [
    ('\u{24f}', 88, 96),    // Latin
    ('\u{2ff}', 72, 80),    // phonetic letters
    ('\u{36f}', 0, 0),      // combining marks
    ('\u{3ff}', 86, 94),    // Greek
    ('\u{52f}', 98, 112),   // Cyrillic
    ('\u{58f}', 98, 104),   // Armenian
    ('\u{5ff}', 72, 78),    // Hebrew
    ('\u{8ff}', 110, 124),  // Arabic, Syriac
    ('\u{109f}', 110, 120), // scripts of India and South-East Asia
    ('\u{10ff}', 107, 110), // Georgian
    ('\u{1fff}', 110, 125), // Hangul letters, Ethiopic, further Greek and Latin
    ('\u{200f}', 0, 0),     // spaces and joiners that remain after escaping
    ('\u{2bff}', 110, 110), // punctuation, arrows, symbols
    ('\u{fdff}', 105, 105), // Chinese, Japanese, Korean
    ('\u{fe0f}', 0, 0),     // variation selectors
    ('\u{ffff}', 105, 105), // forms, full width
];

/// Slack of comparisons, for sums of widths in another order.
const SLACK: f64 = 0.01;

/// Width of an emoji and of other characters beyond the basic plane, in hundredths.
const ASTRAL: u8 = 140;

fn hundredths(character: char, bold: bool) -> u8 {
    let code = character as usize;
    if let Some(index) = code.checked_sub(0x20).filter(|index| *index < REGULAR.len()) {
        return if bold { BOLD[index] } else { REGULAR[index] };
    }
    match character {
        '…' => 100,
        '·' => 40,
        _ => {
            let range = RANGES.iter().find(|(last, _, _)| character <= *last);
            range.map_or(ASTRAL, |(_, regular, heavy)| if bold { *heavy } else { *regular })
        }
    }
}

/// Returns an upper bound on the width of a text.
pub(crate) fn width(text: &str, font: Font) -> f64 {
    let sum: u64 = text
        .chars()
        .map(|character| u64::from(hundredths(character, font.bold)))
        .sum();
    sum as f64 * font.size / 100.0
}

/// Returns the text in one line without hidden characters, shortened with an ellipsis if it is wider than `most`.
pub(crate) fn fitted(text: &str, font: Font, most: f64) -> String {
    let text = visible::line(text);
    if width(&text, font) <= most + SLACK {
        return text.into_owned();
    }
    let room = most - width("…", font);
    let mut kept = prefix(&text, font, room).trim_end().to_owned();
    kept.push('…');
    kept
}

/// Returns the longest start of a text that fits, without half a character.
fn prefix(text: &str, font: Font, room: f64) -> &str {
    let mut used = 0.0;
    let mut end = 0;
    for (at, character) in text.char_indices() {
        let own = f64::from(hundredths(character, font.bold)) * font.size / 100.0;
        if used + own > room + SLACK {
            // A mark without width belongs to the character before it, and a joiner asks for the next one.
            return text[..end].trim_end_matches('\u{200d}');
        }
        used += own;
        end = at + character.len_utf8();
    }
    text
}

/// Breaks a text into at most `lines` lines, between words where possible. The last line is shortened with an ellipsis
/// if the text is longer.
pub(crate) fn wrapped(text: &str, font: Font, most: f64, lines: usize) -> Vec<String> {
    let text = visible::line(text);
    let mut rest = text.trim();
    let mut broken = Vec::new();
    while !rest.is_empty() {
        if broken.len() + 1 == lines {
            broken.push(fitted(rest, font, most));
            break;
        }
        if width(rest, font) <= most + SLACK {
            broken.push(rest.to_owned());
            break;
        }
        let fits = prefix(rest, font, most);
        let at_word = fits.rfind(' ').filter(|_| !rest[fits.len()..].starts_with(' '));
        let end = match at_word {
            Some(space) if space > 0 => space,
            // A column too narrow for one character takes one character a line.
            _ => fits.len().max(rest.chars().next().map_or(1, char::len_utf8)),
        };
        broken.push(rest[..end].trim_end().to_owned());
        rest = rest[end..].trim_start();
    }
    broken
}

#[cfg(test)]
mod tests {
    use super::*;

    const FONT: Font = Font::regular(10.0);

    #[test]
    fn width_counts_scripts_and_marks() {
        let cases = [
            ("", 0.0),
            ("ab", 12.6),
            ("\u{65}\u{301}", 6.2),
            ("杯子", 21.0),
            ("🤖", 14.0),
        ];
        for (text, expected) in cases {
            assert!(
                (width(text, FONT) - expected).abs() < 1e-9,
                "{text}: {}",
                width(text, FONT)
            );
        }
    }

    #[test]
    fn fitted_text_is_never_wider_than_the_room() {
        for text in [
            "a long name of a thing",
            "杯子杯子杯子杯子",
            "הספל הכחול על השולחן",
            "a\u{202e}b\u{7}c",
        ] {
            for most in [12.0, 30.0, 61.5, 300.0] {
                let line = fitted(text, FONT, most);
                assert!(width(&line, FONT) <= most + SLACK, "{line} in {most}");
                assert!(!line.contains(visible::is_hidden), "{line:?}");
            }
        }
    }

    #[test]
    fn wrapped_text_breaks_between_words_and_ends_with_an_ellipsis() {
        let lines = wrapped("put the blue cup on the shelf", FONT, 70.0, 5);
        assert_eq!(lines, ["put the blue", "cup on the", "shelf"]);
        assert_eq!(
            wrapped("put the blue cup on the shelf", FONT, 70.0, 2),
            ["put the blue", "cup on the…"]
        );
        assert_eq!(wrapped("杯子杯子", FONT, 22.0, 3), ["杯子", "杯子"]);
        assert_eq!(wrapped("abc", FONT, 1.0, 9).len(), 3);
        assert!(wrapped(" ", FONT, 70.0, 3).is_empty());
    }
}
