//! Figures as people read them.

use crate::attempt::{Attempt, Wanted};
use crate::rate::Rate;

/// A share in per cent. With few attempts, more digits would only seem exact; with many, fewer would make 99.9 a 100.
pub(crate) fn percent(rate: Rate) -> String {
    match rate.of {
        0 => "none".to_owned(),
        of => format!("{:.*} %", digits(of), rate.share() * 100.0),
    }
}

/// The 95 % interval of a share, in per cent.
pub(crate) fn interval(rate: Rate) -> String {
    let (low, high) = rate.interval();
    let digits = digits(rate.of);
    format!("{:.digits$}–{:.digits$} %", low * 100.0, high * 100.0)
}

/// A difference of shares in percentage points, with its sign.
pub(crate) fn points(before: Rate, after: Rate) -> String {
    let difference = (after.share() - before.share()) * 100.0;
    // No minus in front of nothing.
    let shown = if difference.abs() < 0.05 { 0.0 } else { difference };
    format!("{shown:+.1} points")
}

fn digits(of: usize) -> usize {
    usize::from(of >= 200)
}

/// A time from milliseconds.
pub(crate) fn duration(milliseconds: f64) -> String {
    match milliseconds {
        short if short < 0.95 => format!("{short:.2} ms"),
        short if short < 10.0 => format!("{short:.1} ms"),
        short if short < 999.5 => format!("{short:.0} ms"),
        some if some < 9_950.0 => format!("{:.1} s", some / 1000.0),
        some if some < 119_500.0 => format!("{:.0} s", some / 1000.0),
        long if long < 7_170_000.0 => format!("{:.0} min", long / 60_000.0),
        long => format!("{:.1} h", long / 3_600_000.0),
    }
}

/// A count, with its thousands apart.
pub(crate) fn amount(count: u64) -> String {
    let digits = count.to_string();
    let mut grouped = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// So many of something.
pub(super) fn several(count: u64, one: &str) -> String {
    match count {
        1 => format!("1 {one}"),
        count => format!("{} {one}s", amount(count)),
    }
}

/// What was expected, in words.
pub(super) fn expected(wanted: &Wanted) -> String {
    match wanted {
        Wanted::Plan(goals) => goals.join(", or "),
        Wanted::Question => "a question back".to_owned(),
        Wanted::Refusal => "no plan, since there is none".to_owned(),
        Wanted::Either => "a question back or no plan".to_owned(),
    }
}

/// What came instead: what was understood, or else how it ended.
pub(crate) fn came(attempt: &Attempt) -> String {
    if attempt.asked() {
        return format!("the question \u{201c}{}\u{201d}", attempt.question);
    }
    match attempt.understood.is_empty() {
        true => attempt.outcome.name().replace('_', " "),
        false => attempt.understood.join(" & "),
    }
}

/// Why an attempt is not correct, in a line.
pub(crate) fn reason(attempt: &Attempt) -> String {
    let whys = attempt.why.iter();
    // "The plan is not valid" says little without what is wrong with it.
    let all: Vec<&str> = whys.chain(attempt.violations.first()).map(String::as_str).collect();
    all.join("; ")
}
