//! The resources: the world and the plan of a session.

use rmcp::model::{ErrorData, ReadResourceResponse, ReadResourceResult, Resource, ResourceContents, ResourceTemplate};
use serde_json::Value;

use super::face::Face;
use crate::problem::{Problem, ProblemKind};

const WORLD: &str = "longstep://world";
const PLAN: &str = "longstep://plan";
const SESSIONS: &str = "longstep://sessions/";
const JSON: &str = "application/json";

/// The resources of a connection.
pub(super) fn all() -> Vec<Resource> {
    [
        (
            WORLD,
            "world",
            "The world before the next instruction, as an environment of Longstep",
        ),
        (
            PLAN,
            "plan",
            "The plan that waits for a decision, as a plan file of Longstep",
        ),
    ]
    .into_iter()
    .map(|(uri, name, description)| {
        Resource::new(uri, name)
            .with_description(description)
            .with_mime_type(JSON)
    })
    .collect()
}

/// The resources of named sessions.
pub(super) fn templates() -> Vec<ResourceTemplate> {
    ["world", "plan"]
        .into_iter()
        .map(|name| {
            ResourceTemplate::new(format!("{SESSIONS}{{session}}/{name}"), format!("{name} of a session"))
                .with_mime_type(JSON)
        })
        .collect()
}

/// Returns the session that an address names, and the part of it; none if there is no such resource.
fn parts(uri: &str) -> Option<(Option<&str>, &str)> {
    match uri {
        WORLD => Some((None, "world")),
        PLAN => Some((None, "plan")),
        _ => {
            let (session, part) = uri.strip_prefix(SESSIONS)?.split_once('/')?;
            matches!(part, "world" | "plan").then_some((Some(session), part))
        }
    }
}

impl Face {
    /// Reads a resource.
    ///
    /// # Errors
    ///
    /// There is no such resource.
    pub(super) async fn resource(&self, uri: &str) -> Result<ReadResourceResponse, ErrorData> {
        let missing = |why: &str| ErrorData::resource_not_found(format!("there is no resource `{uri}`: {why}"), None);
        let (session, part) = parts(uri).ok_or_else(|| missing("its address is unknown"))?;
        let session = self.session(session).map_err(|problem| missing(&problem.message))?;
        let is_plan = part == "plan";
        let read = self.work(move |shared| {
            let no_plan = || Problem::new(ProblemKind::Missing, "no plan waits for a decision");
            let read = match (&session, is_plan) {
                (None, true) => return Err(no_plan()),
                (None, false) => serde_json::to_value(shared.hub.place(&shared.options.start)?.1.environment()),
                (Some(id), true) => {
                    let snapshot = shared.hub.session(id)?;
                    let proposal = snapshot.view.proposal.as_ref().ok_or_else(no_plan)?;
                    serde_json::to_value(&proposal.answer.plan)
                }
                (Some(id), false) => serde_json::to_value(&shared.hub.session(id)?.view.environment),
            };
            Ok(read.unwrap_or(Value::Null))
        });
        let value = read.await.map_err(|problem| missing(&problem.message))?;
        let contents = ResourceContents::text(format!("{value:#}"), uri).with_mime_type(JSON);
        Ok(ReadResourceResult::new(vec![contents]).into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn address_names_a_session_and_a_part() {
        for (uri, expected) in [
            ("longstep://world", Some((None, "world"))),
            ("longstep://plan", Some((None, "plan"))),
            ("longstep://sessions/ab/plan", Some((Some("ab"), "plan"))),
            ("longstep://sessions/../world/x", None),
            ("longstep://sessions/ab", None),
            ("longstep://sessions/ab/audit", None),
            ("file:///etc/passwd", None),
        ] {
            assert_eq!(parts(uri), expected, "{uri}");
        }
    }
}
