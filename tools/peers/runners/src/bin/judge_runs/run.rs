//! A run from its command to its end.

use std::collections::HashMap;
use std::time::Duration;

use longstep::domain::Domain;
use longstep::goal;
use longstep::report::Assessment;
use longstep_core::environment::{self, Environment, World};
use longstep_core::execution::{Aim, BeginError, Execution, Resumed, Settings, Stop};
use longstep_core::{json, plan};
use longstep_llm::load_domain;
use longstep_robot::{Description, RunHeader, RunLog, StopRequest, drive, preflight, reports};
use serde_json::{Value, json};

use crate::Anyhow;
use crate::driven::{PipeRobot, PipeWatcher};
use crate::pipe::Pipe;

/// The domains that were loaded, by name.
pub(crate) type Domains = HashMap<String, Domain>;

/// Carries out a command; returns the last line of the run.
pub(crate) fn run(pipe: &Pipe, domains: &mut Domains, command: &Value) -> Anyhow<Value> {
    let (key, resumes) = match command.get("resume") {
        Some(_) => ("resume", true),
        None => ("begin", false),
    };
    let wanted = &command[key];
    let request = StopRequest::default();
    let mut robot = PipeRobot::new(*pipe, description(&wanted["robot"]), request.clone());
    request.attach(longstep_robot::Robot::stop_switch(&robot));
    let domain = load(domains, wanted["domain"].as_str().unwrap_or_default())?;
    let begun = if resumes {
        resumed(domain, wanted, &robot)
    } else {
        begun(domain, wanted, &robot)?
    };
    let mut execution = match begun {
        Ok(execution) => execution,
        Err((code, why)) => return Ok(json!({"refused": {"code": code, "why": why}})),
    };
    let stop = if wanted["direct"] == true {
        crate::direct::carry_out(*pipe, &mut execution, &request)?
    } else {
        let mut watcher = PipeWatcher::new(*pipe, request.clone());
        drive(&mut execution, &mut robot, &mut watcher, &request.clone().into()).into_stop()
    };
    let environment = serde_json::to_value(execution.environment())?;
    Ok(json!({"ended": {
        "stop": stop.as_ref().map(kind),
        "why": stop.as_ref().map(|stop| stop.sentence(execution.world())),
        "resumable": stop.as_ref().is_some_and(Stop::is_resumable),
        "environment": environment,
    }}))
}

fn load<'a>(domains: &'a mut Domains, name: &str) -> Anyhow<&'a Domain> {
    if !domains.contains_key(name) {
        // Random domains are used for a few runs each.
        if domains.len() > 8 {
            domains.clear();
        }
        domains.insert(name.to_owned(), load_domain(name)?);
    }
    domains.get(name).ok_or_else(|| "the domain was not loaded".into())
}

fn description(wanted: &Value) -> Description {
    let names = |key: &str| wanted[key].as_array().into_iter().flatten().filter_map(Value::as_str);
    let mut description = Description::new(wanted["name"].as_str().unwrap_or("pipe"));
    description.observes = true;
    description.simulated = true;
    description.counts_events = wanted["counts_events"] == true;
    description.parallel = wanted["parallel"]
        .as_u64()
        .and_then(|own| usize::try_from(own).ok())
        .unwrap_or(1);
    description.reports = names("reports").map(str::to_owned).collect();
    description.timeouts.stop = Duration::from_secs(1);
    description
}

/// Verifies the plan with its purpose and begins, as `longstep run` does; a refusal has its exit code.
fn begun(domain: &Domain, wanted: &Value, robot: &PipeRobot) -> Anyhow<Result<Execution, (u8, String)>> {
    let written = wanted["environment"].to_string();
    let environment = Environment::from_json(&written)?;
    let mut world = environment::read(domain, &environment, "environment", &written, &json::Path::default())?;
    let draft = plan::read(wanted["plan"].as_str().unwrap_or_default())?;
    let purpose = draft.file.purpose.clone().unwrap_or_default();
    let given = wanted["rules"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_str);
    let mut rules = Vec::new();
    for rule in given.chain(purpose.rules.iter().map(String::as_str)) {
        world.add_values(rule);
        rules.extend(goal::rules(&world, rule)?);
    }
    let mut world: World = world.with_prohibitions(rules);
    let mut goal = None;
    if let Some(text) = wanted["goal"].as_str().or(purpose.goal.as_deref()) {
        world.add_values(text);
        goal = Some(goal::parse(&world, text)?);
    }
    let aim = Aim::from(goal.as_ref().map(|goal| goal.exact(&world).join(" & ")));
    let assessment = Assessment::new(&world, draft, None);
    let assessment = match goal {
        Some(goal) => assessment.for_goal(goal),
        None => assessment,
    };
    let Some(plan) = assessment.verified() else {
        let answer = assessment.verdict();
        let why = answer
            .violations
            .first()
            .map(|own| own.message.clone())
            .unwrap_or_default();
        return Ok(Err((10, why)));
    };
    let mut settings: Settings = settings(&wanted["settings"])?;
    settings.reports = reports(robot, &world)?;
    preflight(robot, &plan, &settings.skills)?;
    Ok(Execution::new(&plan, &aim, settings).map_err(|error| match error {
        BeginError::Purpose(_) => (10, error.to_string()),
        _ => (30, error.to_string()),
    }))
}

fn settings(wanted: &Value) -> Anyhow<Settings> {
    let mut settings = Settings::default();
    if let Some(approval) = wanted.get("approval") {
        settings.approval = serde_json::from_value(approval.clone())?;
    }
    if let Some(trust) = wanted.get("trust") {
        settings.trust = serde_json::from_value(trust.clone())?;
    }
    if let Some(watch) = wanted.get("watch") {
        settings.watch = serde_json::from_value(watch.clone())?;
    }
    if let Some(changes) = wanted["changes"].as_u64() {
        settings.changes = u32::try_from(changes)?;
    }
    Ok(settings)
}

/// Takes up a run from the lines of its log, which go through a file as those of `longstep run` do.
fn resumed(domain: &Domain, wanted: &Value, robot: &PipeRobot) -> Result<Execution, (u8, String)> {
    let events = lines(wanted).map_err(|error| (30, error.to_string()))?;
    let mut resumed = Resumed::default();
    resumed.approval = serde_json::from_value(wanted["approval"].clone()).map_err(|error| (30, error.to_string()))?;
    resumed.trust = serde_json::from_value(wanted["trust"].clone()).map_err(|error| (30, error.to_string()))?;
    let execution = Execution::resume(domain, &events, resumed).map_err(|error| (30, error.to_string()))?;
    let reported = reports(robot, execution.world()).map_err(|error| (30, error.to_string()))?;
    if reported == execution.settings().reports {
        Ok(execution)
    } else {
        Err((30, "this robot reports other facts".to_owned()))
    }
}

fn lines(wanted: &Value) -> Anyhow<Vec<longstep_core::execution::Event>> {
    let folder = tempfile::tempdir_in(wanted["folder"].as_str().unwrap_or("."))?;
    let path = folder.path().join("run.jsonl");
    let header = serde_json::to_string(&RunHeader::new("pipe", "made"))?;
    std::fs::write(
        &path,
        format!("{header}\n{}", wanted["log"].as_str().unwrap_or_default()),
    )?;
    let (_, _, events) = RunLog::resume(&path)?;
    Ok(events)
}

/// The name of a stop.
pub(crate) fn kind(stop: &Stop) -> &'static str {
    match stop {
        Stop::Requested(_) => "requested",
        Stop::Refused => "refused",
        Stop::NoPlan { .. } => "no-plan",
        Stop::GaveUp { .. } => "gave-up",
        Stop::TooManyChanges(_) => "too-many-changes",
        Stop::Repeated => "repeated",
        Stop::Broken { .. } => "broken",
        Stop::Unseen { .. } => "unseen",
        Stop::Robot(_) => "robot",
        _ => "other",
    }
}
