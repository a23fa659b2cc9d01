//! SVG charts. Widths are in per cent: nothing is scaled, and texts stay readable on a phone.

use super::markup::escaped;
use super::words::{duration, interval, percent};
use crate::rate::Rate;

/// A bar with its 95 % confidence interval, on a scale from 0 to 1.
pub(super) fn bar(rate: Rate, class: &str) -> String {
    let (low, high) = rate.interval();
    let at = |share: f64| format!("{:.2}%", share * 100.0);
    let name = format!("{}, 95 % interval {}", percent(rate), interval(rate));
    let whisker = format!(
        "<line class=\"whisker\" x1=\"{0}\" x2=\"{1}\" y1=\"50%\" y2=\"50%\"/>\
         <line class=\"whisker\" x1=\"{0}\" x2=\"{0}\" y1=\"28%\" y2=\"72%\"/>\
         <line class=\"whisker\" x1=\"{1}\" x2=\"{1}\" y1=\"28%\" y2=\"72%\"/>",
        at(low),
        at(high)
    );
    format!(
        "<svg class=\"bar {class}\" role=\"img\" aria-label=\"{name}\"><rect class=\"ground\" width=\"100%\" \
         height=\"100%\"/><rect class=\"fill\" width=\"{}\" height=\"100%\"/>{whisker}</svg>",
        at(rate.share())
    )
}

/// Bars with names and shares, one below the other; those of this run (`true`) stand out.
pub(super) fn bars(shares: &[(String, Rate, bool)]) -> String {
    let bar = |(name, rate, ours): &(String, Rate, bool)| {
        let class = if *ours { "ours" } else { "theirs" };
        format!(
            "<li><span class=\"name\">{}</span>{}<span class=\"figure\"><b>{}</b> <small>{} of \
             {}</small></span></li>\n",
            escaped(name),
            self::bar(*rate, class),
            percent(*rate),
            rate.hits,
            rate.of
        )
    };
    let bars: String = shares.iter().map(bar).collect();
    format!("<ul class=\"bars\">\n{bars}</ul>\n")
}

/// A bar for a count relative to the largest one.
pub(super) fn count_bar(count: usize, most: usize) -> String {
    let width = count as f64 / most.max(1) as f64 * 100.0;
    format!(
        "<svg class=\"bar count\" aria-hidden=\"true\"><rect class=\"fill\" width=\"{width:.2}%\" \
         height=\"100%\"/></svg>"
    )
}

/// Number of classes of a histogram.
const CLASSES: usize = 24;

/// A histogram of durations; empty for fewer than two.
pub(super) fn histogram(milliseconds: &[f64]) -> String {
    let least = milliseconds.iter().copied().fold(f64::INFINITY, f64::min);
    let most = milliseconds.iter().copied().fold(0.0, f64::max);
    if milliseconds.len() < 2 || !most.is_finite() || most <= least {
        return String::new();
    }
    let mut counts = [0_usize; CLASSES];
    for time in milliseconds {
        let class = (time - least) / (most - least) * CLASSES as f64;
        counts[(class as usize).min(CLASSES - 1)] += 1;
    }
    let tallest = counts.iter().copied().max().unwrap_or(1);
    let width = 100.0 / CLASSES as f64;
    let column = |(class, count): (usize, &usize)| {
        let height = *count as f64 / tallest as f64 * 100.0;
        let from = least + (most - least) * class as f64 / CLASSES as f64;
        let to = least + (most - least) * (class + 1) as f64 / CLASSES as f64;
        format!(
            "<rect class=\"fill\" x=\"{:.2}%\" width=\"{:.2}%\" y=\"{:.2}%\" height=\"{height:.2}%\"><title>{count} \
             from {} to {}</title></rect>",
            class as f64 * width + 0.2,
            width - 0.4,
            100.0 - height,
            duration(from),
            duration(to)
        )
    };
    let columns: String = counts
        .iter()
        .enumerate()
        .filter(|(_, count)| **count > 0)
        .map(column)
        .collect();
    format!(
        "<figure class=\"histogram\"><figcaption>Time of an attempt; the highest column is {tallest} of \
         {}</figcaption>\
         <svg role=\"img\" aria-label=\"Times from {least} to {most}\">{columns}<line class=\"axis\" x2=\"100%\" \
         y1=\"100%\" y2=\"100%\"/></svg><p \
         class=\"axis\"><span>{least}</span><span>{middle}</span><span>{most}</span></p>\
         </figure>\n",
        milliseconds.len(),
        least = duration(least),
        middle = duration((least + most) / 2.0),
        most = duration(most)
    )
}
