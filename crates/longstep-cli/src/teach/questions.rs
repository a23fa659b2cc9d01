//! A lesson at the terminal: one step after the other is asked for, until its demonstration can be used.

use std::path::Path;
use std::time::Duration;

use anyhow::Result;
use longstep_teach::{Expectations, Finding, Lesson, Request, Segment, learn};

use super::recorder::{Recorded, StepRecorder};
use super::recording::Recording;
use super::{notes_of, recording, show_note, show_step, tell};
use crate::exit_code::STOPPED;
use crate::failure::{Failure, tell as tell_error};
use crate::input_lines::{InputLines, Waited};
use crate::output::{Style, remark};

/// Limit for one answer, in bytes.
const LINE_LIMIT: u64 = 16 << 10;
/// The time between two looks for an answer, if nothing else is to be looked at.
const LOOK: Duration = Duration::from_secs(60);

/// The answer to a question for a demonstration.
enum Answer {
    Enter,
    File(String),
    Back,
    Skip,
    Quit,
}

impl Answer {
    /// Reads an answer; none at the end of the input ends the lesson.
    fn of(line: Option<&str>) -> Self {
        match line.map(str::trim) {
            Some("") => Self::Enter,
            Some("back") => Self::Back,
            Some("skip") => Self::Skip,
            Some("quit") | None => Self::Quit,
            Some(file) => Self::File(file.to_owned()),
        }
    }
}

/// The result of a question for a demonstration.
enum Shown {
    Recording(Recording),
    /// There is no recording; the reason was shown.
    Nothing,
    Back,
    Skip,
    Quit,
}

/// A lesson with a person at the terminal. The questions go to stderr, one answer a line.
pub(super) struct Questions<'a> {
    requests: &'a [Request],
    expectations: &'a Expectations,
    recorder: Option<StepRecorder>,
    input: InputLines,
    segments: Vec<Segment>,
}

impl<'a> Questions<'a> {
    pub(super) fn new(requests: &'a [Request], expectations: &'a Expectations, recorder: Option<StepRecorder>) -> Self {
        Self {
            requests,
            expectations,
            recorder,
            input: InputLines::new(LINE_LIMIT),
            segments: Vec::new(),
        }
    }

    /// Asks for the demonstration of each step. Also returns how the lesson is repeated, if it was recorded.
    pub(super) fn lesson(mut self) -> Result<(Lesson, Option<String>)> {
        let steps: Vec<&Request> = self
            .requests
            .iter()
            .filter(|request| !request.parameters.is_empty())
            .collect();
        match &self.recorder {
            Some(recorder) => remark!(
                "Show one step after the other. Enter starts `{}`. Or answer with the file of a recording, `back`, `skip` or \
                 `quit`.",
                recorder.command()
            ),
            None => remark!(
                "Show one step after the other. Answer with the file of its recording, or `back`, `skip` or `quit`."
            ),
        }
        let mut next = 0;
        while let Some(request) = steps.get(next) {
            let question = format!("Show step {}: {}", request.number(), request.sentence);
            remark!("{}", question.bold());
            match self.shown(request)? {
                Shown::Quit => break,
                Shown::Skip => next += 1,
                Shown::Back => next = next.saturating_sub(1),
                Shown::Nothing => {}
                Shown::Recording(recording) => {
                    if self.is_kept(request, &recording)? {
                        next += 1
                    } else {
                        remark!("Show step {} again.", request.number())
                    }
                }
            }
        }
        let lesson = learn(self.requests, &self.segments, self.expectations);
        Ok((lesson, self.repetition(&steps)))
    }

    /// Asks for the recording of a step, or makes it.
    fn shown(&mut self, request: &Request) -> Result<Shown> {
        let mut answer = self.answer()?;
        loop {
            let recorded = match (answer, &self.recorder) {
                (Answer::Quit, _) => return Ok(Shown::Quit),
                (Answer::Skip, _) => return Ok(Shown::Skip),
                (Answer::Back, _) => return Ok(Shown::Back),
                (Answer::File(file), _) => recording(Path::new(&file), self.expectations.hand).map(|demonstration| {
                    notes_of(&demonstration).for_each(|note| show_note(&note));
                    Recorded::Shown(Recording {
                        demonstration,
                        unsaved: None,
                    })
                }),
                (Answer::Enter, Some(recorder)) => recorder.record(request.number(), &mut self.input),
                (Answer::Enter, None) => {
                    remark!("Answer with a file, or `back`, `skip` or `quit`.");
                    answer = self.answer()?;
                    continue;
                }
            };
            match recorded {
                Ok(Recorded::Shown(recording)) => return Ok(Shown::Recording(recording)),
                Ok(Recorded::Answer(line)) => answer = Answer::of(line.as_deref()),
                Ok(Recorded::Stopped) => {
                    return Err(Failure::new("stopped by a signal", STOPPED)
                        .hint("the recordings of the steps before are saved; answer with their files next time")
                        .into());
                }
                Err(error) => {
                    tell_error(&error);
                    return Ok(Shown::Nothing);
                }
            }
        }
    }

    /// Adds a recording as the segment of a step, saves it, and shows its values and findings. Returns false, and takes it
    /// back, if a value is missing, or the person does not keep what is doubtful.
    fn is_kept(&mut self, request: &Request, recording: &Recording) -> Result<bool> {
        let before = self.segments.clone();
        let shown = &recording.demonstration;
        self.segments.retain(|own| own.step != request.number());
        self.segments.push(Segment::whole(shown, request.number()));
        let lesson = learn(self.requests, &self.segments, self.expectations);
        if let Some(step) = lesson.steps.iter().find(|own| own.step == request.number()) {
            show_step(self.requests, step);
        }
        let findings: Vec<&Finding> = lesson
            .findings
            .iter()
            .filter(|own| own.step == Some(request.number()))
            .collect();
        findings.iter().for_each(|finding| tell(finding));
        let mut kept = match (findings.is_empty(), findings.iter().all(|finding| finding.is_doubt())) {
            (true, _) => true,
            (false, true) => self.is_yes("Keep it? [y/n]")?,
            (false, false) => false,
        };
        if kept && let Err(error) = recording.save() {
            tell_error(&error);
            kept = false;
        }
        if !kept {
            self.segments = before;
        }
        Ok(kept)
    }

    fn answer(&mut self) -> Result<Answer> {
        if self.recorder.is_some() {
            remark!("Press Enter to begin.");
        }
        Ok(Answer::of(self.line()?.as_deref()))
    }

    /// Asks until the answer is yes or no; the end of the input is no.
    fn is_yes(&mut self, question: &str) -> Result<bool> {
        remark!("{question}");
        loop {
            let Some(line) = self.line()? else { return Ok(false) };
            if let Some(decision) = crate::run::Question::Fact(question).decision(&line) {
                return Ok(decision);
            }
        }
    }

    /// Returns the next line of the input; none at its end.
    fn line(&mut self) -> Result<Option<String>> {
        loop {
            match self.input.wait(LOOK)? {
                Waited::Line(line) => return Ok(Some(line)),
                Waited::Ended => return Ok(None),
                Waited::Nothing => {}
            }
        }
    }

    /// Returns how the lesson is repeated, if it was recorded and has every step.
    fn repetition(&self, steps: &[&Request]) -> Option<String> {
        let own = |request: &&Request| self.segments.iter().find(|own| own.step == request.number());
        let segments: Option<Vec<&Segment>> = steps.iter().map(own).collect();
        Some(self.recorder.as_ref()?.repetition(&segments?))
    }
}
