//! The recorder of a lesson: a program that is started for each step, and its recordings beside the skills file.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use longstep_robot::recorder::{Recorder, RecorderError, RecorderLimits};
use longstep_robot::{CommandLine, StopRequest};
use longstep_teach::{Demonstration, Format, ReadError, Segment};

use super::recording::Recording;
use crate::arguments::TeachArguments;
use crate::failure::Failure;
use crate::input_lines::{InputLines, Waited};
use crate::output::{Style, remark};
use crate::signals::{self, Armed};

/// The environment variable with the number of the step.
const STEP: &str = "LONGSTEP_STEP";
/// The time between two looks at the recorder, at the input and at signals.
const LOOK: Duration = Duration::from_millis(20);
/// The recorder in messages about its recording.
const SOURCE: &str = "the recorder";

/// The program that records each step.
pub(super) struct StepRecorder {
    command: CommandLine,
    limits: RecorderLimits,
    /// The skills file.
    output: PathBuf,
    /// Digits of a step's number in the names of files, so that names sort as steps do.
    digits: usize,
}

/// The end of a recording.
pub(super) enum Recorded {
    /// The step was shown.
    Shown(Recording),
    /// The person wrote something else than Enter, or the input ended: the recording is discarded.
    Answer(Option<String>),
    /// A signal stopped the lesson.
    Stopped,
}

impl StepRecorder {
    /// Returns the recorder that the arguments name; none if they name none.
    pub(super) fn of(arguments: &TeachArguments, steps: usize) -> Result<Option<Self>> {
        let Some(text) = &arguments.recorder else {
            return Ok(None);
        };
        let command = CommandLine::parse(text).map_err(|error| {
            Failure::unreadable(format!("--recorder `{text}`: {error}"))
                .hint("for example `--recorder \"python3 tracker.py\"`")
        })?;
        let defaults = RecorderLimits::default();
        let silence = arguments.silence.unwrap_or(defaults.silence);
        signals::stop_runs()?;
        Ok(Some(Self {
            command,
            limits: defaults.with_silence(silence),
            output: arguments.output.clone(),
            digits: steps.to_string().len(),
        }))
    }

    /// The command line, for a person.
    pub(super) fn command(&self) -> String {
        self.command.to_string()
    }

    /// Records a step, from the first frame until the person presses Enter.
    pub(super) fn record(&self, step: usize, input: &mut InputLines) -> Result<Recorded> {
        let request = StopRequest::default();
        let _armed = Armed::new(&request);
        remark!("Starting the recorder; wait for its first frame.");
        let command = self.command.clone().variable(STEP, step.to_string());
        let mut recorder = Recorder::start(&command, self.limits.clone()).map_err(failure)?;
        let mut has_begun = false;
        loop {
            let lines = recorder.look().map_err(failure)?;
            if !has_begun && begins(recorder.recording(), lines)? {
                has_begun = true;
                remark!(
                    "{} Show the step, then press Enter to end.",
                    "Recording.".green().bold()
                );
            }
            match input.wait(LOOK)? {
                _ if request.is_requested() => return Ok(Recorded::Stopped),
                Waited::Nothing => {}
                Waited::Ended => return Ok(Recorded::Answer(None)),
                Waited::Line(line) if line.trim().is_empty() => break,
                Waited::Line(line) => {
                    remark!("The recording is discarded.");
                    return Ok(Recorded::Answer(Some(line)));
                }
            }
        }
        let bytes = recorder.finish().map_err(failure)?;
        if request.is_requested() {
            return Ok(Recorded::Stopped);
        }
        let mut demonstration = read(&bytes)?;
        let (first, last) = demonstration.span().unwrap_or_default();
        remark!(
            "Recorded {} frames in {:.1} s.",
            demonstration.frames.len(),
            last - first
        );
        let path = self.path(step, Format::of_lines(&bytes));
        demonstration.source = path.display().to_string();
        Ok(Recorded::Shown(Recording {
            demonstration,
            unsaved: Some((path, bytes)),
        }))
    }

    /// The file of a step's recording, beside the skills file: `skills.step-3.csv`.
    fn path(&self, step: usize, format: Format) -> PathBuf {
        let stem = self.output.file_stem().unwrap_or_default().to_string_lossy();
        let (digits, ending) = (self.digits, format.ending());
        self.output
            .with_file_name(format!("{stem}.step-{step:0digits$}.{ending}"))
    }

    /// The advice how to repeat a lesson with these recordings.
    pub(super) fn repetition(&self, segments: &[&Segment]) -> String {
        let words = ["--demo"]
            .into_iter()
            .chain(segments.iter().map(|own| own.source.as_str()));
        format!(
            "`{}` in place of `--recorder` repeats the lesson",
            CommandLine::new(words)
        )
    }
}

/// Returns true if a recording has its first frame. So nobody shows a step while the recorder starts, or writes nonsense.
fn begins(recording: &[u8], lines: usize) -> Result<bool> {
    let header = usize::from(Format::of_lines(recording) == Format::Csv);
    if lines <= header {
        return Ok(false);
    }
    match Demonstration::read(SOURCE, Format::of_lines(recording), recording) {
        // The tracker does not see the hand yet.
        Err(error) if error.is_without_position => Ok(false),
        read => Ok(read.map(|_| true).map_err(unreadable)?),
    }
}

fn read(recording: &[u8]) -> Result<Demonstration> {
    Ok(Demonstration::read(SOURCE, Format::of_lines(recording), recording).map_err(unreadable)?)
}

fn unreadable(error: ReadError) -> Failure {
    Failure::unreadable(error.to_string()).hint(
        "a recorder writes CSV with a line of names, or JSON Lines, and nothing else; docs/guide/teaching.md lists the columns",
    )
}

/// Returns the failure for an error of a recorder, and shows what the program wrote about it.
fn failure(error: RecorderError) -> Failure {
    if !error.messages().is_empty() {
        remark!("The last messages of the recorder:");
        error.messages().lines().for_each(|line| remark!("  | {line}"));
    }
    Failure::unreadable(error.to_string()).hint(error.hint())
}
