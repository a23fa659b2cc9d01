//! Articles of everyday names: "the juice", but "plate 2", "Maria" and "杯子".

use super::label::is_label;
use super::{DomainData, EntityId, World};

impl DomainData {
    /// Returns a name with the domain's [article](DomainData::article), if it takes one.
    ///
    /// A name that begins or ends with a number or a label takes none, and neither does a name in another script than
    /// the article's.
    ///
    /// ```
    /// let household = longstep_model::domain::shipped("household").unwrap().unwrap();
    /// assert_eq!(household.with_article("juice"), "the juice");
    /// assert_eq!(household.with_article("plate 2"), "plate 2");
    /// assert_eq!(household.with_article("tube A"), "tube A");
    /// assert_eq!(household.with_article("чашка"), "чашка");
    /// ```
    pub fn with_article(&self, name: &str) -> String {
        let is_label = |word: &str| word.ends_with(char::is_numeric) || is_label(word);
        let is_labelled = name.rsplit_once(' ').is_some_and(|(_, last)| is_label(last));
        let is_numbered = name.starts_with(char::is_numeric) || name.ends_with(char::is_numeric);
        let own = self.article.chars().find_map(script);
        let is_foreign = name.chars().filter_map(script).any(|script| Some(script) != own);
        if self.article.is_empty() || is_numbered || is_labelled || is_foreign {
            name.to_owned()
        } else {
            format!("{} {name}", self.article)
        }
    }
}

impl World {
    /// Returns the everyday name of an entity with its article. A name with a capital letter that the environment gave is
    /// a proper name, which takes none: "Maria", "Bay 3". Nor does the speaker: "me".
    pub fn with_article(&self, entity: EntityId) -> String {
        let entity = self.entity(entity);
        let is_speaker = self.environment().speaker.as_ref() == Some(&entity.identifier);
        if entity.is_value || is_speaker {
            return entity.name.clone();
        }
        let given = self.environment().names.as_ref();
        let given = given.and_then(|names| names.get(&entity.identifier));
        if given.is_some_and(|name| name.contains(char::is_uppercase)) {
            return entity.name.clone();
        }
        self.domain().with_article(&entity.name)
    }
}

/// The script of a letter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Script {
    Latin,
    Greek,
    Cyrillic,
    /// Any other script, by its block of 256 characters.
    Other(u32),
}

/// Returns the script of a letter; none for any other character.
fn script(letter: char) -> Option<Script> {
    letter.is_alphabetic().then_some(match letter {
        '\0'..='\u{2af}' | '\u{1d00}'..='\u{1dbf}' | '\u{1e00}'..='\u{1eff}' => Script::Latin,
        '\u{2c60}'..='\u{2c7f}' | '\u{a720}'..='\u{a7ff}' => Script::Latin,
        '\u{370}'..='\u{3ff}' | '\u{1f00}'..='\u{1fff}' => Script::Greek,
        '\u{400}'..='\u{52f}' => Script::Cyrillic,
        other => Script::Other(u32::from(other) >> 8),
    })
}
