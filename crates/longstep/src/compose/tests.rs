//! Compositions, from the script to the verdict.

use serde_json::{Value, json};

use super::*;
use crate::dialogue::{ChatRequest, Constraint, ConstraintKind, Dialogue};
use crate::domain::{Domain, shipped};
use crate::environment::World;
use crate::plan::{PlanFile, script};
use crate::report::Answer;
use longstep_core::testing;

/// A domain, its current world, and stored plans, each given by file name, handled object, and steps as `call:
/// explanation`.
struct Scene {
    domain: Domain,
    world: World,
    stored: Vec<Stored>,
}

impl Scene {
    fn request(&self, instruction: &str, kind: ConstraintKind) -> ChatRequest {
        let dialogue = CompositionDialogue::new(CompositionInput {
            world: &self.world,
            stored: &self.stored,
            instruction,
            rounds: &[],
            kind,
        });
        dialogue.request()
    }
}

fn scene(domain: &str, now: &Value, plans: &[(&str, &str, &Value, &[&str])]) -> Scene {
    let domain = shipped(domain).unwrap().unwrap();
    let stored = plans.iter().map(|(stem, object, before, steps)| {
        let steps: Vec<(&str, &str)> = steps.iter().map(|step| step.split_once(": ").unwrap()).collect();
        let file = json!({
            "task_cohesion": {
                "task_sequence": steps.iter().map(|step| step.0).collect::<Vec<_>>(),
                "step_instructions": steps.iter().map(|step| step.1).collect::<Vec<_>>(),
                "object_name": object,
            },
            "environment_before": before,
            "instruction_summary": stem.replace('_', " "),
        });
        Stored::new(stem, serde_json::from_value::<PlanFile>(file).unwrap())
    });
    Scene {
        world: testing::world_of(&domain, now),
        stored: stored.collect(),
        domain,
    }
}

fn larder(cream: &str) -> Value {
    json!({"assets": ["<bench>", "<ledge>", "<scrap_bin>"], "objects": ["<cream>"], "object_states": {"<cream>": cream}})
}

const TAKE: &[&str] = &[
    "move_hand(): move the hand to the cream",
    "grasp_object(): grasp the cream",
    "detach_from_plane(): lift the cream from the bench",
];
const PUT: &[&str] = &[
    "move_object(): move the cream to the ledge",
    "attach_to_plane(): put the cream on the ledge",
    "release_object(): release the cream",
];
const DROP: &[&str] = &[
    "move_object(): move the cream to the scrap bin",
    "release_object(): drop the cream into the scrap bin",
];

fn cream(now: &str) -> Scene {
    let (there, held) = (larder("on_something(<bench>)"), larder("inside_hand()"));
    scene(
        "household-checks",
        &larder(now),
        &[
            ("take_cream", "<cream>", &there, TAKE),
            ("shelve_cream", "<cream>", &held, PUT),
            ("drop_cream", "<cream>", &held, DROP),
        ],
    )
}

fn shed(now: &[&str]) -> Scene {
    let all = ["<saw>", "<vice>"];
    let world = |objects: &[&str]| {
        let states: serde_json::Map<String, Value> = objects
            .iter()
            .map(|object| ((*object).to_owned(), json!("on_something(<bench>)")))
            .collect();
        json!({"assets": ["<bench>", "<rack>"], "objects": objects, "object_states": states})
    };
    scene(
        "household-dual",
        &world(now),
        &[
            (
                "saw_away",
                "<saw>",
                &world(&all),
                &[
                    "move_hand(left): move the left hand to the saw",
                    "grasp_object(left): grasp the saw",
                    "detach_from_plane(left): lift the saw from the bench",
                    "move_object(left): move the saw to the rack",
                    "attach_to_plane(left): put the saw on the rack",
                    "release_object(left): release the saw",
                ],
            ),
            (
                "vice_away",
                "<vice>",
                &world(&all),
                &[
                    "move_hand(right): move the right hand to the vice",
                    "grasp_object(right): grasp the vice",
                    "detach_from_plane(right): lift the vice from the bench",
                    "move_object(right): move the vice to the rack",
                    "attach_to_plane(right): put the vice on the rack",
                    "release_object(right): release the vice",
                ],
            ),
            (
                "both_hands_over",
                "<vice>",
                &world(&all),
                &[
                    "move_hand(left): move the left hand to the saw",
                    "move_hand(right): move the right hand to the vice",
                ],
            ),
        ],
    )
}

fn composed<'a>(scene: &'a Scene, composition: &str) -> Result<Composed<'a>, Vec<Misfit>> {
    let written = script::read(composition).unwrap();
    let inlined = inline(&scene.world, &written, &scene.stored)?;
    Ok(Composed::new(&scene.world, inlined, ""))
}

/// Compares the number of steps and endings of a composition, or its errors.
#[track_caller]
fn check(scene: &Scene, composition: &str, expected: &str) {
    let outcome = match composed(scene, composition) {
        Err(misfits) => misfits.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"),
        Ok(composed) => {
            let answer: Answer = composed.verdict();
            match composed.verified() {
                Some(plan) => format!("{} steps, {} endings", plan.steps().len(), plan.endings().len()),
                None => {
                    let wrong = answer.violations.iter().map(|violation| violation.message.as_str());
                    wrong.collect::<Vec<_>>().join("\n")
                }
            }
        }
    };
    assert_eq!(outcome, expected, "{composition}");
}

const ON_BENCH: &str = "on_something(<bench>)";

#[test]
fn plans_in_turn_and_in_branches_are_one_plan() {
    let scene = cream(ON_BENCH);
    check(&scene, "take_cream()\nshelve_cream()", "6 steps, 1 endings");
    let branching = "take_cream()\ncheck_best_by_date(\"cream\")\nif expired(\"cream\"):\n    drop_cream()\n\
                     else:\n    shelve_cream()\n";
    check(&scene, branching, "9 steps, 2 endings");
    // The paper's notation, with the object given by identifier or omitted.
    for call in ["check_best_by_date(\"<cream>\")", "check_best_by_date()"] {
        let composition = format!("take_cream()\nif {call}:\n    shelve_cream()\nelse:\n    drop_cream()\n");
        check(&scene, &composition, "9 steps, 2 endings");
    }
}

#[test]
fn composition_violations_name_the_stored_plan() {
    let scene = cream(ON_BENCH);
    check(
        &scene,
        "shelve_cream()",
        "step 1: move_object() needs that the hand holds the cream, and that the cream is lifted (step 1 is of \
         `shelve_cream`)\nstep 2: attach_to_plane() needs that the hand holds the cream, and that the cream is lifted \
         (step 2 is of `shelve_cream`)\nstep 3: release_object() needs that the hand holds the cream (step 3 is of \
         `shelve_cream`)",
    );
    let composed = composed(&scene, "take_cream()\ndrop_cream()\nshelve_cream()\n").unwrap();
    let answer = composed.verdict();
    let first = &answer.violations[0].message;
    assert!(
        first.starts_with("step 6: move_object() needs")
            && first.ends_with("(step 6 is of `shelve_cream`, step 5 is of `drop_cream`)"),
        "{first}"
    );
}

#[test]
fn composition_reports_entities_missing_from_the_world() {
    let mut scene = cream(ON_BENCH);
    scene.world = testing::world_of(
        &scene.domain,
        json!({"assets": ["<bench>"], "objects": ["<cream>"], "object_states": {"<cream>": ON_BENCH}}),
    );
    let answer = composed(&scene, "take_cream()\nshelve_cream()").unwrap().verdict();
    let first = &answer.violations[0];
    assert_eq!(first.kind, "unknown_entity");
    assert!(
        first.message.contains("`<ledge>`") && first.message.ends_with("is of `shelve_cream`)"),
        "{}",
        first.message
    );
}

#[test]
fn composition_rejects_invalid_uses_of_stored_plans() {
    let scene = cream(ON_BENCH);
    check(
        &scene,
        "take_creme()",
        "there is no stored plan `take_creme`; did you mean `take_cream`?",
    );
    check(
        &scene,
        "take_cream(\"cream\")",
        "`take_cream` is a stored plan, which takes nothing in its parentheses: what it handles was settled when it was made",
    );
    check(
        &scene,
        "if take_cream():\n    drop_cream()",
        "`take_cream` is a stored plan, so it cannot be a condition: a condition is a sensing action or a state",
    );
    check(
        &scene,
        "with parallel():\n    with lane(\"left\"):\n        take_cream()\n",
        "nothing can be done side by side in the domain `household-checks`: no action says who does it",
    );
    // Each error is reported once.
    check(
        &scene,
        "fly()\nfly()\nswim()",
        "there is no stored plan `fly`\nthere is no stored plan `swim`",
    );
}

#[test]
fn composition_rejects_a_plan_in_the_lane_of_another_hand() {
    let scene = shed(&["<saw>", "<vice>"]);
    let lanes = |left: &str, right: &str| {
        format!(
            "with parallel():\n    with lane(\"left\"):\n        {left}()\n    with lane(\"right\"):\n        {right}()\n"
        )
    };
    check(&scene, &lanes("saw_away", "vice_away"), "12 steps, 1 endings");
    let named = lanes("saw_away", "vice_away")
        .replace("left", "one")
        .replace("right", "other");
    check(&scene, &named, "12 steps, 1 endings");
    check(
        &scene,
        &lanes("vice_away", "saw_away"),
        "`vice_away` is done by right, and stands in the lane of left\n`saw_away` is done by left, and stands in the lane of right",
    );
    check(
        &scene,
        &lanes("both_hands_over", "vice_away"),
        "`both_hands_over` needs left and right, and a lane has only one",
    );
    check(&scene, "saw_away()\nvice_away()", "12 steps, 1 endings");
}

fn grammar_of(scene: &Scene, instruction: &str) -> String {
    let request = scene.request(instruction, ConstraintKind::Grammar);
    let Constraint::Lark(grammar) = request.constraint else {
        panic!("a grammar")
    };
    grammar
}

#[test]
fn composition_grammar_lists_plans_and_conditions() {
    let scene = cream(ON_BENCH);
    for words in [
        "Put the cream on the ledge",
        "Nimm sie, und wirf sie weg, falls sie verdorben ist",
    ] {
        let grammar = grammar_of(&scene, words);
        assert!(grammar.contains("\"take_cream()\""), "{grammar}");
        assert!(grammar.contains(r#""check_best_by_date(\"cream\")\n""#), "{grammar}");
        assert!(grammar.contains(r#""if expired(\"cream\"):\n""#), "{grammar}");
        assert!(!grammar.contains("lane"), "there is one hand: {grammar}");
    }
    let scene = shed(&["<saw>", "<vice>"]);
    let sides = grammar_of(&scene, "Put the saw and the vice away, both at the same time");
    assert!(sides.contains(r#""\n    with lane(\"left hand\"):\n""#), "{sides}");
    assert!(
        !sides.contains("        both_hands_over"),
        "it fits into no lane: {sides}"
    );
}

#[test]
fn composition_schema_lists_the_stored_plans() {
    let scene = shed(&["<saw>", "<vice>"]);
    let wish = "Put the saw and the vice away at once";
    let request = scene.request(wish, ConstraintKind::JsonSchema);
    let Constraint::JsonSchema(schema) = request.constraint else {
        panic!("a schema")
    };
    assert_eq!(schema["$defs"]["call"]["enum"][0], "saw_away()");
    assert_eq!(
        schema["$defs"]["node0"]["anyOf"].as_array().unwrap().len(),
        2,
        "{schema}"
    );
}

#[test]
fn every_example_can_be_read_in_both_forms() {
    for example in examples::EXAMPLES {
        let answer = read(example.answer).unwrap();
        assert_eq!(
            read(&super::read::in_json(example.answer)).unwrap(),
            answer,
            "{}",
            example.wish
        );
        if let CompositionAnswer::Composition(written) = answer {
            let known = |name: &str| example.plans.iter().any(|(plan, ..)| *plan == name);
            let looks = |name: &str| example.checks.iter().any(|(call, _)| call.starts_with(name));
            for step in &written.steps {
                assert!(known(&step.call.name) || looks(&step.call.name), "{}", step.call);
            }
        }
    }
}

#[test]
fn composition_reader_never_panics() {
    for text in [
        "",
        "{",
        "question:",
        "take(",
        "```\n```",
        "if :",
        "\u{0}",
        "with parallel():",
    ] {
        let _ = read(text);
    }
    assert_eq!(
        read("question: Which?").unwrap(),
        CompositionAnswer::Question("Which?".to_owned())
    );
    let json = r#"{"task_tree": [], "question": "Which?"}"#;
    assert_eq!(read(json).unwrap(), CompositionAnswer::Question("Which?".to_owned()));
}
