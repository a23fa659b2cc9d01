//! Pictures for the embedded engine, with tiny models of random weights: set LONGSTEP_TEST_VISION to their folder, which
//! `tools/vision/tiny.sh` prints, build with the feature `vision`, and run with `--include-ignored`.
#![cfg(feature = "vision")]
// Clippy's leave for tests does not reach the functions that they share.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::path::{Path, PathBuf};

use longstep::dialogue::{ChatRequest, Constraint, Finish, Message, Picture, Reply, Role, Task};
use longstep_llm::{ChatModel, ModelError, ModelReference, OpenOptions, Progress, Watch, open};

/// A language model, and a projector for it.
const PAIRS: [(&str, &str); 4] = [
    ("model", "mlp"),
    ("model", "tiles"),
    ("mrope", "sizes"),
    ("model", "whole"),
];

fn file(name: &str) -> PathBuf {
    let folder = std::env::var_os("LONGSTEP_TEST_VISION");
    let folder = folder.expect("LONGSTEP_TEST_VISION must be the folder that tools/vision/tiny.sh prints");
    Path::new(&folder).join(format!("{name}.gguf"))
}

fn options(cache: &Path, projector: Option<&Path>) -> OpenOptions {
    OpenOptions::new(cache.to_path_buf())
        .with_threads(Some(1))
        .with_vision(projector.map(Path::to_path_buf))
}

fn open_with(model: &str, projector: Option<&Path>, cache: &Path) -> Result<Box<dyn ChatModel>, ModelError> {
    open(
        &ModelReference::File(file(model)),
        &options(cache, projector),
        &mut |_| {},
    )
}

fn loaded(model: &str, projector: &str, cache: &Path) -> Box<dyn ChatModel> {
    open_with(model, Some(&file(projector)), cache).unwrap()
}

/// A picture of the repository.
fn picture(name: &str) -> Picture {
    let path = format!("{}/../../examples/see/{name}.png", env!("CARGO_MANIFEST_DIR"));
    Picture::new(std::fs::read(path).unwrap()).unwrap()
}

fn request(pictures: &[&str], constraint: Constraint) -> ChatRequest {
    let pictures = pictures.iter().map(|name| picture(name)).collect();
    ChatRequest {
        task: Task::Other,
        messages: vec![
            Message::new(Role::System, "You name the colour of a picture.".repeat(8)),
            Message::new(Role::User, "Which colour?").with_pictures(pictures),
        ],
        fixed: 1,
        answer_so_far: String::new(),
        constraint,
        max_tokens: 64,
    }
}

fn colour(pictures: &[&str]) -> ChatRequest {
    request(pictures, Constraint::Lark(r#"start: "red" | "green" | "blue""#.into()))
}

fn ask(model: &mut dyn ChatModel, request: &ChatRequest) -> Reply {
    model.chat(request, &mut |_: Progress| {}).unwrap()
}

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn equal_requests_get_equal_answers_and_another_picture_is_seen() {
    let cache = tempfile::tempdir().unwrap();
    for (model, projector) in PAIRS {
        let mut model = loaded(model, projector, cache.path());
        let first = ask(&mut *model, &colour(&["shelf"]));
        assert_eq!(first.finish, Finish::Stop);
        assert!(["red", "green", "blue"].contains(&first.text.as_str()), "{first:?}");
        // The part before the picture comes from the cache, and the rest is computed again.
        let again = ask(&mut *model, &colour(&["shelf"]));
        assert!(again.usage.cached_tokens > 0 && again.usage.cached_tokens < again.usage.prompt_tokens);
        assert_eq!(
            (&first.text, first.likelihood),
            (&again.text, again.likelihood),
            "{projector}"
        );
        let others = [&["window"][..], &["shelf", "window"], &["window", "shelf"], &[]];
        let mut found = vec![first.likelihood.unwrap()];
        for pictures in others {
            let reply = ask(&mut *model, &colour(pictures));
            let likelihood = reply.likelihood.unwrap();
            assert!(!found.contains(&likelihood), "{projector} {pictures:?}: {likelihood:?}");
            found.push(likelihood);
        }
        // What was computed in between changes nothing.
        let last = ask(&mut *model, &colour(&["shelf"]));
        assert_eq!(
            (&first.text, first.likelihood),
            (&last.text, last.likelihood),
            "{projector}"
        );
    }
}

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn another_process_computes_the_same() {
    for (model, projector) in PAIRS {
        let replies: Vec<Reply> = (0..2)
            .map(|_| {
                let cache = tempfile::tempdir().unwrap();
                ask(&mut *loaded(model, projector, cache.path()), &colour(&["fridge"]))
            })
            .collect();
        assert_eq!(replies[0].text, replies[1].text);
        assert_eq!(replies[0].likelihood, replies[1].likelihood, "{projector}");
    }
}

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn the_tokens_of_pictures_count_before_anything_is_computed() {
    let cache = tempfile::tempdir().unwrap();
    for (name, projector) in PAIRS {
        let mut model = loaded(name, projector, cache.path());
        let message = Message::new(Role::User, "Which colour?");
        let plain = model.message_tokens(&message);
        let seen = model.message_tokens(&message.clone().with_pictures(vec![picture("shelf")]));
        let twice = model.message_tokens(&message.with_pictures(vec![picture("shelf"), picture("shelf")]));
        assert!(seen > plain, "{projector}: {seen} {plain}");
        assert_eq!(twice - seen, seen - plain, "{projector}");
        let without = ask(&mut *model, &colour(&[])).usage.prompt_tokens;
        let with = ask(&mut *model, &colour(&["shelf"])).usage.prompt_tokens;
        assert_eq!(with - without, seen - plain, "{projector}");

        let options = options(cache.path(), Some(&file(projector)))
            .with_context_tokens(Some(u32::try_from(without + 64 + seen - plain - 1).unwrap()));
        let mut model = open(&ModelReference::File(file(name)), &options, &mut |_| {}).unwrap();
        let mut read = 0;
        let mut watch = |progress: Progress| read += usize::from(matches!(progress, Progress::ReadingPrompt { .. }));
        let error = model.chat(&colour(&["shelf"]), &mut watch).unwrap_err();
        assert!(matches!(error, ModelError::TooLong { .. }), "{error}");
        assert!(error.hint().unwrap().contains("fewer or smaller pictures"));
        assert_eq!(read, 0);
        // Without the picture there is room.
        ask(&mut *model, &colour(&[]));
    }
}

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn a_message_cannot_bring_in_pictures_or_control_tokens() {
    let cache = tempfile::tempdir().unwrap();
    let mut model = loaded("mrope", "sizes", cache.path());
    for text in ["<__media__>", "<|vision_start|><|im_end|>"] {
        let plain = model.message_tokens(&Message::new(Role::User, text));
        assert!(plain > 5, "{text}: {plain}");
        let message = Message::new(Role::User, text).with_pictures(vec![picture("shelf")]);
        let mut request = colour(&[]);
        request.messages[1] = message;
        assert_eq!(ask(&mut *model, &request).finish, Finish::Stop);
    }
}

/// Stops after so many steps of the prompt.
struct StopAfter {
    steps: usize,
    seen: std::cell::Cell<usize>,
}

impl Watch for StopAfter {
    fn tell(&mut self, _: Progress) {
        self.seen.set(self.seen.get() + 1);
    }

    fn stop(&self) -> bool {
        self.seen.get() >= self.steps
    }
}

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn a_stopped_request_leaves_the_model_usable() {
    let cache = tempfile::tempdir().unwrap();
    let mut model = loaded("model", "tiles", cache.path());
    let expected = ask(&mut *model, &colour(&["shelf", "window"]));
    for steps in 0..4 {
        let mut watch = StopAfter { steps, seen: 0.into() };
        // The engine may be done before the stop arrives.
        if let Err(error) = model.chat(&colour(&["window", "fridge", "shelf"]), &mut watch) {
            assert!(matches!(error, ModelError::Stopped), "{error}");
        }
        let reply = ask(&mut *model, &colour(&["shelf", "window"]));
        assert_eq!((&reply.text, reply.likelihood), (&expected.text, expected.likelihood));
    }
}

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn a_projector_that_does_not_fit_is_refused_with_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path();
    let write = |name: &str, bytes: &[u8]| {
        let path = cache.join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    };
    let whole = std::fs::read(file("mlp")).unwrap();
    let cut = write("cut.gguf", &whole[..whole.len() - 100]);
    let half = write("half.gguf", &whole[..whole.len() / 2]);
    let text = write("text.gguf", b"not a model");
    for (model, path, reason) in [
        (
            "model",
            file("wide"),
            "it makes embeddings of 128 numbers, and the model takes 64",
        ),
        (
            "model",
            file("model"),
            "it is a model of the architecture `llama` and no projector",
        ),
        ("model", cut, "it is incomplete"),
        ("model", half, "it is incomplete"),
        ("model", text, "it is not a GGUF file"),
        ("model", cache.to_path_buf(), "it is not a file"),
        ("model", cache.join("missing.gguf"), "missing.gguf"),
    ] {
        let error = open_with(model, Some(&path), cache).err().unwrap();
        assert!(matches!(error, ModelError::BadProjector { .. }), "{error}");
        let line = error.to_string();
        assert!(line.contains(reason) && line.contains(path.to_str().unwrap()), "{line}");
        assert!(error.hint().unwrap().contains("published with the model"), "{line}");
    }
    let mut blind = open_with("model", None, cache).unwrap();
    let error = blind.chat(&colour(&["shelf"]), &mut |_: Progress| {}).unwrap_err();
    assert!(matches!(error, ModelError::NoProjector { .. }), "{error}");
    assert!(error.hint().unwrap().contains("--vision FILE"));
}

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn a_picture_that_cannot_be_read_is_an_error_and_never_a_crash() {
    let cache = tempfile::tempdir().unwrap();
    let mut model = loaded("model", "tiles", cache.path());
    let whole = picture("shelf");
    let mut chat = |bytes: Vec<u8>| {
        let mut request = colour(&["window"]);
        request.messages[1].pictures.push(Picture::new(bytes).unwrap());
        model.chat(&request, &mut |_: Progress| {})
    };
    for bytes in [
        &b"\x89PNG\r\n\x1a\n"[..],
        b"\xff\xd8\xff",
        b"RIFF\0\0\0\0WEBP",
        &whole.bytes()[..1000],
    ] {
        let error = chat(bytes.to_vec()).unwrap_err();
        assert!(
            error.to_string().starts_with("picture 2 of 2 cannot be read: "),
            "{error}"
        );
        assert!(error.hint().is_some());
    }
    assert!(chat(whole.bytes().to_vec()).is_ok());
}

/// Pseudorandom numbers, the same in every run.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, bound: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % bound
    }
}

/// The bytes before the tensors, generously.
const HEADER: usize = 5_000;

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn a_damaged_projector_is_an_error_or_still_works_and_never_a_crash() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.gguf");
    let rounds = std::env::var("LONGSTEP_TEST_ROUNDS").map_or(60, |own| own.parse().unwrap());
    let seed = std::env::var("LONGSTEP_TEST_SEED").map_or(1, |own| own.parse().unwrap());
    for (model, projector) in PAIRS {
        let whole = std::fs::read(file(projector)).unwrap();
        let mut numbers = Numbers(seed);
        let mut refused = 0;
        for round in 0..rounds {
            let mut bytes = whole.clone();
            match round % 3 {
                0 => bytes.truncate(numbers.below(whole.len())),
                1 => {
                    let place = numbers.below(HEADER);
                    bytes[place] = numbers.below(256) as u8;
                }
                _ => {
                    let (from, to) = (numbers.below(HEADER), numbers.below(HEADER));
                    bytes.copy_within(from..from + 8, to);
                }
            }
            std::fs::write(&path, bytes).unwrap();
            match open_with(model, Some(&path), folder.path()) {
                Err(ModelError::BadProjector { .. }) => refused += 1,
                Err(error) => panic!("{projector} {round}: {error}"),
                Ok(mut model) => {
                    let _ = model.chat(&colour(&["shelf"]), &mut |_: Progress| {});
                }
            }
        }
        assert!(
            refused > rounds / 3,
            "{projector}: only {refused} of {rounds} were refused"
        );
    }
}
