//! Coreference across instructions: the pronoun in "put it back".

use super::{Mentions, reference_words};
use crate::environment::{EntityId, World};
use crate::model::plain_words;

/// An instruction whose pronoun is replaced by entities of an earlier one.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct SpelledOut {
    /// The resolved instruction.
    pub text: String,
    /// The pronoun.
    pub pronoun: String,
    /// The antecedent.
    pub meant: Vec<EntityId>,
}

/// Resolves a pronoun without an antecedent in its own instruction. In "put it on the desk" it means the entity in
/// `before`; in "take the pen and put it on the desk" it means the pen.
///
/// Returns none if there is no such pronoun, or if `before` has no or several entities for "it".
///
/// ```
/// use longstep::{domain, instruction};
/// use longstep_core::{json, environment};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let environment = environment::Environment::from_json(r#"{"assets": ["<desk>"], "objects": ["<pen>"]}"#).unwrap();
/// let world = environment::read(&household, &environment, "env.json", "", &json::Path::default()).unwrap();
/// let pen = world.find("<pen>").unwrap();
/// let spelled = instruction::spelled_out(&world, "Now put it on the desk", &[pen]).unwrap();
/// assert_eq!(spelled.text, "Now put the pen on the desk");
/// assert_eq!(instruction::spelled_out(&world, "Take the pen and put it on the desk", &[pen]), None);
/// ```
pub fn spelled_out(world: &World, instruction: &str, before: &[EntityId]) -> Option<SpelledOut> {
    let mut words: Vec<&str> = instruction.split_whitespace().collect();
    let plain = |word: &str| plain_words(word).concat();
    let at = words.iter().position(|word| {
        let word = plain(word);
        reference_words::stand_for_one(&word) || reference_words::stand_for_several(&word)
    })?;
    let pronoun = plain(words[at]);
    let one = reference_words::stand_for_one(&pronoun);
    if before.is_empty() || (one && before.len() > 1) {
        return None;
    }
    // The instruction itself has the antecedent.
    if !Mentions::of(world, &words[..at].join(" ")).entities.is_empty() {
        return None;
    }
    let names: Vec<String> = before
        .iter()
        .map(|id| format!("the {}", world.entity(*id).name))
        .collect();
    let end = words[at].trim_start_matches(char::is_alphanumeric);
    let meant = format!("{}{end}", names.join(" and "));
    words[at] = &meant;
    Some(SpelledOut {
        text: words.join(" "),
        pronoun,
        meant: before.to_vec(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    use longstep_core::testing;

    #[track_caller]
    fn check(instruction: &str, before: &[&str], expected: Option<&str>) {
        let text =
            r#"{"assets": ["<desk>", "<shelf>", "<drawer>"], "objects": ["<pen>", "<ruler>", "<drawer_handle>"]}"#;
        let world = testing::world("household", text);
        let before: Vec<_> = before.iter().map(|name| world.find(name).unwrap()).collect();
        let spelled = spelled_out(&world, instruction, &before);
        assert_eq!(
            spelled.as_ref().map(|spelled| spelled.text.as_str()),
            expected,
            "{instruction}"
        );
    }

    #[test]
    fn pronoun_resolves_to_the_previously_handled_object() {
        check("Put it on the shelf", &["<pen>"], Some("Put the pen on the shelf"));
        check(
            "Put it, please, on the shelf",
            &["<pen>"],
            Some("Put the pen, please, on the shelf"),
        );
        check("Take the ruler and put it on the shelf", &["<pen>"], None);
        check("Open the drawer and put it in", &["<pen>"], None);
        check("Put the ruler away", &["<pen>"], None);
        check("Put it on the shelf", &[], None);
        check("Put it on the shelf", &["<pen>", "<ruler>"], None);
        check(
            "Put them on the shelf",
            &["<pen>", "<ruler>"],
            Some("Put the pen and the ruler on the shelf"),
        );
        check("Close it", &["<drawer>"], Some("Close the drawer"));
    }
}
