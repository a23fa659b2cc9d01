//! Numbers in readable form.

use crate::attempt::{Attempt, Wanted};
use crate::rate::Rate;

/// A share in per cent. More digits would suggest precision for few attempts; fewer would round 99.9 to 100 for many.
pub(crate) fn percent(rate: Rate) -> String {
    match rate.of {
        0 => "none".to_owned(),
        of => format!("{:.*} %", digits(of), rate.share() * 100.0),
    }
}

/// The 95 % confidence interval of a share, in per cent.
pub(crate) fn interval(rate: Rate) -> String {
    let (low, high) = rate.interval();
    let digits = digits(rate.of);
    format!("{:.digits$}–{:.digits$} %", low * 100.0, high * 100.0)
}

/// A difference of shares in percentage points, with its sign.
pub(crate) fn points(before: Rate, after: Rate) -> String {
    let difference = (after.share() - before.share()) * 100.0;
    // No minus sign for zero.
    let shown = if difference.abs() < 0.05 { 0.0 } else { difference };
    format!("{shown:+.1} points")
}

fn digits(of: usize) -> usize {
    usize::from(of >= 200)
}

/// A duration given in milliseconds.
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

/// A count with thousands separators.
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

/// A count with a noun in singular or plural.
pub(super) fn several(count: u64, one: &str) -> String {
    match count {
        1 => format!("1 {one}"),
        count => format!("{} {one}s", amount(count)),
    }
}

/// The expected result.
pub(super) fn expected(wanted: &Wanted) -> String {
    match wanted {
        Wanted::Plan(goals) => goals.join(", or "),
        Wanted::Question => "a question back".to_owned(),
        Wanted::Refusal => "no plan, since there is none".to_owned(),
        Wanted::Either => "a question back or no plan".to_owned(),
        Wanted::Nothing => "nothing done, or a question back".to_owned(),
    }
}

/// The actual result: a question, the goals, or the outcome.
pub(crate) fn came(attempt: &Attempt) -> String {
    if attempt.is_question() {
        return format!("the question \u{201c}{}\u{201d}", attempt.question);
    }
    if attempt.understood.is_empty() {
        attempt.outcome.name().replace('_', " ")
    } else {
        attempt.understood.join(" & ")
    }
}

/// The reasons why an attempt is not correct, in one line.
pub(crate) fn reason(attempt: &Attempt) -> String {
    let whys = attempt.why.iter();
    // The sentence "the plan is not valid" needs its first violation.
    let all: Vec<&str> = whys.chain(attempt.violations.first()).map(String::as_str).collect();
    all.join("; ")
}
