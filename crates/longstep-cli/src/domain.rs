//! `longstep domain`: shows, checks and creates domains, and writes nodes for behavior trees.

mod interview;
mod kept_answers;
mod new_domain;
mod questions;
mod trial;

use std::path::Path;

use anyhow::Result;
use longstep::domain::{self, Domain};
use longstep_author::Finding;
use longstep_core::environment::{Origin, World, fact_text};
use longstep_core::plan::behavior_tree::nodes::{self, Language};
use longstep_core::visible;
use longstep_files::domain_files;
use longstep_llm::load_domain;

use crate::arguments::{DomainCommand, NodesLanguage};
use crate::failure::NOT_VALID;
use crate::inputs;
use crate::output::{self, Style, print_line};
use crate::show;

pub(crate) fn run(command: &DomainCommand) -> Result<u8> {
    match command {
        DomainCommand::List => {
            for name in domain::shipped_names() {
                let domain = load_domain(name)?;
                print_line!("{:16}  {}", name.bold(), domain.about);
            }
        }
        DomainCommand::Show { domain, env } => {
            let domain = load_domain(domain)?;
            match env {
                Some(env) => describe_world(&inputs::world(&domain, env, None)?),
                None => describe(&domain),
            }
        }
        DomainCommand::Check {
            domain,
            env,
            strict,
            json,
        } => return check(domain, env.as_deref(), *strict, *json),
        DomainCommand::Nodes { domain, language } => {
            let language = match language {
                NodesLanguage::Cpp => Language::Cpp,
                NodesLanguage::Python => Language::Python,
            };
            let domain = load_domain(domain)?;
            output::document(&nodes::write(&domain, language));
        }
        DomainCommand::New(arguments) => new_domain::run(arguments)?,
        DomainCommand::Try(arguments) => return trial::run(arguments),
    }
    Ok(0)
}

/// Warnings are the result of the command and go to stdout; a fault that keeps a domain from loading is an error.
fn check(name: &str, env: Option<&Path>, strict: bool, json: bool) -> Result<u8> {
    let files = domain_files(name)?;
    let domain = domain::load(&files)?;
    let mut findings = longstep_author::lint(&domain, &files);
    if let Some(env) = env {
        let (world, text) = inputs::world_and_text(&domain, env)?;
        findings.extend(longstep_author::lint_environment(
            &world,
            &files,
            &env.display().to_string(),
            &text,
        ));
    }
    if json {
        let entries: Vec<_> = findings.iter().map(entry).collect();
        output::json(&entries)?;
    } else {
        for finding in &findings {
            show::finding("warning:".yellow().bold(), &finding.named());
        }
        let verdict = match findings.len() {
            0 => "no warnings".to_owned(),
            1 => "1 warning".to_owned(),
            count => format!("{count} warnings"),
        };
        print_line!(
            "{name}: {verdict} (actions: {}, goals: {}, examples: {})",
            domain.actions.len(),
            domain.goal_words.len(),
            domain.prompts.examples.len()
        );
    }
    Ok(if strict && !findings.is_empty() { NOT_VALID } else { 0 })
}

fn entry(finding: &Finding) -> serde_json::Value {
    let diagnostic = &finding.diagnostic;
    serde_json::json!({
        "lint": finding.lint.name(),
        "of": finding.of,
        "file": diagnostic.file,
        "line": diagnostic.position.map(|position| position.line),
        "column": diagnostic.position.map(|position| position.column),
        "message": diagnostic.message,
        "hint": diagnostic.hint,
    })
}

fn describe(domain: &Domain) {
    print_line!("{}: {}", domain.name.bold(), domain.about);
    let mut entries: Vec<(String, &str)> = domain
        .actions
        .iter()
        .map(|action| {
            let shown: Vec<&str> = action
                .explicit
                .iter()
                .map(|p| action.parameters[*p].name.as_str())
                .collect();
            (format!("{}({})", action.call, shown.join(", ")), action.means.as_str())
        })
        .collect();
    table("Actions", &entries);
    entries = domain
        .states
        .iter()
        .map(|state| {
            let holes = state.parameters.join(", ");
            (format!("{}({holes})", state.word), state.means.as_str())
        })
        .collect();
    table("States of an environment", &entries);
    entries = domain
        .goal_words
        .iter()
        .map(|word| (word.shown(), word.means.as_str()))
        .collect();
    table("Goals", &entries);
}

/// Prints every entity with its type, its names, and its facts with their origins.
fn describe_world(world: &World) {
    let domain = world.domain();
    for (id, entity) in world.entities() {
        if id.index() > 0 {
            output::blank();
        }
        let kind = domain.types.name(entity.kind);
        let others = entity.names.iter().filter(|name| **name != entity.name);
        let others: Vec<&str> = others.map(String::as_str).collect();
        print_line!("{}  {} ({kind})", entity.identifier.bold(), entity.name);
        if !others.is_empty() {
            print_line!("  also {}", others.join(", "));
        }
        for fact in world.facts_about(id) {
            let text = fact_text(world, fact, true);
            let origin = Origin::of(world, fact).to_string();
            print_line!("  {text}  {}", format!("({origin})").dimmed());
        }
    }
}

fn table(title: &str, entries: &[(String, &str)]) {
    output::blank();
    show::heading(title);
    let widths = entries.iter().map(|(left, _)| visible::line(left).chars().count());
    let width = widths.max().unwrap_or(0);
    for (left, right) in entries {
        let left = visible::line(left);
        print_line!("  {left:width$}  {}", right.dimmed());
    }
}
