//! The language of step changes that a model writes: `drop 5`, `insert move_object() after 4`.

use super::StepWish;
use crate::call::Call;
use crate::diagnostic::nearest;
use crate::environment::{EntityId, World};
use crate::model::ActionId;
use longstep_core::model::Domain;

/// Reason why a text is not a wish about the steps of a plan.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum WishError {
    /// The text matches no form.
    #[error(
        "`{0}` is no change of a plan; write `insert CALL after N`, `drop N`, `replace N with CALL` or `move N after N`"
    )]
    UnknownForm(String),
    /// No step has this number.
    #[error("`{part}`: the plan has {length} steps")]
    NoSuchStep {
        /// The invalid part of the text.
        part: String,
        /// The number of steps.
        length: usize,
    },
    /// The call names no action of the domain, or has a wrong number of arguments.
    #[error("`{call}` calls no action of this domain{}", near.as_ref().map_or(String::new(), |n| format!("; did you mean `{n}`?")))]
    UnknownCall {
        /// The call.
        call: String,
        /// An action with a similar name.
        near: Option<String>,
    },
    /// No entity of the right type has this name.
    #[error("`{name}` in `{call}` is nothing that can stand there")]
    UnknownName {
        /// The call.
        call: String,
        /// The name.
        name: String,
    },
}

/// Separator of wishes.
pub(super) const JOINT: &str = " & ";

/// A parsed wish whose call is still text; steps count from 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum WrittenWish<'t> {
    Insert { call: &'t str, before: usize },
    Drop { step: usize },
    Replace { step: usize, call: &'t str },
    Move { step: usize, before: usize },
}

/// Parses the form of one wish about a plan of `length` steps.
pub(super) fn form(text: &str, length: usize) -> Result<WrittenWish<'_>, WishError> {
    let unknown = || WishError::UnknownForm(text.chars().take(80).collect());
    let number = |digits: &str| {
        let number: usize = digits.trim().parse().map_err(|_| unknown())?;
        let inside = (1..=length).contains(&number);
        inside.then(|| number - 1).ok_or_else(|| WishError::NoSuchStep {
            part: text.to_owned(),
            length,
        })
    };
    // Splits off the position: returns the length of the text before it, and the step index to insert before.
    let placed = |rest: &'_ str| -> Result<(usize, usize), WishError> {
        let (at, shift, word) = match (rest.rfind(" after "), rest.rfind(" before ")) {
            (Some(at), _) => (at, 1, " after "),
            (None, Some(at)) => (at, 0, " before "),
            (None, None) => return Err(unknown()),
        };
        Ok((at, number(&rest[at + word.len()..])? + shift))
    };
    let (verb, rest) = text.split_once(' ').ok_or_else(unknown)?;
    Ok(match verb {
        "insert" => {
            let (end, before) = placed(rest)?;
            WrittenWish::Insert {
                call: rest[..end].trim(),
                before,
            }
        }
        "drop" => WrittenWish::Drop { step: number(rest)? },
        "replace" => {
            let (step, call) = rest.split_once(" with ").ok_or_else(unknown)?;
            WrittenWish::Replace {
                step: number(step)?,
                call: call.trim(),
            }
        }
        "move" => {
            let (end, before) = placed(rest)?;
            WrittenWish::Move {
                step: number(&rest[..end])?,
                before,
            }
        }
        _ => return Err(unknown()),
    })
}

/// Parses wishes about a plan of `length` steps, joined by `&`. Arguments are everyday names or identifiers; arguments
/// that a call hides stay open.
///
/// # Errors
///
/// The first part that is invalid.
///
/// ```
/// use longstep::feedback::{StepWish, parse};
/// use longstep::domain;
/// use longstep_core::environment;
/// let domain = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<shelf>"], "objects": ["<tea>"]}"#;
/// let world = environment::parse(&domain, "env.json", text).unwrap();
/// let wishes = parse(&world, "drop 3 & insert move_object() after 4", 7).unwrap();
/// assert_eq!(wishes[0], StepWish::Drop { step: 2 });
/// assert_eq!(wishes[1].before(), Some(4));
/// ```
pub fn parse(world: &World, text: &str, length: usize) -> Result<Vec<StepWish>, WishError> {
    let mut wishes: Vec<StepWish> = Vec::new();
    for part in text.split('&').map(str::trim) {
        let wish = match form(part, length)? {
            WrittenWish::Insert { call, before } => {
                let (action, arguments) = called(world, call)?;
                StepWish::Insert {
                    before,
                    action,
                    arguments,
                    explanation: String::new(),
                }
            }
            WrittenWish::Drop { step } => StepWish::Drop { step },
            WrittenWish::Replace { step, call } => {
                let (action, arguments) = called(world, call)?;
                StepWish::Replace {
                    step,
                    action,
                    arguments,
                    explanation: String::new(),
                }
            }
            WrittenWish::Move { step, before } => StepWish::Move { step, before },
        };
        // The first wish about a step counts.
        let covered = |earlier: &StepWish| *earlier == wish || (wish.step().is_some() && earlier.step() == wish.step());
        if !wishes.iter().any(covered) {
            wishes.push(wish);
        }
    }
    Ok(wishes)
}

/// Finds the action of a call with the right number of arguments.
pub(super) fn action_of(domain: &Domain, text: &str) -> Result<(ActionId, Call), WishError> {
    let unknown = |name: &str| WishError::UnknownCall {
        call: text.chars().take(80).collect(),
        near: nearest(name, domain.actions.iter().map(|action| action.call.as_str())).map(str::to_owned),
    };
    let call = Call::parse(text).map_err(|_| unknown(text))?;
    let mut actions = domain.action_ids();
    let fits =
        |action: &crate::model::Action| action.call == call.name && action.explicit.len() == call.arguments.len();
    match actions.find(|(_, action)| fits(action)) {
        Some((id, _)) => Ok((id, call)),
        None => Err(unknown(&call.name)),
    }
}

fn called(world: &World, text: &str) -> Result<(ActionId, Vec<Option<EntityId>>), WishError> {
    let domain = world.domain();
    let (id, call) = action_of(domain, text)?;
    let action = domain.action(id);
    let mut arguments = vec![None; action.parameters.len()];
    for (name, parameter) in call.arguments.iter().zip(&action.explicit) {
        let found = world.find(name).or_else(|| world.find_name(name));
        let fits = found.filter(|entity| world.is_of_kind(*entity, action.parameters[*parameter].kind));
        arguments[*parameter] = Some(fits.ok_or_else(|| WishError::UnknownName {
            call: text.to_owned(),
            name: name.clone(),
        })?);
    }
    Ok((id, arguments))
}

/// Returns a call in plan notation, with `?` for unknown explicit arguments.
pub fn written(world: &World, action: ActionId, arguments: &[Option<EntityId>]) -> String {
    call(world.domain(), action, arguments, |entity| {
        world.entity(entity).identifier.clone()
    })
}

/// Returns a call with everyday names, as in prompts and replies.
pub(super) fn everyday(world: &World, action: ActionId, arguments: &[Option<EntityId>]) -> String {
    call(world.domain(), action, arguments, |entity| {
        world.entity(entity).name.clone()
    })
}

fn call(
    domain: &Domain,
    action: ActionId,
    arguments: &[Option<EntityId>],
    name: impl Fn(EntityId) -> String,
) -> String {
    let action = domain.action(action);
    let shown = |parameter: &usize| arguments[*parameter].map_or_else(|| "?".to_owned(), &name);
    let call = Call {
        name: action.call.clone(),
        arguments: action.explicit.iter().map(shown).collect(),
    };
    call.to_string()
}
