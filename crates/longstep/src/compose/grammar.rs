//! Structured output for compositions: a grammar for the script and a JSON schema for the tree.

use serde_json::{Value, json};

use super::asked::Check;
use super::menu::{Menu, Offered};
use crate::dialogue::{TreeForms, closed, tree_schema};
use crate::goal::{QUESTION, quoted};

/// Maximum parts of a block. It stops a model that repeats itself.
const MOST: usize = 6;

/// Maximum nesting of branches.
const DEPTH: usize = 2;

/// Maximum plans of a lane for which the grammar lists every order. With more, it permits repetitions.
const LISTED: usize = 4;

/// Returns a grammar in llguidance's Lark dialect for the script of a composition, or for a question.
///
/// Every line is spelled out with its indentation, so only stored plans, checks and lanes that exist can be written. A
/// check and the branch on its outcome form one rule, and no check repeats inside its own branch.
pub(super) fn grammar(menu: &Menu) -> String {
    let question = format!("question: {} /[A-Za-z][A-Za-z0-9 ,'-]{{8,120}}\\?/\n", quoted(QUESTION));
    if menu.plans.is_empty() {
        return format!("start: question\n{question}");
    }
    let mut text = format!("start: question | whole\n{question}");
    let mut forks = Vec::new();
    if !menu.checks.is_empty() {
        forks.push("branch0");
        text.push_str(&branches(menu));
    }
    if !menu.lanes.is_empty() {
        forks.push("sides");
        text.push_str(&sides(menu));
    }
    let plan = menu.plans.iter().map(|plan| quoted(&format!("{}()", plan.name)));
    text.push_str(&format!("plan0: {}\n", any(plan)));
    let forks = forks.join(" | ");
    text.push_str(&match (forks.is_empty(), menu.fork_wanted) {
        (true, _) => format!("whole: plan0 (\"\\n\" plan0){{0,{}}}\n", MOST - 1),
        (false, false) => format!("whole: part (\"\\n\" part){{0,{}}}\npart: plan0 | {forks}\n", MOST - 1),
        // The instruction asks for a branch or lanes, so the grammar requires one.
        (false, true) => format!(
            "whole: (plan0 \"\\n\"){{0,{n}}} ({forks}) (\"\\n\" part){{0,{n}}}\npart: plan0 | {forks}\n",
            n = MOST - 2
        ),
    });
    text
}

fn any(alternatives: impl Iterator<Item = String>) -> String {
    alternatives.collect::<Vec<_>>().join("\n  | ")
}

/// Returns the rules for a branch on each check, with branches on the other checks nested inside.
fn branches(menu: &Menu) -> String {
    let mut text = String::new();
    let all = 0..menu.checks.len();
    let rules = all.clone().map(|index| format!("branch0_{index}"));
    text.push_str(&format!("branch0: {}\n", any(rules)));
    for index in all.clone() {
        text.push_str(&branch(menu, index, 0, &format!("block1_{index}")));
        let others = all.clone().filter(|other| *other != index);
        let inner = std::iter::once("plan1".to_owned()).chain(others.map(|other| format!("branch1_{other}")));
        let inner = any(inner);
        text.push_str(&format!(
            "block1_{index}: part1_{index} (\"\\n\" part1_{index}){{0,{}}}\npart1_{index}: {inner}\n",
            MOST - 1
        ));
        if menu.checks.len() > 1 {
            text.push_str(&branch(menu, index, 1, "block2"));
        }
    }
    let levels = if menu.checks.len() > 1 { 1..=DEPTH } else { 1..=1 };
    for depth in levels {
        let margin = "    ".repeat(depth);
        let calls = menu
            .plans
            .iter()
            .map(|plan| quoted(&format!("{margin}{}()", plan.name)));
        text.push_str(&format!("plan{depth}: {}\n", any(calls)));
    }
    if menu.checks.len() > 1 {
        text.push_str(&format!("block2: plan2 (\"\\n\" plan2){{0,{}}}\n", MOST - 1));
    }
    text
}

/// Returns the rule for a check in one line and the branch on its outcome in the next lines.
fn branch(menu: &Menu, index: usize, depth: usize, block: &str) -> String {
    let check = &menu.checks[index];
    let margin = "    ".repeat(depth);
    let call = check.script();
    let asked = match check.outcomes.is_empty() {
        true => String::new(),
        false => quoted(&format!("{margin}{call}\n")),
    };
    let conditions = check.conditions();
    let one_of = |word: &str| {
        let lines = conditions
            .iter()
            .map(|condition| quoted(&format!("{margin}{word} {condition}:\n")));
        format!("({}) {block}", any(lines))
    };
    // With two outcomes, `else` covers the second.
    let elif = match conditions.len() {
        0..=2 => String::new(),
        _ => format!(" (\"\\n\" {})?", one_of("elif")),
    };
    let otherwise = quoted(&format!("\n{margin}else:\n"));
    format!(
        "branch{depth}_{index}: {asked} {}{elif} ({otherwise} {block})?\n",
        one_of("if")
    )
}

/// Returns the rule for parallel lanes: each ordered pair of two lanes that have plans.
fn sides(menu: &Menu) -> String {
    let lane = |lane: &String| {
        let fitting = menu.plans.iter().filter(|plan| plan.lane.as_ref() == Some(lane));
        format!(
            "{} ({})",
            quoted(&format!("\n    with lane({}):\n", quoted(lane))),
            any(orders(&fitting.collect::<Vec<_>>()).into_iter())
        )
    };
    let lanes: Vec<String> = menu.lanes.iter().map(lane).collect();
    let all = 0..lanes.len();
    let pairs = all.clone().flat_map(|one| all.clone().map(move |other| (one, other)));
    let pairs = pairs.filter(|(one, other)| one != other);
    let pairs = pairs.map(|(one, other)| format!("\"with parallel():\" {} {}", lanes[one], lanes[other]));
    format!("sides: {}\n", any(pairs))
}

/// Returns the possible contents of a lane: a non-empty subset of its plans, in any order.
fn orders<'a>(plans: &[&'a Offered]) -> Vec<String> {
    let line = |plan: &Offered| format!("        {}()", plan.name);
    if plans.len() > LISTED {
        let lines = plans.iter().map(|plan| quoted(&line(plan)));
        let one = any(lines);
        return vec![format!("({one}) (\"\\n\" ({one})){{0,{}}}", MOST - 1)];
    }
    let mut all = Vec::new();
    let mut longest: Vec<Vec<&'a Offered>> = vec![Vec::new()];
    for _ in plans {
        let longer = |row: &Vec<&'a Offered>| {
            let left = plans.iter().copied().filter(|plan| !row.contains(plan));
            left.map(|plan| [&row[..], &[plan]].concat()).collect::<Vec<_>>()
        };
        longest = longest.iter().flat_map(longer).collect();
        all.extend(longest.iter().map(|row| {
            let lines: Vec<String> = row.iter().map(|plan| line(plan)).collect();
            quoted(&lines.join("\n"))
        }));
    }
    all
}

/// Returns a JSON schema for the answer of a server: the tree of a composition, or a question.
pub(super) fn schema(menu: &Menu) -> Value {
    let plain = |word: &str, things: &[String]| format!("{word}({})", things.join(", "));
    let plans = menu.plans.iter().map(|plan| format!("{}()", plan.name));
    let looks = menu.checks.iter().map(|check| plain(&check.call, &check.things));
    let calls: Vec<String> = plans.chain(looks).collect();
    let asked = menu.checks.iter().flat_map(|check| match check.outcomes.is_empty() {
        true => vec![plain(&check.call, &check.things)],
        false => check
            .outcomes
            .iter()
            .map(|(word, things)| plain(word, things))
            .collect(),
    });
    let asked: Vec<String> = asked.collect();
    let tree = tree_schema(TreeForms {
        calls: Some(&calls),
        asked: Some(&asked),
        lanes: &menu.lanes,
        loops: false,
        explained: false,
        depth: DEPTH,
    });
    let mut schema = closed(&[("task_tree", tree.nodes), ("question", json!({"type": "string"}))]);
    schema["$defs"] = tree.definitions;
    schema
}

impl Check {
    /// Returns the call in script notation: `check_date("spam")`.
    pub(super) fn script(&self) -> String {
        script_call(&self.call, &self.things)
    }

    /// Returns one condition for each outcome. If the environment has no words for the outcomes, these are the call
    /// itself (the first outcome) and its negation (every other outcome).
    pub(super) fn conditions(&self) -> Vec<String> {
        if self.outcomes.is_empty() {
            return vec![self.script(), format!("not {}", self.script())];
        }
        let asked = self.outcomes.iter().map(|(word, things)| script_call(word, things));
        asked.collect()
    }
}

fn script_call(word: &str, things: &[String]) -> String {
    let things: Vec<String> = things.iter().map(|thing| quoted(thing)).collect();
    format!("{word}({})", things.join(", "))
}
