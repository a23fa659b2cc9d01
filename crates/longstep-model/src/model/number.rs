//! Exact decimal numbers.

use std::fmt;

/// An exact decimal number with six places after the point.
///
/// Sums and differences are exact, products and quotients are rounded to the nearest millionth, halves away from zero. An
/// operation whose result does not fit returns none.
///
/// ```
/// use longstep_model::environment::Number;
/// let (tenth, fifth) = (Number::parse("0.1").unwrap(), Number::parse("0.2").unwrap());
/// assert_eq!(tenth.plus(fifth).unwrap().to_string(), "0.3");
/// assert_eq!(Number::from(7).over(Number::from(2)), Number::parse("3.5"));
/// assert_eq!(Number::from(1).over(Number::from(0)), None);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Number(i64);

impl Number {
    /// Number of millionths in one.
    const ONE: i64 = 1_000_000;
    /// Digits after the point.
    const PLACES: usize = 6;
    /// Zero.
    pub const ZERO: Number = Number(0);

    /// Parses a decimal such as `-2.50`; none if it has more than six places, does not fit, or is no number.
    pub fn parse(text: &str) -> Option<Self> {
        let (negative, digits) = match text.strip_prefix('-') {
            Some(rest) => (true, rest),
            None => (false, text),
        };
        let (whole, places) = digits.split_once('.').unwrap_or((digits, ""));
        let all_digits = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
        let places = places.trim_end_matches('0');
        let has_digits = !whole.is_empty() && !digits.ends_with('.');
        if !has_digits || !all_digits(whole) || !all_digits(places) || places.len() > Self::PLACES {
            return None;
        }
        let whole: i64 = whole.parse().ok()?;
        let places: i64 = format!("{places:0<6}").parse().ok()?;
        let size = whole.checked_mul(Self::ONE)?.checked_add(places)?;
        Some(Self(if negative { -size } else { size }))
    }

    /// Parses a decimal as [`Number::parse`] does, with any number of places; those after the sixth are rounded away.
    pub fn parse_rounded(text: &str) -> Option<Self> {
        let is_long = |(_, places): &(&str, &str)| places.len() > Self::PLACES && text.is_ascii();
        let Some((_, places)) = text.split_once('.').filter(is_long) else {
            return Self::parse(text);
        };
        let kept = Self::parse(&text[..text.len() - places.len() + Self::PLACES])?;
        let rest = &places[Self::PLACES..];
        if !rest.bytes().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        let away = i64::from(rest.as_bytes()[0] >= b'5');
        let away = if text.starts_with('-') { -away } else { away };
        kept.0.checked_add(away).and_then(Self::of_millionths)
    }

    /// Creates the number of so many millionths; none for the one value that is reserved.
    pub fn of_millionths(millionths: i64) -> Option<Self> {
        (millionths != i64::MIN).then_some(Self(millionths))
    }

    /// Returns the number of millionths.
    pub fn millionths(self) -> i64 {
        self.0
    }

    /// Returns the sum.
    pub fn plus(self, other: Self) -> Option<Self> {
        self.0.checked_add(other.0).and_then(Self::of_millionths)
    }

    /// Returns the difference.
    pub fn minus(self, other: Self) -> Option<Self> {
        self.0.checked_sub(other.0).and_then(Self::of_millionths)
    }

    /// Returns the product, rounded to the nearest millionth.
    pub fn times(self, other: Self) -> Option<Self> {
        rounded(i128::from(self.0) * i128::from(other.0), i128::from(Self::ONE))
    }

    /// Returns the quotient, rounded to the nearest millionth; none for a division by zero.
    pub fn over(self, other: Self) -> Option<Self> {
        rounded(i128::from(self.0) * i128::from(Self::ONE), i128::from(other.0))
    }
}

/// Returns a quotient in millionths, rounded to the nearest, halves away from zero.
fn rounded(dividend: i128, divisor: i128) -> Option<Number> {
    if divisor == 0 {
        return None;
    }
    let size = (2 * dividend.abs() + divisor.abs()) / (2 * divisor.abs());
    let signed = if (dividend < 0) == (divisor < 0) { size } else { -size };
    i64::try_from(signed).ok().and_then(Number::of_millionths)
}

impl Number {
    /// Returns the nearest floating-point number, for formats that have no decimals.
    pub fn approximate(self) -> f64 {
        self.0 as f64 / Self::ONE as f64
    }
}

impl From<i32> for Number {
    fn from(whole: i32) -> Self {
        Self(i64::from(whole) * Self::ONE)
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (size, sign) = (self.0.unsigned_abs(), if self.0 < 0 { "-" } else { "" });
        let one = Self::ONE.unsigned_abs();
        write!(f, "{sign}{}", size / one)?;
        let places = format!("{:06}", size % one);
        match places.trim_end_matches('0') {
            "" => Ok(()),
            places => write!(f, ".{places}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parse_rounded_rounds_extra_decimal_places() {
        for (text, expected) in [
            ("2.5", Some("2.5")),
            ("0.3333333333", Some("0.333333")),
            ("-0.66666666", Some("-0.666667")),
            ("2499.9999999", Some("2500")),
            ("1.000000x", None),
            ("1.00000\u{0663}\u{0663}", None),
            ("x.0000000", None),
        ] {
            let number = Number::parse_rounded(text).map(|number| number.to_string());
            assert_eq!(number.as_deref(), expected, "{text}");
        }
    }

    #[test]
    fn decimals_are_read_and_written_exactly() {
        for (text, expected) in [
            ("0", Some("0")),
            ("-0", Some("0")),
            ("3", Some("3")),
            ("-2.50", Some("-2.5")),
            ("0.000001", Some("0.000001")),
            ("12.0000000000", Some("12")),
            ("9000000000000", Some("9000000000000")),
            ("10000000000000", None),
            ("99999999999999999999", None),
            ("0.0000001", None),
            ("", None),
            ("-", None),
            (".5", None),
            ("5.", None),
            ("+1", None),
            ("1e3", None),
            ("--1", None),
            ("1.-5", None),
            ("NaN", None),
            ("\u{0663}", None),
        ] {
            assert_eq!(
                Number::parse(text).map(|number| number.to_string()).as_deref(),
                expected,
                "{text}"
            );
        }
    }

    #[test]
    fn operations_are_exact_or_rounded_to_the_nearest_and_never_wrap() {
        let number = |text: &str| Number::parse(text).unwrap();
        let most = Number(i64::MAX);
        for (result, expected) in [
            (number("0.1").plus(number("0.2")), Some("0.3")),
            (number("1").minus(number("1.000001")), Some("-0.000001")),
            (number("0.5").times(number("0.000001")), Some("0.000001")),
            (number("-0.5").times(number("0.000001")), Some("-0.000001")),
            (number("0.4").times(number("0.000001")), Some("0")),
            (number("2").over(number("3")), Some("0.666667")),
            (number("-2").over(number("3")), Some("-0.666667")),
            (number("2").over(Number::ZERO), None),
            (Number::ZERO.over(Number::ZERO), None),
            (most.plus(most), None),
            (most.times(most), None),
            (Number(-i64::MAX).minus(Number(1)), None),
            (most.over(number("0.000001")), None),
        ] {
            assert_eq!(result.map(|number| number.to_string()).as_deref(), expected);
        }
    }
}
