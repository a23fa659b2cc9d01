//! The state of a simulated world in a file, so that it outlives the program as a real world does.

use std::fs;
use std::io::{Read, Write};
use std::path::Path;

use longstep_core::environment::{EntityId, Observation, ObservedFacts as Seen};

use super::Sim;
use crate::error::RobotError;

/// Maximum length of a state file.
const LARGEST: u64 = 64 << 20;

impl Sim {
    /// Reads the state file, if there is one.
    pub(super) fn restore(&mut self) -> Result<(), RobotError> {
        let Some(path) = self.options.state.clone() else {
            return Ok(());
        };
        let unreachable = |reason: String| RobotError::Unreachable {
            robot: format!("sim:state={}", path.display()),
            reason,
        };
        let file = match fs::File::open(&path) {
            Ok(file) => file,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return self.keep(),
            Err(error) => return Err(unreachable(error.to_string())),
        };
        let mut text = String::new();
        let read = file.take(LARGEST).read_to_string(&mut text);
        read.map_err(|error| unreachable(error.to_string()))?;
        let statements: Observation = serde_json::from_str(&text).map_err(|error| unreachable(error.to_string()))?;
        let seen = Seen::read(&self.world, &self.reports, &statements);
        let seen = seen.map_err(|error| unreachable(error.to_string()))?;
        self.state = seen.revised(&self.world, &self.state);
        Ok(())
    }

    /// Writes the state file, if there is to be one.
    pub(super) fn keep(&self) -> Result<(), RobotError> {
        let Some(path) = &self.options.state else {
            return Ok(());
        };
        let everything: Vec<EntityId> = self.world.entities().map(|(entity, _)| entity).collect();
        let statements = Seen::statements(&self.world, &self.state, &everything, &self.reports);
        let text = serde_json::to_string(&statements).map_err(|error| error.to_string());
        let written = text.and_then(|text| replace(path, &text).map_err(|error| error.to_string()));
        written.map_err(|reason| RobotError::Gone {
            reason: format!("cannot write {}: {reason}", path.display()),
            messages: String::new(),
        })
    }
}

/// Replaces a file as a whole.
fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    let mut file = fs::File::create(&name)?;
    file.write_all(text.as_bytes())?;
    file.sync_data()?;
    fs::rename(&name, path)
}
