//! Earlier goals that later ones exclude, and what stages, counts and constraints mean for numbers.

use super::parse;
use crate::pddl::{read_problem, write_plan};
use crate::search::{Limits, Outcome, solve};
use crate::testing;
use longstep_model::domain::{Files, from_pddl, load};
use longstep_model::model::{Condition, State, World};
use longstep_verify::verify::check;

/// Things that can be held or stand somewhere, with flags, lamps, doors and levels.
const HOUSE: &str = "(define (domain house) (:requirements :adl :numeric-fluents)
  (:types place item - thing)
  (:predicates (on ?x - item ?y - place) (held ?x - item) (flag ?x - item ?y - place) (lit ?x - item ?y - place)
    (open ?x - item) (shut ?x - item) (near ?y - place) (stamp ?x - item ?y - place) (clean ?x - item) (dusty ?x - item))
  (:functions (level ?x - item) (charge))
  (:action take :parameters (?x - item ?y - place) :precondition (on ?x ?y) :effect (and (not (on ?x ?y)) (held ?x)))
  (:action drop :parameters (?x - item ?y - place) :precondition (held ?x) :effect (and (on ?x ?y) (not (held ?x))))
  (:action mark :parameters (?x - item ?f ?t - place) :precondition (not (= ?f ?t))
    :effect (and (not (flag ?x ?f)) (flag ?x ?t)))
  (:action light :parameters (?x - item ?t - place) :precondition ()
    :effect (and (forall (?f - place) (not (lit ?x ?f))) (lit ?x ?t)))
  (:action open-up :parameters (?x - item) :precondition () :effect (and (open ?x) (not (shut ?x))))
  (:action shut-up :parameters (?x - item) :precondition () :effect (and (shut ?x) (not (open ?x))))
  (:action go :parameters (?y - place) :precondition ()
    :effect (and (near ?y) (forall (?f - place) (when (and (near ?f) (not (= ?f ?y))) (not (near ?f))))))
  (:action print :parameters (?x - item ?y - place) :precondition (forall (?z - place) (not (stamp ?x ?z)))
    :effect (stamp ?x ?y))
  (:action wash :parameters (?x - item) :precondition () :effect (and (clean ?x) (not (dusty ?x))))
  (:action swap :parameters (?x ?z - item) :precondition () :effect (and (clean ?x) (dusty ?z) (not (dusty ?x)) (not (clean ?z))))
  (:action fill :parameters (?x - item) :precondition (< (level ?x) 6) :effect (increase (level ?x) 1))
  (:action drain :parameters (?x - item) :precondition (> (level ?x) 0) :effect (decrease (level ?x) 1))
  (:action rain :parameters () :precondition () :effect (and (forall (?x - item) (increase (level ?x) 1)) (increase (charge) 1))))";

fn house() -> World {
    let domain = from_pddl("house.pddl", HOUSE).unwrap();
    let problem = "(define (problem p) (:domain house) (:objects tray desk box - place cup mug jar - item)
        (:init (on cup desk) (on mug desk) (near desk) (= (level cup) 0) (= (level mug) 0) (= (charge) 0)) (:goal ()))";
    read_problem(&domain, "p.pddl", problem).unwrap().world
}

/// A tray with two things must be locked.
fn trays() -> World {
    let predicates = [
        ("on", "on", "(on ?self ?y)", "<y>"),
        ("locked", "locked", "(locked ?self)", ""),
    ];
    let words: String = predicates
        .iter()
        .map(|(name, word, fact, argument)| {
            format!(
                "[[predicate]]\nname = \"{name}\"\nsays = \"is {name}\"\ndenies = \"is not {name}\"
                [[state]]\nword = \"{word}({argument})\"\nfact = \"{fact}\"\nmeans = \"It is {name}.\"\n"
            )
        })
        .collect();
    let actions: String = [("put", "?x, ?y"), ("take", "?x, ?y"), ("lock", "?y")]
        .iter()
        .map(|(name, call)| {
            format!(
                "[[action]]\nname = \"{name}\"\ncall = \"{name}({call})\"\nsays = \"{name}\"\nmeans = \"It works.\"\n"
            )
        })
        .collect();
    let domain = load(&Files {
        pddl: "(define (domain trays) (:requirements :adl) (:types place item - thing)
            (:predicates (on ?x - item ?y - place) (locked ?y - place))
            (:action put :parameters (?x - item ?y - place) :precondition (not (on ?x ?y)) :effect (on ?x ?y))
            (:action take :parameters (?x - item ?y - place) :precondition (on ?x ?y) :effect (not (on ?x ?y)))
            (:action lock :parameters (?y - place) :precondition (not (locked ?y)) :effect (locked ?y)))"
            .to_owned(),
        words: format!(
            "name = \"trays\"\nabout = \"Trays.\"\n[environment]\nassets = \"place\"\nobjects = \"item\"\n{words}{actions}
            [[rule]]\nname = \"locked-tray\"\nholds = \"always\"
            condition = \"(forall (?a - item ?b - item ?t - place) (imply (and (on ?a ?t) (on ?b ?t) (not (= ?a ?b))) (locked ?t)))\"
            says = \"{{t}} with {{a}} and {{b}} must be locked\"\n"
        ),
        ..Files::default()
    })
    .unwrap_or_else(|error| panic!("{error}"));
    let text = r#"{"assets": ["<tray>", "<desk>"], "objects": ["<cup>", "<mug>"], "object_states": {},
        "names": {"<mug>": "item"}}"#;
    testing::world_of(&domain, text)
}

fn planned(world: &World, text: &str) -> String {
    let goal = parse(world, text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let purpose = goal.purpose(world);
    match solve(world, &purpose, &Limits::default()) {
        Outcome::Solved { plan, shortest, .. } => {
            let report = check(world, plan.clone(), &purpose);
            assert_eq!(report.violations, [], "{text}");
            assert!(shortest, "{text}");
            write_plan(world, plan.steps()).trim().replace('\n', " ")
        }
        Outcome::ProvenUnsolvable { .. } => "unsolvable".to_owned(),
        other @ Outcome::GaveUp { .. } => format!("{other:?}"),
    }
}

#[test]
fn goal_is_given_up_only_if_no_state_satisfies_both() {
    let world = house();
    for (first, second, excludes) in [
        ("on(cup, tray)", "on(cup, desk)", true),
        ("on(cup, tray)", "held(cup)", true),
        ("on(cup, tray)", "on(mug, desk)", false),
        ("held(cup)", "held(mug)", false),
        // A flag at one place is taken away, whether or not it is there; others stay.
        ("flag(cup, tray)", "flag(cup, desk)", false),
        // All others are taken away.
        ("lit(cup, tray)", "lit(cup, desk)", true),
        ("lit(cup, tray)", "lit(mug, desk)", false),
        ("open(cup)", "shut(cup)", true),
        ("open(cup)", "shut(mug)", false),
        ("near(tray)", "near(desk)", true),
        // A second stamp is impossible.
        ("stamp(cup, tray)", "stamp(cup, box)", true),
        // Swapping a thing with itself leaves it clean and dusty.
        ("clean(cup)", "dusty(cup)", false),
        ("level(cup) > level(mug)", "level(mug) > level(cup)", true),
        ("level(cup) >= level(mug)", "level(mug) >= level(cup)", false),
        ("level(cup) = level(mug)", "level(mug) != level(cup)", true),
        ("level(cup) > 3", "level(cup) <= 3", true),
        ("level(cup) >= 3", "level(cup) <= 3", false),
        ("level(cup) > level(mug)", "level(mug) > 3", false),
        ("on(any item, tray)", "on(cup, desk)", false),
        ("on(any item, tray)", "on(all item, desk)", true),
        ("on(any item, tray)", "on(2 of item, desk)", false),
        ("on(exactly 1 of item, tray)", "on(2 of item, tray)", true),
    ] {
        let goal = parse(&world, &format!("{first} then {second}")).unwrap();
        let kept = goal.purpose(&world).wanted[0].condition != Condition::TRUE;
        assert_eq!(!kept, excludes, "{first} then {second}");
    }
}

#[test]
fn later_goals_are_reached_with_the_earlier_ones_that_they_allow() {
    let world = house();
    for (text, expected) in [
        (
            "flag(cup, tray) then flag(cup, desk)",
            "(mark cup desk tray) (mark cup box desk)",
        ),
        (
            "level(cup) > level(mug) then level(mug) > level(cup)",
            "(fill cup) (fill mug) (fill mug)",
        ),
        ("clean(cup) then dusty(cup)", "(wash cup) (swap cup cup)"),
    ] {
        assert_eq!(planned(&world, text), expected, "{text}");
    }
    assert_eq!(
        planned(&trays(), "on(cup, tray) then on(mug, tray)"),
        "(put cup tray) (lock tray) (put mug tray)"
    );
}

#[test]
fn an_action_that_only_takes_a_goal_back_is_relevant_to_a_later_stage() {
    let world = house();
    for (text, expected) in [
        (
            "open(cup) then open(mug) then open(cup)",
            "(open-up cup) (shut-up cup) (open-up mug) (open-up cup)",
        ),
        (
            "level(cup) >= 1 then open(mug) then level(cup) >= 1",
            "(fill cup) (drain cup) (open-up mug) (fill cup)",
        ),
        (
            "level(cup) = level(mug) then level(cup) > level(mug) then level(cup) = level(mug)",
            "(fill cup) (fill mug)",
        ),
    ] {
        assert_eq!(planned(&world, text), expected, "{text}");
    }
}

#[test]
fn things_without_a_number_do_not_satisfy_a_comparison() {
    let world = house();
    for (text, expected) in [
        ("level(exactly 1 of item) >= 1", "(fill cup)"),
        ("level(exactly 2 of item) != 3", "; no steps"),
        ("level(exactly 3 of item) != 3", "unsolvable"),
        ("open(cup) & never level(jar) >= 5", "(open-up cup)"),
        (
            "level(any item) >= 2 & never level(2 of item) >= 1",
            "(fill cup) (fill cup)",
        ),
    ] {
        assert_eq!(planned(&world, text), expected, "{text}");
    }
}

#[test]
fn search_keeps_numeric_fluents_of_untouched_objects() {
    let world = house();
    for (text, expected) in [
        ("level(cup) >= 1 & untouched(mug)", "(fill cup)"),
        ("charge >= 1", "(rain)"),
        ("charge >= 1 & untouched(mug)", "unsolvable"),
        ("charge >= 1 & untouched(jar)", "unsolvable"),
        ("charge >= 1 & untouched(tray)", "(rain)"),
        ("charge >= 1 & untouched(any item)", "unsolvable"),
    ] {
        // Rain falls into what has a level only.
        let rain = "(forall (?x - item) (increase (level ?x) 1))";
        let domain = HOUSE.replace(rain, "(forall (?x - item) (assign (level ?x) 1))");
        let domain = from_pddl("house.pddl", &domain).unwrap();
        let problem = "(define (problem p) (:domain house) (:objects tray desk box - place cup mug jar - item)
            (:init (on cup desk) (= (level cup) 0) (= (level mug) 0) (= (charge) 0)) (:goal ()))";
        let wet = read_problem(&domain, "p.pddl", problem).unwrap().world;
        assert_eq!(planned(&wet, text), expected, "{text}");
    }
    // What others change before the rest of a plan is no change of it; what the rest changes is.
    let goal = parse(&world, "level(cup) >= 1 & untouched(mug)").unwrap();
    let purpose = goal.purpose(&world);
    let mut state = world.state.clone();
    let mug = world.find("mug").unwrap();
    let level = longstep_model::model::Fluent::new(longstep_model::model::FunctionId::new(0), [mug]);
    state.set_number(level, 1.into());
    let rest = world.continued(state.clone());
    let rule = purpose.prohibitions[0].always.clone().unwrap();
    let broken = |world: &World, state: &State| longstep_model::model::broken_bindings(&rule, world, state).len();
    assert_eq!((broken(&world, &world.state), broken(&world, &state)), (0, 1));
    assert_eq!((broken(&rest, &state), broken(&rest, &world.state)), (0, 1));
}

#[test]
fn group_name_means_a_type_before_an_entity() {
    let world = trays();
    for (text, members) in [
        ("on(all item, tray)", vec!["cup", "item"]),
        ("on(all items, tray)", vec!["cup", "item"]),
        ("on(all (item), tray)", vec!["cup", "item"]),
        ("on(all (item except cup), tray)", vec!["item"]),
        ("on(any (items), tray)", vec!["cup", "item"]),
        ("on(all mug, tray)", vec!["item"]),
        ("on(all (mugs), tray)", vec!["item"]),
        ("on(cup, all thing except item)", vec!["tray", "desk"]),
        ("on(cup, all (things except items))", vec!["tray", "desk"]),
    ] {
        let goal = parse(&world, text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let found: Vec<&str> = goal.groups[0].groups[0]
            .members
            .iter()
            .map(|member| world.entity(*member).name.as_str())
            .collect();
        assert_eq!(found, members, "{text}");
    }
    // By itself, the word is the name.
    let goal = parse(&world, "on(item, tray)").unwrap();
    assert_eq!(goal.exact(&world), ["on(<mug>, <tray>)"]);
}
