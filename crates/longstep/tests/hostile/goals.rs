//! Goals: read, solved, offered to a model; instructions, and the prompts for them.

use longstep::Clock;
use longstep::dialogue::{ConstraintKind, Dialogue, EstimatedTokens, direct_request};
use longstep::domain::Domain;
use longstep::goal;
use longstep::instruction::{self, Mentions};
use longstep::report::{self, Status};
use longstep::understanding::{Understanding, UnderstandingInput};
use longstep_core::environment::World;
use serde_json::Value;

use super::{LARGEST, Row, Work, fill, many, nest, shipped, world_of};

const SOLVING: u64 = 120_000_000;

fn solve(domain: &str, environment: &Value, text: String) -> Work {
    assert!(text.len() <= LARGEST, "a goal of {} bytes", text.len());
    let domain = shipped(domain);
    let world = world_of(&domain, environment);
    Box::new(move || match goal::parse(&world, &text) {
        Ok(goal) => {
            report::of_goal(&world, &goal, &text, &longstep::Limits::default(), &Clock::none())
                .answer
                .status
                == Status::Verified
        }
        Err(_) => false,
    })
}

/// Solves a goal under the rules of a file, one a line.
fn under_rules(environment: &Value, goal: &str, rules: String) -> Work {
    assert!(rules.len() <= LARGEST, "rules of {} bytes", rules.len());
    let (domain, goal) = (shipped("household"), goal.to_owned());
    let world = world_of(&domain, environment);
    Box::new(move || {
        let rules = rules
            .lines()
            .filter_map(|line| goal::rules(&world, line).ok())
            .flatten();
        let world = world.with_prohibitions(rules);
        let Ok(wanted) = goal::parse(&world, &goal) else {
            return false;
        };
        let found = report::of_goal(&world, &wanted, &goal, &longstep::Limits::default(), &Clock::none());
        found.answer.status == Status::Verified
    })
}

fn instruct(domain: &str, environment: &Value, text: String) -> Work {
    let domain = shipped(domain);
    let world = world_of(&domain, environment);
    Box::new(move || {
        let spoken = Mentions::of(&world, &text);
        instruction::spelled_out(&world, &text, &spoken.entities);
        requests(&domain, &world, &text);
        false
    })
}

fn requests(domain: &Domain, world: &World, text: &str) {
    let mut counter = EstimatedTokens::default();
    for kind in [ConstraintKind::Grammar, ConstraintKind::JsonSchema] {
        let input = UnderstandingInput::new(domain, world, text, kind);
        if let Ok(fitted) = Understanding::fitted(input, Some(8_000), &mut counter) {
            fitted.dialogue.request();
        }
    }
    let _ = direct_request(domain, world, text, &[], &[], Some(8_000), &mut counter);
}

/// Goals for so many objects, each in another form.
fn joined(count: usize, goal: fn(usize) -> String) -> String {
    (0..count).map(goal).collect::<Vec<_>>().join(" & ")
}

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row {
            name: "solve/rules-repeated",
            // With a search for each of them to say which prevents the plan, it was 90 million.
            ceiling: 10_000_000,
            make: || {
                let rules = (0..600).map(|n| format!("never put(<o{}>, any thing)\n", n % 4));
                under_rules(&many(4, 4), "put(<o0>, <p1>)", rules.collect())
            },
        },
        Row {
            name: "solve/rules-many",
            ceiling: SOLVING,
            make: || {
                let rules = (0..500).map(|n| format!("never put(<o{}>, <p{}>)\n", n % 20, n / 20 + 2));
                under_rules(&many(30, 20), "put(<o0>, <p1>) & put(<o1>, <p1>)", rules.collect())
            },
        },
        Row {
            name: "solve/rules-counts",
            ceiling: SOLVING,
            make: || {
                let rules = (0..200).map(|n| format!("never put(exactly {} of thing, any thing)\n", n % 7 + 1));
                under_rules(&many(5, 10), "put(<o0>, <p1>) & put(<o1>, <p2>)", rules.collect())
            },
        },
        Row {
            name: "solve/conditional",
            ceiling: SOLVING,
            make: || {
                solve(
                    "household-checks",
                    &many(3, 37),
                    joined(4, |n| {
                        format!("if expired(<o{n}>) then put(<o{n}>, <p1>) else put(<o{n}>, <p2>)")
                    }),
                )
            },
        },
        Row {
            name: "solve/conditional-many",
            ceiling: SOLVING,
            make: || {
                solve(
                    "household-checks",
                    &many(3, 37),
                    joined(37, |n| {
                        format!("if expired(<o{n}>) then put(<o{n}>, <p1>) else put(<o{n}>, <p2>)")
                    }),
                )
            },
        },
        Row {
            name: "solve/conditional-sides",
            ceiling: SOLVING,
            make: || {
                solve(
                    "household-checks",
                    &many(3, 300),
                    format!(
                        "if expired(<o0>) then {} else put(<o0>, <p2>)",
                        (0..300)
                            .map(|n| format!("put(<o{n}>, <p1>)"))
                            .collect::<Vec<_>>()
                            .join(" and ")
                    ),
                )
            },
        },
        Row {
            name: "solve/many",
            ceiling: SOLVING,
            make: || {
                solve(
                    "household",
                    &many(3, 400),
                    joined(400, |n| format!("put(<o{n}>, <p1>)")),
                )
            },
        },
        Row {
            name: "solve/several",
            ceiling: SOLVING,
            make: || {
                solve(
                    "household",
                    &many(10, 20),
                    joined(20, |n| format!("put(<o{n}>, <p{}>)", n % 9 + 1)),
                )
            },
        },
        Row {
            name: "solve/one-of-many",
            ceiling: SOLVING,
            make: || solve("household", &many(200, 300), "put(<o7>, <p9>)".to_owned()),
        },
        Row {
            name: "solve/impossible",
            ceiling: SOLVING,
            make: || {
                solve(
                    "household",
                    &many(20, 40),
                    "put(<o0>, <p1>) & put(<o0>, <p2>)".to_owned(),
                )
            },
        },
        Row {
            name: "solve/dual",
            ceiling: SOLVING,
            make: || {
                solve(
                    "household-dual",
                    &many(20, 60),
                    joined(6, |n| format!("put(<o{n}>, <p{}>)", n + 1)),
                )
            },
        },
        Row {
            name: "goal/parentheses",
            ceiling: SOLVING,
            make: || solve("household", &many(2, 2), nest("put(", "o1, p1", ")")),
        },
        Row {
            name: "goal/empty",
            ceiling: SOLVING,
            make: || solve("household", &many(2, 2), fill("&")),
        },
        Row {
            name: "goal/ifs",
            ceiling: SOLVING,
            make: || solve("household-checks", &many(2, 2), fill("if expired(<o0>) then ")),
        },
        Row {
            name: "goal/unknown",
            ceiling: SOLVING,
            make: || solve("household", &many(2, 400), fill("put(oo, pp) & ")),
        },
        Row {
            name: "goal/long-name",
            ceiling: SOLVING,
            make: || solve("household", &many(2, 400), format!("put({}, p1)", "o".repeat(19_000))),
        },
        Row {
            name: "instruction/boxes",
            ceiling: SOLVING,
            make: || instruct("household", &many(3, 300), "o 5 ".repeat(2_000)),
        },
        Row {
            name: "instruction/all",
            ceiling: SOLVING,
            make: || {
                instruct(
                    "household",
                    &many(100, 300),
                    (0..300).map(|n| format!("put the o {n} on the p {n} and ")).collect(),
                )
            },
        },
        Row {
            name: "instruction/places",
            ceiling: SOLVING,
            make: || {
                instruct(
                    "virtualhome",
                    &serde_json::json!({"assets": super::numbered("p", 0..700), "asset_states": {}, "objects": super::numbered("o", 0..700), "object_states": {}}),
                    fill("put the o 5 on the p 7 "),
                )
            },
        },
        Row {
            name: "instruction/the",
            ceiling: SOLVING,
            make: || instruct("household", &many(3, 300), fill("the ")),
        },
        Row {
            name: "instruction/word",
            ceiling: SOLVING,
            make: || instruct("household", &many(3, 300), "x".repeat(LARGEST)),
        },
        Row {
            name: "instruction/ifs",
            ceiling: SOLVING,
            make: || {
                instruct(
                    "household-checks",
                    &many(3, 300),
                    fill("if the o 5 is expired put it on the p 1, otherwise "),
                )
            },
        },
        Row {
            name: "instruction/not",
            ceiling: SOLVING,
            make: || instruct("household", &many(3, 300), fill("not the o 5 but ")),
        },
    ]
}
