//! Valid suites, and the faults of invalid ones.

use std::collections::BTreeMap;

use longstep::Clock;
use longstep::domain::{self, Domain};
use longstep::report;

use super::*;

const DESK: &str = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    "object_states": {"<pen>": "on_something(<desk>)"}}"#;

fn files(suite: &str, cases: &str, scenes: &[(&str, &str)]) -> Files {
    let scene = |(name, text): &(&str, &str)| ((*name).to_owned(), (*text).to_owned());
    Files {
        folder: "mine/".to_owned(),
        suite: suite.to_owned(),
        cases: [("cases.toml".to_owned(), cases.to_owned())].into(),
        scenes: scenes.iter().map(scene).collect(),
    }
}

fn household() -> Domain {
    domain::shipped("household").unwrap().unwrap()
}

/// Checks the faults of a suite with these cases; none if it is valid.
#[track_caller]
fn check(cases: &str, expected: &[&str]) {
    let suite = "name = 'mine'\nabout = 'A pen.'\ndomain = 'household'";
    let faults = match load(&files(suite, cases, &[("desk", DESK)]), &household()) {
        Ok(_) => Vec::new(),
        Err(faults) => faults.0.iter().map(ToString::to_string).collect(),
    };
    assert_eq!(faults, expected, "{cases}");
}

#[test]
fn suite_reader_accepts_well_formed_cases() {
    check(
        "[[case]]\nid = 'a'\nscene = 'desk'\nsays = 'Shelve the pen.'\ngoal = 'put(pen, shelf)'",
        &[],
    );
    check(
        "[[case]]\nid = 'a'\nscene = 'desk'\nsays = 'Shelve the comb.'\nexpect = 'question'",
        &[],
    );
    check(
        "[[case]]\nid = 'a'\nscene = 'desk'\nsteps = [{ says = 'x', goal = ['put(pen, shelf)', 'put(pen, desk)'] }]",
        &[],
    );
}

#[test]
fn suite_errors_name_the_position_of_each_mistake() {
    check(
        "[[case]]\nid = 'a'\nscene = 'dest'\nsays = 'x'\ngoal = 'put(pen, shelf)'\n\
         [[case]]\nid = 'a'\nscene = 'desk'\nsays = ' '\ngoal = 'put(comb, shelf)'\n\
         [[case]]\nid = 'c'\nscene = 'desk'\nsays = 'x'\nexpect = 'everything'\n\
         [[case]]\nid = 'd'\nscene = 'desk'\nsays = 'x'\ngoal = 'put(pen, shelf)'\nexpect = 'question'\n\
         [[case]]\nid = 'e'\nscene = 'desk'\n",
        &[
            "mine/cases.toml:3:9: there is no scene `dest`\n  hint: did you mean `desk`?",
            "mine/cases.toml:6:1: the instruction is empty",
            "mine/cases.toml:7:6: the id `a` is taken by the case at mine/cases.toml:2\n  hint: give each case an id of its own",
            "mine/cases.toml:10:8: `put(comb, shelf)`: `comb` in `put(comb, shelf)` is nothing in the environment",
            "mine/cases.toml:15:10: `everything` is nothing that can be expected\n  hint: write question, refusal, either or nothing",
            "mine/cases.toml:16:1: an instruction has either `goal` or `expect`\n  hint: `goal` is what must hold in the end; `expect` is question, refusal, either or nothing",
            "mine/cases.toml:22:1: a case has either `says` or `steps`\n  hint: `steps` is for a chain of instructions",
        ],
    );
    check(
        "",
        &[
            "mine/suite.toml: the suite has no cases\n  hint: put `[[case]]` entries into any other .toml file of the folder",
        ],
    );
    check(
        "[[case]]\nid = 'a'\nscene = 'desk'\nsaid = 'x'",
        &[
            "mine/cases.toml:4:1: unknown field `said`, expected one of `id`, `scene`, `rules`, `says`, `wordings`, `goal`, `expect`, `steps`, `tags`",
        ],
    );
}

#[test]
fn suite_reader_reports_all_broken_files_together() {
    let broken = files(
        "name = 'mine'",
        "[[case]",
        &[("desk", "{"), ("hall", "{\"assets\": 1}")],
    );
    let faults = load(&broken, &household()).unwrap_err();
    let places: Vec<String> = faults.0.iter().map(|fault| fault.file.clone()).collect();
    assert_eq!(
        places,
        [
            "mine/cases.toml",
            "mine/scenes/desk.json",
            "mine/scenes/hall.json",
            "mine/suite.toml"
        ]
    );
}

fn loaded(name: &str) -> (Domain, Suite) {
    let (domain, suite) = load_shipped(name).unwrap().unwrap_or_else(|faults| panic!("{faults}"));
    assert_eq!(suite.name, name);
    (domain, suite)
}

/// Every goal of the shipped suites is reachable, and not trivially so, in the world after the steps before it.
#[test]
fn every_expected_goal_can_be_reached() {
    for name in shipped_names() {
        let (_, suite) = loaded(name);
        assert_eq!(
            suite.goal_findings(&longstep::Limits::default()),
            GoalFindings::default()
        );
        for case in &suite.cases {
            let mut world = suite.judged_world(case);
            for step in &case.steps {
                let mut next = None;
                for goal in step.expected.goals() {
                    let solution =
                        report::of_goal(&world, goal, &step.says, &longstep::Limits::default(), &Clock::none());
                    let plan = solution
                        .plan
                        .unwrap_or_else(|| panic!("{name}/{}: {}", case.id, step.says));
                    assert!(!plan.steps().is_empty(), "{name}/{}: {}", case.id, step.says);
                    next.get_or_insert_with(|| world.after(plan.ending()));
                }
                world = next.unwrap_or(world);
            }
        }
    }
}

#[test]
fn an_unreachable_goal_is_found_with_its_instruction_and_the_reason() {
    let suite = "name = 'mine'\nabout = 'A pen.'\ndomain = 'household'";
    let cases = "[[case]]\nid = 'a'\nscene = 'desk'\nsays = 'Shelve the pen.'\ngoal = 'put(pen, shelf)'\n\
         [[case]]\nid = 'b'\nscene = 'desk'\nsteps = [{ says = 'Shelve it.', goal = 'put(pen, shelf)' },\n\
         { says = 'Put it into the desk.', goal = 'put(pen, desk) & on_something(pen, shelf)' },\n\
         { says = 'Shelve it.', goal = 'put(pen, shelf)' }]";
    let suite = load(&files(suite, cases, &[("desk", DESK)]), &household()).unwrap();
    let found = suite.goal_findings(&longstep::Limits::default()).unreached;
    let shown: Vec<String> = found.iter().map(ToString::to_string).collect();
    let expected = "case `b`, instruction 2 (Put it into the desk.): its goal cannot be reached; \
         `put(pen, desk) & on_something(pen, shelf)`: each goal can be reached, but not all of them together";
    assert_eq!(shown, [expected]);
    let limits = longstep::Limits::default()
        .with_direct(1)
        .with_proof(1)
        .with_shortest(1)
        .with_any(1);
    let given_up = suite.goal_findings(&limits).unreached;
    assert!(
        !given_up.is_empty() && given_up.iter().all(|one| !one.proven),
        "{given_up:?}"
    );
}

#[test]
fn a_goal_that_holds_already_is_found() {
    let suite = "name = 'mine'\nabout = 'A pen.'\ndomain = 'household'";
    let cases = "[[case]]\nid = 'a'\nscene = 'desk'\nsteps = [{ says = 'Shelve the pen.', goal = 'put(pen, shelf)' },\n\
         { says = 'Shelve it.', goal = ['put(pen, shelf)', 'put(pen, desk)'] }]";
    let suite = load(&files(suite, cases, &[("desk", DESK)]), &household()).unwrap();
    let found = suite.goal_findings(&longstep::Limits::default());
    assert_eq!(found.unreached, []);
    let shown: Vec<String> = found.settled.iter().map(ToString::to_string).collect();
    assert_eq!(
        shown,
        ["case `a`, instruction 2 (Shelve it.): its goal `put(pen, shelf)` holds already"]
    );
}

#[test]
fn shipped_suites_have_the_expected_number_of_cases() {
    let counts: BTreeMap<&str, (usize, usize)> = shipped_names()
        .into_iter()
        .map(|name| {
            let (_, suite) = loaded(name);
            (
                name,
                (suite.cases.len(), suite.cases.iter().map(|case| case.steps.len()).sum()),
            )
        })
        .collect();
    assert_eq!(
        counts,
        [
            ("branching", (25, 25)),
            ("household", (5, 15)),
            ("kitchen", (132, 132)),
            ("long", (4, 185)),
            ("two-arms", (25, 25)),
            ("unsaid", (11, 11)),
            ("unsaid-arms", (5, 5)),
            ("unsaid-rooms", (6, 6)),
        ]
        .into()
    );
    let (_, kitchen) = loaded("kitchen");
    let asks = kitchen
        .cases
        .iter()
        .filter(|case| case.steps[0].expected.goals().is_empty());
    assert_eq!((asks.count(), kitchen.scenes.len()), (22, 5));
    let half = |tag: &str| {
        kitchen
            .cases
            .iter()
            .filter(|case| case.tags.iter().any(|own| own == tag))
            .count()
    };
    assert_eq!((half("development"), half("held-out")), (67, 65));
}
