//! The purpose in a plan file, in the world of the plan.

use longstep_model::model::{Prohibition, World};
use longstep_verify::plan::PurposeFile;

use super::{Goal, GoalError, parse, rules};

/// Puts the rules of a plan's purpose in force, besides those of the world, and reads its goal, if it has one.
///
/// ```
/// use longstep_model::{domain, environment};
/// use longstep_search::goal;
/// use longstep_verify::plan;
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "desk.json", text)?;
/// let mut purpose = plan::PurposeFile::default();
/// purpose.goal = Some("put(pen, shelf)".to_owned());
/// purpose.rules = vec!["untouched(desk)".to_owned()];
/// let (world, goal) = goal::with_purpose(world, &purpose)?;
/// assert_eq!((world.prohibitions().len(), goal.unwrap().facts.len()), (1, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// A rule or a goal that cannot be read in this world.
pub fn with_purpose(mut world: World, purpose: &PurposeFile) -> Result<(World, Option<Goal>), GoalError> {
    let mut read = Vec::new();
    for rule in &purpose.rules {
        world.add_values(rule);
        read.extend(rules(&world, rule)?);
    }
    let is_new = |own: &Prohibition| world.prohibitions().iter().all(|known| known.written != own.written);
    read.retain(is_new);
    let mut world = world.with_prohibitions(read);
    let goal = match &purpose.goal {
        Some(text) => {
            world.add_values(text);
            Some(parse(&world, text)?)
        }
        None => None,
    };
    Ok((world, goal))
}
