//! Instructions that say more than goals, with a real model: prohibitions, quantities, orders and conditions in ten
//! languages, and ordinary instructions among them. `LONGSTEP_MODEL` is a model reference, by default the catalogue's
//! default model, `LONGSTEP_THREADS` its threads (1), `LONGSTEP_SCREENING=0` omits the screening.
//!
//! ```text
//! cargo test --release -p longstep-llm --features embedded --test screening -- --ignored --nocapture development
//! ```

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

mod opened;

use std::collections::BTreeMap;
use std::path::Path;

use longstep::coverage::{Gap, Mark};
use longstep::dialogue::{Dialogue, Reply, ScreeningDialogue};
use longstep::session::{Proposal, Response, Session, Settings};
use longstep::{Planner, World, goal};
use longstep_core::verify;
use longstep_llm::{Progress, load_domain};

/// An instruction with its scene and what is checked.
struct Case<'a> {
    scene: &'a str,
    kind: &'a str,
    instruction: &'a str,
    check: &'a str,
}

fn cases(text: &str) -> Vec<Case<'_>> {
    let lines = text.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split('|').collect();
            let [scene, _, kind, instruction, check] = fields[..] else {
                panic!("{line}")
            };
            Case {
                scene,
                kind,
                instruction,
                check,
            }
        })
        .collect()
}

/// The domain and the environment of a scene.
fn scene(name: &str) -> (String, String) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let (domain, file) = match name {
        "pantry" => ("household".to_owned(), root.join("examples/environments/pantry.json")),
        "greenhouse" => {
            let folder = root.join("examples/greenhouse");
            (folder.display().to_string(), folder.join("environment.json"))
        }
        example if example.contains('/') => {
            let (domain, file) = example.split_once('/').unwrap();
            let folder = root.join("examples").join(domain);
            let file = folder.join(format!("suite/scenes/{file}.json"));
            (folder.display().to_string(), file)
        }
        _ => (
            "virtualhome".to_owned(),
            root.join(format!("suites/kitchen/scenes/{name}.json")),
        ),
    };
    (domain, std::fs::read_to_string(file).unwrap())
}

/// Returns what became of an instruction, in one word.
fn verdict(case: &Case<'_>, world: &World, session: &Session) -> &'static str {
    match session.response() {
        Response::Plan(proposal) => match case.kind {
            "P" | "M" => match breaks(world, proposal, case.check) {
                true => "forbidden",
                false => "dropped",
            },
            "O" => match achieves(world, proposal, case.check) {
                true => "right",
                false => "dropped",
            },
            "N" => match is_goal(world, proposal, case.check) {
                true => "right",
                false => "wrong",
            },
            "T" => match is_goal(world, proposal, case.check) {
                true => "right",
                false => "dropped",
            },
            _ => "dropped",
        },
        Response::Consent(_) | Response::Question(_) => "question",
        _ => "no plan",
    }
}

fn breaks(world: &World, proposal: &Proposal, rules: &str) -> bool {
    let bound = world.with_prohibitions(goal::rules(world, rules).unwrap());
    let report = verify::check(&bound, proposal.plan.plan().clone(), &proposal.purpose);
    !report.violations.is_empty()
}

fn achieves(world: &World, proposal: &Proposal, text: &str) -> bool {
    let purpose = goal::parse(world, text).unwrap().purpose(world);
    let report = verify::check(world, proposal.plan.plan().clone(), &purpose);
    report.violations.is_empty()
}

fn is_goal(world: &World, proposal: &Proposal, texts: &str) -> bool {
    let own = proposal.goal.as_ref().unwrap().everyday(proposal.plan.world());
    texts.split(";;").any(|text| {
        // A message is known to the world of the plan, but not to this one.
        let mut world = world.clone();
        world.add_values(text);
        goal::parse(&world, text).unwrap().everyday(&world) == own
    })
}

fn measure(text: &str) -> BTreeMap<(String, &'static str), usize> {
    let mut model = opened::model();
    let settings = Settings {
        screening: std::env::var("LONGSTEP_SCREENING").as_deref() != Ok("0"),
        ..Settings::default()
    };
    let mut counts = BTreeMap::new();
    for case in cases(text) {
        let (domain, environment) = scene(case.scene);
        let planner = Planner::new(load_domain(&domain).unwrap());
        let world = planner.world(&environment).unwrap();
        let mut session = planner.session(world.clone(), settings, model.facts()).unwrap();
        longstep_llm::instruct(&mut session, &mut *model, case.instruction).unwrap();
        let verdict = verdict(&case, &world, &session);
        let goal = session.proposal().and_then(|proposal| proposal.goal.as_ref());
        let goal = goal.map_or(String::new(), |goal| goal.everyday(session.world()).join(" & "));
        println!(
            "{:9} {} {}  ->  {goal}  {}",
            verdict,
            case.kind,
            case.instruction,
            session.response()
        );
        *counts.entry((case.kind.to_owned(), verdict)).or_default() += 1;
    }
    for ((kind, verdict), count) in &counts {
        println!("== {kind} {verdict}: {count}");
    }
    counts
}

/// Counts how often the screening, by itself, marks what a file says: the kinds of marks, and their words but for signs
/// and spaces.
fn compare_marks(text: &str, is_shown: bool) -> BTreeMap<(String, bool), usize> {
    let mut model = opened::model();
    let kinds = |marks: &[Mark]| {
        let names: Vec<&str> = marks.iter().map(|mark| mark.gap.name()).collect();
        match names.is_empty() {
            true => "nothing".to_owned(),
            false => names.join(" "),
        }
    };
    let mut counts = BTreeMap::new();
    for case in text.trim().split("\n\n") {
        let (instruction, answer) = case.split_once('\n').unwrap();
        let mut dialogue = ScreeningDialogue::new(instruction);
        let found = longstep_llm::converse(&mut *model, &mut dialogue, &mut |_: Progress| {}).unwrap();
        let expected = Reply::complete(answer);
        let expected = ScreeningDialogue::new(instruction).supply(&expected).unwrap().unwrap();
        let words = |marks: &[Mark]| -> Vec<(Gap, String)> {
            let letters = |mark: &Mark| instruction[mark.range.clone()].matches(char::is_alphanumeric).collect();
            marks.iter().map(|mark| (mark.gap, letters(mark))).collect()
        };
        let is_right = words(&found) == words(&expected);
        if is_shown {
            let quoted: Vec<&str> = found.iter().map(|mark| &instruction[mark.range.clone()]).collect();
            println!("{is_right:5} {instruction}  ->  {} {quoted:?}", kinds(&found));
        }
        let same = kinds(&found) == kinds(&expected);
        *counts.entry((kinds(&expected), same)).or_default() += 1;
        if !is_right && same {
            *counts
                .entry((format!("{}, other words", kinds(&expected)), same))
                .or_default() += 1;
        }
    }
    for ((kinds, same), count) in &counts {
        println!("== {kinds}, {}: {count}", if *same { "found" } else { "not found" });
    }
    counts
}

/// Eighty instructions for two robots that no screening has seen. Of the test half only totals are printed.
#[test]
#[ignore = "asks a real model about prohibitions, and about sentences with a negation that forbid nothing"]
fn prohibitions() {
    let all = include_str!("screening/prohibitions.txt");
    for (name, first) in [("development", 0), ("test", 1)] {
        println!("=== {name}");
        let half: Vec<&str> = all.trim().split("\n\n").skip(first).step_by(2).collect();
        let counts = compare_marks(&half.join("\n\n"), name == "development");
        let of = |same| {
            counts
                .get(&("prohibition".to_owned(), same))
                .copied()
                .unwrap_or_default()
        };
        assert!(of(true) > of(false), "{counts:?}");
    }
}

#[test]
#[ignore = "asks a real model about the instructions on which the screening was made"]
fn development() {
    let counts = measure(include_str!("screening/development.txt"));
    assert!(counts.keys().all(|(_, verdict)| *verdict != "forbidden"), "{counts:?}");
}

#[test]
#[ignore = "asks a real model about instructions that were written before anything was run"]
fn test() {
    let counts = measure(include_str!("screening/test.txt"));
    assert!(counts.keys().all(|(_, verdict)| *verdict != "forbidden"), "{counts:?}");
}

#[test]
#[ignore = "asks a real model about messages, numbers in words, times and conditions"]
fn held() {
    measure(include_str!("screening/held.txt"));
}

/// Plans leave out fewer messages, amounts and conditions than are asked about.
#[test]
#[ignore = "asks a real model about instructions of the same kinds, by somebody else"]
fn sealed() {
    let counts = measure(include_str!("screening/sealed.txt"));
    let of = |verdict: &str| -> usize {
        let own = counts
            .iter()
            .filter(|((kind, _), _)| kind != "N")
            .filter(|((_, own), _)| *own == verdict);
        own.map(|(_, count)| count).sum()
    };
    assert!(of("dropped") < of("question") + of("right"), "{counts:?}");
}
