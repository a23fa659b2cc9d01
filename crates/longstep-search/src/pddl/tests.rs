use super::*;
use crate::goal;
use crate::search::{Limits, Outcome, solve};
use crate::testing;
use longstep_model::domain;
use longstep_model::model::Domain;
use longstep_verify::plan::{Plan, Step};
use longstep_verify::verify::{Purpose, check};

const SHELVES: &str = "(define (domain shelves) (:requirements :adl) (:types object thing place - object)
  (:constants hand - place) (:predicates (at ?x - thing ?p - place) (heavy ?x - thing) (dark))
  (:action carry :parameters (?x - thing ?from ?to - place)
    :precondition (and (at ?x ?from) (not (heavy ?x)) (not (at ?to ?x)))
    :effect (and (at ?x ?to) (not (at ?x ?from))))
  (:action rest :parameters () :precondition () :effect ()))";

fn shelves() -> Domain {
    domain::from_pddl("domain.pddl", SHELVES).unwrap()
}

/// Solves a problem of the shelves and returns the verified plan, or the errors in the problem.
fn plan(problem: &str) -> String {
    let domain = shelves();
    let problem = match read_problem(&domain, "p.pddl", problem) {
        Ok(problem) => problem,
        Err(findings) => return findings.to_string(),
    };
    match solve(&problem.world, &Purpose::from(&problem), &Limits::default()) {
        Outcome::Solved { plan, .. } => {
            let written = write_plan(&problem.world, plan.steps());
            let read = read_plan(&problem.world, "plan", &written).unwrap().steps;
            let steps = plan.steps().iter().map(|step| (step.action, &step.arguments));
            assert!(read.iter().map(|step| (step.action, &step.arguments)).eq(steps));
            let explained = |s: crate::search::GroundAction| Step::explained(&problem.world, s.action, s.arguments);
            let purpose = Purpose::from(&problem);
            let plan: Plan = read.into_iter().map(explained).collect();
            assert_eq!(check(&problem.world, plan, &purpose).violations, vec![]);
            written
        }
        other => format!("{other:?}"),
    }
}

#[track_caller]
fn check_plan(parts: &str, expected: &str) {
    let problem =
        format!("(define (problem p) (:domain shelves) (:objects cup vase - thing low high - place)\n{parts})");
    assert_eq!(plan(&problem), expected);
}

#[test]
fn problems_are_read_as_planners_read_them() {
    // A duplicate fact, a negated fact, and facts about an object of another type.
    check_plan(
        "(:init (at cup low) (at cup low) (not (at cup high)) (at low low) (heavy high)) (:goal (at cup high))",
        "(carry cup low high)\n",
    );
    check_plan(
        "(:init (at cup low) (at vase hand) (dark)) (:goal (and (dark) (forall (?x - thing) (at ?x high))))",
        "(carry cup low high)\n(carry vase hand high)\n",
    );
    check_plan("(:init (at cup low)) (:goal (and))", "; no steps\n");
    check_plan(
        "(:init (at cup low) (heavy cup)) (:goal (at cup high))",
        "ProvenUnsolvable { when: None, expanded: 0 }",
    );
    check_plan("(:init) (:goal (or))", "ProvenUnsolvable { when: None, expanded: 0 }");
}

#[test]
fn mistakes_in_problems_are_told_with_their_place() {
    check_plan(
        "(:init (at cop low) (at cup)\n (bright)) (:goal (at cup hihg))",
        "p.pddl:2:12: unknown constant `cop`\n  hint: did you mean `cup`?\n\
         p.pddl:2:21: `at` takes 2 argument(s), not 1\n  hint: it is declared as `(at ?x - thing ?p - place)`\n\
         p.pddl:3:27: unknown constant `hihg`\n  hint: did you mean `high`?",
    );
    check_plan(
        "(:init) (:metric minimize (total-time))",
        "p.pddl:1:1: the problem has no goal\n  hint: add `(:goal (and (predicate object ...) ...))`",
    );
    assert_eq!(
        plan(
            "(define (problem p) (:domain shelves) (:objects cup cup - thang hand) (:init) (:goal (initially (dark))))"
        ),
        "p.pddl:1:59: unknown type `thang`\n  hint: did you mean `thing`?\n\
         p.pddl:1:65: the object `hand` is declared twice, with two types\n  \
         hint: keep one of the declarations, or give one another name\n\
         p.pddl:1:87: unknown predicate `initially`\n  \
         hint: declare it in `(:predicates ...)`; known are `at`, `heavy`, `dark`"
    );
    assert_eq!(
        plan("(define (problem p) (:domain shelfs) (:objects a) (:init) (:goal (c)))"),
        "p.pddl:1:21: this problem is for the domain `shelfs`, not for `shelves`\n  \
         hint: give the domain of this problem with `--domain`\n\
         p.pddl:1:67: unknown predicate `c`\n  \
         hint: declare it in `(:predicates ...)`; known are `at`, `heavy`, `dark`"
    );
    assert_eq!(
        plan("(problem p)"),
        "p.pddl:1:1: no `(define (problem NAME) ...)`\n  \
         hint: a problem file is one `(define (problem NAME) (:domain NAME) ...)` list"
    );
    assert_eq!(
        plan("(define (problem p"),
        "p.pddl:1:1: the problem has no goal\n  hint: add `(:goal (and (predicate object ...) ...))`"
    );
}

#[test]
fn domain_load_reports_type_errors_that_planners_accept() {
    let files = domain::Files {
        pddl: SHELVES.to_owned(),
        ..domain::Files::default()
    };
    let findings = domain::load(&files).unwrap_err().to_string();
    let finding = "domain.pddl:4:64: `at` takes a thing here, and this is a place";
    assert!(findings.contains(finding), "{findings}");
}

#[test]
fn mistakes_in_plans_are_told_with_their_place() {
    let domain = shelves();
    let text = "(define (problem p) (:domain shelves) (:objects cup - thing low - place) (:init) (:goal (and)))";
    let problem = read_problem(&domain, "p.pddl", text).unwrap();
    let plan = "(carry cup low hand)\n(carry cop low hand)\n(carry low cup hand)\n(carry cup)\n(bury cup) ; cost\nrest\n(rest)";
    assert_eq!(
        read_plan(&problem.world, "plan", plan).unwrap_err().to_string(),
        "plan:2:8: unknown object `cop`\n  hint: did you mean `cup`?\n\
         plan:3:8: `low` is no thing\n\
         plan:3:12: `cup` is no place\n\
         plan:4:2: `carry` takes 3 argument(s), not 1\n\
         plan:5:2: unknown action `bury`\n\
         plan:6:1: this line stands between steps and is none\n  \
         hint: take it out, or begin it with `;`, which makes it a comment"
    );
}

#[test]
fn plan_reader_notes_each_assumption_about_the_text() {
    let domain = shelves();
    let text = "(define (problem p) (:domain shelves) (:objects cup - thing low - place) (:init) (:goal (and)))";
    let world = read_problem(&domain, "p.pddl", text).unwrap().world;
    let read = |plan: &str| read_plan(&world, "plan", plan).map(|plan| (plan.steps.len(), plan.notes.join("; ")));
    for (plan, expected) in [
        ("(rest)\n(rest)", ""),
        (
            "0: (rest) [2]\n1: (rest) [2]",
            "steps of this plan are under way at the same time; it was read as steps one after another, in the order in which they begin",
        ),
        ("hm\n(rest)\n; hm\n(rest)\nfine", ""),
    ] {
        assert_eq!(read(plan).unwrap(), (2, expected.to_owned()), "{plan}");
    }
    let two = "; Plan found with metric 2\n(rest)\n(rest)\n; Plan found with metric 1\n(rest)";
    assert_eq!(
        read(two).unwrap(),
        (1, "the file has 2 plans; the last one was taken".to_owned())
    );
    for between in ["hm", "Plan B:", "```\n```"] {
        let error = read(&format!("(rest)\n{between}\n(rest)")).unwrap_err().to_string();
        assert!(error.starts_with("plan:2:1: this line stands between steps"), "{error}");
    }
    assert!(read("nothing here").unwrap_err().to_string().contains("no step"));
}

/// A domain whose types, constants and numbers are as others write them.
const DOCKS: &str = "(define (domain docks) (:requirements :typing :fluents)
  (:types place object - place box - object tower)
  (:predicates (at ?p - place))
  (:functions (charge))
  (:action visit :parameters (?p - place) :precondition (at base) :effect (at ?p))
  (:action rest :parameters () :precondition () :effect (increase (charge) 0.3333333333)))";

#[test]
fn problems_and_domains_of_others_are_read_together() {
    let problem = "```pddl\n(define (problem p) (:domain docks) (:objects base - place crate - box north - tower)
      (:init (at base) (= (charge) 2499.9999996)) (:goal (and (at crate)(at north)))
      (:metric minimize (total-time)))\n```";
    let domain = domain::from_pddl_for("docks.pddl", DOCKS, problem).unwrap();
    assert_eq!(domain.constants.len(), 1);
    let problem = read_problem(&domain, "p.pddl", problem).unwrap();
    let notes: Vec<String> = problem.notes.iter().map(ToString::to_string).collect();
    let metric = "p.pddl:4:7: this metric is left out: a plan costs as much as it has steps";
    assert_eq!(notes, [metric]);
    // A box and a tower are places, since `object` is below `place`.
    let plan = read_plan(&problem.world, "plan", "0: (VISIT CRATE) [1]\n1: (visit north) [1]").unwrap();
    assert_eq!(plan.steps.len(), 2);
    let undeclared = domain::from_pddl("docks.pddl", DOCKS).unwrap_err().to_string();
    assert!(undeclared.contains("unknown constant `base`"), "{undeclared}");
}

#[test]
fn names_are_legal_and_tell_entities_apart() {
    let environment = r#"{"assets": ["<Shelf Top>", "<shelf_top>", "shelf_top", "<7up>", "<café>", "<shelf_top-2>"]}"#;
    let world = testing::world("household", environment);
    assert_eq!(
        object_names(&world),
        [
            "shelf_top",
            "shelf_top-2",
            "shelf_top-3",
            "o_7up",
            "caf_",
            "shelf_top-2-2"
        ]
    );
}

/// Goals written as a problem and parsed again have plans of the same length.
#[track_caller]
fn check_round_trip(domain: &str, environment: &str, goals: &[&str]) {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../");
    let read = |path: &str| std::fs::read_to_string(format!("{root}{path}")).unwrap();
    let pddl = read(&format!("crates/longstep-model/domains/{domain}/domain.pddl"));
    let domain = testing::domain(domain);
    let text = read(&format!("examples/environments/{environment}.json"));
    let world = testing::world_of(&domain, &text);
    let bare = domain::from_pddl("domain.pddl", &pddl).unwrap();
    let length = |outcome| match outcome {
        Outcome::Solved { plan, .. } => Some(plan.steps().len()),
        _ => None,
    };
    for goal in goals {
        let goal = goal::parse(&world, goal).unwrap();
        let purpose = goal.purpose(&world);
        let problem = write_problem(&world, &purpose, "7 things").unwrap();
        let again = read_problem(&bare, "problem.pddl", &problem).unwrap();
        assert_eq!(again.name, "o_7_things");
        assert_eq!(
            write_problem(&again.world, &Purpose::from(&again), "7 things"),
            Ok(without_comments(&problem))
        );
        let expected = length(solve(&world, &purpose, &Limits::default()));
        let found = length(solve(&again.world, &Purpose::from(&again), &Limits::default()));
        assert!(expected.is_some());
        assert_eq!(found, expected, "{problem}");
    }
}

fn without_comments(text: &str) -> String {
    let line = |line: &str| format!("{}\n", line.split(" ;").next().unwrap());
    text.lines().map(line).collect()
}

#[test]
fn problems_that_are_written_mean_the_same_when_read_back() {
    check_round_trip(
        "household",
        "pantry",
        &[
            "put(butter, shelf top)",
            "opened(fridge) & wiped(counter, cloth)",
            "inside_something(<juice>, <fridge>)",
        ],
    );
    check_round_trip(
        "virtualhome",
        "flat",
        &["heated(cupcake, oven)", "put(mug, sofa) & on(lamp)", "held(magazine)"],
    );
}

#[test]
fn problem_writer_rejects_rules_for_every_state() {
    let domain = testing::domain("household").edited(|data| {
        let rule = data.rules.iter_mut().find(|rule| rule.name == "one-hand").unwrap();
        rule.time = longstep_model::domain::RuleTime::Always;
    });
    let world = testing::world_of(&domain, r#"{"assets": ["<table>"], "objects": ["<cup>", "<jug>"]}"#);
    let error = write_problem(&world, &Purpose::default(), "p").unwrap_err();
    assert_eq!(
        error.to_string(),
        "the rule `one-hand` must hold in every state on the way, which a PDDL problem cannot say"
    );
}
