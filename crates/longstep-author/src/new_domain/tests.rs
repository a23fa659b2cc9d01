//! New domains from textbook PDDL and from answers.

use super::{Answers, NewDomain, SourceText, from_answers, from_any_pddl, samples};
use crate::lint::Lint;
use longstep_core::testing;

const BLOCKS: &str = "(define (domain BLOCKS)
  (:predicates (on ?x ?y) (ontable ?x) (clear ?x) (handempty) (holding ?x))
  (:action pick-up :parameters (?x) :precondition (and (clear ?x) (ontable ?x) (handempty))
    :effect (and (not (ontable ?x)) (not (clear ?x)) (not (handempty)) (holding ?x)))
  (:action put-down :parameters (?x) :precondition (holding ?x)
    :effect (and (not (holding ?x)) (clear ?x) (handempty) (ontable ?x)))
  (:action stack :parameters (?x ?y) :precondition (and (holding ?x) (clear ?y))
    :effect (and (not (holding ?x)) (not (clear ?y)) (clear ?x) (handempty) (on ?x ?y)))
  (:action unstack :parameters (?x ?y) :precondition (and (on ?x ?y) (clear ?x) (handempty))
    :effect (and (holding ?x) (clear ?y) (not (clear ?x)) (not (handempty)) (not (on ?x ?y)))))";

const TOWER: &str = "(define (problem tower) (:domain BLOCKS) (:objects A B C)
  (:init (ON A B) (ONTABLE B) (ONTABLE C) (CLEAR A) (CLEAR C) (HANDEMPTY)) (:goal (ON B C)))";

/// Untyped: the kinds of objects are facts.
const GRIPPER: &str = "(define (domain gripper-strips)
  (:predicates (room ?r) (ball ?b) (gripper ?g) (at-robby ?r) (at ?b ?r) (free ?g) (carry ?o ?g))
  (:action move :parameters (?from ?to) :precondition (and (room ?from) (room ?to) (at-robby ?from))
    :effect (and (at-robby ?to) (not (at-robby ?from))))
  (:action pick :parameters (?obj ?room ?gripper) :precondition (and (ball ?obj) (room ?room) (gripper ?gripper)
      (at ?obj ?room) (at-robby ?room) (free ?gripper))
    :effect (and (carry ?obj ?gripper) (not (at ?obj ?room)) (not (free ?gripper))))
  (:action drop :parameters (?obj ?room ?gripper) :precondition (and (ball ?obj) (room ?room) (gripper ?gripper)
      (carry ?obj ?gripper) (at-robby ?room))
    :effect (and (at ?obj ?room) (free ?gripper) (not (carry ?obj ?gripper)))))";

/// Types, costs, a constant, numbers and `either`.
const FLIGHTS: &str = "(define (domain flights) (:requirements :typing :fluents :action-costs)
  (:types plane person city - object) (:constants Hub - city)
  (:predicates (at ?x - (either plane person) ?c - city) (in ?p - person ?a - plane))
  (:functions (total-cost) - number (fuel ?a - plane) - number)
  (:action board :parameters (?p - person ?a - plane ?c - city) :precondition (and (at ?p ?c) (at ?a ?c))
    :effect (and (not (at ?p ?c)) (in ?p ?a) (increase (total-cost) 1)))
  (:action leave :parameters (?p - person ?a - plane ?c - city) :precondition (and (in ?p ?a) (at ?a ?c))
    :effect (and (not (in ?p ?a)) (at ?p ?c) (increase (total-cost) 1)))
  (:action fly :parameters (?a - plane ?from ?to - city) :precondition (and (at ?a ?from) (>= (fuel ?a) 1))
    :effect (and (not (at ?a ?from)) (at ?a ?to) (decrease (fuel ?a) 1) (increase (total-cost) 5))))";

/// Conditional effects, and an action that only takes away.
const DOORS: &str = "(define (domain doors) (:requirements :adl) (:types door room - object)
  (:predicates (open ?d - door) (robot-in ?r - room) (joins ?d - door ?a ?b - room) (warm ?r - room))
  (:action open-door :parameters (?d - door) :precondition (not (open ?d)) :effect (open ?d))
  (:action close-door :parameters (?d - door) :precondition (open ?d) :effect (not (open ?d)))
  (:action go :parameters (?d - door ?a ?b - room) :precondition (and (robot-in ?a) (open ?d) (joins ?d ?a ?b))
    :effect (and (robot-in ?b) (not (robot-in ?a)) (when (warm ?a) (warm ?b)))))";

const PORTER: &str = r#"
name = "porter"
robot = "the porter"
kind = [{ name = "box", examples = ["red box", "blue box"] },
        { name = "shelf", stays = true, examples = ["top shelf", "low shelf"] },
        { name = "door", stays = true, examples = ["front door"] }]
start = ["the red box is on the top shelf", "the blue box is on the low shelf"]
[[action]]
words = "pick up a box"
needs = ["the box is on a shelf", "the porter holds no box"]
then = ["the porter holds the box"]
[[action]]
words = "put a box on a shelf"
needs = ["the porter holds the box"]
then = ["the box is on the shelf"]
[[action]]
words = "open a door"
needs = ["not the door is open"]
then = ["the door is open"]
[[action]]
words = "close a door"
needs = ["the door is open"]
then = ["not the door is open"]
"#;

fn made(domain: &str, problem: Option<&str>) -> NewDomain {
    let source = |file, text| SourceText { file, text };
    let problem = problem.map(|text| source("p.pddl", text));
    from_any_pddl("mine", source("d.pddl", domain), problem).unwrap_or_else(|findings| panic!("{findings}"))
}

fn text<'n>(new: &'n NewDomain, path: &str) -> &'n str {
    let found = new.files.iter().find(|(own, _)| own == path);
    &found.unwrap_or_else(|| panic!("no {path}")).1
}

fn goals(new: &NewDomain) -> Vec<String> {
    new.domain.goal_words.iter().map(|word| word.shown()).collect()
}

#[test]
fn textbook_domains_become_folders_that_load() {
    for (domain, problem, expected) in [
        (BLOCKS, None, "on ontable clear handempty holding"),
        (BLOCKS, Some(TOWER), "on ontable clear handempty holding"),
        (GRIPPER, None, "at_robby at free carry"),
        (FLIGHTS, None, "at in"),
        (DOORS, None, "open not_open robot_in warm"),
    ] {
        let new = made(domain, problem);
        let words: Vec<&str> = new.domain.goal_words.iter().map(|word| word.word.as_str()).collect();
        assert_eq!(words.join(" "), expected);
        assert_eq!(text(&new, "domain.pddl"), domain, "the PDDL stays as it is");
        assert!(new.domain.prompts.examples.len() > 4);
        assert_eq!(new.invented, problem.is_none());
        let broken = new
            .findings
            .iter()
            .find(|f| matches!(f.lint, Lint::BrokenPrompt | Lint::MissingExplanation));
        assert!(broken.is_none(), "{}", broken.unwrap());
        assert!(text(&new, "suite/instructions.toml").matches("[[case]]").count() > 2);
    }
}

#[test]
fn equal_inputs_give_equal_bytes() {
    assert_eq!(made(GRIPPER, None).files, made(GRIPPER, None).files);
    let new = made(BLOCKS, Some(TOWER));
    let world = testing::world_of(&new.domain, text(&new, "environment.json"));
    let said = |seed| {
        samples(&world, 5, seed)
            .into_iter()
            .map(|s| s.instruction)
            .collect::<Vec<_>>()
    };
    assert_eq!(said(3), said(3));
    assert_eq!(said(3).len(), 5);
    assert_ne!(said(3), said(4));
}

#[test]
fn a_problem_becomes_the_environment() {
    let new = made(BLOCKS, Some(TOWER));
    let environment: serde_json::Value = serde_json::from_str(text(&new, "environment.json")).unwrap();
    let environment = &environment["environment"];
    assert_eq!(environment["objects"], serde_json::json!(["<a>", "<b>", "<c>"]));
    assert_eq!(
        environment["object_states"]["<a>"],
        serde_json::json!(["on(<b>)", "clear()"])
    );
    assert_eq!(environment["facts"], serde_json::json!(["handempty"]));
}

#[test]
fn from_answers_writes_pddl_types_actions_and_goals() {
    let new = from_answers(&Answers::read("answers.toml", PORTER).unwrap()).unwrap_or_else(|f| panic!("{f}"));
    let pddl = text(&new, "domain.pddl");
    for part in [
        "(:types shelf door - place box place - object)",
        "(:action pick-up\n    :parameters (?box - box ?shelf - shelf)",
        "(forall (?any_box - box) (not (porter-holds ?any_box)))",
        // The default for what holds no longer.
        ":effect (and (not (on ?box ?shelf))\n                 (porter-holds ?box))",
        ":effect (and (not (open ?door))))",
    ] {
        assert!(pddl.contains(part), "{part}\n{pddl}");
    }
    assert_eq!(
        goals(&new),
        ["on(BOX, SHELF)", "porter_holds(BOX)", "open(DOOR)", "not_open(DOOR)"]
    );
}

/// Only what the new facts exclude is offered as gone: never what a place, or a thing by itself, is.
#[test]
fn guess_removed_offers_only_states_that_new_facts_exclude() {
    let kinds = "name = \"x\"\nkind = [{ name = \"box\" }, { name = \"lid\" }, { name = \"shelf\", stays = true }, \
                 { name = \"table\", stays = true }, { name = \"door\", stays = true }]\n";
    let take = r#"{ words = "pick up a box", needs = ["the box is on a shelf", "the box is closed", "the robot is at the shelf"],
                    then = ["the robot holds the box"] }"#;
    let go_to_box = r#"{ words = "drive to a box", needs = [], then = ["the robot is at the box"] }"#;
    for (earlier, action, expected) in [
        (
            "",
            r#"words = "drive to a shelf", needs = ["the shelf is on the floor", "the shelf is open"], then = ["the robot is at the shelf"]"#,
            vec!["the robot is at any shelf"],
        ),
        (
            "",
            r#"words = "open a door", needs = ["the robot is at the door", "the robot holds no box"], then = ["the door is open"]"#,
            vec![],
        ),
        ("", take.trim_matches(['{', '}', ' ']), vec!["the box is on a shelf"]),
        (
            take,
            r#"words = "put a box on a table", needs = ["the robot holds the box", "the box is closed"], then = ["the box is on the table"]"#,
            vec!["the robot holds the box"],
        ),
        (
            "",
            r#"words = "put a box on a table", needs = ["the robot holds the box"], then = ["the box is on the table"]"#,
            vec!["the robot holds the box"],
        ),
        (
            go_to_box,
            r#"words = "push a box onto a table", needs = ["the robot is at the box"], then = ["the box is on the table"]"#,
            vec![],
        ),
        (
            "",
            r#"words = "slide a box from a shelf to a table", needs = ["the box is on the shelf"], then = ["the box is on the table"]"#,
            vec!["the box is on the shelf"],
        ),
        (
            take,
            r#"words = "wash a box", needs = ["the robot holds the box", "the box is open"], then = ["the box is clean"]"#,
            vec![],
        ),
    ] {
        let last = format!("{{ {action} }}");
        let actions = [earlier, &last].into_iter().filter(|own| !own.is_empty());
        let one_line = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        let actions: Vec<String> = actions.map(one_line).collect();
        let text = format!("{kinds}action = [{}]\n", actions.join(", "));
        let answers = Answers::read("answers.toml", &text).unwrap();
        let last = answers.action.last().unwrap();
        assert_eq!(super::guess_removed(&answers, last), expected, "{action}");
    }
}

/// A state that another action brings back is replaced, and both actions say so.
#[test]
fn actions_that_reverse_each_other_replace_the_state() {
    let open = r#"{ words = "open a door", needs = ["the door is closed", "the door is clean"], then = ["the door is open"], no_longer = [] }"#;
    let close = r#"{ words = "close a door", needs = ["the door is open"], then = ["the door is closed"], no_longer = ["the door is open"] }"#;
    for (actions, guess, missed) in [
        (vec![open], vec![], vec![]),
        (
            vec![open, close],
            vec!["the door is open"],
            vec![(0, "the door is closed")],
        ),
    ] {
        let text = format!(
            "name = \"x\"\nkind = [{{ name = \"door\", stays = true }}]\naction = [{}]\n",
            actions.join(", ")
        );
        let answers = Answers::read("answers.toml", &text).unwrap();
        assert_eq!(super::guess_removed(&answers, answers.action.last().unwrap()), guess);
        let found = super::missed_removals(&answers);
        let found: Vec<(usize, &str)> = found.iter().map(|own| (own.action, own.state.as_str())).collect();
        assert_eq!(found, missed);
    }
}

/// A robot that goes to places of two kinds, one of which has one thing with its name.
const LIBRARIAN: &str = r#"
name = "librarian"
robot = "librarian"
kind = [
  { name = "book", stays = false, examples = ["war novel"] },
  { name = "place", stays = true, examples = ["return box", "history shelf"] },
  { name = "scanner", stays = true, examples = ["scanner"] },
]
[[action]]
words = "drive to a place"
then = ["the librarian is at the place"]
no_longer = ["the librarian is at any place"]
[[action]]
words = "drive to a scanner"
then = ["the librarian is at the scanner"]
[[action]]
words = "scan a book on a scanner"
needs = ["the librarian is at the scanner"]
then = ["the book is scanned"]
[[action]]
words = "take a book from a place"
needs = ["the librarian is at the place", "the book is on the place", "the librarian holds no book"]
then = ["the librarian holds the book"]
"#;

#[test]
fn guesses_keep_the_robot_at_one_place_across_kinds() {
    let mut answers = Answers::read("answers.toml", LIBRARIAN).unwrap();
    let drive = answers.action[1].clone();
    assert_eq!(
        super::guess_removed(&answers, &drive),
        ["the librarian is at any scanner", "the librarian is at any place"]
    );
    let missed = super::missed_removals(&answers);
    let missed: Vec<(usize, &str)> = missed.iter().map(|own| (own.action, own.state.as_str())).collect();
    assert_eq!(missed, [(0, "the librarian is at any scanner")]);
    let start = super::guess_start(&answers);
    let places = start.iter().filter(|text| text.contains("librarian is at"));
    assert_eq!(places.count(), 1, "{start:?}");
    // "the scanner" is the only one.
    answers.start = vec![
        "the librarian is at the scanner".to_owned(),
        "the war novel is on the return box".to_owned(),
    ];
    for text in &answers.start {
        assert_eq!(super::start_mistake(&answers, text), None);
    }
    from_answers(&answers).unwrap();
}

#[test]
fn misspelt_kind_corrects_misspelled_names_of_kinds() {
    let answers = Answers::read("answers.toml", LIBRARIAN).unwrap();
    for (text, expected) in [
        ("the book is on the palce", Some("the book is on the place")),
        ("the librarian holds no bok", Some("the librarian holds no book")),
        ("scan a book on a scaner", Some("scan a book on a scanner")),
        ("the librarian is at the place", None),
        ("the book is in place", None),
        ("the book is at the back", None),
        ("the librarian holds no letter", None),
    ] {
        let mended = super::misspelt_kind(&answers, text).map(|misspelt| misspelt.mended(text));
        assert_eq!(mended.as_deref(), expected, "{text}");
    }
}

#[test]
fn examples_name_the_things_without_a_start_too() {
    let (before, after) = PORTER.split_once("start = [").unwrap();
    let after = after.split_once("]\n").unwrap().1;
    for start in ["", "start = []\n"] {
        let answers = Answers::read("answers.toml", &format!("{before}{start}{after}")).unwrap();
        let new = from_answers(&answers).unwrap_or_else(|findings| panic!("{findings}"));
        let (_, environment) = new.files.iter().find(|(name, _)| name == "environment.json").unwrap();
        for name in ["<red_box>", "<blue_box>", "<top_shelf>", "<low_shelf>", "<front_door>"] {
            assert!(environment.contains(name), "{environment}");
        }
        assert!(!environment.contains("_1>"), "{environment}");
    }
}

#[test]
fn same_state_finds_other_wordings_of_a_known_state() {
    let answers = Answers::read("answers.toml", PORTER).unwrap();
    let none = super::ActionAnswer::default();
    for (text, expected) in [
        ("the porter holds the box", None),
        ("Porter holds a box.", None),
        ("the porter is holding the box", Some("the porter holds the box")),
        ("the robot holds no box", Some("not the porter holds any box")),
        ("the box is on top of the shelf", Some("the box is on the shelf")),
        ("the box is under the shelf", None),
        ("the door is opened", Some("the door is open")),
        ("the door is locked", None),
        ("the porter is at the shelf", None),
    ] {
        assert_eq!(super::same_state(&answers, &none, text).as_deref(), expected, "{text}");
    }
}

#[test]
fn answers_that_make_no_domain_are_errors() {
    let change = |from: &str, to: &str| {
        assert!(PORTER.contains(from), "{from}");
        PORTER.replacen(from, to, 1)
    };
    for (text, expected) in [
        (
            "name = \"x\"".to_owned(),
            "a domain needs a kind of things and an action",
        ),
        (change("pick up a box", "sing"), "an action names the kinds"),
        (
            change("[\"the porter holds the box\"]\n[[", "[]\n[["),
            "it changes nothing",
        ),
        (
            change("\"the red box is on the top shelf\"", "\"the red box is wet\""),
            "no action speaks of this",
        ),
        (
            change("pick up a box", "open a door"),
            "two actions have the same words",
        ),
    ] {
        let found = Answers::read("answers.toml", &text).and_then(|answers| from_answers(&answers));
        let found = found.map(|new| new.domain.name.clone()).unwrap_err().to_string();
        assert!(found.contains(expected), "{expected}: {found}");
    }
}

#[test]
fn domain_import_names_the_line_of_an_unsupported_section() {
    let text = BLOCKS.replacen("(:predicates", "\n(:process heat)\n(:predicates", 1);
    let found = from_any_pddl(
        "mine",
        SourceText {
            file: "d.pddl",
            text: &text,
        },
        None,
    );
    let found = found.map(|new| new.domain.name.clone()).unwrap_err().to_string();
    assert!(found.starts_with("d.pddl:3:1:"), "{found}");
    assert!(found.contains("`:process` is not supported"), "{found}");
}

/// A derived predicate becomes a goal, and the objects of the problem that the actions name are constants. The goal is not needed.
#[test]
fn a_domain_is_read_together_with_its_problem() {
    let domain = "(define (domain porter) (:types room crate - object)
      (:predicates (at ?c - crate ?r - room) (door ?r - room))
      (:derived (safe ?c - crate) (exists (?r - room) (and (at ?c ?r) (not (door ?r)))))
      (:action fetch :parameters (?c - crate ?r - room) :precondition (and (at ?c ?r) (not (= ?r depot)))
        :effect (and (not (at ?c ?r)) (at ?c depot)))
      (:action bring :parameters (?c - crate ?r - (either room)) :precondition (at ?c depot)
        :effect (and (not (at ?c depot)) (at ?c ?r))))";
    let problem = "(define (problem p) (:domain porter) (:objects depot hall - room red - crate)
      (:init (at red hall) (door hall)))";
    let new = made(domain, Some(problem));
    assert_eq!(goals(&new), ["safe(C)", "at(C, R)"]);
    let pddl = text(&new, "domain.pddl");
    assert!(
        pddl.contains("(:constants depot - room)") && pddl.contains("(:derived (safe ?c - crate)"),
        "{pddl}"
    );
    assert!(text(&new, "prompt/examples.toml").contains("answer = \"safe("));
    assert!(
        !text(&new, "domain.toml").contains("fact = \"(safe"),
        "no environment states it"
    );
}

/// Files as others write them become folders that load, with a note where something was rewritten.
#[test]
fn new_domain_imports_foreign_pddl_with_notes() {
    let durative = "```pddl
(define (domain rover)
  (:requirements :strips :typing :durative-actions :universal-preconditions :fluents)
  (:types room -object robot - object)
  (:predicates (at ?r - robot ?x -room) (path ?a ?b - room) (swept?x - room))
  (:durative-action drive
    :parameters (?r - robot ?a ?b - room)
    :duration (= ?duration 5)
    :condition (and (at start (at ?r ?a)) (over all (path ?a ?b)))
    :effect (and (at start (not (at ?r ?a))) (at end (at ?r ?b))))
  (:durative-action sweep
    :parameters (?r - robot ?x - room)
    :duration (= ?duration 2)
    :condition (and (over all (at ?r ?x)) (at start (not (swept ?x))))
    :effect (at end (swept ?x))))
```";
    let new = made(durative, None);
    assert_eq!(new.domain.actions.len(), 2);
    let pddl = text(&new, "domain.pddl");
    assert!(pddl.contains("(:action drive"), "{pddl}");
    assert!(
        pddl.contains("(increase (total-cost) 5)") && !pddl.contains("durative"),
        "{pddl}"
    );
    let notes: Vec<String> = new.notes.iter().map(ToString::to_string).collect();
    assert!(
        notes.iter().any(|own| own.contains("steps one after another")),
        "{notes:?}"
    );
    // What the start brings about is no condition of the end.
    let held = durative.replace("(over all (path ?a ?b))", "(at end (not (at ?r ?a)))");
    let held = made(&held, None);
    assert!(
        text(&held, "domain.pddl").contains(":precondition (and (at ?r ?a))"),
        "{}",
        text(&held, "domain.pddl")
    );
    // What the start takes and the end gives back is no effect.
    let busy = durative
        .replace("(swept?x - room)", "(swept ?x - room) (idle ?r - robot)")
        .replace("(over all (at ?r ?x))", "(at start (idle ?r)) (over all (at ?r ?x))")
        .replace(
            ":effect (at end (swept ?x))",
            ":effect (and (at start (not (idle ?r))) (at end (idle ?r)) (at end (swept ?x)))",
        );
    let busy = made(&busy, None);
    let effect = text(&busy, "domain.pddl")
        .split(":action sweep")
        .nth(1)
        .unwrap_or_default();
    let effect = effect.split(":effect").nth(1).unwrap_or_default();
    assert!(effect.contains("swept") && !effect.contains("idle"), "{effect}");
    // A domain whose made-up world shows nothing is written, with a note.
    let nothing = "(define (domain never) (:predicates (p ?x) (q ?x) (r ?x))
        (:action a :parameters (?x) :precondition (and (p ?x) (q ?x) (not (q ?x))) :effect (r ?x)))";
    let new = made(nothing, None);
    assert!(
        new.notes
            .iter()
            .any(|own| own.message.contains("nothing to show a model")),
        "{:?}",
        new.notes
    );
}

/// A domain of one predicate and one action for each number: the first predicate leads to the last one.
fn chain(count: usize) -> String {
    let predicates: String = (0..=count).map(|n| format!(" (p{n} ?x)")).collect();
    let action = |n: usize| {
        format!(
            " (:action a{n} :parameters (?x) :precondition (p{n} ?x) :effect (p{} ?x))",
            n + 1
        )
    };
    let actions: String = (0..count).map(action).collect();
    format!("(define (domain k) (:predicates{predicates}){actions})")
}

#[test]
fn a_large_domain_takes_bounded_work_and_says_what_is_missing() {
    let noted = |new: &NewDomain| {
        new.notes
            .iter()
            .any(|note| note.message.contains("all the work that they may take"))
    };
    let mut most = 0;
    for count in [20, 80, 240] {
        let spent = longstep_core::effort::within(u64::MAX, || made(&chain(count), None));
        most = spent.units.max(most);
        let examples = spent.result.domain.prompts.examples.len();
        assert!(examples > 4, "{count}: {examples} examples");
        assert!(examples >= 20 || noted(&spent.result), "{count}: {examples} examples");
    }
    // Loading, the made-up world, the examples and the lints; without a bound it was many times that.
    assert!(most < 50_000_000, "{most} units");
}

#[test]
fn new_domain_notes_too_many_types_for_an_example_world() {
    let types: String = (0..400).map(|n| format!(" t{n}")).collect();
    let text = format!(
        "(define (domain wide) (:requirements :typing) (:types{types} - object) (:predicates (p ?a) (q ?a))
          (:action go :parameters (?a) :precondition (p ?a) :effect (q ?a)))"
    );
    let new = made(&text, None);
    let notes: Vec<&str> = new.notes.iter().map(|note| note.message.as_str()).collect();
    assert!(
        notes
            .iter()
            .any(|note| note.contains("too large for a complete example world")),
        "{notes:?}"
    );
}

#[test]
fn new_domain_renames_reserved_words_with_a_note() {
    let text = "(define (domain f) (:requirements :adl)\n (:predicates (if ?x) (never ?x) (all ?x) (untouched ?x))\n \
                (:action for :parameters (?x) :precondition (not (if ?x)) :effect (and (if ?x) (never ?x) (all ?x) (untouched ?x))))";
    let new = made(text, None);
    assert_eq!(goals(&new), ["is_if(X)", "is_never(X)", "is_all(X)", "is_untouched(X)"]);
    assert_eq!(new.domain.actions[0].call, "do_for");
    let notes: Vec<String> = new.notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "d.pddl:2:16: `if` is a word of the goal language; domain.toml has `is_if` for it",
            "d.pddl:2:24: `never` is a word of the goal language; domain.toml has `is_never` for it",
            "d.pddl:2:35: `all` is a word of the goal language; domain.toml has `is_all` for it",
            "d.pddl:2:44: `untouched` is a word of the goal language; domain.toml has `is_untouched` for it",
            "d.pddl:3:11: `for` is a word of the notation of plans; domain.toml has `do_for` for it",
        ]
    );
}
