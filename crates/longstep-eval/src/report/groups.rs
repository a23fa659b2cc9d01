//! Groups and labels of attempts.

use std::collections::{BTreeMap, BTreeSet};

use crate::attempt::Attempt;
use crate::folder::Results;
use crate::rate::Rate;

/// The label of an attempt: the shortest part of its key that is unique in the run.
pub(crate) fn label(results: &Results, attempt: &Attempt) -> String {
    let key = &attempt.key;
    let mut label = if super::paper::is_paper(results) {
        format!("Scenario {}", key.case)
    } else {
        key.case.clone()
    };
    let chain = |other: &Attempt| other.key.case == key.case && other.key.step > 0;
    if key.step > 0 || results.attempts.iter().any(chain) {
        label += &format!(", step {}", key.step + 1);
    }
    if several_wordings(results) {
        label += &format!(", {}", key.wording.replace('_', " "));
    }
    if results.plan.trials > 1 {
        label += &format!(", trial {}", key.trial);
    }
    label
}

/// Returns true if the run has more than one wording.
pub(super) fn several_wordings(results: &Results) -> bool {
    let mut wordings = results.attempts.iter().map(|attempt| &attempt.key.wording);
    let first = wordings.next();
    wordings.any(|wording| Some(wording) != first)
}

/// A group of attempts.
pub(super) struct Group {
    pub(super) name: String,
    pub(super) correct: Rate,
    /// Share of the attempts that expect a plan.
    pub(super) executable: Rate,
}

/// The attempts grouped by tag, scene and wording, each with a heading. Groupings with a single group are omitted.
pub(super) fn groupings(results: &Results) -> Vec<(&'static str, Vec<Group>)> {
    let by_tag = groups(results, |attempt| attempt.tags.clone());
    let by_scene = groups(results, |attempt| vec![attempt.scene.clone()]);
    let by_wording = groups(results, |attempt| vec![attempt.key.wording.replace('_', " ")]);
    let mut all = vec![("By tag", by_tag), ("By scene", by_scene), ("By wording", by_wording)];
    // If each case has a scene of its own, the grid shows the same information.
    let cases: BTreeSet<&str> = results
        .attempts
        .iter()
        .map(|attempt| attempt.key.case.as_str())
        .collect();
    all.retain(|(heading, groups)| groups.len() > 1 && (*heading != "By scene" || groups.len() < cases.len()));
    all
}

fn groups(results: &Results, of: impl Fn(&Attempt) -> Vec<String>) -> Vec<Group> {
    let mut names: Vec<String> = Vec::new();
    let mut members: BTreeMap<String, Vec<&Attempt>> = BTreeMap::new();
    for attempt in &results.attempts {
        for name in of(attempt) {
            // In the order of the run: scenario 2 precedes scenario 10.
            if !members.contains_key(&name) {
                names.push(name.clone());
            }
            members.entry(name).or_default().push(attempt);
        }
    }
    let group = |name: String| {
        let all = &members[&name];
        Group {
            correct: Rate::count(all, |attempt| attempt.correct),
            executable: Rate::count(all.iter().filter(|a| a.wants_plan()), |attempt| attempt.executable),
            name,
        }
    };
    names.into_iter().map(group).collect()
}
