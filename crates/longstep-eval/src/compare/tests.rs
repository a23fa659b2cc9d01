use super::{html, markdown, text};
use crate::report::tests::{results, right, wrong};

/// Joins columns with single blanks.
fn one_line(lines: &str) -> String {
    lines.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn comparison_lists_changed_cases_by_direction() {
    let first = results("desk", "small", vec![right("pen", 1), wrong("cup", 1), wrong("ink", 1)]);
    let mut second = results("desk", "large", vec![wrong("pen", 1), right("cup", 1), wrong("ink", 1)]);
    second.plan.seed = 7;
    let lines = text(&first, &second);
    let (_, lists) = lines
        .split_once("1 from wrong to right, 1 from right to wrong; p = 1.0000")
        .unwrap();
    let (mended, broken) = lists.split_once("From right to wrong").unwrap();
    assert!(
        mended.contains("cup: the plan is not valid; step 1: the fridge is closed"),
        "{lines}"
    );
    assert!(!mended.contains("pen") && broken.contains("pen:") && !lists.contains("ink"));
    assert!(
        lines.contains("seed: 1 -> 7") && lines.contains("model: small -> large"),
        "{lines}"
    );
    assert!(
        one_line(&lines).contains("33 % (1/3) 33 % (1/3) +0.0 points"),
        "{lines}"
    );

    let document = markdown(&first, &second);
    assert!(
        document.contains("Was wrong: the plan is not valid; step 1: the fridge is closed. Right now: cup is done.")
    );
    assert!(html(&first, &second).contains("<h2>From right to wrong (1)</h2>"));
}

#[test]
fn comparison_of_different_suites_counts_common_attempts() {
    let first = results("desk", "one", vec![right("pen", 1), right("cup", 1)]);
    let second = results("shelf", "one", vec![wrong("pen", 1), wrong("ink", 1), wrong("box", 1)]);
    let lines = text(&first, &second);
    assert!(lines.contains("runs of different suites, desk and shelf"), "{lines}");
    assert!(lines.contains("Attempts in both runs: 1; only in the first, and not counted: 1; only in the second: 2."));
    assert!(
        one_line(&lines).contains("correct 100 % (1/1) 0 % (0/1) -100.0 points"),
        "{lines}"
    );
}

#[test]
fn data_is_never_markup() {
    let evil = "<script>alert(1)</script>";
    let mut first = results("desk", evil, vec![right("pen", 1)]);
    let mut second = results("desk", "other", vec![wrong("pen", 1)]);
    first.plan.changes = vec![evil.to_owned()];
    second.attempts[0].says = evil.to_owned();
    second.attempts[0].why = vec![evil.to_owned()];
    let page = html(&first, &second);
    assert_eq!(page.matches("<script").count(), 1);
    assert!(!markdown(&first, &second).contains("<script"));
    assert_eq!(page, html(&first, &second));
    second.attempts[0].why = vec!["\u{1b}[2Jgone".to_owned()];
    assert!(text(&first, &second).contains("pen: \\u{1b}[2Jgone"));
}
