//! The context of a loaded model: the tokens it has computed and the logits of the next one.

use std::num::NonZeroU32;
use std::sync::OnceLock;

use llama_cpp_2::context::LlamaContext;
use llama_cpp_2::context::params::LlamaContextParams;
use llama_cpp_2::llama_backend::LlamaBackend;
use llama_cpp_2::llama_batch::LlamaBatch;
use llama_cpp_2::model::{LlamaLoraAdapter, LlamaModel};
use llama_cpp_2::token::LlamaToken;

use super::blocks::{self, Blocks};

/// The only sequence in the context.
pub(super) const SEQUENCE: i32 = 0;

/// The llama.cpp backend, started once for the process, with its log off.
pub(super) fn backend() -> Result<&'static LlamaBackend, String> {
    static BACKEND: OnceLock<Result<LlamaBackend, String>> = OnceLock::new();
    BACKEND
        .get_or_init(|| {
            let mut backend = LlamaBackend::init().map_err(|error| error.to_string())?;
            // The log of the library for pictures goes nowhere, unless the program has a subscriber for it.
            #[cfg(feature = "vision")]
            llama_cpp_2::send_logs_to_tracing(llama_cpp_2::LogOptions::default());
            backend.void_logs();
            Ok(backend)
        })
        .as_ref()
        .map_err(Clone::clone)
}

/// A context of a model, and the tokens whose computation it holds.
pub(super) struct Engine<'model> {
    context: LlamaContext<'model>,
    /// Maximum number of tokens that are computed together.
    batch: usize,
    /// The tokens in the cache, from position 0 on, up to the first picture.
    tokens: Vec<LlamaToken>,
    /// Number of positions of the first picture and everything behind it, which are never reused.
    beyond: usize,
    /// The ends of the blocks in which the prompt's tokens were computed. The tokens behind them were generated.
    ends: Vec<usize>,
    /// Index of the newest token in the last batch; its logits are those of the next token.
    newest: i32,
}

impl<'model> Engine<'model> {
    /// A context for `size` tokens, of which at least `together` can be computed together.
    pub(super) fn new(model: &'model LlamaModel, size: u32, threads: usize, together: usize) -> Result<Self, String> {
        let threads = i32::try_from(threads).unwrap_or(i32::MAX);
        let batch = together.next_multiple_of(blocks::LARGE).max(blocks::LARGE);
        let tokens = u32::try_from(batch).map_err(|error| error.to_string())?;
        let parameters = LlamaContextParams::default()
            .with_n_ctx(NonZeroU32::new(size))
            .with_n_batch(tokens)
            .with_n_ubatch(tokens)
            .with_n_seq_max(1)
            .with_n_threads(threads)
            .with_n_threads_batch(threads)
            // Prefixes of every length must be reusable, also with sliding-window attention.
            .with_swa_full(true)
            .with_kv_unified(true)
            // On processors flash attention is fast only for batches of 64 tokens. Without it, generating a token takes
            // two thirds of the time, and reading a prompt takes no longer.
            .with_flash_attention_policy(0);
        let context = model
            .new_context(backend()?, parameters)
            .map_err(|error| format!("cannot create a context of {size} tokens: {error}"))?;
        Ok(Self {
            context,
            batch,
            tokens: Vec::new(),
            beyond: 0,
            ends: Vec::new(),
            newest: 0,
        })
    }

    /// Makes an adapter part of the computation, or no longer, and empties the cache.
    pub(super) fn adapt(&mut self, adapter: &mut LlamaLoraAdapter, is_on: bool) -> Result<(), String> {
        self.forget();
        if is_on {
            let set = self.context.lora_adapter_set(adapter, 1.0);
            set.map_err(|error| error.to_string())
        } else {
            let removed = self.context.lora_adapter_remove(adapter);
            removed.map_err(|error| error.to_string())
        }
    }

    /// True if the cache is empty.
    pub(super) fn is_empty(&self) -> bool {
        self.tokens.is_empty() && self.beyond == 0
    }

    /// The number of tokens in the cache.
    pub(super) fn length(&self) -> usize {
        self.tokens.len()
    }

    /// The length of the common prefix of these tokens and the cache.
    pub(super) fn known(&self, tokens: &[LlamaToken]) -> usize {
        let pairs = self.tokens.iter().zip(tokens);
        pairs.take_while(|(ours, theirs)| ours == theirs).count()
    }

    /// Removes all but the first `keep` tokens from the cache. Returns how many remain: none for models whose memory
    /// cannot be cut.
    pub(super) fn keep(&mut self, keep: usize) -> usize {
        if keep < self.tokens.len() || self.beyond > 0 {
            let from = u32::try_from(keep).ok();
            let cut = self.context.clear_kv_cache_seq(Some(SEQUENCE as u32), from, None);
            if matches!(cut, Ok(true)) {
                self.beyond = 0;
                self.tokens.truncate(keep);
                self.ends.retain(|end| *end <= keep);
            } else {
                self.forget();
            }
        }
        self.tokens.len()
    }

    /// Empties the cache.
    pub(super) fn forget(&mut self) {
        self.context.clear_kv_cache();
        self.beyond = 0;
        self.tokens.clear();
        self.ends.clear();
    }

    /// Keeps what the cache has of a prompt, in whole blocks, and forgets the rest. Returns how many tokens that is.
    pub(super) fn begin(&mut self, tokens: &[LlamaToken], blocks: &Blocks) -> usize {
        let known = blocks.reusable(&self.ends, self.known(tokens));
        self.keep(known)
    }

    /// Computes the blocks of a prompt that are not in the cache, of its first `until` tokens. `read` receives the number of
    /// tokens done so far, and stops the computation by returning `false`.
    pub(super) fn read(
        &mut self,
        tokens: &[LlamaToken],
        blocks: &Blocks,
        until: usize,
        read: &mut dyn FnMut(usize) -> bool,
    ) -> Result<(), String> {
        while let Some(end) = blocks.next(self.tokens.len()).filter(|end| *end <= until) {
            let start = self.tokens.len();
            if !read(start) {
                return Err("it was stopped".into());
            }
            self.compute(tokens.get(start..end).unwrap_or_default(), false)?;
            self.ends.push(end);
        }
        Ok(())
    }

    /// Computes tokens that the model has generated. `tell` receives each of them but the first with the logits at its place.
    pub(super) fn append(
        &mut self,
        tokens: &[LlamaToken],
        tell: &mut dyn FnMut(LlamaToken, &[f32]),
    ) -> Result<(), String> {
        for part in tokens.chunks(blocks::LARGE) {
            self.compute(part, true)?;
            for (place, token) in part.iter().enumerate().skip(1) {
                let before = i32::try_from(place - 1).map_err(|error| error.to_string())?;
                tell(*token, self.context.get_logits_ith(before));
            }
        }
        Ok(())
    }

    /// Computes tokens of a prompt behind a picture. They are not reused for another prompt.
    pub(super) fn read_on(&mut self, tokens: &[LlamaToken]) -> Result<(), String> {
        let parts = tokens.chunks(blocks::LARGE);
        parts.into_iter().try_for_each(|part| self.compute(part, false))
    }

    /// Computes a picture behind the tokens so far. `evaluate` receives the context, the position of the picture and the
    /// maximum number of tokens that are computed together; it returns the position behind the picture.
    #[cfg(feature = "vision")]
    pub(super) fn see(
        &mut self,
        evaluate: impl FnOnce(&mut LlamaContext<'model>, i32, i32) -> Result<i32, String>,
    ) -> Result<(), String> {
        let position = i32::try_from(self.position()).map_err(|error| error.to_string())?;
        let batch = i32::try_from(self.batch).map_err(|error| error.to_string())?;
        let end = evaluate(&mut self.context, position, batch);
        let end = end.and_then(|end| usize::try_from(end).map_err(|error| error.to_string()));
        match end {
            Ok(end) if end > self.position() => {
                self.beyond = end - self.tokens.len();
                Ok(())
            }
            Ok(_) => {
                self.forget();
                Err("the picture has no tokens".into())
            }
            Err(reason) => {
                self.forget();
                Err(reason)
            }
        }
    }

    /// Returns the maximum number of tokens that are computed together.
    pub(super) fn batch(&self) -> usize {
        self.batch
    }

    /// Computes tokens; with the logits at all their places, or at the last one.
    fn compute(&mut self, part: &[LlamaToken], all: bool) -> Result<(), String> {
        let mut batch = LlamaBatch::new(part.len(), 1);
        let start = self.position();
        for (index, token) in part.iter().enumerate() {
            let position = i32::try_from(start + index).map_err(|error| error.to_string())?;
            let wanted = all || index + 1 == part.len();
            batch
                .add(*token, position, &[SEQUENCE], wanted)
                .map_err(|error| error.to_string())?;
        }
        if let Err(error) = self.context.decode(&mut batch) {
            self.forget();
            return Err(error.to_string());
        }
        match self.beyond {
            0 => self.tokens.extend_from_slice(part),
            _ => self.beyond += part.len(),
        }
        self.newest = i32::try_from(part.len()).map_or(0, |length| length - 1);
        Ok(())
    }

    /// Returns the position of the next token.
    fn position(&self) -> usize {
        self.tokens.len() + self.beyond
    }

    /// The logits of the next token, for the whole vocabulary. Valid only after a computation.
    pub(super) fn logits(&self) -> &[f32] {
        self.context.get_logits_ith(self.newest)
    }

    /// The context and the tokens in its cache, for saving.
    pub(super) fn saved(&self) -> (&LlamaContext<'model>, &[LlamaToken]) {
        (&self.context, &self.tokens)
    }

    /// Empties the context and lets `load` restore the saved state of a prompt without its last line. `load` returns the
    /// tokens, or `None` if there is no valid state.
    pub(super) fn restore(
        &mut self,
        fixed: usize,
        load: impl FnOnce(&mut LlamaContext<'model>) -> Option<Vec<LlamaToken>>,
    ) {
        self.forget();
        match load(&mut self.context) {
            Some(tokens) => {
                self.ends = Blocks::of(tokens.len(), fixed, tokens.len()).into_ends();
                self.tokens = tokens;
            }
            None => self.forget(),
        }
    }
}
