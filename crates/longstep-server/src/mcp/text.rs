//! Plans, sessions and runs as short texts for models.

use longstep::report::{Answer, Status};
use longstep_core::execution::Mark;
use longstep_core::plan::OutlineLine;

use super::reply::section;
use crate::run::{RunState, RunView};
use crate::view::{AcceptedView, SessionView};

/// Returns the steps of a plan, one a line, with the conditions between them.
pub(super) fn steps(outline: &[OutlineLine]) -> String {
    let lines = outline.iter().map(|line| {
        let indent = "  ".repeat(line.depth);
        match line.step {
            Some(step) => format!("\n{indent}{}. {} [{}]", step + 1, line.explanation, line.text),
            None => format!("\n{indent}{}", line.text),
        }
    });
    lines.collect()
}

/// Returns all that a person should know about a plan besides its steps.
pub(super) fn remarks(answer: &Answer) -> String {
    let gaps = answer.not_represented.iter().map(|gap| gap.text.as_str());
    let choices = answer.choices.iter().flat_map(|choice| &choice.says);
    let edits = answer.edits.iter().map(|edit| edit.why.as_str());
    [
        section("Goal", &answer.goal),
        section("Chosen by the planner", choices),
        section("Assumed", &answer.assumptions),
        section(
            "Words of the instruction that the plan does not say",
            &answer.plan.not_in_plan,
        ),
        section("Parts of the instruction that the plan ignores", gaps),
        section("Changes", edits),
        section("Notes", &answer.notes),
    ]
    .concat()
}

/// Returns the verdict on a written plan.
pub(super) fn verdict(answer: &Answer) -> String {
    let violations = answer.violations.iter().map(|violation| violation.message.as_str());
    let head = match answer.status {
        Status::Verified => format!("The plan is valid: {} steps.", answer.steps.len()),
        Status::Invalid => "The plan is not valid.".to_owned(),
        Status::Unsolvable => "No plan can do this.".to_owned(),
        Status::GaveUp => "No valid plan was found within the limits.".to_owned(),
        Status::Question => format!("The plan asks a question: {}", answer.plan.question),
    };
    let steps = match answer.status {
        Status::Verified => steps(&answer.outline),
        _ => String::new(),
    };
    format!("{head}{}{steps}{}", section("Violations", violations), remarks(answer))
}

/// Returns the state of a session, and the next step.
pub(super) fn session(view: &SessionView, plan_id: Option<&str>) -> String {
    let id = &view.id;
    let question = view.question.as_deref().unwrap_or_default();
    let shown = view.proposal.as_ref().map_or(String::new(), |proposal| {
        let refused = section("Not changed, because", &proposal.refused);
        let answer = &proposal.answer;
        format!(
            "{refused}{}{}\nhash: {}",
            steps(&answer.outline),
            remarks(answer),
            proposal.plan
        )
    });
    let plan_id = plan_id.map_or(String::new(), |plan_id| format!("\nplan_id: {plan_id}"));
    let head = head(view, question);
    let next = next_step(view.state);
    let next = next.map_or(String::new(), |next| format!("\nNext step: {next}"));
    format!("{head}{shown}{plan_id}\nsession: {id}{next}")
}

fn head(view: &SessionView, question: &str) -> String {
    let count = view.proposal.as_ref().map_or(0, |proposal| proposal.answer.steps.len());
    match view.state {
        "plan" => format!("A verified plan with {count} steps. Nothing has moved."),
        "consent" => format!("A verified plan with {count} steps, and a question: {question} Nothing has moved."),
        "question" => format!("A question to the person: {question}"),
        "no_plan" => {
            let why = view.failure.as_ref().map_or("", |failure| failure.message.as_str());
            format!("There is no plan: {why}")
        }
        "endings" => "The last plan has several endings, and no robot has carried it out yet.".to_owned(),
        "thinking" => "The model works for this session.".to_owned(),
        _ => match view.accepted.iter().find(|accepted| accepted.pending) {
            Some(accepted) => waiting(accepted),
            None => "The session is ready for an instruction.".to_owned(),
        },
    }
}

fn waiting(accepted: &AcceptedView) -> String {
    let numbered = accepted.steps.iter().enumerate();
    let steps: String = numbered
        .map(|(index, step)| format!("\n{}. {step}", index + 1))
        .collect();
    format!("The plan for `{}` waits for a robot:{steps}", accepted.instruction)
}

/// Returns the next step in a state of a session; none if anything can follow.
pub(super) fn next_step(state: &str) -> Option<&'static str> {
    Some(match state {
        "plan" => "show the plan to the person; `revise` changes it, `execute_plan` asks the person and carries it out",
        "consent" => {
            "show the plan and the question to the person; `execute_plan` asks the person, `revise` changes the plan"
        }
        "question" => "ask the person, and call `answer` with the answer",
        "no_plan" => "call `plan` with other words, or `revise` with what the person wants",
        "endings" => "call `explain` for the plan_id, then `execute_plan`; or `discard`",
        "thinking" => "wait some seconds, then call `explain`; `discard` cancels the work",
        _ => return None,
    })
}

fn mark(mark: Mark) -> &'static str {
    match mark {
        Mark::Waiting => "waiting",
        Mark::New => "new",
        Mark::UnderWay { .. } => "under way",
        Mark::Done => "done",
        Mark::Failed => "failed",
        Mark::Undone => "to be done again",
        Mark::Skipped => "needless",
        _ => "unknown",
    }
}

/// Returns a run: its state, its steps, and its question.
pub(super) fn run(view: &RunView, page: &str) -> String {
    let record = &view.record;
    let numbered = view.steps.iter().enumerate();
    let steps: String = numbered
        .map(|(index, step)| format!("\n{}. {} ({})", index + 1, step.text, mark(step.mark)))
        .collect();
    let end = view.end.as_ref().map_or(String::new(), |end| format!(": {}", end.text));
    let question = view.question.as_ref().map_or(String::new(), |question| {
        let edits = section("Edits", &question.edits);
        let steps = section("Steps", &question.steps);
        format!(
            "\nA person has to decide: {}{steps}{edits}\nquestion: {}\nNext step: call `decide` with `run` and `question`{page}",
            question.text, question.id
        )
    });
    let notices = section("Noticed", view.notices.iter().rev().take(10).rev());
    let state = view.state.name();
    let next = match view.state {
        RunState::Queued | RunState::Opening | RunState::Running => "\nNext step: call `run_status` again",
        RunState::Paused => "\nNext step: `resume` or `stop`",
        _ => "",
    };
    format!(
        "Run {} on robot `{}` is {state}{end}.{steps}{notices}{question}{next}",
        record.id, record.robot
    )
}
