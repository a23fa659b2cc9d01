//! The goal strategy in a world that may be too large for it.

use super::dialogue::ANSWER_TOKENS;
use super::{ConstraintKind, GoalDialogue, OverBudget, PartCost, PromptError, Round, TokenCounter, focus};
use crate::effort;
use crate::environment::World;
use crate::model::Domain;

/// Entities of a scene at most, unless the instruction names more. Goals are offered for pairs of things: a grammar for a
/// hundred has some 70 KiB where nothing is named, and a model that is shown more reads none of it well.
const SCENE: usize = 100;
/// Units of work for all dialogues that are begun to find one that fits.
const EFFORT: u64 = 2 * effort::OPERATION;

/// A goal dialogue, and the part of the world that it is about.
#[derive(Debug, Clone)]
pub struct FittedDialogue {
    /// The dialogue; give it [`FittedDialogue::world`].
    pub dialogue: GoalDialogue,
    /// The part of the world that the model is shown; none if that is all of it.
    pub narrowed: Option<World>,
    /// Entities that the model is not shown.
    pub left_out: usize,
    /// What each part of the first request costs.
    pub costs: Vec<PartCost>,
}

impl FittedDialogue {
    /// The world that the dialogue is about, `whole` being the one that it was begun with. What is understood is
    /// carried back to `whole` by [`crate::goal::Understanding::carried`].
    pub fn world<'a>(&'a self, whole: &'a World) -> &'a World {
        self.narrowed.as_ref().unwrap_or(whole)
    }
}

impl GoalDialogue {
    /// Begins a conversation that fits, with its answer, into a model's `context` of so many tokens.
    ///
    /// When the whole world does not fit, or is too large to make goals for, the model is shown the part of it that the
    /// instruction can concern ([`focus`]).
    ///
    /// ```
    /// use longstep::dialogue::{ConstraintKind, EstimatedTokens, GoalDialogue};
    /// use longstep::{domain, json, environment};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let environment = environment::Environment::from_json(r#"{"assets": ["<table>"], "objects": ["<cup>"]}"#).unwrap();
    /// let world = environment::read(&household, &environment, "env.json", "", &json::Path::default()).unwrap();
    /// let (text, kind) = ("Put the cup on the table", ConstraintKind::JsonSchema);
    /// let mut counter = EstimatedTokens::default();
    /// let fitted = GoalDialogue::fitted(&household, &world, text, &[], kind, Some(4000), &mut counter).unwrap();
    /// let request = fitted.dialogue.request(&household, fitted.world(&world));
    /// assert!(request.messages.last().unwrap().text.contains("cup"));
    /// ```
    ///
    /// # Errors
    ///
    /// When not even what the instruction names fits, or when finding the goals that make sense takes too much work.
    pub fn fitted(
        domain: &Domain,
        world: &World,
        instruction: &str,
        rounds: &[Round],
        kind: ConstraintKind,
        context: Option<u64>,
        counter: &mut dyn TokenCounter,
    ) -> Result<FittedDialogue, PromptError> {
        let fitted = || Self::fitted_within(domain, world, instruction, rounds, kind, context, counter);
        let mut fitted = effort::within(EFFORT, fitted).result?;
        let seen = fitted.narrowed.as_ref().unwrap_or(world);
        fitted.dialogue.begin(domain, seen);
        if fitted.dialogue.is_exhausted() {
            return Err(PromptError::TooMuchWork);
        }
        Ok(fitted)
    }

    fn fitted_within(
        domain: &Domain,
        world: &World,
        instruction: &str,
        rounds: &[Round],
        kind: ConstraintKind,
        context: Option<u64>,
        counter: &mut dyn TokenCounter,
    ) -> Result<FittedDialogue, PromptError> {
        let room = context.map_or(u64::MAX, |context| context.saturating_sub(ANSWER_TOKENS.into()));
        let mut attempt = |shown: &World| {
            let dialogue = GoalDialogue::before(domain, shown, instruction, rounds, kind);
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
                narrowed: None,
                left_out: 0,
                costs,
            });
        }
        let said = rounds.iter().map(|round| round.said.as_str());
        let words: Vec<&str> = std::iter::once(instruction).chain(said).collect();
        let words = words.join(" ");
        let focus = focus(domain, world, &words);
        let (part, (dialogue, costs)) = focus.most(SCENE, |keep| {
            let part = world.narrowed(domain, keep);
            attempt(&part).map(|made| (part, made))
        })?;
        Ok(FittedDialogue {
            dialogue,
            left_out: all - part.entities().count(),
            narrowed: Some(part),
            costs,
        })
    }
}
