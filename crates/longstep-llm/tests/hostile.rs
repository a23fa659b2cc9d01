//! Calls to a hostile server: each ends with the error that its mode stands for, and no clock decides which.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

#[path = "hostile/mod.rs"]
mod server;

use std::time::Duration;

use longstep::dialogue::{ChatRequest, Constraint, Finish, Message, Reply, Role, Task};
use longstep_llm::{ChatModel, ModelError, OpenOptions, Progress, StopFlag, Watch, open};
use server::{Hostile, Mode, Outcome, Place, Short, modes};

fn request() -> ChatRequest {
    ChatRequest {
        task: Task::Other,
        messages: vec![Message::new(Role::User, "Put the cereal on the counter.")],
        fixed: 0,
        answer_so_far: String::new(),
        constraint: Constraint::Free,
        max_tokens: 256,
    }
}

fn model(server: &Hostile, short: Short, stop: &StopFlag) -> Box<dyn ChatModel> {
    let mut options = OpenOptions::new("unused".into());
    match short {
        Short::Nothing => {}
        Short::Timeout => options.timeout = Duration::from_secs(1),
        Short::Silence => options.silence = Duration::from_millis(500),
    }
    options.stop = stop.clone();
    open(&server.reference().parse().unwrap(), &options, &mut |_| {}).unwrap()
}

fn outcome(result: &Result<Reply, ModelError>) -> Outcome {
    match result {
        Ok(reply) if reply.finish == Finish::Length => Outcome::CutOff,
        Ok(_) => Outcome::Reply,
        Err(ModelError::Silent { .. }) => Outcome::Silent,
        Err(ModelError::TimedOut { .. }) => Outcome::TimedOut,
        Err(ModelError::TooLarge { .. }) => Outcome::TooLarge,
        Err(ModelError::BadAnswer { .. }) => Outcome::Bad,
        Err(ModelError::Unreachable { .. }) => Outcome::Unreachable,
        Err(ModelError::Status { status, .. }) => Outcome::Status(*status),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn every_call_ends_with_the_error_of_its_mode() {
    let modes = modes();
    assert!(modes.len() >= 20);
    let mut wrong = Vec::new();
    for mode in &modes {
        let server = Hostile::new(mode);
        let mut model = model(&server, mode.short, &StopFlag::default());
        if mode.place == Place::Context {
            assert_eq!(model.context_tokens(), None, "{}", mode.name);
        }
        if mode.place == Place::Tokens {
            let tokens = model.message_tokens(&request().messages[0]);
            assert!((8..30).contains(&tokens), "{}: {tokens}", mode.name);
        }
        let result = model.chat(&request(), &mut |_: Progress| {});
        if outcome(&result) != mode.outcome {
            wrong.push(format!("{}: {:?}, not {result:?}", mode.name, mode.outcome));
        }
        if let Err(error) = result {
            let line = error.to_string();
            assert!(line.len() < 500 && !line.contains('\n'), "{}: {line}", mode.name);
            assert!(
                error.hint().is_some() || matches!(error, ModelError::Status { .. }),
                "{line}"
            );
        }
    }
    assert_eq!(wrong, [""; 0], "\n{}", wrong.join("\n"));
}

/// Stops a call as soon as the server has been asked.
struct Impatient<'a> {
    flag: &'a StopFlag,
    after: usize,
    told: usize,
}

impl Watch for Impatient<'_> {
    fn tell(&mut self, _: Progress) {
        self.told += 1;
        if self.told >= self.after {
            let flag = self.flag.clone();
            std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(100));
                flag.set(true);
            });
        }
    }

    fn stop(&self) -> bool {
        self.flag.is_set()
    }
}

/// The calls of these modes would last for 60 s (of silence) or 600 s: that they end with `Stopped` shows that they were
/// stopped.
#[test]
fn a_call_can_be_stopped_at_every_moment() {
    let long = |mode: &&Mode| mode.short != Short::Nothing;
    for mode in modes().iter().filter(long) {
        let server = Hostile::new(mode);
        let flag = StopFlag::default();
        let mut model = model(&server, Short::Nothing, &flag);
        let mut watch = Impatient {
            flag: &flag,
            after: 1,
            told: 0,
        };
        let error = model.chat(&request(), &mut watch).unwrap_err();
        // An error that drips is stopped as well, though it would end by itself.
        assert!(matches!(error, ModelError::Stopped), "{}: {error}", mode.name);
    }
}

#[test]
fn a_question_beside_the_chat_can_be_stopped_and_is_asked_again() {
    for mode in modes().iter().filter(|mode| mode.place != Place::Chat) {
        let server = Hostile::new(mode);
        let flag = StopFlag::default();
        let mut model = model(&server, Short::Nothing, &flag);
        flag.set(true);
        assert_eq!(model.context_tokens(), None);
        assert!(model.message_tokens(&request().messages[0]) > 0);
        let error = model.chat(&request(), &mut |_: Progress| {}).unwrap_err();
        assert!(matches!(error, ModelError::Stopped), "{}: {error}", mode.name);
        flag.set(false);
        assert!(model.chat(&request(), &mut |_: Progress| {}).is_ok(), "{}", mode.name);
    }
}
