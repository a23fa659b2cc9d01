//! The input of `longstep verify`, `show`, `repair` and `export`: a plan file and its world.

use std::time::Instant;

use anyhow::Result;
use longstep::draft_text::{changed_domain, is_foreign as is_foreign_to, knows_no_step, other_domain};
use longstep::goal::Goal;
use longstep::report::{Answer, Assessment};
use longstep_core::environment::World;
use longstep_core::goal::{self, GoalError};
use longstep_core::json;
use longstep_core::model::Wanted;
use longstep_core::pddl::Problem;
use longstep_core::plan;
use longstep_core::verify::{Purpose, VerifiedPlan};
use longstep_llm::load_domain;
use longstep_picture::plan::Annotations;

use crate::arguments::{DraftArguments, domain_or_default, required};
use crate::clock::milliseconds;
use crate::failure::Failure;
use crate::output::{self, Form};
use crate::plan_domain::wrong_domain;
use crate::{exit_code, inputs, problem, show};

/// Returns the verdict on a plan with its times; `started` is before the plan was read.
pub(crate) fn timed_verdict(assessment: &Assessment<'_>, started: Instant) -> Answer {
    let verifying = Instant::now();
    let mut answer = assessment.verdict();
    answer.timings_ms.verify = milliseconds(verifying);
    answer.timings_ms.total = milliseconds(started);
    answer
}

/// A plan file, read and resolved.
pub(crate) struct Draft {
    pub(crate) world: World,
    draft: plan::Draft,
    /// The goal for which the plan was made, or for which it is to be run.
    goal: Option<Goal>,
    /// The goal of a PDDL problem.
    wanted: Vec<Wanted>,
    /// Assumptions made when the plan was read.
    notes: Vec<String>,
}

impl Draft {
    pub(crate) fn read(arguments: &DraftArguments) -> Result<Self> {
        if let Some(file) = &arguments.problem {
            let problem = problem::read(arguments.domain.as_deref(), file)?;
            return Self::for_problem(arguments, problem);
        }
        let domain = load_domain(domain_or_default(arguments.domain.as_ref()))?;
        let read = inputs::plan_text(&arguments.plan, &domain)?;
        let shown = read.name().to_owned();
        let planned = read.draft().and_then(|draft| other_domain(&draft.file, &domain));
        let is_foreign = planned.is_some() || read.draft().is_some_and(|draft| knows_no_step(&draft.file, &domain));
        let before = read.draft().and_then(|draft| draft.file.environment_before.as_ref());
        let world = match (&arguments.env, before) {
            (Some(path), _) => inputs::world(&domain, path, None)?,
            (None, Some(environment)) => {
                let inside = json::Path::key("environment_before");
                let world = inputs::read_world(&domain, environment, &shown, read.text(), &inside);
                match (world, is_foreign) {
                    (Err(error), false) => return Err(error),
                    (Err(_), true) => return Err(wrong_domain(&shown, planned, &domain).into()),
                    (Ok(world), _) => world,
                }
            }
            (None, None) if arguments.project_env.is_some() => {
                inputs::world(&domain, required(arguments.project_env.as_deref())?, None)?
            }
            (None, None) => {
                let failure = Failure::unreadable(format!("{shown} has no `environment_before`"));
                return Err(failure
                    .hint("pass the environment before the plan with `--env ENV.json`, or a PDDL problem with `--problem FILE.pddl`")
                    .into());
            }
        };
        let changed = read.draft().and_then(|draft| changed_domain(&draft.file, &domain));
        let (draft, mut notes) = read.for_world(&world).map_err(inputs::no_draft)?;
        notes.extend(changed);
        let mut world = inputs::with_rules(world, arguments.rules.as_deref())?;
        let mut goal = None;
        if let Some(purpose) = &draft.file.purpose {
            let wrong = |error: GoalError| {
                Failure::unreadable(format!("{shown}: the purpose of the plan cannot be read: {error}")).hint(
                    "`purpose` has the goal and the rules for which the plan was made, with names of its environment",
                )
            };
            (world, goal) = goal::with_purpose(world, purpose).map_err(wrong)?;
        }
        let read = Self {
            world,
            draft,
            goal,
            wanted: Vec::new(),
            notes,
        };
        // A plan for one domain may be valid in another one that has its actions too.
        match other_domain(&read.draft.file, &domain).filter(|_| is_foreign_to(&read.assessment().verdict())) {
            Some(planned) => Err(wrong_domain(&shown, Some(planned), &domain).into()),
            None => Ok(read),
        }
    }

    fn for_problem(arguments: &DraftArguments, problem: Problem) -> Result<Self> {
        let Problem {
            world, wanted, notes, ..
        } = problem;
        let read = inputs::plan_text(&arguments.plan, world.domain())?;
        let of_problem = notes.iter().map(ToString::to_string);
        let (draft, notes) = read.for_world(&world).map_err(inputs::no_draft)?;
        Ok(Self {
            world,
            draft,
            goal: None,
            wanted,
            notes: of_problem.chain(notes).collect(),
        })
    }

    /// Returns the words of the instruction that the plan does not say.
    pub(crate) fn not_in_plan(&self) -> &[String] {
        &self.draft.file.not_in_plan
    }

    /// Returns the assumptions that the plan file states, as sentences.
    pub(crate) fn assumptions(&self) -> &[String] {
        self.draft
            .file
            .purpose
            .as_ref()
            .map_or(&[], |purpose| &purpose.assumptions)
    }

    /// Replaces the goal for which the plan was made.
    pub(crate) fn pursue(&mut self, text: &str) -> Result<()> {
        goal::add_values(&mut self.world, text);
        self.goal = Some(goal::parse(&self.world, text)?);
        Ok(())
    }

    /// The goal for which the plan was made, in the goal language; none if it is not known.
    pub(crate) fn goal(&self) -> Option<String> {
        let goal = self.goal.as_ref()?;
        Some(goal.exact(&self.world).join(" & "))
    }

    /// Returns the goal of the plan with the constraints that it is verified against, as far as they are known.
    pub(crate) fn purpose(&self) -> Purpose {
        match &self.goal {
            Some(goal) => goal.purpose(&self.world),
            None => Purpose {
                wanted: self.wanted.clone(),
                ..Purpose::default()
            },
        }
    }

    /// Returns what is known about the plan besides its steps.
    pub(crate) fn annotations(&self) -> Annotations {
        match &self.goal {
            Some(goal) => Annotations::default().with_goal(&self.world, goal),
            None => Annotations::default().with_purpose(self.purpose()),
        }
    }

    /// Returns the plan; of one that is not valid shows why, and returns the exit code. `use_of` says what only verified plans
    /// are: `run`, `taught`.
    pub(crate) fn verified(&self, use_of: &str) -> Result<VerifiedPlan, u8> {
        let assessment = self.assessment();
        assessment.verified().ok_or_else(|| {
            let answer = assessment.verdict();
            match output::form() {
                Form::Text => {
                    show::answer(&answer, show::Changes::Shown);
                    show::hint(&format!(
                        "only a verified plan is {use_of}; `longstep repair PLAN.json --save FILE` may mend it"
                    ));
                }
                form => output::in_form(form, &answer),
            }
            exit_code::of_status(answer.status)
        })
    }

    pub(crate) fn assessment(&self) -> Assessment<'_> {
        let assessment = Assessment::new(&self.world, self.draft.clone(), None);
        let assessment = match &self.goal {
            Some(goal) => assessment.for_goal(goal.clone()),
            None => assessment,
        };
        assessment.wanting(self.wanted.clone()).noting(self.notes.clone())
    }
}
