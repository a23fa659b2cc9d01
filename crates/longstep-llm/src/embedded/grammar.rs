//! Grammars over a model's vocabulary, for constrained decoding.

use std::sync::Arc;

use llama_cpp_2::model::LlamaModel;
use llama_cpp_2::sampling::LlamaSampler;
use llguidance::api::TopLevelGrammar;
use llguidance::earley::SlicedBiasComputer;
use llguidance::{Matcher, ParserFactory};
use longstep::dialogue::Constraint;
use toktrie::{InferenceCapabilities, TokEnv, TokTrie, TokenId, TokenizerEnv};

use crate::ModelError;

/// The vocabulary of a model, with the model's own tokenizer. llguidance tokenizes forced text with it; such tokens are
/// appended without sampling.
struct Vocabulary {
    trie: TokTrie,
    model: Arc<LlamaModel>,
}

impl TokenizerEnv for Vocabulary {
    fn tok_trie(&self) -> &TokTrie {
        &self.trie
    }

    /// Forced text can begin or end inside a character, which the model's own tokenizer would replace.
    fn tokenize_bytes(&self, text: &[u8]) -> Vec<TokenId> {
        self.trie.tokenize_with_greedy_fallback(text, |text| {
            let tokens = self.model.vocab().tokenize(text.as_bytes(), false, false);
            tokens.into_iter().map(|token| token.0.cast_unsigned()).collect()
        })
    }
}

/// Builds grammar matchers. Made once for a model, because it reads the whole vocabulary.
pub(super) struct Grammars {
    pub(super) factory: ParserFactory,
}

impl Grammars {
    pub(super) fn new(model: &Arc<LlamaModel>) -> Result<Self, String> {
        let trie = LlamaSampler::llguidance_tok_env(model).tok_trie().clone();
        let vocabulary: TokEnv = Arc::new(Vocabulary {
            trie,
            model: Arc::clone(model),
        });
        let capabilities = InferenceCapabilities {
            ff_tokens: true,
            ..InferenceCapabilities::default()
        };
        let slices = SlicedBiasComputer::general_slices();
        let mut factory = ParserFactory::new(&vocabulary, capabilities, &slices).map_err(|error| error.to_string())?;
        factory.quiet();
        Ok(Self { factory })
    }

    /// A matcher that follows the constraint token by token; `None` if any text is allowed.
    pub(super) fn matcher(&self, constraint: &Constraint) -> Result<Option<Matcher>, ModelError> {
        let grammar = match constraint {
            Constraint::Free => return Ok(None),
            Constraint::Lark(grammar) => TopLevelGrammar::from_lark(grammar.clone()),
            Constraint::JsonSchema(schema) => TopLevelGrammar::from_json_schema(schema.clone()),
        };
        let matcher = Matcher::new(self.factory.create_parser(grammar));
        match matcher.get_error() {
            Some(error) => Err(ModelError::Grammar(first_line(&error))),
            None => Ok(Some(matcher)),
        }
    }
}

/// llguidance repeats the grammar after the first line of an error.
fn first_line(error: &str) -> String {
    error.lines().next().unwrap_or_default().trim().to_owned()
}
