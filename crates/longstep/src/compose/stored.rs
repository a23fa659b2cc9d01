//! Stored plans and their names.

use crate::plan::PlanFile;
use longstep_core::model::Domain;

/// An accepted plan that can be part of another one.
#[derive(Debug, Clone, PartialEq)]
pub struct Stored {
    /// Name in compositions: ASCII letters, digits and underscores.
    pub name: String,
    /// Short description.
    pub summary: String,
    /// The plan; `environment_before` holds the world that it was made for.
    pub file: PlanFile,
}

/// A name conflict between stored plans, or with an action.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NameClash {
    /// Two plans have one name.
    #[error("two stored plans are called `{0}`")]
    Twice(String),
    /// A plan has the name of an action.
    #[error("a stored plan is called `{0}`, and so is an action of the domain")]
    Action(String),
}

/// Keywords of the plan notation.
const RESERVED: [&str; 16] = [
    "if", "elif", "else", "while", "for", "in", "range", "with", "not", "and", "or", "pass", "parallel", "lane",
    "sync", "question",
];

impl Stored {
    /// Creates a stored plan from a file with this name (without its extension). Characters that a name cannot contain
    /// become `_`.
    ///
    /// ```
    /// use longstep::compose::Stored;
    /// use longstep_core::plan::PlanFile;
    /// let file = r#"{"task_cohesion": {}, "instruction_summary": "take the pear"}"#;
    /// let file: PlanFile = serde_json::from_str(file).unwrap();
    /// let stored = Stored::new("fetch the pear", file.clone());
    /// assert_eq!((stored.name.as_str(), stored.summary.as_str()), ("fetch_the_pear", "take the pear"));
    /// assert_eq!(Stored::new("0", file).name, "plan_0");
    /// ```
    pub fn new(stem: &str, file: PlanFile) -> Self {
        Self {
            name: plan_name(stem),
            summary: file
                .instruction_summary
                .split_whitespace()
                .collect::<Vec<_>>()
                .join(" "),
            file,
        }
    }
}

fn plan_name(stem: &str) -> String {
    let parts = stem.split(|c: char| !c.is_ascii_alphanumeric());
    let name = parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
    if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) || RESERVED.contains(&name.as_str()) {
        format!("plan_{name}").trim_end_matches('_').to_owned()
    } else {
        name
    }
}

/// Checks that names are unique among the plans and differ from all actions.
///
/// # Errors
///
/// The first name conflict, in the order of the plans.
pub fn check_names(domain: &Domain, stored: &[Stored]) -> Result<(), NameClash> {
    for (index, plan) in stored.iter().enumerate() {
        if stored[..index].iter().any(|other| other.name == plan.name) {
            return Err(NameClash::Twice(plan.name.clone()));
        }
        let taken = |name: &str| name.eq_ignore_ascii_case(&plan.name);
        if domain.actions.iter().any(|action| taken(&action.call)) {
            return Err(NameClash::Action(plan.name.clone()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::shipped;

    #[track_caller]
    fn check(stem: &str, expected: &str) {
        assert_eq!(plan_name(stem), expected);
    }

    #[test]
    fn any_file_name_becomes_a_legal_name() {
        check("pick_up_spam", "pick_up_spam");
        check("pick up-spam.v2", "pick_up_spam_v2");
        check("12", "plan_12");
        check("if", "plan_if");
        check("_hidden", "hidden");
        check("", "plan");
        check("..", "plan");
        check("été", "t");
        check("a\") \n b", "a_b");
    }

    #[test]
    fn stored_plan_names_must_be_unique() {
        let domain = shipped("household").unwrap().unwrap();
        let clash = |stems: &[&str]| {
            let file: PlanFile = serde_json::from_str(r#"{"task_cohesion": {}}"#).unwrap();
            let stored: Vec<Stored> = stems.iter().map(|stem| Stored::new(stem, file.clone())).collect();
            check_names(&domain, &stored)
                .err()
                .map_or(String::new(), |clash| clash.to_string())
        };
        assert_eq!(clash(&["a", "b"]), "");
        assert_eq!(clash(&["a", "b-c", "b c"]), "two stored plans are called `b_c`");
        let expected = "a stored plan is called `move_hand`, and so is an action of the domain";
        assert_eq!(clash(&["move hand"]), expected);
    }
}
