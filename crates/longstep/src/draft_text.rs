//! The text of a plan that somebody else wrote: a plan file, a script, a model's reply, or what another planner printed.
//!
//! The names in a text decide in its world whether a planner wrote it. A plan also says for which domain it was made.

use std::path::Path;

use longstep_core::call::Call;
use longstep_core::diagnostic::Diagnostics;
use longstep_core::environment::World;
use longstep_core::model::{Domain, DomainData};
use longstep_core::pddl::{self, Author};
use longstep_core::plan::script::{self, ScriptError};
use longstep_core::plan::{
    self, Draft, DraftStep, Plan, PlanDomain, PlanFile, Resolved, Step, TaskCohesion, Unreadable,
};

use crate::report::Answer;

/// The notation of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Notation {
    /// One of those that [`plan::read`] knows.
    #[default]
    Any,
    /// A script.
    Script,
}

impl Notation {
    /// Returns the notation of a file: that of a script ends in `.py`.
    pub fn of_file(path: &Path) -> Self {
        if path.extension().is_some_and(|extension| extension == "py") {
            Self::Script
        } else {
            Self::Any
        }
    }
}

/// The reason why a text has no plan.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DraftTextError {
    /// A script has what no plan has.
    #[error("{name}: {error}")]
    Script {
        /// The name of the text.
        name: String,
        /// The error.
        error: ScriptError,
    },
    /// The text has no plan.
    #[error("{name}: {error}")]
    Reply {
        /// The name of the text.
        name: String,
        /// The error.
        error: Unreadable,
    },
    /// The plan of a planner cannot be read.
    #[error(transparent)]
    Printed(Diagnostics),
    /// Calls and the plan of a planner are different plans.
    #[error(
        "{0} can be read in two ways that are not the same: as calls, and as the plan of a planner with all arguments in the order of PDDL"
    )]
    TwoReadings(String),
}

impl DraftTextError {
    /// Returns the next step for the user; none for an error whose findings have their own.
    pub fn hint(&self) -> Option<&str> {
        match self {
            Self::Script { error, .. } => Some(&error.hint),
            Self::Reply { error, .. } => Some(error.hint()),
            Self::Printed(_) => None,
            Self::TwoReadings(_) => {
                Some("write the steps as `(action argument ...)` for a planner's plan, or as JSON under `plan`")
            }
        }
    }
}

/// A failed reading.
#[derive(Debug)]
struct NoDraft {
    error: DraftTextError,
    /// True if the text has steps that are no plan, whoever wrote it.
    has_steps: bool,
}

/// The text of a plan, whose names decide in its world who wrote it.
///
/// ```
/// use longstep::draft_text::{DraftText, Notation};
/// use longstep_core::{domain, environment};
/// let household = domain::shipped("household").unwrap()?;
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text)?;
/// let printed = DraftText::read("plan.txt", "(move-hand pen)\n(grasp pen)\n", Notation::Any, &household).unwrap();
/// let (draft, _) = printed.for_world(&world).unwrap();
/// assert_eq!(draft.file.task_cohesion.task_sequence, ["move_hand()", "grasp_object()"]);
/// # Ok::<(), longstep_core::diagnostic::Diagnostics>(())
/// ```
#[derive(Debug)]
pub struct DraftText {
    name: String,
    text: String,
    draft: Result<Draft, NoDraft>,
    /// The one who may have written the text, if it may be the plan of a planner.
    author: Option<Author>,
}

impl DraftText {
    /// Reads a text; `name` is its name in messages.
    ///
    /// # Errors
    ///
    /// When the text has no plan, and no planner may have written it.
    pub fn read(name: &str, text: &str, notation: Notation, domain: &Domain) -> Result<Self, DraftTextError> {
        let author = pddl::author_of_plan(domain, text);
        match parsed(name, text, notation) {
            Err(none) if author.is_none() => Err(none.error),
            draft => Ok(Self {
                name: name.to_owned(),
                text: text.to_owned(),
                draft,
                author,
            }),
        }
    }

    /// Returns the name of the text in messages.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the plan, if the text has one that can be read without a world.
    pub fn draft(&self) -> Option<&Draft> {
        self.draft.as_ref().ok()
    }

    /// Returns the plan with notes for a person.
    ///
    /// # Errors
    ///
    /// When the text has no plan of the world, or two that differ.
    pub fn for_world(self, world: &World) -> Result<(Draft, Vec<String>), DraftTextError> {
        let is_planners = self.author == Some(Author::Planner);
        let draft = match self.draft {
            Ok(draft) if self.author.is_none() => return Ok((draft, Vec::new())),
            Err(none) if none.has_steps && !is_planners => return Err(none.error),
            draft => draft,
        };
        let printed = printed_plan(world, &self.name, &self.text).map_err(DraftTextError::Printed);
        let draft = match draft {
            Ok(draft) => draft,
            Err(none) if printed.is_err() && !is_planners => return Err(none.error),
            Err(_) => return printed,
        };
        let own = plan::resolve(world, &draft.file.task_cohesion);
        let Ok((other, notes)) = printed else {
            return Ok((draft, Vec::new()));
        };
        if !own.issues.is_empty() || is_same(&own, &plan::resolve(world, &other.file.task_cohesion)) {
            return Ok((other, notes));
        }
        Err(DraftTextError::TwoReadings(self.name))
    }
}

/// Reads a text as a plan without a world.
///
/// # Errors
///
/// When the text has no plan.
pub fn draft(name: &str, text: &str, notation: Notation) -> Result<Draft, DraftTextError> {
    parsed(name, text, notation).map_err(|none| none.error)
}

fn parsed(name: &str, text: &str, notation: Notation) -> Result<Draft, NoDraft> {
    let name = name.to_owned();
    if notation == Notation::Any {
        return plan::read(text).map_err(|error| NoDraft {
            has_steps: error.has_steps(),
            error: DraftTextError::Reply { name, error },
        });
    }
    let written = script::read(text).map_err(|error| NoDraft {
        has_steps: plan::read(text).is_err_and(|error| error.has_steps()),
        error: DraftTextError::Script { name, error },
    })?;
    Ok(Draft {
        file: PlanFile::from(TaskCohesion::from_written(written)),
        leniencies: Vec::new(),
    })
}

/// Returns true if two plans have the same steps, as far as their arguments are given.
fn is_same(one: &Resolved, other: &Resolved) -> bool {
    let is_same_step = |(one, other): (&Option<DraftStep>, &Option<DraftStep>)| match (one, other) {
        (Some(one), Some(other)) => {
            let mut arguments = one.arguments.iter().zip(&other.arguments);
            one.action == other.action && arguments.all(|(one, other)| one.is_none() || one == other)
        }
        _ => false,
    };
    one.steps.len() == other.steps.len() && one.steps.iter().zip(&other.steps).all(is_same_step)
}

/// Reads what a planner printed as a plan of the world; returns it with notes for a person.
fn printed_plan(world: &World, name: &str, text: &str) -> Result<(Draft, Vec<String>), Diagnostics> {
    let pddl::ForeignPlan { steps, notes } = pddl::read_plan(world, name, text)?;
    let steps = steps
        .into_iter()
        .map(|step| Step::explained(world, step.action, step.arguments));
    let written = TaskCohesion::new(world, &Plan::sequence(steps.collect()));
    let draft = Draft {
        file: PlanFile::from(written),
        leniencies: Vec::new(),
    };
    Ok((draft, notes))
}

/// Returns the domain for which a plan was made, if that is another one.
pub fn other_domain<'p>(plan: &'p PlanFile, domain: &DomainData) -> Option<&'p PlanDomain> {
    plan.domain.as_ref().filter(|own| own.name != domain.name)
}

/// Returns a note about a domain that was changed after the plan was saved.
pub fn changed_domain(plan: &PlanFile, domain: &DomainData) -> Option<String> {
    let own = plan.domain.as_ref().filter(|own| own.name == domain.name)?;
    let is_changed = own.hash.as_ref().is_some_and(|hash| *hash != domain.hash);
    is_changed.then(|| format!("the domain `{}` has changed since the plan was saved", domain.name))
}

/// Returns true if the steps or the entities of a plan mean nothing in the domain in which it was read.
pub fn is_foreign(answer: &Answer) -> bool {
    let kinds = ["unknown_action", "unknown_entity", "unknown_actor", "wrong_arguments"];
    answer.violations.iter().any(|own| kinds.contains(&own.kind))
}

/// Returns true if a plan has steps, and the domain has the action of none of them.
pub fn knows_no_step(plan: &PlanFile, domain: &DomainData) -> bool {
    let listed = plan.task_cohesion.task_sequence.iter();
    let listed = listed.filter_map(|text| Call::parse(text).ok()).map(|call| call.name);
    let tree = plan.task_cohesion.task_tree.iter().flat_map(|tree| &tree.steps);
    let mut names = listed.chain(tree.map(|step| step.call.name.clone())).peekable();
    names.peek().is_some() && names.all(|name| domain.actions.iter().all(|action| action.call != name))
}
