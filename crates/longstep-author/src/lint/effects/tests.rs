//! Wrong effects, planted one at a time into robots that are right.

use crate::lint::{Lint, lint};
use crate::new_domain::{Answers, from_answers};
use longstep::domain::{Files, load, starter};

macro_rules! example {
    ($name:literal) => {
        Files {
            pddl: include_str!(concat!("../../../../../examples/", $name, "/domain.pddl")).to_owned(),
            words: include_str!(concat!("../../../../../examples/", $name, "/domain.toml")).to_owned(),
            goal_prompt: include_str!(concat!("../../../../../examples/", $name, "/prompt/goal.md")).to_owned(),
            examples: include_str!(concat!("../../../../../examples/", $name, "/prompt/examples.toml")).to_owned(),
            ..Files::default()
        }
    };
}

/// Boxes and lids on shelves, with a hand that is a fact of its own; untyped, as textbooks write it.
const HAND: &str = "(define (domain hand)
  (:predicates (box ?b) (shelf ?s) (on ?b ?s) (in ?b ?s) (holding ?b) (hand-empty) (robot-at ?s) (path ?s ?t))
  (:action walk :parameters (?from ?to) :precondition (and (shelf ?from) (shelf ?to) (path ?from ?to) (robot-at ?from))
    :effect (and (robot-at ?to) (not (robot-at ?from))))
  (:action pick :parameters (?b ?s) :precondition (and (box ?b) (shelf ?s) (robot-at ?s) (on ?b ?s) (hand-empty))
    :effect (and (holding ?b) (not (on ?b ?s)) (not (hand-empty))))
  (:action pull :parameters (?b ?s) :precondition (and (box ?b) (shelf ?s) (robot-at ?s) (in ?b ?s) (hand-empty))
    :effect (and (holding ?b) (not (in ?b ?s)) (not (hand-empty))))
  (:action put :parameters (?b ?s) :precondition (and (box ?b) (shelf ?s) (robot-at ?s) (holding ?b))
    :effect (and (on ?b ?s) (hand-empty) (not (holding ?b))))
  (:action push :parameters (?b ?s) :precondition (and (box ?b) (shelf ?s) (robot-at ?s) (holding ?b))
    :effect (and (in ?b ?s) (hand-empty) (not (holding ?b)))))";

/// Answers to the questions of `longstep domain new`.
const CARRIER: &str = r#"
name = "carrier"
kind = [{ name = "tray" }, { name = "table", stays = true }]
[[action]]
words = "drive to a table"
needs = ["the table is on the floor", "the table is open"]
then = ["the carrier is at the table"]
no_longer = ["the carrier is at any table"]
[[action]]
words = "pick up a tray from a table"
needs = ["the carrier is at the table", "the tray is on the table", "the carrier holds no tray"]
then = ["the carrier holds the tray"]
no_longer = ["the tray is on the table"]
[[action]]
words = "put a tray on a table"
needs = ["the carrier is at the table", "the carrier holds the tray"]
then = ["the tray is on the table"]
no_longer = ["the carrier holds the tray"]
"#;

/// A robot without a parameter for itself, which goes to places of two kinds and to a thing with opposite states.
const SAMPLER: &str = r#"
name = "sampler"
robot = "sampler"
kind = [{ name = "tube" }, { name = "rack", stays = true }, { name = "centrifuge", stays = true }]
[[action]]
words = "drive to a rack"
then = ["the sampler is at the rack"]
[[action]]
words = "drive to a centrifuge"
then = ["the sampler is at the centrifuge"]
[[action]]
words = "open a centrifuge"
needs = ["the sampler is at the centrifuge", "the centrifuge is closed"]
then = ["the centrifuge is open"]
no_longer = ["the centrifuge is closed"]
[[action]]
words = "close a centrifuge"
needs = ["the sampler is at the centrifuge", "the centrifuge is open"]
then = ["the centrifuge is closed"]
no_longer = ["the centrifuge is open"]
[[action]]
words = "spin a tube in a centrifuge"
needs = ["the sampler is at the centrifuge", "the centrifuge is closed"]
then = ["the tube is spun"]
no_longer = []
[[action]]
words = "take a tube from a rack"
needs = ["the sampler is at the rack", "the tube is on the rack", "the sampler holds no tube"]
then = ["the sampler holds the tube"]
[[action]]
words = "put a tube on a rack"
needs = ["the sampler is at the rack", "the sampler holds the tube"]
then = ["the tube is on the rack"]
"#;

fn robot(name: &str) -> Files {
    let made = |files: Vec<(String, String)>| Files::from_texts("", files);
    let mut files = match name {
        "starter" => made(starter("porter")),
        "hand" => {
            let source = crate::SourceText { file: "d", text: HAND };
            let new = crate::from_any_pddl("hand", source, None).unwrap_or_else(|found| panic!("{found}"));
            made(new.files)
        }
        "carrier" => {
            let answers = Answers::read(
                "answers.toml",
                &CARRIER.replace("\nkind", "\nrobot = \"the carrier\"\nkind"),
            );
            let new = from_answers(&answers.unwrap()).unwrap_or_else(|found| panic!("{found}"));
            made(new.files)
        }
        "sampler" => {
            let new = from_answers(&Answers::read("answers.toml", SAMPLER).unwrap());
            made(new.unwrap_or_else(|found| panic!("{found}")).files)
        }
        "greenhouse" => example!("greenhouse"),
        "warehouse" => example!("warehouse"),
        "care" => example!("care"),
        "home" => example!("home"),
        "laboratory" => example!("laboratory"),
        _ => example!("workshop"),
    };
    files.parts.clear();
    files.feedback.clear();
    files
}

/// Returns the findings about the effects of a robot with a change to its PDDL, each with its hint.
fn found(name: &str, from: &str, to: &str) -> Vec<String> {
    let mut files = robot(name);
    let lines = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let pddl: Vec<&str> = files
        .pddl
        .lines()
        .map(|line| line.split(';').next().unwrap_or_default())
        .collect();
    files.pddl = lines(&pddl.join("\n"));
    assert!(
        files.pddl.contains(&lines(from)),
        "{name} has no `{from}`:\n{}",
        files.pddl
    );
    files.pddl = files.pddl.replacen(&lines(from), &lines(to), 1);
    let domain = load(&files).unwrap_or_else(|found| panic!("{name}: {found}"));
    let not_about_effects = [Lint::UnreadEffect, Lint::UnusedPredicate, Lint::DeadState];
    let findings = lint(&domain, &files)
        .into_iter()
        .filter(|own| !not_about_effects.contains(&own.lint));
    findings.map(|own| own.to_string()).collect()
}

#[test]
fn effect_lint_accepts_correct_domains() {
    for name in [
        "starter",
        "hand",
        "carrier",
        "sampler",
        "greenhouse",
        "warehouse",
        "care",
        "home",
        "laboratory",
        "workshop",
    ] {
        let found = found(name, "(define", "(define");
        let found: Vec<&String> = found.iter().filter(|own| own.contains("effect")).collect();
        assert!(found.is_empty(), "{name}: {found:#?}");
    }
}

/// Robot, old text, new text, lint, action, and predicate.
const PLANTED: &[[&str; 6]] = &[
    // An effect too much: a fact of the target that nothing makes true again.
    [
        "carrier",
        "(not (carrier-at ?any_table)))",
        "(not (carrier-at ?any_table))) (not (open ?table))",
        "lost-fact",
        "drive-to",
        "open",
    ],
    [
        "carrier",
        "(not (carrier-at ?any_table)))",
        "(not (carrier-at ?any_table))) (not (on-floor ?table))",
        "lost-fact",
        "drive-to",
        "on-floor",
    ],
    [
        "warehouse",
        "(charged) (increase",
        "(charged) (not (charger ?place)) (increase",
        "lost-fact",
        "charge",
        "charger",
    ],
    [
        "warehouse",
        "(forall (?from - place) (not (robot-at ?from))) (robot-at ?to)",
        "(forall (?from - place) (not (robot-at ?from))) (robot-at ?to) (blocked ?to)",
        "lost-fact",
        "drive",
        "blocked",
    ],
    [
        "laboratory",
        ":effect (and (forall (?vessel - vessel) (when (in ?vessel ?fixture) (spun ?vessel)))",
        ":effect (and (not (centrifuge ?fixture)) (forall (?vessel - vessel) (when (in ?vessel ?fixture) (spun ?vessel)))",
        "lost-fact",
        "spin",
        "centrifuge",
    ],
    [
        "home",
        "(forall (?other - temperature) (not (set-to ?device ?other)))",
        "(not (thermostat ?device)) (forall (?other - temperature) (not (set-to ?device ?other)))",
        "lost-fact",
        "set",
        "thermostat",
    ],
    // The old place or the hand is kept.
    [
        "hand",
        "(on ?b ?s) (hand-empty) (not (holding ?b))",
        "(on ?b ?s) (hand-empty)",
        "conflicting-facts",
        "put",
        "holding",
    ],
    [
        "hand",
        "(holding ?b) (not (on ?b ?s)) (not (hand-empty))",
        "(holding ?b) (not (hand-empty))",
        "conflicting-facts",
        "pick",
        "on",
    ],
    [
        "hand",
        "(holding ?b) (not (on ?b ?s)) (not (hand-empty))",
        "(holding ?b) (not (on ?b ?s))",
        "conflicting-facts",
        "pick",
        "hand-empty",
    ],
    [
        "starter",
        "(at ?parcel ?to) (not (carrying ?parcel))",
        "(at ?parcel ?to)",
        "conflicting-facts",
        "drop",
        "carrying",
    ],
    [
        "starter",
        "(carrying ?parcel) (not (at ?parcel ?from))",
        "(carrying ?parcel)",
        "conflicting-facts",
        "pick",
        "at",
    ],
    [
        "starter",
        "(forall (?from - station) (not (robot-at ?from)))",
        "",
        "permanent-fact",
        "drive",
        "robot-at",
    ],
    [
        "hand",
        "(robot-at ?to) (not (robot-at ?from))",
        "(robot-at ?to)",
        "permanent-fact",
        "walk",
        "robot-at",
    ],
    [
        "home",
        "(at ?item ?to) (not (at ?item ?from))",
        "(at ?item ?to)",
        "permanent-fact",
        "carry",
        "at",
    ],
    // Nothing says where the object is.
    [
        "hand",
        "(in ?b ?s) (hand-empty) (not (holding ?b))",
        "(hand-empty) (not (holding ?b))",
        "vanished-object",
        "push",
        "holding",
    ],
    [
        "hand",
        "(holding ?b) (not (in ?b ?s)) (not (hand-empty))",
        "(not (in ?b ?s))",
        "vanished-object",
        "pull",
        "in",
    ],
    // An effect that is there before.
    [
        "greenhouse",
        ":effect (vent-open ?bed)",
        ":effect (not (vent-open ?bed))",
        "idle-effect",
        "open-vent",
        "vent-open",
    ],
    [
        "home",
        ":effect (not (locked ?device))",
        ":effect (locked ?device)",
        "idle-effect",
        "unlock",
        "locked",
    ],
    [
        "hand",
        "(robot-at ?to) (not (robot-at ?from))",
        "(robot-at ?from) (not (robot-at ?to))",
        "idle-effect",
        "walk",
        "robot-at",
    ],
    [
        "care",
        ":effect (not (asleep ?person))",
        ":effect (asleep ?person)",
        "idle-effect",
        "wake",
        "asleep",
    ],
    // One fact both ways.
    [
        "greenhouse",
        ":effect (can-full)",
        ":effect (and (can-full) (not (can-full)))",
        "contradictory-effect",
        "fill",
        "can-full",
    ],
    // The wrong entity.
    [
        "hand",
        "(on ?b ?s) (hand-empty) (not (holding ?b))",
        "(on ?s ?b) (hand-empty) (not (holding ?b))",
        "swapped-arguments",
        "put",
        "on",
    ],
    [
        "greenhouse",
        ":effect (vent-open ?bed)",
        ":effect (forall (?any - bed) (vent-open ?any))",
        "effect-on-all",
        "open-vent",
        "vent-open",
    ],
    // The robot is at two places or at none, and a thing in neither of two opposite states.
    [
        "sampler",
        "(not (sampler-at-centrifuge ?any_centrifuge))) (forall (?any_rack - rack) (not (sampler-at ?any_rack))) (sampler-at-centrifuge ?centrifuge)",
        "(not (sampler-at-centrifuge ?any_centrifuge))) (sampler-at-centrifuge ?centrifuge)",
        "conflicting-facts",
        "drive-to-centrifuge",
        "sampler-at",
    ],
    [
        "sampler",
        "(spun ?tube)))",
        "(spun ?tube) (not (sampler-at-centrifuge ?centrifuge))))",
        "vanished-object",
        "spin-in",
        "sampler-at-centrifuge",
    ],
    [
        "sampler",
        "(spun ?tube)))",
        "(spun ?tube) (not (closed ?centrifuge))))",
        "vanished-object",
        "spin-in",
        "closed",
    ],
    // The wrong direction of a number.
    [
        "warehouse",
        "(charged) (increase (battery) 20)",
        "(charged) (decrease (battery) 20)",
        "wrong-direction",
        "charge",
        "battery",
    ],
    [
        "warehouse",
        "(decrease (battery) 2)",
        "(increase (battery) 2)",
        "wrong-direction",
        "drive",
        "battery",
    ],
];

#[test]
fn planted_wrong_effects_are_found() {
    let mut missed = Vec::new();
    for [name, from, to, lint, action, predicate] in PLANTED {
        let found = found(name, from, to);
        let says = |own: &&String| {
            own.contains(&format!("[{lint}]"))
                && own.contains(&format!("`{action}`"))
                && own.contains(predicate)
                && own.contains("hint: ")
        };
        if found.iter().filter(says).count() != 1 {
            missed.push(format!("{name}, {lint} of {action} and {predicate}: {found:#?}"));
        }
    }
    assert!(
        missed.is_empty(),
        "{} of {}\n{}",
        missed.len(),
        PLANTED.len(),
        missed.join("\n")
    );
}
