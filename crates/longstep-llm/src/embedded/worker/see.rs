//! Requests with pictures.

use longstep::dialogue::Message;

use super::{Tell, Worker};
use crate::embedded::prompt::PromptTokens;
use crate::embedded::vision::PictureTokens;
use crate::{ModelError, Progress};

impl Worker<'_> {
    /// Returns the pictures of messages as tokens, in their order.
    pub(super) fn pictures(&self, messages: &[Message]) -> Result<Vec<PictureTokens>, ModelError> {
        let pictures: Vec<_> = messages.iter().flat_map(|message| &message.pictures).collect();
        let Some(vision) = &self.vision else {
            return if pictures.is_empty() {
                Ok(Vec::new())
            } else {
                Err(ModelError::no_vision(self.name))
            };
        };
        let total = pictures.len();
        let numbered = pictures.into_iter().zip(1..);
        numbered
            .map(|(picture, number)| {
                let tokens = vision.tokens(picture);
                tokens.map_err(|reason| ModelError::BadPicture { number, total, reason })
            })
            .collect()
    }

    /// Computes a prompt with pictures; returns how many tokens before the first one came from the cache. A stop takes
    /// effect between two pictures, because the engine computes each as a whole.
    pub(super) fn see(
        &mut self,
        prompt: &PromptTokens,
        pictures: &[PictureTokens],
        total: usize,
        tell: &mut Tell<'_>,
    ) -> Result<usize, ModelError> {
        if prompt.pictures.last() == Some(&prompt.tokens.len()) {
            return Err(self.unsupported("its chat template ends with the picture".into()));
        }
        let largest = pictures.iter().map(PictureTokens::together).max().unwrap_or_default();
        let widened = self.contexts.widen(largest);
        widened.map_err(|reason| self.failed(reason))?;
        let mut done = prompt.pictures.first().copied().unwrap_or_default();
        let cached = self.read(prompt, done, total, tell)?;
        let ends = prompt.pictures.iter().copied().skip(1).chain([prompt.tokens.len()]);
        let texts = prompt.pictures.iter().copied().zip(ends);
        for (picture, (start, end)) in pictures.iter().zip(texts) {
            if !tell(Progress::ReadingPrompt { done, total }) {
                return Err(self.failed("it was stopped".into()));
            }
            let vision = self.vision.as_mut().ok_or_else(|| ModelError::no_vision(self.name))?;
            let text = prompt.tokens.get(start..end).unwrap_or_default();
            let engine = self.contexts.engine_mut();
            let seen = vision.see(picture, engine);
            let read = seen.and_then(|()| engine.read_on(text));
            read.map_err(|reason| self.failed(reason))?;
            done += picture.tokens() + text.len();
        }
        Ok(cached)
    }
}
