//! Domains of somebody's own: read, linted, grounded, searched; problems for planners.

use longstep::Clock;
use longstep::domain::{self, Files};
use longstep::report::{self, Status};
use longstep_core::pddl;
use longstep_core::verify::Purpose;

use super::{LARGEST, Row, Work, fill, nest};

const LOADING: u64 = 10_000_000;
const SOLVING: u64 = 120_000_000;

/// Reads a domain and a problem, and searches for a plan.
fn planned(domain: String, problem: String) -> Work {
    assert!(
        domain.len() + problem.len() <= LARGEST,
        "{} bytes",
        domain.len() + problem.len()
    );
    Box::new(move || {
        let domain = match domain::from_pddl("domain.pddl", &domain) {
            Ok(domain) => domain,
            Err(_) => return false,
        };
        let problem = match pddl::read_problem(&domain, "problem.pddl", &problem) {
            Ok(problem) => problem,
            Err(_) => return false,
        };
        let purpose = Purpose::from(&problem);
        let found = report::of_purpose(
            &problem.world,
            &purpose,
            None,
            "",
            &longstep::Limits::default(),
            &Clock::none(),
        );
        let _ = pddl::write_problem(&problem.world, &purpose, "again");
        found.answer.status == Status::Verified
    })
}

/// A domain with one action, and its problem with so many objects.
fn one(parameters: &str, precondition: &str, effect: &str, objects: usize, goal: &str) -> Work {
    let domain = format!(
        "(define (domain d) (:requirements :adl) (:predicates (p ?a) (q ?a ?b) (done))\n (:action act :parameters ({parameters}) \
         :precondition {precondition} :effect {effect}))"
    );
    let names: Vec<String> = (0..objects).map(|n| format!("o{n}")).collect();
    let problem = format!(
        "(define (problem x) (:domain d) (:objects {}) (:init (p o0)) (:goal {goal}))",
        names.join(" ")
    );
    planned(domain, problem)
}

fn quantified(depth: usize, quantifier: &str, inner: &str) -> String {
    let open: String = (0..depth).map(|n| format!("({quantifier} (?x{n}) ")).collect();
    format!("{open}{inner}{}", ")".repeat(depth))
}

/// Checks a plan of so many steps in a domain with one action.
fn checked(parameters: &str, precondition: &str, effect: &str, objects: usize, step: &str, steps: usize) -> Work {
    let domain = format!(
        "(define (domain d) (:requirements :adl) (:predicates (p ?a) (q ?a ?b) (done))\n (:action act :parameters ({parameters}) \
         :precondition {precondition} :effect {effect}))"
    );
    let names: Vec<String> = (0..objects).map(|n| format!("o{n}")).collect();
    let problem = format!(
        "(define (problem x) (:domain d) (:objects {}) (:init (p o0)) (:goal (done)))",
        names.join(" ")
    );
    let plan = format!("({step})\n").repeat(steps);
    assert!(domain.len() + problem.len() + plan.len() <= LARGEST);
    Box::new(move || {
        let domain = domain::from_pddl("domain.pddl", &domain).unwrap_or_else(|e| panic!("{e}"));
        let problem = pddl::read_problem(&domain, "problem.pddl", &problem).unwrap_or_else(|e| panic!("{e}"));
        let steps = pddl::read_plan(&problem.world, "plan", &plan)
            .unwrap_or_else(|e| panic!("{e}"))
            .steps;
        let explained = |step: longstep_core::search::GroundAction| {
            longstep_core::plan::Step::explained(&problem.world, step.action, step.arguments)
        };
        let purpose = Purpose::from(&problem);
        let plan = steps.into_iter().map(explained).collect();
        let report = longstep_core::verify::check(&problem.world, plan, &purpose);
        report.into_verified().is_ok()
    })
}

/// A rule of the starter's domain that joins facts about parcels, and a station with so many of them.
fn ruled(time: &str, parcels: usize) -> Work {
    let condition = "(forall (?a ?b ?c ?d - parcel ?s - station) (or (not (at ?a ?s)) (not (at ?b ?s)) (not (at ?c ?s)) \
                     (not (at ?d ?s)) (not (carrying ?d))))";
    let rule =
        format!("\n[[rule]]\nname = \"r\"\nholds = \"{time}\"\ncondition = \"{condition}\"\nsays = \"too much\"\n");
    let mut files = starter();
    files.words.push_str(&rule);
    let domain = domain::load(&files).unwrap_or_else(|e| panic!("{e}"));
    let parcels = super::numbered("o", 0..parcels);
    let at: serde_json::Map<String, serde_json::Value> = parcels
        .iter()
        .map(|parcel| (parcel.clone(), serde_json::json!("at(<a>)")))
        .collect();
    let environment = serde_json::json!({"assets": ["<a>", "<b>"], "asset_states": {"<a>": "robot_here()"}, "objects": parcels,
        "object_states": at});
    let text = environment.to_string();
    Box::new(move || {
        let environment = longstep_core::environment::Environment::from_json(&text).unwrap();
        let inside = longstep_core::json::Path::default();
        let Ok(world) = longstep_core::environment::read(&domain, &environment, "environment", &text, &inside) else {
            return false;
        };
        let Ok(goal) = longstep::goal::parse(&world, "bring(<o1>, <b>)") else {
            return false;
        };
        report::of_goal(&world, &goal, "", &longstep::Limits::default(), &Clock::none())
            .answer
            .status
            == Status::Verified
    })
}

/// The starter without its example plans, which are valid only for the unchanged domain.
fn starter() -> Files {
    let mut files = Files::from_texts("", domain::starter("starter"));
    files.parts.clear();
    files
}

/// Loads the starter's files with one of them changed, and lints them.
fn loaded(change: fn(&mut Files)) -> Work {
    let mut files = starter();
    change(&mut files);
    Box::new(move || {
        if let Ok(domain) = domain::load(&files) {
            let _ = longstep::dialogue::fixed_parts(&domain);
            longstep_author::lint(&domain, &files);
        }
        false
    })
}

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row {
            name: "pddl/lists",
            ceiling: LOADING,
            make: || planned(nest("(", "", ")"), String::new()),
        },
        Row {
            name: "pddl/goal-nested",
            ceiling: SOLVING,
            make: || {
                one(
                    "",
                    "()",
                    "(done)",
                    3,
                    &nest("(and ", "(done)", ")")[..0]
                        .to_owned()
                        .chars()
                        .chain("(and ".repeat(190).chars())
                        .chain("(done)".chars())
                        .chain(")".repeat(190).chars())
                        .collect::<String>(),
                )
            },
        },
        Row {
            name: "pddl/not",
            ceiling: SOLVING,
            make: || {
                one(
                    "",
                    "()",
                    "(done)",
                    3,
                    &format!("{}(done){}", "(not ".repeat(190), ")".repeat(190)),
                )
            },
        },
        Row {
            name: "pddl/imply",
            ceiling: SOLVING,
            make: || {
                one(
                    "",
                    "()",
                    "(done)",
                    3,
                    &format!("{}(done){}", "(imply (done) ".repeat(180), ")".repeat(180)),
                )
            },
        },
        Row {
            name: "pddl/quantified-goal",
            ceiling: SOLVING,
            make: || {
                one(
                    "",
                    "()",
                    "(done)",
                    40,
                    &quantified(8, "forall", "(or (q ?x0 ?x7) (done))"),
                )
            },
        },
        Row {
            name: "pddl/quantified-exists",
            ceiling: SOLVING,
            make: || {
                one(
                    "",
                    "()",
                    "(done)",
                    40,
                    &quantified(8, "exists", "(and (q ?x0 ?x7) (not (q ?x1 ?x6)))"),
                )
            },
        },
        Row {
            name: "pddl/quantified-precondition",
            ceiling: SOLVING,
            make: || {
                one(
                    "?a",
                    &quantified(6, "forall", "(or (q ?x0 ?x5) (not (q ?a ?x3)))"),
                    "(done)",
                    60,
                    "(done)",
                )
            },
        },
        Row {
            name: "pddl/effects",
            ceiling: SOLVING,
            make: || {
                one(
                    "",
                    "()",
                    &quantified(6, "forall", "(when (not (q ?x0 ?x5)) (q ?x1 ?x2))"),
                    60,
                    "(forall (?x ?y) (q ?x ?y))",
                )
            },
        },
        Row {
            name: "pddl/effects-wide",
            ceiling: SOLVING,
            make: || {
                one(
                    "?a ?b",
                    "()",
                    "(forall (?c) (when (q ?a ?c) (q ?b ?c)))",
                    500,
                    "(forall (?x) (q ?x o1))",
                )
            },
        },
        Row {
            name: "pddl/parameters",
            ceiling: SOLVING,
            make: || {
                one(
                    "?a ?b ?c ?d ?e ?f",
                    "(and (q ?a ?b) (q ?c ?d) (q ?e ?f))",
                    "(done)",
                    1_000,
                    "(done)",
                )
            },
        },
        Row {
            name: "pddl/parameters-some",
            ceiling: SOLVING,
            make: || {
                one(
                    "?a ?b",
                    "(not (q ?a ?b))",
                    "(and (q ?a ?b) (p ?b))",
                    120,
                    "(forall (?x) (p ?x))",
                )
            },
        },
        Row {
            name: "pddl/pairs",
            ceiling: SOLVING,
            make: || {
                one(
                    "?a ?b",
                    "(and (p ?a) (not (p ?b)))",
                    "(and (p ?b) (not (p ?a)))",
                    200,
                    "(and (p o1) (p o2))",
                )
            },
        },
        Row {
            name: "pddl/toggles",
            ceiling: SOLVING,
            make: || {
                one(
                    "?a",
                    "(not (p ?a))",
                    "(and (p ?a) (forall (?x) (when (q ?x ?a) (not (p ?x)))))",
                    400,
                    "(forall (?x) (p ?x))",
                )
            },
        },
        Row {
            name: "pddl/whens",
            ceiling: LOADING,
            make: || {
                one(
                    "",
                    "()",
                    &format!("{}(done){}", "(when (done) ".repeat(190), ")".repeat(190)),
                    3,
                    "(done)",
                )
            },
        },
        Row {
            name: "pddl/types",
            ceiling: LOADING,
            make: || {
                let types: String = (0..1_000).map(|n| format!("t{} - t{n} ", n + 1)).collect();
                planned(
                    format!("(define (domain d) (:types {types}) (:predicates (done)))"),
                    "(define (problem x) (:domain d) (:goal (done)))".to_owned(),
                )
            },
        },
        Row {
            name: "pddl/names",
            ceiling: LOADING,
            make: || {
                let predicates: String = (0..2_000).map(|n| format!("(p{n})")).collect();
                planned(
                    format!("(define (domain d) (:predicates {predicates}))"),
                    "(define (problem x) (:domain d) (:goal (q)))".to_owned(),
                )
            },
        },
        Row {
            name: "pddl/actions",
            ceiling: SOLVING,
            make: || {
                let actions: String = (0..200)
                    .map(|n| format!("(:action a{n} :precondition (p{n}) :effect (p{}))", n + 1))
                    .collect();
                let predicates: String = (0..201).map(|n| format!("(p{n})")).collect();
                planned(
                    format!("(define (domain d) (:predicates {predicates}){actions})"),
                    "(define (problem x) (:domain d) (:init (p0)) (:goal (p200)))".to_owned(),
                )
            },
        },
        Row {
            name: "domain/loops",
            ceiling: LOADING,
            make: || loaded(|files| files.goal_prompt = "{% for a in goals %}".repeat(12) + &"{% endfor %}".repeat(12)),
        },
        Row {
            name: "domain/doubling",
            ceiling: LOADING,
            make: || {
                loaded(|files| files.goal_prompt = "{% set s = 'aa' %}".to_owned() + &"{% set s = s ~ s %}".repeat(900))
            },
        },
        Row {
            name: "domain/template-deep",
            ceiling: LOADING,
            make: || {
                loaded(|files| {
                    files.goal_prompt = format!("{{{{ {} }}}}", nest("(", "name", ")")[..].to_owned())
                        .chars()
                        .take(19_990)
                        .collect()
                })
            },
        },
        Row {
            name: "domain/rules",
            ceiling: LOADING,
            make: || {
                loaded(|files| {
                    let condition = quantified(8, "forall", "(or (at ?x0 ?x1) (at ?x2 ?x3))");
                    files.words.push_str(&format!(
                        "\n[[rule]]\nname = \"r\"\nholds = \"always\"\ncondition = \"{condition}\"\nsays = \"no\"\n"
                    ));
                })
            },
        },
        Row {
            name: "domain/tables",
            ceiling: LOADING,
            make: || loaded(|files| files.words.push_str(&fill("[[rule]]\n")[..15_000])),
        },
        Row {
            name: "domain/toml-nested",
            ceiling: LOADING,
            make: || loaded(|files| files.words = format!("a = {}", nest("[", "", "]"))),
        },
        Row {
            name: "domain/toml-keys",
            ceiling: LOADING,
            make: || loaded(|files| files.words = fill("a.").to_owned() + "b = 1"),
        },
        Row {
            name: "domain/examples",
            ceiling: 40_000_000,
            make: || {
                loaded(|files| {
                    files.examples =
                        fill("[[example]]\nobjects={}\nplaces={}\ninstruction=\"a\"\nanswer=\"question: a\"\n")
                })
            },
        },
        Row {
            name: "domain/holes",
            ceiling: LOADING,
            make: || {
                loaded(|files| {
                    files.words = files.words.replace(
                        "says = \"drive to {to}\"",
                        &format!("says = \"{}\"", "{to}".repeat(3_500)),
                    )
                })
            },
        },
        Row {
            name: "verify/quantified-precondition",
            ceiling: SOLVING,
            make: || {
                checked(
                    "?a",
                    &quantified(6, "forall", "(or (q ?x0 ?x5) (not (q ?a ?x3)))"),
                    "(done)",
                    60,
                    "act o1",
                    100,
                )
            },
        },
        Row {
            name: "verify/quantified-effects",
            ceiling: SOLVING,
            make: || {
                checked(
                    "",
                    "()",
                    &quantified(6, "forall", "(when (not (q ?x0 ?x5)) (q ?x1 ?x2))"),
                    60,
                    "act",
                    100,
                )
            },
        },
        Row {
            name: "verify/wide-effects",
            ceiling: SOLVING,
            make: || {
                checked(
                    "",
                    "()",
                    "(forall (?x ?y) (when (not (q ?x ?y)) (q ?y ?x)))",
                    700,
                    "act",
                    1_000,
                )
            },
        },
        Row {
            name: "environment/rules",
            ceiling: SOLVING,
            make: || ruled("start", 300),
        },
        Row {
            name: "verify/rules",
            ceiling: SOLVING,
            make: || ruled("always", 300),
        },
    ]
}
