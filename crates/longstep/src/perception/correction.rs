//! The dialogue with a model about a correction of a view.

use super::dialogue::meanings;
use super::example::correction_examples;
use super::sentence::{self, Said};
use super::sighting::Sighting;
use super::vocabulary::Vocabulary;
use crate::dialogue::{
    ChatRequest, ConstraintKind, Dialogue, DialogueError, Message, Reply, Role, Transcript, one_line,
};
use crate::model::Domain;

const TASK: &str = "A robot has this description of a place, and a person corrects it, in any language. Write in plain English \
sentences only what is different: what is so now, \"There is a NAME\" for something new of which no more is said, and \"There is no \
NAME\" for something that is not there.\nThe states are:\n";
/// Token budget of an answer.
const TOKENS: u32 = 512;
/// Maximum number of characters of a correction.
const LENGTH: usize = 1_000;

/// Lets a model read a person's correction of a view. One request, one reply; embedded models and servers answer in the same
/// sentences. Names that the view does not have are new objects.
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
            let question = question(&vocabulary, &example.before, &example.text);
            messages.push(Message::new(Role::User, question));
            messages.push(Message::new(Role::Assistant, example.answer));
        }
        let mut transcript = Transcript::new(kind, messages);
        let words: String = one_line(words).chars().take(LENGTH).collect();
        transcript.push(Role::User, question(&vocabulary, before, &words));
        Self {
            vocabulary,
            before: before.clone(),
            transcript,
        }
    }
}

fn question(vocabulary: &Vocabulary<'_>, before: &Sighting, words: &str) -> String {
    format!("{}\n\n{words}", sentence::written(vocabulary, before, &before.names()))
}

impl Dialogue for CorrectionDialogue<'_> {
    type Output = Sighting;

    fn request(&self) -> ChatRequest {
        match self.transcript.kind {
            ConstraintKind::Grammar => {
                let form = sentence::correction_form(&self.vocabulary);
                self.transcript.under_grammar(form.grammar(), TOKENS)
            }
            ConstraintKind::JsonSchema => self.transcript.free(TOKENS),
        }
    }

    /// Reads the sentences. Those that no state says are in [`Sighting::left_out`].
    ///
    /// # Errors
    ///
    /// The reply is cut off or refused.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Sighting>, DialogueError> {
        self.transcript.receive(reply)?;
        let mut change = Sighting::default();
        let known: Vec<&str> = self.before.names().into_iter().map(|(name, _)| name).collect();
        let said = sentence::read(&self.vocabulary, &reply.text);
        let names = sentence::names(&self.vocabulary, &said).into_iter();
        change.objects = names.filter(|name| !known.contains(&name.as_str())).collect();
        for sentence in said {
            match sentence {
                Said::State(statement) => change.statements.push(statement),
                Said::Absent(name) => change.absent.push(name),
                Said::Other(text) => change.left_out.push(text),
                Said::There(_) => {}
            }
        }
        Ok(Some(change))
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}
