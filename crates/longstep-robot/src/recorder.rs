//! Recorders: programs that write the poses of a hand to their standard output, live, while a person shows a step.
//!
//! A recorder has no protocol: it is started when the step begins, and receives the signal of Ctrl-C (SIGINT) when the step
//! ends, and SIGTERM if it goes on after half of the time that it has for its end. Everything that it writes has a bound, and so has every wait for it. Whatever happens, the program and its children
//! are ended.
//!
//! 1. [`Recorder::start`] starts the program.
//! 2. [`Recorder::look`] reads what it wrote, again and again, until the step is shown.
//! 3. [`Recorder::finish`] ends it and returns the recording.

use std::time::{Duration, Instant};

use crate::program::{Child, CommandLine, Lines, TooLong, Watched};

/// The time between two looks at the state of a program that is ending.
const TICK: Duration = Duration::from_millis(20);

/// The time between the end of a program's output and its own end, after which its output counts as closed.
const CLOSED_LIMIT: Duration = Duration::from_millis(100);

/// The bounds of one recording.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct RecorderLimits {
    /// The longest time without a line.
    pub silence: Duration,
    /// The longest recording, from the start of the program on.
    pub duration: Duration,
    /// The longest time between the signal of Ctrl-C and the end of the program.
    pub ending: Duration,
    /// The most bytes of a recording.
    pub bytes: usize,
    /// The most bytes of a line.
    pub line: usize,
}

impl Default for RecorderLimits {
    fn default() -> Self {
        Self {
            silence: Duration::from_secs(30),
            duration: Duration::from_secs(600),
            ending: Duration::from_secs(5),
            bytes: 64 << 20,
            line: 64 << 10,
        }
    }
}

impl RecorderLimits {
    /// Sets the longest time without a line.
    #[must_use]
    pub fn with_silence(self, silence: Duration) -> Self {
        Self { silence, ..self }
    }

    /// Sets the longest recording.
    #[must_use]
    pub fn with_duration(self, duration: Duration) -> Self {
        Self { duration, ..self }
    }

    /// Sets the longest time between the signal of Ctrl-C and the end of the program.
    #[must_use]
    pub fn with_ending(self, ending: Duration) -> Self {
        Self { ending, ..self }
    }

    /// Sets the most bytes of a recording.
    #[must_use]
    pub fn with_bytes(self, bytes: usize) -> Self {
        Self { bytes, ..self }
    }

    /// Sets the most bytes of a line.
    #[must_use]
    pub fn with_line(self, line: usize) -> Self {
        Self { line, ..self }
    }
}

/// Reason why there is no recording. The program is ended.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RecorderError {
    /// The program cannot be started.
    #[error("cannot start the recorder `{command}`: {reason}")]
    NotStarted {
        /// The command line.
        command: String,
        /// The error of the operating system.
        reason: String,
    },
    /// The program ended, or closed its output, before it was to end.
    #[error("the recorder stopped before the step was shown: {reason}")]
    EndedEarly {
        /// How it ended.
        reason: String,
        /// The last lines that it wrote to its standard error; empty if there are none.
        messages: String,
    },
    /// The program wrote no line for too long.
    #[error("the recorder wrote nothing for {} s", .limit.as_secs_f64())]
    Silent {
        /// [`RecorderLimits::silence`].
        limit: Duration,
        /// The last lines that it wrote to its standard error; empty if there are none.
        messages: String,
    },
    /// The program wrote no complete line until its end.
    #[error("the recorder wrote nothing")]
    Empty {
        /// The last lines that it wrote to its standard error; empty if there are none.
        messages: String,
    },
    /// The recording is too long.
    #[error("the recording is longer than {} s", .limit.as_secs_f64())]
    TooLong {
        /// [`RecorderLimits::duration`].
        limit: Duration,
    },
    /// The recording is too large.
    #[error("the recording is larger than {limit} bytes")]
    TooLarge {
        /// [`RecorderLimits::bytes`].
        limit: usize,
    },
    /// A line is too long.
    #[error("the recorder wrote a line longer than {limit} bytes")]
    LongLine {
        /// [`RecorderLimits::line`].
        limit: usize,
    },
    /// The program went on after the signal of Ctrl-C, and after SIGTERM.
    #[error("the recorder did not end within {} s after Ctrl-C (SIGINT) and SIGTERM; it was killed with its children", .limit.as_secs_f64())]
    NotEnded {
        /// [`RecorderLimits::ending`].
        limit: Duration,
    },
}

impl RecorderError {
    /// Returns the last lines that the program wrote to its standard error; empty if there are none.
    pub fn messages(&self) -> &str {
        match self {
            Self::EndedEarly { messages, .. } | Self::Silent { messages, .. } | Self::Empty { messages } => messages,
            _ => "",
        }
    }

    /// Returns the next step for the user.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::NotStarted { .. } => "check the command of the recorder",
            Self::EndedEarly { .. } => "a recorder writes frames until it receives Ctrl-C (SIGINT)",
            Self::Silent { .. } | Self::Empty { .. } => {
                "a recorder writes each frame to its standard output at once; check its camera and that it flushes"
            }
            Self::TooLong { .. } => "end the recording when the step is shown",
            Self::TooLarge { .. } | Self::LongLine { .. } => {
                "a recorder writes nothing but frames to its standard output, one a line"
            }
            Self::NotEnded { .. } => "let the recorder end on Ctrl-C (SIGINT)",
        }
    }
}

/// A recorder that runs. Dropping it ends it with its children.
///
/// ```no_run
/// use std::time::Duration;
/// use longstep_robot::CommandLine;
/// use longstep_robot::recorder::{Recorder, RecorderLimits};
///
/// let command = CommandLine::parse("python3 tracker.py")?;
/// let mut recorder = Recorder::start(&command, RecorderLimits::default())?;
/// for _ in 0..100 {
///     recorder.wait(Duration::from_millis(20));
///     recorder.look()?;
/// }
/// let recording = recorder.finish()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Recorder {
    child: Child,
    watched: Watched,
    limits: RecorderLimits,
    lines: Lines,
    /// The complete lines.
    recording: Vec<u8>,
    count: usize,
    begun: Instant,
    /// The time of the last line.
    heard: Instant,
    /// The time at which the output ended.
    closed: Option<Instant>,
}

impl Recorder {
    /// Starts a recorder.
    ///
    /// # Errors
    ///
    /// [`RecorderError::NotStarted`].
    pub fn start(command: &CommandLine, limits: RecorderLimits) -> Result<Self, RecorderError> {
        let failed = |error: std::io::Error| RecorderError::NotStarted {
            command: command.to_string(),
            reason: error.to_string(),
        };
        let (mut child, watched) = Child::spawn(command, None).map_err(failed)?;
        child.guard(limits.ending).map_err(failed)?;
        let now = Instant::now();
        Ok(Self {
            child,
            watched,
            limits,
            lines: Lines::default(),
            recording: Vec::new(),
            count: 0,
            begun: now,
            heard: now,
            closed: None,
        })
    }

    /// Waits until the recorder writes, or the time is over.
    pub fn wait(&self, limit: Duration) {
        self.watched.wait(limit);
    }

    /// Reads what the recorder wrote until now, without waiting. Returns the number of lines so far, empty ones left out.
    ///
    /// # Errors
    ///
    /// The recorder ended or closed its output, is silent for too long, or exceeds a bound.
    pub fn look(&mut self) -> Result<usize, RecorderError> {
        let now = Instant::now();
        // Before the reading, so that nothing is written after the last read.
        let has_ended = self.child.exit().is_some();
        let before = self.count;
        self.read(now)?;
        if self.count > before {
            self.heard = now;
        }
        let is_closed = self
            .closed
            .is_some_and(|closed| now.duration_since(closed) > CLOSED_LIMIT);
        if has_ended || is_closed {
            return Err(RecorderError::EndedEarly {
                reason: self.child.exit().unwrap_or("it closed its output").to_owned(),
                messages: self.child.messages(),
            });
        }
        if now.duration_since(self.heard) > self.limits.silence {
            return Err(RecorderError::Silent {
                limit: self.limits.silence,
                messages: self.child.messages(),
            });
        }
        if now.duration_since(self.begun) > self.limits.duration {
            let limit = self.limits.duration;
            return Err(RecorderError::TooLong { limit });
        }
        Ok(self.count)
    }

    /// Returns the complete lines so far.
    pub fn recording(&self) -> &[u8] {
        &self.recording
    }

    /// Ends the recorder with the signal of Ctrl-C, then with SIGTERM, and returns all its complete lines, also those that it writes after the
    /// signal. A line without an end is left out: it may be cut.
    ///
    /// # Errors
    ///
    /// The errors of [`Recorder::look`]; the recorder wrote no line; it did not end, and was killed.
    pub fn finish(mut self) -> Result<Vec<u8>, RecorderError> {
        self.look()?;
        self.child.close_input();
        self.child.interrupt();
        let limit = self.limits.ending;
        let interrupted = Instant::now();
        let mut is_terminated = false;
        while self.child.exit().is_none() {
            let now = Instant::now();
            let waited = now.duration_since(interrupted);
            if waited >= limit {
                return Err(RecorderError::NotEnded { limit });
            }
            if waited >= limit / 2 && !std::mem::replace(&mut is_terminated, true) {
                self.child.terminate();
            }
            self.watched.wait(TICK);
            self.read(now)?;
        }
        self.read(Instant::now())?;
        // Its children too: they are of no use without it.
        self.child.end();
        match self.count {
            0 => Err(RecorderError::Empty {
                messages: self.child.messages(),
            }),
            _ => Ok(self.recording),
        }
    }

    fn read(&mut self, now: Instant) -> Result<(), RecorderError> {
        self.child.read_messages();
        if self.closed.is_none() && !self.child.read(self.lines.buffer()) {
            self.closed = Some(now);
        }
        let limit = self.limits.line;
        while let Some(line) = self
            .lines
            .next(limit)
            .map_err(|TooLong| RecorderError::LongLine { limit })?
        {
            if self.recording.len() + line.len() >= self.limits.bytes {
                let limit = self.limits.bytes;
                return Err(RecorderError::TooLarge { limit });
            }
            self.count += usize::from(!line.trim_ascii().is_empty());
            self.recording.extend_from_slice(&line);
            self.recording.push(b'\n');
        }
        Ok(())
    }
}
