//! The dialogue with a model about a description or pictures.

use serde_json::{Value, json};

use super::example::sight_examples;
use super::sighting::{COMMA, KINDS, LABEL, NAMES, NONE, PLAIN, SEMICOLON, Sighting};
use super::vocabulary::{List, Vocabulary};
use crate::dialogue::answer_grammar::{Form, any_text, closed, list, one_of};
use crate::dialogue::{
    ChatRequest, ConstraintKind, Dialogue, DialogueError, Message, Picture, Reply, Role, Transcript, one_line,
};
use crate::model::Domain;

/// The task, with a place for the states of the domain.
const TASK: &str = include_str!("sight.txt");
/// The form of a server's answer.
const JSON_FORM: &str = "Answer with JSON: `assets` and `objects` are lists of names, `states` lists the states with their \
    entity and the names of the other entities, and `unsure` lists in plain words what cannot be seen well.";
/// The form of an embedded model's answer.
const LINE_FORM: &str = "Answer with a line of plain English sentences, one for each fact, a line of all names, each with asset or \
object, and then a line for each name with its states.";
/// Token budget of an answer.
const TOKENS: u32 = 4096;
/// Maximum number of characters of the description in plain sentences.
const PLAIN_LENGTH: usize = 2_000;
/// A name in the line form.
pub(super) const NAME: &str = "[a-z][a-z0-9]{0,19}(_[a-z0-9]{1,19}){0,3}";
/// Maximum number of states of one entity in the line form.
const STATES: usize = 3;
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
/// An embedded model answers in lines: plain English sentences and the names, then, in a second request, the states of each of
/// these names. A
/// server answers in JSON, in one request.
///
/// ```
/// use longstep::Planner;
/// use longstep::dialogue::{ConstraintKind, Dialogue, Finish, Reply, Usage};
/// use longstep::perception::{SightDialogue, SightInput, View};
///
/// let planner = Planner::shipped("household")?;
/// let domain = planner.domain();
/// let input = SightInput { domain, words: "Milk in a fridge", pictures: &[], kind: ConstraintKind::Grammar };
/// let mut dialogue = SightDialogue::new(&input);
/// let reply = |text: &str| Reply { text: text.to_owned(), finish: Finish::Stop, usage: Usage::default(), likelihood: None };
/// assert!(dialogue.supply(&reply("plain: The milk is in the fridge.\nnames: milk object, fridge asset\n"))?.is_none());
/// let sighting = dialogue.supply(&reply("milk: inside_something(fridge)\nfridge: none"))?.unwrap();
/// let view = View::of(domain, &sighting);
/// assert_eq!(view.environment.object_states["<milk>"].as_slice(), ["inside_something(<fridge>)"]);
/// assert!(view.world.is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct SightDialogue<'a> {
    vocabulary: Vocabulary<'a>,
    kind: ConstraintKind,
    transcript: Transcript,
    /// The names, once the model has listed them in the line form.
    listed: Option<Vec<(String, List)>>,
}

impl<'a> SightDialogue<'a> {
    /// Starts a dialogue. Only the first 4,000 characters of the words are used.
    pub fn new(input: &SightInput<'a>) -> Self {
        let vocabulary = Vocabulary::of(input.domain);
        let form = match input.kind {
            ConstraintKind::Grammar => LINE_FORM,
            ConstraintKind::JsonSchema => JSON_FORM,
        };
        let task = format!("{}{form}", TASK.replace("{states}", &meanings(&vocabulary)));
        let mut messages = vec![Message::new(Role::System, task)];
        for example in sight_examples(&vocabulary) {
            let answer = match input.kind {
                ConstraintKind::Grammar => {
                    let written = example.sighting.written(&example.names());
                    format!("{PLAIN}{}\n{written}", example.plain(&vocabulary))
                }
                ConstraintKind::JsonSchema => json_of(&example.sighting).to_string(),
            };
            messages.push(Message::new(Role::User, example.text));
            messages.push(Message::new(Role::Assistant, answer));
        }
        let mut transcript = Transcript::new(input.kind, messages);
        let words: String = one_line(input.words).chars().take(LENGTH).collect();
        let words = match (words.is_empty(), input.pictures.is_empty()) {
            (true, false) => "Write down what the picture shows.".to_owned(),
            _ => words,
        };
        transcript.push_with_pictures(Role::User, words, input.pictures.to_vec());
        Self {
            vocabulary,
            kind: input.kind,
            transcript,
            listed: None,
        }
    }

    /// Returns the grammar of the plain sentences and the names.
    fn grammar_of_names() -> String {
        let kinds = Form::texts(KINDS.iter().map(|(kind, _)| (*kind).to_owned()));
        let name = Form::Row(vec![Form::Pattern(NAME.to_owned()), kinds]);
        let names = name.separated(Form::text(COMMA), NAMES);
        let names = Form::Either(vec![Form::text(NONE), names]);
        let plain = Form::Pattern(format!("[^\\n]{{1,{PLAIN_LENGTH}}}"));
        let label = Form::text(format!("\n{LABEL}"));
        Form::Row(vec![Form::text(PLAIN), plain, label, names, Form::text("\n")]).grammar()
    }

    /// Returns the grammar of a line of states for each name.
    fn grammar_of_states(&self, listed: &[(String, List)]) -> String {
        let names: Vec<(&str, List)> = listed.iter().map(|(name, list)| (name.as_str(), *list)).collect();
        let mut row = Vec::new();
        for (index, (name, list)) in names.iter().enumerate() {
            let start = if index == 0 {
                format!("{name}: ")
            } else {
                format!("\n{name}: ")
            };
            row.push(Form::text(start));
            row.push(states_form(self.vocabulary.forms(name, *list, &names)));
        }
        Form::Row(row).grammar()
    }
}

/// The form of the states of one entity.
pub(super) fn states_form(states: Vec<Form>) -> Form {
    let none = Form::text(NONE);
    match states.is_empty() {
        true => none,
        false => Form::Either(vec![
            none,
            Form::Either(states).separated(Form::text(SEMICOLON), STATES),
        ]),
    }
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

/// The JSON schema of a server's answer.
fn schema(vocabulary: &Vocabulary<'_>) -> Value {
    let words: Vec<String> = vocabulary.words().map(|word| word.word.clone()).collect();
    let state = closed(&[
        ("entity", any_text()),
        ("state", one_of(Some(&words))),
        ("arguments", list(any_text())),
    ]);
    closed(&[
        ("assets", list(any_text())),
        ("objects", list(any_text())),
        ("states", list(state)),
        ("unsure", list(any_text())),
    ])
}

impl Dialogue for SightDialogue<'_> {
    type Output = Sighting;

    fn request(&self) -> ChatRequest {
        match (self.kind, &self.listed) {
            (ConstraintKind::JsonSchema, _) => self.transcript.under_schema(schema(&self.vocabulary), TOKENS),
            (ConstraintKind::Grammar, None) => self.transcript.under_grammar(Self::grammar_of_names(), TOKENS),
            (ConstraintKind::Grammar, Some(listed)) => {
                self.transcript.under_grammar(self.grammar_of_states(listed), TOKENS)
            }
        }
    }

    /// Reads names, or the states of the names.
    ///
    /// # Errors
    ///
    /// The reply is cut off or refused, or it has another form.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Sighting>, DialogueError> {
        self.transcript.receive(reply)?;
        if self.kind == ConstraintKind::JsonSchema {
            return Sighting::from_json(&reply.text).map(Some);
        }
        let Some(listed) = self.listed.take() else {
            let listed = Sighting::named(&reply.text)?;
            if listed.is_empty() {
                return Ok(Some(Sighting::default()));
            }
            self.listed = Some(listed);
            return Ok(None);
        };
        let mut sighting = Sighting::of_names(&listed);
        for line in reply.text.lines() {
            let (name, states) = line
                .split_once(": ")
                .ok_or_else(|| DialogueError::Unreadable(format!("a line without a name: `{line}`")))?;
            sighting.add_line(name, states);
        }
        Ok(Some(sighting))
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}
