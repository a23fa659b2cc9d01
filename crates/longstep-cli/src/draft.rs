//! The input of `longstep verify`, `longstep repair` and `longstep export`: a plan file and its world.

use anyhow::Result;
use longstep::report::Assessment;
use longstep_core::environment::World;
use longstep_core::json;
use longstep_core::plan;
use longstep_core::verify::VerifiedPlan;
use longstep_llm::load_domain;

use crate::arguments::DraftArguments;
use crate::failure::Failure;
use crate::{inputs, show};

/// A plan file, read and resolved.
pub(crate) struct Draft {
    pub(crate) world: World,
    draft: plan::Draft,
}

impl Draft {
    pub(crate) fn read(arguments: &DraftArguments) -> Result<Self> {
        let domain = load_domain(&arguments.domain)?;
        let (draft, text) = inputs::plan(&arguments.plan)?;
        let shown = arguments.plan.display().to_string();
        let world = match (&arguments.env, &draft.file.environment_before) {
            (Some(path), _) => inputs::world(&domain, path, None)?,
            (None, Some(environment)) => {
                let inside = json::Path::key("environment_before");
                inputs::read_world(&domain, environment, &shown, &text, &inside)?
            }
            (None, None) => {
                let failure = Failure::unreadable(format!("{shown} has no `environment_before`"));
                return Err(failure
                    .hint("pass the environment before the plan with `--env ENV.json`")
                    .into());
            }
        };
        let world = inputs::with_rules(world, arguments.rules.as_deref())?;
        Ok(Self { world, draft })
    }

    /// Returns the plan; of one that is not valid shows why, and returns the exit code. `use_of` says what only verified plans
    /// are: `run`, `taught`.
    pub(crate) fn verified(&self, use_of: &str) -> Result<VerifiedPlan, u8> {
        let assessment = self.assessment();
        assessment.verified().ok_or_else(|| {
            let answer = assessment.verdict();
            show::answer(&answer, show::Changes::Shown);
            show::hint(&format!(
                "only a verified plan is {use_of}; `longstep repair PLAN.json --save FILE` may mend it"
            ));
            answer.status.exit_code()
        })
    }

    pub(crate) fn assessment(&self) -> Assessment<'_> {
        Assessment::new(&self.world, self.draft.clone(), None)
    }
}
