//! Goal dialogues for worlds that may be too large for a prompt.

use super::goal_dialogue::ANSWER_TOKENS;
use super::{GoalDialogue, GoalInput, OverBudget, PartCost, PromptError, TokenCounter, focus};
use crate::effort;
use crate::environment::World;

/// Maximum entities of a scene, unless the instruction names more. Goals are offered for pairs of entities: with a
/// hundred entities, none of them named, a grammar has about 70 KiB, and a longer scene makes models less accurate.
const SCENE: usize = 100;
/// Work budget for all dialogues that the fitting tries.
const EFFORT: u64 = 2 * effort::OPERATION;

/// A goal dialogue with the part of the world that it shows.
#[derive(Debug, Clone)]
pub struct FittedDialogue {
    /// The dialogue. If it shows a part of the world, [`crate::goal::Understanding::carried`] transfers its result to
    /// the whole.
    pub dialogue: GoalDialogue,
    /// True if the dialogue shows only a part of the world.
    pub is_narrowed: bool,
    /// Number of entities that the prompt omits.
    pub left_out: usize,
    /// Token counts of the first request, by part.
    pub costs: Vec<PartCost>,
}

impl GoalDialogue {
    /// Starts a dialogue that fits, with its answer, into a `context` length in tokens.
    ///
    /// If the whole world does not fit, or has too many possible goals, the prompt shows its most relevant part
    /// ([`focus`]).
    ///
    /// ```
    /// use longstep::dialogue::{ConstraintKind, Dialogue, EstimatedTokens, GoalDialogue, GoalInput};
    /// use longstep::domain;
    /// use longstep_core::{json, environment};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let environment = environment::Environment::from_json(r#"{"assets": ["<table>"], "objects": ["<cup>"]}"#).unwrap();
    /// let world = environment::read(&household, &environment, "env.json", "", &json::Path::default()).unwrap();
    /// let input = GoalInput::new(&household, &world, "Put the cup on the table", ConstraintKind::JsonSchema);
    /// let fitted = GoalDialogue::fitted(input, Some(4000), &mut EstimatedTokens::default()).unwrap();
    /// let request = fitted.dialogue.request();
    /// assert!(request.messages.last().unwrap().text.contains("cup"));
    /// ```
    ///
    /// # Errors
    ///
    /// Even the required entities exceed the token budget, or enumerating the possible goals exceeds the work budget.
    pub fn fitted(
        input: GoalInput<'_>,
        context: Option<u64>,
        counter: &mut dyn TokenCounter,
    ) -> Result<FittedDialogue, PromptError> {
        let fitted = || Self::fitted_within(input, context, counter);
        let mut fitted = effort::within(EFFORT, fitted).result?;
        fitted.dialogue.look();
        if fitted.dialogue.is_exhausted() {
            return Err(PromptError::TooMuchWork);
        }
        Ok(fitted)
    }

    fn fitted_within(
        input: GoalInput<'_>,
        context: Option<u64>,
        counter: &mut dyn TokenCounter,
    ) -> Result<FittedDialogue, PromptError> {
        let room = context.map_or(u64::MAX, |context| context.saturating_sub(ANSWER_TOKENS.into()));
        let GoalInput { world, .. } = input;
        let mut attempt = |shown: &World| {
            let dialogue = GoalDialogue::before(GoalInput { world: shown, ..input });
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
            return Ok(FittedDialogue {
                dialogue,
                is_narrowed: false,
                left_out: 0,
                costs,
            });
        }
        let messages = input.rounds.iter().map(|round| round.message.as_str());
        let words: Vec<&str> = std::iter::once(input.instruction).chain(messages).collect();
        let words = words.join(" ");
        let focus = focus(world, &words);
        let (dialogue, costs) = focus.most(SCENE, |keep| attempt(&world.narrowed(keep)))?;
        Ok(FittedDialogue {
            left_out: all - dialogue.world().entities().count(),
            dialogue,
            is_narrowed: true,
            costs,
        })
    }
}
