//! `longstep serve`: sessions, approvals and runs behind HTTP.

use std::net::TcpListener;
use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use longstep::domain::Domain;
use longstep_core::autonomy::Autonomy;
use longstep_core::execution::Settings;
use longstep_files::{read_text, session_directory};
use longstep_llm::load_domain;
use longstep_robot::{OpenOptions, RobotReference};
use longstep_server::http::{Access, ServeOptions, Token, serve};
use longstep_server::ros::{RosFace, RosOptions};
use longstep_server::{Configuration, Domains, FileStore, Hub, Models, Problem, RobotEntry, Scene};

use crate::arguments::{ExecutionArguments, ServeArguments, domain_or_default};
use crate::ask;
use crate::exit_code::{DONE, LIMIT, MODEL, ROBOT, UNREADABLE};
use crate::failure::Failure;
use crate::inputs;
use crate::output::{Style, print_line, remark};
use crate::signals;

pub(crate) fn run(arguments: &ServeArguments) -> Result<u8> {
    let listener = listener(arguments)?;
    let address = listener.local_addr()?;
    let store = store()?;
    let token_file = match &arguments.token_file {
        Some(file) => file.clone(),
        None => store.folder().join("token"),
    };
    let token = Token::of_file(&token_file)
        .map_err(|error| Failure::unreadable(error.to_string()).hint("name another file with `--token-file FILE`"))?;
    // Read before anything begins, so that a mistake in a file is known now.
    let bridges = arguments
        .ros2
        .iter()
        .map(|file| bridge(file))
        .collect::<Result<Vec<_>>>()?;
    let hub = Hub::open(configuration(arguments, store)?).map_err(failure)?;
    print_line!("{} http://{address}/?token={}", "Longstep is at".bold(), token.text());
    remark!(
        "The token is in {}; whoever has it can approve plans. Ctrl-C stops all robots and ends the server",
        token_file.display()
    );
    let access = Access::new(token, address, &arguments.name);
    let _faces = faces(&hub, bridges)?;
    let ended = signals::ended().map_err(|error| Failure::unreadable(format!("cannot watch for signals: {error}")))?;
    serve(listener, hub, ServeOptions::new(access), ended)?;
    Ok(DONE)
}

/// Reads the bridge of a robot file. Its robot, if the server has it, is that of plans that a caller approves.
fn bridge(file: &Path) -> Result<(String, RosOptions)> {
    let name = file.display().to_string();
    let configuration = longstep_robot::ros2::Configuration::parse(&name, &read_text(file)?)?;
    let notice = |text: &str| remark!("{text}");
    let options = RosOptions::new(&configuration).with_notice(Arc::new(notice));
    Ok((format!("ros2:{name}"), options))
}

/// Begins the faces in ROS 2. They end when they are dropped.
fn faces(hub: &Arc<Hub>, bridges: Vec<(String, RosOptions)>) -> Result<Vec<RosFace>> {
    let begin = |(reference, options): (String, RosOptions)| {
        let own = hub.robots().iter().find(|robot| robot.reference == reference);
        let options = options.with_robot(own.map(|robot| robot.name.clone()));
        let serving = &options.serving;
        let callers = if serving.approve {
            "callers may approve plans"
        } else {
            "callers may not approve plans"
        };
        remark!(
            "ROS 2 at {}: topics {}/...; {callers}",
            options.address,
            serving.namespace
        );
        Ok(RosFace::start(Arc::clone(hub), options)?)
    };
    bridges.into_iter().map(begin).collect()
}

/// Opens the listener. Beyond this machine nothing is encrypted: that is said before anything else.
fn listener(arguments: &ServeArguments) -> Result<TcpListener> {
    if !arguments.listen.ip().is_loopback() {
        if arguments.token_file.is_none() {
            return Err(Failure::unreadable(format!(
                "other machines reach {}, so the token has to be yours",
                arguments.listen
            ))
            .hint(
                "name a file with a token of at least 32 letters and digits: `--token-file FILE`; \
                           and put a server with TLS in front, see docs/guide/server.md",
            )
            .into());
        }
        remark!(
            "{} what is sent to {} is not encrypted: put a server with TLS in front, see docs/guide/server.md",
            "Warning:".yellow(),
            arguments.listen
        );
    }
    Ok(TcpListener::bind(arguments.listen).map_err(|error| {
        Failure::unreadable(format!("cannot listen at {}: {error}", arguments.listen))
            .hint("name another address with `--listen 127.0.0.1:PORT`; port 0 takes a free one")
    })?)
}

/// Opens the store beside the sessions of this user.
pub(crate) fn store() -> Result<Arc<FileStore>> {
    let store = FileStore::open(&session_directory()?);
    Ok(Arc::new(store.map_err(|error| failure(error.into()))?))
}

fn configuration(arguments: &ServeArguments, store: Arc<FileStore>) -> Result<Configuration> {
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

/// Reads an environment file as a scene. It is read in the domain too, so that its errors are known now.
pub(crate) fn scene(domain: &Domain, path: &Path) -> Result<Scene> {
    let world = inputs::world(domain, path, None)?;
    let text = serde_json::to_string(world.environment())?;
    let name = path
        .file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    Ok(Scene::new(&name, &domain.name, &text, ""))
}

fn models(arguments: &ServeArguments) -> Result<Models> {
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
pub(crate) fn robots(named: &[String], execution: &ExecutionArguments, domain: &Domain) -> Result<Vec<RobotEntry>> {
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
