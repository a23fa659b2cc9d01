//! Requests of the direct strategy, within a token budget.

use super::query::{contained_json, query_text};
use super::reply::StateLists;
use super::{
    ChatRequest, Constraint, Conversation, Exchange, Fitted, Forecast, Message, PartCost, PromptError, Role, Round,
    Task, TokenCounter, direct_schema, fit, fixed_parts, focus,
};
use crate::diagnostic::Diagnostics;
use crate::environment::World;
use crate::model::Domain;

/// Token budget of the steps in an answer; the environments are added to it.
const STEP_TOKENS: u64 = 1500;

/// A request within its token budget.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Prepared {
    /// The request. Its `max_tokens` suffice for both environments and about sixty steps.
    pub request: ChatRequest,
    /// Token counts by part.
    pub costs: Vec<PartCost>,
    /// Number of omitted exchanges of the history, from the oldest.
    pub dropped: usize,
    /// Number of entities that the prompt omits. The world keeps them, and the reply is resolved in all of it.
    pub left_out: usize,
    /// The tokens of a request for a whole plan; none for the short requests of the goal strategy.
    pub forecast: Option<Forecast>,
}

/// Builds the request for a whole plan: fixed parts, history, query, and the feedback rounds on it.
///
/// `context` is the model's context length in tokens, for prompt and answer together; without it, nothing is omitted.
/// If the prompt is too long, the history is dropped from its oldest exchange on, then the least relevant entities
/// ([`focus`]).
///
/// ```
/// use longstep::dialogue::{EstimatedTokens, direct_request};
/// use longstep::domain;
/// use longstep_core::{json, environment};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let environment = environment::Environment::from_json(r#"{"assets": ["<table>"], "objects": ["<cup>"]}"#).unwrap();
/// let world = environment::read(&household, &environment, "env.json", "", &json::Path::default()).unwrap();
/// let mut counter = EstimatedTokens::default();
/// let prepared =
///     direct_request(&household, &world, "Put the cup on the table", &[], &[], Some(8000), &mut counter).unwrap();
/// assert_eq!((prepared.dropped, prepared.left_out), (0, 0));
/// assert!(prepared.request.messages.last().unwrap().text.contains("Put the cup on the table"));
/// ```
///
/// # Errors
///
/// The domain's `prompt/` files are invalid, or even the required entities exceed the budget.
pub fn direct_request(
    domain: &Domain,
    world: &World,
    instruction: &str,
    history: &[Exchange],
    rounds: &[Round],
    context: Option<u64>,
    counter: &mut dyn TokenCounter,
) -> Result<Prepared, PromptError> {
    let fixed = fixed_parts(domain)?;
    // If the query can be rendered for this world, it can be rendered for every part of it.
    query_text(domain, world.environment(), instruction).map_err(|finding| Diagnostics(vec![finding]))?;
    let attempt = |shown: &World, history: &[Exchange], counter: &mut dyn TokenCounter| {
        let query = query_text(domain, shown.environment(), instruction).unwrap_or_default();
        let turns: Vec<&str> = std::iter::once(query.as_str())
            .chain(rounds.iter().map(|round| round.message.as_str()))
            .collect();
        let before = turns.iter().zip(rounds).map(|(message, round)| Exchange {
            message: (*message).to_owned(),
            reply: round.reply.clone(),
        });
        let conversation = Conversation {
            fixed: &fixed,
            history,
            rounds: &before.collect::<Vec<_>>(),
            now: turns[rounds.len()],
        };
        let room = context.map(|context| context.saturating_sub(answer_tokens(shown, counter)));
        fit(conversation, room, counter)
    };
    if let Ok(fitted) = attempt(world, history, counter) {
        return Ok(prepared(world, fitted, 0, context, counter));
    }
    let focus = focus(world, instruction);
    let (part, mut fitted) = focus.most(focus.ranked.len(), |keep| {
        let part = world.narrowed(keep);
        attempt(&part, &[], counter).map(|fitted| (part, fitted))
    })?;
    fitted.dropped = history.len();
    let left_out = world.entities().count() - part.entities().count();
    Ok(prepared(&part, fitted, left_out, context, counter))
}

fn prepared(
    shown: &World,
    fitted: Fitted,
    left_out: usize,
    context: Option<u64>,
    counter: &mut dyn TokenCounter,
) -> Prepared {
    let answer = answer_tokens(shown, counter);
    Prepared {
        forecast: Some(Forecast::new(&fitted.costs, answer - STEP_TOKENS, STEP_TOKENS, context)),
        request: ChatRequest {
            task: Task::Other,
            messages: fitted.messages,
            fixed: fitted.fixed,
            answer_so_far: String::new(),
            constraint: Constraint::JsonSchema(direct_schema(shown)),
            max_tokens: u32::try_from(answer).unwrap_or(u32::MAX),
        },
        costs: fitted.costs,
        dropped: fitted.dropped,
        left_out,
    }
}

/// Returns the token budget of an answer: two environments and the steps.
fn answer_tokens(shown: &World, counter: &mut dyn TokenCounter) -> u64 {
    let lists = contained_json(&StateLists::of(shown.environment()));
    2 * counter.message_tokens(&Message::new(Role::Assistant, lists)) + STEP_TOKENS
}
