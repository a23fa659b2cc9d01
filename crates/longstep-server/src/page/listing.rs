//! The sessions and runs of a server, the latest first.

use std::sync::Arc;

use jiff::Timestamp;
use longstep::session::{Event, Log};
use maud::{Markup, html};

use crate::hub::Hub;
use crate::id::SessionId;
use crate::problem::Problem;
use crate::run::RunView;
use crate::store::LogName;

/// A run with the time of its last event.
pub(super) type TimedRun = (Option<Timestamp>, Arc<RunView>);

/// A session in a list.
pub(super) struct SessionLine {
    pub(super) id: SessionId,
    pub(super) changed: Option<Timestamp>,
    /// The last instruction; none for a session without one.
    pub(super) instruction: Option<String>,
    /// The number of instructions.
    pub(super) instructions: usize,
}

/// Returns the latest sessions, and the number of all.
///
/// Their logs are read, not owned: a list does not take a session from the program that has it open.
pub(super) fn latest_sessions(hub: &Hub, limit: usize) -> Result<(Vec<SessionLine>, usize), Problem> {
    let mut sessions = Vec::new();
    for id in hub.sessions()? {
        let changed = hub.store.changed_at(&LogName::Session(id.clone()))?;
        sessions.push((changed, id));
    }
    sessions.sort_by(|one, other| other.cmp(one));
    let count = sessions.len();
    sessions.truncate(limit);
    let lines = sessions.into_iter().map(|(changed, id)| {
        let instructions = instructions(hub, &id);
        SessionLine {
            id,
            changed,
            instructions: instructions.len(),
            instruction: instructions.into_iter().next_back(),
        }
    });
    Ok((lines.collect(), count))
}

/// Returns the instructions of a session; none if its log cannot be read, which opening it explains.
fn instructions(hub: &Hub, id: &SessionId) -> Vec<String> {
    let bytes = hub.store.read(&LogName::Session(id.clone())).ok().flatten();
    let log = bytes.and_then(|bytes| Log::read(&bytes).ok());
    let events = log.iter().flat_map(Log::events);
    events
        .filter_map(|event| match event {
            Event::Instruction { text } => Some(text.clone()),
            _ => None,
        })
        .collect()
}

/// Returns the runs, the latest first.
pub(super) fn latest_runs(hub: &Hub) -> Vec<TimedRun> {
    let timed = |run: Arc<RunView>| {
        let changed = hub.store.changed_at(&LogName::Run(run.record.id.clone()));
        (changed.ok().flatten(), run)
    };
    let mut runs: Vec<_> = hub.runs().into_iter().map(timed).collect();
    runs.sort_by(|(one, _), (other, _)| other.cmp(one));
    runs
}

/// Writes a time; the script shows it in the time zone of the browser.
pub(super) fn time(at: Option<Timestamp>) -> Markup {
    html! {
        @if let Some(at) = at {
            time datetime=(at.strftime("%Y-%m-%dT%H:%M:%SZ")) { (at.strftime("%Y-%m-%d %H:%M:%S UTC")) }
        }
    }
}
