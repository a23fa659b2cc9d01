//! The arguments that are not given: from environment variables and the project file.

use std::path::PathBuf;

use anyhow::Result;
use longstep_core::secret;

use super::{Command, DraftArguments, HubArguments, ModelArguments, RobotCommand, RunArguments};
use crate::project::Project;

/// The variable that names the domain.
const DOMAIN_VARIABLE: &str = "LONGSTEP_DOMAIN";

/// Values that a command takes from the project file.
#[derive(Debug, Default)]
pub(crate) struct Taken {
    /// The file; none before it was needed, or where there is none.
    project: Option<Project>,
    is_read: bool,
    /// The names and values that were taken.
    values: Vec<String>,
}

impl Taken {
    /// Returns a sentence about what was taken from the project file; none if nothing was.
    pub(crate) fn sentence(&self) -> Option<String> {
        let project = self.project.as_ref().filter(|_| !self.values.is_empty())?;
        let sentence = format!("From {}: {}", project.shown, self.values.join(", "));
        // Addresses of models and robots may have passwords.
        Some(secret::redacted(&sentence).into_owned())
    }

    /// Reads the project file at the first use. A command that takes nothing from it does not read it.
    fn project(&mut self) -> Result<&Project> {
        if !std::mem::replace(&mut self.is_read, true) {
            self.project = Project::find()?;
        }
        static NONE: std::sync::LazyLock<Project> = std::sync::LazyLock::new(Project::default);
        Ok(self.project.as_ref().unwrap_or(&NONE))
    }

    fn domain(&mut self, own: &mut Option<String>) -> Result<()> {
        if own.is_some() {
            return Ok(());
        }
        *own = std::env::var(DOMAIN_VARIABLE).ok().filter(|name| !name.is_empty());
        if own.is_none() {
            own.clone_from(&self.project()?.domain);
            self.values.extend(own.iter().map(|name| format!("domain {name}")));
        }
        Ok(())
    }

    fn environment(&mut self, own: &mut Option<PathBuf>) -> Result<()> {
        if own.is_none() {
            own.clone_from(&self.project()?.environment);
            self.values
                .extend(own.iter().map(|path| format!("environment {}", path.display())));
        }
        Ok(())
    }

    /// The environment of the project for a plan that may have its own.
    fn further_environment(&mut self, own: Option<&PathBuf>) -> Result<Option<PathBuf>> {
        match own {
            Some(_) => Ok(None),
            None => Ok(self.project()?.environment.clone()),
        }
    }

    fn rules(&mut self, own: &mut Option<PathBuf>) -> Result<()> {
        if own.is_none() {
            own.clone_from(&self.project()?.rules);
            self.values
                .extend(own.iter().map(|path| format!("rules {}", path.display())));
        }
        Ok(())
    }

    fn robot(&mut self, own: &mut Option<String>) -> Result<()> {
        if own.is_none() {
            own.clone_from(&self.project()?.robot);
            self.values.extend(own.iter().map(|name| format!("robot {name}")));
        }
        Ok(())
    }

    fn autonomy(&mut self, own: &mut Option<PathBuf>) -> Result<()> {
        if own.is_none() {
            own.clone_from(&self.project()?.autonomy);
            self.values
                .extend(own.iter().map(|path| format!("autonomy {}", path.display())));
        }
        Ok(())
    }

    fn model(&mut self, own: &mut ModelArguments) -> Result<()> {
        if own.model.is_none() && own.lender.is_none() {
            own.model.clone_from(&self.project()?.model);
            self.values.extend(own.model.iter().map(|name| format!("model {name}")));
        }
        Ok(())
    }

    fn draft(&mut self, own: &mut DraftArguments) -> Result<()> {
        if own.problem.is_none() {
            self.domain(&mut own.domain)?;
            self.rules(&mut own.rules)?;
            own.project_env = self.further_environment(own.env.as_ref())?;
        }
        Ok(())
    }

    fn run(&mut self, own: &mut RunArguments) -> Result<()> {
        // A run that is resumed has all of this in its log.
        let Some(what) = own.what.as_ref().filter(|_| own.resume.is_none()) else {
            return Ok(());
        };
        let is_file = std::path::Path::new(what).is_file();
        self.domain(&mut own.domain)?;
        self.rules(&mut own.rules)?;
        self.robot(&mut own.robot)?;
        self.autonomy(&mut own.execution.autonomy)?;
        own.project_env = self.further_environment(own.env.as_ref())?;
        if is_file { Ok(()) } else { self.model(&mut own.model) }
    }

    fn hub(&mut self, own: &mut HubArguments) -> Result<()> {
        self.domain(&mut own.domain)?;
        self.autonomy(&mut own.execution.autonomy)?;
        if own.env.is_empty() {
            let mut env = None;
            self.environment(&mut env)?;
            own.env.extend(env);
        }
        if own.robot.is_empty() {
            let mut robot = None;
            self.robot(&mut robot)?;
            own.robot.extend(robot);
        }
        if own.no_model {
            Ok(())
        } else {
            self.model(&mut own.model)
        }
    }
}

impl Command {
    /// Completes the arguments that are not given: from an environment variable, or else from the project file.
    ///
    /// # Errors
    ///
    /// A project file that cannot be read.
    pub(crate) fn complete(&mut self) -> Result<Taken> {
        let mut taken = Taken::default();
        match self {
            Self::Plan(own) => {
                taken.domain(&mut own.world.domain)?;
                taken.environment(&mut own.world.env)?;
                taken.rules(&mut own.world.rules)?;
                taken.model(&mut own.model)?;
            }
            Self::Chat(own) => {
                if own.resume.is_none() {
                    taken.domain(&mut own.domain)?;
                    taken.environment(&mut own.env)?;
                    taken.rules(&mut own.rules)?;
                }
                taken.robot(&mut own.robot)?;
                if own.robot.is_some() {
                    taken.autonomy(&mut own.execution.autonomy)?;
                }
                taken.model(&mut own.model)?;
            }
            Self::Compose(own) => {
                taken.domain(&mut own.world.domain)?;
                taken.environment(&mut own.world.env)?;
                taken.rules(&mut own.world.rules)?;
                if own.script.is_none() {
                    taken.model(&mut own.model)?;
                }
            }
            Self::Solve(own) if own.problem.is_none() => {
                taken.domain(&mut own.domain)?;
                taken.environment(&mut own.env)?;
                taken.rules(&mut own.rules)?;
            }
            Self::See(own) => {
                if own.update.is_none() {
                    taken.domain(&mut own.domain)?;
                }
                taken.model(&mut own.model)?;
            }
            Self::Verify(own) => taken.draft(&mut own.draft)?,
            Self::Show(own) => taken.draft(&mut own.draft)?,
            Self::Repair(own) => taken.draft(&mut own.draft)?,
            Self::Export(own) => taken.draft(&mut own.draft)?,
            Self::Teach(own) => {
                taken.domain(&mut own.domain)?;
                taken.rules(&mut own.rules)?;
                own.project_env = taken.further_environment(own.env.as_ref())?;
            }
            Self::Run(own) => taken.run(own)?,
            Self::Serve(own) => {
                // A server has a model of its own.
                own.hub.model.lender = None;
                taken.hub(&mut own.hub)?
            }
            Self::Mcp(own) => taken.hub(&mut own.hub)?,
            Self::Robot(RobotCommand::Check(own)) => {
                taken.domain(&mut own.domain)?;
                taken.environment(&mut own.env)?;
            }
            Self::Solve(_)
            | Self::Session(_)
            | Self::Runs(_)
            | Self::Robot(_)
            | Self::Eval(_)
            | Self::Domain(_)
            | Self::Model(_)
            | Self::Schema { .. } => {}
        }
        Ok(taken)
    }
}
