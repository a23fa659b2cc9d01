//! Questions to the person at the terminal, and answers from a pipe.

use std::io::{BufRead, Read};

use anyhow::Result;

use crate::failure::Failure;
use crate::output::{Style, remark};

/// Limit for one answer, in bytes.
const LINE_LIMIT: u64 = 16 << 10;

/// Asks one question; none at the end of the input.
pub(crate) fn ask(question: &str, default: &str) -> Result<Option<String>> {
    match default {
        "" => remark!("{}", question.bold()),
        default => remark!("{} [{default}]", question.bold()),
    }
    let mut line = String::new();
    let mut input = std::io::stdin().lock().take(LINE_LIMIT);
    let read = input
        .read_line(&mut line)
        .map_err(|_| Failure::unreadable("the answer is not text").hint("write answers in UTF-8"))?;
    if read as u64 == LINE_LIMIT {
        let failure = Failure::unreadable(format!("an answer is longer than {LINE_LIMIT} bytes"));
        return Err(failure.hint("write one line for each answer").into());
    }
    let answer = line.trim();
    Ok(match (read, answer) {
        (0, _) => None,
        (_, "") => Some(default.to_owned()),
        (_, answer) => Some(answer.to_owned()),
    })
}
