//! The notation of robots: `sim`, `process:COMMAND`, `ros2:robot.toml`, `virtualhome:URL`.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use longstep_core::secret;

use crate::sim::{SimOptions, SimOptionsError};
use crate::virtualhome::{VirtualHomeOptions, VirtualHomeOptionsError};

/// A robot as a user names it.
///
/// ```
/// use longstep_robot::{RobotKind, RobotReference};
/// let sim: RobotReference = "sim:faults=2,seed=7".parse()?;
/// assert!(sim.is_simulation());
/// let RobotKind::Sim(options) = sim.kind() else { panic!() };
/// assert_eq!((options.faults, options.seed), (2, 7));
/// let arm: RobotReference = "ros2:arm/robot.toml".parse()?;
/// assert!(!arm.is_simulation());
/// assert_eq!(arm.to_string(), "ros2:arm/robot.toml");
/// assert_eq!("drone".parse::<RobotReference>().unwrap_err().to_string(), "`drone` is no robot");
/// # Ok::<(), longstep_robot::ReferenceError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RobotReference {
    written: String,
    kind: RobotKind,
}

/// The kind of a robot, with its options.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum RobotKind {
    /// A simulated robot: `sim`, `sim:OPTIONS`.
    Sim(SimOptions),
    /// A robot behind a program, with the command that starts it: `process:COMMAND`.
    #[cfg(unix)]
    Process(String),
    /// A robot in ROS 2, with its configuration file: `ros2:FILE`.
    Ros2(PathBuf),
    /// A character in the simulator VirtualHome: `virtualhome:URL`.
    VirtualHome(VirtualHomeOptions),
}

/// A text that names no robot.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ReferenceError {
    /// There is no such kind of robot.
    #[error("`{0}` is no robot")]
    Unknown(String),
    /// An option of the simulated robot cannot be read.
    #[error(transparent)]
    Sim(#[from] SimOptionsError),
    /// An option of VirtualHome cannot be read.
    #[error(transparent)]
    VirtualHome(#[from] VirtualHomeOptionsError),
}

impl ReferenceError {
    /// Returns the next step for the user.
    pub fn hint(&self) -> &'static str {
        match self {
            Self::Unknown(_) => {
                "write `sim`, `sim:faults=2,seed=7`, `process:COMMAND`, `ros2:robot.toml` or `virtualhome:URL`"
            }
            Self::Sim(_) => "for example `sim:faults=2,seed=7`",
            Self::VirtualHome(_) => "for example `virtualhome:http://127.0.0.1:8080,room=kitchen`",
        }
    }
}

impl FromStr for RobotReference {
    type Err = ReferenceError;

    fn from_str(written: &str) -> Result<Self, ReferenceError> {
        let (kind, rest) = written.split_once(':').unwrap_or((written, ""));
        let kind = match kind {
            "sim" => RobotKind::Sim(rest.parse()?),
            #[cfg(unix)]
            "process" if !rest.trim().is_empty() => RobotKind::Process(rest.to_owned()),
            "ros2" if !rest.trim().is_empty() => RobotKind::Ros2(PathBuf::from(rest)),
            "virtualhome" => RobotKind::VirtualHome(rest.parse()?),
            _ => return Err(ReferenceError::Unknown(written.to_owned())),
        };
        Ok(Self {
            written: written.to_owned(),
            kind,
        })
    }
}

impl RobotReference {
    /// Returns the text that was parsed, with the passwords of its addresses.
    pub fn as_written(&self) -> &str {
        &self.written
    }

    /// Returns the kind of the robot, with its options. See the [example](Self#example).
    pub fn kind(&self) -> &RobotKind {
        &self.kind
    }

    /// Returns true if the robot is a simulation, whatever its world. A robot behind a program or in ROS 2 says by itself if
    /// it is one ([`Description::simulated`](crate::Description::simulated)).
    pub fn is_simulation(&self) -> bool {
        matches!(self.kind, RobotKind::Sim(_) | RobotKind::VirtualHome(_))
    }
}

impl fmt::Display for RobotReference {
    /// Writes the text that was parsed, without the passwords of its addresses.
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&secret::in_addresses(&self.written))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robot_reference_rejects_texts_that_name_no_robot() {
        for text in [
            "",
            "drone",
            "ros2",
            "ros2:",
            "ros2: ",
            "process:",
            "process: ",
            "SIM",
            "sim2:seed=1",
        ] {
            let error = text.parse::<RobotReference>().unwrap_err();
            assert_eq!(error, ReferenceError::Unknown(text.to_owned()));
            assert!(error.hint().contains("process:COMMAND"));
        }
        let error = "sim:fault=2".parse::<RobotReference>().unwrap_err();
        assert!(matches!(error, ReferenceError::Sim(_)) && error.to_string().starts_with("`fault=2` is no option"));
        let error = "virtualhome:".parse::<RobotReference>().unwrap_err();
        assert!(matches!(error, ReferenceError::VirtualHome(_)), "{error:?}");
    }

    #[test]
    fn robot_reference_shows_no_password() {
        let reference: RobotReference = "virtualhome:http://me:secret@127.0.0.1:8080".parse().unwrap();
        assert!(!reference.to_string().contains("secret"), "{reference}");
        assert!(reference.as_written().contains("secret") && reference.is_simulation());
    }
}
