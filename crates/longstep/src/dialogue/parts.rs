//! The fixed parts of the direct strategy's conversation: role, actions, environment, format, examples.
//!
//! Each is a template, the library's own or one of the domain's `prompt/` folder, rendered from the domain when it is
//! asked for. The sixth part, the query, is made anew for each instruction (`query`).

use minijinja::{Value, context};

use super::dialogue::TOO_MUCH_WORK;
use super::{Message, OverBudget, Role, template, template_context, worked};
use crate::diagnostic::{Diagnostic, Diagnostics, Position};
use crate::model::Domain;

/// What a model says to a part that asks nothing of it.
const UNDERSTOOD: &str = "Understood. I am waiting.";

/// A fixed part of the conversation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PartName {
    /// What the model is to be.
    Role,
    /// What the robot can do.
    Actions,
    /// How the world is written.
    Environment,
    /// How an answer is written, and the rules that a plan keeps.
    Format,
    /// Worked examples, each a query and its answer.
    Examples,
}

impl PartName {
    /// Every part, in the order of the conversation.
    pub const ALL: [PartName; 5] = [
        Self::Role,
        Self::Actions,
        Self::Environment,
        Self::Format,
        Self::Examples,
    ];

    /// The name that people see.
    pub fn name(self) -> &'static str {
        match self {
            Self::Role => "role",
            Self::Actions => "actions",
            Self::Environment => "environment",
            Self::Format => "format",
            Self::Examples => "examples",
        }
    }

    /// The file of `prompt/` that it is made from.
    pub fn file(self) -> &'static str {
        match self {
            Self::Role => "role.md",
            Self::Actions => "actions.md",
            Self::Environment => "environment.md",
            Self::Format => "format.md",
            Self::Examples => "plans.toml",
        }
    }
}

/// A fixed part with its turns: the role is the system's, each other part is said by the user and acknowledged, and
/// examples are pairs of a query and its answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Which part.
    pub name: PartName,
    /// Its turns.
    pub messages: Vec<Message>,
}

/// Why there is no prompt.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PromptError {
    /// A file of the domain's `prompt/` cannot be used: each finding has its file and line.
    #[error(transparent)]
    Broken(#[from] Diagnostics),
    /// It does not fit.
    #[error(transparent)]
    OverBudget(#[from] OverBudget),
    /// Finding the goals that make sense in the world takes more work than its budget.
    #[error("{TOO_MUCH_WORK}")]
    TooMuchWork,
}

/// Renders the fixed parts, in the order in which they are said.
///
/// Examples are planned for and checked on the way, so that none can be out of date; this takes milliseconds, and
/// nothing of it happens when a domain is loaded.
///
/// ```
/// use longstep::{domain, dialogue};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let parts = dialogue::fixed_parts(&household).unwrap();
/// assert_eq!(parts.len(), 5);
/// assert!(parts[1].messages[0].text.contains("- grasp_object(): "));
/// ```
///
/// # Errors
///
/// Everything that is wrong with the domain's `prompt/` files, with file and line: [`PromptError::Broken`].
pub fn fixed_parts(domain: &Domain) -> Result<Vec<Part>, PromptError> {
    let mut parts = Vec::new();
    let mut findings = Vec::new();
    for name in PartName::ALL {
        let messages = match name {
            PartName::Examples => worked::turns(domain),
            _ => text_part(domain, name).map_err(|finding| vec![finding]),
        };
        match messages {
            Ok(messages) => parts.push(Part { name, messages }),
            Err(found) => findings.extend(found),
        }
    }
    if findings.is_empty() {
        Ok(parts)
    } else {
        Err(PromptError::Broken(Diagnostics::sorted(findings)))
    }
}

/// Everything that is wrong with what the direct strategy would tell a model, sorted; nothing for a good domain.
pub(crate) fn broken_parts(domain: &Domain) -> Vec<Diagnostic> {
    let mut findings = match fixed_parts(domain) {
        Err(PromptError::Broken(Diagnostics(findings))) => findings,
        _ => Vec::new(),
    };
    let shown = ["{environment}", "{instruction}"];
    match render(
        domain,
        "query.md",
        context! { environment => shown[0], instruction => shown[1] },
        0,
    ) {
        Ok(text) => {
            let source = domain.prompts.parts.source("query.md");
            let left_out = shown.iter().filter(|variable| !text.contains(**variable));
            findings.extend(left_out.map(|variable| {
                let message = format!("the query does not show `{}`", variable.trim_matches(['{', '}']));
                Diagnostic::whole(&source.path, message).hint(format!("write `{{{variable}}}` where it belongs"))
            }));
        }
        Err(finding) => findings.push(finding),
    }
    Diagnostics::sorted(findings).0
}

fn text_part(domain: &Domain, name: PartName) -> Result<Vec<Message>, Diagnostic> {
    let text = render(domain, name.file(), Value::UNDEFINED, 0)?;
    Ok(match name {
        PartName::Role => vec![Message::new(Role::System, text)],
        _ => vec![
            Message::new(Role::User, text),
            Message::new(Role::Assistant, UNDERSTOOD),
        ],
    })
}

/// Renders a file of `prompt/` with what the domain says, and with `more`, whose texts have `more_size` bytes.
pub(super) fn render(domain: &Domain, file: &str, more: Value, more_size: usize) -> Result<String, Diagnostic> {
    let source = domain.prompts.parts.source(file);
    let given = template_context::size(domain) + more_size;
    let variables = match more.is_undefined() {
        true => template_context::context(domain),
        false => context! { ..more, ..template_context::context(domain) },
    };
    template::render(&source.text, variables, given)
        .map(|text| text.trim().to_owned())
        .map_err(|(line, message)| Diagnostic::at(&source.path, Position { line, column: 1 }, message))
}
