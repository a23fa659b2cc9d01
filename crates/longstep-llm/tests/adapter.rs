//! The adapter of an embedded model: set LONGSTEP_TEST_MODEL to the path of the catalogue's qwen2.5-coder-0.5b and run with
//! `--include-ignored`.
#![cfg(feature = "embedded")]
// Clippy's leave for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};

use longstep::dialogue::{ChatRequest, Constraint, Likelihood, Message, Reply, Role, Task};
use longstep_llm::{AdapterChoice, ChatModel, ModelError, ModelReference, OpenOptions, Progress, open};

/// The width of the model, and the number of its blocks.
const WIDTH: u64 = 896;
const BLOCKS: u64 = 24;

fn model_path() -> PathBuf {
    let path = std::env::var_os("LONGSTEP_TEST_MODEL");
    path.expect("LONGSTEP_TEST_MODEL must be the path of a .gguf file")
        .into()
}

fn load(adapter: AdapterChoice, cache: &Path) -> Result<Box<dyn ChatModel>, ModelError> {
    let options = OpenOptions::new(cache.to_path_buf())
        .with_threads(Some(1))
        .with_context_tokens(Some(512))
        .with_adapters(adapter);
    open(&ModelReference::File(model_path()), &options, &mut |_| {})
}

fn ask(model: &mut dyn ChatModel, task: Task) -> Reply {
    let mut messages = Vec::new();
    for (thing, colour) in [
        ("a tomato", "red"),
        ("grass", "green"),
        ("the sky", "blue"),
        ("a poppy", "red"),
    ] {
        messages.push(Message::new(Role::User, format!("What colour is {thing}?")));
        messages.push(Message::new(Role::Assistant, colour));
    }
    let fixed = messages.len();
    messages.push(Message::new(Role::User, "What colour is the sea?"));
    let request = ChatRequest {
        task,
        messages,
        fixed,
        answer_so_far: String::new(),
        constraint: Constraint::Lark(r#"start: "red" | "green" | "blue""#.into()),
        max_tokens: 8,
    };
    model.chat(&request, &mut |_: Progress| {}).unwrap()
}

/// A value of an adapter's file.
enum Value {
    Text(&'static str),
    Number(f32),
}

/// Writes an adapter of rank 1 for one linear map of each block, with random numbers up to `size`.
fn write_adapter(path: &Path, size: f32, width: u64) {
    let text = |bytes: &mut Vec<u8>, text: &str| {
        bytes.extend((text.len() as u64).to_le_bytes());
        bytes.extend(text.as_bytes());
    };
    let mut bytes = b"GGUF".to_vec();
    bytes.extend(3_u32.to_le_bytes());
    bytes.extend((2 * BLOCKS).to_le_bytes());
    let keys = [
        ("general.architecture", Value::Text("qwen2")),
        ("general.type", Value::Text("adapter")),
        ("adapter.type", Value::Text("lora")),
        ("adapter.lora.alpha", Value::Number(1.0)),
        ("longstep.task", Value::Text("goals")),
    ];
    bytes.extend((keys.len() as u64).to_le_bytes());
    for (key, value) in &keys {
        text(&mut bytes, key);
        match value {
            Value::Text(value) => {
                bytes.extend(8_u32.to_le_bytes());
                text(&mut bytes, value);
            }
            Value::Number(value) => {
                bytes.extend(6_u32.to_le_bytes());
                bytes.extend(value.to_le_bytes());
            }
        }
    }
    for block in 0..BLOCKS {
        for (part, shape) in [("a", [width, 1]), ("b", [1, width])] {
            text(&mut bytes, &format!("blk.{block}.attn_output.weight.lora_{part}"));
            bytes.extend(2_u32.to_le_bytes());
            bytes.extend(shape.iter().flat_map(|size| size.to_le_bytes()));
            bytes.extend(0_u32.to_le_bytes());
            let number = 2 * block + u64::from(part == "b");
            bytes.extend((number * width * 4).to_le_bytes());
        }
    }
    bytes.resize(bytes.len().next_multiple_of(32), 0);
    let mut state = 7_u32;
    for _ in 0..2 * BLOCKS * width {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let share = f32::from((state >> 16) as u16) / f32::from(u16::MAX);
        bytes.extend((size * (2.0 * share - 1.0)).to_le_bytes());
    }
    std::fs::write(path, bytes).unwrap();
}

#[test]
#[ignore = "needs LONGSTEP_TEST_MODEL"]
fn an_adapter_changes_how_goals_are_written_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("adapter.gguf");
    write_adapter(&path, 0.2, WIDTH);
    let mut plain = load(AdapterChoice::Off, folder.path()).unwrap();
    let mut adapted = load(AdapterChoice::Files(vec![path.clone()]), folder.path()).unwrap();
    let alone = ask(&mut *plain, Task::Goals);
    // Each model goes from one task to the other and back, with the states that the disk has.
    let tasks = [Task::Other, Task::Goals, Task::Goals, Task::Description, Task::Goals];
    let likelihoods = tasks.map(|task| ask(&mut *adapted, task).likelihood);
    assert_eq!(likelihoods[0], alone.likelihood);
    assert_ne!(likelihoods[1], alone.likelihood);
    assert_eq!(likelihoods[2], likelihoods[1]);
    assert_eq!(likelihoods[3], alone.likelihood);
    assert_eq!(likelihoods[4], likelihoods[1]);
    // A new engine takes the states from the disk, each for its own task.
    drop(adapted);
    let mut again = load(AdapterChoice::Files(vec![path.clone()]), folder.path()).unwrap();
    assert_eq!(ask(&mut *again, Task::Goals).likelihood, likelihoods[1]);
    assert_eq!(ask(&mut *again, Task::Other).likelihood, alone.likelihood);
    // An adapter without effect changes nothing.
    write_adapter(&path, 0.0, WIDTH);
    let mut idle = load(AdapterChoice::Files(vec![path]), folder.path()).unwrap();
    let (idle, alone) = (ask(&mut *idle, Task::Goals).likelihood, alone.likelihood);
    let alone = alone.map(|likelihood| Likelihood {
        is_trained: true,
        ..likelihood
    });
    assert_eq!(idle, alone);
}

#[test]
#[ignore = "needs LONGSTEP_TEST_MODEL"]
fn load_rejects_adapters_that_do_not_fit_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("adapter.gguf");
    let refused = |content: &dyn Fn(&Path)| {
        content(&path);
        let error = load(AdapterChoice::Files(vec![path.clone()]), folder.path()).err();
        let error = error.expect("it must be refused");
        assert!(error.to_string().contains("adapter.gguf"), "{error}");
        error.to_string()
    };
    let text = refused(&|path| std::fs::write(path, "no adapter").unwrap());
    assert!(text.contains("not a GGUF file"), "{text}");
    let other = refused(&|path| write_adapter(path, 0.1, WIDTH / 2));
    assert!(other.contains("not an adapter for this model"), "{other}");
    let model = refused(&|path| {
        std::fs::remove_file(path).unwrap();
        std::os::unix::fs::symlink(model_path(), path).unwrap();
    });
    assert!(model.contains("no adapter with a task"), "{model}");
    std::fs::remove_file(&path).unwrap();
    write_adapter(&path, 0.1, WIDTH);
    let twice = load(AdapterChoice::Files(vec![path.clone(), path.clone()]), folder.path()).err();
    assert!(twice.expect("it must be refused").to_string().contains("the same task"));
}
