//! Programs that Longstep starts: their command line, their process group with its pipes, and the lines that they write.

mod child;
mod lines;

use std::fmt;
use std::path::PathBuf;
use std::process::Command;

use longstep_core::{secret, visible};

pub(crate) use child::{Child, Watched};
pub(crate) use lines::{Lines, TooLong};

/// A program with its arguments, folder and environment variables.
///
/// ```
/// use longstep_robot::CommandLine;
/// let line = CommandLine::parse("python3 'my tracker.py' --camera 1")?;
/// assert_eq!(line.to_string(), "python3 'my tracker.py' --camera 1");
/// # Ok::<(), longstep_robot::CommandLineError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CommandLine {
    /// The program and its arguments.
    words: Vec<String>,
    folder: Option<PathBuf>,
    variables: Vec<(String, String)>,
}

/// Reason why a text is no command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CommandLineError {
    /// A quote has no end, or nothing follows a backslash.
    #[error("a quote or a backslash at its end is not complete")]
    Incomplete,
    /// There are no words.
    #[error("it names no program")]
    Empty,
}

impl CommandLine {
    /// Reads a command line: words with the quotes of a shell, without variables and pipes.
    ///
    /// # Errors
    ///
    /// An empty command, and a quote that does not end.
    pub fn parse(text: &str) -> Result<Self, CommandLineError> {
        let words = shlex::split(text).ok_or(CommandLineError::Incomplete)?;
        if words.is_empty() {
            Err(CommandLineError::Empty)
        } else {
            Ok(Self::new(words))
        }
    }

    /// Returns the command with these words; the first is the program.
    pub fn new<W: Into<String>>(words: impl IntoIterator<Item = W>) -> Self {
        Self {
            words: words.into_iter().map(Into::into).collect(),
            folder: None,
            variables: Vec::new(),
        }
    }

    /// Runs the program in this folder.
    #[must_use]
    pub fn folder(mut self, folder: impl Into<PathBuf>) -> Self {
        self.folder = Some(folder.into());
        self
    }

    /// Sets an environment variable of the program.
    #[must_use]
    pub fn variable(mut self, name: impl Into<String>, value: impl Into<String>) -> Self {
        self.variables.push((name.into(), value.into()));
        self
    }

    /// Returns the program without its arguments.
    pub fn program(&self) -> &str {
        self.words.first().map_or("", String::as_str)
    }

    /// Returns a text that is the same for the same program with the same arguments in the same folder.
    pub(crate) fn key(&self) -> String {
        let folder = self.folder.clone().unwrap_or_default();
        let folder = std::path::absolute(&folder)
            .or_else(|_| std::env::current_dir())
            .unwrap_or(folder);
        format!("{}\0{}", self.words.join("\0"), folder.display())
    }

    fn command(&self) -> Command {
        let mut command = Command::new(self.program());
        command.args(self.words.iter().skip(1));
        command.envs(self.variables.iter().map(|(name, value)| (name, value)));
        if let Some(folder) = &self.folder {
            command.current_dir(folder);
        }
        command
    }
}

/// The words for a person, with quotes where they need them and without the passwords of addresses.
impl fmt::Display for CommandLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<_> = self
            .words
            .iter()
            .map(|word| shlex::try_quote(word).unwrap_or(word.into()))
            .collect();
        f.write_str(&secret::redacted(&visible::line(&words.join(" "))))
    }
}
