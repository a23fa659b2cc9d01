//! Requests for worlds that may be too large for a prompt.

use super::dialogue::{ANSWER_TOKENS, Understanding, UnderstandingInput};
use crate::dialogue::{OverBudget, PartCost, PromptError, TokenCounter, focus};
use crate::effort;
use crate::environment::World;

/// Maximum entities of a scene, unless the instruction names more. Goals are possible for pairs of entities, and a longer scene makes
/// models less accurate.
const SCENE: usize = 100;
/// Work budget for all requests that the fitting tries.
const EFFORT: u64 = 2 * effort::OPERATION;

/// A request with the part of the world that it shows.
#[derive(Debug, Clone)]
pub struct FittedUnderstanding {
    /// The request. If it shows a part of the world, [`Interpretation::carried`](super::Interpretation::carried) transfers its
    /// result to the whole.
    pub dialogue: Understanding,
    /// True if the request shows only a part of the world.
    pub is_narrowed: bool,
    /// Number of entities that the prompt omits.
    pub left_out: usize,
    /// Token counts of the first request, by part.
    pub costs: Vec<PartCost>,
}

impl Understanding {
    /// Starts a request that fits, with its answer, into a `context` length in tokens.
    ///
    /// If the whole world does not fit, or is too large, the prompt shows its most relevant part ([`focus`]).
    ///
    /// # Errors
    ///
    /// Even the required entities exceed the token budget, or enumerating the possible goals exceeds the work budget.
    pub fn fitted(
        input: UnderstandingInput<'_>,
        context: Option<u64>,
        counter: &mut dyn TokenCounter,
    ) -> Result<FittedUnderstanding, PromptError> {
        effort::within(EFFORT, || fitted_within(input, context, counter)).result
    }
}

fn fitted_within(
    input: UnderstandingInput<'_>,
    context: Option<u64>,
    counter: &mut dyn TokenCounter,
) -> Result<FittedUnderstanding, PromptError> {
    let room = context.map_or(u64::MAX, |context| context.saturating_sub(ANSWER_TOKENS.into()));
    let world = input.world;
    let mut attempt = |shown: &World| {
        let dialogue = Understanding::new(UnderstandingInput { world: shown, ..input });
        let costs = dialogue.costs(counter);
        let needed = costs.iter().map(|cost| cost.tokens).sum();
        if needed > room {
            Err(OverBudget { needed, room }.into())
        } else if dialogue.is_exhausted() {
            Err(PromptError::TooMuchWork)
        } else {
            Ok((dialogue, costs))
        }
    };
    let all = world.entities().count();
    if all <= SCENE
        && let Ok((dialogue, costs)) = attempt(world)
    {
        return Ok(FittedUnderstanding {
            dialogue,
            is_narrowed: false,
            left_out: 0,
            costs,
        });
    }
    let messages = input.rounds.iter().map(|round| round.message.as_str());
    let words: Vec<&str> = std::iter::once(input.instruction).chain(messages).collect();
    let focus = focus(world, &words.join(" "));
    let (dialogue, costs) = focus.most(SCENE, |keep| attempt(&world.narrowed(keep)))?;
    Ok(FittedUnderstanding {
        left_out: all - dialogue.world().entities().count(),
        dialogue,
        is_narrowed: true,
        costs,
    })
}
