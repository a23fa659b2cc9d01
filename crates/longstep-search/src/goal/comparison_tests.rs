//! Numbers in a domain with words: a robot that carries water.

use super::{GoalFact, parse, rules};
use crate::pddl::{read_problem, write_problem};
use crate::search::{Limits, Missing, Outcome, solve, why_not};
use crate::testing;
use longstep_model::diagnostic::Diagnostics;
use longstep_model::environment;
use longstep_model::model::{Domain, Number, World};
use longstep_verify::plan::{Plan, Step};
use longstep_verify::verify::{Purpose, check};

fn tank() -> Domain {
    testing::domain("tank")
}

const PLACES: &str = r#""assets": ["<well>", "<dock>", "<north_tank>", "<south_tank>"]"#;

fn environment_text(battery: &str, north: &str) -> String {
    format!(
        r#"{{{PLACES}, "asset_states": {{
            "<well>": ["here()", "distance(<dock>, 10)", "distance(<north_tank>, 40)", "distance(<south_tank>, 12.5)"],
            "<dock>": ["distance(<well>, 10)", "distance(<north_tank>, 50)", "distance(<south_tank>, 20)"],
            "<north_tank>": ["level({north})", "capacity(20)", "distance(<well>, 40)", "distance(<dock>, 50)", "distance(<south_tank>, 30)"],
            "<south_tank>": ["level(3)", "capacity(20)", "distance(<well>, 12.5)", "distance(<dock>, 20)", "distance(<north_tank>, 30)"]}},
            "facts": ["raining", "bucket(0)", "battery({battery})"]}}"#
    )
}

fn read(text: &str) -> Result<World, Diagnostics> {
    environment::parse(&tank(), "env.json", text)
}

#[test]
fn environment_states_numbers_with_and_without_subject() {
    let world = read(&environment_text("80", "0")).unwrap();
    assert_eq!(world.state.numbers().len(), 18);
    assert_eq!(environment::write(&world, &world.state), *world.environment());
    let wrong = |from: &str, to: &str| {
        read(&environment_text("80", "0").replace(from, to))
            .unwrap_err()
            .to_string()
    };
    for (from, to, expected) in [
        (
            "level(3)",
            "level(300)",
            "`level(300)` is outside of the range of `level`, 0 to 40 l",
        ),
        ("level(3)", "level(three)", "`three` is no number"),
        ("level(3)", "level(0.0000001)", "`0.0000001` is no number"),
        (
            "level(3)",
            "level()",
            "`level` takes 1 argument(s), the number last, not 0",
        ),
        (
            "level(3)\", ",
            "level(3)\", \"level(4)\", ",
            "`level(4)` contradicts another number, 3",
        ),
        (
            "level(3)",
            "levle(3)",
            "unknown state `levle`\n  hint: did you mean `level`?",
        ),
        (
            "level(3)",
            "battery(3)",
            "`battery` is a statement without a subject: write it in `facts`",
        ),
        (
            "\"bucket(0)\"",
            "\"level(3)\"",
            "`level` needs a subject: write it among the states of an entity",
        ),
        ("distance(<dock>, 20)", "distance(<dok>, 20)", "did you mean `<dock>`?"),
        (
            "\"raining\"",
            "\"rainig\"",
            "unknown statement `rainig`\n  hint: did you mean `raining`?",
        ),
    ] {
        let found = wrong(from, to);
        assert!(found.contains(expected), "{from} -> {to}: {found}");
    }
}

fn solved(world: &World, goal: &str) -> (Vec<String>, Option<String>, World) {
    let goal = parse(world, goal).unwrap_or_else(|error| panic!("{goal}: {error}"));
    let purpose = goal.purpose(world);
    match solve(world, &purpose, &Limits::default()) {
        Outcome::Solved {
            plan, cost, shortest, ..
        } => {
            let plan = check(world, plan, &purpose).into_verified().unwrap();
            assert!(shortest);
            assert_eq!(plan.report().cost(), cost);
            let calls = plan.steps().iter().map(|step| step.call(world).to_string()).collect();
            (calls, cost.map(|cost| cost.to_string()), world.after(plan.ending()))
        }
        other => (vec![format!("{other:?}")], None, world.clone()),
    }
}

#[test]
fn goals_about_numbers_are_planned_verified_and_written_back() {
    let world = read(&environment_text("80", "0")).unwrap();
    let (calls, cost, after) = solved(&world, "level(north tank) >= 5 & level(south tank) > 3");
    // The cheapest of the plans: the south tank is near the well, so the way leads over it.
    assert_eq!(
        calls,
        [
            "Draw(<well>)",
            "Drive(<south_tank>)",
            "Pour(<south_tank>)",
            "Drive(<well>)",
            "Draw(<well>)",
            "Drive(<north_tank>)",
            "Pour(<north_tank>)",
        ]
    );
    assert_eq!(cost.as_deref(), Some("69"));
    let environment = after.environment();
    assert_eq!(environment.asset_states["<south_tank>"].as_slice()[0], "level(8)");
    assert_eq!(
        environment.facts.as_deref().unwrap(),
        ["raining", "bucket(0)", "battery(47.5)"]
    );
    let again = environment::read(&tank(), environment, "", "", &Default::default()).unwrap();
    assert_eq!(again.state, after.state);
    // With little charge, the robot drives by the dock.
    let low = read(&environment_text("6", "0")).unwrap();
    let (calls, cost, _) = solved(&low, "level(north tank) = 5");
    let by_the_dock = [
        "Draw(<well>)",
        "Drive(<dock>)",
        "Charge(<dock>)",
        "Drive(<north_tank>)",
        "Pour(<north_tank>)",
    ];
    assert_eq!(calls, by_the_dock);
    assert_eq!(cost.as_deref(), Some("67"));
}

#[test]
fn rules_about_numbers_bind_plans() {
    let world = read(&environment_text("30", "0")).unwrap();
    let (calls, ..) = solved(&world, "level(north tank) >= 5 & never battery < 10");
    assert_eq!(calls, ["Draw(<well>)", "Drive(<north_tank>)", "Pour(<north_tank>)"]);
    let (calls, ..) = solved(&world, "level(north tank) >= 5 & always battery >= 20");
    assert_eq!(calls[..3], ["Draw(<well>)", "Drive(<dock>)", "Charge(<dock>)"]);
    let (calls, ..) = solved(&world, "battery < 20 & never battery < 20");
    assert!(calls[0].starts_with("ProvenUnsolvable"), "{calls:?}");
    let standing = world.with_prohibitions(rules(&world, "never level(south tank) > 3").unwrap());
    let goal = parse(&standing, "level(south tank) >= 4").unwrap();
    let why = why_not(&standing, &goal.purpose(&standing), &Limits::default());
    assert_eq!(why.prohibitions, ["never level(<south_tank>) > 3"]);
}

#[test]
fn goals_about_numbers_parse_back_and_mistakes_are_named() {
    let world = read(&environment_text("80", "0")).unwrap();
    for (text, everyday) in [
        ("level(north tank) >= 3", "level(north tank) >= 3"),
        ("level(<north_tank>)>=3.50 l", "level(north tank) >= 3.5"),
        ("battery < 20 %", "battery() < 20"),
        ("battery() != -1", "battery() != -1"),
        (
            "level(<north_tank>) > level(south tank)",
            "level(north tank) > level(south tank)",
        ),
        ("distance(well, dock) = 10 m", "distance(well, dock) = 10"),
        ("never battery <= 5", "never battery() <= 5"),
        ("bucket = 5 then bucket = 0", "bucket() = 5 & then bucket() = 0"),
    ] {
        let goal = parse(&world, text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(goal.everyday(&world).join(" & "), everyday, "{text}");
        let exact = goal.exact(&world).join(" & ");
        assert_eq!(parse(&world, &exact).unwrap(), goal, "{exact}");
        assert_eq!(goal.carried(world.domain(), &world, &world).as_ref(), Some(&goal));
    }
    for (text, expected) in [
        (
            "level(north tank) >= many",
            "`many` in `level(north tank) >= many` should be a number in l",
        ),
        (
            "level(north tank) >= 3 m",
            "`3 m` in `level(north tank) >= 3 m` should be a number in l",
        ),
        ("level(nroth tank) >= 3", "did you mean `north tank`?"),
        ("level() >= 3", "`level()` in `level() >= 3` should be `level(T)`"),
        ("levels(north tank) >= 3", "is not a goal of this domain"),
    ] {
        let error = parse(&world, text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
    let goal = parse(&world, "level(north tank) >= 3 & bucket = 5").unwrap();
    assert_eq!(
        goal.sentences(&world),
        ["the level of the north tank >= 3 l", "bucket() = 5"]
    );
    assert!(matches!(goal.facts[0], GoalFact::Number(_)));
}

#[test]
fn violations_name_the_number_that_is_missing() {
    let world = read(&environment_text("6", "18")).unwrap();
    let step = |name: &str, places: &[&str]| {
        let (id, _) = world
            .domain()
            .action_ids()
            .find(|(_, action)| action.name == name)
            .unwrap();
        Step::explained(
            &world,
            id,
            places.iter().map(|place| world.find(place).unwrap()).collect(),
        )
    };
    let messages = |steps: Vec<Step>| {
        let report = check(&world, Plan::sequence(steps), &Purpose::default());
        let steps = report.plan.steps();
        report
            .violations
            .iter()
            .map(|own| own.message(&world, steps, None))
            .collect::<Vec<_>>()
    };
    assert_eq!(
        messages(vec![
            step("draw", &["<well>"]),
            step("drive", &["<well>", "<north_tank>"]),
            step("pour", &["<north_tank>"])
        ]),
        [
            "step 2: Drive(<north_tank>) needs that the charge of the battery >= 20 % (it is 6 %)",
            "after step 2: the charge of the battery is outside of its range, 0 to 100 %",
            "step 3: Pour(<north_tank>) needs that the level of the north tank + bucket() <= 20 (the level of the north tank is 18 l, bucket() is 5); before step 1 (Draw(<well>)), the level of the north tank + bucket() <= 20",
        ]
    );
    let unknown = environment_text("80", "0").replace("\"level(3)\", ", "");
    let world = read(&unknown).unwrap();
    let (calls, ..) = solved(&world, "level(south tank) >= 4");
    assert!(calls[0].starts_with("ProvenUnsolvable"), "{calls:?}");
    let goal = parse(&world, "level(south tank) >= 4").unwrap();
    let why = why_not(&world, &goal.purpose(&world), &Limits::default());
    assert_eq!(why.goals, [0]);
    assert!(matches!(why.missing, Some(Missing::Number(_))));
}

#[test]
fn a_claimed_number_is_compared_with_the_simulated_one() {
    let world = read(&environment_text("80", "0")).unwrap();
    let (draw, _) = world
        .domain()
        .action_ids()
        .find(|(_, action)| action.name == "draw")
        .unwrap();
    let plan = Plan::sequence(vec![Step::explained(&world, draw, vec![world.find("<well>").unwrap()])]);
    let claimed = |facts: &[&str]| {
        let mut environment = world.environment().clone();
        environment.facts = Some(facts.iter().map(|&fact| fact.to_owned()).collect());
        let claim = environment::Claim::read(&world, &environment);
        assert!(claim.ignored.is_empty(), "{:?}", claim.ignored);
        let purpose = Purpose {
            claim: Some(claim),
            ..Purpose::default()
        };
        let report = check(&world, plan.clone(), &purpose);
        let violations = report.violations.iter();
        violations
            .map(|own| own.message(&world, report.plan.steps(), None))
            .collect::<Vec<_>>()
    };
    assert!(claimed(&["raining", "bucket(5)", "battery(80)"]).is_empty());
    assert_eq!(
        claimed(&["raining", "bucket(4)", "battery(80)"]),
        ["the plan claims that bucket() is 4 at the end, but it is 5"]
    );
}

#[test]
fn problems_with_numbers_are_written_and_read_back() {
    let world = read(&environment_text("80", "0")).unwrap();
    let goal = parse(&world, "level(north tank) >= 5").unwrap();
    // The ranges of the domain are rules on every state, which a problem cannot say.
    assert!(write_problem(&world, &goal.purpose(&world), "p").is_err());
    let domain = tank().edited(|data| data.rules.clear());
    let world = testing::world_of(&domain, environment_text("80", "0"));
    let text = write_problem(&world, &goal.purpose(&world), "p").unwrap();
    for part in [
        "(= (level north_tank) 0)",
        "(= (total-cost) 0)",
        "(>= (level north_tank) 5)",
        "(:metric minimize (total-cost))",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let again = read_problem(&domain, "p.pddl", &text).unwrap();
    let numbers = |world: &World| {
        world
            .state
            .numbers()
            .iter()
            .map(|(_, number)| *number)
            .collect::<Vec<Number>>()
    };
    assert_eq!(numbers(&again.world), numbers(&world));
    match solve(&again.world, &Purpose::from(&again), &Limits::default()) {
        Outcome::Solved { cost, .. } => assert_eq!(cost.map(|cost| cost.to_string()).as_deref(), Some("42")),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_number_may_be_relative_to_what_is_now() {
    let world = read(&environment_text("80", "0")).unwrap();
    for (text, expected) in [
        ("level(south tank) >= now + 2", "level(south tank) >= 5"),
        ("level(south tank) >= now + 2 l", "level(south tank) >= 5"),
        ("level(south tank) = now * 2", "level(south tank) = 6"),
        ("battery <= now - 7.5", "battery() <= 72.5"),
    ] {
        assert_eq!(parse(&world, text).unwrap().everyday(&world), [expected]);
    }
    let error = parse(&world, "level(south tank) >= now + 2 km")
        .unwrap_err()
        .to_string();
    assert!(error.contains("`now + 2 km`"), "{error}");
}
