//! The audit log as a table.

use jiff::Timestamp;
use maud::{Markup, html};

use super::listing::time;
use super::sheet::Sheet;
use crate::audit::{AuditEntry, Deed};
use crate::hub::Hub;
use crate::problem::Problem;

/// The most lines that the page shows.
const LINES: usize = 500;

/// Writes the audit log, the newest line first.
///
/// # Errors
///
/// The log cannot be read.
pub(crate) fn audit(hub: &Hub) -> Result<Sheet, Problem> {
    let entries = hub.audit().last(LINES)?;
    let live = html! {
        h1 { "Audit log" }
        p.quiet { "Who approved, refused, started and stopped what; the newest first, at most " (LINES) " lines." }
        @if entries.is_empty() {
            p { "Nothing was approved or started yet." }
        } @else {
            div.wide tabindex="0" role="region" aria-label="Audit log" {
                table.audit {
                    thead { tr { th scope="col" { "Time" } th scope="col" { "Who" } th scope="col" { "Deed" } th scope="col" { "What" } } }
                    tbody { @for entry in &entries { (line(entry)) } }
                }
            }
        }
    };
    Ok(Sheet {
        follows: Some(String::new()),
        is_going: hub.runs().iter().any(|run| !run.state.is_ended()),
        ..Sheet::new("Audit log", "/audit", live)
    })
}

fn line(entry: &AuditEntry) -> Markup {
    let at: Option<Timestamp> = entry.at.parse().ok();
    html! {
        tr {
            td { @if at.is_some() { (time(at)) } @else { (entry.at) } }
            td { (entry.by) }
            td { (word(&entry.deed)) }
            td { (subject(&entry.deed)) }
        }
    }
}

fn word(deed: &Deed) -> &'static str {
    match deed {
        Deed::Accepted { .. } => "accepted",
        Deed::Approved { .. } => "approved",
        Deed::Refused { .. } => "refused",
        Deed::Started { .. } => "started",
        Deed::Decided { yes: true, .. } => "answered yes",
        Deed::Decided { yes: false, .. } => "answered no",
        Deed::Paused { .. } => "paused",
        Deed::Continued { .. } => "continued",
        Deed::Stopped { .. } => "asked to stop",
        Deed::Ended { .. } => "ended",
    }
}

fn subject(deed: &Deed) -> Markup {
    let run = |id: &crate::RunId| html! { a href={ "/runs/" (id) } { "run " (short(id.as_str())) } };
    let session = |id: &crate::SessionId| html! { a href={ "/sessions/" (id) } { "session " (short(id.as_str())) } };
    let plan = |hash: &str| html! { "plan " code title=(hash) { (short(hash)) } };
    match deed {
        Deed::Accepted {
            session: id,
            plan: hash,
        } => html! { (plan(hash)) " of " (session(id)) },
        Deed::Approved {
            session: id,
            plan: hash,
            robot,
            ..
        } => html! { (plan(hash)) " of " (session(id)) " for " (robot) },
        Deed::Refused {
            session: id,
            plan: hash,
            why,
        } => html! { (plan(hash)) " of " (session(id)) ": " (why) },
        Deed::Started {
            run: id,
            plan: hash,
            robot,
            ..
        } => html! { (run(id)) " of " (plan(hash)) " on " (robot) },
        Deed::Decided { run: id, proposal, .. } => html! {
            (run(id)) @if let Some(hash) = proposal { ", proposal " code title=(hash) { (short(hash)) } }
        },
        Deed::Paused { run: id } | Deed::Continued { run: id } => run(id),
        Deed::Stopped { run: Some(id) } => run(id),
        Deed::Stopped { run: None } => html! { "all robots" },
        Deed::Ended { run: id, end } => html! { (run(id)) ": " (end) },
    }
}

/// Returns the first characters of an id or a hash, for people who compare two.
pub(super) fn short(id: &str) -> String {
    id.chars().take(8).collect()
}
