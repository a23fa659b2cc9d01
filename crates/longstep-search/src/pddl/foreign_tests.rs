//! PDDL as others write it: what is read with a note, and what is refused with a hint.

use super::read_problem;
use crate::search::{Limits, Outcome, solve};
use longstep_model::domain;
use longstep_verify::verify::Purpose;

/// The result of a pair of files: the plan's steps, and the notes of both files.
fn plan(domain: &str, problem: &str) -> Result<(Vec<String>, String), String> {
    let own = domain::read_foreign("d.pddl", domain, Some(problem)).map_err(|findings| findings.to_string())?;
    let problem = read_problem(&own.domain, "p.pddl", problem).map_err(|findings| findings.to_string())?;
    let notes: Vec<String> = own
        .notes
        .iter()
        .chain(&problem.notes)
        .map(ToString::to_string)
        .collect();
    let outcome = solve(&problem.world, &Purpose::from(&problem), &Limits::default());
    let Outcome::Solved { plan, .. } = outcome else {
        return Err(format!("{outcome:?}"));
    };
    let written = super::write_plan(&problem.world, plan.steps());
    Ok((written.lines().map(str::to_owned).collect(), notes.join("\n")))
}

#[track_caller]
fn check(domain: &str, problem: &str, steps: &[&str], note: &str) {
    let (found, notes) = plan(domain, problem).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(found, steps, "{notes}");
    assert!(notes.contains(note), "{notes}");
    // What is rewritten is read again, by the strict reader too.
    let own = domain::read_foreign("d.pddl", domain, Some(problem)).unwrap();
    if let Some(text) = own.rewritten {
        let again = domain::read_foreign("again.pddl", &text, Some(problem)).unwrap();
        assert_eq!(again.domain.actions.len(), own.domain.actions.len(), "{text}");
    }
}

#[track_caller]
fn check_error(domain: &str, problem: &str, expected: &str) {
    let error = plan(domain, problem).unwrap_err();
    assert!(error.contains(expected), "{error}");
    assert!(error.contains("hint:"), "{error}");
}

const YARD: &str = "(define (domain yard) (:types shed - object gate - object)
  (:predicates (at ?x - object) (shut ?g - gate) (path ?a ?b - object))
  (:derived (open-way ?b - object) (exists (?a - object) (and (at ?a) (path ?a ?b) (clear-of-gates ?b))))
  (:derived (clear-of-gates ?b - shed) (not (at nowhere)))
  (:derived (clear-of-gates ?g - gate) (not (shut ?g)))
  (:action walk :parameters (?a ?b - object) :precondition (and (at ?a) (open-way ?b))
    :effect (and (not (at ?a)) (at ?b)))
  (:action unlatch :parameters (?g - gate) :precondition (shut ?g) :effect (not (shut ?g))))";

const YARD_PROBLEM: &str = "(define (problem p) (:domain yard) (:objects nowhere barn - shed west - gate)
  (:init (at barn) (path barn west) (shut west)) (:goal (and (at west) (not (open-way barn)))))";

#[test]
fn derived_predicates_stand_for_their_conditions() {
    check(
        YARD,
        YARD_PROBLEM,
        &["(unlatch west)", "(walk barn west)"],
        "objects of the problem that the actions name are read as constants",
    );
    // A fact of a derived predicate about an entity of another type than its rules name is false.
    let goal = YARD_PROBLEM.replace("(not (open-way barn))", "(not (clear-of-gates west))");
    assert!(plan(YARD, &goal).unwrap_err().contains("Unsolvable"));
    check_error(
        &YARD.replace("(not (at nowhere))", "(clear-of-gates ?b)"),
        YARD_PROBLEM,
        "the derived predicate `clear-of-gates` depends on itself",
    );
    check_error(
        YARD,
        &YARD_PROBLEM.replace("(shut west)", "(open-way west)"),
        "`open-way` is derived, so it follows from other facts",
    );
    check_error(
        &YARD.replace("(and (not (at ?a)) (at ?b))", "(open-way ?b)"),
        YARD_PROBLEM,
        "`open-way` is derived, so it follows from other facts",
    );
}

#[test]
fn derived_predicates_have_bounds() {
    let mut doubling = String::from("(define (domain d) (:predicates (a)) (:derived (p0) (a))");
    for level in 1..40 {
        let below = level - 1;
        doubling.push_str(&format!("(:derived (p{level}) (and (p{below}) (p{below})))"));
    }
    doubling.push_str("(:action go :parameters () :precondition (p39) :effect (a)))");
    check_error(&doubling, YARD_PROBLEM, "too large when they are written out");
    let mut deep = String::from("(define (domain d) (:predicates (a)) (:derived (p0) (a))");
    for level in 1..150 {
        deep.push_str(&format!("(:derived (p{level}) (or (not (p{})) (a)))", level - 1));
    }
    deep.push(')');
    check_error(&deep, YARD_PROBLEM, "deep when it is written out");
}

#[test]
fn union_types_become_conditions_on_variables() {
    let domain = |types: &str| {
        format!(
            "(define (domain d) (:types cup lid stone - object) (:predicates (clean ?x - object) (all))
             (:action wash :parameters (?x - {types}) :precondition () :effect (clean ?x))
             (:action finish :parameters () :precondition (forall (?x - {types}) (clean ?x)) :effect (all))
             (:action rain :parameters () :precondition () :effect (forall (?x - {types}) (not (clean ?x)))))"
        )
    };
    let problem = |goal: &str| {
        format!("(define (problem p) (:domain d) (:objects c - cup l - lid s - stone) (:init) (:goal {goal}))")
    };
    let union = domain("(either cup lid)");
    check(
        &union,
        &problem("(and (all) (clean c))"),
        &["(wash c)", "(wash l)", "(finish)"],
        "",
    );
    assert!(plan(&union, &problem("(clean s)")).unwrap_err().contains("Unsolvable"));
    check_error(
        &union,
        &problem("(all)").replace("c - cup", "c - (either cup lid)"),
        "an object has one type",
    );
}

/// A small domain of a lift, with a part that others write in their own way.
fn lift(replaced: &str, by: &str) -> String {
    let text = "(define (domain lift) (:types floor) (:predicates (at ?f - floor) (next ?a ?b - floor))
      (:action go :parameters (?a ?b - floor) :precondition (and (at ?a) (next ?a ?b)) :effect (and (not (at ?a)) (at ?b))))";
    assert!(text.contains(replaced), "{replaced}");
    text.replacen(replaced, by, 1)
}

const LIFT_PROBLEM: &str = "(define (problem p) (:domain lift) (:objects a b - floor)
  (:init (at a) (next a b)) (:goal (at b)))";

#[test]
fn inexact_domains_are_read_with_a_note() {
    for (replaced, by, note) in [
        ("(:types floor)", "", "the type `floor` is not declared"),
        (
            "(next ?a ?b - floor)",
            "(next ?a ?b - floor) (next ?a - level ?b - floor)",
            "is declared twice; it is read as one for the types of both",
        ),
        (
            "(next ?a ?b - floor)",
            "(next ?a ?a - floor)",
            "the parameter `?a` is declared twice; this one is called `?a-2`",
        ),
        (
            " (next ?a ?b - floor))",
            ")",
            "the predicate `next` is not declared; it is read with 2 argument(s)",
        ),
        (
            "(not (at ?a)) ",
            "(not (at ?a)) (increase (total-cost) 2) ",
            "`(total-cost)` is not declared",
        ),
        ("(at ?b))))", "(at ?b)))", "1 `)` at the end is missing"),
        ("(at ?b))))", "(at ?b)))))", "1 `)` at the end closes nothing"),
        (
            "(at ?b))))",
            "(at ?b))))\nFooter",
            "`footer` is outside of the definition",
        ),
        (
            "(:action go",
            "(:action go :parameters (?a - floor) :precondition (at ?a) :effect ()) (:action go",
            "the action `go` is declared twice; this one is called `go-2`",
        ),
        (
            "(not (at ?a)) ",
            "(not (at ?a)) (when (at ?a) (increase (total-cost) 2)) ",
            "costs inside of `when` and `forall` are left out",
        ),
    ] {
        let action = if note.contains("`go-2`") {
            "(go-2 a b)"
        } else {
            "(go a b)"
        };
        check(&lift(replaced, by), LIFT_PROBLEM, &[action], note);
    }
}

#[test]
fn inexact_problems_are_read_with_a_note() {
    for (replaced, by, note) in [
        (
            "(:domain lift)",
            "(:domain elevator)",
            "this problem is for the domain `elevator`, not for `lift`; all its names fit",
        ),
        (
            "(:objects a b - floor)",
            "(:objects a b - floor a - floor)",
            "`a` is declared twice; it is read as one",
        ),
        ("(at a)", "(at a) (painted a green)", "facts of `painted` are left out"),
        ("(:goal", "(:length 4) (:goal", "`:length` is left out"),
    ] {
        check(
            &lift("(:types floor)", "(:types floor)"),
            &LIFT_PROBLEM.replacen(replaced, by, 1),
            &["(go a b)"],
            note,
        );
    }
    let untyped = lift(" - floor)", ")")
        .replace("(:types floor)", "")
        .replace(" - floor", "");
    check(&untyped, LIFT_PROBLEM, &["(go a b)"], "the domain has no types");
}

#[test]
fn reader_gives_a_hint_for_unsupported_or_misspelled_pddl() {
    for (replaced, by, expected) in [
        (
            "(at a)",
            "(at a) (at 5 (next a b))",
            "a fact that changes at the time 5 by itself is not supported",
        ),
        (
            "(at a)",
            "(at a) (unknown (next a b))",
            "`unknown` says that facts are not known at the start",
        ),
        (
            "(at a)",
            "(att a)",
            "unknown predicate `att`\n  hint: did you mean `at`?",
        ),
        ("(at a)", "(at c)", "unknown constant `c`"),
        ("(:goal (at b))", "", "the problem has no goal\n  hint: add `(:goal"),
        (
            "(:goal (at b))",
            "(:goal (reached b))",
            "hint: declare it in `(:predicates ...)`; known are `at`, `next`",
        ),
        ("(:goal (at b))", "(:gaol (at b))", "hint: did you mean `:goal`?"),
        (
            "(:goal (at b))",
            "(:goal (at a b))",
            "hint: it is declared as `(at ?f - floor)`",
        ),
        (
            "(:objects a b - floor)",
            "(:objects a b - floor a)",
            "the object `a` is declared twice, with two types",
        ),
        (
            "a b - floor",
            "a b - storey",
            "hint: declare it in `(:types ...)`; known are `object`, `floor`",
        ),
    ] {
        check_error(
            &lift("(:types floor)", "(:types floor)"),
            &LIFT_PROBLEM.replacen(replaced, by, 1),
            expected,
        );
    }
    for (replaced, by, expected) in [
        (
            ":effect",
            ":observe",
            "hint: an action that senses has the effect `(and)`",
        ),
        (":precondition", ":preconditions", "hint: did you mean `:precondition`?"),
        ("(:action", "(:axiom) (:action", "hint: write it as `(:derived"),
        ("(:action", "(:process) (:action", "hint: PDDL+ is not read"),
        ("(?a ?b - floor) :pre", "(?a - floor) :pre", "unknown variable `b`"),
    ] {
        check_error(&lift(replaced, by), LIFT_PROBLEM, expected);
    }
}

#[test]
fn pddl_numbers_and_durations_have_their_standard_meaning() {
    let domain = "(define (domain d) (:types spot) (:predicates (at ?s - spot) (way ?a ?b - spot))
      (:functions (length ?a ?b - spot) (driven) (charge))
      (:durative-action drive :parameters (?a ?b - spot) :duration (= ?duration (length ?a ?b))
        :condition (and (at start (at ?a)) (at start (> charge 0)))
        :effect (and (at start (not (at ?a))) (at end (at ?b)) (at end (increase driven ?duration))))
      (:durative-action load :parameters () :duration (<= ?duration (- 10 (charge)))
        :condition (at start (< (charge) 10)) :effect (at end (increase (charge) ?duration))))";
    let problem = "(define (problem p) (:domain d) (:objects a b - spot)
      (:init (at a) (= charge 0) (= (length a b) 4)) (:goal (and (at b) (= (charge) 10))) (:metric minimize (driven)))";
    check(
        domain,
        problem,
        &["(load)", "(drive a b)"],
        "`(driven)` has no number at the start; it begins at 0",
    );
    // Lengths are costs: the way by `c` is shorter.
    let costly = domain.replace(
        "(:durative-action load :parameters () :duration (<= ?duration (- 10 (charge)))",
        "(:durative-action load :parameters () :duration (= ?duration 1)",
    );
    let costly = costly.replace("(increase (charge) ?duration)", "(increase (charge) 10)");
    let problem = "(define (problem p) (:domain d) (:objects a b c - spot)
      (:init (at a) (= (charge) 1) (= (length a b) 9.5) (= (length a c) 4) (= (length c b) 4)) (:goal (at b)))";
    check(
        &costly,
        problem,
        &["(drive a c)", "(drive c b)"],
        "their durations are costs",
    );
}
