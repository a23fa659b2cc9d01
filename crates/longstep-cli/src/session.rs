//! `longstep session`: lists, shows and replays saved sessions.

use std::path::{Path, PathBuf};

use anyhow::Result;
use longstep::session::{Event, Log, replay};
use longstep_files::session_directory;
use longstep_llm::{LOG, SessionFolder, load_domain};
use serde_json::Value;

use crate::arguments::SessionCommand;
use crate::output;
use crate::output::{Style, counted, print_line};

/// Limit for an instruction in a table, in characters.
const SHOWN: usize = 60;

/// Limit for a value in a comparison, in characters.
const COMPARED: usize = 100;

pub(crate) fn run(command: &SessionCommand) -> Result<u8> {
    match command {
        SessionCommand::List => list(),
        SessionCommand::Show { session, json } => {
            let log = SessionFolder::read(&folder(session)?)?;
            if *json {
                output::json(&log.entries)?;
            } else {
                show(&log);
            }
            Ok(0)
        }
        SessionCommand::Replay { session } => replayed(&folder(session)?),
    }
}

/// The folder of a session, given by its path or its name.
pub(crate) fn folder(named: &str) -> Result<PathBuf> {
    let path = Path::new(named);
    if path.exists() || named.contains(std::path::MAIN_SEPARATOR) {
        return Ok(path.to_owned());
    }
    Ok(session_directory()?.join(named))
}

fn list() -> Result<u8> {
    let all = session_directory()?;
    let mut names: Vec<String> = std::fs::read_dir(&all)
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.path().join(LOG).is_file())
        .filter_map(|entry| entry.file_name().into_string().ok())
        .collect();
    names.sort();
    if names.is_empty() {
        print_line!("No sessions in {}", all.display());
        return Ok(0);
    }
    let width = names.iter().map(|name| name.chars().count()).max().unwrap_or(0);
    for name in &names {
        match SessionFolder::read(&all.join(name)) {
            Ok(log) => {
                let begun = log.entries.first().map_or("", |entry| &entry.at);
                let day = begun.get(..16).unwrap_or(begun).replace('T', " ");
                let plans = standing(&log);
                print_line!("{:width$}  {day}  {}", name.bold(), counted(plans, "plan"));
            }
            Err(error) => print_line!("{:width$}  {}", name.bold(), error.red()),
        }
    }
    output::blank();
    print_line!("Sessions are saved in {}", all.display());
    Ok(0)
}

/// The number of accepted plans that were not undone.
fn standing(log: &Log) -> usize {
    log.events().fold(0, |plans, event| match event {
        Event::Accept { number, .. } => number + 1,
        Event::Undo { number } => *number,
        _ => plans,
    })
}

/// A row of the table: one instruction.
#[derive(Default)]
struct Row {
    instruction: String,
    calls: usize,
    prompt: u64,
    completion: u64,
    seconds: f64,
    edits: usize,
    words: usize,
    outcome: String,
}

fn show(log: &Log) {
    if let Some(Event::Begin { domain, settings, .. }) = log.events().next() {
        let strategy = serde_json::to_value(settings.strategy).unwrap_or_default();
        let model = log.events().find_map(|event| match event {
            Event::Model { name, .. } => Some(name.as_str()),
            _ => None,
        });
        let strategy = strategy.as_str().unwrap_or_default();
        print_line!(
            "domain {domain}, strategy {strategy}, model {}",
            model.unwrap_or("none")
        );
        output::blank();
    }
    let mut rows: Vec<Row> = Vec::new();
    for event in log.events() {
        if let Event::Instruction { text } = event {
            rows.push(Row {
                instruction: text.clone(),
                outcome: "in progress".to_owned(),
                ..Row::default()
            });
            continue;
        }
        if let Event::Undo { number } = event {
            let undone = format!("accepted as {number}");
            if let Some(row) = rows.iter_mut().rev().find(|row| row.outcome == undone) {
                row.outcome = "undone".to_owned();
            }
        }
        if let Some(row) = rows.last_mut() {
            row.hear(event);
        }
    }
    let header = format!(
        "{:>3}  {:SHOWN$}  {:>5}  {:>7}  {:>7}  {:>7}  {:>5}  {:>5}  outcome",
        "#", "instruction", "calls", "prompt", "answer", "model", "edits", "user"
    );
    print_line!("{}", header.bold());
    for (number, row) in rows.iter().enumerate() {
        let mut text: String = row.instruction.split_whitespace().collect::<Vec<_>>().join(" ");
        if text.chars().count() > SHOWN {
            text = text.chars().take(SHOWN - 1).chain(['…']).collect();
        }
        print_line!(
            "{:>3}  {text:SHOWN$}  {:>5}  {:>7}  {:>7}  {:>6.1}s  {:>5}  {:>5}  {}",
            number + 1,
            row.calls,
            row.prompt,
            row.completion,
            row.seconds,
            row.edits,
            row.words,
            row.outcome
        );
    }
    output::blank();
    print_line!("{} accepted", counted(standing(log), "plan"));
}

impl Row {
    fn hear(&mut self, event: &Event) {
        match event {
            Event::Reply {
                usage, milliseconds, ..
            } => {
                self.calls += 1;
                self.prompt = self.prompt.max(usage.prompt_tokens);
                self.completion += usage.completion_tokens;
                self.seconds += milliseconds / 1000.0;
            }
            Event::Verdict { answer } => {
                self.edits = answer["edits"].as_array().map_or(0, Vec::len);
            }
            Event::Feedback { .. } | Event::Answer { .. } => self.words += 1,
            Event::Question { .. } => self.outcome = "question".to_owned(),
            Event::Accept { number, .. } => self.outcome = format!("accepted as {number}"),
            Event::Stuck { why } | Event::Failed { error: why } => self.outcome = why.clone(),
            Event::Cancel => self.outcome = "cancelled".to_owned(),
            _ => {}
        }
    }
}

fn replayed(folder: &Path) -> Result<u8> {
    let log = SessionFolder::read(folder)?;
    let domain = match log.events().next() {
        Some(Event::Begin { domain, .. }) => load_domain(domain)?,
        // A log always begins with this event.
        _ => return Ok(crate::failure::UNREADABLE),
    };
    let outcome = replay(domain, &log)?;
    for difference in &outcome.differing {
        print_line!("{}", format!("line {}", difference.line).bold());
        for part in parts(difference.recorded.as_ref(), difference.today.as_ref()) {
            print_line!("  {}", part.name);
            print_line!("    {} {}", "recorded".red(), part.recorded);
            print_line!("    {} {}", "replayed".green(), part.today);
        }
    }
    if !outcome.differing.is_empty() {
        output::blank();
    }
    let summary = format!(
        "{}, {} accepted",
        counted(outcome.instructions, "instruction"),
        counted(outcome.accepted, "plan")
    );
    if outcome.differing.is_empty() {
        print_line!("{} {summary}", "Identical:".green().bold());
        Ok(0)
    } else {
        let many = counted(outcome.differing.len(), "event");
        print_line!("{} {many} ({summary})", "Different:".red().bold());
        Ok(10)
    }
}

/// A part of an event that differs in the replay.
struct DifferingPart {
    /// Its path of keys, such as `plan.environment_after`.
    name: String,
    recorded: String,
    today: String,
}

/// The differences between two events, part by part: an event may contain whole environments, mostly equal.
fn parts(recorded: Option<&Value>, today: Option<&Value>) -> Vec<DifferingPart> {
    let mut parts = Vec::new();
    let kind = |event: &Value| event["event"].clone();
    match (recorded, today) {
        (Some(recorded), Some(today)) if kind(recorded) == kind(today) => {
            let name = kind(recorded).as_str().unwrap_or_default().to_owned();
            compare(&name, recorded, today, &mut parts);
        }
        (recorded, today) => parts.push(DifferingPart {
            name: "event".to_owned(),
            recorded: recorded.map_or("nothing".to_owned(), |event| shortened(&kind(event))),
            today: today.map_or("nothing".to_owned(), |event| shortened(&kind(event))),
        }),
    }
    parts
}

fn compare(name: &str, recorded: &Value, today: &Value, parts: &mut Vec<DifferingPart>) {
    if recorded == today {
        return;
    }
    if let (Value::Object(was), Value::Object(is)) = (recorded, today) {
        let new = is.keys().filter(|key| !was.contains_key(*key));
        for key in was.keys().chain(new) {
            let (was, is) = (was.get(key), is.get(key));
            compare(
                &format!("{name}.{key}"),
                was.unwrap_or(&Value::Null),
                is.unwrap_or(&Value::Null),
                parts,
            );
        }
        return;
    }
    parts.push(DifferingPart {
        name: name.to_owned(),
        recorded: shortened(recorded),
        today: shortened(today),
    });
}

fn shortened(value: &Value) -> String {
    let text = match value {
        Value::Null => "nothing".to_owned(),
        value => value.to_string(),
    };
    match text.char_indices().nth(COMPARED) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}
