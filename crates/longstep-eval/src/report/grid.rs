//! Attempts in a table.

use std::collections::BTreeMap;

use super::groups;
use crate::attempt::Attempt;
use crate::folder::Results;

/// Trials and wordings in rows, cases in columns.
pub(super) struct Grid<'a> {
    /// The cases, in the order of the run.
    pub(super) cases: Vec<&'a str>,
    pub(super) rows: Vec<Row<'a>>,
}

/// A trial with one wording.
pub(super) struct Row<'a> {
    pub(super) name: String,
    /// Its attempts with their places in the run; `None` if a case lacks the wording or has not run yet.
    pub(super) cells: Vec<Option<(usize, &'a Attempt)>>,
}

/// The grid of a run. Only the first step of a chain is included.
pub(super) fn grid(results: &Results) -> Grid<'_> {
    let (mut cases, mut rows) = (Vec::new(), Vec::new());
    let mut attempts = BTreeMap::new();
    for (place, attempt) in results.attempts.iter().enumerate() {
        let key = &attempt.key;
        if !cases.contains(&key.case.as_str()) {
            cases.push(key.case.as_str());
        }
        let row = (key.wording.as_str(), key.trial);
        if !rows.contains(&row) {
            rows.push(row);
        }
        attempts.entry((key.case.as_str(), row)).or_insert((place, attempt));
    }
    let several_wordings = groups::several_wordings(results);
    // Groups the trials of a wording, in any order of the run.
    let wordings: Vec<&str> = rows.iter().map(|(wording, _)| *wording).collect();
    rows.sort_by_key(|(wording, trial)| (wordings.iter().position(|known| known == wording), *trial));
    let named = |row: (&str, u32)| {
        let trial = format!("Trial {}", row.1);
        if several_wordings {
            format!("{trial}, {}", row.0.replace('_', " "))
        } else {
            trial
        }
    };
    let rows = rows
        .iter()
        .map(|row| Row {
            name: named(*row),
            cells: cases.iter().map(|case| attempts.get(&(*case, *row)).copied()).collect(),
        })
        .collect();
    Grid { cases, rows }
}

/// A scene with its cases, and the attempts of each case with their places in the run.
pub(super) struct Scene<'a> {
    pub(super) name: &'a str,
    pub(super) cases: Vec<(&'a str, Vec<(usize, &'a Attempt)>)>,
}

/// The attempts, grouped by scene and case.
pub(super) fn scenes(results: &Results) -> Vec<Scene<'_>> {
    let mut scenes: Vec<Scene<'_>> = Vec::new();
    let mut places: BTreeMap<(&str, &str), (usize, usize)> = BTreeMap::new();
    for (place, attempt) in results.attempts.iter().enumerate() {
        let (name, case) = (attempt.scene.as_str(), attempt.key.case.as_str());
        let (scene, at) = *places.entry((name, case)).or_insert_with(|| {
            let scene = scenes.iter().position(|scene| scene.name == name).unwrap_or_else(|| {
                scenes.push(Scene {
                    name,
                    cases: Vec::new(),
                });
                scenes.len() - 1
            });
            scenes[scene].cases.push((case, Vec::new()));
            (scene, scenes[scene].cases.len() - 1)
        });
        scenes[scene].cases[at].1.push((place, attempt));
    }
    scenes
}
