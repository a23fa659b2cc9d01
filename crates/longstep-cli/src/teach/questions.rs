//! A lesson at the terminal: one step after the other is asked for, until its demonstration can be used.

use std::io::{BufRead, Read};
use std::path::Path;

use anyhow::Result;
use longstep_teach::{Demonstration, Expectations, Finding, Lesson, Request, Segment, learn};

use super::{recording, show_step, tell};
use crate::failure::tell as tell_error;
use crate::output::{Style, remark};

/// Limit for one answer, in bytes.
const LINE_LIMIT: u64 = 16 << 10;

/// The answer to a question for a demonstration.
enum Shown {
    File(String),
    Back,
    Skip,
    Quit,
}

/// Asks for the demonstration of each step. The questions go to stderr, one answer a line.
pub(super) fn lesson(requests: &[Request], expectations: &Expectations) -> Result<Lesson> {
    let steps: Vec<&Request> = requests
        .iter()
        .filter(|request| !request.parameters.is_empty())
        .collect();
    remark!("Show one step after the other. Answer with the file of its recording, or `back`, `skip` or `quit`.");
    let mut segments: Vec<Segment> = Vec::new();
    let mut next = 0;
    while let Some(request) = steps.get(next) {
        let question = format!("Show step {}: {}", request.number(), request.sentence);
        remark!("{}", question.bold());
        match answer()? {
            Shown::Quit => break,
            Shown::Skip => next += 1,
            Shown::Back => next = next.saturating_sub(1),
            Shown::File(file) => match recording(Path::new(&file)) {
                Ok(recording) if is_kept(requests, request, &mut segments, &recording, expectations)? => next += 1,
                Ok(_) => remark!("Show step {} again.", request.number()),
                Err(error) => {
                    tell_error(&error);
                }
            },
        }
    }
    Ok(learn(requests, &segments, expectations))
}

/// Adds a recording as the segment of a step, and shows its values and findings. Returns false, and takes it back, if a
/// value is missing, or the person does not keep what is doubtful.
fn is_kept(
    requests: &[Request],
    request: &Request,
    segments: &mut Vec<Segment>,
    recording: &Demonstration,
    expectations: &Expectations,
) -> Result<bool> {
    let before = segments.clone();
    segments.retain(|own| own.step != request.number());
    segments.push(Segment {
        step: request.number(),
        source: recording.source.clone(),
        reference: recording.reference.clone(),
        frames: recording.frames.clone(),
    });
    let lesson = learn(requests, segments, expectations);
    if let Some(step) = lesson.steps.iter().find(|own| own.step == request.number()) {
        show_step(requests, step);
    }
    let findings: Vec<&Finding> = lesson
        .findings
        .iter()
        .filter(|own| own.step == Some(request.number()))
        .collect();
    findings.iter().for_each(|finding| tell(finding));
    let kept = match (findings.is_empty(), findings.iter().all(|finding| finding.is_doubt())) {
        (true, _) => true,
        (false, true) => is_yes("Keep it? [y/n]")?,
        (false, false) => false,
    };
    if !kept {
        *segments = before;
    }
    Ok(kept)
}

fn answer() -> Result<Shown> {
    loop {
        let Some(line) = line()? else { return Ok(Shown::Quit) };
        match line.trim() {
            "" => remark!("Answer with a file, or `back`, `skip` or `quit`."),
            "back" => return Ok(Shown::Back),
            "skip" => return Ok(Shown::Skip),
            "quit" => return Ok(Shown::Quit),
            file => return Ok(Shown::File(file.to_owned())),
        }
    }
}

/// Asks until the answer is yes or no; the end of the input is no.
fn is_yes(question: &str) -> Result<bool> {
    remark!("{question}");
    loop {
        let Some(line) = line()? else { return Ok(false) };
        if let Some(decision) = crate::run::decision(&line) {
            return Ok(decision);
        }
    }
}

/// Returns the next line of the input; none at its end.
fn line() -> Result<Option<String>> {
    let mut line = String::new();
    let read = std::io::stdin().lock().take(LINE_LIMIT).read_line(&mut line)?;
    Ok((read > 0).then_some(line))
}
