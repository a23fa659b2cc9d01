//! Measures the one request: `one_request ADAPTER EXAMPLES|all SUITE...` prints a line for each case.
#![allow(clippy::print_stdout, clippy::print_stderr)]
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use longstep::dialogue::Dialogue;
use longstep::domain::Domain;
use longstep::understanding::{UnderstandingDialogue, UnderstandingInput};
use longstep_eval::suite::{self, Expected, Files, Suite};
use longstep_llm::{AdapterChoice, OpenOptions, read_texts};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut options = OpenOptions::new(PathBuf::from(std::env::var("HOME")?).join(".cache/longstep"));
    options.adapters = match arguments[0].as_str() {
        "off" => AdapterChoice::Off,
        file => AdapterChoice::Files(vec![file.into()]),
    };
    let examples: Option<usize> = arguments[1].parse().ok();
    let mut model = longstep_llm::open(&"qwen2.5-coder-1.5b".parse()?, &options, &mut |_| {})?;
    for folder in &arguments[2..] {
        let (domain, suite) = read_suite(Path::new(folder))?;
        for case in &suite.cases {
            let [step] = &case.steps[..] else { continue };
            let mut world = suite.world(case);
            world.add_values(&step.says);
            let started = Instant::now();
            let mut out = Vec::new();
            for asks in [true, false] {
                let input = UnderstandingInput { domain: &domain, world: &world, instruction: &step.says, examples, asks };
                let mut dialogue = UnderstandingDialogue::new(input);
                let request = dialogue.request();
                let formed = started.elapsed().as_millis();
                let reply = match model.chat(&request, &mut |_: longstep_llm::Progress| {}) { Ok(r) => r, Err(e) => { out.push(serde_json::json!({"error": e.to_string()})); break } };
                let judged = suite.judged_world(case);
                let answer = dialogue.supply(&reply);
                let (right, kind) = match (&answer, &step.expected) {
                    (Ok(Some(a)), Expected::Plan(goals)) => match &a.goal {
                        Some(goal) => {
                            let texts: Vec<String> = goals.iter().map(|g| text(g, &judged)).collect();
                            (texts.contains(&text(goal, &world)), "goal")
                        }
                        None => (false, "asks"),
                    },
                    (Ok(Some(a)), _) => match &a.goal { Some(_) => (false, "goal"), None => (true, "asks") },
                    (Err(e), _) => { out.push(serde_json::json!({"unreadable": e.to_string()})); (false, "unreadable") }
                    _ => (false, "nothing"),
                };
                let l = reply.likelihood.map(|l| l.text);
                out.push(serde_json::json!({"text": reply.text, "likelihood": l, "right": right, "kind": kind, "formed": formed,
                    "ms": started.elapsed().as_millis() as u64, "usage": format!("{:?}", reply.usage)}));
                if kind != "asks" || !asks { break }
            }
            let expected: Vec<String> = step.expected.goals().iter().map(|g| text(g, &suite.judged_world(case))).collect();
            println!("{}", serde_json::json!({"suite": suite.name, "id": case.id, "says": step.says, "expected": expected, "tags": case.tags, "out": out}));
        }
    }
    Ok(())
}

fn text(goal: &longstep_core::goal::Goal, world: &longstep::World) -> String {
    goal.everyday(world).join(" & ").replace("& then ", "then ")
}

fn read_suite(folder: &Path) -> Result<(Domain, Suite), Box<dyn Error>> {
    let mut cases = read_texts(folder, |name| name.ends_with(".toml"))?;
    let scenes = read_texts(&folder.join("scenes"), |name| name.ends_with(".json"))?;
    let files = Files {
        folder: format!("{}/", folder.display()),
        suite: cases.remove("suite.toml").ok_or("there is no suite.toml")?,
        cases,
        scenes: scenes.into_iter().map(|(name, text)| (name.trim_end_matches(".json").to_owned(), text)).collect(),
    };
    let domain = suite::domain_name(&files)?;
    let beside = folder.join(&domain);
    let domain = if beside.is_dir() { beside.display().to_string() } else { domain };
    let domain = longstep_llm::load_domain(&domain)?;
    let suite = suite::load(&files, &domain)?;
    Ok((domain, suite))
}
