//! A written plan in a world: a plan file, a script, a model's reply, or what another planner printed.
//!
//! Plans are read as `longstep verify` reads files, so that both give the same answer.

use longstep::Goal;
use longstep::domain::shipped_names;
use longstep::draft_text::{
    DraftText, DraftTextError, Notation, changed_domain, is_foreign, knows_no_step, other_domain,
};
use longstep::report::Assessment;
use longstep_core::environment::World as ReadWorld;
use longstep_core::goal;
use longstep_core::model::{Domain, DomainData};
use longstep_core::plan::{self, PlanDomain};
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
        let read = plan_text(text, domain)?;
        let known = read.draft().map(|draft| &draft.file);
        let planned = known.and_then(|file| other_domain(file, domain)).cloned();
        if planned.is_some() && known.is_some_and(|file| knows_no_step(file, domain)) {
            return Err(wrong_domain(&text.name, planned.as_ref(), domain));
        }
        let changed = known.and_then(|file| changed_domain(file, domain));
        let (draft, mut notes) = read.for_world(world).map_err(|error| no_draft(text, error))?;
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
        let (draft, own) = plan_text(text, world.domain())?
            .for_world(world)
            .map_err(|error| no_draft(text, error))?;
        Ok(Self {
            world: world.clone(),
            draft,
            goal: None,
            wanted: wanted.to_vec(),
            notes: notes.iter().cloned().chain(own).collect(),
        })
    }

    /// Returns the words of the instruction that the plan ignores, as its file has them.
    pub(crate) fn left_out(&self) -> &[String] {
        &self.draft.file.not_in_plan
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

/// Reads the text of a plan, which may also be what a planner printed.
fn plan_text(text: &NamedText, domain: &Domain) -> Result<DraftText, Failure> {
    let notation = text.path.as_deref().map(Notation::of_file).unwrap_or_default();
    DraftText::read(&text.name, &text.text, notation, domain).map_err(|error| no_draft(text, error))
}

/// Returns the failure for a text without a plan.
fn no_draft(text: &NamedText, error: DraftTextError) -> Failure {
    match error {
        DraftTextError::Printed(findings) => findings.into(),
        error => {
            let hint = error.hint().map(|hint| match error {
                DraftTextError::Reply { .. } => text.hint(hint),
                _ => hint.to_owned(),
            });
            Failure::unreadable(error.to_string()).hint(hint)
        }
    }
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
