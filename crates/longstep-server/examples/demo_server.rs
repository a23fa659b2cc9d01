//! A server to try the page without a model or a robot: a model that answers from a table, and simulated robots.
//!
//! ```text
//! cargo run -p longstep-server --example demo_server -- [MINUTES] [FOLDER] [PORT]
//! ```
//!
//! It prints the link to the page, and ends after ten minutes, or after `MINUTES`. Its files, the token among them, are in
//! `FOLDER`, or in a temporary folder. The robot `sim` takes a moment for each step, `brisk` some milliseconds, `quick`
//! none, `slow` hangs in its first step, and `clumsy` has mishaps. The scripts in `tools/server` measure this server.

#![allow(unreachable_pub, clippy::unwrap_used, clippy::print_stdout)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use longstep_llm::ChatModel;
use longstep_robot::SimOptions;
use longstep_server::http::{Access, ServeOptions, Token, serve};
use longstep_server::{Body, Configuration, Domains, Hub, Models, RobotEntry, Scene};
use support::{Scripted, simulated, store};

/// What the model answers, by words of the instruction or the feedback.
const ANSWERS: [(&str, &str); 9] = [
    ("cereal instead", "put(cereal, counter)"),
    ("juice on top of the shelf", "put(juice, shelf top)"),
    (
        "everything fragile",
        r#"{"goal": "put(cereal, counter)", "left_out": ["be careful with everything fragile"], "question": ""}"#,
    ),
    ("cereal on the counter", "put(cereal, counter)"),
    ("butter on the counter", "put(butter, counter)"),
    ("the drink", "?Which drink?"),
    (
        "cream has expired",
        "if expired(cream) then put(cream, scrap bin) else put(cream, ledge)",
    ),
    ("never put the juice", "never put(juice, trash bin)"),
    ("without touching it", "put(juice, shelf top) & untouched(juice)"),
];

fn robots() -> Vec<RobotEntry> {
    let table = [
        ("sim", "ticks=1,pace=600"),
        ("quick", ""),
        ("brisk", "ticks=3,pace=8"),
        ("slow", "ticks=1,pace=60000"),
        ("clumsy", "seed=3,faults=2,horizon=4,kinds=slips+moved,pace=150"),
    ];
    let robot = |(name, options): (&str, &str)| {
        let options: SimOptions = options.parse().unwrap();
        simulated(name, options, Body::PerSession)
    };
    table.into_iter().map(robot).collect()
}

/// The arguments of the program.
struct Arguments {
    minutes: u64,
    folder: PathBuf,
    port: u16,
}

impl Arguments {
    /// Reads the arguments; `temporary` is the folder if none is given.
    fn read(temporary: &Path) -> Self {
        let mut words = std::env::args().skip(1);
        Self {
            minutes: words.next().map_or(10, |minutes| minutes.parse().unwrap()),
            folder: words.next().map_or(temporary.to_owned(), PathBuf::from),
            port: words.next().map_or(0, |port| port.parse().unwrap()),
        }
    }
}

fn main() {
    let temporary = tempfile::tempdir().unwrap();
    let Arguments { minutes, folder, port } = Arguments::read(temporary.path());
    let open = || Ok(Box::new(Scripted(ANSWERS.to_vec())) as Box<dyn ChatModel>);
    let models = Models::open(Arc::new(open), 2, 64).unwrap();
    let domains = Domains::new(&[], Scene::shipped()).unwrap();
    let configuration = Configuration::new(store(&folder), domains);
    let hub = Hub::open(configuration.with_models(models).with_robots(robots())).unwrap();
    let listener = TcpListener::bind(("127.0.0.1", port)).unwrap();
    let address = listener.local_addr().unwrap();
    let token = Token::of_file(&folder.join("token")).unwrap();
    println!("http://{address}/?token={}", token.text());
    let options = ServeOptions::new(Access::new(token, address, &[]));
    let ended = async move { tokio::time::sleep(Duration::from_secs(60 * minutes)).await };
    serve(listener, hub, options, ended).unwrap();
}
