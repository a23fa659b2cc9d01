//! Help for an author who answers one question after another: mistakes in an answer, two spellings of one state, and a
//! first world.

use super::answer_reader::AnswerReader;
use super::answers::{ActionAnswer, Answers};
use super::sentence::{Piece, Sentence, Which, kinds_of, plain};
use longstep::domain::singular;

/// Words that say nothing about a state: "the box is being held" is about "held".
const FILLERS: [&str; 12] = [
    "is",
    "are",
    "be",
    "being",
    "been",
    "the",
    "a",
    "an",
    "it",
    "now",
    "then",
    "currently",
];

/// Facts that the proposal for a first world has at most.
const START: usize = 200;

/// A mistake in an answer, with a hint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AnswerMistake {
    /// The mistake.
    pub message: String,
    /// The remedy.
    pub hint: String,
}

fn mistake(message: String, hint: impl Into<String>) -> Option<AnswerMistake> {
    Some(AnswerMistake {
        message,
        hint: hint.into(),
    })
}

/// Returns the mistake in the words of an action after those in `answers`, if any.
pub fn action_mistake(answers: &Answers, words: &str) -> Option<AnswerMistake> {
    let reader = AnswerReader::new(answers).ok()?;
    if words.contains([',', ';']) {
        return mistake(
            format!("\"{words}\" is more than one action"),
            "write one action at a time: \"pick up a box\"",
        );
    }
    if let Some(found) = plural_mistake(answers, words) {
        return Some(found);
    }
    let sentence = reader.sentence(words);
    let kinds = kinds_of(&sentence);
    let names: Vec<&str> = answers.kind.iter().map(|kind| kind.name.as_str()).collect();
    if kinds.is_empty() || kinds.iter().any(|(_, which)| *which == Which::Any) {
        return mistake(
            format!("\"{words}\" does not name what it is done to"),
            format!("name one of each kind: {}", names.join(", ")),
        );
    }
    if !sentence.pieces.iter().any(is_own_word) {
        return mistake(
            format!("\"{words}\" has no verb"),
            "begin with what the robot does: \"pick up a box\"",
        );
    }
    let is_same = |own: &ActionAnswer| plain(&own.words) == plain(words);
    if answers.action.iter().any(is_same) {
        return mistake(
            format!("there is an action \"{words}\" already"),
            "say the difference, or go on to the next question",
        );
    }
    None
}

/// Returns the mistake in a sentence about a state, if any.
pub fn sentence_mistake(answers: &Answers, text: &str) -> Option<AnswerMistake> {
    let reader = AnswerReader::new(answers).ok()?;
    if text.contains(',') {
        return mistake(
            format!("\"{text}\" is more than one sentence"),
            "separate sentences by \";\"",
        );
    }
    if let Some(found) = plural_mistake(answers, text) {
        return Some(found);
    }
    let sentence = reader.sentence(text);
    if !sentence.pieces.iter().any(is_own_word) {
        return mistake(
            format!("\"{text}\" says nothing"),
            "write a whole sentence: \"the box is on a shelf\"",
        );
    }
    if let Some(Piece::Thing(kind, _)) = sentence.pieces.iter().find(|piece| matches!(piece, Piece::Thing(..))) {
        let name = &answers.kind[*kind].name;
        return mistake(
            format!("\"{text}\" is about one thing, and an action is about all of its kind"),
            format!("write the kind: \"the {name}\""),
        );
    }
    None
}

/// Returns the mistake in a sentence about the first world, if any: it has to be about known facts and things.
pub fn start_mistake(answers: &Answers, text: &str) -> Option<AnswerMistake> {
    let mut reader = AnswerReader::new(answers).ok()?;
    let sentences = states(answers);
    let known: Vec<&str> = sentences.iter().map(String::as_str).take(3).collect();
    for own in &sentences {
        let sentence = reader.sentence(own);
        reader.pattern(&sentence);
    }
    let sentence = reader.start_sentence(text);
    if let Some(Piece::Kind(kind, _)) = sentence.pieces.iter().find(|piece| matches!(piece, Piece::Kind(..))) {
        let kind = &answers.kind[*kind];
        return mistake(
            format!("\"{text}\" does not say which {}", kind.name),
            format!("name one of: {}", kind.examples.join(", ")),
        );
    }
    if !sentence.holds {
        return mistake(
            format!("\"{text}\" says what is not so"),
            "write only what is so; all else is not",
        );
    }
    let count = reader.patterns.len();
    if reader.pattern(&sentence) >= count {
        let hint = format!(
            "use the words of the actions, with your examples: \"{}\"",
            known.join("\", \"")
        );
        return mistake(format!("no action speaks of \"{text}\""), hint);
    }
    None
}

fn is_own_word(piece: &Piece) -> bool {
    matches!(piece, Piece::Word(word) if !FILLERS.contains(&word.as_str()))
}

/// Finds "boxes" where the kind is "box": a sentence would not be about the kind.
fn plural_mistake(answers: &Answers, text: &str) -> Option<AnswerMistake> {
    let kinds: Vec<Vec<String>> = answers.kind.iter().map(|kind| plain(&kind.name)).collect();
    let words = plain(text);
    let is_plural = |word: &&String| {
        let single = singular(word);
        let is_kind = |own: &str| kinds.iter().any(|kind| kind.len() == 1 && kind[0] == own);
        single != **word && is_kind(&single) && !is_kind(word)
    };
    let word = words.iter().find(is_plural)?;
    let single = singular(word);
    mistake(
        format!("\"{word}\" is more than one {single}"),
        format!("write \"the {single}\", \"any {single}\" or \"no {single}\""),
    )
}

/// Returns the names of the kinds that no action is about.
pub fn unused_kinds(answers: &Answers) -> Vec<String> {
    let Ok(reader) = AnswerReader::new(answers) else {
        return Vec::new();
    };
    let mut used: Vec<usize> = Vec::new();
    let words = answers.action.iter().map(|action| action.words.clone());
    for text in words.chain(states(answers)) {
        used.extend(kinds_in_order(&reader.sentence(&text)));
    }
    let kinds = answers.kind.iter().enumerate();
    kinds
        .filter(|(index, _)| !used.contains(index))
        .map(|(_, kind)| kind.name.clone())
        .collect()
}

/// Returns all sentences about states in the answers.
fn states(answers: &Answers) -> Vec<String> {
    let of_action = |action: &ActionAnswer| {
        let removed = action.no_longer.iter().flatten();
        action
            .needs
            .iter()
            .chain(&action.then)
            .chain(removed)
            .cloned()
            .collect::<Vec<_>>()
    };
    answers.action.iter().flat_map(of_action).collect()
}

/// Returns an earlier sentence for the same state in other words, written like `text`: of another box, or its opposite.
/// `action` is the action that is being described.
pub fn same_state(answers: &Answers, action: &ActionAnswer, text: &str) -> Option<String> {
    let reader = AnswerReader::new(answers).ok()?;
    let sentence = reader.sentence(text);
    let robot = answers.robot();
    let meaning = meaning(&sentence, &robot);
    let kinds = kinds_in_order(&sentence);
    let mut of_action = answers.clone();
    of_action.action.push(action.clone());
    let earlier: Vec<Sentence> = states(&of_action).iter().map(|own| reader.sentence(own)).collect();
    if earlier.iter().any(|own| is_same(own, &sentence)) {
        return None;
    }
    let similar = |own: &&Sentence| kinds_in_order(own) == kinds && is_similar(&self::meaning(own, &robot), &meaning);
    let found = earlier.iter().find(similar)?;
    Some(rewritten(answers, found, &sentence))
}

/// A word in a sentence that may be a slip of the pen for a kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Misspelt {
    /// The word as it is written.
    pub word: String,
    /// The name of the kind.
    pub kind: String,
}

/// Returns the first word behind an article or a quantifier that is no kind and nearly one: "the palce".
pub fn misspelt_kind(answers: &Answers, text: &str) -> Option<Misspelt> {
    let reader = AnswerReader::new(answers).ok()?;
    let sentence = reader.sentence(text);
    let determiners = ["the", "a", "an", "no", "any", "another", "every", "all"];
    sentence.pieces.windows(2).find_map(|pair| {
        let [Piece::Word(before), Piece::Word(word)] = pair else {
            return None;
        };
        if !determiners.contains(&before.as_str()) || *word == answers.robot() {
            return None;
        }
        let names = answers.kind.iter().map(|kind| kind.name.to_lowercase());
        let mut near = names.filter(|name| {
            let most = if name.chars().count() > 5 { 2 } else { 1 };
            name.chars().count() > 3 && strsim::osa_distance(name, word) <= most
        });
        near.next().map(|kind| Misspelt {
            word: word.clone(),
            kind,
        })
    })
}

impl Misspelt {
    /// Returns a sentence with the kind in place of the word.
    pub fn mended(&self, text: &str) -> String {
        let words = text.split_whitespace().map(|word| {
            if plain(word).first() == Some(&self.word) {
                self.kind.as_str()
            } else {
                word
            }
        });
        words.collect::<Vec<_>>().join(" ")
    }
}

/// A state that actions need and none brings about, with a state of the robot and the same kinds that one brings about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnmadeState {
    /// The sentence of the need.
    pub needed: String,
    /// The sentence that an action brings about.
    pub made: String,
}

/// Returns the states of the robot that actions need and none brings about, where they may be other words for one that is brought
/// about: "the robot has the box" beside "the robot holds the box".
pub fn unmade_states(answers: &Answers) -> Vec<UnmadeState> {
    let Ok(reader) = AnswerReader::new(answers) else {
        return Vec::new();
    };
    let robot = answers.robot();
    let is_of_robot = |own: &Sentence| !kinds_of(own).is_empty() && plain_words(own).join(" ").contains(&robot);
    let read = |texts: Vec<&String>| -> Vec<Sentence> {
        let all = texts.into_iter().map(|text| reader.sentence(text));
        all.filter(&is_of_robot).collect()
    };
    let made = read(answers.action.iter().flat_map(|action| &action.then).collect());
    let mut unmade: Vec<UnmadeState> = Vec::new();
    for needed in read(answers.action.iter().flat_map(|action| &action.needs).collect()) {
        if made.iter().any(|own| is_same(own, &needed)) {
            continue;
        }
        let found = made.iter().find(|own| kinds_in_order(own) == kinds_in_order(&needed));
        let own = found.map(|made| UnmadeState {
            needed: rewritten(answers, &needed, &needed),
            made: rewritten(answers, made, &needed),
        });
        unmade.extend(own.filter(|own| !unmade.contains(own)));
    }
    unmade
}

/// Writes one state in the words of another one, in all actions.
pub fn replace_state(answers: &mut Answers, state: &UnmadeState) {
    let before = answers.clone();
    let Ok(reader) = AnswerReader::new(&before) else { return };
    let (needed, made) = (reader.sentence(&state.needed), reader.sentence(&state.made));
    for action in &mut answers.action {
        let removed = action.no_longer.iter_mut().flatten();
        for text in action.needs.iter_mut().chain(&mut action.then).chain(removed) {
            let own = reader.sentence(text);
            if is_same(&own, &needed) {
                *text = rewritten(&before, &made, &own);
            }
        }
    }
}

/// Returns true if two sentences are about the same fact.
fn is_same(left: &Sentence, right: &Sentence) -> bool {
    words_of(left) == words_of(right) && kinds_in_order(left) == kinds_in_order(right)
}

fn kinds_in_order(sentence: &Sentence) -> Vec<usize> {
    kinds_of(sentence).into_iter().map(|(kind, _)| kind).collect()
}

/// Returns the words of a sentence with a mark for each kind.
fn words_of(sentence: &Sentence) -> Vec<&str> {
    let words = sentence.pieces.iter().filter_map(|piece| match piece {
        Piece::Word(word) if !matches!(word.as_str(), "the" | "a" | "an") => Some(word.as_str()),
        Piece::Word(_) => None,
        Piece::Kind(..) | Piece::Thing(..) => Some("<>"),
    });
    words.collect()
}

/// Returns what the words of a sentence mean, roughly: without fillers and endings; the robot by any name is one word.
fn meaning(sentence: &Sentence, robot: &str) -> Vec<String> {
    let stem = |word: &str| {
        let endings = ["ing", "ed", "es", "s"];
        let cut = endings
            .iter()
            .find_map(|ending| word.strip_suffix(ending).filter(|stem| stem.len() > 2));
        cut.unwrap_or(word).to_owned()
    };
    let words = sentence
        .pieces
        .iter()
        .filter(|piece| is_own_word(piece))
        .filter_map(|piece| match piece {
            Piece::Word(word) if word == robot || matches!(word.as_str(), "robot" | "he" | "she") => {
                Some("robot".to_owned())
            }
            Piece::Word(word) => Some(stem(word)),
            _ => None,
        });
    words.collect()
}

/// Returns true if two meanings may be one: the same words, the words of one among those of the other, or a slip of the pen.
fn is_similar(left: &[String], right: &[String]) -> bool {
    if left.is_empty() || right.is_empty() {
        return false;
    }
    let within = |short: &[String], long: &[String]| short.iter().all(|word| long.contains(word));
    let (one, other) = (left.join(" "), right.join(" "));
    within(left, right)
        || within(right, left)
        || (one.len() > 5 && other.len() > 5 && strsim::levenshtein(&one, &other) <= 2)
}

/// Writes the fact of a sentence about the kinds of another one.
fn rewritten(answers: &Answers, fact: &Sentence, text: &Sentence) -> String {
    let mut kinds = kinds_of(text).into_iter();
    let mut words: Vec<String> = Vec::new();
    for piece in &fact.pieces {
        match piece {
            Piece::Word(word) => words.push(word.clone()),
            Piece::Thing(_, name) => words.push(name.clone()),
            Piece::Kind(kind, _) => {
                let which = kinds.next().map_or(Which::One, |(_, which)| which);
                words.push(match which {
                    Which::One => "the".to_owned(),
                    Which::Other => "another".to_owned(),
                    Which::Any => "any".to_owned(),
                });
                words.push(answers.kind[*kind].name.clone());
            }
        }
    }
    if !text.holds {
        words.insert(0, "not".to_owned());
    }
    words.join(" ")
}

/// Proposes a first world for the examples of the kinds: each thing at a place, the robot at the first one, and all that no
/// action changes.
pub fn guess_start(answers: &Answers) -> Vec<String> {
    let Ok(mut reader) = AnswerReader::new(answers) else {
        return Vec::new();
    };
    let mut changed: Vec<usize> = Vec::new();
    let mut needed: Vec<(usize, Sentence)> = Vec::new();
    for action in &answers.action {
        for text in action.then.iter().chain(action.no_longer.iter().flatten()) {
            let sentence = reader.sentence(text);
            changed.push(reader.pattern(&sentence));
        }
        for text in &action.needs {
            let sentence = reader.sentence(text);
            let pattern = reader.pattern(&sentence);
            if sentence.holds && !needed.iter().any(|(own, _)| *own == pattern) {
                needed.push((pattern, sentence));
            }
        }
    }
    let mut start = Vec::new();
    let mut placed: Vec<usize> = Vec::new();
    let mut robot_is: Vec<Vec<String>> = Vec::new();
    let robot = answers.robot();
    for (pattern, sentence) in &needed {
        let kinds = kinds_in_order(sentence);
        let moves = kinds.iter().copied().find(|kind| !answers.kind[*kind].stays);
        match (&kinds[..], changed.contains(pattern)) {
            // Whom the robot has or knows at the start, only its author can say.
            ([kind], false) if !answers.kind[*kind].stays && plain_words(sentence).join(" ").contains(&robot) => {}
            ([kind], false) => start.extend(of_all(answers, sentence, *kind)),
            // The robot is at one place, of whatever kind.
            ([place], true)
                if answers.kind[*place].stays
                    && plain_words(sentence).join(" ").contains(&robot)
                    && !robot_is.contains(&plain_words(sentence)) =>
            {
                robot_is.push(plain_words(sentence));
                start.extend(of_all(answers, sentence, *place).into_iter().take(1));
            }
            ([_, _], _) if moves.is_some_and(|kind| !placed.contains(&kind)) => {
                placed.extend(moves);
                start.extend(of_pairs(answers, sentence, &kinds));
            }
            ([], false) => start.push(filled(answers, sentence, &[])),
            _ => {}
        }
    }
    start.truncate(START);
    start
}

fn plain_words(sentence: &Sentence) -> Vec<String> {
    let words = sentence.pieces.iter().filter_map(|piece| match piece {
        Piece::Word(word) => Some(word.clone()),
        _ => None,
    });
    words.collect()
}

fn of_all(answers: &Answers, sentence: &Sentence, kind: usize) -> Vec<String> {
    let examples = answers.kind[kind].examples.iter();
    examples.map(|name| filled(answers, sentence, &[name])).collect()
}

/// Each thing of the first kind with one of the second, by turns.
fn of_pairs(answers: &Answers, sentence: &Sentence, kinds: &[usize]) -> Vec<String> {
    let [left, right] = [kinds[0], kinds[1]].map(|kind| &answers.kind[kind].examples);
    let pairs = left.iter().zip(right.iter().cycle());
    pairs
        .map(|(one, other)| filled(answers, sentence, &[one, other]))
        .collect()
}

/// Writes a sentence with the names of things in place of its kinds.
fn filled(answers: &Answers, sentence: &Sentence, names: &[&str]) -> String {
    let mut names = names.iter();
    let words = sentence.pieces.iter().map(|piece| match piece {
        Piece::Word(word) => word.clone(),
        Piece::Thing(_, name) => name.clone(),
        Piece::Kind(kind, _) => format!(
            "the {}",
            names.next().map_or(answers.kind[*kind].name.as_str(), |name| name)
        ),
    });
    words.collect::<Vec<_>>().join(" ")
}
