//! The client that calls, and its era of the protocol.

use rmcp::model::{ClientCapabilities, ProgressNotificationParam, ProgressToken};
use rmcp::service::{Peer, RequestContext, RoleServer};
use tokio_util::sync::CancellationToken;

/// The longest name of a client in the audit log, in characters.
const LONGEST_NAME: usize = 60;

/// The client that calls a tool.
#[derive(Debug, Clone)]
pub(super) struct Caller {
    /// The name in the audit log: `mcp:` and the name that the client gives itself.
    pub(super) by: String,
    /// True before protocol 2026-07-28: the server may send requests to the client.
    pub(super) is_asked_directly: bool,
    /// True if the client says that it can show forms.
    pub(super) shows_forms: bool,
    /// The way to the client.
    pub(super) peer: Peer<RoleServer>,
    /// Cancelled when the client takes its call back.
    pub(super) cancelled: CancellationToken,
    /// The name of the call in reports of its progress; none if the client wants no reports.
    progress: Option<ProgressToken>,
}

impl Caller {
    pub(super) fn of(context: &RequestContext<RoleServer>) -> Self {
        let name = context.client_info().map(|client| client.name);
        let version = context.protocol_version();
        Self {
            by: name_of(name.as_deref().unwrap_or_default()),
            is_asked_directly: version.is_none_or(|version| version.has_initialize()),
            shows_forms: context.client_capabilities().is_some_and(|own| shows_forms(&own)),
            peer: context.peer.clone(),
            cancelled: context.ct.clone(),
            progress: context.meta.get_progress_token(),
        }
    }

    /// Reports the progress of a call, if the client wants that. Clients wait longer for calls with reports.
    pub(super) async fn report(&self, number: u32, text: &str) {
        if let Some(token) = &self.progress {
            let report = ProgressNotificationParam::new(token.clone(), f64::from(number)).with_message(text);
            // A client that has gone needs no report.
            let _ = self.peer.notify_progress(report).await;
        }
    }
}

/// Returns the name in the audit log, on one line and not too long.
fn name_of(client: &str) -> String {
    let is_plain = |c: &char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | '/' | ' ');
    let name: String = client.trim().chars().filter(is_plain).take(LONGEST_NAME).collect();
    format!("mcp:{}", if name.is_empty() { "unknown" } else { &name })
}

/// Returns true for a client with forms; one that names no mode has them.
fn shows_forms(capabilities: &ClientCapabilities) -> bool {
    let elicitation = capabilities.elicitation.as_ref();
    elicitation.is_some_and(|own| own.form.is_some() || own.url.is_none())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn name_in_the_audit_log_is_one_short_line() {
        for (client, name) in [
            ("claude-code", "mcp:claude-code"),
            ("", "mcp:unknown"),
            (" \n\u{1b}[2J", "mcp:2J"),
            ("page\n{\"deed\":\"approved\"}", "mcp:pagedeedapproved"),
        ] {
            assert_eq!(name_of(client), name);
        }
        assert_eq!(name_of(&"a".repeat(1_000)).len(), "mcp:".len() + LONGEST_NAME);
    }

    #[test]
    fn forms_are_shown_by_clients_that_say_so() {
        for (capabilities, shows) in [
            (r#"{}"#, false),
            (r#"{"elicitation": {}}"#, true),
            (r#"{"elicitation": {"form": {}}}"#, true),
            (r#"{"elicitation": {"form": {}, "url": {}}}"#, true),
            (r#"{"elicitation": {"url": {}}}"#, false),
        ] {
            let read: ClientCapabilities = serde_json::from_str(capabilities).unwrap();
            assert_eq!(shows_forms(&read), shows, "{capabilities}");
        }
    }
}
