//! The faces of a server in ROS 2.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Result;
use longstep_files::read_text;
use longstep_server::Hub;
use longstep_server::ros::{RosFace, RosOptions};

use crate::output::remark;

/// The bridge of a robot file.
pub(crate) struct Bridge {
    /// The robot of the file. If the server has it, it is that of plans that a caller approves.
    reference: String,
    options: RosOptions,
}

/// Reads the bridges of robot files.
pub(crate) fn bridges(files: &[PathBuf]) -> Result<Vec<Bridge>> {
    files.iter().map(|file| bridge(file)).collect()
}

fn bridge(file: &Path) -> Result<Bridge> {
    let name = file.display().to_string();
    let configuration = longstep_robot::ros2::Configuration::parse(&name, &read_text(file)?)?;
    let notice = |text: &str| remark!("{text}");
    let options = RosOptions::new(&configuration).with_notice(Arc::new(notice));
    Ok(Bridge {
        reference: format!("ros2:{name}"),
        options,
    })
}

/// Begins the faces in ROS 2. They end when they are dropped.
pub(crate) fn faces(hub: &Arc<Hub>, bridges: Vec<Bridge>) -> Result<Vec<RosFace>> {
    let begin = |Bridge { reference, options }: Bridge| {
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
