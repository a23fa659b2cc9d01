//! Prints what a model is trained on: one JSON object for each instruction of the given suites, or for each paragraph of texts.
//!
//!     cargo run -p longstep-eval --no-default-features --example training_data -- lab/understanding/training/*
//!     cargo run -p longstep-eval --no-default-features --example training_data -- lab/adapter/descriptions/*.txt
//!     cargo run -p longstep-eval --no-default-features --example training_data -- lab/adapter/changes/*.txt
//!     cargo run -p longstep-eval --no-default-features --example training_data -- lab/adapter/compositions/*.txt
//!
//! An object has the suite, the fixed messages of the request (`fixed`, pairs of role and text), the last message up to the
//! instruction (`lead`), the instruction, and the expected answer, which is null where a question is expected. Of a suite, cases
//! with one instruction count. Their tags say what a goal of a suite does not: `left out KIND: WORDS`; `meaning: GOAL` for a case that
//! expects a question because nothing is to be done (a prohibition alone); `first: ANSWER` and `remark: WORDS` for what was answered before, and
//! said then. A text of descriptions begins with its domain (`domain: household`); its paragraphs are
//! answers, which have the sentences of the description in them. A text of changes begins with its suite
//! (`suite: lab/understanding/training/bakery`); a paragraph has the id of a case, whose plan is searched for, and lines of what a
//! person says about the plan, and the answer (`Leave out step 3. => drop 3`). `--plans SUITE` prints the cases with their plans, for
//! those who write such texts. `--requests SUITE` prints what a server is asked for each instruction, for a model that is recorded
//! elsewhere: the suite, the case and the messages. A text of compositions has paragraphs as the model sees them (`Plans:`, `Checks:`, `Wish:`), `=>`, and the
//! program that puts the plans together.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::error::Error;
use std::path::Path;

use longstep::compose::{self, CompositionAnswer, CompositionDialogue, CompositionInput};
use longstep::dialogue::{ChatRequest, ConstraintKind, Dialogue, Likelihood, Reply, Role};
use longstep::domain::Domain;
use longstep::feedback::{Amended, FeedbackDialogue, FeedbackInput, Wish, amend};
use longstep::perception::{SightDialogue, SightInput};
use longstep::understanding::{Examples, Understanding, UnderstandingInput};
use longstep_core::environment::{self, World};
use longstep_core::goal;
use longstep_core::plan::Plan;
use longstep_core::search::{self, Limits, Outcome};
use longstep_eval::suite::{self, Case, Expected, Files, Suite};
use longstep_files::read_texts;
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    let folders: Vec<String> = std::env::args().skip(1).collect();
    if folders.is_empty() {
        return Err("usage: training_data SUITE|TEXT.txt... or training_data --plans|--requests SUITE...".into());
    }
    let print = match folders[0].as_str() {
        "--plans" => Some(planned_cases as fn(&Domain, &Suite)),
        "--requests" => Some(requests as fn(&Domain, &Suite)),
        _ => None,
    };
    if let Some(print) = print {
        for folder in &folders[1..] {
            let (domain, suite) = read_suite(Path::new(folder))?;
            print(&domain, &suite);
        }
        return Ok(());
    }
    for folder in folders {
        let folder = Path::new(&folder);
        if folder.extension().is_some_and(|own| own == "txt") {
            let (name, text) = (folder.display().to_string(), std::fs::read_to_string(folder)?);
            if let Some(text) = text.strip_prefix("domain: ") {
                described(&name, text)?;
            } else if let Some(text) = text.strip_prefix("suite: ") {
                changed(&name, text)?;
            } else {
                composed(&name, &text)?;
            }
            continue;
        }
        let (domain, suite) = read_suite(folder)?;
        let mut written = 0;
        for case in &suite.cases {
            if let Some(object) = object(&suite, &domain, case) {
                println!("{object}");
                written += 1;
            }
        }
        eprintln!("{}: {written} of {} cases", suite.name, suite.cases.len());
    }
    Ok(())
}

/// A suite in a folder, and its domain.
fn read_suite(folder: &Path) -> Result<(Domain, Suite), Box<dyn Error>> {
    let mut cases = read_texts(folder, |name| name.ends_with(".toml"))?;
    let scenes = read_texts(&folder.join("scenes"), |name| name.ends_with(".json"))?;
    let files = Files {
        folder: format!("{}/", folder.display()),
        suite: cases.remove("suite.toml").ok_or("there is no suite.toml")?,
        cases,
        scenes: scenes
            .into_iter()
            .map(|(name, text)| (name.trim_end_matches(".json").to_owned(), text))
            .collect(),
    };
    let domain = suite::domain_name(&files)?;
    let beside = folder.join(&domain);
    let domain = if beside.is_dir() {
        beside.display().to_string()
    } else {
        domain
    };
    let domain = longstep_llm::load_domain(&domain)?;
    let suite = suite::load(&files, &domain)?;
    Ok((domain, suite))
}

/// The suite that the first line of a text names, with its domain, and the other lines.
fn suite_of(text: &str) -> Result<(Domain, Suite, &str), Box<dyn Error>> {
    let (folder, text) = text.split_once('\n').ok_or("there is nothing behind the suite")?;
    let (domain, suite) = read_suite(Path::new(folder.trim()))?;
    Ok((domain, suite, text))
}

fn case_of<'a>(suite: &'a Suite, id: &str) -> Option<&'a Case> {
    suite.cases.iter().find(|case| case.id == id.trim())
}

/// The plan of a case with one instruction, and its world.
fn planned(suite: &Suite, case: &Case) -> Option<(World, Plan, String)> {
    let [step] = &case.steps[..] else { return None };
    let goal = step.expected.goals().first()?;
    let world = suite.judged_world(case);
    match search::solve(&world, &goal.purpose(&world), &Limits::default()) {
        Outcome::Solved { plan, .. } if plan.is_sequence() => {
            let plan = Plan::sequence(plan.steps().to_vec());
            Some((world, plan, step.says.clone()))
        }
        _ => None,
    }
}

/// Prints the cases with plans of two steps and more, as a model sees them when a person speaks about them.
fn planned_cases(domain: &Domain, suite: &Suite) {
    for case in &suite.cases {
        let Some((world, plan, instruction)) = planned(suite, case) else {
            continue;
        };
        if plan.steps().len() > 1 {
            let request = about_plan(domain, &world, &plan, &instruction, "").request();
            let text = request.messages.last().map_or("", |own| own.text.as_str());
            let text = text.rsplit_once('\n').map_or(text, |(before, _)| before);
            println!("{}\n{text}\n", case.id);
        }
    }
}

/// Prints the requests to a server for the cases with one instruction.
fn requests(domain: &Domain, suite: &Suite) {
    for case in &suite.cases {
        let [step] = &case.steps[..] else { continue };
        let mut world = suite.world(case);
        world.add_values(&step.says);
        let input = UnderstandingInput::new(domain, &world, &step.says, ConstraintKind::JsonSchema);
        let request = Understanding::new(input).request();
        let texts: Vec<&str> = request.messages.iter().map(|own| own.text.as_str()).collect();
        println!("{}", json!({"suite": suite.name, "case": case.id, "messages": texts}));
    }
}

fn about_plan(domain: &Domain, world: &World, plan: &Plan, instruction: &str, says: &str) -> FeedbackDialogue {
    FeedbackDialogue::new(FeedbackInput {
        domain,
        world,
        plan,
        instruction,
        feedback: says,
        kind: ConstraintKind::Grammar,
    })
}

/// Prints the objects of a text of changes.
fn changed(name: &str, text: &str) -> Result<(), Box<dyn Error>> {
    let (domain, suite, text) = suite_of(text)?;
    let (mut said, mut impossible) = (0, 0);
    for paragraph in text.trim().split("\n\n") {
        let wrong = |reason: &dyn std::fmt::Display| format!("{name}: {reason} in `{paragraph}`");
        let (id, lines) = paragraph
            .trim()
            .split_once('\n')
            .ok_or_else(|| wrong(&"nothing is said"))?;
        let case = case_of(&suite, id).ok_or_else(|| wrong(&"there is no such case"))?;
        let (world, plan, instruction) = planned(&suite, case).ok_or_else(|| wrong(&"there is no plan"))?;
        let purpose = case.steps[0].expected.goals()[0].purpose(&world);
        for line in lines.lines() {
            let (says, answer) = line.rsplit_once(" => ").ok_or_else(|| wrong(&"there is no arrow"))?;
            let (says, answer) = (says.trim(), answer.trim());
            let mut dialogue = about_plan(&domain, &world, &plan, &instruction, says);
            let request = dialogue.request();
            match dialogue.supply(&reply(answer)).map_err(|error| wrong(&error))? {
                Some(Wish::Steps(wishes)) => match amend(&world, &plan, &wishes, &purpose) {
                    Amended::Done(_) => {}
                    Amended::Impossible { .. } => impossible += 1,
                },
                Some(Wish::Goal | Wish::Further | Wish::Question(_)) => {}
                None => return Err(wrong(&"the answer is not whole").into()),
            }
            let query = &request.messages[request.fixed].text;
            let (shown, own) = query
                .rsplit_once("The person says:")
                .ok_or("the request has no words")?;
            let answer = Some(answer).filter(|answer| !answer.starts_with("question:"));
            println!(
                "{}",
                json!({"suite": suite.name, "id": id, "fixed": fixed(&request),
                    "lead": "", "plan": format!("{shown}The person says:"), "instruction": own, "answer": answer})
            );
            said += 1;
        }
    }
    eprintln!("{name}: {said}, of which {impossible} are not possible in their plan");
    Ok(())
}

/// Prints the objects of a text of compositions.
fn composed(name: &str, text: &str) -> Result<(), Box<dyn Error>> {
    let domain = longstep_llm::load_domain("household")?;
    let world = environment::parse(&domain, "environment", r#"{"assets": [], "objects": []}"#)?;
    let dialogue = CompositionDialogue::new(CompositionInput {
        world: &world,
        stored: &[],
        instruction: "",
        rounds: &[],
        kind: ConstraintKind::Grammar,
    });
    let fixed = fixed(&dialogue.request());
    let paragraphs = text.trim().split("\n\n");
    let count = paragraphs.clone().count();
    for paragraph in paragraphs {
        let wrong = |reason: &dyn std::fmt::Display| format!("{name}: {reason} in `{paragraph}`");
        let (query, answer) = paragraph
            .trim()
            .split_once("\n=>\n")
            .ok_or_else(|| wrong(&"there is no arrow"))?;
        let (lead, wish) = query.rsplit_once("\nWish:").ok_or_else(|| wrong(&"there is no wish"))?;
        let answer = Some(answer).filter(|answer| !answer.starts_with("question:"));
        if let Some(answer) = answer {
            let CompositionAnswer::Composition(written) = compose::read(answer).map_err(|error| wrong(&error))? else {
                return Err(wrong(&"this is no composition").into());
            };
            for step in &written.steps {
                if !lead.contains(&format!("\n- {}(", step.call.name)) {
                    return Err(wrong(&format!("`{}` is not listed", step.call)).into());
                }
            }
        }
        println!(
            "{}",
            json!({"suite": "compositions", "fixed": fixed, "lead": "", "instruction": format!("{lead}\nWish:{wish}"),
                "answer": answer})
        );
    }
    eprintln!("{name}: {count}");
    Ok(())
}

/// Prints the objects of a text of descriptions.
fn described(name: &str, text: &str) -> Result<(), Box<dyn Error>> {
    let (domain, text) = text.split_once('\n').ok_or("there is nothing behind the domain")?;
    let domain = longstep_llm::load_domain(domain.trim())?;
    for paragraph in text.trim().split("\n\n") {
        let wrong = |reason: &dyn std::fmt::Display| format!("{name}: {reason} in `{paragraph}`");
        let (lines, names) = paragraph
            .trim()
            .rsplit_once('\n')
            .ok_or_else(|| wrong(&"there are no names"))?;
        let mut words = String::new();
        let mut facts = 0;
        for line in lines.lines() {
            let (text, plain) = line.split_once(" => ").ok_or_else(|| wrong(&"there is no arrow"))?;
            if words.ends_with(|own: char| own.is_ascii()) {
                words.push(' ');
            }
            words.push_str(text);
            let plain = plain.trim_end_matches('.');
            facts += plain.split(". ").filter(|own| !own.starts_with("There is")).count();
        }
        let input = SightInput {
            domain: &domain,
            words: &words,
            pictures: &[],
            kind: ConstraintKind::Grammar,
        };
        let mut dialogue = SightDialogue::new(&input);
        let request = dialogue.request();
        let sighting = match dialogue.supply(&reply(&format!("{lines}\n")))? {
            Some(sighting) => sighting,
            None => dialogue
                .supply(&reply(names))
                .map_err(|error| wrong(&error))?
                .ok_or_else(|| wrong(&"a name is not in the description"))?,
        };
        let read = sighting.statements.len() + sighting.left_out.len();
        if read != facts {
            return Err(wrong(&format!("{read} of {facts} plain sentences can be read")).into());
        }
        let listed = names.matches(',').count() + 1;
        let known = sighting.assets.len() + sighting.objects.len();
        if listed != known {
            return Err(wrong(&format!("{listed} of {known} names are listed")).into());
        }
        println!(
            "{}",
            json!({"suite": name, "fixed": fixed(&request), "lead": "", "instruction": words,
                "answer": format!("{lines}\n{names}")})
        );
    }
    Ok(())
}

fn reply(text: &str) -> Reply {
    Reply {
        // A model that is trained for the request.
        likelihood: Some(Likelihood {
            is_trained: true,
            ..Likelihood::default()
        }),
        ..Reply::complete(text)
    }
}

/// The fixed messages of a request, as pairs of role and text.
fn fixed(request: &ChatRequest) -> Vec<Value> {
    let fixed = request.messages.iter().take(request.fixed);
    fixed.map(|own| json!([role(own.role), own.text])).collect()
}

fn object(suite: &Suite, domain: &Domain, case: &Case) -> Option<Value> {
    let [step] = &case.steps[..] else { return None };
    let judged = suite.judged_world(case);
    let tagged = |name: &'static str| {
        case.tags
            .iter()
            .filter_map(move |tag| tag.strip_prefix(name))
            .map(str::trim)
    };
    let mut answer = match (tagged("meaning:").next(), &step.expected) {
        (Some(meaning), _) => Some(match goal::parse(&judged, meaning) {
            Ok(goal) => goal.text(&judged),
            // What the language of goals has no words for yet.
            Err(_) => meaning.to_owned(),
        }),
        (None, Expected::Question) => None,
        (None, Expected::Plan(goals)) => Some(goals.first()?.text(&judged)),
        (None, Expected::Refusal | Expected::Either | Expected::Nothing) => return None,
    };
    if let Some(answer) = &mut answer {
        for words in tagged("left out ") {
            answer.push_str(&format!(" | left out {words}"));
        }
    }
    let rounds: Vec<[&str; 2]> = tagged("first:")
        .zip(tagged("remark:"))
        .map(|(reply, message)| [reply, message])
        .collect();
    let mut world = suite.world(case);
    world.add_values(&step.says);
    let dialogue = Understanding::new(UnderstandingInput {
        examples: Examples::All,
        ..UnderstandingInput::new(domain, &world, &step.says, ConstraintKind::Grammar)
    });
    let (query, fixed) = dialogue.transcript().messages().split_last()?;
    let (scene, instruction) = query.text.rsplit_once("Instruction: ")?;
    let fixed: Vec<Value> = fixed.iter().map(|own| json!([role(own.role), own.text])).collect();
    Some(json!({
        "suite": suite.name, "id": case.id, "fixed": fixed, "lead": format!("{scene}Instruction:"),
        "instruction": format!(" {instruction}"), "rounds": rounds, "answer": answer,
    }))
}

fn role(role: Role) -> &'static str {
    match role {
        Role::System => "system",
        Role::User => "user",
        Role::Assistant => "assistant",
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// A request that differs from what the adapter for `goals` has learned is understood worse, without a word: whoever changes it
    /// trains the adapter again, measures, and then replaces the text (`LONGSTEP_LEARNED=write`).
    #[test]
    fn the_request_is_the_one_that_the_adapter_has_learned() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let (domain, suite) = read_suite(&root.join("lab/understanding/training/avstore")).unwrap();
        let (learned, case) = (root.join("lab/adapter/learned-request.txt"), &suite.cases[0]);
        let world = suite.world(case);
        let input = UnderstandingInput {
            examples: Examples::All,
            ..UnderstandingInput::new(&domain, &world, &case.steps[0].says, ConstraintKind::Grammar)
        };
        let mut text = String::new();
        for message in Understanding::new(input).request().messages {
            text.push_str(&format!("== {}\n{}\n", role(message.role), message.text));
        }
        if std::env::var("LONGSTEP_LEARNED").is_ok_and(|own| own == "write") {
            std::fs::write(&learned, &text).unwrap();
        }
        assert_eq!(text, std::fs::read_to_string(&learned).unwrap());
    }
}
