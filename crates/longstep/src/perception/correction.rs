//! The dialogue with a model about a correction of a view.

use super::dialogue::{NAME, meanings, states_form};
use super::example::correction_examples;
use super::sighting::{Sighting, plain};
use super::vocabulary::{List, Vocabulary};
use crate::dialogue::answer_grammar::Form;
use crate::dialogue::{
    ChatRequest, ConstraintKind, Dialogue, DialogueError, Message, Reply, Role, Transcript, one_line,
};
use crate::model::Domain;

const TASK: &str = "A robot has this list of assets and objects with their states, and a person corrects it. Write only the lines \
that change: `NAME: STATES` for something in the list, `new NAME: STATES` for something that is missing in it, and `absent NAME` \
for something that is not there.\nThe states are:\n";
/// Token budget of an answer.
const TOKENS: u32 = 512;
/// Maximum number of lines in an answer.
const LINES: usize = 6;
/// Maximum number of characters of a correction.
const LENGTH: usize = 1_000;
/// The beginning of a line about an entity that is missing in the list.
const NEW: &str = "new ";
/// The beginning of a line about an entity that is not there.
const ABSENT: &str = "absent ";

/// Lets a model read a person's correction of a view. One request, one reply; the lines have one form for embedded models and
/// servers.
#[derive(Debug, Clone)]
pub struct CorrectionDialogue<'a> {
    vocabulary: Vocabulary<'a>,
    before: Sighting,
    transcript: Transcript,
}

impl<'a> CorrectionDialogue<'a> {
    /// Starts a dialogue about a correction of a sighting. Only the first 1,000 characters of the words are used.
    pub fn new(domain: &'a Domain, before: &Sighting, words: &str, kind: ConstraintKind) -> Self {
        let vocabulary = Vocabulary::of(domain);
        let task = format!("{TASK}{}", meanings(&vocabulary));
        let mut messages = vec![Message::new(Role::System, task)];
        for example in correction_examples(&vocabulary) {
            messages.push(Message::new(Role::User, question(&example.before, &example.text)));
            messages.push(Message::new(Role::Assistant, example.answer));
        }
        let mut transcript = Transcript::new(kind, messages);
        let words: String = one_line(words).chars().take(LENGTH).collect();
        transcript.push(Role::User, question(before, &words));
        Self {
            vocabulary,
            before: before.clone(),
            transcript,
        }
    }

    fn grammar(&self) -> String {
        let names = self.before.names();
        let mut lines: Vec<Form> = names
            .iter()
            .map(|(name, list)| {
                let states = states_form(self.vocabulary.forms(name, *list, &names));
                Form::Row(vec![Form::text(format!("{name}: ")), states])
            })
            .collect();
        let states = states_form(self.vocabulary.forms("", List::Objects, &names));
        let name = Form::Pattern(NAME.to_owned());
        lines.push(Form::Row(vec![Form::text(NEW), name, Form::text(": "), states]));
        if !names.is_empty() {
            let all = Form::texts(names.iter().map(|(name, _)| (*name).to_owned()));
            lines.push(Form::Row(vec![Form::text(ABSENT), all]));
        }
        Form::Either(lines).separated(Form::text("\n"), LINES).grammar()
    }
}

fn question(before: &Sighting, words: &str) -> String {
    format!("{}\n\n{words}", before.written(&before.names()))
}

impl Dialogue for CorrectionDialogue<'_> {
    type Output = Sighting;

    fn request(&self) -> ChatRequest {
        match self.transcript.kind {
            ConstraintKind::Grammar => self.transcript.under_grammar(self.grammar(), TOKENS),
            ConstraintKind::JsonSchema => self.transcript.free(TOKENS),
        }
    }

    /// Reads the lines that change.
    ///
    /// # Errors
    ///
    /// The reply is cut off or refused, or it has another form.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Sighting>, DialogueError> {
        self.transcript.receive(reply)?;
        let mut change = Sighting::default();
        let known = self.before.names();
        for line in reply
            .text
            .lines()
            .map(str::trim)
            .filter(|line| !line.is_empty())
            .take(LINES)
        {
            if let Some(name) = line.strip_prefix(ABSENT) {
                change.absent.push(plain(name));
                continue;
            }
            let unreadable = || DialogueError::Unreadable(format!("a line without a name: `{}`", one_line(line)));
            let (name, states) = line.split_once(':').ok_or_else(unreadable)?;
            let name = plain(name.strip_prefix(NEW).unwrap_or(name));
            if !known.iter().any(|(own, _)| *own == name) {
                change.objects.push(name.clone());
            }
            change.add_line(&name, states);
        }
        Ok(Some(change))
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}
