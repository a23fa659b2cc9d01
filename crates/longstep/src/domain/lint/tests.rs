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

/// A change to one of the starter's files: which, what, and what instead.
type Change<'a> = (&'a str, &'a str, &'a str);

/// Findings in the starter after some changes.
fn found(changes: &[Change<'_>]) -> Vec<Finding> {
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
    let domain = load(&files).unwrap_or_else(|findings| panic!("{changes:?}\n{findings}"));
    lint(&domain, &files)
}

/// Checks each case: what it is, the changes, and what is found then, as `place lint names`.
#[track_caller]
fn check(cases: &[(&str, &[Change<'_>], &[&str])]) {
    let short = |finding: &Finding| {
        let Diagnostic { file, position, .. } = &finding.diagnostic;
        let place = position.unwrap();
        let of = finding.of.join(" ");
        format!("{file}:{}:{} {} {of}", place.line, place.column, finding.lint.name())
    };
    let mut wrong = String::new();
    for (what, changes, expected) in cases {
        let found = found(changes);
        if found.iter().map(short).collect::<Vec<_>>() != *expected {
            wrong += &format!("\n{what}: expected {expected:#?}, found");
            found
                .iter()
                .for_each(|finding| wrong += &format!("\n{}\n  ({})", finding, short(finding)));
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Changes that add a predicate without arguments and an action with this precondition and effect.
fn with_fly<'a>(pddl: &'a str) -> [Change<'a>; 3] {
    [
        (
            "pddl",
            "(carrying ?parcel - parcel))\n",
            "(carrying ?parcel - parcel) (winged))\n",
        ),
        ("pddl", "(:action drive", pddl),
        (
            "toml",
            "[[rule]]",
            r#"
[[predicate]]
name = "winged"
says = "the robot has wings"
denies = "the robot has no wings"

[[action]]
name = "fly"
call = "fly(?to)"
says = "fly to {to}"
means = "Fly to a station."

[[rule]]"#,
        ),
    ]
}

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
fn every_lint_is_in_the_documentation() {
    let documentation = include_str!("../../../../../docs/domains.md");
    for lint in Lint::ALL {
        assert!(documentation.contains(&format!("`{}`", lint.name())), "{lint:?}");
    }
}

#[test]
fn actions_that_can_never_apply() {
    let fly = |rest: &str| format!("(:action fly :parameters (?to - station) {rest})\n(:action drive");
    let nothing = fly(":precondition (winged) :effect (robot-at ?to)");
    let itself = fly(":precondition (winged) :effect (and (winged) (robot-at ?to))");
    check(&[
        (
            "nothing makes it true",
            &with_fly(&nothing),
            &["domain.pddl:17:58 never-applicable fly"],
        ),
        (
            "only the action itself makes it true",
            &with_fly(&itself),
            &["domain.pddl:17:58 never-applicable fly"],
        ),
        (
            "a fact and its opposite",
            &[(
                "pddl",
                "(and (robot-at ?to) (carrying",
                "(and (robot-at ?to) (not (robot-at ?to)) (carrying",
            )],
            &["domain.pddl:31:24 never-applicable drop"],
        ),
        (
            "a fact and its opposite of everything",
            &[(
                "pddl",
                "(and (robot-at ?from) (at",
                "(and (carrying ?parcel) (robot-at ?from) (at",
            )],
            &["domain.pddl:25:24 never-applicable pick"],
        ),
        (
            "behind `or` and `exists`",
            &[(
                "pddl",
                ":precondition (not (robot-at ?to))",
                ":precondition (or (not (= ?to ?to)) (exists (?p - parcel) (and (carrying ?p) (not (carrying ?p)))))",
            )],
            &["domain.pddl:19:28 never-applicable drive"],
        ),
        (
            "a type that no entity has",
            &[
                ("pddl", "(:types station", "(:types dock - station station"),
                (
                    "pddl",
                    "(?to - station)\n    :precondition (not",
                    "(?to - dock)\n    :precondition (not",
                ),
            ],
            &["domain.pddl:18:24 never-applicable drive"],
        ),
        (
            "two things that are never the same",
            &[(
                "pddl",
                ":precondition (not (robot-at ?to))",
                ":precondition (exists (?p - parcel) (= ?p ?to))",
            )],
            &["domain.pddl:19:41 never-applicable drive"],
        ),
        (
            "an effect that never happens",
            &[(
                "pddl",
                ":effect (and (at ?parcel ?to)",
                ":effect (and (when (not (carrying ?parcel)) (robot-at ?to)) (at ?parcel ?to)",
            )],
            &["domain.pddl:32:29 never-applicable drop robot-at"],
        ),
    ]);
}

#[test]
fn what_can_be_is_left_alone() {
    for precondition in [
        // Different variables of the same slot.
        "(and (exists (?p - parcel) (carrying ?p)) (exists (?p - parcel) (not (carrying ?p))))",
        "(or (not (robot-at ?to)) (robot-at ?to))",
        // Of everything else.
        "(exists (?p - parcel) (and (carrying ?p) (forall (?o - parcel) (imply (not (= ?o ?p)) (not (carrying ?o))))))",
        // Another argument.
        "(exists (?s - station) (and (robot-at ?s) (not (robot-at ?to))))",
    ] {
        let changed = format!(":precondition {precondition}");
        check(&[(
            precondition,
            &[("pddl", ":precondition (not (robot-at ?to))", &changed)],
            &[],
        )]);
    }
}

const GOAL: &str = "condition = \"(at ?parcel ?station)\"\nsubject";

#[test]
fn goals_rules_and_facts_that_can_never_be() {
    let goal = |condition: &str| format!("condition = \"{condition}\"\nsubject");
    let offered = goal("(at ?parcel ?station)\"\noffered = \"(winged)");
    let fly = "(:action fly :parameters (?to - station) :precondition (not (robot-at ?to)) :effect (and (winged) (robot-at ?to)))\n(:action drive";
    let grounded = "(:action fly :parameters (?to - station) :precondition (and (not (winged)) (not (robot-at ?to))) :effect (and (winged) (robot-at ?to)))\n(:action drive";
    let not_winged =
        "(:action fly :parameters (?to - station) :precondition (not (winged)) :effect (robot-at ?to))\n(:action drive";
    let winged = with_fly(not_winged);
    check(&[
        (
            "a condition that contradicts itself",
            &[(
                "toml",
                GOAL,
                &goal("(and (at ?parcel ?station) (not (at ?parcel ?station)))"),
            )],
            &["domain.toml:75:14 unreachable-goal bring({parcel}, {station})"],
        ),
        (
            "never offered",
            &[winged[0], winged[1], winged[2], ("toml", GOAL, &offered)],
            &["domain.toml:88:12 unreachable-goal bring({parcel}, {station})"],
        ),
        (
            "nothing works towards it",
            &[("toml", GOAL, &goal("(initially (at ?parcel ?station))"))],
            &["domain.toml:75:14 unreachable-goal bring({parcel}, {station})"],
        ),
        (
            "a rule that nothing breaks",
            &[
                winged[0],
                winged[1],
                winged[2],
                (
                    "toml",
                    "(not (carrying ?parcel)))\"",
                    "(not (and (winged) (carrying ?parcel))))\"",
                ),
            ],
            &["domain.toml:80:14 vacuous-rule deliver"],
        ),
        ("asked for in vain", &winged, &["domain.pddl:15:34 never-true winged"]),
        (
            "a resource that is spent for good",
            &with_fly(grounded),
            &["domain.pddl:15:34 one-way-state winged"],
        ),
        (
            "what nobody needs back may be spent",
            &with_fly(fly),
            &["domain.pddl:17:92 unread-effect winged"],
        ),
        (
            "a hand that never lets go",
            &[("pddl", "(at ?parcel ?to) (not (carrying ?parcel))", "(at ?parcel ?to)")],
            &["domain.pddl:15:6 one-way-state carrying"],
        ),
    ]);
}

#[test]
fn what_nothing_reads() {
    let idle = |effect: &str| {
        format!("(:action fly :parameters (?to - station) :precondition (robot-at ?to) {effect})\n(:action drive")
    };
    let (none, unread, both) = (
        idle(""),
        idle(":effect (winged)"),
        idle(":effect (and (robot-at ?to) (not (robot-at ?to)))"),
    );
    check(&[
        (
            "no effect",
            &with_fly(&none),
            &[
                "domain.pddl:15:34 unused-predicate winged",
                "domain.pddl:17:12 useless-action fly",
            ],
        ),
        (
            "an effect that nothing reads",
            &with_fly(&unread),
            &["domain.pddl:17:12 useless-action fly"],
        ),
        (
            "an effect and its opposite",
            &with_fly(&both),
            &[
                "domain.pddl:15:34 unused-predicate winged",
                "domain.pddl:17:86 contradictory-effect fly robot-at",
            ],
        ),
        (
            "a state",
            &[
                (
                    "pddl",
                    "(carrying ?parcel - parcel))\n",
                    "(carrying ?parcel - parcel) (heavy ?parcel - parcel))\n",
                ),
                (
                    "toml",
                    "[[rule]]",
                    "[[predicate]]\nname = \"heavy\"\nsays = \"{parcel} is heavy\"\ndenies = \"{parcel} is light\"\n\n              [[state]]\nword = \"heavy\"\nfact = \"(heavy ?self)\"\nmeans = \"It weighs much.\"\n\n[[rule]]",
                ),
            ],
            &["domain.toml:71:9 dead-state heavy"],
        ),
        (
            "a state that a model sees",
            &[
                (
                    "pddl",
                    "(carrying ?parcel - parcel))\n",
                    "(carrying ?parcel - parcel) (heavy ?parcel - parcel))\n",
                ),
                (
                    "toml",
                    "[[rule]]",
                    "[[predicate]]\nname = \"heavy\"\nsays = \"{parcel} is heavy\"\ndenies = \"{parcel} is light\"\nshort = \"heavy\"\n\n              [[state]]\nword = \"heavy\"\nfact = \"(heavy ?self)\"\nmeans = \"It weighs much.\"\n\n[[rule]]",
                ),
            ],
            &[],
        ),
        (
            "a type",
            &[("pddl", "(:types station", "(:types dock - station station")],
            &["domain.pddl:10:11 unused-type dock"],
        ),
    ]);
}

const SWAP: &str = r#"
[[goal]]
form = "swap({parcel}, {parcels})"
parameters = "?parcel - parcel ?parcels - parcel"
condition = "(and (carrying ?parcel) (not (carrying ?parcels)))"
says = "{parcel} is carried instead of {parcels}"
means = "one parcel is taken in place of another"

# Everyday names"#;

#[test]
fn names_that_a_model_will_confuse() {
    check(&[
        (
            "actions",
            &[("toml", "call = \"pick(", "call = \"drop_off(")],
            &["domain.toml:60:9 confusable-names drop_off drop"],
        ),
        (
            "other things in the same places",
            &[("toml", "call = \"pick(", "call = \"drive_off(")],
            &[],
        ),
        (
            "states",
            &[
                ("toml", "word = \"carried()\"", "word = \"at_last(<station>)\""),
                ("toml", "fact = \"(carrying ?self)\"", "fact = \"(at ?self ?station)\""),
            ],
            &["domain.toml:41:9 confusable-names at at_last"],
        ),
        (
            "parameters",
            &[("toml", "# Everyday names", SWAP)],
            &[
                "domain.toml:83:9 missing-example swap({parcel}, {parcels})",
                "domain.toml:84:15 confusable-names parcel parcels",
            ],
        ),
    ]);
}

#[test]
fn what_is_not_explained() {
    check(&[
        (
            "nothing",
            &[("toml", "means = \"Drive to another station.\"", "means = \" \"")],
            &["domain.toml:47:9 missing-explanation drive"],
        ),
        (
            "only the name",
            &[("toml", "means = \"Drive to another station.\"", "means = \"Drive.\"")],
            &["domain.toml:47:9 missing-explanation drive"],
        ),
        (
            "no sentence",
            &[("toml", "says = \"drive to {to}\"", "says = \"\"")],
            &["domain.toml:49:9 missing-explanation drive"],
        ),
        (
            "a sentence without its thing",
            &[("toml", "says = \"drive to {to}\"", "says = \"drive\"")],
            &["domain.toml:49:9 unnamed-parameter drive to"],
        ),
        (
            "the same explanation",
            &[(
                "toml",
                "means = \"The robot carries the parcel.\"",
                "means = \"The robot is at this station\"",
            )],
            &["domain.toml:41:9 same-explanation robot_here carried"],
        ),
        (
            "the same sentence",
            &[(
                "toml",
                "says = \"set down {parcel} at {to}\"",
                "says = \"pick up {parcel} at {to}\"",
            )],
            &["domain.toml:61:9 same-explanation pick drop"],
        ),
        (
            "not denied",
            &[(
                "toml",
                "denies = \"the robot does not carry {parcel}\"",
                "denies = \"the robot carries {parcel}\"",
            )],
            &["domain.toml:26:11 same-explanation carrying"],
        ),
        (
            "a goal that is not shown",
            &[(
                "toml",
                "# Everyday names",
                "[[goal]]\nform = \"loaded({parcel})\"\nparameters = \"?parcel - parcel\"\ncondition = \"(carrying ?parcel)\"\nsays = \"{parcel} is loaded\"\nmeans = \"the robot carries it\"\n# Everyday names",
            )],
            &["domain.toml:82:9 missing-example loaded({parcel})"],
        ),
        (
            "no question",
            &[(
                "examples",
                "question: I see no trumpet here. Which thing do you mean?",
                "bring(letter, hangar)",
            )],
            &["prompt/examples.toml:1:1 missing-example question"],
        ),
    ]);
}

#[test]
fn findings_can_be_accepted() {
    let accept = |lint: &str, of: &str, why: &str| {
        format!("[[accept]]\nlint = \"{lint}\"\nof = [{of}]\nwhy = \"{why}\"\n\n[[rule]]")
    };
    let renamed = ("toml", "call = \"pick(", "call = \"drop_off(");
    check(&[
        (
            "with a reason",
            &[
                renamed,
                (
                    "toml",
                    "[[rule]]",
                    &accept("confusable-names", r#""drop", "drop_off""#, "They say so."),
                ),
            ],
            &[],
        ),
        (
            "without one",
            &[
                renamed,
                (
                    "toml",
                    "[[rule]]",
                    &accept("confusable-names", r#""drop", "drop_off""#, ""),
                ),
            ],
            &["domain.toml:68:8 stale-acceptance drop drop_off"],
        ),
        (
            "another",
            &[(
                "toml",
                "[[rule]]",
                &accept("confusable-names", r#""drop""#, "They say so."),
            )],
            &["domain.toml:66:9 stale-acceptance drop"],
        ),
        (
            "unknown",
            &[(
                "toml",
                "[[rule]]",
                &accept("confusing-names", r#""drop""#, "They say so."),
            )],
            &["domain.toml:66:9 stale-acceptance drop"],
        ),
    ]);
}
