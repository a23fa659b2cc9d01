//! A written plan in a world: a plan file, a script, a model's reply, or what another planner printed.
//!
//! Plans are read as `longstep verify` reads files, so that both give the same answer.

use std::path::Path;

use longstep::Goal;
use longstep::domain::shipped_names;
use longstep::report::{Answer as Report, Assessment};
use longstep_core::call::Call;
use longstep_core::environment::World as ReadWorld;
use longstep_core::goal;
use longstep_core::model::{Domain, DomainData};
use longstep_core::pddl::{self, Author};
use longstep_core::plan::{self, PlanDomain, PlanFile, TaskCohesion};
use longstep_core::search::Wanted;

use crate::failure::Failure;
use crate::rule::with_rules;
use crate::source::NamedText;

/// A plan, read and resolved, with its purpose.
pub(crate) struct Draft {
    pub(crate) world: ReadWorld,
    draft: plan::Draft,
    pub(crate) goal: Option<Goal>,
    /// The goal of a PDDL problem.
    pub(crate) wanted: Vec<Wanted>,
    /// Assumptions made when the plan was read.
    notes: Vec<String>,
}

impl Draft {
    /// Reads a plan in a world. A goal takes the place of the one in the plan's purpose.
    pub(crate) fn read(
        text: &NamedText,
        world: &ReadWorld,
        goal: Option<&str>,
        rules: &[String],
    ) -> Result<Self, Failure> {
        let domain = world.domain();
        let read = PlanText::read(text, domain)?;
        let known = read.draft().map(|draft| &draft.file);
        let planned = known.and_then(|file| other_domain(file, domain)).cloned();
        if planned.is_some() && known.is_some_and(|file| knows_no_step(file, domain)) {
            return Err(wrong_domain(&text.name, planned.as_ref(), domain));
        }
        let changed = known.and_then(|file| changed_domain(file, domain));
        let (draft, mut notes) = read.for_world(text, world)?;
        notes.extend(changed);
        let mut world = with_rules(world.clone(), rules)?;
        let mut own = None;
        if let Some(purpose) = &draft.file.purpose {
            (world, own) =
                goal::with_purpose(world, purpose).map_err(|error| {
                    Failure::unreadable(format!("{}: the purpose of the plan cannot be read: {error}", text.name)).hint(
                    "`purpose` has the goal and the rules for which the plan was made, with names of its environment"
                        .to_owned(),
                )
                })?;
        }
        if let Some(goal) = goal {
            goal::add_values(&mut world, goal);
            own = Some(goal::parse(&world, goal)?);
        }
        let read = Self {
            world,
            draft,
            goal: own,
            wanted: Vec::new(),
            notes,
        };
        // A plan for one domain may be valid in another one that has its actions too.
        match planned.filter(|_| is_foreign(&read.assessment().verdict())) {
            Some(planned) => Err(wrong_domain(&text.name, Some(&planned), read.world.domain())),
            None => Ok(read),
        }
    }

    /// Reads a plan for a PDDL problem, with the notes about it.
    pub(crate) fn for_problem(
        text: &NamedText,
        world: &ReadWorld,
        wanted: &[Wanted],
        notes: &[String],
    ) -> Result<Self, Failure> {
        let (draft, own) = PlanText::read(text, world.domain())?.for_world(text, world)?;
        Ok(Self {
            world: world.clone(),
            draft,
            goal: None,
            wanted: wanted.to_vec(),
            notes: notes.iter().cloned().chain(own).collect(),
        })
    }

    /// Returns the assessment, which simulates and repairs on demand.
    pub(crate) fn assessment(&self) -> Assessment<'_> {
        let assessment = Assessment::new(&self.world, self.draft.clone(), None);
        let assessment = match &self.goal {
            Some(goal) => assessment.for_goal(goal.clone()),
            None => assessment,
        };
        assessment.wanting(self.wanted.clone()).noting(self.notes.clone())
    }
}

/// The reason why a text has no plan.
struct NoDraft {
    failure: Failure,
    /// True if the text has steps that are no plan, whoever wrote it.
    has_steps: bool,
}

/// The text of a plan, which may also be what a planner printed; its names decide that in its world.
struct PlanText {
    draft: Result<plan::Draft, NoDraft>,
    /// The one who may have written the text, if it may be the plan of a planner.
    author: Option<Author>,
}

impl PlanText {
    fn read(text: &NamedText, domain: &Domain) -> Result<Self, Failure> {
        let author = pddl::author_of_plan(domain, &text.text);
        match draft(text) {
            Err(none) if author.is_none() => Err(none.failure),
            draft => Ok(Self { draft, author }),
        }
    }

    /// Returns the plan, if the text has one that can be read without a world.
    fn draft(&self) -> Option<&plan::Draft> {
        self.draft.as_ref().ok()
    }

    /// Returns the plan with notes for a person.
    fn for_world(self, text: &NamedText, world: &ReadWorld) -> Result<(plan::Draft, Vec<String>), Failure> {
        let is_planners = self.author == Some(Author::Planner);
        let draft = match self.draft {
            Ok(draft) if self.author.is_none() => return Ok((draft, Vec::new())),
            Err(none) if none.has_steps && !is_planners => return Err(none.failure),
            draft => draft,
        };
        let printed = printed_plan(world, text);
        let draft = match draft {
            Ok(draft) => draft,
            Err(none) if printed.is_err() && !is_planners => return Err(none.failure),
            Err(_) => return printed,
        };
        let own = plan::resolve(world, &draft.file.task_cohesion);
        let Ok((other, notes)) = printed else {
            return Ok((draft, Vec::new()));
        };
        if !own.issues.is_empty() || is_same(&own, &plan::resolve(world, &other.file.task_cohesion)) {
            return Ok((other, notes));
        }
        let message = format!(
            "{} can be read in two ways that are not the same: as calls, and as the plan of a planner with all arguments in the order of PDDL",
            text.name
        );
        let hint = "write the steps as `(action argument ...)` for a planner's plan, or as JSON under `plan`";
        Err(Failure::unreadable(message).hint(hint.to_owned()))
    }
}

/// Reads the text of a plan; the file of a script ends in `.py`.
fn draft(text: &NamedText) -> Result<plan::Draft, NoDraft> {
    let name = &text.name;
    let is_script = |path: &Path| path.extension().is_some_and(|extension| extension == "py");
    if text.path.as_deref().is_some_and(is_script) {
        let written = plan::script::read(&text.text).map_err(|error| NoDraft {
            has_steps: plan::read(&text.text).is_err_and(|error| error.has_steps()),
            failure: Failure::unreadable(format!("{name}: {error}")).hint(error.hint.to_string()),
        })?;
        return Ok(plan::Draft {
            file: PlanFile::from(TaskCohesion::from_written(written)),
            leniencies: Vec::new(),
        });
    }
    plan::read(&text.text).map_err(|error| NoDraft {
        has_steps: error.has_steps(),
        failure: Failure::unreadable(format!("{name}: {error}")).hint(text.hint(error.hint())),
    })
}

/// Returns true if two plans have the same steps, as far as their arguments are given.
fn is_same(one: &plan::Resolved, other: &plan::Resolved) -> bool {
    let is_same_step = |(one, other): (&Option<plan::DraftStep>, &Option<plan::DraftStep>)| match (one, other) {
        (Some(one), Some(other)) => {
            let mut arguments = one.arguments.iter().zip(&other.arguments);
            one.action == other.action && arguments.all(|(one, other)| one.is_none() || one == other)
        }
        _ => false,
    };
    one.steps.len() == other.steps.len() && one.steps.iter().zip(&other.steps).all(is_same_step)
}

/// Reads what a planner printed as a plan of the world; returns it with notes for a person.
fn printed_plan(world: &ReadWorld, text: &NamedText) -> Result<(plan::Draft, Vec<String>), Failure> {
    let pddl::ForeignPlan { steps, notes } = pddl::read_plan(world, &text.name, &text.text)?;
    let steps = steps
        .into_iter()
        .map(|step| plan::Step::explained(world, step.action, step.arguments));
    let written = TaskCohesion::new(world, &plan::Plan::sequence(steps.collect()));
    let draft = plan::Draft {
        file: PlanFile::from(written),
        leniencies: Vec::new(),
    };
    Ok((draft, notes))
}

/// Returns the domain for which a plan was made, if that is another one.
fn other_domain<'p>(plan: &'p PlanFile, domain: &DomainData) -> Option<&'p PlanDomain> {
    plan.domain.as_ref().filter(|own| own.name != domain.name)
}

/// Returns a note about a domain that was changed after the plan was saved.
fn changed_domain(plan: &PlanFile, domain: &DomainData) -> Option<String> {
    let own = plan.domain.as_ref().filter(|own| own.name == domain.name)?;
    let is_changed = own.hash.as_ref().is_some_and(|hash| *hash != domain.hash);
    is_changed.then(|| format!("the domain `{}` has changed since the plan was saved", domain.name))
}

/// Returns true if the steps or the entities of a plan mean nothing in the domain in which it was read.
fn is_foreign(answer: &Report) -> bool {
    let kinds = ["unknown_action", "unknown_entity", "unknown_actor", "wrong_arguments"];
    answer.violations.iter().any(|own| kinds.contains(&own.kind))
}

/// Returns true if a plan has steps, and the domain has the action of none of them.
fn knows_no_step(plan: &PlanFile, domain: &DomainData) -> bool {
    let written = plan.task_cohesion.task_sequence.iter();
    let called = written.filter_map(|text| Call::parse(text).ok()).map(|call| call.name);
    let tree = plan.task_cohesion.task_tree.iter().flat_map(|tree| &tree.steps);
    let mut names = called.chain(tree.map(|step| step.call.name.clone())).peekable();
    names.peek().is_some() && names.all(|name| domain.actions.iter().all(|action| action.call != name))
}

/// Returns the failure for a plan that was made for another domain.
fn wrong_domain(name: &str, planned: Option<&PlanDomain>, domain: &DomainData) -> Failure {
    let here = &domain.name;
    let Some(planned) = planned else {
        return Failure::unreadable(format!("{name} is no plan for the domain `{here}`"));
    };
    let other = &planned.name;
    let hint = if shipped_names().contains(&other.as_str()) {
        format!("read the world with `domain=\"{other}\"`")
    } else {
        format!("read the world with the folder of the domain `{other}`")
    };
    Failure::unreadable(format!(
        "{name} is a plan for the domain `{other}`, and not for `{here}`"
    ))
    .hint(hint)
}
