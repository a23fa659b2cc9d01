//! `longstep robot environment`: the scene of a running simulator as an environment file.

use anyhow::Result;
use longstep_core::environment;
use longstep_core::json::Path;
use longstep_core::secret;
use longstep_files::write_whole;
use longstep_llm::load_domain;
use longstep_robot::virtualhome::{self, Graph, Simulator, VirtualHomeOptions};

use crate::arguments::RobotEnvironmentArguments;
use crate::failure::Failure;
use crate::output::{self, remark};
use crate::run::robot::{failure, misnamed};

/// The most rooms that a hint lists.
const LISTED: usize = 30;

pub(crate) fn run(arguments: &RobotEnvironmentArguments) -> Result<u8> {
    let Some(rest) = arguments.robot.strip_prefix("virtualhome:") else {
        return Err(
            Failure::unreadable(format!("`{}` has no scene to read", arguments.robot))
                .hint("write `virtualhome:URL`; for other robots, write the environment file by hand")
                .into(),
        );
    };
    let options = rest.parse::<VirtualHomeOptions>();
    let options = options.map_err(|error| misnamed(error.into()))?;
    let graph = graph(&options.url, arguments.scene).map_err(|error| failure(&error))?;
    check_rooms(&graph, &arguments.room)?;
    let environment = virtualhome::environment(&graph, &arguments.room);
    let mut json = serde_json::to_string_pretty(&environment)?;
    json.push('\n');
    // What the domain cannot read is found here, and not with the first plan.
    let domain = load_domain("virtualhome")?;
    let address = secret::in_addresses(&options.url);
    environment::read(&domain, &environment, &address, &json, &Path::default())?;
    remark!(
        "{} assets and {} objects for the domain `virtualhome`",
        environment.assets.len(),
        environment.objects.len()
    );
    match &arguments.save {
        Some(path) => {
            let written = write_whole(path, json.as_bytes());
            written.map_err(|error| Failure::unreadable(format!("cannot write {}: {error}", path.display())))?;
            remark!("Saved to {}", path.display());
        }
        None => output::document(&json),
    }
    Ok(0)
}

fn graph(url: &str, scene: Option<i64>) -> Result<Graph, longstep_robot::RobotError> {
    let simulator = Simulator::new(url)?;
    simulator.check()?;
    if let Some(scene) = scene {
        simulator.reset(Some(scene))?;
    }
    simulator.graph()
}

/// Refuses rooms that the scene does not have.
fn check_rooms(graph: &Graph, wanted: &[String]) -> Result<()> {
    let rooms: Vec<&str> = graph
        .nodes
        .iter()
        .filter(|node| node.is_room())
        .map(|node| node.class_name.as_str())
        .collect();
    match wanted.iter().find(|room| !rooms.contains(&room.as_str())) {
        Some(room) => Err(Failure::unreadable(format!("the scene has no room `{room}`"))
            .hint(format!("it has {}", listed(&rooms)))
            .into()),
        None => Ok(()),
    }
}

fn listed(rooms: &[&str]) -> String {
    let shown: Vec<&str> = rooms.iter().take(LISTED).copied().collect();
    match rooms.len().saturating_sub(LISTED) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
