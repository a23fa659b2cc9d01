//! Any text is a condition in PDDL, as a rule and as a goal, and means the same wherever it is evaluated.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use longstep::domain::{self, Condition, Domain, Files};
use longstep_core::effort;
use longstep_core::environment::{self, Environment, Moment, State, World, holds};
use longstep_core::json::Path;
use longstep_core::pddl::{self, Problem};
use longstep_core::search::{self, Effort, Limits, Outcome, Wanted};
use longstep_core::verify::{Purpose, apply, unmet};

const PDDL: &str = "(define (domain d) (:requirements :adl) (:types place item - thing)
  (:predicates (ready) (lit ?x - thing) (at ?x - item ?y - place) (link ?x ?y - thing))
  (:action go :parameters (?i - item ?to - place) :precondition (not (at ?i ?to))
    :effect (and (forall (?p - place) (not (at ?i ?p))) (at ?i ?to)))
  (:action light :parameters (?x - thing) :precondition (exists (?i - item) (link ?i ?x))
    :effect (and (lit ?x) (when (at milk shelf) (ready))))
  (:action douse :parameters (?x - thing) :precondition (lit ?x) :effect (not (lit ?x))))";

/// The domain with the constants that its actions name.
static BARE: LazyLock<Domain> = LazyLock::new(|| {
    let text = PDDL.replace("(:predicates", "(:constants milk - item shelf - place)\n  (:predicates");
    domain::from_pddl("d.pddl", &text).expect("it is valid")
});

/// The shipped greenhouse example, to which a rule is added.
static GREENHOUSE: LazyLock<(Files, Environment)> = LazyLock::new(|| {
    let files = Files {
        pddl: include_str!("../../examples/greenhouse/domain.pddl").to_owned(),
        words: include_str!("../../examples/greenhouse/domain.toml").to_owned(),
        goal_prompt: "{{ name }}".to_owned(),
        ..Files::default()
    };
    domain::load(&files).expect("it is valid without the rule");
    let environment = include_str!("../../examples/greenhouse/environment.json");
    (files, Environment::from_json(environment).expect("it is JSON"))
});

/// Units of work for one input.
const UNITS: u64 = effort::OPERATION / 400;

fn small() -> Limits {
    Limits::default()
        .with_direct(200)
        .with_proof(50)
        .with_shortest(100)
        .with_any(200)
        .with_effort(Effort::NORMAL)
}

fuzz_target!(|condition: &str| {
    as_goal(condition);
    as_rule(condition);
});

fn as_goal(condition: &str) {
    let text = format!(
        "(define (problem p) (:domain d) (:objects jam - item table - place lamp - thing)
          (:init (ready) (lit lamp) (at milk table) (at jam shelf) (link milk lamp) (link jam jam)) (:goal {condition}))"
    );
    match pddl::read_problem(&BARE, "p.pddl", &text) {
        Ok(problem) => {
            effort::within(4 * UNITS, || check_problem(&problem));
        }
        Err(findings) => drop(findings.to_string()),
    }
}

fn check_problem(problem: &Problem) {
    let Problem { world, wanted, .. } = problem;
    let Some(holds_now) = all_hold(world, &world.state, wanted) else {
        return;
    };
    let written = pddl::write_problem(world, &Purpose::from(problem), "p").expect("there are no rules for every state");
    let again = pddl::read_problem(&BARE, "again.pddl", &written).expect("what was written can be read");
    assert_eq!(again.world.state, world.state, "{written}");
    if let Some(holds_again) = all_hold(&again.world, &again.world.state, &again.wanted) {
        assert_eq!(holds_again, holds_now, "{written}");
    }
    let spent = effort::within(UNITS, || search::solve(world, &Purpose::from(problem), &small()));
    match spent.result {
        _ if spent.exhausted => {}
        Outcome::Solved { plan, .. } => {
            assert!(
                !holds_now || plan.steps().is_empty(),
                "nothing is to be done, and {plan:?} is"
            );
            let mut state = world.state.clone();
            for step in plan.steps() {
                let action = BARE.action(step.action);
                if let Some(missing) = missing(world, &state, &action.precondition, step.arguments.clone()) {
                    assert!(!missing, "a step of a solution can be done");
                }
                apply(world, &mut state, action, &step.arguments);
            }
            for wanted in [wanted, &again.wanted] {
                assert_ne!(
                    all_hold(world, &state, wanted),
                    Some(false),
                    "a solution reaches what is wanted"
                );
            }
        }
        Outcome::ProvenUnsolvable { .. } => assert!(!holds_now, "what holds is no unsolvable goal"),
        Outcome::GaveUp { .. } => {}
    }
}

/// Returns whether everything that is wanted holds; none where that takes too much work to tell.
fn all_hold(world: &World, state: &State, wanted: &[Wanted]) -> Option<bool> {
    let mut all = true;
    for part in wanted {
        all &= !missing(world, state, &part.condition, part.bindings.clone())?;
    }
    Some(all)
}

/// Returns whether something is missing for the condition, by both ways to find out.
fn missing(
    world: &World,
    state: &State,
    condition: &Condition,
    mut bindings: Vec<environment::EntityId>,
) -> Option<bool> {
    let spent = effort::within(UNITS, || {
        let holds = holds(Moment { world, state }, condition, &mut bindings);
        (holds, unmet(world, state, condition, &mut bindings).is_empty())
    });
    let (holds, nothing_unmet) = spent.result;
    if spent.exhausted {
        return None;
    }
    assert_eq!(holds, nothing_unmet, "{condition:?}");
    Some(!holds)
}

fn as_rule(condition: &str) {
    let (files, environment) = &*GREENHOUSE;
    let Ok(condition) = serde_json::to_string(condition) else {
        return;
    };
    let rule =
        format!("[[rule]]\nname = \"fuzz\"\nholds = \"end\"\ncondition = {condition}\nsays = \"no\"\n\n[lexicon]");
    let files = Files {
        words: files.words.replacen("[lexicon]", &rule, 1),
        ..files.clone()
    };
    let domain = match domain::load(&files) {
        Ok(domain) => domain,
        Err(findings) => return drop(findings.to_string()),
    };
    let read = effort::within(UNITS, || {
        environment::read(&domain, environment, "environment", "", &Path::default())
    });
    let Ok(world) = read.result else {
        return;
    };
    for rule in domain.rules.iter().filter(|rule| rule.name == "fuzz") {
        let mut all = vec![Vec::new()];
        for variable in &rule.variables {
            let entities = world.of_kind(variable.kind);
            all = all
                .iter()
                .flat_map(|bindings: &Vec<_>| entities.iter().map(|entity| [&bindings[..], &[*entity]].concat()))
                .take(64)
                .collect();
        }
        for bindings in all {
            missing(&world, &world.state, &rule.condition, bindings);
        }
    }
}
