//! Structured output for compositions: a grammar for the script and a JSON schema for the tree.

use serde_json::Value;

use super::menu::{Menu, Offered};
use super::sensing::Check;
use crate::dialogue::answer_grammar::{Grammar, any_text, closed, either, quoted};
use crate::dialogue::{TreeForms, tree_schema};

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
    let mut grammar = Grammar::default();
    grammar.question();
    if menu.plans.is_empty() {
        return grammar.text();
    }
    grammar.start("whole");
    let mut forks = Vec::new();
    if !menu.checks.is_empty() {
        forks.push("branch0");
        branches(menu, &mut grammar);
    }
    if !menu.lanes.is_empty() {
        forks.push("sides");
        grammar.rule("sides", sides(menu));
    }
    grammar.rule("plan0", calls(menu, 0));
    let forks = forks.join(" | ");
    if forks.is_empty() {
        grammar.rule("whole", [block("plan0")]);
        return grammar.text();
    }
    // Where the instruction asks for a branch or lanes, the grammar requires one.
    grammar.rule(
        "whole",
        [match menu.fork_wanted {
            true => format!(
                "(plan0 \"\\n\"){{0,{n}}} ({forks}) (\"\\n\" part){{0,{n}}}",
                n = MOST - 2
            ),
            false => block("part"),
        }],
    );
    grammar.rule("part", [format!("plan0 | {forks}")]);
    grammar.text()
}

/// Returns the rule for lines of one kind.
fn block(line: &str) -> String {
    format!("{line} (\"\\n\" {line}){{0,{}}}", MOST - 1)
}

/// Returns the calls of the stored plans, indented for this depth.
fn calls(menu: &Menu, depth: usize) -> impl Iterator<Item = String> {
    let margin = "    ".repeat(depth);
    let plans = menu.plans.iter();
    plans.map(move |plan| quoted(&format!("{margin}{}()", plan.name)))
}

/// Adds the rules for a branch on each check, with branches on the other checks nested inside.
fn branches(menu: &Menu, grammar: &mut Grammar) {
    let all = 0..menu.checks.len();
    let nested = menu.checks.len() > 1;
    grammar.rule("branch0", all.clone().map(|index| format!("branch0_{index}")));
    for index in all.clone() {
        branch(menu, index, 0, &format!("block1_{index}"), grammar);
        let part = format!("part1_{index}");
        grammar.rule(&format!("block1_{index}"), [block(&part)]);
        let others = all.clone().filter(|other| *other != index);
        let inner = std::iter::once("plan1".to_owned()).chain(others.map(|other| format!("branch1_{other}")));
        grammar.rule(&part, inner);
        if nested {
            branch(menu, index, 1, "block2", grammar);
        }
    }
    for depth in 1..=if nested { DEPTH } else { 1 } {
        grammar.rule(&format!("plan{depth}"), calls(menu, depth));
    }
    if nested {
        grammar.rule("block2", [block("plan2")]);
    }
}

/// Adds the rule for a check in one line and the branch on its outcome in the next lines.
fn branch(menu: &Menu, index: usize, depth: usize, body: &str, grammar: &mut Grammar) {
    let check = &menu.checks[index];
    let margin = "    ".repeat(depth);
    let sensed = match check.outcomes.is_empty() {
        true => String::new(),
        false => quoted(&format!("{margin}{}\n", check.script())),
    };
    let conditions = check.conditions();
    // With two outcomes, `else` covers the second.
    let elif = match conditions.len() {
        0..=2 => String::new(),
        _ => format!(" (\"\\n\" {} {body})?", heads(&margin, "elif", &conditions)),
    };
    let heads = heads(&margin, "if", &conditions);
    let otherwise = quoted(&format!("\n{margin}else:\n"));
    grammar.rule(
        &format!("branch{depth}_{index}"),
        [format!("{sensed} {heads} {body}{elif} ({otherwise} {body})?")],
    );
}

/// Returns the lines that begin a branch, one for each condition.
fn heads(margin: &str, word: &str, conditions: &[String]) -> String {
    let lines = conditions.iter();
    let lines = lines.map(|condition| quoted(&format!("{margin}{word} {condition}:\n")));
    format!("({})", either(lines))
}

/// Returns the alternatives for parallel lanes: each ordered pair of two lanes that have plans.
fn sides(menu: &Menu) -> Vec<String> {
    let lanes: Vec<String> = menu.lanes.iter().map(|lane| lane_rule(menu, lane)).collect();
    let all = 0..lanes.len();
    let pairs = all.clone().flat_map(|one| all.clone().map(move |other| (one, other)));
    let pairs = pairs.filter(|(one, other)| one != other);
    let pairs = pairs.map(|(one, other)| format!("\"with parallel():\" {} {}", lanes[one], lanes[other]));
    pairs.collect()
}

/// Returns the rule for a lane with its plans.
fn lane_rule(menu: &Menu, lane: &String) -> String {
    let head = quoted(&format!("\n    with lane({}):\n", quoted(lane)));
    let fitting = menu.plans.iter().filter(|plan| plan.lane.as_ref() == Some(lane));
    format!("{head} ({})", either(orders(&fitting.collect::<Vec<_>>())))
}

/// Returns the possible contents of a lane: a non-empty subset of its plans, in any order.
fn orders<'a>(plans: &[&'a Offered]) -> Vec<String> {
    let line = |plan: &Offered| format!("        {}()", plan.name);
    if plans.len() > LISTED {
        let lines = plans.iter().map(|plan| quoted(&line(plan)));
        return vec![block(&format!("({})", either(lines)))];
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
    let conditions = menu.checks.iter().flat_map(|check| match check.outcomes.is_empty() {
        true => vec![plain(&check.call, &check.things)],
        false => check
            .outcomes
            .iter()
            .map(|(word, things)| plain(word, things))
            .collect(),
    });
    let conditions: Vec<String> = conditions.collect();
    let tree = tree_schema(TreeForms {
        calls: Some(&calls),
        conditions: Some(&conditions),
        lanes: &menu.lanes,
        loops: false,
        explained: false,
        depth: DEPTH,
    });
    let mut schema = closed(&[("task_tree", tree.nodes), ("question", any_text())]);
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
        let conditions = self.outcomes.iter().map(|(word, things)| script_call(word, things));
        conditions.collect()
    }
}

fn script_call(word: &str, things: &[String]) -> String {
    let things: Vec<String> = things.iter().map(|thing| quoted(thing)).collect();
    format!("{word}({})", things.join(", "))
}
