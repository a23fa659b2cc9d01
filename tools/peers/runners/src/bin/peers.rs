//! Our side of the comparison with other planners; `tools/peers/compare.py` runs it.
//!
//! - `peers export FOLDER`: writes goals of every shipped domain and example as PDDL tasks, one folder each.
//! - `peers order FOLDER`: writes goals with an order and with prohibitions as ground PDDL tasks.
//! - `peers check-order`: checks other planners' plans for them; a line of the input is `SCENE GOAL PLAN`, with tabs
//!   between.
//! - `peers solve [--effort EFFORT] DOMAIN.pddl PROBLEM.pddl...`: plans for PDDL problems.
//! - `peers check`: checks other planners' plans; a line of the input is `DOMAIN.pddl PROBLEM.pddl PLAN`, with tabs
//!   between.
//!
//! The results are written as one JSON object to a line.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use longstep::domain::{self, Domain, Files};
use longstep::goal::{self, Goal, GoalFact};
use longstep::instruction;
use longstep_core::environment::{self, Environment, World};
use longstep_core::json;
use longstep_core::pddl::{self, Problem};
use longstep_core::plan::{Plan, Step};
use longstep_core::search::{self, Effort, Limits, Outcome};
use longstep_core::verify::{Purpose, check};
use longstep_files::domain_files;
use serde_json::{Value, json};

type Anyhow<T> = Result<T, Box<dyn Error>>;

fn main() -> Anyhow<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match &words[..] {
        ["export", folder] => export(Path::new(folder)),
        ["order", folder] => export_order(Path::new(folder)),
        ["check-order"] => {
            let scenes = scenes()?;
            std::io::stdin().lines().try_for_each(|line| check_order(&scenes, &line?))
        }
        ["solve", "--effort", effort, domain, problems @ ..] if !problems.is_empty() => {
            let limits = Limits::from(effort.parse::<Effort>()?);
            problems.iter().try_for_each(|problem| solve(domain, problem, &limits))
        }
        ["solve", domain, problems @ ..] if !problems.is_empty() => problems
            .iter()
            .try_for_each(|problem| solve(domain, problem, &Limits::default())),
        ["check"] => std::io::stdin().lines().try_for_each(|line| check_plan(&line?)),
        _ => Err(
            "usage: peers export FOLDER | peers order FOLDER | peers check-order | peers solve [--effort EFFORT] DOMAIN.pddl PROBLEM.pddl... | peers check"
                .into(),
        ),
    }
}

/// Reads and solves a problem; the time is that from the texts in memory to the plan.
fn solve(domain_file: &str, problem_file: &str, limits: &Limits) -> Anyhow<()> {
    let texts = (
        std::fs::read_to_string(domain_file)?,
        std::fs::read_to_string(problem_file)?,
    );
    let started = Instant::now();
    let domain = domain::from_pddl(domain_file, &texts.0)?;
    let problem = pddl::read_problem(&domain, problem_file, &texts.1)?;
    let outcome = search::solve(&problem.world, &Purpose::from(&problem), limits);
    let microseconds = started.elapsed().as_micros();
    let mut line = json!({"problem": problem_file, "outcome": name(&outcome), "microseconds": microseconds});
    match outcome {
        Outcome::Solved {
            plan,
            shortest,
            expanded,
            ..
        } => {
            line["length"] = plan.steps().len().into();
            line["shortest"] = shortest.into();
            line["expanded"] = expanded.into();
            line["valid"] = is_valid(&problem, plan).into();
        }
        Outcome::ProvenUnsolvable { expanded, .. } | Outcome::GaveUp { expanded, .. } => {
            line["expanded"] = expanded.into()
        }
    }
    println!("{line}");
    Ok(())
}

fn name(outcome: &Outcome) -> &'static str {
    match outcome {
        Outcome::Solved { .. } => "solved",
        Outcome::ProvenUnsolvable { .. } => "unsolvable",
        Outcome::GaveUp { .. } => "gave_up",
    }
}

/// Returns true if the verifier, which shares nothing with the search, accepts the plan.
fn is_valid(problem: &Problem, plan: Plan) -> bool {
    check(&problem.world, plan, &Purpose::from(problem))
        .violations
        .is_empty()
}

fn check_plan(line: &str) -> Anyhow<()> {
    let [domain_file, problem_file, plan_file] = line.split('\t').collect::<Vec<_>>()[..] else {
        return Err(format!("not three files: {line}").into());
    };
    let domain = domain::from_pddl(domain_file, &std::fs::read_to_string(domain_file)?)?;
    let problem = pddl::read_problem(&domain, problem_file, &std::fs::read_to_string(problem_file)?)?;
    let text = std::fs::read_to_string(plan_file)?;
    let steps = pddl::read_plan(&problem.world, plan_file, &text)?.steps;
    let length = steps.len();
    let explained = steps
        .into_iter()
        .map(|step| Step::explained(&problem.world, step.action, step.arguments));
    let valid = is_valid(&problem, explained.collect());
    println!("{}", json!({"problem": problem_file, "length": length, "valid": valid}));
    Ok(())
}

/// A robot and a place for it.
struct Scene {
    name: String,
    domain: Domain,
    pddl: String,
    world: World,
}

fn export(folder: &Path) -> Anyhow<()> {
    let mut number = 0;
    for scene in scenes()? {
        for goal in goals(&scene.domain, &scene.world) {
            number += 1;
            export_goal(
                &folder.join(format!("{number:03}")),
                &format!("task-{number:03}"),
                &scene,
                &goal,
            )?;
        }
    }
    Ok(())
}

fn export_goal(folder: &Path, name_of_task: &str, scene: &Scene, goal: &Goal) -> Anyhow<()> {
    let world = &scene.world;
    let purpose = goal.purpose(world);
    let text = pddl::write_problem(world, &purpose, name_of_task)?;
    let domain_file = folder.join("domain.pddl");
    let problem_file = folder.join("problem.pddl");
    std::fs::create_dir_all(folder)?;
    std::fs::write(&domain_file, &scene.pddl)?;
    std::fs::write(&problem_file, &text)?;
    let mut line = solved_line(
        scene,
        &goal.exact(world).join(" & "),
        &purpose,
        (&domain_file, &problem_file),
    );
    // What was written means the same to us when we read it back.
    let bare = domain::from_pddl("domain.pddl", &scene.pddl)?;
    let problem = pddl::read_problem(&bare, "problem.pddl", &text)?;
    let again = search::solve(&problem.world, &Purpose::from(&problem), &Limits::default());
    line["again"] = match again {
        Outcome::Solved { plan, .. } => plan.steps().len().into(),
        other => name(&other).into(),
    };
    println!("{line}");
    Ok(())
}

/// Returns the line about a task: its files, and what our search finds.
fn solved_line(scene: &Scene, goal: &str, purpose: &Purpose, (domain_file, problem_file): (&Path, &Path)) -> Value {
    let outcome = search::solve(&scene.world, purpose, &Limits::default());
    let mut line = json!({
        "scene": scene.name,
        "goal": goal,
        "domain": domain_file,
        "problem": problem_file,
        "outcome": name(&outcome),
    });
    if let Outcome::Solved { plan, shortest, .. } = outcome {
        line["length"] = plan.steps().len().into();
        line["shortest"] = shortest.into();
    }
    line
}

/// Goals with an order or a prohibition, made of the single goals of a scene.
fn ordered_goals(scene: &Scene) -> Vec<String> {
    let single: Vec<String> = goals(&scene.domain, &scene.world)
        .iter()
        .filter(|goal| goal.facts.len() == 1 && !goal.depends_on_sensing(&scene.domain))
        .map(|goal| goal.exact(&scene.world).concat())
        .collect();
    let next = |index: usize| &single[(index * 7 + 3) % single.len()];
    let mut all = Vec::new();
    // A few for each scene: both planners need seconds for some of them.
    let step = single.len().div_ceil(3).max(1);
    for (index, first) in single.iter().enumerate().step_by(step) {
        let (second, third) = (next(index), next(index + 1));
        all.push(format!("{first} then {second}"));
        all.push(format!("{first} then {second} then {first}"));
        all.push(format!("{first} & never {second}"));
        all.push(format!("{first} then {second} & never {third}"));
    }
    // A constraint on what can never hold is no goal.
    all.retain(|text| goal::parse(&scene.world, text).is_ok());
    all
}

fn export_order(folder: &Path) -> Anyhow<()> {
    let mut number = 0;
    for scene in scenes()? {
        let world = &scene.world;
        if scene.domain.actions.iter().any(|action| !action.senses.is_empty()) {
            continue;
        }
        for text in ordered_goals(&scene) {
            number += 1;
            let purpose = goal::parse(world, &text)?.purpose(world);
            let task = pddl::GroundTask::write(world, &purpose, &format!("task-{number}"))?;
            // The other planner's translator is written for tasks with variables and takes minutes for larger ones.
            if task.domain.len() > 60_000 {
                continue;
            }
            let folder = folder.join(format!("{number:04}"));
            std::fs::create_dir_all(&folder)?;
            let (domain_file, problem_file) = (folder.join("domain.pddl"), folder.join("problem.pddl"));
            std::fs::write(&domain_file, &task.domain)?;
            std::fs::write(&problem_file, &task.problem)?;
            let line = solved_line(&scene, &text, &purpose, (&domain_file, &problem_file));
            println!("{line}");
        }
    }
    Ok(())
}

fn check_order(scenes: &[Scene], line: &str) -> Anyhow<()> {
    let [scene_name, text, plan_file] = line.split('\t').collect::<Vec<_>>()[..] else {
        return Err(format!("not a scene, a goal and a file: {line}").into());
    };
    let scene = scenes.iter().find(|scene| scene.name == scene_name);
    let world = &scene.ok_or("no such scene")?.world;
    let purpose = goal::parse(world, text)?.purpose(world);
    let task = pddl::GroundTask::write(world, &purpose, "task")?;
    let steps = task.read_plan(&std::fs::read_to_string(plan_file)?);
    let steps = steps.ok_or("the plan has an action that the task does not have")?;
    let length = steps.len();
    let explained = steps
        .into_iter()
        .map(|step| Step::explained(world, step.action, step.arguments));
    let valid = check(world, explained.collect(), &purpose).violations.is_empty();
    println!(
        "{}",
        json!({"problem": format!("{scene_name}: {text}"), "length": length, "valid": valid})
    );
    Ok(())
}

/// Every domain of the repository with every example environment that is one of its worlds.
fn scenes() -> Anyhow<Vec<Scene>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let mut domains = Vec::new();
    for name in domain::shipped_names() {
        domains.push((name.to_owned(), domain_files(name)?));
    }
    let greenhouse = root.join("examples/greenhouse");
    domains.push((
        "greenhouse".to_owned(),
        domain_files(&greenhouse.display().to_string())?,
    ));
    let starter = domain::starter("starter");
    let environment = starter.iter().find(|(path, _)| path == "environment.json");
    let environment = environment.map(|(_, text)| text.clone()).unwrap_or_default();
    let mut environments = vec![("starter".to_owned(), environment)];
    domains.push(("starter".to_owned(), Files::from_texts("starter/", starter)));

    let mut paths: Vec<PathBuf> = std::fs::read_dir(root.join("examples/environments"))?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    paths.push(greenhouse.join("environment.json"));
    paths.sort();
    for path in paths {
        let stem = |path: &Path| {
            path.file_stem()
                .map(|stem| stem.to_string_lossy().into_owned())
                .unwrap_or_default()
        };
        let name = match stem(&path).as_str() {
            "environment" => path.parent().map(stem).unwrap_or_default(),
            other => other.to_owned(),
        };
        environments.push((name, std::fs::read_to_string(&path)?));
    }

    let mut scenes = Vec::new();
    for (domain_name, files) in &domains {
        for (environment_name, text) in &environments {
            let domain = domain::load(files)?;
            let environment = Environment::from_json(text)?;
            // Most environments are worlds of one domain only.
            if let Ok(world) = environment::read(&domain, &environment, environment_name, text, &json::Path::default())
            {
                scenes.push(Scene {
                    name: format!("{domain_name}/{environment_name}"),
                    domain,
                    pddl: files.pddl.clone(),
                    world,
                });
            }
        }
    }
    Ok(scenes)
}

/// Three goals of each word, spread over what is offered; some of them joined; and some that exclude each other.
fn goals(domain: &Domain, world: &World) -> Vec<Goal> {
    let fact = |word, arguments: &Vec<_>| GoalFact::Word {
        word,
        arguments: arguments.clone(),
    };
    let offers = instruction::offers(world);
    let mut facts = Vec::new();
    for offer in &offers {
        let all = &offer.arguments;
        let mut places = vec![0, all.len() / 2, all.len() - 1];
        places.dedup();
        facts.push(
            places
                .into_iter()
                .map(|at| fact(offer.word, &all[at]))
                .collect::<Vec<_>>(),
        );
    }
    let single = facts.iter().flatten().cloned().map(|fact| vec![fact]);
    let mut goals: Vec<Vec<GoalFact>> = single.collect();
    for (first, second) in facts.iter().zip(facts.iter().skip(1)) {
        goals.extend(
            first
                .last()
                .zip(second.first())
                .map(|(a, b)| vec![a.clone(), b.clone()]),
        );
    }
    if let [first, second, third, ..] = &facts[..] {
        let all = [first.first(), second.last(), third.first()];
        goals.push(all.into_iter().flatten().cloned().collect());
    }
    for offer in &offers {
        let word = domain.goal_word(offer.word);
        for (index, other) in domain.goal_words.iter().enumerate() {
            let kinds = |word: &domain::GoalWord| word.parameters.iter().map(|p| p.kind).collect::<Vec<_>>();
            let excludes = other.exclusive.is_some() && other.exclusive == word.exclusive && other.word != word.word;
            if excludes && kinds(other) == kinds(word) {
                let arguments = &offer.arguments[0];
                let opposite = fact(domain::GoalWordId::new(index), arguments);
                goals.push(vec![fact(offer.word, arguments), opposite]);
            }
        }
    }
    goals.into_iter().map(Goal::from).collect()
}
