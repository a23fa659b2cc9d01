//! Cost of calls to a model.

/// Cost of a call, in tokens of the model in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Usage {
    /// Model calls.
    pub calls: u32,
    /// Tokens of the prompt, those from the cache included.
    pub prompt_tokens: u64,
    /// Tokens of the prompt that needed no computation.
    pub cached_tokens: u64,
    /// Tokens of the answer.
    pub completion_tokens: u64,
}

impl std::ops::AddAssign for Usage {
    fn add_assign(&mut self, other: Self) {
        self.calls += other.calls;
        self.prompt_tokens += other.prompt_tokens;
        self.cached_tokens += other.cached_tokens;
        self.completion_tokens += other.completion_tokens;
    }
}
