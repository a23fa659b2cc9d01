//! Rules in force in a world.

use longstep_core::environment::World;
use longstep_core::goal;

use crate::failure::Failure;

/// Returns the world with rules in force: `never GOAL`, `always GOAL` or `untouched(NAME)`.
pub(crate) fn with_rules(mut world: World, rules: &[String]) -> Result<World, Failure> {
    let mut found = Vec::new();
    for rule in rules {
        world.add_values(rule);
        let read = goal::rules(&world, rule).map_err(|error| {
            Failure::unreadable(format!("the rule `{rule}` cannot be read: {error}"))
                .hint("a rule is `never GOAL`, `always GOAL` or `untouched(NAME)`".to_owned())
        })?;
        found.extend(read);
    }
    Ok(world.with_prohibitions(found))
}
