//! Any text is a recording, or an error; a recording gives every reply that it holds once, and then none.
#![no_main]

use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use longstep::dialogue::{ChatRequest, Constraint, Message, Role, Task};
use longstep_llm::{ChatModel, ModelError, ModelReference, OpenOptions, Progress, open};
use serde_json::Value;

/// A file in memory where there is such a folder: recordings are opened by their path.
static FILE: LazyLock<PathBuf> = LazyLock::new(|| {
    let memory = PathBuf::from("/dev/shm");
    let folder = if memory.is_dir() { memory } else { std::env::temp_dir() };
    folder.join(format!("longstep-fuzz-replay-{}", std::process::id()))
});

fuzz_target!(|text: &str| {
    std::fs::write(&*FILE, text).expect("the file can be written");
    let reference = ModelReference::Replay(FILE.clone());
    let opened = open(&reference, &OpenOptions::new("unused".into()), &mut |_| {});
    // Whatever ends the process next, nothing is left behind.
    drop(std::fs::remove_file(&*FILE));
    let mut model = match opened {
        Ok(model) => model,
        Err(error) => return drop((error.to_string(), error.hint())),
    };
    let message = Message::new(Role::User, "hello");
    drop((
        model.name().len(),
        model.constraint_kind(),
        model.context_tokens(),
        model.counting(),
    ));
    assert_eq!(model.message_tokens(&message), model.message_tokens(&message));
    let _ = model.frame_tokens();
    let turns: Vec<(ChatRequest, String)> = text.lines().filter_map(turn).collect();
    for (request, _) in &turns {
        let reply = ask(model.as_mut(), request).expect("it was recorded");
        let recorded = turns.iter().any(|(other, text)| same(other, request) && *text == reply);
        assert!(recorded, "{reply:?} was never a reply to this request");
    }
    // A turn may be written in other ways than `turn` knows.
    let others = text
        .lines()
        .filter(|line| line.contains("request") || line.contains('\\'))
        .count()
        > turns.len();
    let unknown = request(vec![message]);
    for request in turns.iter().map(|(request, _)| request).chain([&unknown]) {
        match ask(model.as_mut(), request) {
            Err(error @ ModelError::NotRecorded { .. }) => drop((error.to_string(), error.hint())),
            Ok(_) if others || same(request, &unknown) => {}
            other => panic!("{other:?}"),
        }
    }
});

fn ask(model: &mut dyn ChatModel, request: &ChatRequest) -> Result<String, ModelError> {
    model.chat(request, &mut |_: Progress| {}).map(|reply| reply.text)
}

fn same(one: &ChatRequest, other: &ChatRequest) -> bool {
    one.messages == other.messages && one.max_tokens == other.max_tokens && one.answer_so_far == other.answer_so_far
}

fn request(messages: Vec<Message>) -> ChatRequest {
    ChatRequest {
        task: Task::Other,
        messages,
        fixed: 0,
        answer_so_far: String::new(),
        constraint: Constraint::Free,
        max_tokens: 9,
    }
}

/// The request and the reply of a line that is a plain turn.
fn turn(line: &str) -> Option<(ChatRequest, String)> {
    let value: Value = serde_json::from_str(line).ok()?;
    let turn = value.get("turn")?;
    let recorded = turn.get("request")?;
    if recorded.get("constraint")? != "free" {
        return None;
    }
    let role = |text: &str| match text {
        "system" => Some(Role::System),
        "user" => Some(Role::User),
        "assistant" => Some(Role::Assistant),
        _ => None,
    };
    let message = |record: &Value| {
        Some(Message::new(
            role(record.get("role")?.as_str()?)?,
            record.get("text")?.as_str()?,
        ))
    };
    let messages: Option<Vec<Message>> = recorded.get("messages")?.as_array()?.iter().map(message).collect();
    let made = ChatRequest {
        answer_so_far: recorded.get("answer_so_far")?.as_str()?.to_owned(),
        max_tokens: u32::try_from(recorded.get("max_tokens")?.as_u64()?).ok()?,
        ..request(messages?)
    };
    Some((made, turn.get("reply")?.get("text")?.as_str()?.to_owned()))
}
