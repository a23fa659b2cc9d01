use super::*;
use crate::domain::{load, shipped_files, shipped_names, starter};

fn starter_files() -> Files {
    let files = starter("porter");
    let text = |path: &str| files.iter().find(|(known, _)| known == path).unwrap().1.clone();
    Files {
        folder: String::new(),
        pddl: text("domain.pddl"),
        words: text("domain.toml"),
        goal_prompt: text("prompt/goal.md"),
        examples: text("prompt/examples.toml"),
    }
}

fn greenhouse_files() -> Files {
    Files {
        folder: String::new(),
        pddl: include_str!("../../../../../examples/greenhouse/domain.pddl").to_owned(),
        words: include_str!("../../../../../examples/greenhouse/domain.toml").to_owned(),
        goal_prompt: include_str!("../../../../../examples/greenhouse/prompt/goal.md").to_owned(),
        examples: include_str!("../../../../../examples/greenhouse/prompt/examples.toml").to_owned(),
    }
}

/// What is found in the starter after the changes: each `file: from -> to`, where a `from` that ends with `$` stands
/// for the end of the file.
fn found(changes: &[(&str, &str, &str)]) -> Vec<Finding> {
    let mut files = starter_files();
    for (file, from, to) in changes {
        let text = match *file {
            "pddl" => &mut files.pddl,
            "toml" => &mut files.words,
            _ => &mut files.examples,
        };
        assert!(text.contains(from), "{file} has no `{from}`");
        *text = text.replacen(from, to, 1);
    }
    let domain = load(&files).unwrap_or_else(|findings| panic!("{findings}"));
    lint(&domain, &files)
}

/// Findings as `place: lint of names`.
#[track_caller]
fn check(changes: &[(&str, &str, &str)], expected: &[&str]) {
    let found = found(changes);
    let short = |finding: &Finding| {
        let Diagnostic { file, position, .. } = &finding.diagnostic;
        let place = position.unwrap();
        let of = finding.of.join(", ");
        format!(
            "{file}:{}:{}: {} of {of}",
            place.line,
            place.column,
            finding.lint.name()
        )
    };
    let text: Vec<String> = found.iter().map(ToString::to_string).collect();
    eprintln!("{}", text.join("\n"));
    assert_eq!(
        found.iter().map(short).collect::<Vec<_>>(),
        expected,
        "{}",
        text.join("\n")
    );
}

const FLY: &str =
    "(:action fly :parameters (?to - station) :precondition (winged) :effect (robot-at ?to)) (:action drive";
const WINGED: &str = "(robot-at ?station - station) (winged)";
const FLY_WORDS: &str = "[[predicate]]\nname = \"winged\"\nsays = \"the robot has wings\"\ndenies = \"it has none\"\n\n\
    [[action]]\nname = \"fly\"\ncall = \"fly(?to)\"\nsays = \"fly to {to}\"\nmeans = \"Fly to a station.\"\n\n[[rule]]";

#[test]
fn our_own_domains_are_clean() {
    let shipped = shipped_names().into_iter().filter_map(shipped_files);
    for files in shipped.chain([greenhouse_files(), starter_files()]) {
        let domain = load(&files).unwrap_or_else(|findings| panic!("{findings}"));
        let found: Vec<String> = lint(&domain, &files).iter().map(ToString::to_string).collect();
        assert_eq!(found, Vec::<String>::new());
    }
}

#[test]
fn actions_that_can_never_apply() {
    // Nothing makes it true.
    check(
        &[
            ("pddl", "(robot-at ?station - station)", WINGED),
            ("pddl", "(:action drive", FLY),
            ("toml", "[[rule]]", FLY_WORDS),
        ],
        &["domain.pddl:18:58: never-applicable of fly"],
    );
    // Only an action that can never apply itself makes it true.
    check(
        &[
            ("pddl", "(robot-at ?station - station)", WINGED),
            (
                "pddl",
                "(:action drive",
                &FLY.replace("(robot-at ?to))", "(and (winged) (robot-at ?to)))"),
            ),
            ("toml", "[[rule]]", FLY_WORDS),
        ],
        &["domain.pddl:18:58: never-applicable of fly"],
    );
    // A fact and its opposite.
    check(
        &[(
            "pddl",
            "(and (robot-at ?to) (carrying",
            "(and (robot-at ?to) (not (robot-at ?to)) (carrying",
        )],
        &["domain.pddl:31:24: never-applicable of drop"],
    );
    // A fact and its opposite of everything.
    check(
        &[(
            "pddl",
            "(and (robot-at ?from) (at",
            "(and (carrying ?parcel) (robot-at ?from) (at",
        )],
        &["domain.pddl:25:24: never-applicable of pick"],
    );
    // Behind `or` and `exists`.
    check(
        &[(
            "pddl",
            ":precondition (not (robot-at ?to))",
            ":precondition (or (not (= ?to ?to)) (exists (?p - parcel) (and (carrying ?p) (not (carrying ?p)))))",
        )],
        &["domain.pddl:20:24: never-applicable of drive"],
    );
    // A type that no entity has.
    check(
        &[
            ("pddl", "(:types station", "(:types dock - station station"),
            (
                "pddl",
                "(?to - station)\n    :precondition (not",
                "(?to - dock)\n    :precondition (not",
            ),
        ],
        &["domain.pddl:19:23: never-applicable of drive"],
    );
    // Two types that no entity has together.
    check(
        &[
            (
                "pddl",
                "(?to - station)\n    :precondition (not",
                "(?to - thing ?p - parcel)\n    :precondition (and (= ?to ?p) (carrying ?p) (robot-at ?to)) :effect (and) ) (:action x :parameters (?to - station) :precondition (not",
            ),
            (
                "toml",
                "[[rule]]",
                "[[action]]\nname = \"x\"\ncall = \"x(?to)\"\nsays = \"x {to}\"\nmeans = \"Go there.\"\n\n[[rule]]",
            ),
        ],
        &[],
    );
    // An effect that never happens.
    check(
        &[(
            "pddl",
            ":effect (and (at ?parcel ?to)",
            ":effect (and (when (not (carrying ?parcel)) (robot-at ?to)) (at ?parcel ?to)",
        )],
        &["domain.pddl:32:24: never-applicable of drop, robot-at"],
    );
}

#[test]
fn what_can_be_is_left_alone() {
    for precondition in [
        // Different variables of the same slot.
        "(and (exists (?p - parcel) (carrying ?p)) (exists (?p - parcel) (not (carrying ?p))))",
        // Now and at the start.
        "(or (not (robot-at ?to)) (robot-at ?to))",
        // Of everything else.
        "(exists (?p - parcel) (and (carrying ?p) (forall (?o - parcel) (imply (not (= ?o ?p)) (not (carrying ?o))))))",
        // Another argument.
        "(exists (?s - station) (and (robot-at ?s) (not (robot-at ?to))))",
    ] {
        let precondition = format!(":precondition {precondition}");
        check(&[("pddl", ":precondition (not (robot-at ?to))", &precondition)], &[]);
    }
}
