//! The contexts of a model: how much of the last prompts stays computed.
//!
//! The requests of a session alternate between prompts and adapters: what an instruction means, then how its plan is to change. A
//! context holds one prompt, computed with one adapter. With a single one, each request would compute its scene again.

use llama_cpp_2::model::{LlamaLoraAdapter, LlamaModel};
use llama_cpp_2::token::LlamaToken;
use longstep::dialogue::Task;

use super::engine::Engine;
use super::state::States;

/// Maximum number of contexts. Two prompts alternate where people speak about plans; the third is for all others.
const MOST: usize = 3;

/// A loaded adapter.
pub(super) struct Adapted {
    pub(super) task: Task,
    pub(super) adapter: LlamaLoraAdapter,
    /// The states of the model with this adapter.
    pub(super) states: States,
}

/// The contexts of a model and its adapters.
pub(super) struct Contexts<'model> {
    model: &'model LlamaModel,
    size: u32,
    threads: usize,
    adapters: Vec<Adapted>,
    /// The states of the model without an adapter.
    plain: States,
    /// The least recently used one is the first.
    older: Vec<Context<'model>>,
    current: Context<'model>,
}

struct Context<'model> {
    /// The adapter that is part of the computation, by its place in the list.
    adapter: Option<usize>,
    engine: Engine<'model>,
}

impl<'model> Contexts<'model> {
    /// Contexts for `size` tokens each. The first one is created now, the others when they are needed.
    pub(super) fn new(
        model: &'model LlamaModel,
        size: u32,
        threads: usize,
        adapters: Vec<Adapted>,
        plain: States,
    ) -> Result<Self, String> {
        Ok(Self {
            model,
            size,
            threads,
            adapters,
            plain,
            older: Vec::new(),
            current: Context::new(model, size, threads, 0)?,
        })
    }

    /// Chooses the context for a prompt of a task: one that holds the prompt's fixed part, or else an empty, a new or the
    /// least recently used one.
    pub(super) fn choose(&mut self, task: Task, tokens: &[LlamaToken], fixed: usize) -> Result<(), String> {
        let adapter = self.adapters.iter().position(|own| own.task == task);
        if self.current.shares(adapter, tokens, fixed).is_some() {
            return Ok(());
        }
        let shared = |(place, context): (usize, &Context<'_>)| Some((context.shares(adapter, tokens, fixed)?, place));
        let shared = self.older.iter().enumerate().filter_map(shared).max();
        let empty = || self.older.iter().position(|context| context.engine.is_empty());
        if let Some(place) = shared.map(|(_, place)| place).or_else(empty) {
            self.take(place);
        } else if !self.current.engine.is_empty() {
            if self.older.len() + 1 < MOST {
                let context = Context::new(self.model, self.size, self.threads, 0)?;
                self.older.push(std::mem::replace(&mut self.current, context));
            } else {
                self.take(0);
            }
        }
        self.adapt(adapter)
    }

    /// Makes an older context the current one.
    fn take(&mut self, place: usize) {
        let context = self.older.remove(place);
        self.older.push(std::mem::replace(&mut self.current, context));
    }

    /// Makes an adapter part of the current context's computation, and no other one. What was computed otherwise is forgotten.
    fn adapt(&mut self, wanted: Option<usize>) -> Result<(), String> {
        let context = &mut self.current;
        if wanted == context.adapter {
            return Ok(());
        }
        for (place, is_on) in [(context.adapter.take(), false), (wanted, true)] {
            if let Some(adapted) = place.and_then(|place| self.adapters.get_mut(place)) {
                context.engine.adapt(&mut adapted.adapter, is_on)?;
            }
        }
        context.adapter = wanted;
        Ok(())
    }

    /// Returns the engine of the current context.
    pub(super) fn engine(&self) -> &Engine<'model> {
        &self.current.engine
    }

    /// Returns the engine of the current context.
    pub(super) fn engine_mut(&mut self) -> &mut Engine<'model> {
        &mut self.current.engine
    }

    /// Makes sure that the current context can compute as many tokens together. If it could not, it is empty then.
    pub(super) fn widen(&mut self, together: usize) -> Result<(), String> {
        if together > self.current.engine.batch() {
            let adapter = self.current.adapter;
            self.current = Context::new(self.model, self.size, self.threads, together)?;
            self.adapt(adapter)?;
        }
        Ok(())
    }

    /// Returns the states of the model as the current context computes it.
    pub(super) fn states(&self) -> &States {
        let adapted = self.current.adapter.and_then(|place| self.adapters.get(place));
        adapted.map_or(&self.plain, |adapted| &adapted.states)
    }

    /// True if an adapter is part of the current computation.
    pub(super) fn is_adapted(&self) -> bool {
        self.current.adapter.is_some()
    }
}

impl<'model> Context<'model> {
    /// An empty context without an adapter, which can compute `together` tokens together.
    fn new(model: &'model LlamaModel, size: u32, threads: usize, together: usize) -> Result<Self, String> {
        Ok(Self {
            adapter: None,
            engine: Engine::new(model, size, threads, together)?,
        })
    }

    /// Returns how many tokens of a prompt the context holds, if these are its fixed part at least, or half of a prompt
    /// without one.
    fn shares(&self, adapter: Option<usize>, tokens: &[LlamaToken], fixed: usize) -> Option<usize> {
        let least = match fixed {
            0 => tokens.len().div_ceil(2),
            _ => fixed,
        };
        let known = self.engine.known(tokens);
        (self.adapter == adapter && known >= least).then_some(known)
    }
}
