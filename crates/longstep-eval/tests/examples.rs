//! The suites of the example domains: every expected goal has a plan, found and verified without a model.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use longstep::{Clock, World, goal, report};
use longstep_eval::suite::{self, Files, Suite};

const DOMAINS: [&str; 6] = [
    "care",
    "home",
    "laboratory",
    "robots/pyrobosim/domain",
    "warehouse",
    "workshop",
];

fn folder(domain: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../examples")
        .join(domain)
}

/// The texts of the files with this ending, by name without the ending.
fn texts(folder: &Path, ending: &str) -> BTreeMap<String, String> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let named = entries.filter_map(|path| {
        let name = path.file_name()?.to_str()?.strip_suffix(ending)?.to_owned();
        Some((name, std::fs::read_to_string(&path).unwrap()))
    });
    named.collect()
}

fn load(domain: &str) -> Suite {
    let home = folder(domain);
    let mut cases = texts(&home.join("suite"), ".toml");
    let files = Files {
        folder: format!("examples/{domain}/suite/"),
        suite: cases.remove("suite").unwrap(),
        cases: cases
            .into_iter()
            .map(|(name, text)| (format!("{name}.toml"), text))
            .collect(),
        scenes: texts(&home.join("suite/scenes"), ".json"),
    };
    let domain = longstep_llm::load_domain(home.to_str().unwrap()).unwrap_or_else(|error| panic!("{error}"));
    suite::load(&files, &domain).unwrap_or_else(|faults| panic!("{faults}"))
}

#[test]
fn the_domains_have_no_warnings() {
    for name in DOMAINS {
        let files = longstep_files::domain_files(folder(name).to_str().unwrap()).unwrap();
        let domain = longstep::domain::load(&files).unwrap_or_else(|faults| panic!("{faults}"));
        let findings = longstep_author::lint(&domain, &files);
        let shown: Vec<String> = findings.iter().map(|finding| finding.diagnostic.to_string()).collect();
        assert!(shown.is_empty(), "{name}: {shown:#?}");
    }
}

/// The pills go back to the cabinet, although the goal puts something else there.
#[test]
fn a_goal_waives_rules_for_its_subject_alone() {
    let world = load("care").scenes.remove("ward").unwrap();
    let solved = |world: &World, goal: &str| {
        let goal = goal::parse(world, goal).unwrap();
        let solution = report::of_goal(world, &goal, "", &longstep::Limits::default(), &Clock::none());
        solution.plan.unwrap()
    };
    let plan = solved(
        &world,
        "dosed(heart pills, Mrs Ito) & brought(blanket, medicine cabinet)",
    );
    let after = world.after(plan.ending());
    assert!(
        solved(&after, "brought(heart pills, medicine cabinet)")
            .steps()
            .is_empty()
    );
    // A goal about the pills themselves waives it.
    let plan = solved(&world, "dosed(heart pills, Mrs Ito) & brought(heart pills, Mrs Ito)");
    let after = world.after(plan.ending());
    assert!(
        !solved(&after, "brought(heart pills, medicine cabinet)")
            .steps()
            .is_empty()
    );
}

#[test]
fn every_expected_goal_is_solved_and_verified() {
    let mut missing = Vec::new();
    let mut solved = 0;
    for domain in DOMAINS {
        let suite = load(domain);
        for case in &suite.cases {
            let world = suite.judged_world(case);
            for step in &case.steps {
                for goal in step.expected.goals() {
                    let solution =
                        report::of_goal(&world, goal, &step.says, &longstep::Limits::default(), &Clock::none());
                    match solution.plan {
                        // A goal that holds already would show nothing.
                        Some(plan) if !plan.steps().is_empty() => solved += 1,
                        _ => missing.push(format!("{}: {}: {:?}", case.id, step.says, solution.answer.notes)),
                    }
                }
            }
        }
    }
    assert!(missing.is_empty(), "{solved} solved, not: {missing:#?}");
    assert_eq!(solved, 80);
}
