//! The domain of a plan file, compared with the domain in which it is read.

use longstep::domain::shipped_names;
use longstep_core::model::DomainData;
use longstep_core::plan::PlanDomain;

use crate::failure::Failure;

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
