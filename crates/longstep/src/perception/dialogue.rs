//! The dialogue with a model about a description or pictures.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::example::sight_examples;
use super::sentence::{self, NAME, Said};
use super::sighting::{ARROW, COMMA, KINDS, LABEL, NAMES, Sighting, written_names};
use super::vocabulary::{List, Vocabulary};
use crate::dialogue::answer_grammar::{Form, any_text, at_most, closed, list, one_of, pattern};
use crate::dialogue::{
    ChatRequest, ConstraintKind, Dialogue, DialogueError, Message, Picture, Reply, Role, Task, Transcript, one_line,
};
use crate::model::{Domain, plain_words, singular};

/// The task, with a place for the states of the domain.
const TASK: &str = include_str!("sight.txt");
/// The form of a server's answer.
const JSON_FORM: &str = "Answer with JSON: `assets` and `objects` are lists of names, `states` lists the states with their \
    entity and the names of the other entities, and `unsure` lists in plain words what cannot be seen well.";
/// The form of an embedded model's answer.
const LINE_FORM: &str = "Answer with a line for each sentence: the sentence, and what it says in plain English sentences, one for \
each fact; what no state says begins with \"Other:\". Then write a line of all names, each with asset or object.";
/// Token budget of an answer.
const TOKENS: u32 = 4096;
/// A remark about what cannot be seen well, in a schema with bounds.
const NOTE: &str = "^[A-Za-z][A-Za-z0-9 ,'-]{0,59}$";
/// Maximum number of such remarks in a schema with bounds.
const NOTES: usize = 8;
/// Maximum number of states in a schema with bounds.
const SEEN_STATES: usize = 60;
/// Maximum number of characters of a word in a name.
const WORD: usize = 20;
/// Maximum number of words that names can be made of.
const WORDS: usize = 300;
/// Maximum number of characters of a description.
const LENGTH: usize = 4_000;

/// The source of a sighting.
#[derive(Debug, Clone)]
pub struct SightInput<'a> {
    /// The domain.
    pub domain: &'a Domain,
    /// The description, or further words about the pictures; may be empty if there are pictures.
    pub words: &'a str,
    /// The pictures.
    pub pictures: &'a [Picture],
    /// The kind of constraint that the model supports.
    pub kind: ConstraintKind,
}

/// Lets a model write down what a description or pictures show.
///
/// An embedded model answers to words in plain sentences, one for each fact, under a grammar of the domain's own sentences. A
/// model that was not trained for this makes names up: one that is no word of the description, where most names are. What it
/// says about such a name is left out, or, if that would lose a thing, it is asked again, with no names but the person's words. In
/// a last request it says of each name if it is an asset or an object, unless the sentences decide that: what is on, in or held by
/// something is an object, and what other things are on or in is an asset if it is in no place itself. A server answers in
/// JSON, in one request; so does an embedded model that sees pictures, with bounds on the names, because it has no sentences to
/// begin with.
///
/// ```
/// use longstep::Planner;
/// use longstep::dialogue::{ConstraintKind, Dialogue, Reply};
/// use longstep::perception::{SightDialogue, SightInput, View};
///
/// let planner = Planner::shipped("household")?;
/// let domain = planner.domain();
/// let input = SightInput { domain, words: "Milk in a fridge", pictures: &[], kind: ConstraintKind::Grammar };
/// let mut dialogue = SightDialogue::new(&input);
/// let text = "Milk in a fridge => The milk is in the fridge.\n";
/// let reply = Reply::complete(text);
/// let sighting = dialogue.supply(&reply)?.unwrap();
/// let view = View::of(domain, &sighting);
/// assert_eq!(view.environment.object_states["<milk>"].as_slice(), ["inside_something(<fridge>)"]);
/// assert!(view.world.is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct SightDialogue<'a> {
    vocabulary: Vocabulary<'a>,
    /// The form of the answer.
    kind: ConstraintKind,
    /// True if the schema has bounds: for an engine that masks tokens.
    is_bounded: bool,
    transcript: Transcript,
    /// The sentences of the description.
    sentences: Vec<String>,
    /// The words that names are made of; none for any names.
    words: Option<SaidWords>,
    /// The plain sentences of an embedded model, once it has written them, if they leave open the list of a name.
    said: Option<Vec<Said>>,
}

impl<'a> SightDialogue<'a> {
    /// Starts a dialogue. Only the first 4,000 characters of the words are used.
    pub fn new(input: &SightInput<'a>) -> Self {
        let vocabulary = Vocabulary::of(input.domain);
        let kind = match input.pictures {
            [] => input.kind,
            [..] => ConstraintKind::JsonSchema,
        };
        let form = match kind {
            ConstraintKind::Grammar => LINE_FORM,
            ConstraintKind::JsonSchema => JSON_FORM,
        };
        let task = format!("{}{form}", TASK.replace("{states}", &meanings(&vocabulary)));
        let mut messages = vec![Message::new(Role::System, task)];
        for example in sight_examples(&vocabulary) {
            let names = example.names(&vocabulary);
            let answer = match kind {
                ConstraintKind::Grammar => {
                    let lines = example
                        .parts
                        .iter()
                        .map(|(text, plain)| format!("{text}{ARROW}{plain}\n"));
                    format!("{}{}", lines.collect::<String>(), written_names(&names))
                }
                ConstraintKind::JsonSchema => {
                    json_of(&sentence::sighting(example.said(&vocabulary), &names)).to_string()
                }
            };
            messages.push(Message::new(Role::User, example.text()));
            messages.push(Message::new(Role::Assistant, answer));
        }
        let mut transcript = Transcript::new(kind, messages);
        if kind == ConstraintKind::Grammar {
            transcript = transcript.for_task(Task::Description);
        }
        let words: String = one_line(input.words).chars().take(LENGTH).collect();
        let words = match (words.is_empty(), input.pictures.is_empty()) {
            (true, false) => "Write down what the picture shows.".to_owned(),
            _ => words,
        };
        transcript.push_with_pictures(Role::User, words, input.pictures.to_vec());
        Self {
            vocabulary,
            kind,
            is_bounded: input.kind == ConstraintKind::Grammar,
            sentences: sentence::split(input.words),
            words: None,
            transcript,
            said: None,
        }
    }

    /// Returns the grammar of a line for each sentence of the description: the sentence, and what it says in plain ones.
    /// A small model that has the sentence right before its answer keeps to it.
    fn grammar_of_sentences(&self) -> String {
        let name = self.words.as_ref().map_or_else(|| NAME.to_owned(), SaidWords::pattern);
        let plain = sentence::form(&self.vocabulary, &name).shared();
        let lines = self.sentences.iter().flat_map(|text| {
            let begin = Form::text(format!("{text}{ARROW}"));
            [begin, plain.clone(), Form::text("\n")]
        });
        Form::Row(lines.collect()).grammar()
    }

    /// Returns the sentences without what they say about names that the model has made up. None if that would lose a thing: then
    /// the next request admits no names but words of the description.
    fn without_made_up(&mut self, said: Vec<Said>) -> Option<Vec<Said>> {
        let names = sentence::names(&self.vocabulary, &said);
        let words = SaidWords::of(&self.sentences);
        let Some((words, made_up)) = words.and_then(|words| words.lack(&names).map(|made_up| (words, made_up))) else {
            return Some(said);
        };
        let kept = sentence::without(&self.vocabulary, said, &made_up);
        let left = sentence::names(&self.vocabulary, &kept);
        if names.iter().all(|name| made_up.contains(name) || left.contains(name)) {
            return Some(kept);
        }
        self.words = Some(words);
        self.transcript.answer.clear();
        None
    }

    /// Returns the grammar of the names of the sentences, each with its list.
    fn grammar_of_names(names: &[&str]) -> String {
        let kinds = Form::texts(KINDS.iter().map(|(kind, _)| (*kind).to_owned())).shared();
        let mut row = vec![Form::text(LABEL)];
        for (index, name) in names.iter().enumerate() {
            let comma = if index == 0 { "" } else { COMMA };
            row.extend([Form::text(format!("{comma}{name}")), kinds.clone()]);
        }
        Form::Row(row).grammar()
    }
}

/// The words of a description that names can be made of, with their singulars.
#[derive(Debug, Clone)]
struct SaidWords(BTreeSet<String>);

impl SaidWords {
    /// Returns the words; none if there are too many for a grammar.
    fn of(sentences: &[String]) -> Option<Self> {
        let words = sentences.iter().flat_map(|text| plain_words(text));
        let forms = words.flat_map(|word| [singular(&word), word]);
        let fits = |word: &String| {
            (2..=WORD).contains(&word.len())
                && word.chars().all(|own| own.is_ascii_alphanumeric())
                && word.starts_with(|own: char| own.is_ascii_lowercase())
        };
        let words: BTreeSet<String> = forms.filter(fits).collect();
        (words.len() <= WORDS).then_some(Self(words))
    }

    /// Returns the names without any of the words, if most of the names have one: in another language than that of the names, few
    /// have.
    fn lack(&self, names: &[String]) -> Option<Vec<String>> {
        let made_up = |name: &&String| !name.split('_').any(|part| self.0.contains(part));
        let made_up: Vec<String> = names.iter().filter(made_up).cloned().collect();
        (!made_up.is_empty() && made_up.len() * 2 <= names.len()).then_some(made_up)
    }

    /// Returns the pattern of names made of the words, with a number or without.
    fn pattern(&self) -> String {
        let words: Vec<&str> = self.0.iter().map(String::as_str).collect();
        let word = format!("({})", words.join("|"));
        format!("{word}(_{word}){{0,2}}(_[1-9][0-9]?)?")
    }
}

/// Returns the sighting of sentences, with the lists that they decide and those that the model has added.
fn sighting(said: Vec<Said>, lists: Vec<(String, Option<List>)>, added: &[(String, List)]) -> Sighting {
    let of = |name: &String| added.iter().find(|(own, _)| own == name).map(|(_, list)| *list);
    let named: Vec<(String, List)> = lists
        .into_iter()
        .filter_map(|(name, list)| list.or_else(|| of(&name)).map(|list| (name, list)))
        .collect();
    sentence::sighting(said, &named)
}

/// Returns the states of the domain with their meanings, a line each.
pub(super) fn meanings(vocabulary: &Vocabulary<'_>) -> String {
    let lines = vocabulary.words().map(|word| {
        let call = crate::call::Call {
            name: word.word.clone(),
            arguments: word
                .parameters
                .iter()
                .map(|own| own.trim_matches(['<', '>']).to_owned())
                .collect(),
        };
        format!("- {call}: {}", one_line(&word.means.replace(['<', '>'], "")))
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn json_of(sighting: &Sighting) -> Value {
    let states: Vec<Value> = sighting
        .statements
        .iter()
        .map(|own| json!({"entity": own.subject, "state": own.state.name, "arguments": own.state.arguments}))
        .collect();
    json!({"assets": sighting.assets, "objects": sighting.objects, "states": states, "unsure": sighting.unsure})
}

/// The JSON schema of an answer. With bounds, it admits only names in their form and short lists: a small model that repeats
/// itself comes to an end. The strict modes of servers know no bounds.
fn schema(vocabulary: &Vocabulary<'_>, is_bounded: bool) -> Value {
    let words: Vec<String> = vocabulary.words().map(|word| word.word.clone()).collect();
    let arguments = vocabulary.words().map(|word| word.parameters.len()).max();
    let bounded_list = |items: Value, most: usize| {
        if is_bounded {
            at_most(list(items), most)
        } else {
            list(items)
        }
    };
    let name = if is_bounded {
        pattern(&format!("^{NAME}$"))
    } else {
        any_text()
    };
    let note = if is_bounded { pattern(NOTE) } else { any_text() };
    let state = closed(&[
        ("entity", name.clone()),
        ("state", one_of(Some(&words))),
        ("arguments", bounded_list(name.clone(), arguments.unwrap_or_default())),
    ]);
    let mut schema = closed(&[
        ("assets", bounded_list(name.clone(), NAMES)),
        ("objects", bounded_list(name, NAMES)),
        ("states", bounded_list(state, SEEN_STATES)),
        ("unsure", bounded_list(note, NOTES)),
    ]);
    if is_bounded && let Some(schema) = schema.as_object_mut() {
        // Without blanks, as in the worked examples.
        schema.insert("x-guidance".to_owned(), json!({"whitespace_flexible": false}));
    }
    schema
}

impl Dialogue for SightDialogue<'_> {
    type Output = Sighting;

    fn request(&self) -> ChatRequest {
        match (self.kind, &self.said) {
            (ConstraintKind::JsonSchema, _) => {
                let schema = schema(&self.vocabulary, self.is_bounded);
                self.transcript.under_schema(schema, TOKENS)
            }
            (ConstraintKind::Grammar, None) => self.transcript.under_grammar(self.grammar_of_sentences(), TOKENS),
            (ConstraintKind::Grammar, Some(said)) => {
                let lists = sentence::lists(&self.vocabulary, said);
                let open = lists.iter().filter(|(_, list)| list.is_none());
                let names: Vec<&str> = open.map(|(name, _)| name.as_str()).collect();
                self.transcript.under_grammar(Self::grammar_of_names(&names), TOKENS)
            }
        }
    }

    /// Reads the sentences, or the lists of their names.
    ///
    /// # Errors
    ///
    /// The reply is cut off or refused, or it has another form.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Sighting>, DialogueError> {
        self.transcript.receive(reply)?;
        if self.kind == ConstraintKind::JsonSchema {
            return self.transcript.read_or_repeat(reply, Sighting::from_json(&reply.text));
        }
        let Some(said) = self.said.take() else {
            let lines = reply.text.lines().filter_map(|line| line.split_once(ARROW));
            let said: Vec<Said> = lines
                .flat_map(|(_, plain)| sentence::read(&self.vocabulary, plain))
                .collect();
            if said.is_empty() {
                return Err(DialogueError::Unreadable("it has no sentences".to_owned()));
            }
            let is_trained = reply.likelihood.is_some_and(|likelihood| likelihood.is_trained);
            let said = match self.words {
                None if !is_trained => self.without_made_up(said),
                _ => Some(said),
            };
            let Some(said) = said else { return Ok(None) };
            let lists = sentence::lists(&self.vocabulary, &said);
            if lists.iter().any(|(_, list)| list.is_none()) {
                self.said = Some(said);
                return Ok(None);
            }
            return Ok(Some(sighting(said, lists, &[])));
        };
        let lists = sentence::lists(&self.vocabulary, &said);
        Ok(Some(sighting(said, lists, &Sighting::named(&reply.text)?)))
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}
