//! Recording and replay: a model's requests and replies, written to a file and answered from it.
//!
//! A recording is JSON Lines: first a description of the model (name, kind of constraint, counting of tokens), then
//! each request with its reply, and the tokens of each counted message. It contains no keys.

mod difference;
mod line;
mod replay;

use std::collections::HashSet;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use longstep::dialogue::{ChatRequest, ConstraintKind, Counting, Message, Reply, TokenCounter};

use crate::wire::{WireHead, WireRequest};
use crate::{ChatModel, ModelError, Watch};
use line::{Line, WireCount};
use longstep_files::append;
pub(crate) use replay::Replay;

/// A model whose requests and replies are appended to a file. Its answers are those of the wrapped model.
pub struct Recording {
    model: Box<dyn ChatModel>,
    path: PathBuf,
    file: File,
    /// True if the file already has its first line.
    headed: bool,
    counted: HashSet<Message>,
    framed: bool,
    /// A write that failed while tokens were counted; the next request returns it.
    failed: Option<ModelError>,
}

impl Recording {
    /// Records `model` at the end of the file. A new file gets mode 600.
    ///
    /// # Errors
    ///
    /// [`ModelError::File`] if the file cannot be opened for writing.
    pub fn new(model: Box<dyn ChatModel>, path: &Path) -> Result<Self, ModelError> {
        let fail = || ModelError::file("cannot record to", path);
        let file = append(path).map_err(fail())?;
        let headed = file.metadata().map_err(fail())?.len() > 0;
        Ok(Self {
            model,
            path: path.to_path_buf(),
            file,
            headed,
            counted: HashSet::new(),
            framed: false,
            failed: None,
        })
    }

    /// Appends a line with a single write: another process may record to the file, too.
    fn write(&mut self, line: &Line) -> Result<(), ModelError> {
        let mut text = String::new();
        if !self.headed {
            // Not earlier: some models know their way of counting only after the first count.
            let head = WireHead::of(self.model.as_ref());
            text = self.text(&Line::Recording(head))?;
        }
        text += &self.text(line)?;
        let written = self.file.write_all(text.as_bytes());
        written.map_err(ModelError::file("cannot record to", &self.path))?;
        self.headed = true;
        Ok(())
    }

    fn text(&self, line: &Line) -> Result<String, ModelError> {
        let text = serde_json::to_string(line).map_err(std::io::Error::from);
        Ok(text.map_err(ModelError::file("cannot record to", &self.path))? + "\n")
    }

    fn note(&mut self, line: &Line) {
        if let Err(error) = self.write(line) {
            self.failed.get_or_insert(error);
        }
    }
}

impl std::fmt::Debug for Recording {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut shown = formatter.debug_struct("Recording");
        shown
            .field("model", &self.model.name())
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl ChatModel for Recording {
    fn name(&self) -> &str {
        self.model.name()
    }

    fn constraint_kind(&self) -> ConstraintKind {
        self.model.constraint_kind()
    }

    /// # Errors
    ///
    /// The errors of the model, and [`ModelError::File`] when the reply cannot be written.
    fn chat(&mut self, request: &ChatRequest, watch: &mut dyn Watch) -> Result<Reply, ModelError> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        let reply = self.model.chat(request, watch)?;
        self.write(&Line::Turn {
            request: WireRequest::of(request),
            reply: (&reply).into(),
        })?;
        Ok(reply)
    }

    fn context_tokens(&self) -> Option<u64> {
        self.model.context_tokens()
    }
}

impl TokenCounter for Recording {
    fn message_tokens(&mut self, message: &Message) -> u64 {
        let tokens = self.model.message_tokens(message);
        if self.counted.insert(message.clone()) {
            self.note(&Line::Count(WireCount {
                message: message.into(),
                tokens,
            }));
        }
        tokens
    }

    fn frame_tokens(&mut self) -> u64 {
        let tokens = self.model.frame_tokens();
        if !self.framed {
            self.framed = true;
            self.note(&Line::Frame(tokens));
        }
        tokens
    }

    fn counting(&self) -> Counting {
        self.model.counting()
    }
}

#[cfg(test)]
mod tests;
