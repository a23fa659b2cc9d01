//! The domain of a plan file, compared with the domain in which it is read.

use longstep::domain::shipped_names;
use longstep::report::Answer;
use longstep_core::call::Call;
use longstep_core::model::DomainData;
use longstep_core::plan::{PlanDomain, PlanFile};

use crate::failure::Failure;

/// Returns the domain for which a plan was made, if that is another one.
pub(crate) fn other_domain<'p>(plan: &'p PlanFile, domain: &DomainData) -> Option<&'p PlanDomain> {
    plan.domain.as_ref().filter(|own| own.name != domain.name)
}

/// Returns a note about a domain that was changed after the plan was saved.
pub(crate) fn changed_domain(plan: &PlanFile, domain: &DomainData) -> Option<String> {
    let own = plan.domain.as_ref().filter(|own| own.name == domain.name)?;
    let is_changed = own.hash.as_ref().is_some_and(|hash| *hash != domain.hash);
    is_changed.then(|| format!("the domain `{}` has changed since the plan was saved", domain.name))
}

/// Returns true if the steps or the entities of a plan mean nothing in the domain in which it was read.
pub(crate) fn is_foreign(answer: &Answer) -> bool {
    let kinds = ["unknown_action", "unknown_entity", "unknown_actor", "wrong_arguments"];
    answer.violations.iter().any(|own| kinds.contains(&own.kind))
}

/// Returns true if a plan has steps, and the domain has the action of none of them.
pub(crate) fn knows_no_step(plan: &PlanFile, domain: &DomainData) -> bool {
    let calls = plan.task_cohesion.task_sequence.iter();
    let mut names = calls
        .filter_map(|text| Call::parse(text).ok())
        .map(|call| call.name)
        .chain(
            plan.task_cohesion
                .task_tree
                .iter()
                .flat_map(|tree| &tree.steps)
                .map(|step| step.call.name.clone()),
        )
        .peekable();
    names.peek().is_some() && names.all(|name| domain.actions.iter().all(|action| action.call != name))
}

/// The failure for a plan that was made for another domain; none for its name if it is not known.
pub(crate) fn wrong_domain(shown: &str, planned: Option<&PlanDomain>, domain: &DomainData) -> Failure {
    let here = &domain.name;
    let Some(planned) = planned else {
        let message = format!("{shown} is no plan for the domain `{here}`, which has none of its actions");
        return Failure::unreadable(message).hint("name the domain of the plan with `--domain DOMAIN`");
    };
    let name = &planned.name;
    let hint = if shipped_names().contains(&name.as_str()) {
        format!("add `--domain {name}`")
    } else {
        format!("name the folder of the domain `{name}` with `--domain FOLDER`")
    };
    Failure::unreadable(format!(
        "{shown} is a plan for the domain `{name}`, and not for `{here}`"
    ))
    .hint(hint)
}
