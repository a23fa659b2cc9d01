//! `longstep chat`: instructions one after the other, each in the world after the last plan.

mod commands;
mod input;
mod robot;
mod screen;
mod typed_ahead;

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use anyhow::Result;
use longstep::session::{Event, Proposal, Session};
use longstep_files::session_directory;
use longstep_llm::{AdvanceError, ChatModel, ModelError, SessionFolder, advance};

use crate::arguments::{ChatArguments, ModelArguments, domain_or_default};
use crate::ask::{self, Waiting};
use crate::clock::clock;
use crate::exit_code::WRONG_ARGUMENTS;
use crate::failure::{self, Failure};
use crate::{inputs, output, plan, show};
use input::{Input, Lines};
use robot::ChatRobot;

/// The exit code after Ctrl-C on a pipe: 128 plus the signal's number, as in shells.
const INTERRUPTED: u8 = 130;

/// Lines that accept a plan, and lines that reject it.
const ACCEPTING: [&str; 6] = ["", "y", "yes", "ok", "okay", "accept"];
const REJECTING: [&str; 2] = ["n", "no"];

/// Returns the line in lower case and without its full stop.
fn plain(line: &str) -> String {
    line.trim_end_matches(['.', '!']).to_lowercase()
}

/// Returns true if the line accepts or rejects a plan, and says no more.
fn is_decision(line: &str) -> bool {
    let plain = plain(line);
    ACCEPTING.contains(&plain.as_str()) || REJECTING.contains(&plain.as_str())
}

/// A conversation with a person.
struct Chat<'a> {
    session: Session,
    folder: SessionFolder,
    /// Opened at the first use: `/undo` and `/env` need no model.
    model: Option<Box<dyn ChatModel>>,
    model_name: String,
    arguments: &'a ModelArguments,
    /// Number of accepted plans that have been shown.
    shown: usize,
    /// None without `--robot`.
    robot: Option<ChatRobot<'a>>,
}

/// Continues or ends the conversation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    GoOn,
    Quit,
}

pub(crate) fn run(arguments: &ChatArguments) -> Result<u8> {
    let interactive = std::io::stdin().is_terminal();
    let mut chat = match (&arguments.resume, &arguments.env) {
        (Some(named), _) => resume(arguments, &crate::session::folder(named)?, interactive)?,
        (None, Some(env)) => begin(arguments, env)?,
        (None, None) => {
            return Err(Failure::new("neither an environment nor a session is given", WRONG_ARGUMENTS)
                .hint("pass `--env ENV.json`, name the environment in longstep.toml, or resume a session with `--resume`")
                .into());
        }
    };
    ask::watch_for_interrupts();
    if interactive {
        screen::notice(&format!(
            "The session is saved in {}. `/help` lists the commands.",
            chat.folder.path().display()
        ));
    }
    let mut lines = Lines::open(interactive)?;
    let outcome = chat.converse(&mut lines, interactive);
    lines.close();
    let name = screen::session_name(chat.folder.path());
    if chat.session.proposal().is_some() && outcome.is_ok() {
        screen::notice(&format!(
            "The plan is not accepted. Resume with: longstep chat --resume {name}"
        ));
    } else if interactive || matches!(outcome, Ok(INTERRUPTED)) {
        screen::notice(&format!("Resume with: longstep chat --resume {name}"));
    }
    outcome
}

fn begin<'a>(arguments: &'a ChatArguments, env: &Path) -> Result<Chat<'a>> {
    let named = domain_or_default(arguments.domain.as_ref());
    let domain = inputs::domain_with_prompt(named, arguments.strategy.prompt.as_deref())?;
    let world = inputs::world(&domain, env, arguments.rules.as_deref())?;
    let settings = arguments.strategy.settings().with_accept(arguments.yes);
    let name = arguments.model.name();
    let model = ask::model(name, &arguments.model)?;
    let folder = match &arguments.session {
        Some(folder) => SessionFolder::create(folder)?,
        None => SessionFolder::create(&free_folder(env)?)?,
    };
    let facts = model.facts();
    let origin = domain.origin.clone();
    let mut chat = Chat {
        session: Session::new(&origin, domain, world, settings, facts, clock()),
        folder,
        model: Some(model),
        model_name: name.to_owned(),
        arguments: &arguments.model,
        shown: 0,
        robot: robot(arguments)?,
    };
    chat.folder.keep(&mut chat.session)?;
    Ok(chat)
}

fn robot(arguments: &ChatArguments) -> Result<Option<ChatRobot<'_>>> {
    let named = arguments.robot.as_deref();
    named
        .map(|named| ChatRobot::new(named, &arguments.execution))
        .transpose()
}

/// A folder for a new session, named after its environment.
fn free_folder(env: &Path) -> Result<PathBuf> {
    let all = session_directory()?;
    let stem = env.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let free = (1_u32..)
        .map(|number| all.join(format!("{stem}-{number}")))
        .find(|path| !path.exists());
    free.ok_or_else(|| Failure::unreadable("there are too many sessions").into())
}

fn resume<'a>(arguments: &'a ChatArguments, path: &Path, interactive: bool) -> Result<Chat<'a>> {
    let (folder, log) = SessionFolder::open(path)?;
    let Some(Event::Begin { domain, .. }) = log.events().next() else {
        // A log always begins with this event.
        return Err(Failure::unreadable("the session has not begun").into());
    };
    let domain = inputs::domain_with_prompt(domain, arguments.strategy.prompt.as_deref())?;
    let resumed = Session::resume(domain, &log, clock())?;
    if log.torn > 0 {
        screen::notice("The last line of the session's log was incomplete and is dropped");
    }
    if let Some(instruction) = &resumed.dropped {
        screen::notice(&format!("An unfinished instruction is dropped: {instruction}"));
    }
    let mut session = resumed.session;
    folder.mend(&session)?;
    let chosen = arguments.strategy.settings();
    let settings = session
        .settings()
        .with_accept(arguments.yes)
        .with_partial(chosen.partial)
        .with_effort(arguments.strategy.effort.or(session.settings().effort));
    if settings != session.settings() {
        session.set_settings(settings);
    }
    let shown = session.accepted().len();
    let mut chat = Chat {
        session,
        folder,
        model: None,
        model_name: arguments.model.name().to_owned(),
        arguments: &arguments.model,
        shown,
        robot: robot(arguments)?,
    };
    chat.folder.keep(&mut chat.session)?;
    screen::where_we_are(&chat.session, interactive);
    Ok(chat)
}

impl Chat<'_> {
    /// Runs the conversation to its end; returns the exit code.
    fn converse(&mut self, lines: &mut Lines, interactive: bool) -> Result<u8> {
        self.go_on(interactive)?;
        loop {
            // A plan that the user cannot see must not be accepted.
            if output::failed() {
                return Ok(output::NOT_WRITTEN);
            }
            let asks = match self.session.proposal() {
                Some(proposal) if proposal.question.is_some() => "Go on? [Enter, `no`, or a change] ",
                Some(_) => "Accept? [Enter, `no`, or a change] ",
                None if !self.session.endings().is_empty() => "Which? [number] ",
                None => "> ",
            };
            let decides = self.session.proposal().is_some() || !self.session.endings().is_empty();
            let line = match lines.next(asks, decides)? {
                Input::Line(line) => line,
                Input::End => return Ok(0),
                Input::Interrupted => return Ok(INTERRUPTED),
            };
            match self.hear(line.trim(), lines) {
                Ok(Next::GoOn) => {}
                Ok(Next::Quit) => return Ok(0),
                // If the session cannot be saved, the conversation ends at once.
                Err(error) if error.is::<longstep_llm::FolderError>() => return Err(error),
                Err(error) => {
                    failure::tell(&error);
                }
            }
            if let Err(error) = self.go_on(interactive) {
                if error.is::<longstep_llm::FolderError>() {
                    return Err(error);
                }
                failure::tell(&error);
                if self.session.proposal().is_some() {
                    screen::notice("The plan is unchanged; `/plan` shows it");
                }
            }
        }
    }

    /// Handles a line of the user, by the state of the session.
    fn hear(&mut self, line: &str, lines: &mut Lines) -> Result<Next> {
        if let Some(command) = line.strip_prefix('/') {
            return self.command(command, lines);
        }
        let plain = plain(line);
        if self.session.proposal().is_some() {
            match plain.as_str() {
                word if ACCEPTING.contains(&word) => self.accept()?,
                word if REJECTING.contains(&word) => {
                    self.session.cancel()?;
                    screen::notice("Cancelled; nothing has changed");
                }
                _ => self.session.feedback(plan::checked_instruction(line)?)?,
            }
        } else if line.is_empty() {
            return Ok(Next::GoOn);
        } else if !self.session.endings().is_empty() {
            self.ended(&plain)?;
        } else if self.session.question().is_some() {
            self.session.answer(plan::checked_instruction(line)?)?;
        } else {
            self.session.instruct(plan::checked_instruction(line)?)?;
        }
        Ok(Next::GoOn)
    }

    /// Accepts the plan, or the rule that is offered in place of one.
    fn accept(&mut self) -> Result<()> {
        let offers_rule = self.session.proposal().is_some_and(Proposal::offers_rule);
        self.session.accept()?;
        if offers_rule {
            screen::rules(&self.session);
        }
        Ok(())
    }

    /// Takes the number of the outcome with which the last plan ended.
    fn ended(&mut self, line: &str) -> Result<()> {
        let count = self.session.endings().len();
        let number: Option<usize> = line.parse().ok().filter(|number| (1..=count).contains(number));
        let Some(number) = number else {
            let failure = Failure::unreadable(format!("`{line}` is not the number of an outcome"));
            return Err(failure
                .hint(format!("enter a number from 1 to {count}, or `/undo` to undo the plan"))
                .into());
        };
        let before = self.session.world().environment().clone();
        self.session.ended(number - 1)?;
        show::changes(&before, self.session.world().environment());
        output::blank();
        Ok(())
    }

    /// Advances the session until it needs the user, and shows the result.
    fn go_on(&mut self, interactive: bool) -> Result<()> {
        if self.session.wants_model() {
            // An earlier Ctrl-C does not cancel this call.
            ask::interrupted().set(false);
            self.open_model()?;
            if ask::interrupted().is_set() {
                self.session.cancel()?;
                self.folder.keep(&mut self.session)?;
                self.notice_stopped();
                return Ok(());
            }
            let Some(model) = self.model.as_deref_mut() else {
                return Ok(());
            };
            let mut waiting = Waiting::new(model.name());
            let advanced = advance(&mut self.session, model, Some(&mut self.folder), &mut waiting);
            drop(waiting);
            match advanced {
                Ok(()) => screen::response(&self.session, interactive),
                Err(AdvanceError::Model(ModelError::Stopped)) => {
                    let _ = ask::take_interrupt();
                    self.notice_stopped();
                }
                Err(error) => return Err(error.into()),
            }
        } else {
            self.folder.keep(&mut self.session)?;
        }
        if self.session.accepted().len() > self.shown {
            screen::accepted(&self.session);
        }
        self.shown = self.session.accepted().len();
        Ok(())
    }

    fn notice_stopped(&self) {
        screen::notice(match self.session.proposal() {
            Some(_) => "Stopped; the plan is unchanged, `/plan` shows it",
            None => "Stopped",
        });
    }

    fn open_model(&mut self) -> Result<()> {
        if self.model.is_none() {
            let model = ask::model(&self.model_name, self.arguments)?;
            let facts = model.facts();
            // The request for the size of the context was cancelled, so the model is unknown.
            if ask::interrupted().is_set() {
                return Ok(());
            }
            if self.session.model() != &facts {
                self.session.set_model(facts);
            }
            self.model = Some(model);
        }
        Ok(())
    }
}
