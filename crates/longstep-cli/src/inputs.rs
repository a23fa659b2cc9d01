//! Reads environments and plans; writes files atomically.

use std::path::Path;

use anyhow::Result;
use longstep::domain::{self, Domain};
use longstep_core::environment::{self, Environment, World};
use longstep_core::goal;
use longstep_core::json;
use longstep_core::model::DomainData;
use longstep_core::pddl;
use longstep_core::plan::{self, PlanFile, TaskCohesion};
use longstep_files::{plain_reason, read_text, write_whole};
use longstep_llm::{load_domain, load_domain_with_prompt};

use crate::failure::Failure;

/// Loads a domain; files in the folder `prompt` replace its prompt files.
pub(crate) fn domain_with_prompt(name: &str, prompt: Option<&Path>) -> Result<Domain> {
    Ok(match prompt {
        Some(folder) => load_domain_with_prompt(name, folder)?,
        None => load_domain(name)?,
    })
}

/// Reads an environment file as a world of the domain, with the rules of a file in force.
pub(crate) fn world(domain: &Domain, path: &Path, rules: Option<&Path>) -> Result<World> {
    with_rules(bare_world(domain, path)?, rules)
}

/// Puts the rules of a file in force: one rule a line, with empty lines and comments after `#`.
pub(crate) fn with_rules(mut world: World, path: Option<&Path>) -> Result<World> {
    let Some(path) = path else { return Ok(world) };
    let text = read_text(path)?;
    let mut rules = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.split_once('#').map_or(line, |(rule, _)| rule).trim();
        if !line.is_empty() {
            world.add_values(line);
            let found = goal::rules(&world, line).map_err(|error| {
                let place = format!("{}:{}", path.display(), index + 1);
                Failure::unreadable(format!("{place}: {error}"))
                    .hint("a rule is `never GOAL`, `always GOAL` or `untouched(NAME)`")
            })?;
            rules.extend(found);
        }
    }
    Ok(world.with_prohibitions(rules))
}

fn bare_world(domain: &Domain, path: &Path) -> Result<World> {
    Ok(world_and_text(domain, path)?.0)
}

/// Reads an environment file as a world of the domain, and returns the text of the file too.
pub(crate) fn world_and_text(domain: &Domain, path: &Path) -> Result<(World, String)> {
    let text = read_text(path)?;
    let shown = path.display().to_string();
    let (environment, wrapped) = Environment::parse(&text).map_err(|error| {
        Failure::unreadable(format!("{shown}: {error}")).hint(
            "an environment is JSON, or a Python literal, with `assets`, `asset_states`, `objects` and `object_states`",
        )
    })?;
    let inside = if wrapped {
        json::Path::key("environment")
    } else {
        json::Path::default()
    };
    let world = read_world(domain, &environment, &shown, &text, &inside)?;
    Ok((world, text))
}

/// Reads an environment at the path `inside` of `text`. If it fits another shipped domain, the hint names that domain.
pub(crate) fn read_world(
    domain: &Domain,
    environment: &Environment,
    shown: &str,
    text: &str,
    inside: &json::Path,
) -> Result<World> {
    environment::read(domain, environment, shown, text, inside).map_err(|findings| {
        let fits = |name: &&str| {
            let other = domain::shipped(name).and_then(Result::ok);
            other.is_some_and(|other| environment::read(&other, environment, "", "", inside).is_ok())
        };
        match domain::shipped_names()
            .into_iter()
            .filter(|name| *name != domain.name)
            .find(fits)
        {
            Some(other) => {
                let message = format!("{shown} is not an environment of the domain `{}`", domain.name);
                Failure::unreadable(message)
                    .hint(format!("it fits the domain `{other}`: add `--domain {other}`"))
                    .into()
            }
            None => findings.into(),
        }
    })
}

/// Reads a plan, a script, or a model's reply that contains a plan; also returns the text, for positions in errors.
pub(crate) fn plan(path: &Path) -> Result<(plan::Draft, String)> {
    let text = read_text(path)?;
    let draft = draft(path, &text).map_err(|none| none.failure)?;
    Ok((draft, text))
}

/// The reason why a text has no plan.
struct NoDraft {
    failure: Failure,
    /// True if the text has steps that are no plan, whoever wrote it.
    has_steps: bool,
}

/// Reads the text of a plan file.
fn draft(path: &Path, text: &str) -> std::result::Result<plan::Draft, NoDraft> {
    let shown = path.display();
    if path.extension().is_some_and(|extension| extension == "py") {
        let written = plan::script::read(text).map_err(|error| NoDraft {
            has_steps: plan::read(text).is_err_and(|error| error.has_steps()),
            failure: Failure::unreadable(format!("{shown}: {error}")).hint(error.hint),
        })?;
        return Ok(plan::Draft {
            file: PlanFile::from(TaskCohesion::from_written(written)),
            leniencies: Vec::new(),
        });
    }
    plan::read(text).map_err(|error| NoDraft {
        has_steps: error.has_steps(),
        failure: Failure::unreadable(format!("{shown}: {error}")).hint(error.hint()),
    })
}

/// The text of a plan file, which may also be what a planner printed; its names decide that when its world is known.
pub(crate) struct PlanText {
    draft: std::result::Result<plan::Draft, NoDraft>,
    /// Who may have written the text, if it may be the plan of a planner.
    author: Option<pddl::Author>,
    pub(crate) shown: String,
    pub(crate) text: String,
}

impl PlanText {
    pub(crate) fn read(path: &Path, domain: &longstep_core::domain::Domain) -> Result<Self> {
        let text = read_text(path)?;
        let draft = draft(path, &text);
        let author = pddl::author_of_plan(domain, &text);
        match draft {
            Err(none) if author.is_none() => Err(none.failure.into()),
            draft => Ok(Self {
                draft,
                author,
                shown: path.display().to_string(),
                text,
            }),
        }
    }

    /// Returns the plan, if the text has one that can be read without a world.
    pub(crate) fn draft(&self) -> Option<&plan::Draft> {
        self.draft.as_ref().ok()
    }

    /// Returns the world before the plan, if the file has it.
    pub(crate) fn before(&self) -> Option<&Environment> {
        self.draft()?.file.environment_before.as_ref()
    }

    /// Returns the plan with notes for a person.
    pub(crate) fn for_world(self, world: &World) -> Result<(plan::Draft, Vec<String>)> {
        let is_planners = self.author == Some(pddl::Author::Planner);
        let draft = match self.draft {
            Ok(draft) if self.author.is_none() => return Ok((draft, Vec::new())),
            Err(none) if none.has_steps && !is_planners => return Err(none.failure.into()),
            draft => draft,
        };
        let printed = printed_plan(world, &self.shown, &self.text);
        let draft = match draft {
            Ok(draft) => draft,
            Err(none) if printed.is_err() && !is_planners => return Err(none.failure.into()),
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
            self.shown
        );
        Err(Failure::unreadable(message)
            .hint("write the steps as `(action argument ...)` for a planner's plan, or as JSON under `plan`")
            .into())
    }
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
fn printed_plan(world: &World, shown: &str, text: &str) -> Result<(plan::Draft, Vec<String>)> {
    let pddl::ForeignPlan { steps, notes } = pddl::read_plan(world, shown, text)?;
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

/// Writes a plan's file atomically, with the domain for which the plan was made.
pub(crate) fn save(path: &Path, plan: &PlanFile, domain: &DomainData) -> Result<()> {
    let mut json = serde_json::to_string_pretty(&plan.clone().of_domain(domain))?;
    json.push('\n');
    write_whole(path, json.as_bytes()).map_err(|error| {
        Failure::unreadable(format!("cannot write {}: {}", path.display(), plain_reason(&error)))
            .hint("check that the folder exists and is writable")
    })?;
    Ok(())
}

/// Writes files into a folder, which is made if there is none.
pub(crate) fn write_files(folder: &Path, files: &[(&str, &str)]) -> Result<()> {
    let failed = |path: &Path, error: &std::io::Error| {
        Failure::unreadable(format!("cannot write {}: {}", path.display(), plain_reason(error)))
            .hint("check that the folder is writable")
    };
    std::fs::create_dir_all(folder).map_err(|error| failed(folder, &error))?;
    for (name, text) in files {
        let path = folder.join(name);
        write_whole(&path, text.as_bytes()).map_err(|error| failed(&path, &error))?;
    }
    Ok(())
}
