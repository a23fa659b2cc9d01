//! Runs in batches, for a program that plays the robot and the person and judges what happens; `tools/peers/simulate_runs.py`
//! does.
//!
//! Reads one JSON object a line from standard input and writes one a line to standard output. A run begins with a command:
//!
//! - `{"begin": {"domain", "environment", "plan", "goal", "rules", "settings", "robot", "direct"}}`: the plan file `plan` as a
//!   text, a `goal` and `rules` in the goal language, the `settings` of an execution, and the `robot` as a description.
//! - `{"resume": {"domain", "log", "approval", "trust", "robot", "direct"}}`: the lines of a `log`; the last one may be torn.
//!
//! A refused command is answered with `{"refused": {"code", "why"}}`. Otherwise each question of the run is one line, which has to be
//! answered with one line: `record`, `start`, `poll`, `observe`, `stop`, `approve`, `judge`, `confirm`. With `direct` the execution is not driven
//! by `longstep_robot::drive`: its needs are questions, and any call of its interface is an answer. An answer `{"crash": true}` drops
//! the run as if the program were killed; `"signal": true` in an answer requests a stop. The last line of a run is
//! `{"ended": {"stop", "why", "resumable"}}` or `{"crashed": true}`.
#![allow(clippy::print_stdout, clippy::panic)]

mod direct;
mod driven;
mod pipe;
mod run;

use std::error::Error;

use pipe::{Crash, Pipe};
use serde_json::json;

/// Any error: it ends the process, or refuses a run.
pub(crate) type Anyhow<T> = Result<T, Box<dyn Error>>;

fn main() -> Anyhow<()> {
    let pipe = Pipe;
    let mut domains = run::Domains::default();
    while let Some(command) = pipe.read()? {
        let run = std::panic::AssertUnwindSafe(|| run::run(&pipe, &mut domains, &command));
        match std::panic::catch_unwind(run) {
            Ok(Ok(end)) => pipe.write(&end)?,
            Ok(Err(error)) => pipe.write(&json!({"refused": {"code": 30, "why": error.to_string()}}))?,
            Err(payload) if payload.is::<Crash>() => pipe.write(&json!({"crashed": true}))?,
            Err(payload) => {
                let why = payload.downcast_ref::<String>().map_or("a panic", String::as_str);
                pipe.write(&json!({"panicked": why}))?;
            }
        }
    }
    Ok(())
}
