//! Replies of every form: what was written is what is read, and what is not whole is never read.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::path::PathBuf;

use longstep_core::environment::{Environment, Words};
use longstep_core::plan::{Draft, LeniencyKind, PlanFile, TaskCohesion, Unreadable, read};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use serde_json::Value;

fn text() -> impl Strategy<Value = String> {
    prop_oneof![
        "[a-z]{1,4}(_[a-z]{1,4})?\\(\\)",
        "<[a-z]{1,6}_[0-9]{1,3}>",
        "[a-z]{1,6}'[a-z]{1,2} [a-z]{0,4}",
        "[a-z '\"`{}\\[\\]()#/*,:\\\\\n\t“’…é🤖]{0,16}",
        "(?s).{0,8}",
    ]
}

fn words() -> impl Strategy<Value = Words> {
    prop_oneof![text().prop_map(Words::One), vec(text(), 0..3).prop_map(Words::Many)]
}

fn environment() -> impl Strategy<Value = Environment> {
    let states = || vec((text(), words()), 0..3).prop_map(|states| states.into_iter().collect());
    let names = vec((text(), text()), 0..3).prop_map(|names| names.into_iter().collect());
    (
        vec(text(), 0..3),
        states(),
        vec(text(), 0..3),
        states(),
        option::of(states()),
        option::of(states()),
        option::of(names),
    )
        .prop_map(
            |(assets, asset_states, objects, object_states, asset_properties, object_properties, names)| Environment {
                assets,
                asset_states,
                objects,
                object_states,
                asset_properties,
                object_properties,
                names,
                ..Environment::default()
            },
        )
}

fn plan() -> impl Strategy<Value = PlanFile> {
    let cohesion = (
        vec(text(), 0..4),
        vec(text(), 0..4),
        option::of(text()),
        vec(text(), 0..3),
    );
    (
        cohesion,
        option::of(environment()),
        option::of(environment()),
        text(),
        text(),
    )
        .prop_map(
            |((task_sequence, step_instructions, object_name, object_names), before, after, summary, question)| {
                PlanFile {
                    task_cohesion: TaskCohesion {
                        task_sequence,
                        step_instructions,
                        object_name,
                        object_names,
                        task_tree: None,
                    },
                    environment_before: before,
                    environment_after: after,
                    endings: Vec::new(),
                    instruction_summary: summary,
                    question,
                    not_in_plan: Vec::new(),
                    purpose: None,
                    domain: None,
                }
            },
        )
}

/// Writes values in any form that is forgiven, as its choices go; they begin again when they are used up.
struct Writer {
    choices: Vec<u8>,
    next: usize,
    text: String,
}

impl Writer {
    fn new(choices: Vec<u8>) -> Self {
        Self {
            choices,
            next: 0,
            text: String::new(),
        }
    }

    fn choose(&mut self, among: usize) -> usize {
        self.next += 1;
        self.choices[self.next % self.choices.len()] as usize % among
    }

    fn one_of(&mut self, texts: &[&str]) {
        let chosen = self.choose(texts.len());
        self.text.push_str(texts[chosen]);
    }

    fn space(&mut self) {
        self.one_of(&[
            "",
            "",
            "",
            " ",
            "\n  ",
            "\r\n",
            "# it's {\n",
            "// \"]\n",
            "/* ' } */",
            "\u{a0}",
        ]);
    }

    /// The reply around the value, and where the value ends.
    fn reply(mut self, value: &Value) -> (String, usize) {
        self.one_of(&[
            "",
            "",
            "\u{feff}",
            "Sure, here's the plan for the {object}:\n",
            "{}\n{'a': 1}\n",
        ]);
        self.one_of(&["", "```json\n", "```python\n", "```\n"]);
        self.one_of(&["", "", "plan = ", "reply: dict = "]);
        self.value(value);
        let end = self.text.len();
        self.one_of(&["", "\n", "\n```", "\n```\nI hope it's what you're after :)"]);
        (self.text, end)
    }

    fn value(&mut self, value: &Value) {
        match value {
            Value::Object(entries) => {
                self.text.push('{');
                for (index, (key, value)) in entries.iter().enumerate() {
                    self.separate(index);
                    if key.chars().all(|c| c.is_ascii_lowercase()) && !key.is_empty() && self.choose(4) == 0 {
                        self.text.push_str(key);
                    } else {
                        self.quoted(key, true);
                    }
                    self.space();
                    self.text.push(':');
                    self.space();
                    self.value(value);
                }
                self.close(entries.len(), '}');
            }
            Value::Array(items) => {
                let tuple = self.choose(4) == 0;
                self.text.push(if tuple { '(' } else { '[' });
                for (index, item) in items.iter().enumerate() {
                    self.separate(index);
                    self.value(item);
                }
                if tuple && items.len() == 1 {
                    self.text.push(',');
                    self.close(0, ')');
                } else {
                    self.close(items.len(), if tuple { ')' } else { ']' });
                }
            }
            Value::String(text) => self.quoted(text, false),
            other => panic!("a plan has no {other}"),
        }
    }

    fn separate(&mut self, index: usize) {
        self.space();
        if index > 0 {
            self.text.push(',');
            self.space();
        }
    }

    fn close(&mut self, items: usize, bracket: char) {
        self.space();
        if items > 0 && self.choose(3) == 0 {
            self.text.push(',');
            self.space();
        }
        self.text.push(bracket);
    }

    fn quoted(&mut self, text: &str, key: bool) {
        // A fence ends a text that has line breaks in it, and a key has none.
        let one_line = key || text.contains('`');
        match self.choose(7) {
            0 | 1 => self.single_quoted(text, self.choices[0].is_multiple_of(2)),
            2 if !one_line => self.escaped("\"\"\"", text, "\"\"\"", &['"', '\\']),
            3 if !one_line => self.escaped("'''", text, "'''", &['\'', '\\']),
            4 if !one_line => self.escaped("“", text, "”", &['“', '”', '\\']),
            5 if !one_line => self.escaped("\"", text, "\"", &['"', '\\']),
            6 if !key && !text.is_empty() => {
                // Not in front: an empty text and the quote after it would be three quotes.
                let middle = text.chars().count().div_ceil(2);
                let (first, second) = text.split_at(text.char_indices().nth(middle).map_or(text.len(), |(at, _)| at));
                self.text.push_str(&Value::from(first).to_string());
                self.space();
                self.text.push_str(&Value::from(second).to_string());
            }
            _ => self.text.push_str(&Value::from(text).to_string()),
        }
    }

    fn escaped(&mut self, open: &str, text: &str, close: &str, escaped: &[char]) {
        self.text.push_str(open);
        for character in text.chars() {
            if escaped.contains(&character) {
                self.text.push('\\');
            }
            self.text.push(character);
        }
        self.text.push_str(close);
    }

    /// As Python writes it, or with bare apostrophes where a letter follows.
    fn single_quoted(&mut self, text: &str, bare: bool) {
        self.text.push('\'');
        let mut rest = text.chars();
        while let Some(character) = rest.next() {
            let letter_follows = rest.clone().next().is_some_and(char::is_alphanumeric);
            match character {
                '\'' if bare && letter_follows => self.text.push('\''),
                '\'' | '\\' => self.text.extend(['\\', character]),
                '\n' => self.text.push_str("\\n"),
                _ if character < ' ' => self.text.push_str(&format!("\\x{:02x}", character as u32)),
                _ => self.text.push(character),
            }
        }
        self.text.push('\'');
    }
}

fn damaged(plan: &PlanFile, choices: Vec<u8>) -> (String, usize) {
    Writer::new(choices).reply(&serde_json::to_value(plan).unwrap())
}

/// Whatever is read can be written and read again, and then nothing has to be forgiven.
fn check_any(reply: &str) {
    if let Ok(Draft { file, .. }) = read(reply) {
        let again = read(&serde_json::to_string(&file).unwrap()).unwrap();
        assert_eq!((again.file, again.leniencies), (file, Vec::new()), "{reply}");
    }
}

/// No beginning of the reply that lacks some of the plan is read.
fn check_beginnings(reply: &str, end: usize) {
    for (cut, _) in reply.char_indices().take_while(|(cut, _)| *cut < end) {
        assert!(read(&reply[..cut]).is_err(), "{}", &reply[..cut]);
    }
}

proptest! {
    #[test]
    fn any_text_is_read_or_refused(reply in any::<String>()) {
        check_any(&reply);
        check_any(&format!("{{'task_sequence': {reply}"));
    }

    #[test]
    fn any_tokens_are_read_or_refused(tokens in vec(prop_oneof![
        Just("{"), Just("}"), Just("["), Just("]"), Just("("), Just(")"), Just(","), Just(":"), Just("'"), Just("\""),
        Just("\"\"\""), Just("```"), Just("\n"), Just(" "), Just("\\"), Just("#"), Just("//"), Just("/*"), Just("*/"),
        Just("{'task_cohesion': "), Just("'task_sequence': ["), Just("\"a()\""), Just("None"), Just("=”"), Just("u00"),
        Just("{'task_sequence': []}"), Just("{\"question\": \"why?\"}"),
    ], 0..40)) {
        check_any(&tokens.concat());
    }

    #[test]
    fn a_plan_as_json_needs_no_leniency(plan in plan()) {
        for text in [serde_json::to_string(&plan).unwrap(), serde_json::to_string_pretty(&plan).unwrap()] {
            let draft = read(&text).unwrap();
            prop_assert_eq!(&draft.file, &plan);
            prop_assert_eq!(draft.leniencies, Vec::new());
        }
    }

    #[test]
    fn a_plan_in_any_form_is_the_same_plan(plan in plan(), choices in vec(any::<u8>(), 1..60)) {
        let (reply, _) = damaged(&plan, choices);
        match read(&reply) {
            Ok(draft) => prop_assert_eq!(draft.file, plan, "{}", reply),
            Err(unreadable) => prop_assert!(false, "{}\n{}", unreadable, reply),
        }
    }

    #[test]
    fn a_changed_plan_is_read_or_refused(
        plan in plan(), choices in vec(any::<u8>(), 1..60), places in vec(any::<prop::sample::Index>(), 1..4),
        put in "[\\[{}'\"\\\\,: \n]?",
    ) {
        let mut reply: Vec<char> = damaged(&plan, choices).0.chars().collect();
        for place in places {
            let place = place.index(reply.len());
            reply.splice(place..=place, put.chars());
            if reply.is_empty() {
                break;
            }
        }
        check_any(&reply.into_iter().collect::<String>());
    }

    #[test]
    fn reader_rejects_arbitrarily_deep_brackets(open in "[\\[{(]|\\{'a':|\\[\\(|\\{a:\\[", times in 1_usize..5_000) {
        let reply = format!("{{'task_cohesion': {}", open.repeat(times));
        let refused = matches!(
            read(&reply),
            Err(Unreadable::TooDeep { .. } | Unreadable::CutOff { .. } | Unreadable::Malformed { .. })
        );
        prop_assert!(refused);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn truncated_reply_is_never_read_as_a_plan(plan in plan(), choices in vec(any::<u8>(), 1..60)) {
        let strict = serde_json::to_string(&plan).unwrap();
        check_beginnings(&strict, strict.len());
        let (reply, end) = damaged(&plan, choices);
        check_beginnings(&reply, end);
    }
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn recorded_replies_are_read_as_json_and_as_python() {
    let folder = std::env::var_os("LONGSTEP_CORPUS").expect("LONGSTEP_CORPUS names the folder of the recorded plans");
    for (file, count) in [("recorded_trials.json", 70), ("recorded_feedback.json", 26)] {
        let path = PathBuf::from(&folder).join("virtualhome14").join(file);
        let recorded: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let recorded = recorded.as_array().unwrap();
        assert_eq!(recorded.len(), count);
        for entry in recorded {
            let mut reply = entry["reply"].clone();
            let plan: PlanFile = serde_json::from_value(reply.clone()).unwrap();
            let draft = read(&reply.to_string()).unwrap();
            assert_eq!(draft.file, plan);
            let ignored: Vec<String> = draft
                .leniencies
                .iter()
                .flat_map(|l| &l.path)
                .map(ToString::to_string)
                .collect();
            assert_eq!(ignored, ["was_execution_successful", "user_feedback"]);

            // What the simulator said about the reply is not the model's.
            let fields = reply.as_object_mut().unwrap();
            fields.retain(|key, _| !ignored.contains(key));
            let text = reply.to_string();
            assert_eq!(read(&text).unwrap().leniencies, Vec::new());
            check_beginnings(&text, text.len());
            // As Python writes it, and in a code block with a name before it and apostrophes left bare.
            for choices in [vec![1], vec![22]] {
                let (python, end) = Writer::new(choices).reply(&reply);
                let draft = read(&python).unwrap();
                assert_eq!(draft.file, plan);
                let mut kinds = draft.leniencies.iter().map(|leniency| leniency.kind);
                assert!(kinds.any(|kind| kind == LeniencyKind::SingleQuotes));
                check_beginnings(&python, end);
            }
        }
    }
}
