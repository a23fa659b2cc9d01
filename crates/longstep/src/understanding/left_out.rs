//! The words of an instruction that its goal does not say.

use std::fmt;

/// What kind of words a goal does not say. The kind decides whether they are a question or a note.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LeftOutKind {
    /// A deadline, an hour, a date.
    Time,
    /// How something is done: quietly, neatly.
    Manner,
    /// Why something is wished.
    Reason,
    /// How much, how often, how long.
    Amount,
    /// A case or an occasion in which something is wished.
    Condition,
    /// The order of things.
    Order,
    /// A text that somebody is to be told.
    Message,
    /// Something that is forbidden.
    Prohibition,
    /// A further wish.
    Wish,
}

impl LeftOutKind {
    /// All kinds.
    pub const ALL: [Self; 9] = [
        Self::Time,
        Self::Manner,
        Self::Reason,
        Self::Amount,
        Self::Condition,
        Self::Order,
        Self::Message,
        Self::Prohibition,
        Self::Wish,
    ];

    /// Returns the word for the kind in an answer.
    pub fn word(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Manner => "manner",
            Self::Reason => "reason",
            Self::Amount => "amount",
            Self::Condition => "condition",
            Self::Order => "order",
            Self::Message => "message",
            Self::Prohibition => "prohibition",
            Self::Wish => "wish",
        }
    }

    /// Reads the word for a kind.
    pub fn read(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.word() == word)
    }

    /// Returns true if the plan would be another one if a goal could say such words.
    pub fn changes_the_plan(self) -> bool {
        !matches!(self, Self::Time | Self::Manner | Self::Reason)
    }
}

impl fmt::Display for LeftOutKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.word())
    }
}

/// Words of an instruction that the goal does not say.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct LeftOut {
    /// The words, as they were said.
    pub text: String,
    /// Their kind.
    pub kind: LeftOutKind,
}
