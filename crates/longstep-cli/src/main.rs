//! The `longstep` program.
//!
//! Results go to stdout, progress and errors to stderr. The exit codes are in `exit_code`, and on the page
//! docs/reference/command-line.md.

mod arguments;
mod ask;
mod chat;
mod clock;
mod compose;
mod domain;
mod draft;
mod eval;
mod exit_code;
mod explain;
mod export;
mod failure;
mod hub;
mod input_lines;
mod inputs;
mod lanes;
mod mcp;
mod model;
mod output;
mod parsed_arguments;
mod plan;
mod plan_domain;
mod plan_tree;
mod problem;
mod progress;
mod project;
mod question;
mod repair;
mod robot;
mod ros;
mod run;
mod runs;
mod schema;
mod see;
mod serve;
mod session;
mod show;
mod signals;
mod solve;
mod teach;
mod verify;

use std::process::ExitCode;

use arguments::Command;
use output::Style;

fn main() -> ExitCode {
    let mut arguments = match parsed_arguments::parsed() {
        Ok(arguments) => arguments,
        Err(code) => return ExitCode::from(output::finished(code)),
    };
    let code = run(&mut arguments.command).unwrap_or_else(|error| failure::tell(&error));
    ExitCode::from(output::finished(code))
}

fn run(command: &mut Command) -> anyhow::Result<u8> {
    let taken = command.complete()?;
    if let Some(sentence) = taken.sentence().filter(|_| output::shows_remarks()) {
        output::remark!("{}", sentence.dimmed());
    }
    match command {
        Command::Plan(arguments) => plan::run(arguments),
        Command::Chat(arguments) => chat::run(arguments),
        Command::Session(command) => session::run(command),
        Command::Verify(arguments) => verify::run(arguments),
        Command::Show(arguments) => plan_tree::run(arguments),
        Command::Repair(arguments) => repair::run(arguments),
        Command::Teach(arguments) => teach::run(arguments),
        Command::Run(arguments) => run::run(arguments),
        Command::Runs(command) => runs::run(command),
        Command::Serve(arguments) => serve::run(arguments),
        Command::Mcp(arguments) => mcp::run(arguments),
        Command::Robot(command) => robot::run(command),
        Command::Export(arguments) => export::run(arguments),
        Command::Solve(arguments) => solve::run(arguments),
        Command::See(arguments) => see::run(arguments),
        Command::Compose(arguments) => compose::run(arguments),
        Command::Eval(arguments) => eval::run(arguments),
        Command::Domain(command) => domain::run(command),
        Command::Model(command) => model::run(command),
        Command::Schema { name } => schema::run(name.as_deref()),
    }
}
