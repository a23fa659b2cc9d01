//! Pins from the difference between a plan and its rewritten form.

use crate::plan::{DraftStep, Plan, Resolved, Step};
use crate::repair::{Pins, Reach, Unwanted};

/// Returns the pins for a plan that a model rewrote after feedback: new steps are kept, removed steps must not return.
///
/// ```
/// use longstep_core::plan::{TaskCohesion, resolve};
/// use longstep::{domain, feedback};
/// use longstep_core::{verify, environment};
/// let domain = domain::shipped("virtualhome").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk_1>"], "objects": ["<mug_2>"], "object_states": {"<mug_2>": "ON(<desk_1>)"}}"#;
/// let world = environment::parse(&domain, "env.json", text).unwrap();
/// let read = |calls: &[&str]| {
///     let task_sequence = calls.iter().map(|call| (*call).to_owned()).collect();
///     resolve(&world, &TaskCohesion { task_sequence, ..TaskCohesion::default() })
/// };
/// let before = read(&["Walktowards(<desk_1>)", "Grab(<mug_2>)"]);
/// let (before, _) = verify::bind(&world, &before.complete().unwrap(), &[], None).unwrap();
/// let after = read(&["Walktowards(<mug_2>)", "Grab(<mug_2>)"]);
/// let pins = feedback::pins(&before, &after);
/// assert_eq!((pins.kept, pins.unwanted.len()), (vec![0], 1));
/// ```
pub fn pins(before: &Plan, after: &Resolved) -> Pins {
    let old = before.steps();
    let new = &after.steps;
    // The alignment with the most common steps, which prefers steps with equal explanations.
    let mut score = vec![vec![0u32; new.len() + 1]; old.len() + 1];
    let worth = |step: &Step, drafted: &Option<DraftStep>| match drafted {
        Some(drafted) if is_like(step, drafted) => 2 + u32::from(step.explanation == drafted.explanation),
        _ => 0,
    };
    for i in (0..old.len()).rev() {
        for j in (0..new.len()).rev() {
            let met = match worth(&old[i], &new[j]) {
                0 => 0,
                worth => worth + score[i + 1][j + 1],
            };
            score[i][j] = met.max(score[i + 1][j]).max(score[i][j + 1]);
        }
    }
    let (mut i, mut j) = (0, 0);
    let mut kept = Vec::new();
    let mut gone = Vec::new();
    while i < old.len() || j < new.len() {
        let met = i < old.len() && j < new.len() && {
            let worth = worth(&old[i], &new[j]);
            worth > 0 && score[i][j] == worth + score[i + 1][j + 1]
        };
        if met {
            (i, j) = (i + 1, j + 1);
        } else if j == new.len() || (i < old.len() && score[i][j] == score[i + 1][j]) {
            gone.push((&old[i], j));
            i += 1;
        } else {
            kept.push(j);
            j += 1;
        }
    }
    // A step that did not resolve cannot be kept.
    kept.retain(|index| new[*index].is_some());
    Pins {
        kept,
        unwanted: unwanted(&gone, new),
    }
}

/// Returns the constraints against removed steps. Each reaches as far as the remaining draft permits. A removed step
/// comes with the index of the draft step that followed it.
pub(super) fn unwanted(gone: &[(&Step, usize)], draft: &[Option<DraftStep>]) -> Vec<Unwanted> {
    let reach = |step: &Step| {
        let mut left = draft.iter().flatten();
        if left.clone().any(|other| is_like(step, other)) {
            Reach::Here
        } else if left.any(|other| other.action == step.action) {
            Reach::ThisStep
        } else {
            Reach::ThisAction
        }
    };
    gone.iter()
        .map(|(step, before)| Unwanted {
            action: step.action,
            arguments: step.arguments.clone(),
            before: *before,
            reach: reach(step),
        })
        .collect()
}

/// Returns true if the draft step can be an instance of this step.
fn is_like(step: &Step, drafted: &DraftStep) -> bool {
    let mut pairs = step.arguments.iter().zip(&drafted.arguments);
    step.action == drafted.action && pairs.all(|(known, other)| other.is_none_or(|other| other == *known))
}
