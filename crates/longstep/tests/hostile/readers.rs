//! Readers of what models and strangers write: replies, scripts, trees, environments, logs, compositions.

use longstep::{compose, session};
use longstep_core::plan::{self, script};
use serde_json::{Value, json};

use super::{LARGEST, Row, Work, fill, many, nest, numbered, read_environment};

const READING: u64 = 12_000_000;

fn reply(text: String) -> Work {
    assert!(text.len() <= LARGEST);
    Box::new(move || {
        let _ = plan::read(&text);
        false
    })
}

fn python(text: String) -> Work {
    assert!(text.len() <= LARGEST);
    Box::new(move || {
        let _ = script::read(&text);
        let _ = compose::read(&text);
        let _ = plan::read(&text);
        false
    })
}

fn indented(line: &str) -> String {
    let mut text = String::new();
    for depth in 0.. {
        let next = format!("{}{line}\n", " ".repeat(depth));
        if text.len() + next.len() > LARGEST {
            return text;
        }
        text.push_str(&next);
    }
    text
}

fn log(text: String) -> Work {
    Box::new(move || {
        let _ = session::Log::read(text.as_bytes());
        false
    })
}

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row {
            name: "reply/brackets",
            ceiling: READING,
            make: || reply(nest("[", "", "]")),
        },
        Row {
            name: "reply/open",
            ceiling: READING,
            make: || reply(fill("{\"a\":[")),
        },
        Row {
            name: "reply/braces",
            ceiling: READING,
            make: || reply(fill("{")),
        },
        Row {
            name: "reply/pairs",
            ceiling: READING,
            make: || reply(fill("{}[]")),
        },
        Row {
            name: "reply/fences",
            ceiling: READING,
            make: || reply(fill("```json\n{\n```\n")),
        },
        Row {
            name: "reply/quotes",
            ceiling: READING,
            make: || reply(fill("{\"")),
        },
        Row {
            name: "reply/escapes",
            ceiling: READING,
            make: || reply(format!("{{\"a\": \"{}", fill("\\\"")[..19_000].to_owned())),
        },
        Row {
            name: "reply/objects",
            ceiling: READING,
            make: || reply(fill("{\"task_cohesion\": {}}")),
        },
        Row {
            name: "reply/python",
            ceiling: READING,
            make: || reply(nest("{'a': (", "1", ")}")),
        },
        Row {
            name: "reply/commas",
            ceiling: READING,
            make: || reply(format!("[{}]", fill("1,,")[..19_000].to_owned())),
        },
        Row {
            name: "reply/keys",
            ceiling: READING,
            make: || {
                reply(format!(
                    "{{\"task_cohesion\": {{{}}}}}",
                    (0..1_500).map(|n| format!("\"k{n}\":1,")).collect::<String>()
                ))
            },
        },
        Row {
            name: "reply/tree",
            ceiling: READING,
            make: || {
                reply(format!(
                    "{{\"task_cohesion\": {{\"task_tree\": [{}]}}}}",
                    nest("{\"repeat\":1,\"do\":[", "", "]}")[..]
                        .chars()
                        .take(0)
                        .collect::<String>()
                        + &"{\"repeat\":1,\"do\":[".repeat(500)
                        + &"]}".repeat(500)
                ))
            },
        },
        Row {
            name: "reply/condition",
            ceiling: READING,
            make: || {
                reply(format!(
                    "{{\"task_cohesion\": {{\"task_tree\": [{{\"if\": {}{{\"call\":\"open(<a>)\"}}{}, \"then\": []}}]}}}}",
                    "{\"not\":".repeat(2_000),
                    "}".repeat(2_000)
                ))
            },
        },
        Row {
            name: "reply/words",
            ceiling: READING,
            make: || reply(fill("grasp ")),
        },
        Row {
            name: "reply/unicode",
            ceiling: READING,
            make: || reply(fill("\u{202e}{[\"")),
        },
        Row {
            name: "script/parentheses",
            ceiling: READING,
            make: || {
                python(
                    format!("if {}:\n    a()\n", nest("(", "open(\"<a>\")", ")")[..].to_owned())
                        .chars()
                        .take(LARGEST)
                        .collect(),
                )
            },
        },
        Row {
            name: "script/not",
            ceiling: READING,
            make: || python(format!("if {}open(\"<a>\"):\n    a()\n", "not ".repeat(4_500))),
        },
        Row {
            name: "script/and",
            ceiling: READING,
            make: || {
                python(format!(
                    "if {}open(\"<a>\"):\n    a()\n",
                    "open(\"<a>\") and ".repeat(1_200)
                ))
            },
        },
        Row {
            name: "script/brackets",
            ceiling: READING,
            make: || python(nest("a(", "", ")")),
        },
        Row {
            name: "script/indents",
            ceiling: READING,
            make: || python(indented("while open(\"<a>\"):")),
        },
        Row {
            name: "script/elif",
            ceiling: READING,
            make: || python(format!("if a():\n b()\n{}", "elif a():\n b()\n".repeat(1_200))),
        },
        Row {
            name: "script/calls",
            ceiling: READING,
            make: || python(fill("move_hand()\n")),
        },
        Row {
            name: "script/arguments",
            ceiling: READING,
            make: || {
                python(format!(
                    "a({})\n",
                    fill("\"<b>\",")[..19_980].trim_end_matches(|c| c != ',')
                ))
            },
        },
        Row {
            name: "script/strings",
            ceiling: READING,
            make: || python(fill("\"")),
        },
        Row {
            name: "script/comments",
            ceiling: READING,
            make: || python(fill("# <a>: b()\n")),
        },
        Row {
            name: "script/claims",
            ceiling: READING,
            make: || {
                python(format!(
                    "move_hand()  # a; {}\n",
                    fill("<a>: b(), ")[..19_000].to_owned()
                ))
            },
        },
        Row {
            name: "script/lanes",
            ceiling: READING,
            make: || {
                python(format!(
                    "with parallel():\n{}",
                    " with lane(\"a\"):\n  b()\n  sync(\"c\")\n".repeat(500)
                ))
            },
        },
        Row {
            name: "script/objects",
            ceiling: READING,
            make: || {
                python(format!(
                    "# objects: [{}]\nmove_hand()\n",
                    fill("\"<a>\", ")[..19_000].to_owned()
                ))
            },
        },
        Row {
            name: "log/lines",
            ceiling: READING,
            make: || log(fill("{\"at\":\"\",\"event\":\"instruction\"}\n")),
        },
        Row {
            name: "log/brackets",
            ceiling: READING,
            make: || log(nest("[", "", "]") + "\n"),
        },
        Row {
            name: "environment/on450",
            ceiling: READING,
            make: || {
                let on: Vec<String> = (0..450).map(|n| format!("on_something(<p{n}>)")).collect();
                read_environment(
                    "household",
                    &json!({"assets": numbered("p", 0..450), "asset_states": {}, "objects": ["<a>"], "object_states": {"<a>": on}}),
                )
            },
        },
        Row {
            name: "environment/many",
            ceiling: READING,
            make: || read_environment("household", &many(2, 500)),
        },
        Row {
            name: "environment/places",
            ceiling: READING,
            make: || {
                read_environment(
                    "virtualhome",
                    &json!({"assets": numbered("p", 0..1_800), "asset_states": {}, "objects": [], "object_states": {}}),
                )
            },
        },
        Row {
            name: "environment/unlisted",
            ceiling: READING,
            make: || {
                let states: serde_json::Map<String, Value> =
                    (0..700).map(|n| (format!("<u{n}>"), json!("open()"))).collect();
                read_environment(
                    "household",
                    &json!({"assets": numbered("p", 0..700), "asset_states": {}, "objects": [], "object_states": states}),
                )
            },
        },
        Row {
            name: "environment/unknown",
            ceiling: READING,
            make: || {
                let states: Vec<String> = (0..1_500).map(|n| format!("opn{n}()")).collect();
                read_environment(
                    "household",
                    &json!({"assets": ["<p>"], "asset_states": {"<p>": states}, "objects": [], "object_states": {}}),
                )
            },
        },
        Row {
            name: "environment/names",
            ceiling: READING,
            make: || {
                let name = "x".repeat(9_000);
                read_environment(
                    "household",
                    &json!({"assets": [format!("<{name}>")], "asset_states": {format!("<{}y>", &name[1..]): "open()"}, "objects": [], "object_states": {}}),
                )
            },
        },
        Row {
            name: "environment/bins",
            ceiling: READING,
            make: || {
                // Names that things follow from, in pairs.
                let assets: Vec<String> = (0..500).map(|n| format!("<fridge_{n}>")).collect();
                let objects: Vec<String> = (0..500).map(|n| format!("<fridge_{n}_handle>")).collect();
                read_environment(
                    "household",
                    &json!({"assets": assets, "asset_states": {}, "objects": objects, "object_states": {}}),
                )
            },
        },
    ]
}
