//! A file of a domain's `prompt/` folder with its variables filled in.

use minijinja::{Value, context};

use super::{template, template_context};
use crate::diagnostic::{Diagnostic, Position};
use crate::model::Domain;

/// Renders a file of `prompt/` with the domain's variables and with `more`, whose texts have `more_size` bytes.
pub(super) fn render(domain: &Domain, file: &str, more: Value, more_size: usize) -> Result<String, Diagnostic> {
    let source = domain.prompts.parts.source(file);
    let given = template_context::size(domain) + more_size;
    let variables = if more.is_undefined() {
        template_context::context(domain)
    } else {
        context! { ..more, ..template_context::context(domain) }
    };
    template::render(&source.text, variables, given)
        .map(|text| text.trim().to_owned())
        .map_err(|(line, message)| Diagnostic::at(&source.path, Position { line, column: 1 }, message))
}
