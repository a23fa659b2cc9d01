//! New domains: all files of a folder, from a PDDL file of any origin or from an author's answers.
//!
//! Both ways lead to a [`Blueprint`]: PDDL for the semantics, a PDDL problem for an example world, and sentences. The
//! rest is made from it and checked: the words, worked examples that search has planned and the verifier accepted, an
//! environment, and a small suite. Nothing is returned that does not load.

mod answer_pddl;
mod answer_reader;
mod answers;
mod author;
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

pub use answer_reader::{MissedRemoval, guess_removed, missed_removals};
#[cfg(feature = "schema")]
pub use answers::answers_schema;
pub use answers::{ActionAnswer, Answers, KindAnswer};
pub use author::{
    AnswerMistake, Misspelt, UnmadeState, action_mistake, guess_start, misspelt_kind, replace_state, same_state,
    sentence_mistake, start_mistake, unmade_states, unused_kinds,
};
pub use sample::{Sample, samples};

use crate::lint::{Finding, lint, lint_environment};
use longstep::domain::{self, Domain, Files};
use longstep_core::diagnostic::{Diagnostic, Diagnostics};
use longstep_core::domain::ForeignDomain;
use longstep_core::environment;
use sample::Sampler;
use wording::PredicateText;
use words::Words;

/// Instructions in the suite of a new domain.
const SUITE: usize = 5;

/// Reason given when the searches for examples have spent their budget.
const TOO_MUCH: &str = "the searches for examples took all the work that they may take";

/// The files of a new domain.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct NewDomain {
    /// Paths within the folder, with their texts.
    pub files: Vec<(String, String)>,
    /// The domain, loaded from these files.
    pub domain: Domain,
    /// Probable mistakes for the author to look at.
    pub findings: Vec<Finding>,
    /// Decisions for the author to know: names that have other words.
    pub notes: Vec<Diagnostic>,
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
/// use longstep_author::{SourceText, from_any_pddl};
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
    let problem_text = problem.map(|problem| problem.text);
    let own = longstep_core::domain::read_foreign(domain.file, domain.text, problem_text)?;
    let blueprint = Blueprint {
        name: domain::plain_name(name),
        about: format!("The PDDL domain {}.", own.domain.pddl_name),
        pddl: own.rewritten.clone().unwrap_or_else(|| domain.text.to_owned()),
        ..Blueprint::default()
    };
    if let Some(problem) = problem {
        let mut new = complete(&blueprint, &own, domain.file, problem, false)?;
        new.notes.extend(own.notes);
        return Ok(new);
    }
    let made_up = problem::write(&own.domain, &problem::Names::new());
    let source = SourceText {
        file: "the made-up problem",
        text: &made_up.text,
    };
    let mut new = complete(&blueprint, &own, domain.file, source, true)?;
    let note = made_up.note(domain.file);
    new.notes.extend(own.notes);
    new.notes
        .extend(note.map(|note| note.hint("give a problem file with --problem")));
    Ok(new)
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
        text: &problem.text,
    };
    let own = longstep_core::domain::read_foreign("the answers", &blueprint.pddl, None)?;
    let mut new = complete(&blueprint, &own, "the answers", source, false)?;
    new.notes.extend(problem.note("the answers"));
    for note in new.notes.iter_mut().filter(|note| note.position.is_some()) {
        // The answers have no PDDL; the new folder has.
        note.file = "domain.pddl".to_owned();
    }
    Ok(new)
}

/// A new domain without worked examples, which a model needs.
const NO_GOAL: &str = "no goal of the domain can be reached in the example world, so there is nothing to show a model";

/// Makes all files from a blueprint and an example problem.
fn complete(
    blueprint: &Blueprint,
    own: &ForeignDomain,
    pddl_file: &str,
    problem: SourceText<'_>,
    invented: bool,
) -> Result<NewDomain, Diagnostics> {
    let bare = &own.domain;
    if bare.actions.is_empty() {
        let finding = Diagnostic::whole(pddl_file, "the domain has no actions");
        return Err(Diagnostics(vec![finding.hint("add an `(:action ...)`")]));
    }
    let words = Words::of(bare, blueprint);
    // The author's file that the environment is made from.
    let source = if invented { pddl_file } else { problem.file };
    // Places in a text that was rewritten are no places in the author's file.
    let of_author = |mut findings: Diagnostics| {
        if own.rewritten.is_some() {
            let in_domain = findings.0.iter_mut().filter(|finding| finding.file == "domain.pddl");
            in_domain.for_each(|finding| finding.position = None);
        }
        self::of_author(findings, pddl_file)
    };
    let problem = longstep_core::pddl::read_start(bare, problem.file, problem.text)
        .map_err(|findings| if invented { of_author(findings) } else { findings })?;
    let lists = example_world::lists(bare, blueprint, &problem.world);
    let mut files = vec![
        ("domain.pddl".to_owned(), blueprint.pddl.clone()),
        ("domain.toml".to_owned(), words::write(blueprint, bare, &words, lists)),
        ("prompt/goal.md".to_owned(), example::TASK.to_owned()),
        ("prompt/examples.toml".to_owned(), String::new()),
    ];
    let first = load_files(&files).map_err(of_author)?;
    let environment = example_world::environment(&first, &problem.world, lists);
    let json = example_world::json(&environment, "./schemas/environment.schema.json");
    let world = environment::parse(&first, "environment.json", &json);
    let world = world.map_err(|findings| self::of_author(findings, source))?;
    let mut sampler = Sampler::default();
    let samples = sampler.samples(&world, SUITE, 0);
    let without_examples = samples.is_empty().then(|| {
        let (message, hint) = match (sampler.is_exhausted(), invented) {
            (true, _) => (
                format!("no example was found: {TOO_MUCH}"),
                "give a small problem file with --problem",
            ),
            (false, true) => (
                NO_GOAL.to_owned(),
                "give a problem file with --problem: a world in which the actions are possible",
            ),
            (false, false) => (
                NO_GOAL.to_owned(),
                "check the initial facts: do the preconditions of the actions hold?",
            ),
        };
        Diagnostic::whole(source, message).hint(hint)
    });
    files.push(("environment.json".to_owned(), json.clone()));
    if without_examples.is_none() {
        files.extend(example::suite(&blueprint.name, &world, &samples));
        let scene = example_world::json(&environment, "../../schemas/environment.schema.json");
        files.push(("suite/scenes/example.json".to_owned(), scene));
        files.push(("prompt/plans.toml".to_owned(), example::plans(&world, &mut sampler)));
        files[3].1 = example::examples(&world, &mut sampler);
    }
    let domain = load_files(&files).map_err(of_author)?;
    let shown = Files::from_texts("", files.iter().cloned());
    let mut findings = lint(&domain, &shown);
    findings.extend(lint_environment(&world, &shown, "environment.json", &json));
    let mut notes: Vec<Diagnostic> = words
        .renamed
        .iter()
        .map(|renamed| renamed.note(pddl_file, &own.positions))
        .collect();
    let has_examples = without_examples.is_none();
    notes.extend(problem.notes);
    notes.extend(without_examples);
    if has_examples && sampler.is_exhausted() {
        notes.push(Diagnostic::whole(
            pddl_file,
            format!("there are fewer examples than usual: {TOO_MUCH}"),
        ));
    }
    Ok(NewDomain {
        files,
        domain,
        findings,
        notes,
        invented,
    })
}

fn load_files(files: &[(String, String)]) -> Result<Domain, Diagnostics> {
    domain::load(&Files::from_texts("", files.iter().cloned()))
}

/// Returns the findings about the files of a new domain as findings about the author's file: that is `domain.pddl` by
/// another name, and the others are made from it.
fn of_author(findings: Diagnostics, pddl_file: &str) -> Diagnostics {
    let of_author = |mut finding: Diagnostic| {
        if finding.file == "domain.pddl" {
            finding.file = pddl_file.to_owned();
            return finding;
        }
        let hint = finding.hint.take();
        let message = format!("what is made from it does not load: {finding}");
        let whole = Diagnostic::whole(pddl_file, message);
        match hint {
            Some(hint) => whole.hint(hint),
            None => whole,
        }
    };
    Diagnostics(findings.0.into_iter().map(of_author).collect())
}
