//! `longstep see`: an environment from a scene of boxes, from pictures, or from words.

mod source;
mod update;

use std::path::Path;

use anyhow::Result;
use longstep::domain::Domain;
use longstep::perception::{CorrectionDialogue, LookSource, SightDialogue, SightInput, View};
use longstep_core::diagnostic::Diagnostics;
use longstep_core::environment::{self, Environment};
use longstep_core::geometry::{self, Look, LookError, Scene};
use longstep_core::json;
use longstep_files::{plain_reason, write_whole};
use longstep_llm::{ChatModel, converse, load_domain};
use serde::Serialize;

use crate::arguments::{SeeArguments, domain_or_default};
use crate::ask::{self, Waiting};
use crate::failure::{Failure, LIMIT, NOT_VALID};
use crate::output::{self, print_line};
use crate::question::ask as ask_person;
use crate::show;
use source::Source;

/// Exit code if a person has to confirm first.
const UNCONFIRMED: u8 = 13;
/// Maximum number of corrections of one view.
const CORRECTIONS: usize = 50;

pub(crate) fn run(arguments: &SeeArguments) -> Result<u8> {
    let source = Source::read(arguments)?;
    if let Some(named) = &arguments.update {
        return update::run(arguments, &source, named);
    }
    let domain = load_domain(domain_or_default(arguments.domain.as_ref()))?;
    let seen = seen(arguments, &domain, &source)?;
    let saved = if seen.agreed {
        save(arguments.output.as_deref(), &seen.report.environment)?
    } else {
        None
    };
    let report = LookReport {
        saved: saved.clone(),
        ..seen.report
    };
    if arguments.json {
        output::json(&report)?;
    } else if arguments.output.is_none() {
        show::heading("Environment");
        output::document(&pretty(&report.environment)?);
    } else if let Some(path) = saved {
        print_line!("Saved {path}");
    } else if report.contradictions.is_empty() {
        show::hint("nothing is saved; confirm with `--yes`");
    }
    Ok(match (report.contradictions.is_empty(), seen.agreed) {
        (false, _) => NOT_VALID,
        (true, true) => 0,
        (true, false) => UNCONFIRMED,
    })
}

/// An environment, and the person's agreement to it.
struct Seen {
    report: LookReport,
    source: LookSource,
    agreed: bool,
}

/// An environment and everything that a person should know about it.
#[derive(Debug, Default, Serialize)]
struct LookReport {
    environment: Environment,
    statements: Vec<StatementReport>,
    /// Contradictions to the rules of the domain.
    contradictions: Vec<String>,
    /// Boxes that fit no world.
    findings: Vec<String>,
    /// Changes that were made to read a model's reply.
    read_as: Vec<String>,
    assumed: Vec<String>,
    unsaid: Vec<String>,
    /// The rest that no state of the domain says, in the model's words.
    left_out: Vec<String>,
    unsure: Vec<String>,
    /// The file to which the environment was written.
    saved: Option<String>,
}

#[derive(Debug, Serialize)]
struct StatementReport {
    entity: String,
    state: String,
    says: String,
}

/// Finds the environment of a source, and shows it.
fn seen(arguments: &SeeArguments, domain: &Domain, source: &Source) -> Result<Seen> {
    match source {
        Source::Scene { file, text } => seen_in_boxes(arguments, domain, file, text),
        Source::Described { .. } => seen_by_model(arguments, domain, source),
    }
}

fn seen_in_boxes(arguments: &SeeArguments, domain: &Domain, file: &str, text: &str) -> Result<Seen> {
    if !arguments.correct.is_empty() {
        let failure = Failure::unreadable("`--correct` is for what a model wrote down");
        return Err(failure.hint("correct the scene file").into());
    }
    let scene = Scene::parse(file, text)?;
    let look = geometry::look(domain, &scene).map_err(|error| match error {
        LookError::NoGeometry(_) => Failure::unreadable(error.to_string())
            .hint("add `geometry = [\"on\"]` to the state in domain.toml that says it; see docs/reference/domains.md"),
        _ => Failure::new(error.to_string(), LIMIT).hint("split the scene"),
    })?;
    let report = LookReport::of_look(domain, look);
    if !arguments.json {
        report.show();
    }
    let is_clean = report.contradictions.is_empty() && report.findings.is_empty();
    let agreed = report.contradictions.is_empty() && (is_clean || arguments.yes || confirmed(arguments)?);
    Ok(Seen {
        report,
        source: LookSource::Poses,
        agreed,
    })
}

fn confirmed(arguments: &SeeArguments) -> Result<bool> {
    if arguments.json || arguments.output.is_none() {
        return Ok(false);
    }
    let answer = ask_person("Save it all the same? yes or no", "no")?.unwrap_or_default();
    Ok(is_yes(&answer))
}

fn is_yes(answer: &str) -> bool {
    matches!(answer.trim().to_lowercase().as_str(), "y" | "yes" | "ok")
}

fn is_no(answer: &str) -> bool {
    matches!(answer.trim().to_lowercase().as_str(), "n" | "no" | "quit")
}

fn seen_by_model(arguments: &SeeArguments, domain: &Domain, source: &Source) -> Result<Seen> {
    let Source::Described { words, pictures } = source else {
        return Err(Failure::unreadable("there is nothing to describe").into());
    };
    let mut model = if pictures.is_empty() {
        ask::model(arguments.model.name(), &arguments.model)?
    } else {
        ask::seeing_model(&arguments.model, arguments.vision.as_deref())?
    };
    let input = SightInput {
        domain,
        words,
        pictures,
        kind: model.constraint_kind(),
    };
    let name = model.name().to_owned();
    let sighting = converse(
        model.as_mut(),
        &mut SightDialogue::new(&input),
        &mut Waiting::new(&name),
    )?;
    let mut view = View::of(domain, &sighting);
    for words in &arguments.correct {
        view = corrected(domain, model.as_mut(), &view, words)?;
    }
    let mut report = LookReport::of_view(domain, &view);
    if !arguments.json {
        report.show();
    }
    let mut agreed = arguments.yes;
    for _ in 0..CORRECTIONS {
        if arguments.yes || arguments.json {
            break;
        }
        let question = if report.contradictions.is_empty() {
            "Is this right? yes, no, or say what is different"
        } else {
            "Say what is different, or no"
        };
        let answer = ask_person(question, "")?;
        let Some(answer) = answer.filter(|answer| !answer.is_empty() && !is_no(answer)) else {
            break;
        };
        if is_yes(&answer) {
            agreed = true;
            break;
        }
        view = corrected(domain, model.as_mut(), &view, &answer)?;
        report = LookReport::of_view(domain, &view);
        report.show();
    }
    Ok(Seen {
        agreed: agreed && report.contradictions.is_empty(),
        source: LookSource::Stated,
        report,
    })
}

/// Applies a correction in words.
fn corrected(domain: &Domain, model: &mut dyn ChatModel, view: &View, words: &str) -> Result<View> {
    let mut dialogue = CorrectionDialogue::new(domain, &view.sighting, words, model.constraint_kind());
    let name = model.name().to_owned();
    let change = converse(model, &mut dialogue, &mut Waiting::new(&name))?;
    Ok(view.corrected(domain, &change))
}

impl LookReport {
    fn of_look(domain: &Domain, look: Look) -> Self {
        let read = environment::read(domain, &look.environment, "the scene", "", &json::Path::default());
        let wordless = look.wordless.iter().map(|relation| {
            format!(
                "the domain has no state for `{}`, which some boxes are",
                relation.name()
            )
        });
        Self {
            contradictions: contradictions(read.err()),
            findings: look.findings.into_iter().map(|finding| finding.text).collect(),
            assumed: look.assumed.into_iter().map(|assumed| assumed.text).collect(),
            unsaid: wordless.collect(),
            statements: look
                .reasons
                .into_iter()
                .map(|reason| StatementReport {
                    entity: reason.subject,
                    state: reason.statement,
                    says: reason.text,
                })
                .collect(),
            environment: look.environment,
            ..Self::default()
        }
    }

    fn of_view(domain: &Domain, view: &View) -> Self {
        let statements = view.sighting.statements.iter().zip(view.sentences(domain));
        Self {
            environment: view.environment.clone(),
            statements: statements
                .map(|(statement, says)| StatementReport {
                    entity: format!("<{}>", statement.subject),
                    state: statement.state.to_string(),
                    says,
                })
                .collect(),
            contradictions: contradictions(view.world.as_ref().err().cloned()),
            findings: Vec::new(),
            read_as: view.leniencies.iter().map(ToString::to_string).collect(),
            assumed: view.assumed.clone(),
            unsaid: view.unsaid.clone(),
            left_out: view.sighting.left_out.clone(),
            unsure: view.sighting.unsure.clone(),
            saved: None,
        }
    }

    fn show(&self) {
        let names = |title: &str, names: &[String]| print_line!("{title}: {}", show::nothing(&names.join(", ")));
        names("Assets", &self.environment.assets);
        names("Objects", &self.environment.objects);
        output::blank();
        let says: Vec<String> = self.statements.iter().map(|own| own.says.clone()).collect();
        for (title, texts) in [
            ("States", &says),
            ("Findings", &self.findings),
            ("Contradictions", &self.contradictions),
            ("Read leniently", &self.read_as),
            ("Assumed", &self.assumed),
            ("Not said", &self.unsaid),
            ("Left out: the domain has no state for it", &self.left_out),
            ("Not seen well", &self.unsure),
        ] {
            show::list(title, texts);
        }
        output::blank();
    }
}

fn contradictions(found: Option<Diagnostics>) -> Vec<String> {
    let all = found.into_iter().flat_map(|found| found.0);
    all.map(|finding| finding.message).collect()
}

fn pretty(environment: &Environment) -> Result<String> {
    Ok(serde_json::to_string_pretty(environment)? + "\n")
}

/// Writes an environment to a file; returns its path.
fn save(path: Option<&Path>, environment: &Environment) -> Result<Option<String>> {
    let Some(path) = path else { return Ok(None) };
    write_whole(path, pretty(environment)?.as_bytes()).map_err(|error| {
        Failure::unreadable(format!("cannot write {}: {}", path.display(), plain_reason(&error)))
            .hint("check that the folder exists and is writable")
    })?;
    Ok(Some(path.display().to_string()))
}
