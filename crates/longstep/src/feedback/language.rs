//! The few words in which a model writes what should change about a plan: `drop 5`, `insert move_object() after 4`.

use super::StepWish;
use crate::call::Call;
use crate::diagnostic::nearest;
use crate::environment::{EntityId, World};
use crate::model::{ActionId, Domain};

/// Why a text is no wish about the steps of a plan.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WishError {
    /// It has the form of none.
    #[error(
        "`{0}` is no change of a plan; write `insert CALL after N`, `drop N`, `replace N with CALL` or `move N after N`"
    )]
    UnknownForm(String),
    /// A number that no step has.
    #[error("`{part}`: the plan has {length} steps")]
    NoSuchStep {
        /// The part of the text.
        part: String,
        /// How many steps there are.
        length: usize,
    },
    /// A call of an action that the domain does not have, or with too few or too many arguments.
    #[error("`{call}` calls no action of this domain{}", near.as_ref().map_or(String::new(), |n| format!("; did you mean `{n}`?")))]
    UnknownCall {
        /// The call.
        call: String,
        /// An action of a similar name.
        near: Option<String>,
    },
    /// A name that nothing of the right type has.
    #[error("`{name}` in `{call}` is nothing that can stand there")]
    UnknownName {
        /// The call.
        call: String,
        /// The name.
        name: String,
    },
}

/// What joins two wishes.
pub(super) const JOINT: &str = " & ";

/// A wish with its call as text, not looked up yet; steps count from 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Form<'t> {
    Insert { call: &'t str, before: usize },
    Drop { step: usize },
    Replace { step: usize, call: &'t str },
    Move { step: usize, before: usize },
}

/// Reads the form of one wish about a plan of `length` steps.
pub(super) fn form(text: &str, length: usize) -> Result<Form<'_>, WishError> {
    let unknown = || WishError::UnknownForm(text.chars().take(80).collect());
    let number = |digits: &str| {
        let number: usize = digits.trim().parse().map_err(|_| unknown())?;
        let inside = (1..=length).contains(&number);
        inside.then(|| number - 1).ok_or_else(|| WishError::NoSuchStep {
            part: text.to_owned(),
            length,
        })
    };
    // What comes first, and the place between two steps that is told after it.
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
            Form::Insert {
                call: rest[..end].trim(),
                before,
            }
        }
        "drop" => Form::Drop { step: number(rest)? },
        "replace" => {
            let (step, call) = rest.split_once(" with ").ok_or_else(unknown)?;
            Form::Replace {
                step: number(step)?,
                call: call.trim(),
            }
        }
        "move" => {
            let (end, before) = placed(rest)?;
            Form::Move {
                step: number(&rest[..end])?,
                before,
            }
        }
        _ => return Err(unknown()),
    })
}

/// Reads wishes about a plan of `length` steps, joined by `&`. Entities go by everyday name or identifier; what a call
/// hides stays open.
///
/// # Errors
///
/// The first part that cannot be read.
///
/// ```
/// use longstep::feedback::{StepWish, parse};
/// use longstep::{domain, json, environment};
/// let domain = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<shelf>"], "objects": ["<tea>"]}"#;
/// let environment = environment::Environment::from_json(text).unwrap();
/// let world = environment::read(&domain, &environment, "env.json", text, &json::Path::default()).unwrap();
/// let wishes = parse(&domain, &world, "drop 3 & insert move_object() after 4", 7).unwrap();
/// assert_eq!(wishes[0], StepWish::Drop { step: 2 });
/// assert_eq!(wishes[1].before(), Some(4));
/// ```
pub fn parse(domain: &Domain, world: &World, text: &str, length: usize) -> Result<Vec<StepWish>, WishError> {
    let mut wishes: Vec<StepWish> = Vec::new();
    for part in text.split('&').map(str::trim) {
        let wish = match form(part, length)? {
            Form::Insert { call, before } => {
                let (action, arguments) = called(domain, world, call)?;
                StepWish::Insert {
                    before,
                    action,
                    arguments,
                    explanation: String::new(),
                }
            }
            Form::Drop { step } => StepWish::Drop { step },
            Form::Replace { step, call } => {
                let (action, arguments) = called(domain, world, call)?;
                StepWish::Replace {
                    step,
                    action,
                    arguments,
                    explanation: String::new(),
                }
            }
            Form::Move { step, before } => StepWish::Move { step, before },
        };
        // What is said of a step first counts.
        let said = |earlier: &StepWish| *earlier == wish || (wish.step().is_some() && earlier.step() == wish.step());
        if !wishes.iter().any(said) {
            wishes.push(wish);
        }
    }
    Ok(wishes)
}

/// The action that a call names, if it has as many arguments.
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

fn called(domain: &Domain, world: &World, text: &str) -> Result<(ActionId, Vec<Option<EntityId>>), WishError> {
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

/// A call as a plan writes it, with `?` for what should be shown and is not known.
pub fn written(domain: &Domain, world: &World, action: ActionId, arguments: &[Option<EntityId>]) -> String {
    call(domain, action, arguments, |entity| {
        world.entity(entity).identifier.clone()
    })
}

/// The same with everyday names, as a model reads and writes it.
pub(super) fn everyday(domain: &Domain, world: &World, action: ActionId, arguments: &[Option<EntityId>]) -> String {
    call(domain, action, arguments, |entity| world.entity(entity).name.clone())
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
