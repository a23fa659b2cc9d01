//! The tools, as a table: a model that has never seen Longstep reads these descriptions.

use std::sync::Arc;

use rmcp::model::{JsonObject, Tool, ToolAnnotations};
use serde_json::{Value, json};

use super::schema;

/// The effect of a tool.
#[derive(Clone, Copy)]
enum Effect {
    /// It changes nothing.
    Reads,
    /// It changes a session; nothing moves.
    Plans,
    /// It lets a robot move, or go on.
    Moves,
    /// It halts a robot; doing it twice is no error.
    Halts,
}

impl Effect {
    fn annotations(self) -> ToolAnnotations {
        let hints = ToolAnnotations::new().open_world(false);
        match self {
            Self::Reads => hints.read_only(true).destructive(false).idempotent(true),
            Self::Plans => hints.read_only(false).destructive(false),
            Self::Moves => hints.read_only(false).destructive(true).open_world(true),
            Self::Halts => hints.read_only(false).destructive(false).idempotent(true),
        }
    }
}

/// An argument: its name, whether it is required, and its schema.
type Argument = (&'static str, bool, Value);

fn text(name: &'static str, description: &str) -> Argument {
    (name, true, json!({"type": "string", "description": description}))
}

fn session() -> Argument {
    let description = "The session, as `plan` returned it (`id`). Without it: the last session of this connection.";
    ("session", false, json!({"type": "string", "description": description}))
}

fn run() -> Argument {
    text("run", "The run, as `execute_plan` or `run_status` returned it (`id`).")
}

fn draft() -> Vec<Argument> {
    let plan = "The plan as text: a plan file of Longstep, a list of calls such as `grasp_object(<pen>)`, or a text with one of them.";
    let goal = "A goal that the plan has to achieve, in Longstep's goal language, such as `put(pen, shelf)`.";
    vec![
        text("plan", plan),
        ("goal", false, json!({"type": "string", "description": goal})),
        session(),
    ]
}

fn tool(
    name: &'static str,
    title: &'static str,
    description: &'static str,
    effect: Effect,
    arguments: Vec<Argument>,
    output: Value,
) -> Tool {
    let required = arguments.iter().filter(|(_, required, _)| *required);
    let required: Vec<&str> = required.map(|(name, ..)| *name).collect();
    let properties: JsonObject = arguments
        .iter()
        .map(|(name, _, schema)| ((*name).to_owned(), schema.clone()))
        .collect();
    let input = json!({
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    });
    let mut tool = Tool::new(name, description, object(input));
    tool.title = Some(title.to_owned());
    tool.annotations = Some(effect.annotations());
    tool.output_schema = Some(object(output));
    tool
}

fn object(value: Value) -> Arc<JsonObject> {
    match value {
        Value::Object(object) => Arc::new(object),
        _ => Arc::default(),
    }
}

/// Returns all tools.
pub(super) fn all() -> Vec<Tool> {
    [planning(), judging(), running()].concat()
}

fn planning() -> Vec<Tool> {
    vec![
        tool(
            "describe_world",
            "Describe the world",
            "Shows the objects and places that the robot knows, where everything is, the actions that the robot has, the \
             rules in force, and the names of the robots. Changes nothing.",
            Effect::Reads,
            vec![session()],
            schema::world(),
        ),
        tool(
            "plan",
            "Plan an instruction",
            "Makes a verified plan for an instruction in plain words. Nothing moves. Returns the steps with `plan_id` and \
             `hash` for `execute_plan`, or a question to the person (then call `answer`), or the reason why there is no \
             plan. A plan without a decision is dropped by the next instruction.",
            Effect::Plans,
            vec![
                text("instruction", "What the robot should do, in the words of the person."),
                session(),
            ],
            schema::session(),
        ),
        tool(
            "answer",
            "Answer the question",
            "Answers the question that `plan`, `answer` or `revise` returned. Ask the person; do not guess.",
            Effect::Plans,
            vec![text("answer", "The answer, in the words of the person."), session()],
            schema::session(),
        ),
        tool(
            "revise",
            "Change the plan",
            "Changes the plan that waits for a decision, or an instruction without a plan, by a remark in plain words. The \
             changed plan is verified and has another `hash`; a change that is not possible is listed with its reason.",
            Effect::Plans,
            vec![
                text("feedback", "What is to be different, in the words of the person."),
                session(),
            ],
            schema::session(),
        ),
        tool(
            "discard",
            "Drop the plan",
            "Drops the question or the plan that waits for a decision, or the last plan that waits for a robot, or cancels \
             the work of the model. A run is not affected; call `stop` for that.",
            Effect::Plans,
            vec![session()],
            schema::session(),
        ),
    ]
}

fn judging() -> Vec<Tool> {
    vec![
        tool(
            "verify",
            "Verify a written plan",
            "Simulates a plan that you wrote in the world of the session, and lists every violation with its step. Changes \
             nothing. A plan that you wrote is not carried out; `plan` makes one that can be.",
            Effect::Reads,
            draft(),
            schema::answer(),
        ),
        tool(
            "repair",
            "Repair a written plan",
            "Finds the cheapest edits that make a plan valid which you wrote, each with its reason. Changes nothing.",
            Effect::Reads,
            draft(),
            schema::answer(),
        ),
        tool(
            "explain",
            "Explain the plan",
            "Explains the plan that waits for a decision or for a robot: what each step achieves, what would fail without \
             it, what is assumed, and which words of the instruction are not in the plan. Returns a fresh `plan_id`.",
            Effect::Reads,
            vec![session()],
            schema::explanation(),
        ),
    ]
}

fn running() -> Vec<Tool> {
    let robot = "The robot, as `describe_world` names it. Without it: the usual one.";
    let wait = "Seconds to wait for the end or for a question of the run, at most 30.";
    vec![
        tool(
            "execute_plan",
            "Carry out a plan",
            "Shows the plan to a person in a form and, only if they approve exactly this plan, lets the robot carry it out. \
             Returns the run at once; call `run_status` for its course. If the client cannot ask a person, nothing moves, \
             and the result says how to approve.",
            Effect::Moves,
            vec![
                text("plan_id", "The `plan_id` of the plan. It starts one run and expires."),
                text("hash", "The `hash` that was returned with the plan_id."),
                ("robot", false, json!({"type": "string", "description": robot})),
            ],
            schema::executed(),
        ),
        tool(
            "decide",
            "Decide a question of a run",
            "Shows the question of a run (a change of its plan, a step, or something nobody has seen) to a person in a form, \
             and passes their answer on. You cannot answer it yourself.",
            Effect::Moves,
            vec![
                run(),
                text("question", "The `id` of the question, as `run_status` shows it."),
            ],
            schema::run(),
        ),
        tool(
            "run_status",
            "Show a run",
            "Shows the state of a run, its steps, what was noticed, and its question if it has one. Changes nothing.",
            Effect::Reads,
            vec![
                (
                    "run",
                    false,
                    json!({"type": "string", "description": "The run. Without it: the last one of the session."}),
                ),
                (
                    "wait_seconds",
                    false,
                    json!({"type": "number", "minimum": 0, "description": wait}),
                ),
                session(),
            ],
            schema::run(),
        ),
        tool(
            "pause",
            "Pause a run",
            "Pauses a run after the steps that are under way.",
            Effect::Halts,
            vec![run()],
            schema::run(),
        ),
        tool(
            "resume",
            "Let a paused run go on",
            "Lets a run go on that this client has paused, from the world that is observed then.",
            Effect::Moves,
            vec![run()],
            schema::run(),
        ),
        tool(
            "stop",
            "Stop the robot",
            "Stops a run at once, or every run if `run` is missing. Call it whenever somebody asks to stop.",
            Effect::Halts,
            vec![(
                "run",
                false,
                json!({"type": "string", "description": "The run. Without it: all of them."}),
            )],
            schema::stopped(),
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_has_each_tool_once_with_its_schemas() {
        let tools = all();
        let mut names: Vec<&str> = tools.iter().map(|tool| tool.name.as_ref()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), tools.len());
        for tool in &tools {
            for schema in [Some(&tool.input_schema), tool.output_schema.as_ref()]
                .into_iter()
                .flatten()
            {
                let schema = Value::Object((**schema).clone());
                assert_eq!(schema["type"], "object", "{}", tool.name);
                assert!(jsonschema::validator_for(&schema).is_ok(), "{}", tool.name);
            }
            let description = tool.description.as_deref().unwrap_or_default();
            assert!((40..500).contains(&description.len()), "{}", tool.name);
        }
    }
}
