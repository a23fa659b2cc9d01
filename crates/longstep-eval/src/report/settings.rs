//! The settings of a run.

use serde_json::Value;

use super::words::several;
use crate::folder::Plan;

/// The settings of a run with their names, in the order of the plan's fields.
pub(crate) fn settings(plan: &Plan) -> Vec<(&'static str, String)> {
    let settings = &plan.settings;
    let word = |value: Value| {
        value
            .as_str()
            .map_or_else(|| value.to_string(), |word| word.replace('_', " "))
    };
    let any = |list: &[String]| {
        if list.is_empty() {
            "all".to_owned()
        } else {
            list.join(", ")
        }
    };
    vec![
        ("suite", plan.suite.clone()),
        ("suite, SHA-256", plan.suite_sha256.clone()),
        ("domain", plan.domain.clone()),
        ("domain, SHA-256", plan.domain_sha256.clone()),
        ("model", plan.model.clone()),
        (
            "model, SHA-256",
            plan.model_sha256.clone().unwrap_or_else(|| "none".to_owned()),
        ),
        ("adapters", plan.adapters.clone()),
        (
            "strategy",
            word(serde_json::to_value(settings.strategy).unwrap_or_default()),
        ),
        (
            "repair",
            word(serde_json::to_value(settings.repair).unwrap_or_default()),
        ),
        ("rounds at most", settings.rounds.to_string()),
        ("accepted without asking", settings.accept.to_string()),
        ("earlier instructions shown", settings.history.to_string()),
        ("temperature", plan.temperature.to_string()),
        (
            "top p",
            plan.top_p.map_or_else(|| "none".to_owned(), |share| share.to_string()),
        ),
        ("seed", plan.seed.to_string()),
        ("trials", plan.trials.to_string()),
        ("tags", any(&plan.tags)),
        ("wordings", any(&plan.wordings)),
        (
            "changes",
            if plan.changes.is_empty() {
                "none".to_owned()
            } else {
                plan.changes.join("; ")
            },
        ),
        ("longstep", plan.longstep.clone()),
        ("version of the files", plan.version.to_string()),
    ]
}

/// The main settings in one line.
pub(super) fn line(plan: &Plan) -> String {
    let settings = self::settings(plan);
    let value = |name: &str| {
        let found = settings.iter().find(|(known, _)| *known == name);
        found.map_or("", |(_, value)| value.as_str())
    };
    let mut parts = vec![
        format!("strategy {}", value("strategy")),
        format!("repair {}", value("repair")),
        format!("at most {}", several(u64::from(plan.settings.rounds), "round")),
        several(u64::from(plan.trials), "trial"),
        format!("temperature {}", plan.temperature),
        format!("seed {}", plan.seed),
        format!("wordings {}", value("wordings")),
    ];
    if let Some(hash) = &plan.model_sha256 {
        parts.push(format!("model {}", hash.get(..12).unwrap_or(hash)));
    }
    if !plan.changes.is_empty() {
        parts.push(format!("changed: {}", value("changes")));
    }
    parts.push(format!("longstep {}", plan.longstep));
    parts.join(", ")
}
