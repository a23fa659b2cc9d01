//! Verdicts in batches, for programs that compare them with their own; `tools/peers/simulate.py` does.
//!
//! Reads one JSON object a line from standard input and writes one a line to standard output, in the same order:
//!
//! - `{"command": "verify", "domain": NAME_OR_FOLDER, "environment": {...}, "plan": TEXT}`
//! - `{"command": "solve", "domain": NAME_OR_FOLDER, "environment": {...}, "goal": TEXT}`
//! - `{"command": "task", "domain": PDDL, "problem": PDDL, "goal": TEXT, "plans": [TEXT]}`; without `goal`, that of the
//!   problem counts
//!
//! The answer is the object that `longstep verify --json` and `longstep solve --json` print. For `verify` of a plan that
//! was simulated, `endings` lists each ending: the sensing outcomes that lead to it (`when`, sentences) and the
//! environment `after` it. For `solve`, `stages` has for each goal of a goal with an order whether it must be achieved
//! `anew` and whether it must hold at the end (`kept`), and `bound` the steps of the plan with all arguments. The answer to `task`
//! has the `outcome` of the search (`solved`, `unsolvable`, `gave_up`), for a solved task its `plan`, `cost`, whether it is
//! proven to be the `best` one and what the verifier says (`valid`), `stages` as above, and the `verdicts` on the plans. What
//! cannot be read is answered with `{"error": TEXT}`.
#![allow(clippy::print_stdout)]

use std::collections::HashMap;
use std::error::Error;
use std::io::Write;

use longstep::Clock;
use longstep::domain::Domain;
use longstep::report::Assessment;
use longstep::{goal, report};
use longstep_core::domain::Condition;
use longstep_core::environment::{self, EntityId, Environment, Voice, World};
use longstep_core::pddl::{read_plan, read_problem};
use longstep_core::plan::{self, Plan, PlanFile, Step, TaskCohesion, Violation};
use longstep_core::search::{self, GroundAction, Outcome};
use longstep_core::verify::{Purpose, bind_tree, check};
use longstep_core::{domain, json};
use longstep_llm::load_domain;
use serde_json::{Value, json};

type Anyhow<T> = Result<T, Box<dyn Error>>;

fn main() -> Anyhow<()> {
    let mut domains = HashMap::new();
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lines() {
        let answer = answer(&mut domains, &line?).unwrap_or_else(|error| json!({"error": error.to_string()}));
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}

fn answer(domains: &mut HashMap<String, Domain>, line: &str) -> Anyhow<Value> {
    let request: Value = serde_json::from_str(line)?;
    let text = |key: &str| request[key].as_str().ok_or(format!("the request has no text `{key}`"));
    if text("command")? == "task" {
        return task(&request, text("domain")?, text("problem")?);
    }
    let domain = load(domains, text("domain")?)?;
    let written = request["environment"].to_string();
    let environment = Environment::from_json(&written)?;
    let world = environment::read(domain, &environment, "environment", &written, &json::Path::default())?;
    match text("command")? {
        "verify" => verify(&world, text("plan")?),
        "solve" => solve(&world, text("goal")?),
        other => Err(format!("there is no command `{other}`").into()),
    }
}

fn load<'a>(domains: &'a mut HashMap<String, Domain>, name: &str) -> Anyhow<&'a Domain> {
    if !domains.contains_key(name) {
        domains.insert(name.to_owned(), load_domain(name)?);
    }
    domains.get(name).ok_or_else(|| "the domain was not loaded".into())
}

fn verify(world: &World, text: &str) -> Anyhow<Value> {
    let draft = if text.trim_start().starts_with('{') {
        plan::read(text)?
    } else {
        plan::Draft {
            file: PlanFile::from(TaskCohesion::from_written(plan::script::read(text)?)),
            leniencies: Vec::new(),
        }
    };
    let assessment = Assessment::new(world, draft, None);
    let mut answer = serde_json::to_value(assessment.verdict())?;
    let bound = bind_tree(world, &assessment.resolved, assessment.purpose.claim.as_ref());
    if let (Ok((plan, _)), None) = (bound, assessment.question()) {
        let report = check(world, plan, &assessment.purpose);
        let endings = report.endings.iter().map(|ending| {
            let when: Vec<String> = ending
                .when
                .iter()
                .map(|fact| Voice::Person.fact(world, *fact, true))
                .collect();
            json!({"when": when, "after": environment::write(world, &ending.after)})
        });
        answer["endings"] = endings.collect();
    }
    Ok(answer)
}

fn solve(world: &World, text: &str) -> Anyhow<Value> {
    let goal = goal::parse(world, text)?;
    let solution = report::of_goal(world, &goal, text, &longstep::Limits::default(), &Clock::none());
    let mut answer = serde_json::to_value(solution.answer)?;
    answer["stages"] = stages(&goal.purpose(world));
    let name = |entity: &EntityId| world.entity(*entity).identifier.clone();
    let steps = solution.plan.iter().flat_map(|plan| plan.steps());
    answer["bound"] = steps
        .map(|step| {
            let arguments: Vec<String> = step.arguments.iter().map(name).collect();
            json!({"action": world.domain().action(step.action).name, "arguments": arguments})
        })
        .collect();
    Ok(answer)
}

/// Returns for each goal of a goal with an order whether it must be achieved anew, and whether it must hold at the end.
fn stages(purpose: &Purpose) -> Value {
    let milestones = purpose.stages.iter().flatten();
    let meant = milestones.zip(&purpose.wanted);
    meant
        .map(|(milestone, wanted)| json!({"anew": milestone.anew, "kept": wanted.condition != Condition::TRUE}))
        .collect()
}

fn task(request: &Value, domain: &str, problem: &str) -> Anyhow<Value> {
    let domain = domain::from_pddl("domain.pddl", domain)?;
    let problem = read_problem(&domain, "problem.pddl", problem)?;
    let world = &problem.world;
    let purpose = match request["goal"].as_str() {
        Some(goal) => goal::parse(world, goal)?.purpose(world),
        None => Purpose::from(&problem),
    };
    let mut answer = match search::solve(world, &purpose, &longstep::Limits::default()) {
        Outcome::Solved {
            plan, cost, shortest, ..
        } => {
            let steps = plan.steps().iter().map(|step| words(world, step));
            json!({
                "outcome": "solved",
                "plan": steps.collect::<Vec<_>>(),
                "cost": cost.map(|cost| cost.to_string()),
                "best": shortest,
                "valid": check(world, plan, &purpose).violations.is_empty(),
            })
        }
        Outcome::ProvenUnsolvable { .. } => json!({"outcome": "unsolvable"}),
        Outcome::GaveUp { why, .. } => json!({"outcome": "gave_up", "why": why}),
    };
    answer["stages"] = stages(&purpose);
    let plans = request["plans"].as_array().into_iter().flatten();
    let verdicts = plans.map(|plan| verdict(world, &purpose, plan.as_str().unwrap_or_default()));
    answer["verdicts"] = verdicts.collect::<Anyhow<Value>>()?;
    Ok(answer)
}

/// Verifies a plan as planners write it: the first step that is not applicable, validity, and the cost.
fn verdict(world: &World, purpose: &Purpose, plan: &str) -> Anyhow<Value> {
    let explained = |step: GroundAction| Step::explained(world, step.action, step.arguments);
    let steps = read_plan(world, "plan", plan)?
        .steps
        .into_iter()
        .map(explained)
        .collect();
    let report = check(world, Plan::sequence(steps), purpose);
    let inapplicable = report.violations.iter().find_map(|violation| match violation {
        Violation::Precondition { step, .. } => Some(*step),
        _ => None,
    });
    Ok(json!({
        "inapplicable": inapplicable,
        "valid": report.violations.is_empty(),
        "cost": report.cost().map(|cost| cost.to_string()),
    }))
}

/// Returns a step as its action and arguments.
fn words(world: &World, step: &Step) -> Vec<String> {
    let arguments = step
        .arguments
        .iter()
        .map(|entity| world.entity(*entity).identifier.clone());
    let action = world.domain().action(step.action).name.clone();
    std::iter::once(action).chain(arguments).collect()
}
