//! The worlds, robots and model of a server.

use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use longstep::domain::Domain;
use longstep_core::autonomy::Autonomy;
use longstep_core::execution::Settings;
use longstep_files::read_text;
use longstep_llm::load_domain;
use longstep_robot::{OpenOptions, RobotReference};
use longstep_server::mcp::McpOptions;
use longstep_server::{
    Configuration, Domains, Models, NewSession, PostgresOptions, PostgresStore, Problem, RobotEntry, Scene, Store,
};

use crate::arguments::{ExecutionArguments, HubArguments, domain_or_default};
use crate::ask;
use crate::exit_code::{LIMIT, MODEL, ROBOT, UNREADABLE};
use crate::failure::Failure;
use crate::inputs;

/// Opens the database of an address, which several programs share.
pub(crate) fn database(address: &str) -> Result<Arc<dyn Store>> {
    let opened = PostgresStore::open(address, PostgresOptions::default());
    let store = opened.map_err(|error| {
        Failure::new(error.to_string(), MODEL)
            .hint("name a PostgreSQL database that this machine reaches; see docs/guide/server.md")
    })?;
    Ok(Arc::new(store))
}

/// Returns the parts of a server. Its model is opened.
pub(crate) fn configuration(arguments: &HubArguments, store: Arc<dyn Store>) -> Result<Configuration> {
    let named = domain_or_default(arguments.domain.as_ref());
    let domain = load_domain(named)?;
    let folders: Vec<String> = arguments.domain.iter().cloned().collect();
    let mut scenes = arguments
        .env
        .iter()
        .map(|env| scene(&domain, env))
        .collect::<Result<Vec<_>>>()?;
    scenes.extend(Scene::shipped());
    let domains = Domains::new(&folders, scenes).map_err(failure)?;
    let models = if arguments.no_model {
        None
    } else {
        Some(models(arguments)?)
    };
    Ok(Configuration::new(store, domains)
        .with_models(models)
        .with_robots(robots(&arguments.robot, &arguments.execution, &domain)?)
        .with_settings(arguments.strategy.settings()))
}

/// Returns the options of a server for agents. A plan goes to the first robot, unless the agent names another one.
pub(crate) fn for_agents(arguments: &HubArguments, robots: &[RobotEntry], page: Option<String>) -> McpOptions {
    McpOptions::new(start(arguments))
        .with_robot(robots.first().map(|robot| robot.name.clone()))
        .with_page(page)
}

/// Returns where sessions of agents begin: in the first environment, or in the first demo scene.
fn start(arguments: &HubArguments) -> NewSession {
    let scene = match arguments.env.first() {
        Some(env) => name_of(env),
        None => Scene::shipped()
            .first()
            .map(|scene| scene.name.clone())
            .unwrap_or_default(),
    };
    NewSession::of_scene(&scene)
}

fn name_of(env: &Path) -> String {
    env.file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}

/// Reads an environment file as a scene. It is read in the domain too, so that its errors are known now.
fn scene(domain: &Domain, path: &Path) -> Result<Scene> {
    let world = inputs::world(domain, path, None)?;
    let text = serde_json::to_string(world.environment())?;
    Ok(Scene::new(&name_of(path), &domain.name, &text, ""))
}

fn models(arguments: &HubArguments) -> Result<Models> {
    // The first one shows its progress; a model that is missing is an error before anything listens.
    let model = arguments.model.clone();
    let first = std::sync::Mutex::new(Some(()));
    let open = move || {
        let is_first = first.lock().is_ok_and(|mut first| first.take().is_some());
        if is_first {
            ask::model(model.name(), &model)
        } else {
            ask::open_quietly(&model)
        }
    };
    let models = Models::open(
        Arc::new(open),
        usize::from(arguments.models),
        usize::from(arguments.queue),
    );
    Ok(models?)
}

/// Opens nothing: a robot is opened by its runs.
fn robots(named: &[String], execution: &ExecutionArguments, domain: &Domain) -> Result<Vec<RobotEntry>> {
    let default = ["sim".to_owned()];
    let named = if named.is_empty() { &default[..] } else { named };
    let mut robots: Vec<RobotEntry> = Vec::new();
    for text in named {
        let (name, reference) = split(text);
        let parsed: RobotReference = reference.parse().map_err(|error: longstep_robot::ReferenceError| {
            Failure::unreadable(error.to_string()).hint(error.hint())
        })?;
        let options = OpenOptions::default().with_live(execution.live);
        let entry = RobotEntry::of_reference(name, &parsed, &options)
            .with_settings(settings(execution, domain)?)
            .with_skills(execution.skills.as_deref().map(read_text).transpose()?);
        if robots.iter().any(|own| own.name == entry.name) {
            return Err(Failure::unreadable(format!("two robots have the name `{name}`"))
                .hint("name them: `--robot left=process:...  --robot right=process:...`")
                .into());
        }
        robots.push(entry);
    }
    Ok(robots)
}

/// Returns the name of a robot and its reference: `arm=ros2:arm.toml`; without a name the kind is one.
fn split(text: &str) -> (&str, &str) {
    match text.split_once('=') {
        Some((name, reference)) if name.chars().all(|c| c.is_alphanumeric() || c == '-' || c == '_') => {
            (name, reference)
        }
        _ => (text.split(':').next().unwrap_or(text), text),
    }
}

fn settings(arguments: &ExecutionArguments, domain: &Domain) -> Result<Settings> {
    let autonomy = match &arguments.autonomy {
        Some(path) => Autonomy::parse(domain, None, &path.display().to_string(), &read_text(path)?)?,
        None => Autonomy::default(),
    };
    // A run of the server always begins with an approval; with `never` nothing is asked after it.
    Ok(Settings::from(arguments).with_autonomy(autonomy))
}

/// Returns the failure for a problem of the server.
pub(crate) fn failure(problem: Problem) -> Failure {
    use longstep_server::ProblemKind as Kind;
    let code = match problem.kind {
        Kind::TooLarge | Kind::Busy => LIMIT,
        Kind::Failed => MODEL,
        Kind::Conflict => ROBOT,
        _ => UNREADABLE,
    };
    let failure = Failure::new(problem.message, code);
    match problem.hint {
        Some(hint) => failure.hint(hint),
        None => failure,
    }
}
