//! The entities that a part of a goal names.

use super::GoalError;
use longstep_model::call::find_unquoted;
use longstep_model::diagnostic::nearest;
use longstep_model::model::{Distinctions, EntityId, FormPiece, GoalWord, TEXT_VALUE_LIMIT, TypeId, ValueForm, World};

/// The largest number of entities that an error offers for a part of their names.
const LONGER_NAMES: usize = 4;

/// Returns the names in a goal of this form, by parameter; none if the text has another form.
pub fn read_form<'t>(word: &GoalWord, text: &'t str) -> Option<Vec<&'t str>> {
    let mut names = vec![""; word.parameters.len()];
    let mut rest = text;
    let mut pieces = word.form.iter().peekable();
    while let Some(piece) = pieces.next() {
        match piece {
            FormPiece::Text(text) => rest = rest.strip_prefix(sign(text))?,
            FormPiece::Parameter(index) => {
                let end = match pieces.peek() {
                    Some(FormPiece::Text(next)) if !next.is_empty() => find_unquoted(rest, sign(next))?,
                    _ => rest.len(),
                };
                names[*index] = rest[..end].trim();
                rest = &rest[end..];
            }
        }
    }
    rest.is_empty().then_some(names)
}

/// Returns what has to stand between two names. No name has a comma, so the blanks beside one do not matter.
fn sign(text: &str) -> &str {
    if text.trim() == "," { "," } else { text }
}

/// Returns the entities with these names, one of each kind.
pub(super) fn entities(
    world: &World,
    part: &str,
    names: &[&str],
    kinds: &[TypeId],
) -> Result<Vec<EntityId>, GoalError> {
    let domain = world.domain();
    let mut entities = Vec::with_capacity(names.len());
    for (name, kind) in names.iter().zip(kinds) {
        let named = world.named(name);
        let fitting = named.iter().copied();
        let fitting: Vec<EntityId> = fitting.filter(|entity| world.is_of_kind(*entity, *kind)).collect();
        let (part, name) = (part.to_owned(), (*name).to_owned());
        match (&fitting[..], &named[..]) {
            ([entity], _) => entities.push(*entity),
            ([], []) => return Err(unknown_name(world, part, name, *kind)),
            ([], _) => {
                let expected = domain.types.name(*kind).to_owned();
                return Err(GoalError::WrongType { part, name, expected });
            }
            _ => {
                let mut candidates = Distinctions::of(world).describe(&fitting);
                if candidates.len() < fitting.len() {
                    candidates.push(format!("and {} more", fitting.len() - candidates.len()));
                }
                return Err(GoalError::SharedName { part, name, candidates });
            }
        }
    }
    Ok(entities)
}

fn unknown_name(world: &World, part: String, name: String, kind: TypeId) -> GoalError {
    let domain = world.domain();
    match domain.value(&name) {
        Some(Err(beyond)) => return GoalError::OutOfRange(beyond),
        Some(Ok(value)) => return GoalError::NewValue { written: value.written },
        None => {}
    }
    let folded = name.to_lowercase();
    let keys = [("speaker", &domain.speaker_names), ("robot", &domain.robot_names)];
    if let Some((key, _)) = keys.into_iter().find(|(_, names)| names.contains(&folded)) {
        return GoalError::NobodyNamed { part, name, key };
    }
    if let Some(values) = domain.values.iter().find(|values| values.kind == kind) {
        return GoalError::NotAValue {
            kind: domain.types.name(kind).to_owned(),
            form: match &values.form {
                ValueForm::Text if name.starts_with('"') => {
                    format!(
                        "a text of 1 to {TEXT_VALUE_LIMIT} characters without quotation marks and backslashes in it"
                    )
                }
                ValueForm::Text => format!("a text in double quotes: `\"{name}\"`"),
                ValueForm::Quantity(form) if form.unit.is_empty() => "a number".to_owned(),
                ValueForm::Quantity(form) => format!("a number with its unit, `{}`", form.unit),
            },
            part,
            name,
        };
    }
    let known = || world.entities().map(|(_, entity)| entity.name.as_str());
    let longer = known()
        .filter(|known| ends_with_words(known, &folded))
        .take(LONGER_NAMES);
    let mut near: Vec<String> = longer.map(str::to_owned).collect();
    // Names that end with the text explain the error better than a similar spelling.
    if near.is_empty() {
        near.extend(nearest(&name, known()).map(str::to_owned));
    }
    GoalError::UnknownName { part, name, near }
}

/// Returns true if a name ends with these words, which are in lower case, and has others before them.
fn ends_with_words(name: &str, words: &str) -> bool {
    let name = name.to_lowercase();
    name.strip_suffix(words).is_some_and(|rest| rest.ends_with(' '))
}
