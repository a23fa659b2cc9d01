//! A Model Context Protocol server with a scripted model and a simulated robot: `tests/mcp_matrix.py` calls it.
//!
//! `mcp_scripted STATE_FOLDER [--http] [--control FIFO] [--plan-lifetime SECONDS] [--form-lifetime SECONDS] [--page URL]`
//!
//! Lines of the control pipe change the world behind the client's back: `observe SESSION JSON`. With `--http` the server
//! prints its address on standard error.

#![allow(clippy::unwrap_used, clippy::print_stderr, missing_docs)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use longstep_llm::ChatModel;
use longstep_robot::SimOptions;
use longstep_server::mcp::{McpOptions, http_service, serve_stdio};
use longstep_server::{Body, Configuration, Domains, FileStore, Hub, Models, NewSession, Scene, SessionId};

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = PathBuf::from(arguments.next().unwrap());
    let mut options = McpOptions::new(NewSession::of_scene("desk")).with_robot("sim".to_owned());
    let (mut is_http, mut control) = (false, None);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().unwrap();
        options = match argument.as_str() {
            "--plan-lifetime" => options.with_plan_lifetime(Duration::from_secs_f64(value().parse().unwrap())),
            "--form-lifetime" => options.with_form_lifetime(Duration::from_secs_f64(value().parse().unwrap())),
            "--page" => options.with_page(value()),
            "--http" => {
                is_http = true;
                options
            }
            "--control" => {
                control = Some(PathBuf::from(value()));
                options
            }
            other => {
                eprintln!("unknown argument {other}");
                std::process::exit(2);
            }
        };
    }
    let hub = hub(&folder);
    if let Some(control) = control {
        let hub = Arc::clone(&hub);
        std::thread::spawn(move || obey(&hub, &control));
    }
    if is_http {
        serve_http(hub, options);
    } else {
        serve_stdio(hub, options, std::future::pending()).unwrap();
    }
}

fn hub(folder: &Path) -> Arc<Hub> {
    let open = || Ok(Box::new(support::Scripted(support::TABLE.to_vec())) as Box<dyn ChatModel>);
    let models = Models::open(Arc::new(open), 1, 8).unwrap();
    let scenes = vec![Scene::new(
        "desk",
        "household",
        support::DESK,
        "Put the pen on the shelf",
    )];
    let store = Arc::new(FileStore::open(&folder.join("sessions")).unwrap());
    let options: SimOptions = "seed=1,pace=20".parse().unwrap();
    let robots = vec![support::simulated("sim", options, Body::PerSession)];
    let configuration = Configuration::new(store, Domains::new(&[], scenes).unwrap())
        .with_models(models)
        .with_robots(robots);
    Hub::open(configuration).unwrap()
}

/// Obeys the lines of a pipe.
fn obey(hub: &Hub, control: &Path) {
    loop {
        let Ok(pipe) = std::fs::File::open(control) else { return };
        for line in BufReader::new(pipe).lines().map_while(Result::ok) {
            let mut words = line.splitn(3, ' ');
            let (command, session, statements) = (words.next(), words.next().unwrap_or(""), words.next().unwrap_or(""));
            assert_eq!(command, Some("observe"));
            let statements = serde_json::from_str(statements).unwrap();
            let id = SessionId::parse(session).unwrap();
            match hub.observed(&id, &statements) {
                Ok(_) => eprintln!("observed"),
                Err(problem) => eprintln!("not observed: {problem}"),
            }
        }
    }
}

fn serve_http(hub: Arc<Hub>, options: McpOptions) {
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()
        .unwrap();
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        eprintln!("http://{}/mcp", listener.local_addr().unwrap());
        let router = axum::Router::new().nest_service("/mcp", http_service(hub, options).unwrap());
        axum::serve(listener, router).await.unwrap();
    });
}
