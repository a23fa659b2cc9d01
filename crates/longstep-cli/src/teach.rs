//! `longstep teach`: the skill parameters of a plan's steps, from demonstrations.

mod questions;
#[cfg(unix)]
mod recorder;
mod recording;

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::Result;
use longstep_core::skill::Skills;
use longstep_files::{plain_reason, read_text, write_whole};
use longstep_teach::{
    BYTES, Demonstration, Expectations, Finding, Format, Hand, Lesson, Request, Segment, TaughtStep, TaughtValue, cut,
    cut_at_times, learn, one_each, requests, skills_file, step_times,
};
use serde_json::{Value, json};

use crate::arguments::{DraftArguments, TeachArguments};
use crate::draft::Draft;
use crate::exit_code::NOT_VALID;
use crate::failure::Failure;
use crate::output::{self, Style, print_line, remark, shell_word};
use crate::show;
use questions::Questions;
use recorder::StepRecorder;

pub(crate) fn run(arguments: &TeachArguments) -> Result<u8> {
    let draft = Draft::read(&DraftArguments {
        plan: arguments.plan.clone(),
        env: arguments.env.clone(),
        project_env: arguments.project_env.clone(),
        problem: None,
        domain: Some(arguments.domain().to_owned()),
        rules: arguments.rules.clone(),
    })?;
    let plan = match draft.verified("taught") {
        Ok(plan) => plan,
        Err(code) => return Ok(code),
    };
    let requests = requests(plan.world(), plan.plan());
    if requests.iter().all(|request| request.parameters.is_empty()) {
        let domain = arguments.domain();
        return Err(Failure::unreadable(format!(
            "the domain `{domain}` declares no parameters that a person teaches"
        ))
        .hint("declare them in its skills.toml, or use `--domain household-taught`")
        .into());
    }
    let expectations = expectations(arguments)?;
    if let Some(unknown) = expectations
        .objects
        .keys()
        .find(|name| plan.world().find(name).is_none())
    {
        return Err(
            Failure::unreadable(format!("--positions: the world has no `{unknown}`"))
                .hint("use the identifiers of the environment, with their brackets")
                .into(),
        );
    }
    let mut notes = Vec::new();
    let (lesson, repetition) = if arguments.demo.is_empty() {
        let recorder = StepRecorder::of(arguments, requests.len())?;
        Questions::new(&requests, &expectations, recorder).lesson()?
    } else {
        let recordings = recordings(arguments)?;
        notes.extend(recordings.iter().flat_map(notes_of));
        let segments = segments(arguments, &requests, &recordings)?;
        (learn(&requests, &segments, &expectations), None)
    };
    let file = skills_file(&requests, &lesson);
    // The program that reads the file is the one that wrote it: what it refuses is a defect of this command.
    Skills::from_value(draft.world.domain(), file.clone())?;
    let mut text = serde_json::to_string_pretty(&file)?;
    text.push('\n');
    write_whole(&arguments.output, text.as_bytes()).map_err(|error| {
        Failure::unreadable(format!(
            "cannot write {}: {}",
            arguments.output.display(),
            plain_reason(&error)
        ))
        .hint("check that the folder exists and is writable")
    })?;
    if arguments.json {
        output::json(&json_of(&lesson, file, &notes))?;
    } else {
        if !arguments.demo.is_empty() {
            for step in &lesson.steps {
                show_step(&requests, step);
            }
            notes.iter().for_each(|note| show_note(note));
            lesson.findings.iter().for_each(tell);
        }
        conclude(arguments, &lesson);
        if let Some(repetition) = repetition {
            show::hint(&repetition);
        }
    }
    Ok(if lesson.is_complete() { 0 } else { NOT_VALID })
}

fn conclude(arguments: &TeachArguments, lesson: &Lesson) {
    let values: usize = lesson.steps.iter().map(|step| step.values.len()).sum();
    let output = arguments.output.display();
    print_line!("{output} has {values} value(s) of {} step(s)", lesson.steps.len());
    let (plan, file) = (shell_word(arguments.plan.display()), shell_word(output));
    let domain = shell_word(arguments.domain());
    if lesson.is_complete() {
        show::hint(&format!(
            "`longstep run {plan} --domain {domain} --skills {file} --robot ROBOT` uses them"
        ))
    } else {
        show::hint("values are missing: `longstep run` refuses the plan until every step is taught")
    }
}

fn json_of(lesson: &Lesson, skills: Value, notes: &[String]) -> Value {
    let finding = |own: &Finding| {
        json!({
            "step": own.step,
            "subject": own.subject,
            "message": own.problem.to_string(),
            "doubt": own.is_doubt(),
        })
    };
    json!({
        "complete": lesson.is_complete(),
        "skills": skills,
        "findings": lesson.findings.iter().map(finding).collect::<Vec<_>>(),
        "notes": notes,
    })
}

/// Reads the recordings of `--demo`.
fn recordings(arguments: &TeachArguments) -> Result<Vec<Demonstration>> {
    let hand = arguments.hand.map(Into::into);
    arguments.demo.iter().map(|path| recording(path, hand)).collect()
}

/// Returns the notes about how a recording was read, with its name.
fn notes_of(recording: &Demonstration) -> impl Iterator<Item = String> + '_ {
    recording
        .notes
        .iter()
        .map(|note| format!("{}: {note}", recording.source))
}

fn show_note(note: &str) {
    remark!("{} {note}", "note:".cyan().bold());
}

/// Cuts the recordings into steps.
fn segments(arguments: &TeachArguments, requests: &[Request], recordings: &[Demonstration]) -> Result<Vec<Segment>> {
    let times = match &arguments.segments {
        Some(text) => Some(step_times(text).map_err(|reason| Failure::unreadable(format!("--segments: {reason}")))?),
        None => None,
    };
    if let Some(time) = times.iter().flatten().find(|time| time.step > requests.len()) {
        let message = format!(
            "--segments: the plan has {} steps, and no step {}",
            requests.len(),
            time.step
        );
        return Err(Failure::unreadable(message).into());
    }
    let unclear = |finding: Finding| Failure::new(finding.to_string(), NOT_VALID);
    match (recordings, times) {
        ([one], Some(times)) => Ok(cut_at_times(one, &times)),
        ([one], None) => Ok(cut(one, requests).map_err(unclear)?),
        (_, Some(_)) => Err(Failure::unreadable("`--segments` needs one recording")
            .hint("give one file with `--demo`, or leave `--segments` out")
            .into()),
        (several, None) => Ok(one_each(several, requests).map_err(unclear)?),
    }
}

/// Recorders are ended with the process groups of Unix.
#[cfg(not(unix))]
mod recorder {
    use anyhow::Result;
    use longstep_teach::Segment;

    use super::recording::Recording;
    use crate::arguments::TeachArguments;
    use crate::failure::Failure;
    use crate::input_lines::InputLines;

    /// There is none.
    pub(super) enum StepRecorder {}

    pub(super) enum Recorded {
        Shown(Recording),
        Answer(Option<String>),
        Stopped,
    }

    impl StepRecorder {
        pub(super) fn of(arguments: &TeachArguments, _: usize) -> Result<Option<Self>> {
            match arguments.recorder {
                None => Ok(None),
                Some(_) => Err(Failure::unreadable("`--recorder` works on Unix only")
                    .hint("record with your own program, and answer with its file")
                    .into()),
            }
        }

        pub(super) fn record(&self, _: usize, _: &mut InputLines) -> Result<Recorded> {
            match *self {}
        }

        pub(super) fn command(&self) -> String {
            match *self {}
        }

        pub(super) fn repetition(&self, _: &[&Segment]) -> String {
            match *self {}
        }
    }
}

/// Reads a recording in the format that its name says, of this hand if it does not say which.
fn recording(path: &Path, hand: Option<Hand>) -> Result<Demonstration> {
    let shown = path.display().to_string();
    let Some(format) = Format::of_name(&shown) else {
        return Err(Failure::unreadable(format!("{shown} is no recording"))
            .hint("a recording is a .csv, .json, .jsonl or .mcap file")
            .into());
    };
    let failed = |error: &std::io::Error| Failure::unreadable(format!("cannot read {shown}: {}", plain_reason(error)));
    let file = File::open(path).map_err(|error| failed(&error))?;
    let mut bytes = Vec::new();
    // One byte more than is read, so that a file that is too long is refused.
    file.take(BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| failed(&error))?;
    Demonstration::read_hand(&shown, format, &bytes, hand.unwrap_or(Hand::Right)).map_err(|error| {
        Failure::unreadable(error.to_string())
            .hint("docs/guide/teaching.md lists the columns of recordings")
            .into()
    })
}

fn expectations(arguments: &TeachArguments) -> Result<Expectations> {
    let objects = match &arguments.positions {
        Some(path) => serde_json::from_str(&read_text(path)?).map_err(|error| {
            Failure::unreadable(format!("{}: {error}", path.display()))
                .hint("write an object of positions: {\"<juice>\": [0.3, 0.2, 0.8]}")
        })?,
        None => Default::default(),
    };
    Ok(Expectations {
        hand: arguments.hand.map(Into::into),
        reference: arguments.frame.clone(),
        objects,
    })
}

fn tell(finding: &Finding) {
    if finding.is_doubt() {
        remark!("{} {finding}", "doubtful:".yellow().bold())
    } else {
        remark!("{} {finding}", "missing:".red().bold())
    }
}

fn show_step(requests: &[Request], step: &TaughtStep) {
    if let Some(request) = requests.get(step.step - 1) {
        print_line!("Step {}: {}", step.step, request.sentence);
    }
    for value in &step.values {
        print_line!("  {} {}", value.parameter, shown(value));
    }
}

/// A value for a person: directions and angles with degrees, paths by their length.
fn shown(value: &TaughtValue) -> String {
    let number = |value: &Value| {
        value
            .as_f64()
            .map_or_else(|| value.to_string(), |value| format!("{value:.3}"))
    };
    let text = match &value.value {
        Value::String(text) => return text.clone(),
        Value::Array(points) if points.iter().all(Value::is_array) => {
            return format!("{} points", points.len());
        }
        Value::Array(parts) => format!("({})", parts.iter().map(number).collect::<Vec<_>>().join(", ")),
        other => number(other),
    };
    let is_angle = value.unit == Some("rad");
    match (value.uncertainty, is_angle) {
        (Some(uncertainty), true) if value.value.is_number() => {
            let degrees = value.value.as_f64().unwrap_or_default().to_degrees();
            format!("{degrees:.1} ± {:.1} degrees", uncertainty.to_degrees())
        }
        (Some(uncertainty), true) => format!("{text} ± {:.1} degrees", uncertainty.to_degrees()),
        (Some(uncertainty), false) => format!("{text} ± {uncertainty:.3} m"),
        (None, _) => text,
    }
}
