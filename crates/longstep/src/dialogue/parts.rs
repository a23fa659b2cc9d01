//! The fixed parts of a direct-strategy prompt: role, actions, environment, format, examples.
//!
//! Each part is a template, from this library or from the domain's `prompt/` folder, and is rendered on demand. The
//! sixth part, the query, changes with each instruction (`query`).

use minijinja::{Value, context};

use super::rendered::render;
use super::transcript::TOO_MUCH_WORK;
use super::{Message, OverBudget, Role, worked};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::Domain;

/// The assistant message after a part that asks for no plan.
const UNDERSTOOD: &str = "Understood. I am waiting.";

/// A fixed part of the conversation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PartName {
    /// The model's task.
    Role,
    /// The robot's actions.
    Actions,
    /// The notation of environments.
    Environment,
    /// The notation of answers, and the rules for plans.
    Format,
    /// Few-shot examples, each a query with its answer.
    Examples,
}

impl PartName {
    /// All parts, in prompt order.
    pub const ALL: [PartName; 5] = [
        Self::Role,
        Self::Actions,
        Self::Environment,
        Self::Format,
        Self::Examples,
    ];

    /// Returns the name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::Role => "role",
            Self::Actions => "actions",
            Self::Environment => "environment",
            Self::Format => "format",
            Self::Examples => "examples",
        }
    }

    /// Returns the file of `prompt/` with the template.
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

/// A fixed part with its messages. The role is a system message; each other part is a user message with an
/// acknowledgement. Examples are pairs of a query and an answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// The part.
    pub name: PartName,
    /// Its messages.
    pub messages: Vec<Message>,
}

/// Reason why no prompt can be built.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PromptError {
    /// A file of the domain's `prompt/` is invalid; each finding has a file and a line.
    #[error(transparent)]
    Broken(#[from] Diagnostics),
    /// The prompt exceeds the token budget.
    #[error(transparent)]
    OverBudget(#[from] OverBudget),
    /// Enumerating the possible goals exceeds the work budget.
    #[error("{TOO_MUCH_WORK}")]
    TooMuchWork,
}

/// Renders the fixed parts, in prompt order.
///
/// The examples are planned and verified each time, so they always match the domain. This takes milliseconds; loading a
/// domain does none of it.
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
/// All errors in the domain's `prompt/` files, with file and line: [`PromptError::Broken`].
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

/// Returns all errors in the direct strategy's prompt files, sorted.
pub fn broken_parts(domain: &Domain) -> Vec<Diagnostic> {
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
