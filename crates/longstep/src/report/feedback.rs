//! What a model is told about its plan.

use crate::model::Domain;
use crate::plan::Step;
use crate::repair::Edit;
use crate::verify::Violation;
use crate::visible;
use crate::world::{Voice, World};

/// A turn of feedback: what is wrong, in the model's own identifiers, and the smallest change that mends it if one is
/// known.
///
/// `steps` are the plan's, and `length` their number as the model wrote them.
///
/// ```
/// use longstep::plan::{TaskCohesion, resolve};
/// use longstep::verify::{Purpose, bind, check, feedback};
/// use longstep::{domain, json, world};
/// let domain = domain::shipped("virtualhome").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk_1>"], "objects": ["<mug_2>"], "object_states": {"<mug_2>": "ON(<desk_1>)"}}"#;
/// let environment = world::Environment::from_json(text).unwrap();
/// let world = world::read(&domain, &environment, "env.json", text, &json::Path::default()).unwrap();
/// let draft = TaskCohesion { task_sequence: vec!["Grab(<mug_2>)".to_owned()], ..TaskCohesion::default() };
/// let resolved = resolve(&domain, &world, &draft);
/// let (plan, _) = bind(&domain, &world, &resolved.complete().unwrap(), &[], None).unwrap();
/// let report = check(&domain, &world, plan, &Purpose::default());
/// let told = feedback(&domain, &world, &report.violations, report.plan.steps(), 1, &[]);
/// assert!(told.contains("step 1: Grab(<mug_2>) needs that <mug_2> is within reach"));
/// ```
pub(crate) fn feedback(
    domain: &Domain,
    world: &World,
    violations: &[Violation],
    steps: &[Step],
    length: usize,
    edits: &[Edit],
) -> String {
    let mut text = String::from("This plan cannot be carried out as it is.\n");
    for violation in violations {
        let told = violation.message_in(Voice::Model, domain, world, steps, None);
        text.push_str(&format!("- {}\n", visible::line(&told)));
    }
    if !edits.is_empty() {
        text.push_str("The smallest change that makes it work:\n");
        for edit in edits {
            text.push_str(&format!("- {}\n", visible::line(&edit.told(length))));
        }
    }
    text.push_str("Answer with the whole plan again, in the same format.\n");
    text
}
