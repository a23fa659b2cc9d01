//! A server for tests: a model that answers from a table, and simulated robots.

#![allow(dead_code, clippy::unwrap_used, missing_docs, unreachable_pub)]

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use longstep::dialogue::{ChatRequest, ConstraintKind, Counting, Message, Reply, Task, TokenCounter};
use longstep_core::environment::World;
use longstep_llm::{ChatModel, ModelError, Progress, Watch};
use longstep_robot::{Opened, RunStart, Sim, SimOptions, StopRequest};
use longstep_server::{
    Body, Configuration, Domains, FileStore, Hub, Models, Problem, ProblemKind, RobotEntry, RunId, RunView, Scene,
    Store,
};
use tempfile::TempDir;

/// A model that answers with the goal behind the first instruction of the table that the request contains. Instructions
/// that contain "wait" are answered only when the call is stopped. A goal that begins with `?` is a question, one that
/// begins with `{` the whole answer. Feedback concerns the goal, and leads to the one of the table.
pub struct Scripted(pub Vec<(&'static str, &'static str)>);

impl TokenCounter for Scripted {
    fn message_tokens(&mut self, _: &Message) -> u64 {
        0
    }

    fn frame_tokens(&mut self) -> u64 {
        0
    }

    fn counting(&self) -> Counting {
        Counting::Estimate("nothing is counted".to_owned())
    }
}

impl ChatModel for Scripted {
    fn name(&self) -> &str {
        "scripted"
    }

    fn constraint_kind(&self) -> ConstraintKind {
        ConstraintKind::JsonSchema
    }

    fn chat(&mut self, request: &ChatRequest, watch: &mut dyn Watch) -> Result<Reply, ModelError> {
        watch.tell(Progress::Waiting);
        let asked = request.messages.last().map_or("", |message| message.text.as_str());
        while asked.contains("wait") {
            if watch.stop() {
                return Err(ModelError::Stopped);
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        if request.task == Task::Plans {
            return Ok(Reply::complete(r#"{"question": "", "goal": true, "edits": []}"#));
        }
        let known = self.0.iter().find(|(words, _)| asked.contains(words));
        let (goal, question) = match known {
            Some((_, whole)) if whole.starts_with('{') => return Ok(Reply::complete(*whole)),
            Some((_, goal)) if goal.starts_with('?') => ("", &goal[1..]),
            Some((_, goal)) => (*goal, ""),
            None => ("", "What do you mean?"),
        };
        let reply = serde_json::json!({"question": question, "goal": goal, "left_out": []});
        Ok(Reply::complete(reply.to_string()))
    }

    fn context_tokens(&self) -> Option<u64> {
        None
    }
}

/// The world of the tests: a pen and a cup on a desk, and a shelf.
pub const DESK: &str = r#"{"assets": ["<desk>", "<shelf>", "<table>"], "objects": ["<pen>", "<cup>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<cup>": "on_something(<desk>)"}}"#;

pub const TABLE: [(&str, &str); 6] = [
    ("pen on the shelf", "put(pen, shelf)"),
    ("cup on the shelf", "put(cup, shelf)"),
    ("pen on the table", "put(pen, table)"),
    ("something away", "?Which one?"),
    ("it somewhere", "?Which one?"),
    ("cup on the table", "put(cup, table)"),
];

/// Returns a robot `sim` with these options.
pub fn simulated(name: &str, options: SimOptions, body: Body) -> RobotEntry {
    let open = move |world: &World, _: &StopRequest, _: RunStart| {
        let sim = Sim::new(world.clone(), &options);
        let sim = sim.map_err(|error| Problem::new(ProblemKind::Failed, error.to_string()))?;
        Ok(Opened::new(sim))
    };
    RobotEntry::new(name, "sim", Arc::new(open)).with_body(body)
}

pub fn store(folder: &Path) -> Arc<dyn Store> {
    Arc::new(FileStore::open(&folder.join("sessions")).unwrap())
}

/// Opens a hub with the scripted model and these robots. One that a test has dropped may take a moment to end.
pub fn hub(folder: &TempDir, robots: Vec<RobotEntry>) -> Arc<Hub> {
    let began = Instant::now();
    loop {
        match hub_at(store(folder.path()), robots.clone()) {
            Ok(hub) => return hub,
            Err(problem) => assert!(began.elapsed() < Duration::from_secs(10), "{problem}"),
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Opens a hub at a store with the scripted model and these robots.
pub fn hub_at(store: Arc<dyn Store>, robots: Vec<RobotEntry>) -> Result<Arc<Hub>, Problem> {
    let open = || Ok(Box::new(Scripted(TABLE.to_vec())) as Box<dyn ChatModel>);
    let models = Models::open(Arc::new(open), 1, 8).unwrap();
    let scenes = vec![Scene::new("desk", "household", DESK, "Put the pen on the shelf")];
    let domains = Domains::new(&[], scenes).unwrap();
    let configuration = Configuration::new(store, domains);
    Hub::open(configuration.with_models(models).with_robots(robots))
}

/// Waits until a run is in a state for which `is_there` is true.
pub fn until(hub: &Hub, run: &RunId, is_there: impl Fn(&RunView) -> bool) -> Arc<RunView> {
    let began = Instant::now();
    loop {
        let view = hub.run(run).unwrap();
        if is_there(&view) {
            return view;
        }
        assert!(began.elapsed() < Duration::from_secs(60), "{view:#?}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

pub fn runtime() -> tokio::runtime::Runtime {
    tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap()
}
