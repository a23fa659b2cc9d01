//! The schemas of results, as plain JSON. They name what a program relies on; results may have more.

use serde_json::{Value, json};

/// The schema of a session with its plan.
pub(super) fn session() -> Value {
    let strings = strings();
    json!({
        "type": "object",
        "properties": {
            "plan_id": described("For `execute_plan`; null without a plan.", nullable(json!({"type": "string"}))),
            "hash": described("The hash of the plan, for `execute_plan`.", nullable(json!({"type": "string"}))),
            "id": {"type": "string", "description": "The session."},
            "version": {"type": "integer"},
            "domain": {"type": "string"},
            "model": {"type": "string"},
            "state": {
                "type": "string",
                "enum": ["ready", "thinking", "question", "plan", "consent", "no_plan", "endings", "unknown"],
            },
            "instruction": nullable(json!({"type": "string"})),
            "question": nullable(json!({"type": "string"})),
            "proposal": nullable(json!({
                "type": "object",
                "properties": {
                    "plan": {"type": "string"},
                    "refused": strings,
                    "offers_rule": {"type": "boolean"},
                    "answer": answer(),
                },
                "required": ["plan", "refused", "offers_rule", "answer"],
            })),
            "failure": nullable(json!({
                "type": "object",
                "properties": {"message": {"type": "string"}},
                "required": ["message"],
            })),
            "endings": {"type": "array", "items": {"type": "object"}},
            "accepted": {
                "type": "array",
                "items": {
                    "type": "object",
                    "properties": {
                        "number": {"type": "integer"},
                        "plan": {"type": "string"},
                        "instruction": {"type": "string"},
                        "goal": strings,
                        "steps": strings,
                        "not_in_plan": strings,
                        "pending": {"type": "boolean"},
                    },
                    "required": ["number", "plan", "instruction", "goal", "steps", "not_in_plan", "pending"],
                },
            },
            "rules": strings,
            "environment": {"type": "object"},
        },
        "required": ["plan_id", "hash", "id", "state", "question", "proposal", "accepted", "rules", "environment"],
    })
}

/// The schema of an answer, as `longstep plan --json` prints it.
pub(super) fn answer() -> Value {
    let strings = strings();
    json!({
        "type": "object",
        "properties": {
            "status": {"type": "string", "enum": ["verified", "invalid", "unsolvable", "gave_up", "question"]},
            "plan": {"type": "object", "description": "The plan file."},
            "steps": {
                "type": "array",
                "items": {
                    "type": "object",
                    "properties": {
                        "index": {"type": "integer"},
                        "action": {"type": "string"},
                        "arguments": strings,
                        "explanation": {"type": "string"},
                    },
                    "required": ["index", "action", "arguments", "explanation"],
                },
            },
            "goal": strings,
            "edits": {
                "type": "array",
                "items": {
                    "type": "object",
                    "properties": {"kind": {"type": "string"}, "at": {"type": "integer"}, "why": {"type": "string"}},
                    "required": ["kind", "at", "why"],
                },
            },
            "violations": {
                "type": "array",
                "items": {
                    "type": "object",
                    "properties": {
                        "kind": {"type": "string"},
                        "step": nullable(json!({"type": "integer"})),
                        "message": {"type": "string"},
                    },
                    "required": ["kind", "step", "message"],
                },
            },
            "assumptions": strings,
            "notes": strings,
        },
        "required": ["status", "plan", "steps", "goal", "edits", "violations", "assumptions", "notes"],
    })
}

/// The schema of a plan with its reasons.
pub(super) fn explanation() -> Value {
    let strings = strings();
    json!({
        "type": "object",
        "properties": {
            "session": {"type": "string"},
            "plan_id": {"type": "string"},
            "hash": {"type": "string"},
            "instruction": {"type": "string"},
            "goal": strings,
            "steps": {
                "type": "array",
                "items": {
                    "type": "object",
                    "properties": {
                        "number": {"type": "integer"},
                        "text": {"type": "string"},
                        "brings_about": strings,
                        "without_it": strings,
                    },
                    "required": ["number", "text", "brings_about", "without_it"],
                },
            },
            "assumptions": strings,
            "not_in_plan": strings,
            "rules": strings,
        },
        "required": ["session", "plan_id", "hash", "instruction", "goal", "steps", "assumptions", "not_in_plan", "rules"],
    })
}

/// The schema of a run.
pub(super) fn run() -> Value {
    json!({
        "type": "object",
        "properties": {
            "id": {"type": "string"},
            "session": {"type": "string"},
            "plan": {"type": "string", "description": "The hash of the plan that was approved."},
            "robot": {"type": "string"},
            "by": {"type": "string"},
            "state": {
                "type": "string",
                "enum": ["queued", "opening", "running", "asking", "paused", "done", "stopped", "interrupted"],
            },
            "dry_run": {"type": "boolean"},
            "steps": {"type": "array", "items": {"type": "object"}},
            "question": nullable(json!({
                "type": "object",
                "properties": {"id": {"type": "string"}, "kind": {"type": "string"}, "text": {"type": "string"}},
                "required": ["id", "kind", "text"],
            })),
            "notices": strings(),
            "end": nullable(json!({
                "type": "object",
                "properties": {"done": {"type": "boolean"}, "text": {"type": "string"}},
                "required": ["done", "text"],
            })),
        },
        "required": ["id", "session", "plan", "robot", "by", "state", "steps", "question", "notices", "end"],
    })
}

/// The schema of a run, or of a session for a plan that puts a rule in force.
pub(super) fn executed() -> Value {
    json!({
        "type": "object",
        "properties": {"id": {"type": "string"}, "state": {"type": "string"}},
        "required": ["id", "state"],
    })
}

/// The schema of a world.
pub(super) fn world() -> Value {
    let strings = strings();
    json!({
        "type": "object",
        "properties": {
            "session": nullable(json!({"type": "string"})),
            "domain": {"type": "string"},
            "environment": {"type": "object"},
            "rules": strings,
            "actions": {
                "type": "array",
                "items": {
                    "type": "object",
                    "properties": {"call": {"type": "string"}, "means": {"type": "string"}},
                    "required": ["call", "means"],
                },
            },
            "robots": strings,
        },
        "required": ["session", "domain", "environment", "rules", "actions", "robots"],
    })
}

/// The schema of a stop.
pub(super) fn stopped() -> Value {
    json!({
        "type": "object",
        "properties": {"stopped": {"type": "integer", "description": "Runs that were going on."}},
        "required": ["stopped"],
    })
}

/// One type or null; a list of types is less portable.
fn nullable(schema: Value) -> Value {
    json!({"anyOf": [schema, {"type": "null"}]})
}

fn described(description: &str, mut schema: Value) -> Value {
    schema["description"] = Value::from(description);
    schema
}

fn strings() -> Value {
    json!({"type": "array", "items": {"type": "string"}})
}
