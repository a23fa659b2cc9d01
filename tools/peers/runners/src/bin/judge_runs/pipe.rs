//! The lines of JSON on standard input and output.

use std::io::{BufRead, Write};

use longstep_robot::StopRequest;
use serde_json::Value;

use crate::Anyhow;

/// The payload of the unwinding that stands for the death of the program.
pub(crate) struct Crash;

/// Questions on standard output, answers on standard input.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pipe;

impl Pipe {
    /// Reads a line; none at the end of the input.
    pub(crate) fn read(self) -> Anyhow<Option<Value>> {
        let mut line = String::new();
        match std::io::stdin().lock().read_line(&mut line)? {
            0 => Ok(None),
            _ => Ok(Some(serde_json::from_str(&line)?)),
        }
    }

    /// Writes a line.
    pub(crate) fn write(self, value: &Value) -> Anyhow<()> {
        let mut out = std::io::stdout().lock();
        writeln!(out, "{value}")?;
        out.flush()?;
        Ok(())
    }

    /// Writes a question and returns its answer. Unwinds if the answer is a crash, or if nobody answers any more.
    pub(crate) fn ask(self, question: &Value, request: &StopRequest) -> Value {
        let answer = self.write(question).and_then(|()| self.read());
        let Ok(Some(answer)) = answer else {
            std::panic::resume_unwind(Box::new(Crash));
        };
        if answer["crash"] == true {
            std::panic::resume_unwind(Box::new(Crash));
        }
        if answer["signal"] == true {
            request.stop();
        }
        answer
    }
}
