//! Values: quantities with units and texts as arguments of actions and goals, for example `22 degC`.
//!
//! A value is an entity that no environment lists: a text that mentions one adds it to a world
//! ([`World::add_values`](super::World::add_values)).

use std::ops::Range;

use super::{Domain, Number, TypeId};

/// A type whose entities are values.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ValueType {
    /// The type in `domain.pddl`.
    pub kind: TypeId,
    /// The notation of its values.
    pub form: ValueForm,
}

/// The notation of the values of a type.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ValueForm {
    /// A number with a unit.
    Quantity(QuantityForm),
    /// A text in double quotes.
    Text,
}

/// The units and the range of a quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QuantityForm {
    /// The unit in which values are written; empty for a plain number.
    pub unit: String,
    /// All units that a text may use, each with its size in `unit`.
    pub units: Vec<(String, Number)>,
    /// The smallest value.
    pub minimum: Option<Number>,
    /// The largest value.
    pub maximum: Option<Number>,
}

/// A value of a domain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Value {
    /// The type.
    pub kind: TypeId,
    /// The number in the unit of the type; none for a text.
    pub number: Option<Number>,
    /// The notation, which is the identifier of the entity: `180 s`, `"dinner is ready"`.
    pub written: String,
}

/// The error for a quantity outside the range of its type.
#[derive(Debug, Clone, PartialEq, Eq, Hash, thiserror::Error)]
#[error("`{written}` is {relation} `{bound}`, the limit for a {kind}")]
#[non_exhaustive]
pub struct OutOfRange {
    /// The quantity.
    pub written: String,
    /// "more than" or "less than".
    pub relation: &'static str,
    /// The limit.
    pub bound: String,
    /// The name of the type.
    pub kind: String,
}

/// The largest number of characters of a text value.
pub const TEXT_VALUE_LIMIT: usize = 200;

/// The largest number of values that one text adds to a world.
pub(super) const VALUE_LIMIT: usize = 50;

impl QuantityForm {
    /// Writes a number with the unit of the type.
    pub fn written(&self, number: Number) -> String {
        match self.unit.as_str() {
            "" => number.to_string(),
            unit => format!("{number} {unit}"),
        }
    }

    /// Returns the value of a number in one of the units; none if the number cannot be converted exactly.
    fn value(&self, domain: &Domain, kind: TypeId, number: Number) -> Result<Value, OutOfRange> {
        let beyond = |relation, bound: Number| OutOfRange {
            written: self.written(number),
            relation,
            bound: self.written(bound),
            kind: domain.types.name(kind).to_owned(),
        };
        match (self.minimum, self.maximum) {
            (Some(minimum), _) if number < minimum => Err(beyond("less than", minimum)),
            (_, Some(maximum)) if number > maximum => Err(beyond("more than", maximum)),
            _ => Ok(Value {
                kind,
                number: Some(number),
                written: self.written(number),
            }),
        }
    }
}

/// A value in a text.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ValueMention {
    /// The place in the text.
    pub place: Range<usize>,
    /// The value, unless it is out of range.
    pub value: Result<Value, OutOfRange>,
}

impl Domain {
    /// Reads a text that is one value: `22 degC`, `3 min`, `"dinner is ready"`. None if it is not written as one.
    pub fn value(&self, text: &str) -> Option<Result<Value, OutOfRange>> {
        let text = text.trim();
        let mention = self.values_in(text).into_iter().next()?;
        (mention.place == (0..text.len())).then_some(mention.value)
    }

    /// Finds all values in a text. Numbers inside names, as in `<cup_3>` or "B12", are none.
    pub fn values_in(&self, text: &str) -> Vec<ValueMention> {
        let mut mentions = Vec::new();
        if self.values.is_empty() {
            return mentions;
        }
        let mut at = 0;
        let mut before = None;
        while let Some(letter) = text[at..].chars().next() {
            let found = match letter {
                '<' => identifier_end(&text[at..]).map(|length| (length, None)),
                '0'..='9' | '-' if !before.is_some_and(joins_number) => self
                    .quantity_at(&text[at..])
                    .map(|(length, value)| (length, Some(value))),
                _ => self
                    .text_at(&text[at..], letter)
                    .map(|(length, value)| (length, Some(Ok(value)))),
            };
            match found {
                Some((length, value)) => {
                    if let Some(value) = value {
                        mentions.push(ValueMention {
                            place: at..at + length,
                            value,
                        });
                    }
                    before = text[..at + length].chars().next_back();
                    at += length;
                }
                None => {
                    before = Some(letter);
                    at += letter.len_utf8();
                }
            }
        }
        mentions
    }

    /// Reads a quoted text at the start of a text that begins with `letter`.
    fn text_at(&self, text: &str, letter: char) -> Option<(usize, Value)> {
        let (_, closing) = QUOTES.iter().find(|(opening, _)| *opening == letter)?;
        let kind = self.values.iter().find(|own| own.form == ValueForm::Text)?.kind;
        let start = letter.len_utf8();
        let end = start + text[start..].find(*closing)?;
        let content = text[start..end].trim();
        let unfit = |c: char| c.is_control() || c == '"' || c == '\\';
        if content.is_empty() || content.contains(unfit) || content.chars().count() > TEXT_VALUE_LIMIT {
            return None;
        }
        let closing = text[end..].chars().next()?;
        let value = Value {
            kind,
            number: None,
            written: format!("\"{content}\""),
        };
        Some((end + closing.len_utf8(), value))
    }

    /// Reads a number with a unit at the start of a text.
    fn quantity_at(&self, text: &str) -> Option<(usize, Result<Value, OutOfRange>)> {
        let (length, number) = number_at(text)?;
        let rest = &text[length..];
        let gap = rest
            .chars()
            .next()
            .filter(|c| matches!(c, ' ' | '\u{a0}' | '\u{202f}' | '-'));
        let gap = gap.map_or(0, char::len_utf8);
        let mut best: Option<(usize, Number, &ValueType, &QuantityForm)> = None;
        for own in &self.values {
            let ValueForm::Quantity(form) = &own.form else { continue };
            for (unit, factor) in &form.units {
                let skipped = if unit.is_empty() { 0 } else { gap };
                let Some(used) = unit_at(&rest[skipped..], unit) else {
                    continue;
                };
                let used = skipped + used;
                if best.is_none_or(|(longest, ..)| used > longest) {
                    best = Some((used, *factor, own, form));
                }
            }
        }
        let (used, factor, own, form) = best?;
        Some((length + used, form.value(self, own.kind, number.times(factor)?)))
    }
}

/// Pairs of quotation marks, opening and closing.
const QUOTES: [(char, [char; 2]); 5] = [
    ('"', ['"', '"']),
    ('“', ['”', '“']),
    ('„', ['“', '”']),
    ('«', ['»', '»']),
    ('「', ['」', '」']),
];

/// Returns true if a number after this character is a part of a name or of another number.
fn joins_number(before: char) -> bool {
    before.is_alphanumeric() || matches!(before, '_' | '.' | ',' | ':' | '-')
}

/// Returns the length of an identifier in angle brackets at the start of a text.
fn identifier_end(text: &str) -> Option<usize> {
    let end = text.find('>')?;
    (!text[1..end].contains(['<', ' ', '\n'])).then_some(end + 1)
}

/// Reads a number at the start of a text, and returns its length. A comma before one or two digits separates decimal
/// places; before three digits it may group thousands, so such a number is not read.
fn number_at(text: &str) -> Option<(usize, Number)> {
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let sign = usize::from(text.starts_with('-'));
    let whole = sign + digits(&text[sign..]);
    if whole == sign {
        return None;
    }
    let mut end = whole;
    let mut plain = text[..whole].to_owned();
    if let Some(separator) = text[whole..].chars().next().filter(|c| matches!(c, '.' | ',')) {
        let fraction = digits(&text[whole + 1..]);
        if separator == ',' && fraction > 2 {
            return None;
        }
        if fraction > 0 {
            end = whole + 1 + fraction;
            plain = format!("{plain}.{}", &text[whole + 1..end]);
        }
        // Dates and versions are no numbers.
        if text[end..].starts_with(['.', ',', ':']) && digits(&text[end + 1..]) > 0 {
            return None;
        }
    }
    if text[end..].starts_with(':') && digits(&text[end + 1..]) > 0 {
        return None;
    }
    Some((end, Number::parse(&plain)?))
}

/// Returns the length of a unit at the start of a text: in the same case, or in another one if the unit is a word.
fn unit_at(text: &str, unit: &str) -> Option<usize> {
    let ends_word = |length: usize| {
        let last = text[..length].chars().next_back();
        let next = text[length..].chars().next();
        // Scripts without blanks between words continue at once.
        let separates = last.is_none_or(|last| last.is_ascii() || last.is_lowercase() || last.is_uppercase());
        !separates || !next.is_some_and(|next| next.is_alphanumeric() || next == '_')
    };
    if text.starts_with(unit) {
        return ends_word(unit.len()).then_some(unit.len());
    }
    if unit.chars().count() < 3 {
        // `mM` and `Mm` are different units.
        return None;
    }
    let head = text.get(..unit.len())?;
    (head.to_lowercase() == unit.to_lowercase() && ends_word(unit.len())).then_some(unit.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    /// A domain with a temperature, a duration, a volume, a count and a message.
    fn domain() -> Domain {
        let household = testing::domain("household");
        household.edited(|data| {
            let mut quantity = |name: &str, unit: &str, units: &[(&str, &str)], range: [Option<&str>; 2]| {
                let number = |text: &str| Number::parse(text).unwrap();
                let kind = data.types.intern(name);
                let mut all = vec![(unit.to_owned(), Number::from(1))];
                all.extend(units.iter().map(|(unit, factor)| ((*unit).to_owned(), number(factor))));
                data.values.push(ValueType {
                    kind,
                    form: ValueForm::Quantity(QuantityForm {
                        unit: unit.to_owned(),
                        units: all,
                        minimum: range[0].map(number),
                        maximum: range[1].map(number),
                    }),
                });
            };
            quantity(
                "temperature",
                "degC",
                &[("°C", "1"), ("degrees", "1")],
                [Some("5"), Some("30")],
            );
            quantity(
                "duration",
                "s",
                &[("min", "60"), ("Minuten", "60"), ("分", "60")],
                [None, None],
            );
            quantity("volume", "ul", &[("ml", "1000"), ("µl", "1")], [None, None]);
            quantity("count", "", &[], [Some("1"), None]);
            let kind = data.types.intern("message");
            data.values.push(ValueType {
                kind,
                form: ValueForm::Text,
            });
        })
    }

    #[test]
    fn values_are_found_in_any_wording() {
        let domain = domain();
        let found = |text: &str| -> Vec<String> {
            let mentions = domain.values_in(text).into_iter();
            let written = |mention: ValueMention| match mention.value {
                Ok(value) => value.written,
                Err(error) => error.to_string(),
            };
            mentions.map(written).collect()
        };
        let cases: &[(&str, &[&str])] = &[
            ("set the thermostat to 22 degrees, please", &["22 degC"]),
            ("22°C", &["22 degC"]),
            ("heat it for 3 min", &["180 s"]),
            ("für 10 minuten", &["600 s"]),
            ("3分間温めて", &["180 s"]),
            ("0.5 ml or 1,5 ml or 50µl", &["500 ul", "1500 ul", "50 ul"]),
            ("a 5-min timer", &["300 s"]),
            ("2 pills", &["2"]),
            ("bring <pallet_17> and <B 12>", &["12"]),
            ("room B12, at 10:30, on 3.4.2026, 1,500 ml", &[]),
            (
                "say \"dinner, (now) is ready\" and „Guten Tag“",
                &["\"dinner, (now) is ready\"", "\"Guten Tag\""],
            ),
            (
                "35 degC",
                &["`35 degC` is more than `30 degC`, the limit for a temperature"],
            ),
            (
                "-3 degC",
                &["`-3 degC` is less than `5 degC`, the limit for a temperature"],
            ),
            ("3 minutes", &["3"]),
            ("99999999999999999999 min", &[]),
        ];
        for (text, expected) in cases {
            assert_eq!(found(text), *expected, "{text}");
        }
    }

    #[test]
    fn value_accepts_only_the_whole_text() {
        let domain = domain();
        let written = |text: &str| {
            domain
                .value(text)
                .map(|value| value.map(|value| value.written).unwrap_or_default())
        };
        assert_eq!(written("3 min").as_deref(), Some("180 s"));
        assert_eq!(written("180 s").as_deref(), Some("180 s"));
        assert_eq!(written("3 min or so"), None);
        assert_eq!(written("99 degC").as_deref(), Some(""));
    }
}
