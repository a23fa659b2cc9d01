use super::*;
use crate::goal;
use crate::testing;
use longstep_model::environment;
use longstep_model::json::Path;
use longstep_model::model::Environment;
use longstep_verify::plan::{Node, Plan, Test};
use longstep_verify::verify::check as verify;

fn scene(states: &str) -> (longstep_model::model::Domain, World) {
    let checks = testing::domain("household-checks");
    let text = r#"{"assets": ["<table>", "<trash_bin>", "<shelf>", "<floor>"],
            "objects": ["<spam>", "<milk>", "<sponge>", "<rag>"], "object_states": {"<spam>": ["on_something(<table>)"],
            "<milk>": ["on_something(<table>)"], "<sponge>": ["on_something(<floor>)"],
            "<rag>": ["on_something(<floor>)"]}, "asset_states": {}}"#;
    let mut environment = Environment::from_json(text).unwrap();
    for state in states.split_whitespace() {
        let (entity, word) = state.split_once(':').unwrap();
        let list = if environment.assets.iter().any(|asset| asset == entity) {
            &mut environment.asset_states
        } else {
            &mut environment.object_states
        };
        let mut words: Vec<String> = list
            .get(entity)
            .map_or_else(Vec::new, |words| words.as_slice().to_vec());
        words.push(word.to_owned());
        list.insert(
            entity.to_owned(),
            serde_json::from_value(serde_json::json!(words)).unwrap(),
        );
    }
    let text = serde_json::to_string(&environment).unwrap();
    let world = environment::read(&checks, &environment, "", &text, &Path::default()).unwrap();
    (checks, world)
}

/// Formats a plan briefly: calls with the entities they are about.
fn shown(domain: &longstep_model::model::Domain, world: &World, plan: &Plan, nodes: &[Node]) -> String {
    let step = |id: &longstep_verify::plan::StepId| {
        let step = plan.step(*id);
        let names: Vec<&str> = step.arguments.iter().map(|e| world.entity(*e).name.as_str()).collect();
        format!("{} {}", domain.action(step.action).name, names.join(" "))
    };
    fn test(world: &World, t: &Test, step: &dyn Fn(&longstep_verify::plan::StepId) -> String) -> String {
        match t {
            Test::Sense(id) => step(id),
            Test::Holds(fact) => longstep_model::environment::Voice::Person.fact(world, *fact, true),
            Test::Not(inner) => format!("not {}", test(world, inner, step)),
            Test::All(parts) | Test::Any(parts) => {
                let parts: Vec<String> = parts.iter().map(|part| test(world, part, step)).collect();
                parts.join(if matches!(t, Test::All(_)) { " and " } else { " or " })
            }
        }
    }
    let all: Vec<String> = nodes
        .iter()
        .map(|node| match node {
            Node::Step(id) => step(id),
            Node::If {
                condition,
                then,
                otherwise,
            } => format!(
                "[{} ? {} : {}]",
                test(world, condition, &step),
                shown(domain, world, plan, then),
                shown(domain, world, plan, otherwise)
            ),
            Node::While { condition, body } => format!(
                "(while {}: {})",
                test(world, condition, &step),
                shown(domain, world, plan, body)
            ),
            other => format!("{other:?}"),
        })
        .collect();
    all.join(", ")
}

#[track_caller]
fn check(states: &str, text: &str, expected: &str) {
    let (domain, world) = scene(states);
    let goal = goal::parse(&world, text).unwrap();
    let outcome = solve(&world, &Target::of(&domain, &goal.purpose(&world)), &Limits::default());
    let found = match &outcome {
        Outcome::Solved { plan, shortest, .. } => {
            let report = verify(&world, plan.clone(), &goal.purpose(&world));
            assert_eq!(report.violations, [], "{text}");
            let more = if *shortest { "" } else { "~ " };
            format!("{more}{}", shown(&domain, &world, plan, plan.body()))
        }
        Outcome::ProvenUnsolvable { when, .. } => {
            let when = when.map(|fact| longstep_model::environment::Voice::Person.fact(&world, fact, true));
            format!("unsolvable: {when:?}")
        }
        Outcome::GaveUp { why, .. } => format!("gave up: {why}"),
    };
    assert_eq!(found, expected, "{text}");
}

#[test]
fn search_senses_before_a_conditional_branch() {
    check(
        "",
        "if expired(spam) then put(spam, trash bin) else put(spam, shelf)",
        "move-hand spam, grasp spam, detach spam table, [check-best-by-date spam ? move-object spam shelf, \
         attach spam shelf : move-object spam trash bin], release spam",
    );
    // An object that was lifted for sensing has to be put down again.
    check(
        "",
        "if expired(spam) then put(spam, trash bin)",
        "move-hand spam, grasp spam, detach spam table, [check-best-by-date spam ? move-object spam table, \
         attach spam table : move-object spam trash bin], release spam",
    );
    check(
        "",
        "if dirty(table) then wiped(table, sponge)",
        "move-hand sponge, grasp sponge, detach sponge floor, move-object sponge table, [check-cleanness table ? move-object sponge floor, attach sponge floor : attach sponge table, wipe sponge table], release sponge",
    );
}

#[test]
fn search_merges_sensing_outcomes_with_the_same_plan() {
    check(
        "",
        "if empty(spam) then put(spam, trash bin) else put(spam, shelf)",
        "move-hand spam, grasp spam, detach spam table, move-object spam shelf, check-fullness spam, [the spam is empty ? \
         move-object spam trash bin : attach spam shelf], release spam",
    );
}

#[test]
fn search_does_not_sense_known_or_irrelevant_facts() {
    check(
        "<spam>:expired()",
        "if expired(spam) then put(spam, trash bin) else put(spam, shelf)",
        "move-hand spam, grasp spam, detach spam table, move-object spam trash bin, release spam",
    );
    check("<spam>:fresh()", "if expired(spam) then put(spam, trash bin)", "");
    // Irrelevant facts are not sensed either.
    check(
        "",
        "if expired(spam) then put(spam, trash bin) else put(spam, trash bin)",
        "move-hand spam, grasp spam, detach spam table, move-object spam trash bin, release spam",
    );
}

#[test]
fn search_reports_the_outcome_that_prevents_a_plan() {
    check(
        "",
        "expired(spam)",
        "unsolvable: Some(\"the spam is not past its date\")",
    );
    check(
        "",
        "if expired(spam) then put(spam, trash bin) else put(spam, spam)",
        "unsolvable: Some(\"the spam is not past its date\")",
    );
    check("", "put(spam, spam)", "unsolvable: None");
}

#[test]
fn search_senses_in_a_loop_until_the_effect_holds() {
    check(
        "",
        "clean(table)",
        "~ move-hand sponge, grasp sponge, detach sponge floor, move-hand table, attach sponge table, \
         (while not check-cleanness table: wipe sponge table), release sponge",
    );
    check(
        "<table>:dirty()",
        "clean(table)",
        "~ move-hand sponge, grasp sponge, detach sponge floor, move-hand table, attach sponge table, \
         wipe sponge table, (while not check-cleanness table: wipe sponge table), release sponge",
    );
}

#[test]
fn search_senses_two_conditions_one_after_another() {
    check(
        "",
        "if expired(spam) then put(spam, trash bin) else put(spam, shelf) & if expired(milk) then put(milk, trash bin) \
         else put(milk, shelf)",
        "move-hand spam, grasp spam, detach spam table, [check-best-by-date spam ? move-object spam shelf, \
         attach spam shelf : move-object spam trash bin], release spam, move-hand milk, grasp milk, detach milk table, \
         [check-best-by-date milk ? move-object milk shelf, attach milk shelf : move-object milk trash bin], \
         release milk",
    );
}

#[test]
fn search_restores_objects_moved_only_for_sensing() {
    check(
        "",
        "if expired(spam) then put(spam, shelf)",
        "move-hand spam, grasp spam, detach spam table, [check-best-by-date spam ? move-object spam table, attach spam table : move-object spam shelf, attach spam shelf], release spam",
    );
    check(
        "",
        "if broken(spam) then put(milk, shelf)",
        "move-hand spam, grasp spam, detach spam table, move-object spam table, [check-damage spam ? attach spam table, release spam : attach spam table, release spam, move-hand milk, grasp milk, detach milk table, move-object milk shelf, attach milk shelf, release milk]",
    );
    // The second goal puts it on the shelf in any case.
    check(
        "",
        "if expired(spam) then put(milk, trash bin) & put(spam, shelf)",
        "move-hand spam, grasp spam, detach spam table, move-object spam shelf, [check-best-by-date spam ? attach spam shelf, release spam : attach spam shelf, release spam, move-hand milk, grasp milk, detach milk table, move-object milk trash bin, release milk]",
    );
}

#[test]
fn search_does_not_restore_objects_that_a_goal_has_moved() {
    check(
        "",
        "if clean(sponge) then wiped(table, sponge)",
        "move-hand sponge, [check-cleanness sponge ? grasp sponge, detach sponge floor, move-object sponge table, \
         attach sponge table, wipe sponge table, release sponge : ]",
    );
    // With a group, the goal is a choice.
    check(
        "",
        "if clean(sponge) then wiped(any table, sponge)",
        "move-hand sponge, [check-cleanness sponge ? grasp sponge, detach sponge floor, move-object sponge table, \
         attach sponge table, wipe sponge table, release sponge : ]",
    );
}

#[test]
fn policy_that_costs_too_much_is_not_proven_impossible() {
    let (domain, world) = scene("");
    for (text, below, expected) in [
        (
            "if expired(spam) then put(spam, trash bin) else put(spam, shelf)",
            100,
            "found",
        ),
        (
            "if expired(spam) then put(spam, trash bin) else put(spam, shelf)",
            4,
            "too dear",
        ),
        ("if dirty(table) then wiped(table, sponge)", 7, "too dear"),
        (
            "if expired(spam) then put(spam, spam) else put(spam, shelf)",
            100,
            "impossible",
        ),
    ] {
        let goal = goal::parse(&world, text).unwrap();
        let target = Target::of(&domain, &goal.purpose(&world));
        let scope = Scope::whole(&world, &Requirements::of(&world, &target.wanted, &target.stages));
        let task = relevance::reduce(ground::ground_sensing(&world, &scope, &target));
        let mut search = Search::new(&task, exact(10_000));
        let found = match search.run(below) {
            Ok(Some(_)) => "found",
            Ok(None) if search.is_too_dear() => "too dear",
            Ok(None) => "impossible",
            Err(TooFar) => "too far",
        };
        assert_eq!(found, expected, "{text}, below {below}");
    }
}

/// Returns the domain with a cost of 3 for each step.
fn with_costs(name: &str) -> longstep_model::model::Domain {
    let mut files = longstep_model::domain::shipped_files(name).unwrap();
    let mut actions = files.pddl.trim_end().strip_suffix(')').unwrap().split("(:action ");
    let mut pddl = format!("{}(:functions (total-cost) - number)\n", actions.next().unwrap());
    for action in actions {
        let (before, effect) = action.split_once(":effect ").unwrap();
        // The last effect of an action ends with its parenthesis.
        let (effect, after) = effect.rsplit_once(')').unwrap();
        pddl.push_str(&format!(
            "(:action {before}:effect (and {effect} (increase (total-cost) 3))){after}"
        ));
    }
    files.pddl = pddl + ")";
    longstep_model::domain::load(&files).unwrap_or_else(|findings| panic!("{findings}"))
}

#[test]
fn steps_of_equal_cost_give_the_plan_of_steps_without_cost() {
    let text = r#"{"assets": ["<table>", "<fridge>", "<bin>"], "objects": ["<fridge_handle>", "<cup>"],
        "object_states": {"<fridge_handle>": "closed()", "<cup>": "on_something(<table>)"}}"#;
    let goal = "if full(cup) then opened(fridge) else put(cup, bin) & opened(fridge)";
    // To look only after the cup was moved back to the table costs as much, and the move is perhaps made for nothing.
    let expected = "move-hand fridge handle, grasp fridge handle, open-by-rotate fridge handle, release fridge handle, \
        move-hand cup, grasp cup, detach cup table, [check-fullness cup ? move-object cup table, attach cup table : \
        move-object cup bin], release cup";
    for domain in [testing::domain("household-checks"), with_costs("household-checks")] {
        let world = testing::world_of(&domain, text);
        let purpose = goal::parse(&world, goal).unwrap().purpose(&world);
        let outcome = solve(&world, &Target::of(&domain, &purpose), &Limits::default());
        let Outcome::Solved { plan, .. } = outcome else {
            panic!("{outcome:?}");
        };
        let plan = shown(&domain, &world, &plan, plan.body());
        assert_eq!(plan, expected, "with costs: {}", domain.has_costs());
    }
}
