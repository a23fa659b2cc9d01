//! The robots of a server.

use std::sync::Arc;

use longstep_core::autonomy::Autonomy;
use longstep_core::environment::World;
use longstep_core::execution::Settings;
use longstep_core::skill::Skills;
use longstep_robot::{OpenOptions, Robot, RobotKind, RobotReference, RunStart, StopRequest};
use serde::Serialize;

use crate::problem::Problem;

/// An open robot.
pub struct OpenedRobot {
    /// The robot.
    pub robot: Box<dyn Robot>,
    /// True if nothing moves.
    pub is_dry: bool,
    /// The levels of autonomy, and the limits, of its configuration.
    pub autonomy: Autonomy,
}

impl OpenedRobot {
    /// Takes a robot that moves.
    pub fn new(robot: impl Robot + 'static) -> Self {
        Self {
            robot: Box::new(robot),
            is_dry: false,
            autonomy: Autonomy::default(),
        }
    }
}

/// Opens a robot in a world, on the thread of the run. The request stops the opening.
pub type OpenRobot = Arc<dyn Fn(&World, &StopRequest, RunStart) -> Result<OpenedRobot, Problem> + Send + Sync>;

/// Whose world a robot moves in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Body {
    /// One robot for all sessions: one run at a time.
    Shared,
    /// A simulation of its own for each session.
    PerSession,
}

/// A robot of a server. Requests name it; they cannot bring one along.
#[derive(Clone)]
#[non_exhaustive]
pub struct RobotEntry {
    /// The name in requests.
    pub name: String,
    /// The robot as its owner named it, without passwords: `sim`, `ros2:robot.toml`.
    pub reference: String,
    /// Whose world it moves in.
    pub body: Body,
    /// The settings of its runs; the predicates that it reports are added.
    pub settings: Settings,
    /// The text of a skills file for it.
    pub skills: Option<String>,
    /// Opens it.
    pub open: OpenRobot,
}

impl RobotEntry {
    /// Creates a robot that all sessions share, with the default settings.
    pub fn new(name: &str, reference: &str, open: OpenRobot) -> Self {
        Self {
            name: name.to_owned(),
            reference: longstep_core::secret::in_addresses(reference).into_owned(),
            body: Body::Shared,
            settings: Settings::default(),
            skills: None,
            open,
        }
    }

    /// Creates the robot of a reference. A simulation moves in a world of its own for each session; another robot is shared,
    /// and moves only if the options say so.
    pub fn of_reference(name: &str, reference: &RobotReference, options: &OpenOptions) -> Self {
        let (own, options) = (reference.clone(), options.clone());
        let open = move |world: &World, request: &StopRequest, start: RunStart| {
            let opened = longstep_robot::open(&own, world, &options, request, start)?;
            Ok(OpenedRobot {
                robot: opened.robot,
                is_dry: opened.is_dry,
                autonomy: opened.autonomy,
            })
        };
        let entry = Self::new(name, reference.as_written(), Arc::new(open));
        let is_private = matches!(reference.kind(), RobotKind::Sim(_));
        entry.with_body(if is_private { Body::PerSession } else { Body::Shared })
    }

    /// Sets whose world it moves in.
    #[must_use]
    pub fn with_body(self, body: Body) -> Self {
        Self { body, ..self }
    }

    /// Sets the settings of its runs.
    #[must_use]
    pub fn with_settings(self, settings: Settings) -> Self {
        Self { settings, ..self }
    }

    /// Sets the text of its skills file.
    #[must_use]
    pub fn with_skills(self, skills: impl Into<Option<String>>) -> Self {
        Self {
            skills: skills.into(),
            ..self
        }
    }

    /// Returns the settings of a run in a world.
    pub(crate) fn settings_in(
        &self,
        world: &World,
        robot: &dyn Robot,
        autonomy: &Autonomy,
    ) -> Result<Settings, Problem> {
        if !robot.describe().observes {
            return Err(
                Problem::conflict("this robot does not observe, so its plan cannot be monitored")
                    .hint("let the robot's program declare the capability `observe` and answer `observe`"),
            );
        }
        let reports = longstep_robot::reports(robot, world).map_err(|error| Problem::conflict(error.to_string()))?;
        let autonomy = self.settings.autonomy.and(autonomy);
        let settings = self.settings.clone().with_reports(reports).with_autonomy(autonomy);
        let Some(text) = &self.skills else {
            return Ok(settings);
        };
        let skills = Skills::parse(world.domain(), "skills", text);
        Ok(settings.with_skills(skills.map_err(|error| Problem::unreadable(error.to_string()))?))
    }
}
