//! Token counts for models on servers.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use longstep::dialogue::{Counting, EstimatedTokens, Message, Role, TokenCounter, Usage};
use tiktoken_rs::CoreBPE;
use tiktoken_rs::tokenizer::{Tokenizer as Family, get_tokenizer};

use super::connection::Connection;
use super::endpoint::{Endpoint, Kind};
use super::limit::COUNTING_TIME;
use super::probe::Tokenizer;

/// Tokens that OpenAI's models add to a message (its role excluded), and those that open the answer, by OpenAI's own
/// instructions for counting.
const OPENAI_AROUND: u64 = 3;

/// Tokens that other models add to a message, including role and line ends, by common chat templates.
const TEMPLATE_AROUND: u64 = 5;

/// Counts the tokens of one model.
#[derive(Debug)]
pub(super) struct Counter {
    way: CountMethod,
    /// Cached counts: the same fixed parts are counted many times.
    counted: HashMap<Message, u64>,
    estimate: Calibrated,
    /// Total time of the token requests to the server.
    counting_time: Duration,
}

#[derive(Debug)]
enum CountMethod {
    /// A tokenizer of OpenAI, loaded at its first use.
    OpenAi(Family),
    /// The server may have a tokenizer; the first count finds out.
    Unprobed,
    /// The server's tokenizer.
    Server(Tokenizer),
    /// No tokenizer is available.
    Estimate,
}

impl Counter {
    pub(super) fn of(endpoint: &Endpoint) -> Self {
        let way = match endpoint.kind {
            Kind::OpenAi | Kind::Azure => get_tokenizer(&endpoint.model)
                .filter(|family| tokenizer(*family).is_some())
                .map_or(CountMethod::Estimate, CountMethod::OpenAi),
            Kind::Other => CountMethod::Unprobed,
            Kind::Ollama | Kind::Anthropic | Kind::Gemini => CountMethod::Estimate,
        };
        Self {
            way,
            counted: HashMap::new(),
            estimate: Calibrated::default(),
            counting_time: Duration::ZERO,
        }
    }

    /// Tokens of a message, including the template around it.
    pub(super) fn message(&mut self, message: &Message, endpoint: &Endpoint, connection: &Connection) -> u64 {
        if let Some(known) = self.counted.get(message) {
            return *known;
        }
        let text = message.text.as_str();
        // A cancelled request gives no information about the server.
        if connection.stop.is_set() {
            return self.estimate.now().message_tokens(message);
        }
        let began = Instant::now();
        if matches!(self.way, CountMethod::Unprobed) {
            let answering = |way: &Tokenizer| way.count("one two", endpoint, connection).is_some();
            let found = Tokenizer::ALL.into_iter().find(answering);
            if !connection.stop.is_set() {
                self.way = found.map_or(CountMethod::Estimate, CountMethod::Server);
            }
        }
        let count = match &self.way {
            CountMethod::OpenAi(family) => tokenizer(*family).map(|load| {
                let tokenizer = load();
                let count = |text: &str| tokenizer.count_ordinary(text) as u64;
                count(role(message.role)) + count(text) + OPENAI_AROUND
            }),
            CountMethod::Server(tokenizer) => {
                let count = tokenizer.count(text, endpoint, connection);
                count.map(|count| count + TEMPLATE_AROUND)
            }
            CountMethod::Unprobed | CountMethod::Estimate => None,
        };
        self.counting_time += began.elapsed();
        let given_up = count.is_none() || self.counting_time > COUNTING_TIME;
        if matches!(self.way, CountMethod::Server(_)) && given_up && !connection.stop.is_set() {
            // If one count fails or is slow, every further message would wait for the server, too.
            self.way = CountMethod::Estimate;
        }
        let Some(count) = count else {
            // Not cached: the next reply may improve the estimate.
            return self.estimate.now().message_tokens(message);
        };
        self.counted.insert(message.clone(), count);
        count
    }

    /// Tokens around the messages of a conversation.
    pub(super) fn frame(&self) -> u64 {
        match &self.way {
            CountMethod::OpenAi(_) => OPENAI_AROUND,
            CountMethod::Server(_) => TEMPLATE_AROUND,
            CountMethod::Unprobed | CountMethod::Estimate => self.estimate.now().frame_tokens(),
        }
    }

    pub(super) fn counting(&self, endpoint: &Endpoint) -> Counting {
        match &self.way {
            CountMethod::OpenAi(_) => Counting::Exact(format!("the tokenizer of {}", endpoint.model)),
            // Texts are counted exactly, but the tokens of the template are unknown.
            CountMethod::Server(_) => Counting::Estimate(format!(
                "the tokenizer of {} on its server, and {TEMPLATE_AROUND} tokens taken for what is around a message",
                endpoint.model
            )),
            CountMethod::Unprobed | CountMethod::Estimate => self.estimate.counting(),
        }
    }

    /// Calibrates the estimate with the server's count for a conversation.
    pub(super) fn learn(&mut self, messages: &[Message], usage: &Usage) {
        self.estimate.learn(messages, usage.prompt_tokens);
    }
}

/// The loader of the tokenizer of a family of chat models.
fn tokenizer(family: Family) -> Option<fn() -> &'static CoreBPE> {
    match family {
        Family::O200kBase => Some(tiktoken_rs::o200k_base_singleton),
        Family::O200kHarmony => Some(tiktoken_rs::o200k_harmony_singleton),
        Family::Cl100kBase => Some(tiktoken_rs::cl100k_base_singleton),
        Family::P50kBase | Family::R50kBase | Family::P50kEdit | Family::Gpt2 => None,
    }
}

fn role(role: Role) -> &'static str {
    match role {
        Role::System => "system",
        Role::User => "user",
        Role::Assistant => "assistant",
    }
}

/// Characters a token, calibrated with the replies so far.
#[derive(Debug, Default)]
struct Calibrated {
    replies: u32,
    characters: u64,
    tokens: u64,
}

impl Calibrated {
    fn learn(&mut self, messages: &[Message], prompt_tokens: u64) {
        // Pictures have tokens and no characters.
        if messages.iter().any(|message| !message.pictures.is_empty()) {
            return;
        }
        let around = EstimatedTokens::default().around * (messages.len() as u64 + 1);
        let characters: usize = messages.iter().map(|message| message.text.chars().count()).sum();
        // A server that counts no tokens, or not all, is ignored.
        let tokens = prompt_tokens.saturating_sub(around);
        if tokens > 0 && characters as u64 > tokens {
            self.replies += 1;
            self.characters += characters as u64;
            self.tokens += tokens;
        }
    }

    fn now(&self) -> EstimatedTokens {
        let mut estimate = EstimatedTokens::default();
        if self.tokens > 0 {
            estimate.characters = self.characters as f64 / self.tokens as f64;
        }
        estimate
    }

    fn counting(&self) -> Counting {
        let characters = self.now().characters;
        match self.replies {
            0 => self.now().counting(),
            1 => Counting::Estimate(format!(
                "calibrated on 1 reply: {characters:.2} characters taken for a token"
            )),
            many => Counting::Estimate(format!(
                "calibrated on {many} replies: {characters:.2} characters taken for a token"
            )),
        }
    }
}

#[cfg(test)]
mod tests {
    use longstep::dialogue::Picture;

    use super::*;
    use crate::StopFlag;

    #[test]
    fn an_estimate_learns_from_what_servers_count() {
        let mut estimate = Calibrated::default();
        let message = Message::new(Role::User, "x".repeat(400));
        assert_eq!(estimate.now(), EstimatedTokens::default());
        // Zero tokens, and an implausible number.
        estimate.learn(std::slice::from_ref(&message), 0);
        estimate.learn(std::slice::from_ref(&message), 5000);
        let picture = Picture::new(b"\x89PNG\r\n\x1a\n".to_vec()).unwrap();
        estimate.learn(&[message.clone().with_pictures(vec![picture])], 108);
        assert_eq!(estimate.replies, 0);
        estimate.learn(std::slice::from_ref(&message), 108);
        assert_eq!(estimate.now().characters, 4.0);
        assert_eq!(estimate.now().message_tokens(&message), 104);
        estimate.learn(std::slice::from_ref(&message), 208);
        let Counting::Estimate(description) = estimate.counting() else {
            panic!("exact")
        };
        assert!(description.contains("calibrated on 2 replies: 2.67"), "{description}");
    }

    #[test]
    fn openais_models_are_counted_as_openai_does() {
        let second = Duration::from_secs(1);
        let connection = Connection::new(second, second, StopFlag::default()).unwrap();
        for (model, tokens) in [("gpt-4o-mini", 16), ("gpt-4", 16), ("gpt-oss-20b", 16)] {
            let endpoint = Endpoint::new(Kind::OpenAi, "http://127.0.0.1:9/v1", model, None);
            let mut counter = Counter::of(&endpoint);
            assert!(matches!(counter.counting(&endpoint), Counting::Exact(_)), "{model}");
            let message = Message::new(Role::User, "Put the cup on the shelf, then close the door.");
            assert_eq!(counter.message(&message, &endpoint, &connection), tokens, "{model}");
            assert_eq!(counter.frame(), 3);
        }
        let endpoint = Endpoint::new(Kind::Azure, "http://127.0.0.1:9", "our-deployment", None);
        assert!(matches!(
            Counter::of(&endpoint).counting(&endpoint),
            Counting::Estimate(_)
        ));
    }
}
