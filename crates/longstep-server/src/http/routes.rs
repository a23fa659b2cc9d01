//! The paths of the server. One table, from which the router and the description are made.

use axum::routing::{MethodRouter, get, post};

use super::{Shared, api};

/// A path of the server.
pub(crate) struct Route {
    /// `get` or `post`.
    pub(crate) method: &'static str,
    pub(crate) path: &'static str,
    /// The name of the operation for generated clients.
    pub(crate) name: &'static str,
    pub(crate) summary: &'static str,
    /// The name of the schema of the body; none for a request without one.
    pub(crate) body: Option<&'static str>,
    /// The status, and the name of the schema, of the answer.
    pub(crate) answer: (u16, &'static str),
    pub(crate) handler: MethodRouter<Shared>,
}

impl Route {
    /// Returns the group of the operation in the description, by which generated clients are divided into modules.
    pub(crate) fn group(&self) -> &'static str {
        match self.path.split('/').nth(2) {
            Some("sessions") => "sessions",
            Some("runs" | "stop") => "runs",
            Some("plan" | "verify" | "repair" | "solve") => "plans",
            _ => "server",
        }
    }
}

macro_rules! routes {
    ($($method:ident $path:literal $name:ident ($body:expr) -> $status:literal $answer:literal : $summary:literal = $handler:expr;)*) => {
        vec![$(Route {
            method: stringify!($method),
            path: $path,
            name: stringify!($name),
            summary: $summary,
            body: $body,
            answer: ($status, $answer),
            handler: $method($handler),
        },)*]
    };
}

/// Returns the paths for programs.
pub(crate) fn routes() -> Vec<Route> {
    routes! {
        get "/api/server" server (None) -> 200 "Server": "The model, domains, scenes and robots" = api::server;
        get "/api/model" get_model (None) -> 200 "LentModel": "The model that `LONGSTEP_SERVER` lends to other programs" = api::model;
        post "/api/model/chat" chat (Some("ChatCall")) -> 200 "ChatReply": "Let the model answer a request as it is" = api::chat;
        post "/api/model/count" count_tokens (Some("CountCall")) -> 200 "TokenCount": "Count the tokens of messages" = api::count;
        get "/api/sessions" list_sessions (None) -> 200 "SessionList": "All sessions" = api::sessions;
        post "/api/sessions" create_session (Some("Place")) -> 201 "Session": "Begin a session in a world" = api::create;
        get "/api/sessions/{id}" get_session (None) -> 200 "Session": "A session as it is now" = api::one_session;
        get "/api/sessions/{id}/world" get_world (None) -> 200 "Environment": "The world before the next instruction" = api::world;
        post "/api/sessions/{id}/instruct" instruct (Some("Words")) -> 200 "Session": "Give an instruction; waits for the person's turn, unless `Prefer: respond-async` is sent" = api::instruct;
        post "/api/sessions/{id}/answer" answer (Some("Words")) -> 200 "Session": "Answer the question" = api::answer;
        post "/api/sessions/{id}/feedback" feedback (Some("Words")) -> 200 "Session": "Say what is to be different" = api::feedback;
        post "/api/sessions/{id}/cancel" cancel (None) -> 200 "Session": "Cancel the instruction, or the work of the model" = api::cancel;
        post "/api/sessions/{id}/accept" accept (Some("PlanHash")) -> 200 "Session": "Accept the plan with this hash; nothing moves" = api::accept;
        post "/api/sessions/{id}/undo" undo (None) -> 200 "Session": "Revert the last accepted plan" = api::undo;
        post "/api/sessions/{id}/ended" ended (Some("Ending")) -> 200 "Session": "Say which ending the last plan had" = api::ended;
        post "/api/sessions/{id}/observed" observed (Some("Observation")) -> 200 "Session": "Report what the world is like" = api::observed;
        post "/api/sessions/{id}/approve" approve (Some("Approve")) -> 201 "Approval": "Approve the next accepted plan for a robot, once" = api::approve;
        post "/api/plan" plan (Some("Instruction")) -> 200 "Answer": "A plan for one instruction, in a session that is not kept" = api::plan;
        post "/api/verify" verify (Some("WrittenPlan")) -> 200 "Answer": "Verify a plan" = api::verify;
        post "/api/repair" repair (Some("WrittenPlan")) -> 200 "Answer": "Repair a plan with the cheapest edits" = api::repair;
        post "/api/solve" solve (Some("GoalRequest")) -> 200 "Answer": "Find a plan for a goal" = api::solve;
        get "/api/runs" list_runs (None) -> 200 "RunList": "All runs" = api::runs;
        post "/api/runs" start_run (Some("Start")) -> 201 "Run": "Begin a run with an approval" = api::start;
        get "/api/runs/{id}" get_run (None) -> 200 "Run": "A run as it is now" = api::one_run;
        post "/api/runs/{id}/decide" decide (Some("Decision")) -> 200 "Run": "Answer the question of a run" = api::decide;
        post "/api/runs/{id}/pause" pause_run (None) -> 200 "Run": "Pause after the steps that are under way" = api::pause;
        post "/api/runs/{id}/continue" continue_run (None) -> 200 "Run": "Go on from the observed world" = api::go_on;
        post "/api/runs/{id}/resume" resume_run (None) -> 200 "Run": "Take up a run that was interrupted" = api::resume;
        post "/api/runs/{id}/stop" stop_run (None) -> 200 "Run": "Stop the robot, then the run" = api::stop;
        post "/api/stop" stop_all (None) -> 200 "Stopped": "Stop all robots" = api::stop_all;
        get "/api/audit" get_audit (None) -> 200 "Audit": "Who approved, started and stopped what, the newest first" = api::audit;
    }
}
