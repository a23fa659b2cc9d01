use longstep::dialogue::{Constraint, EstimatedTokens, Finish, Likelihood, Picture, Role, Task, Usage};
use serde_json::json;

use super::*;
use crate::{ModelReference, OpenOptions, Progress, open};

/// Answers with the number of the request.
struct Numbering(u32);

impl ChatModel for Numbering {
    fn name(&self) -> &str {
        "a model"
    }

    fn constraint_kind(&self) -> ConstraintKind {
        ConstraintKind::JsonSchema
    }

    fn chat(&mut self, request: &ChatRequest, _: &mut dyn Watch) -> Result<Reply, ModelError> {
        self.0 += 1;
        let usage = Usage {
            calls: 1,
            prompt_tokens: request.messages.len() as u64,
            cached_tokens: 2,
            completion_tokens: 3,
        };
        Ok(Reply {
            text: format!("answer {}", self.0),
            finish: Finish::Length,
            usage,
            likelihood: Some(Likelihood {
                text: -700,
                ahead: Some(1600),
                is_trained: true,
            }),
        })
    }

    fn context_tokens(&self) -> Option<u64> {
        Some(77)
    }
}

impl TokenCounter for Numbering {
    fn message_tokens(&mut self, message: &Message) -> u64 {
        1000 + message.text.len() as u64
    }

    fn frame_tokens(&mut self) -> u64 {
        9
    }

    fn counting(&self) -> Counting {
        Counting::Exact("fingers".into())
    }
}

fn request(text: &str) -> ChatRequest {
    ChatRequest {
        task: Task::Other,
        messages: vec![Message::new(Role::System, "Be brief."), Message::new(Role::User, text)],
        fixed: 1,
        answer_so_far: String::new(),
        constraint: Constraint::JsonSchema(json!({"type": "object"})),
        max_tokens: 50,
    }
}

fn replay(path: &Path) -> Result<Box<dyn ChatModel>, ModelError> {
    let reference = format!("replay:{}", path.display()).parse::<ModelReference>()?;
    open(&reference, &OpenOptions::new("unused".into()), &mut |_| {})
}

fn quiet(_: Progress) {}

#[test]
fn replay_returns_the_recorded_replies_and_token_counts() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("talk.jsonl");
    // Twice, because an existing recording is continued.
    let message = Message::new(Role::User, "hello");
    for _ in 0..2 {
        let mut model = Recording::new(Box::new(Numbering(0)), &path).unwrap();
        assert_eq!(model.message_tokens(&message), 1005);
        assert_eq!((model.message_tokens(&message), model.frame_tokens()), (1005, 9));
        for text in ["one", "two", "one"] {
            model.chat(&request(text), &mut quiet).unwrap();
        }
    }
    assert_eq!(std::fs::read_to_string(&path).unwrap().lines().count(), 11);

    let mut model = replay(&path).unwrap();
    assert_eq!(model.name(), "a model");
    assert_eq!(
        (model.constraint_kind(), model.context_tokens()),
        (ConstraintKind::JsonSchema, Some(77))
    );
    assert_eq!(model.counting(), Counting::Exact("fingers".into()));
    assert_eq!((model.message_tokens(&message), model.frame_tokens()), (1005, 9));
    let unknown = Message::new(Role::User, "never counted");
    assert_eq!(
        model.message_tokens(&unknown),
        EstimatedTokens::default().message_tokens(&unknown)
    );
    let mut fixed = request("one");
    fixed.fixed = 0;
    for (request, answer) in [
        (request("two"), "answer 2"),
        (request("one"), "answer 1"),
        (fixed, "answer 3"),
        (request("one"), "answer 1"),
    ] {
        let reply = model.chat(&request, &mut quiet).unwrap();
        assert_eq!((reply.text.as_str(), reply.finish), (answer, Finish::Length));
        assert_eq!(
            (reply.usage.calls, reply.usage.prompt_tokens, reply.usage.cached_tokens),
            (1, 2, 2)
        );
    }
    model.chat(&request("one"), &mut quiet).unwrap();
    let error = model.chat(&request("one"), &mut quiet).unwrap_err();
    assert!(error.to_string().contains("recorded 4 times"), "{error}");
}

#[test]
fn replay_error_names_the_first_difference_from_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("talk.jsonl");
    let mut model = Recording::new(Box::new(Numbering(0)), &path).unwrap();
    model.chat(&request("Put the cup on the shelf."), &mut quiet).unwrap();
    model.chat(&request("Open the door."), &mut quiet).unwrap();
    let near = || request("Put the cup on the shelf.");
    let changed = |change: &dyn Fn(&mut ChatRequest)| {
        let mut request = near();
        change(&mut request);
        request
    };
    let mut model = replay(&path).unwrap();
    for (request, expected) in [
        (
            request("Open the doors."),
            "request 2, which differs in message 2: recorded \"Open the door.\", requested \"Open the doors.\"",
        ),
        (
            changed(&|request| request.messages[1].role = Role::Assistant),
            "request 1, which differs in message 2: recorded from User, requested from Assistant",
        ),
        (
            changed(&|request| request.messages.push(Message::new(Role::User, "x"))),
            "the number of messages: recorded 2, requested 3",
        ),
        (
            changed(&|request| request.answer_so_far = "{".into()),
            "the beginning of the answer: recorded \"\", requested \"{\"",
        ),
        (
            changed(&|request| request.constraint = Constraint::Free),
            "the constraint: recorded \"schema {\\\"type\\\":\\\"object\\\"}\", requested \"none\"",
        ),
        (
            changed(&|request| request.max_tokens = 51),
            "the token limit of the answer: recorded 50, requested 51",
        ),
    ] {
        let error = model.chat(&request, &mut quiet).unwrap_err();
        assert!(matches!(error, ModelError::NotRecorded { .. }));
        assert!(error.to_string().ends_with(expected), "{error}");
        assert!(error.hint().is_some());
    }
}

#[test]
fn pictures_are_compared_by_their_content() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("look.jsonl");
    let picture = |content: &[u8]| Picture::new([b"\x89PNG\r\n\x1a\n", content].concat()).unwrap();
    let showing = |pictures: &[&[u8]]| {
        let pictures = pictures.iter().map(|content| picture(content)).collect();
        Message::new(Role::User, "Look.").with_pictures(pictures)
    };
    let asking = |pictures: &[&[u8]]| {
        let mut request = request("");
        request.messages[1] = showing(pictures);
        request
    };
    let mut model = Recording::new(Box::new(Numbering(0)), &path).unwrap();
    model.chat(&asking(&[b"table", b"shelf"]), &mut quiet).unwrap();
    model.message_tokens(&showing(&[b"table"]));
    let text = std::fs::read_to_string(&path).unwrap();
    assert_eq!(text.matches("\"sha256\"").count(), 3);
    assert!(!text.contains("shelf"), "{text}");

    let mut model = replay(&path).unwrap();
    assert_eq!(model.message_tokens(&showing(&[b"table"])), 1005);
    let estimate = EstimatedTokens::default().message_tokens(&showing(&[]));
    assert_eq!(model.message_tokens(&showing(&[b"shelf"])), estimate);
    for (pictures, expected) in [
        (
            &[&b"table"[..], b"door"][..],
            "message 2: picture 2: recorded image/png with the SHA-256 ab7227178e98..., requested image/png with the SHA-256 ",
        ),
        (
            &[b"shelf", b"table"],
            "message 2: picture 1: recorded image/png with the SHA-256 ",
        ),
        (
            &[b"table"],
            "message 2: the number of pictures: recorded 2, requested 1",
        ),
        (&[], "message 2: the number of pictures: recorded 2, requested 0"),
    ] {
        let error = model.chat(&asking(pictures), &mut quiet).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
    let reply = model.chat(&asking(&[b"table", b"shelf"]), &mut quiet).unwrap();
    assert_eq!(reply.text, "answer 1");
}

#[test]
fn replay_rejects_a_file_that_is_not_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("talk.jsonl");
    assert!(matches!(replay(&path), Err(ModelError::File { .. })));
    let head = r#"{"recording": {"version": 2, "name": "m", "constraint_kind": "grammar", "counting": {"exact": ""}}}"#;
    for (text, expected) in [
        ("", "line 1: the first line with the model is missing"),
        ("\nhello", "line 2: expected value"),
        ("{\"frame\": 3}\n{\"other\": 1}", "line 2: unknown variant `other`"),
        (head, "line 1: version 2"),
    ] {
        std::fs::write(&path, text).unwrap();
        let Err(error) = replay(&path) else {
            panic!("{text} was read")
        };
        assert!(error.to_string().contains(expected), "{error}");
    }
}
