//! Plain sentences: the form in which an embedded model describes a scene, one fact a sentence, in the domain's own words.

use super::sighting::{NAMES, Sighting, Statement, plain};
use super::vocabulary::{List, Vocabulary};
use crate::call::Call;
use crate::dialogue::answer_grammar::Form;
use crate::dialogue::one_line;
use crate::model::StateWord;
use longstep_core::model::SpatialRelation;

/// A name in the line form.
pub(super) const NAME: &str = "[a-z][a-z0-9]{0,19}(_[a-z0-9]{1,19}){0,3}";
/// The beginning of a sentence about something that no state of the domain says.
pub(super) const OTHER: &str = "Other: ";
/// The beginnings of a sentence about an entity of which nothing else is said.
const THERE: [&str; 2] = ["There is a ", "There is an "];
/// The beginning of a sentence about an entity that is not there, in a correction.
const ABSENT: &str = "There is no ";
/// The article before a name.
const ARTICLE: &str = "the ";
/// Maximum number of plain sentences for one sentence, and in a correction.
const MOST: usize = 16;
/// Maximum number of sentences of a description; the last one has the rest.
const SENTENCES: usize = 60;
/// Maximum number of characters of a description.
const DESCRIPTION: usize = 4_000;
/// Maximum number of characters of a sentence that no state says.
const LENGTH: usize = 120;
/// Marks a slot in the sentence of a state; no text of a domain has it.
const MARK: char = '\u{1}';

/// A part of the sentence of a state.
enum Piece {
    Text(String),
    Slot(usize),
}

/// The content of a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Said {
    State(Statement),
    There(String),
    Absent(String),
    Other(String),
}

/// The pieces of the sentence of a state, which begins with a capital.
fn pieces(vocabulary: &Vocabulary<'_>, word: &StateWord) -> Vec<Piece> {
    let sentence = vocabulary.sentence(word, &|slot| format!("{MARK}{slot}{MARK}"));
    let parts = sentence.split(MARK).enumerate();
    parts
        .filter_map(|(index, part)| match index % 2 {
            0 => (!part.is_empty()).then(|| Piece::Text(part.to_owned())),
            _ => part.parse().ok().map(Piece::Slot),
        })
        .collect()
}

/// Returns true if entities of the lists can be in a slot, and not only constants of the domain.
fn has_names(vocabulary: &Vocabulary<'_>, word: &StateWord, slot: usize) -> bool {
    [List::Assets, List::Objects]
        .into_iter()
        .any(|list| vocabulary.fits(word, slot, list))
}

/// The form of plain sentences, with the pattern of a name.
pub(super) fn form(vocabulary: &Vocabulary<'_>, name: &str) -> Form {
    sentences(vocabulary, &THERE, name)
}

/// The form of the sentences of a correction.
pub(super) fn correction_form(vocabulary: &Vocabulary<'_>) -> Form {
    sentences(vocabulary, &[THERE[0], THERE[1], ABSENT], NAME)
}

/// The form of sentences about states, and of those that name one entity after such a beginning.
fn sentences(vocabulary: &Vocabulary<'_>, beginnings: &[&str], name: &str) -> Form {
    let name = Form::Pattern(name.to_owned()).shared();
    let mut sentences: Vec<Form> = vocabulary
        .words()
        .map(|word| sentence_form(vocabulary, word, &name))
        .collect();
    for beginning in beginnings {
        sentences.push(Form::Row(vec![Form::text(*beginning), name.clone(), Form::text(".")]));
    }
    let other = Form::Pattern(format!("[^.\\n]{{1,{LENGTH}}}"));
    sentences.push(Form::Row(vec![Form::text(OTHER), other, Form::text(".")]));
    Form::Either(sentences).separated(Form::text(" "), MOST)
}

/// Returns the names in sentences, in their order.
pub(super) fn names(vocabulary: &Vocabulary<'_>, said: &[Said]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for sentence in said {
        let own: Vec<&String> = match sentence {
            Said::State(own) => std::iter::once(&own.subject).chain(&own.state.arguments).collect(),
            Said::There(name) => vec![name],
            Said::Absent(_) | Said::Other(_) => Vec::new(),
        };
        for name in own
            .into_iter()
            .filter(|name| !vocabulary.is_constant(name) && **name == plain(name))
        {
            if !name.is_empty() && !names.contains(name) && names.len() < NAMES {
                names.push(name.clone());
            }
        }
    }
    names
}

/// Returns the names in sentences with the list that the sentences decide: an object is on, in or held by something; an asset
/// has something on or in it, and is in no place itself.
pub(super) fn lists(vocabulary: &Vocabulary<'_>, said: &[Said]) -> Vec<(String, Option<List>)> {
    const PLACES: [SpatialRelation; 2] = [SpatialRelation::On, SpatialRelation::Inside];
    let (mut placed, mut places): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
    for sentence in said {
        let Said::State(own) = sentence else { continue };
        let relations = vocabulary.find(&own.state.name).map_or(&[][..], |word| &word.relations);
        let is_in_place = relations.iter().any(|relation| PLACES.contains(relation));
        if is_in_place || relations.contains(&SpatialRelation::Held) {
            placed.push(&own.subject);
        }
        if is_in_place {
            places.extend(own.state.arguments.iter().map(String::as_str));
        }
    }
    let list = |name: &String| match (placed.contains(&name.as_str()), places.contains(&name.as_str())) {
        (true, _) => Some(List::Objects),
        (false, true) => Some(List::Assets),
        (false, false) => None,
    };
    let names = names(vocabulary, said).into_iter();
    names
        .map(|name| {
            let list = list(&name);
            (name, list)
        })
        .collect()
}

/// Puts the sentences about some names among those that no state says.
pub(super) fn without(vocabulary: &Vocabulary<'_>, said: Vec<Said>, names: &[String]) -> Vec<Said> {
    let without = |sentence: Said| match sentence {
        Said::State(own)
            if names.contains(&own.subject) || own.state.arguments.iter().any(|name| names.contains(name)) =>
        {
            Sighting::sentence(vocabulary, &own).map(|text| Said::Other(text.replace('_', " ")))
        }
        Said::There(name) if names.contains(&name) => None,
        other => Some(other),
    };
    said.into_iter().filter_map(without).collect()
}

fn sentence_form(vocabulary: &Vocabulary<'_>, word: &StateWord, name: &Form) -> Form {
    let mut row = Vec::new();
    for piece in pieces(vocabulary, word) {
        let is_first = row.is_empty();
        match piece {
            Piece::Text(text) if is_first => row.push(Form::text(capitalized(&text))),
            Piece::Text(text) => row.push(Form::text(text)),
            Piece::Slot(slot) => {
                let mut fitting: Vec<Form> = vocabulary.constants(word, slot).map(Form::text).collect();
                if has_names(vocabulary, word, slot) {
                    let article = if is_first {
                        capitalized(ARTICLE)
                    } else {
                        ARTICLE.to_owned()
                    };
                    fitting.push(Form::Row(vec![Form::text(article), name.clone()]));
                }
                row.push(Form::Either(fitting));
            }
        }
    }
    row.push(Form::text("."));
    Form::Row(row)
}

/// Reads sentences. One that has another form counts as one that no state says.
pub(super) fn read(vocabulary: &Vocabulary<'_>, text: &str) -> Vec<Said> {
    let sentences = text.split('.').map(str::trim).filter(|sentence| !sentence.is_empty());
    sentences
        .take(MOST)
        .map(|sentence| said(vocabulary, sentence))
        .collect()
}

fn said(vocabulary: &Vocabulary<'_>, sentence: &str) -> Said {
    if let Some(other) = sentence.strip_prefix(OTHER) {
        return Said::Other(other.trim().to_owned());
    }
    if let Some(name) = sentence.strip_prefix(ABSENT) {
        return Said::Absent(plain(name));
    }
    if let Some(name) = THERE.iter().find_map(|there| sentence.strip_prefix(there)) {
        return Said::There(plain(name));
    }
    let statement = vocabulary
        .words()
        .find_map(|word| statement(vocabulary, word, sentence));
    statement.map_or_else(|| Said::Other(sentence.to_owned()), Said::State)
}

/// Reads a sentence as one about a state.
fn statement(vocabulary: &Vocabulary<'_>, word: &StateWord, sentence: &str) -> Option<Statement> {
    let mut rest = sentence;
    let mut names: Vec<Option<String>> = vec![None; word.parameters.len() + 1];
    for (index, piece) in pieces(vocabulary, word).into_iter().enumerate() {
        rest = match piece {
            Piece::Text(text) if index == 0 => rest.strip_prefix(capitalized(&text).as_str())?,
            Piece::Text(text) => rest.strip_prefix(text.as_str())?,
            Piece::Slot(slot) => {
                let article = if index == 0 {
                    capitalized(ARTICLE)
                } else {
                    ARTICLE.to_owned()
                };
                let bare = rest.strip_prefix(article.as_str()).unwrap_or(rest);
                let fits = |c: char| c.is_alphanumeric() || c == '_' || c == '<' || c == '>' || c == '-';
                let end = bare.find(|c: char| !fits(c)).unwrap_or(bare.len());
                let (name, after) = bare.split_at(end);
                *names.get_mut(slot)? = Some(name.to_owned()).filter(|name| !name.is_empty());
                after
            }
        };
    }
    if !rest.is_empty() {
        return None;
    }
    let mut names = names.into_iter();
    let subject = plain(&names.next()??);
    let argument = |name: Option<String>| match name {
        Some(name) if !vocabulary.is_constant(&name) => Some(plain(&name)),
        name => name,
    };
    let arguments: Option<Vec<String>> = names.map(argument).collect();
    let state = Call {
        name: word.word.clone(),
        arguments: arguments?,
    };
    Some(Statement { subject, state })
}

/// Returns the sighting of sentences and the lists of their names.
pub(super) fn sighting(said: Vec<Said>, names: &[(String, List)]) -> Sighting {
    let mut sighting = Sighting::of_names(names);
    for sentence in said {
        match sentence {
            Said::State(statement) => sighting.statements.push(statement),
            Said::Other(text) => sighting.left_out.push(text),
            Said::There(_) | Said::Absent(_) => {}
        }
    }
    sighting
}

/// Splits a description into its sentences.
pub(super) fn split(text: &str) -> Vec<String> {
    let mut sentences: Vec<String> = Vec::new();
    let mut sentence = String::new();
    let line = one_line(text);
    let mut letters = line.chars().take(DESCRIPTION).peekable();
    while let Some(letter) = letters.next() {
        sentence.push(letter);
        // A point within a number or a name ends no sentence.
        let is_end = match letter {
            '。' | '！' | '？' | '；' => true,
            '.' | '!' | '?' | ';' => letters.peek().is_none_or(|next| next.is_whitespace()),
            _ => false,
        };
        if is_end && sentences.len() + 1 < SENTENCES {
            sentences.push(std::mem::take(&mut sentence).trim().to_owned());
        }
    }
    sentences.push(sentence.trim().to_owned());
    sentences.retain(|sentence| sentence.chars().any(char::is_alphanumeric));
    if sentences.is_empty() {
        sentences.push(line);
    }
    sentences
}

/// Writes a sighting as sentences, in the order of the names.
pub(super) fn written(vocabulary: &Vocabulary<'_>, sighting: &Sighting, names: &[(&str, List)]) -> String {
    let mut sentences: Vec<String> = Vec::new();
    for (name, _) in names {
        let own = sighting
            .statements
            .iter()
            .filter(|statement| statement.subject == *name);
        let own: Vec<String> = own
            .filter_map(|statement| Sighting::sentence(vocabulary, statement))
            .collect();
        let mentioned = |statement: &Statement| statement.state.arguments.iter().any(|argument| argument == name);
        if own.is_empty() && !sighting.statements.iter().any(mentioned) {
            sentences.push(format!("{}{name}", THERE[0]));
        }
        sentences.extend(own.iter().map(|sentence| capitalized(sentence)));
    }
    sentences.extend(sighting.left_out.iter().map(|text| format!("{OTHER}{text}")));
    sentences.join(". ") + "."
}

pub(super) fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}
