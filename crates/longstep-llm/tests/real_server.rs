//! A real server: `scripts/real-server.sh` starts one and runs this with LONGSTEP_TEST_SERVER, a reference such as
//! `http://127.0.0.1:8080/v1#small`.

// Clippy's leave for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::time::{Duration, Instant};

use longstep::dialogue::{ChatRequest, Constraint, Finish, Message, Reply, Role, Task};
use longstep_llm::{ChatModel, ModelError, OpenOptions, Progress, Sampling, Watch, open};
use serde_json::{Value, json};

fn open_with(options: &OpenOptions) -> Box<dyn ChatModel> {
    let reference = std::env::var("LONGSTEP_TEST_SERVER").expect("LONGSTEP_TEST_SERVER must be a reference");
    open(&reference.parse().unwrap(), options, &mut |_| {}).unwrap()
}

fn model() -> Box<dyn ChatModel> {
    open_with(&OpenOptions::new("unused".into()))
}

fn request(instruction: &str) -> ChatRequest {
    let user = |text: &str| Message::new(Role::User, text);
    ChatRequest {
        task: Task::Other,
        messages: vec![
            Message::new(
                Role::System,
                "You write what a person wants a robot to do, as a JSON object: goals is a list of facts that shall \
                 hold, and question is empty, or asks the person when it is not clear what is wanted.",
            ),
            user("Put the cup on the shelf."),
            Message::new(Role::Assistant, r#"{"question": "", "goals": ["put(cup, shelf)"]}"#),
            user(instruction),
        ],
        fixed: 3,
        answer_so_far: String::new(),
        constraint: Constraint::JsonSchema(json!({
            "type": "object",
            "properties": {
                "question": {"type": "string"},
                "goals": {"type": "array", "items": {"type": "string", "enum": ["open(door)", "closed(door)"]}},
            },
            "required": ["question", "goals"],
            "additionalProperties": false,
        })),
        max_tokens: 80,
    }
}

/// Notes what it is told, and stops after so many pieces of an answer.
#[derive(Default)]
struct Notes {
    told: Vec<Progress>,
    patience: Option<usize>,
    stopped: std::cell::Cell<Option<Instant>>,
}

impl Notes {
    fn pieces(&self) -> usize {
        let writing = |step: &&Progress| matches!(step, Progress::Writing { .. });
        self.told.iter().filter(writing).count()
    }
}

impl Watch for Notes {
    fn tell(&mut self, progress: Progress) {
        self.told.push(progress);
    }

    fn stop(&self) -> bool {
        let stop = self.patience.is_some_and(|patience| self.pieces() >= patience);
        if stop && self.stopped.get().is_none() {
            self.stopped.set(Some(Instant::now()));
        }
        stop
    }
}

fn ask(model: &mut dyn ChatModel, request: &ChatRequest) -> (Reply, Notes) {
    let mut notes = Notes::default();
    let reply = model.chat(request, &mut notes).unwrap();
    (reply, notes)
}

#[test]
#[ignore = "needs LONGSTEP_TEST_SERVER"]
fn a_schema_is_obeyed_or_it_is_told() {
    let (reply, notes) = ask(model().as_mut(), &request("Close the door."));
    println!("{reply:?}");
    let warned = |words: &str| {
        let warns = |step: &Progress| matches!(step, Progress::Warning(text) if text.contains(words));
        notes.told.iter().any(warns)
    };
    let answer: Option<Value> = serde_json::from_str(&reply.text).ok();
    let goals = answer.as_ref().and_then(|answer| answer["goals"].as_array());
    let known = |goal: &Value| goal == "open(door)" || goal == "closed(door)";
    let obeyed = goals.is_some_and(|goals| goals.iter().all(known)) && reply.finish == Finish::Stop;
    assert!(obeyed || warned("schema"), "{reply:?}");
    assert_eq!(notes.told[0], Progress::Waiting);
    assert!(notes.pieces() > 3, "{:?}", notes.told);
}

#[test]
#[ignore = "needs LONGSTEP_TEST_SERVER"]
fn an_answer_that_is_cut_off_says_so() {
    let mut short = request("Open the door.");
    short.max_tokens = 3;
    let (reply, _) = ask(model().as_mut(), &short);
    assert_eq!(reply.finish, Finish::Length, "{reply:?}");
}

#[test]
#[ignore = "needs LONGSTEP_TEST_SERVER"]
fn a_call_can_be_stopped_and_the_model_asked_again() {
    let mut model = model();
    let mut long = request("Count from one to a hundred, in words.");
    long.constraint = Constraint::Free;
    long.max_tokens = 400;
    for patience in [0, 2] {
        let mut notes = Notes {
            patience: Some(patience),
            ..Notes::default()
        };
        let error = model.chat(&long, &mut notes).unwrap_err();
        let late = notes.stopped.get().unwrap().elapsed();
        assert!(matches!(error, ModelError::Stopped), "{error}");
        assert!(late < Duration::from_millis(100), "{late:?}");
    }
    let (reply, _) = ask(model.as_mut(), &request("Open the door."));
    assert!(!reply.text.is_empty());
}

#[test]
#[ignore = "needs LONGSTEP_TEST_SERVER"]
fn tokens_are_counted() {
    let mut model = model();
    let asked = request("Close the door.");
    let counted = model.tokens(&asked.messages);
    let (reply, _) = ask(model.as_mut(), &asked);
    println!("counted {counted} by {:?}, {:?}", model.counting(), reply.usage);
    assert_eq!(reply.usage.calls, 1);
    let told = reply.usage.prompt_tokens;
    // Some servers tell nothing of what a streamed answer cost.
    if told > 0 {
        assert!(
            counted.abs_diff(told) <= 2 + told / 10,
            "counted {counted}, told {told}"
        );
    }
    let text = Message::new(Role::User, "Open the door, and close the door.");
    assert!((10..20).contains(&model.message_tokens(&text)));
}

#[test]
#[ignore = "needs LONGSTEP_TEST_SERVER"]
fn the_same_seed_gives_the_same_answer() {
    let options = OpenOptions::new("unused".into()).with_sampling(
        Sampling::default()
            .with_temperature(1.0)
            .with_top_p(Some(0.95))
            .with_seed(Some(11)),
    );
    let mut asked = request("Name five fruits.");
    asked.constraint = Constraint::Free;
    asked.max_tokens = 24;
    let answer = || ask(open_with(&options).as_mut(), &asked).0.text;
    assert_eq!(answer(), answer());
}
