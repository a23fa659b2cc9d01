//! Steps as lines of a script: `<char0> [putin] <pie> (320) <microwave> (314)`.

use std::fmt;

/// The actions of the `virtualhome` domain, the simulator's verbs for them, and the number of their arguments.
/// `walk` goes all the way, as the domain says of `walk-towards`; the simulator's `walktowards` stops after a few steps.
const VERBS: [(&str, &str, usize); 9] = [
    ("walk-towards", "walk", 1),
    ("grab", "grab", 1),
    ("open", "open", 1),
    ("close", "close", 1),
    ("put", "putback", 2),
    ("put-in", "putin", 2),
    ("switch-on", "switchon", 1),
    ("switch-off", "switchoff", 1),
    ("drink", "drink", 1),
];

/// One line of a script for the first character.
///
/// ```
/// use longstep_robot::virtualhome::Line;
/// let line = Line::new("put-in", &["<pie_320>", "<microwave_314>"])?;
/// assert_eq!(line.to_string(), "<char0> [putin] <pie> (320) <microwave> (314)");
/// assert_eq!(Line::new("dance", &[] as &[&str]).unwrap_err().to_string(), "VirtualHome has no action `dance`");
/// # Ok::<(), longstep_robot::virtualhome::LineError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    verb: &'static str,
    arguments: Vec<(String, i64)>,
}

/// A step that is no line of a script.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LineError {
    /// The simulator has no such action.
    #[error("VirtualHome has no action `{0}`")]
    Action(String),
    /// The action has another number of arguments.
    #[error("`{action}` has {expected} argument(s), not {found}")]
    Arguments {
        /// The action.
        action: String,
        /// Its number of arguments.
        expected: usize,
        /// The number of arguments that were given.
        found: usize,
    },
    /// An entity without the number of a node.
    #[error("{0} has no number: the entities of VirtualHome are written as <fridge_306>")]
    Entity(String),
}

impl Line {
    /// Returns the line for an action of the `virtualhome` domain.
    ///
    /// # Errors
    ///
    /// An action that the simulator lacks, and arguments that are not its entities.
    pub fn new(action: &str, arguments: &[impl AsRef<str>]) -> Result<Self, LineError> {
        let known = VERBS.iter().find(|(name, _, _)| *name == action);
        let (_, verb, expected) = *known.ok_or_else(|| LineError::Action(action.to_owned()))?;
        if arguments.len() != expected {
            let (action, found) = (action.to_owned(), arguments.len());
            return Err(LineError::Arguments {
                action,
                expected,
                found,
            });
        }
        let arguments = arguments
            .iter()
            .map(|own| entity(own.as_ref()))
            .collect::<Result<_, _>>()?;
        Ok(Self { verb, arguments })
    }

    /// The simulator's verb.
    pub fn verb(&self) -> &'static str {
        self.verb
    }

    /// The names of the actions of the domain that have a verb.
    pub(super) fn actions() -> impl Iterator<Item = &'static str> {
        VERBS.iter().map(|(name, _, _)| *name)
    }
}

impl fmt::Display for Line {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "<char0> [{}]", self.verb)?;
        for (class, number) in &self.arguments {
            write!(formatter, " <{class}> ({number})")?;
        }
        Ok(())
    }
}

/// Returns the class and the number of an identifier: `<kitchen_counter_230>`.
pub(super) fn entity(identifier: &str) -> Result<(String, i64), LineError> {
    let unnumbered = || LineError::Entity(longstep_core::visible::line(identifier).into_owned());
    let name = identifier.trim_start_matches('<').trim_end_matches('>');
    let (class, number) = name.rsplit_once('_').ok_or_else(unnumbered)?;
    // The name stands between brackets in a line, where nothing else may follow from it.
    let is_name =
        !class.is_empty() && !class.contains(|letter: char| letter.is_control() || "<>()[]|".contains(letter));
    match number.parse() {
        Ok(number) if is_name => Ok((class.to_owned(), number)),
        _ => Err(unnumbered()),
    }
}
