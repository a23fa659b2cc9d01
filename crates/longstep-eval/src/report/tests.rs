use std::collections::BTreeMap;

use longstep::session::Settings;

use super::{html, markdown, text};
use crate::attempt::{Attempt, Edit, Key, Outcome, PlanLine, Timing, Wanted};
use crate::failure::Failure;
use crate::folder::{Plan, Results, VERSION};
use crate::suite::PLAIN;
use crate::suite::paper::{ROUNDS, TRIALS};

/// The results of a run with these attempts.
pub(crate) fn results(suite: &str, model: &str, attempts: Vec<Attempt>) -> Results {
    let timing = |(place, attempt): (usize, &Attempt)| {
        let timing = Timing {
            key: attempt.key.clone(),
            cached_tokens: 10,
            model_ms: 90.0 + place as f64,
            total_ms: 100.0 + place as f64,
        };
        (attempt.key.clone(), timing)
    };
    Results {
        plan: Plan {
            version: VERSION,
            longstep: "0.1.0".to_owned(),
            suite: suite.to_owned(),
            suite_sha256: "5f".repeat(32),
            domain: "household".to_owned(),
            domain_sha256: "ab".repeat(32),
            model: model.to_owned(),
            model_sha256: None,
            server: None,
            settings: Settings::default(),
            adapters: "catalogue".to_owned(),
            temperature: 0.0,
            top_p: None,
            seed: 1,
            trials: attempts.iter().map(|attempt| attempt.key.trial).max().unwrap_or(1),
            tags: Vec::new(),
            cases: Vec::new(),
            wordings: Vec::new(),
            changes: Vec::new(),
        },
        timings: attempts.iter().enumerate().map(timing).collect::<BTreeMap<_, _>>(),
        attempts,
    }
}

/// A correct attempt.
pub(crate) fn right(case: &str, trial: u32) -> Attempt {
    Attempt {
        key: Key {
            case: case.to_owned(),
            step: 0,
            wording: PLAIN.to_owned(),
            trial,
        },
        scene: format!("scene of {case}"),
        tags: vec!["one-goal".to_owned()],
        says: format!("Do {case}."),
        expected: Wanted::Plan(vec![format!("done({case})")]),
        outcome: Outcome::Verified,
        executable: true,
        correct: true,
        why: Vec::new(),
        failures: Vec::new(),
        rounds: 0,
        edits: Vec::new(),
        claim_right: None,
        understood: vec![format!("{case} is done")],
        question: String::new(),
        readings: Vec::new(),
        replies: vec!["{}".to_owned()],
        corrections: Vec::new(),
        plan: Vec::new(),
        violations: Vec::new(),
        calls: 1,
        prompt_tokens: 1_000,
        completion_tokens: 30,
    }
}

/// An attempt with an invalid plan.
pub(crate) fn wrong(case: &str, trial: u32) -> Attempt {
    Attempt {
        outcome: Outcome::Invalid,
        executable: false,
        correct: false,
        why: vec!["the plan is not valid".to_owned()],
        violations: vec!["step 1: the fridge is closed".to_owned()],
        failures: vec![Failure::LeftOutStep],
        understood: Vec::new(),
        ..right(case, trial)
    }
}

/// An attempt with hostile text in every field.
fn hostile() -> Attempt {
    let evil = "<script>alert('x')</script> & \"</pre>|`*".to_owned();
    Attempt {
        key: Key {
            case: evil.clone(),
            step: 1,
            wording: evil.clone(),
            trial: 1,
        },
        scene: evil.clone(),
        tags: vec![evil.clone()],
        says: evil.clone(),
        expected: Wanted::Plan(vec![evil.clone()]),
        why: vec![evil.clone()],
        rounds: 1,
        edits: vec![Edit {
            kind: "replace".to_owned(),
            at: 0,
            before: Some(evil.clone()),
            after: Some(evil.clone()),
            why: evil.clone(),
        }],
        understood: vec![evil.clone()],
        question: evil.clone(),
        replies: vec![evil.clone(), evil.clone()],
        corrections: vec![evil.clone()],
        plan: vec![PlanLine {
            step: Some(0),
            depth: 1,
            text: evil.clone(),
            explanation: evil.clone(),
            changes: vec![evil.clone()],
        }],
        violations: vec![evil],
        ..wrong("hostile", 1)
    }
}

fn mixed() -> Results {
    let evil = "<script>alert('x')</script>";
    let mut run = results(evil, evil, vec![right("pen", 1), wrong("cup", 1), hostile()]);
    run.plan.changes = vec![evil.to_owned()];
    run.attempts[0].tags = vec!["two-goals".to_owned()];
    let mut attempt = right("which", 1);
    attempt.expected = Wanted::Question;
    attempt.outcome = Outcome::Question;
    attempt.executable = false;
    attempt.question = evil.to_owned();
    run.attempts.push(attempt.clone());
    attempt.key.case = "needless".to_owned();
    attempt.expected = Wanted::Plan(vec!["on(lamp)".to_owned()]);
    attempt.correct = false;
    run.attempts.push(attempt);
    run
}

/// The paper's scenarios with results as in the paper, repeated for each trial.
fn as_in_paper(trials: u32) -> Vec<Attempt> {
    let mut attempts = Vec::new();
    for trial in 1..=trials {
        for (place, right_trials) in TRIALS.iter().enumerate() {
            let case = (place + 1).to_string();
            attempts.push(match right_trials {
                5 => right(&case, trial),
                _ => wrong(&case, trial),
            });
        }
    }
    attempts
}

#[test]
fn data_is_never_markup() {
    let page = html(&mixed());
    // The page contains only its own script.
    assert_eq!(page.matches("<script").count(), 1);
    assert_eq!(page.matches("</script").count(), 1);
    assert!(page.contains("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt; &amp; &quot;"));
    assert!(!page.contains("alert('x')"));
    let document = markdown(&mixed());
    assert!(!document.contains("<script"), "{document}");
    assert!(document.contains("\\|\\`\\*"));
}

#[test]
fn a_page_loads_nothing() {
    let page = html(&mixed());
    for load in ["http:", "https:", "src=", "url(", "@import", "<link", "fetch(", "//www"] {
        assert!(!page.contains(load), "{load}");
    }
    let links = page.split("href=\"").skip(1);
    for link in links {
        assert!(link.starts_with('#'), "{link:.40}");
    }
}

#[test]
fn the_same_results_give_the_same_bytes() {
    assert_eq!(html(&mixed()), html(&mixed()));
    assert_eq!(markdown(&mixed()), markdown(&mixed()));
    assert_eq!(text(&mixed()), text(&mixed()));
}

#[test]
fn every_link_leads_somewhere() {
    for run in [mixed(), results("paper", "recorded replies", as_in_paper(2))] {
        let page = html(&run);
        for link in page.split("href=\"#").skip(1) {
            let (id, _) = link.split_once('"').unwrap();
            assert_eq!(page.matches(&format!("id=\"{id}\"")).count(), 1, "{id}");
        }
        let all = run.attempts.len();
        assert_eq!(page.matches("<article").count(), all);
    }
}

#[test]
fn an_empty_run_has_a_report() {
    let empty = results("kitchen", "none", Vec::new());
    assert!(html(&empty).contains("Nothing has been run yet."));
    assert!(markdown(&empty).starts_with("# Suite kitchen, none\n"));
    assert!(text(&empty).contains("0 of 0 are not correct"));
}

#[test]
fn report_omits_measures_without_data() {
    let lines = text(&mixed());
    assert!(lines.contains("asked needlessly    25 %  1/4 "), "{lines}");
    let page = html(&results("kitchen", "none", vec![right("pen", 1)]));
    assert!(!page.contains("asked needlessly</span><b>") && !page.contains("chains right"));
    assert!(!page.contains("id=\"wrong\"") && !page.contains("id=\"rounds\""));
}

#[test]
fn recorded_trials_agree_with_the_paper() {
    let mut run = results("paper", "recorded replies", as_in_paper(5));
    assert!(text(&run).contains("70 of 70 cells agree with the paper\n"));
    assert!(markdown(&run).contains("| The paper | 0/5 | 0/5 | 0/5 | 0/5 | 5/5 | 5/5 | 0/5 |"));
    assert!(html(&run).contains("70 of 70 cells agree with the paper."));

    run.attempts[16] = right("3", 2);
    let lines = text(&run);
    assert!(
        lines.contains("69 of 70 cells agree with the paper; not Scenario 3, trial 2"),
        "{lines}"
    );
    assert!(lines.lines().count() <= 25, "{lines}");

    // The paper has no judgement of other models.
    run.plan.model = "another".to_owned();
    assert!(!text(&run).contains("agree"));
}

#[test]
fn recorded_feedback_agrees_with_the_paper() {
    let attempt = |(place, rounds): (usize, &u32)| Attempt {
        rounds: *rounds,
        ..right(&(place + 1).to_string(), 1)
    };
    let mut run = results(
        "paper",
        "recorded replies",
        ROUNDS.iter().enumerate().map(attempt).collect(),
    );
    assert!(text(&run).contains("14 of 14 entries agree with the paper\n"));
    let document = markdown(&run);
    assert!(document.contains("| The paper | 1 | 1 | 3 | 1 | 0 |"), "{document}");
    assert!(html(&run).contains("The paper, after feedback"));

    run.attempts[0].rounds = 2;
    assert!(text(&run).contains("13 of 14 entries agree with the paper; not Scenario 1\n"));
}
