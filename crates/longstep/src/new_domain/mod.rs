//! New domains: all files of a folder, from a PDDL file of any origin or from an author's answers.
//!
//! Both ways lead to a [`Blueprint`]: PDDL for the semantics, a PDDL problem for an example world, and sentences. The
//! rest is made from it and checked: the words, worked examples that search has planned and the verifier accepted, an
//! environment, and a small suite. Nothing is returned that does not load.

mod answer_pddl;
mod answer_reader;
mod answers;
mod example;
mod example_world;
mod problem;
mod sample;
mod sentence;
#[cfg(test)]
mod tests;
mod wording;
mod words;

use std::collections::BTreeMap;

pub use answer_reader::guess_removed;
pub use answers::{ActionAnswer, Answers, KindAnswer};
pub use sample::{Sample, samples};

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::environment;
use crate::lint::{Finding, lint, lint_environment};
use crate::model::{Domain, Files};
use crate::{load, model};
use wording::PredicateText;
use words::Words;

/// Instructions in the suite of a new domain.
const SUITE: usize = 5;

/// The files of a new domain.
#[derive(Debug, Clone)]
pub struct NewDomain {
    /// Paths within the folder, with their texts.
    pub files: Vec<(String, String)>,
    /// The domain, loaded from these files.
    pub domain: Domain,
    /// Probable mistakes for the author to look at.
    pub findings: Vec<Finding>,
    /// True if the example environment was made up, since there was no problem file.
    pub invented: bool,
}

/// A file's text, with its name for diagnostics.
#[derive(Debug, Clone, Copy)]
pub struct SourceText<'t> {
    /// The name.
    pub file: &'t str,
    /// The text.
    pub text: &'t str,
}

/// The meaning of a new domain, before its words.
#[derive(Debug, Default)]
struct Blueprint {
    name: String,
    about: String,
    pddl: String,
    /// Sentences of predicates and actions, by their PDDL names; the others follow from the names.
    predicates: BTreeMap<String, PredicateText>,
    actions: BTreeMap<String, String>,
    lexicon: Vec<(String, Vec<String>)>,
    /// The types that stay where they are, if the author says so.
    places: Option<Vec<String>>,
}

/// Makes a domain from a PDDL file of any origin. With a problem file, its objects and initial state become the
/// example environment; otherwise one is made up from the preconditions.
///
/// # Errors
///
/// Everything in the files that is not supported, with line and column; a domain in whose example world no goal can be
/// reached.
///
/// ```
/// use longstep::domain::{SourceText, from_any_pddl};
/// let text = "(define (domain lamps) (:predicates (lit ?lamp))
///     (:action light :parameters (?lamp) :precondition (not (lit ?lamp)) :effect (lit ?lamp)))";
/// let new = from_any_pddl("lamps", SourceText { file: "lamps.pddl", text }, None).unwrap();
/// assert_eq!(new.domain.goal_words[0].shown(), "lit(LAMP)");
/// ```
pub fn from_any_pddl(
    name: &str,
    domain: SourceText<'_>,
    problem: Option<SourceText<'_>>,
) -> Result<NewDomain, Diagnostics> {
    let bare = longstep_core::domain::from_pddl(domain.file, domain.text)?;
    let blueprint = Blueprint {
        name: model::plain_name(name),
        about: format!("The PDDL domain {}.", bare.pddl_name),
        pddl: domain.text.to_owned(),
        ..Blueprint::default()
    };
    let written;
    let (source, invented) = match problem {
        Some(problem) => (problem, false),
        None => {
            written = problem::write(&bare);
            let source = SourceText {
                file: "the made-up problem",
                text: &written,
            };
            (source, true)
        }
    };
    complete(&blueprint, domain.file, source, invented)
}

/// Makes a domain from an author's answers.
///
/// # Errors
///
/// Every answer that cannot be understood, and everything that keeps the result from loading.
pub fn from_answers(answers: &Answers) -> Result<NewDomain, Diagnostics> {
    let (blueprint, problem) = answers.blueprint()?;
    let source = SourceText {
        file: "the answers",
        text: &problem,
    };
    complete(&blueprint, "the answers", source, false)
}

/// Makes all files from a blueprint and an example problem.
fn complete(
    blueprint: &Blueprint,
    pddl_file: &str,
    problem: SourceText<'_>,
    invented: bool,
) -> Result<NewDomain, Diagnostics> {
    let bare = longstep_core::domain::from_pddl(pddl_file, &blueprint.pddl)?;
    if bare.actions.is_empty() {
        let finding = Diagnostic::whole(pddl_file, "the domain has no actions");
        return Err(Diagnostics(vec![finding.hint("add an `(:action ...)`")]));
    }
    let words = Words::of(&bare, blueprint);
    let problem = longstep_core::pddl::read_problem(&bare, problem.file, problem.text)?;
    let lists = example_world::lists(&bare, blueprint, &problem.world);
    let mut files = vec![
        ("domain.pddl".to_owned(), blueprint.pddl.clone()),
        ("domain.toml".to_owned(), words::write(blueprint, &bare, &words, lists)),
        ("prompt/goal.md".to_owned(), example::TASK.to_owned()),
        ("prompt/examples.toml".to_owned(), String::new()),
    ];
    let first = load_files(&files, pddl_file)?;
    let environment = example_world::environment(&first, &problem.world, lists);
    let json = example_world::json(&environment);
    let world = environment::parse(&first, "environment.json", &json)?;
    let samples = samples(&world, SUITE, 0);
    if samples.is_empty() {
        let finding = Diagnostic::whole(
            problem_name(invented),
            "no goal of the domain can be reached in the example world, so there is nothing to show a model",
        );
        let hint = match invented {
            true => "give a problem file with --problem: a world in which the actions are possible",
            false => "check the initial facts: do the preconditions of the actions hold?",
        };
        return Err(Diagnostics(vec![finding.hint(hint)]));
    }
    files.push(("environment.json".to_owned(), json.clone()));
    files.extend(example::suite(&blueprint.name, &world, &samples));
    files.push(("suite/scenes/example.json".to_owned(), json.clone()));
    files[3].1 = example::examples(&world);
    files.push(("prompt/plans.toml".to_owned(), example::plans(&world)));
    let domain = load_files(&files, pddl_file)?;
    let shown = Files::from_texts("", files.iter().cloned());
    let mut findings = lint(&domain, &shown);
    findings.extend(lint_environment(&world, &shown, "environment.json", &json));
    Ok(NewDomain {
        files,
        domain,
        findings,
        invented,
    })
}

fn problem_name(invented: bool) -> &'static str {
    if invented { "domain.pddl" } else { "environment.json" }
}

/// Loads the files. Findings about `domain.pddl` name the author's file instead, which has the same text.
fn load_files(files: &[(String, String)], pddl_file: &str) -> Result<Domain, Diagnostics> {
    load::load(&Files::from_texts("", files.iter().cloned())).map_err(|mut findings| {
        for finding in &mut findings.0 {
            if finding.file == "domain.pddl" {
                finding.file = pddl_file.to_owned();
            }
        }
        findings
    })
}
