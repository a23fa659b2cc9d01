//! Fitting a conversation into a model's context length.

use super::{Message, Part, Role, TokenCounter};

/// A user message with the model's reply.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Exchange {
    /// The user message: a query or feedback.
    pub message: String,
    /// The reply.
    pub reply: String,
}

/// A conversation before it is shortened. The fields are in prompt order.
#[derive(Debug, Clone, Copy)]
pub struct Conversation<'a> {
    /// The fixed parts. Never dropped.
    pub fixed: &'a [Part],
    /// Exchanges about earlier instructions, oldest first. The oldest are dropped first.
    pub history: &'a [Exchange],
    /// Exchanges about this instruction: query and feedback with their replies. Never dropped.
    pub rounds: &'a [Exchange],
    /// The newest user message. Never dropped.
    pub now: &'a str,
}

/// Token count of a part of a conversation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartCost {
    /// The part: a name of [`super::PartName`], `history`, `rounds`, `query`, or `frame` for the chat template around
    /// the messages.
    pub name: &'static str,
    /// Number of tokens.
    pub tokens: u64,
}

/// A conversation within its token budget.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fitted {
    /// Its messages: fixed parts, history, rounds, newest message.
    pub messages: Vec<Message>,
    /// Number of leading messages from the fixed parts.
    pub fixed: usize,
    /// Token counts by part, in prompt order. Their sum is the total.
    pub costs: Vec<PartCost>,
    /// Number of dropped exchanges.
    pub dropped: usize,
}

/// The parts that cannot be dropped exceed the token budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the prompt needs {needed} tokens, which is {} more than the {room} that the model has room for", .needed - .room)]
#[non_exhaustive]
pub struct OverBudget {
    /// Minimum number of tokens.
    pub needed: u64,
    /// Token budget.
    pub room: u64,
}

impl OverBudget {
    /// Returns the excess in tokens.
    pub fn by(&self) -> u64 {
        self.needed - self.room
    }
}

/// Shortens a conversation to `room` tokens by dropping the oldest exchanges of its history.
///
/// `room` is the model's context length minus the budget of the answer; without it, nothing is dropped.
///
/// ```
/// use longstep::dialogue::{Conversation, EstimatedTokens, Exchange, fit};
/// let pair = |text: &str| Exchange { message: text.to_owned(), reply: "done".to_owned() };
/// let history = [pair("the first instruction"), pair("the second")];
/// let conversation = Conversation { fixed: &[], history: &history, rounds: &[], now: "the third" };
/// let fitted = fit(conversation, Some(30), &mut EstimatedTokens::default()).unwrap();
/// assert_eq!((fitted.dropped, fitted.messages.len()), (1, 3));
/// ```
///
/// # Errors
///
/// The conversation is too long without any history.
pub fn fit(
    conversation: Conversation<'_>,
    room: Option<u64>,
    counter: &mut dyn TokenCounter,
) -> Result<Fitted, OverBudget> {
    let room = room.unwrap_or(u64::MAX);
    let Conversation {
        fixed,
        history,
        rounds,
        now,
    } = conversation;
    let mut count = |messages: &[Message]| {
        messages
            .iter()
            .map(|message| counter.message_tokens(message))
            .sum::<u64>()
    };
    let mut messages: Vec<Message> = Vec::new();
    let mut costs = Vec::new();
    for part in fixed {
        costs.push(PartCost {
            name: part.name.name(),
            tokens: count(&part.messages),
        });
        messages.extend(part.messages.iter().cloned());
    }
    let fixed = messages.len();
    let rounds: Vec<Message> = rounds.iter().flat_map(turns).collect();
    let last = Message::new(Role::User, now);
    let (rounds_cost, now_cost) = (count(&rounds), count(std::slice::from_ref(&last)));
    let pairs: Vec<(Vec<Message>, u64)> = history
        .iter()
        .map(|exchange| {
            let pair = turns(exchange);
            let cost = count(&pair);
            (pair, cost)
        })
        .collect();
    let frame = counter.frame_tokens();
    let needed = costs.iter().map(|cost| cost.tokens).sum::<u64>() + rounds_cost + now_cost + frame;
    if needed > room {
        return Err(OverBudget { needed, room });
    }
    let mut left = room - needed;
    let mut kept = 0;
    for (_, cost) in pairs.iter().rev() {
        let Some(rest) = left.checked_sub(*cost) else { break };
        left = rest;
        kept += 1;
    }
    let dropped = pairs.len() - kept;
    let history_cost = pairs[dropped..].iter().map(|(_, cost)| cost).sum();
    messages.extend(pairs.into_iter().skip(dropped).flat_map(|(pair, _)| pair));
    messages.extend(rounds);
    messages.push(last);
    for (name, tokens) in [
        ("history", history_cost),
        ("rounds", rounds_cost),
        ("query", now_cost),
        ("frame", frame),
    ] {
        costs.push(PartCost { name, tokens });
    }
    Ok(Fitted {
        messages,
        fixed,
        costs,
        dropped,
    })
}

fn turns(exchange: &Exchange) -> Vec<Message> {
    vec![
        Message::new(Role::User, exchange.message.as_str()),
        Message::new(Role::Assistant, exchange.reply.as_str()),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::{EstimatedTokens, PartName};
    use super::*;

    /// One token per character, none around a message.
    fn counter() -> EstimatedTokens {
        EstimatedTokens {
            characters: 1.0,
            around: 0,
        }
    }

    fn pair(text: &str) -> Exchange {
        Exchange {
            message: text.to_owned(),
            reply: text.to_uppercase(),
        }
    }

    /// Uses fixed parts of 10 tokens, exchanges of 4, 6 and 8, a round of 2, and a newest message of 5.
    #[track_caller]
    fn check(room: Option<u64>, expected: Result<&str, u64>) {
        let fixed = [Part {
            name: PartName::Role,
            messages: vec![Message::new(Role::System, "0123456789")],
        }];
        let history = [pair("aa"), pair("bbb"), pair("cccc")];
        let rounds = [pair("r")];
        let conversation = Conversation {
            fixed: &fixed,
            history: &history,
            rounds: &rounds,
            now: "now!!",
        };
        let found = fit(conversation, room, &mut counter()).map(|fitted| {
            let texts: Vec<&str> = fitted.messages.iter().map(|message| message.text.as_str()).collect();
            let total: u64 = fitted.costs.iter().map(|cost| cost.tokens).sum();
            assert_eq!(total, counter().tokens(&fitted.messages));
            assert!(room.is_none_or(|room| total <= room));
            assert_eq!(fitted.messages[..fitted.fixed], fixed[0].messages[..]);
            format!("{} {}", fitted.dropped, texts.join(" "))
        });
        let expected = expected.map(str::to_owned);
        assert_eq!(found.map_err(|over| over.by()), expected);
    }

    #[test]
    fn budget_drops_only_the_oldest_history() {
        check(None, Ok("0 0123456789 aa AA bbb BBB cccc CCCC r R now!!"));
        check(Some(35), Ok("0 0123456789 aa AA bbb BBB cccc CCCC r R now!!"));
        check(Some(34), Ok("1 0123456789 bbb BBB cccc CCCC r R now!!"));
        check(Some(31), Ok("1 0123456789 bbb BBB cccc CCCC r R now!!"));
        check(Some(30), Ok("2 0123456789 cccc CCCC r R now!!"));
        check(Some(24), Ok("3 0123456789 r R now!!"));
        check(Some(17), Ok("3 0123456789 r R now!!"));
        check(Some(16), Err(1));
        check(Some(0), Err(17));
    }

    #[test]
    fn over_budget_error_states_the_excess_tokens() {
        let over = OverBudget {
            needed: 4100,
            room: 4000,
        };
        assert_eq!(
            over.to_string(),
            "the prompt needs 4100 tokens, which is 100 more than the 4000 that the model has room for"
        );
    }
}
