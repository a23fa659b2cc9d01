//! Plans, verified and repaired: as replies, as scripts, composed of stored ones.

use longstep::Clock;
use longstep::compose::{self, Composed, CompositionAnswer, Stored};
use longstep::report::{Assessment, Status};
use longstep_core::plan::{self, Draft, PlanFile, TaskCohesion, script};
use longstep_core::schedule;
use serde_json::{Value, json};

use super::{LARGEST, Row, Work, fill, many, shipped, world_of};

const VERIFYING: u64 = 80_000_000;
const REPAIRING: u64 = 250_000_000;

fn written(text: &str) -> Draft {
    assert!(text.len() <= LARGEST, "a plan of {} bytes", text.len());
    if text.starts_with('{') {
        plan::read(text).unwrap_or_else(|e| panic!("{e}"))
    } else {
        Draft {
            file: PlanFile::from(TaskCohesion::from_written(
                script::read(text).unwrap_or_else(|e| panic!("{e}")),
            )),
            leniencies: Vec::new(),
        }
    }
}

fn verify(domain: &str, environment: &Value, text: &str) -> Work {
    let domain = shipped(domain);
    let world = world_of(&domain, environment);
    let draft = written(text);
    Box::new(move || {
        let attempt = Assessment::new(&world, draft.clone(), None);
        let answer = attempt.verdict();
        if answer.status == Status::Invalid {
            attempt.feedback();
            attempt.advice();
        }
        answer.status == Status::Verified
    })
}

fn repair(domain: &str, environment: &Value, text: &str) -> Work {
    let domain = shipped(domain);
    let world = world_of(&domain, environment);
    let draft = written(text);
    Box::new(move || {
        let attempt = Assessment::new(&world, draft.clone(), None);
        attempt.repaired().status == Status::Verified
    })
}

fn composed(domain: &str, environment: &Value, text: &str, stored: &str) -> Work {
    let domain = shipped(domain);
    let world = world_of(&domain, environment);
    let CompositionAnswer::Composition(script) = compose::read(text).unwrap() else {
        panic!("{text}")
    };
    let stored = vec![Stored::new("tidy", written(stored).file)];
    Box::new(move || match compose::inline(&world, &script, &stored) {
        Ok(inlined) => Composed::new(&world, inlined, "").mended().status == Status::Verified,
        Err(misfits) => compose::refused(&world, "", &misfits).status == Status::Verified,
    })
}

fn cream() -> Value {
    json!({"assets": ["<table>", "<fridge>", "<shelf>"], "asset_states": {},
        "objects": ["<cream>", "<jam>"], "object_states": {"<cream>": "on_something(<table>)", "<jam>": "on_something(<table>)"}})
}

fn boxes(count: usize) -> Value {
    let objects: Vec<String> = (3..count).map(|n| format!("<box_{n}>")).collect();
    json!({"assets": ["<box_0>", "<box_1>", "<box_2>"], "asset_states": {}, "objects": objects, "object_states": {}})
}

fn summary(words: &str) -> String {
    json!({"task_cohesion": {"task_sequence": []}, "instruction_summary": words}).to_string()
}

fn condition(parts: usize) -> String {
    let all = vec!["(fresh(\"<cream>\") and full(\"<cream>\"))"; parts].join(" or ");
    format!("if {all}:\n    move_hand()\n")
}

fn swinging() -> String {
    "for _ in range(1000000000):\n    if inside_hand(\"<cream>\"):\n        release_object(item=\"<cream>\")\n    else:\n        \
     grasp_object(item=\"<cream>\")\n"
        .to_owned()
}

fn branches(count: usize) -> String {
    "if check_best_by_date(item=\"<cream>\"):\n    move_hand(to=\"<cream>\")\nelse:\n    move_hand(to=\"<jam>\")\n"
        .repeat(count)
}

fn hidden(count: usize) -> String {
    "if check_best_by_date():\n    move_object()\n".repeat(count)
}

fn lanes(each: usize) -> String {
    let lane = |hand: &str, thing: &str| {
        format!(
            " with lane(\"{hand}\"):\n{}",
            format!("  move_hand(hand=\"{hand}\", to=\"{thing}\")\n").repeat(each)
        )
    };
    format!(
        "with parallel():\n{}{}",
        lane("left", "<cream>"),
        lane("right", "<jam>")
    )
}

fn steps(count: usize) -> String {
    "move_hand(to=\"<cream>\")\nmove_hand(to=\"<jam>\")\n".repeat(count)
}

fn claims(count: usize) -> String {
    let objects: serde_json::Map<String, Value> = (0..count)
        .map(|n| (format!("<o{n}>"), json!("on_something(<p1>)")))
        .collect();
    json!({"task_cohesion": {"task_sequence": ["move_hand()"], "object_name": "<o0>"},
        "environment_after": {"assets": [], "asset_states": {}, "objects": [], "object_states": objects}})
    .to_string()
}

fn unknown(count: usize) -> String {
    (0..count).map(|n| format!("grasp_objekt(\"<o{n}>\")\n")).collect()
}

fn side_by_side() -> Work {
    let domain = shipped("household-dual");
    let world = world_of(&domain, &many(5, 20));
    let goal: Vec<String> = (0..4).map(|n| format!("put(<o{n}>, <p{}>)", n % 4 + 1)).collect();
    let goal = longstep::goal::parse(&world, &goal.join(" & ")).unwrap();
    Box::new(move || {
        let found = longstep::report::of_goal(&world, &goal, "", &longstep::Limits::default(), &Clock::none());
        let shared = found
            .plan
            .as_ref()
            .and_then(|plan| schedule::share(&world, plan, &goal.purpose(&world)));
        drop(shared);
        found.answer.status == Status::Verified
    })
}

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row {
            name: "verify/summary",
            ceiling: VERIFYING,
            make: || verify("household", &boxes(300), &summary(&"box 5 ".repeat(1_500))),
        },
        Row {
            name: "verify/summary-many",
            ceiling: VERIFYING,
            make: || {
                verify(
                    "household",
                    &boxes(1_200),
                    &summary(&(0..1_500).map(|n| format!("box {n} ")).collect::<String>()),
                )
            },
        },
        Row {
            name: "verify/condition",
            ceiling: VERIFYING,
            make: || verify("household-checks", &cream(), &condition(22)),
        },
        Row {
            name: "verify/condition-long",
            ceiling: VERIFYING,
            make: || verify("household-checks", &cream(), &condition(400)),
        },
        Row {
            name: "verify/swinging",
            ceiling: VERIFYING,
            make: || verify("household-checks", &cream(), &swinging()),
        },
        Row {
            name: "verify/branches",
            ceiling: VERIFYING,
            make: || verify("household-checks", &cream(), &branches(150)),
        },
        Row {
            name: "verify/hidden",
            ceiling: VERIFYING,
            make: || verify("household-checks", &many(3, 400), &hidden(300)),
        },
        Row {
            name: "verify/hidden-few",
            ceiling: VERIFYING,
            make: || verify("household-checks", &cream(), &hidden(2)),
        },
        Row {
            name: "verify/steps",
            ceiling: VERIFYING,
            make: || verify("household", &cream(), &steps(350)),
        },
        Row {
            name: "verify/calls",
            ceiling: VERIFYING,
            make: || verify("household", &many(3, 400), &fill("move_hand()\n")),
        },
        Row {
            name: "verify/places",
            ceiling: VERIFYING,
            make: || {
                verify(
                    "virtualhome",
                    &json!({"assets": [], "asset_states": {}, "objects": super::numbered("o", 0..1500), "object_states": {}}),
                    &fill("Grab(\"<o1>\")\n"),
                )
            },
        },
        Row {
            name: "verify/lanes",
            ceiling: VERIFYING,
            make: || verify("household-dual", &cream(), &lanes(200)),
        },
        Row {
            name: "verify/claims",
            ceiling: VERIFYING,
            make: || verify("household", &many(3, 400), &claims(400)),
        },
        Row {
            name: "verify/unknown",
            ceiling: VERIFYING,
            make: || verify("household", &many(3, 400), &unknown(800)),
        },
        Row {
            name: "repair/steps",
            ceiling: REPAIRING,
            make: || repair("household", &cream(), &steps(200)),
        },
        Row {
            name: "repair/calls",
            ceiling: REPAIRING,
            make: || {
                repair(
                    "household",
                    &many(10, 100),
                    &"grasp_object()\nmove_object()\n".repeat(200),
                )
            },
        },
        Row {
            name: "repair/world",
            ceiling: REPAIRING,
            make: || {
                repair(
                    "household",
                    &many(40, 300),
                    "grasp_object(item=\"<o1>\")\nmove_object(item=\"<o1>\", to=\"<p3>\")\n",
                )
            },
        },
        Row {
            name: "repair/claims",
            ceiling: REPAIRING,
            make: || repair("household", &many(3, 400), &claims(400)),
        },
        Row {
            name: "repair/unknown",
            ceiling: REPAIRING,
            make: || repair("household", &many(3, 200), &unknown(400)),
        },
        Row {
            name: "repair/hidden",
            ceiling: REPAIRING,
            make: || repair("household-checks", &many(3, 20), &hidden(30)),
        },
        Row {
            name: "repair/branches",
            ceiling: REPAIRING,
            make: || repair("household-checks", &cream(), &branches(30)),
        },
        Row {
            name: "repair/lanes",
            ceiling: REPAIRING,
            make: || repair("household-dual", &cream(), &lanes(20)),
        },
        Row {
            name: "compose/repeated",
            ceiling: REPAIRING,
            make: || composed("household", &cream(), &fill("tidy()\n"), &steps(300)),
        },
        Row {
            name: "compose/branches",
            ceiling: REPAIRING,
            make: || {
                composed(
                    "household-checks",
                    &cream(),
                    &"if check_best_by_date(item=\"<cream>\"):\n    tidy()\n".repeat(200),
                    &steps(20),
                )
            },
        },
        Row {
            name: "arms/share",
            ceiling: REPAIRING,
            make: side_by_side,
        },
    ]
}
