//! Structured output for compositions: a grammar for the script and a JSON schema for the tree.

use serde_json::Value;

use super::menu::{Menu, Offered};
use super::sensing::Check;
use crate::dialogue::answer_grammar::{Form, any_text, closed, quoted};
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
/// check and the branch on its outcome form one part, and no check repeats inside its own branch.
pub(super) fn grammar(menu: &Menu) -> String {
    if menu.plans.is_empty() {
        return Form::question().grammar();
    }
    Form::Either(vec![Form::question(), whole(menu)]).grammar()
}

fn whole(menu: &Menu) -> Form {
    let mut forks = Vec::new();
    if !menu.checks.is_empty() {
        forks.extend((0..menu.checks.len()).map(|index| branch(menu, index, &[])));
    }
    if !menu.lanes.is_empty() {
        forks.push(sides(menu));
    }
    let plan = calls(menu, 0);
    if forks.is_empty() {
        return block(plan);
    }
    let mut parts = vec![plan];
    parts.extend(forks);
    block(Form::Either(parts))
}

/// Returns the form of lines of one kind.
fn block(line: Form) -> Form {
    line.separated(Form::text("\n"), MOST)
}

/// Returns the calls of the stored plans, indented for this depth.
fn calls(menu: &Menu, depth: usize) -> Form {
    let margin = "    ".repeat(depth);
    let plans = menu.plans.iter();
    Form::texts(plans.map(|plan| format!("{margin}{}()", plan.name)))
}

/// Returns the contents of a branch inside branches on the checks of `outer`: plans, and branches on the other checks.
fn body(menu: &Menu, outer: &[usize]) -> Form {
    let plan = calls(menu, outer.len());
    if outer.len() == DEPTH {
        return block(plan).shared();
    }
    let others = (0..menu.checks.len()).filter(|other| !outer.contains(other));
    let branches = others.map(|other| branch(menu, other, outer));
    block(Form::Either(std::iter::once(plan).chain(branches).collect())).shared()
}

/// Returns the form of a check in one line and the branch on its outcome in the next lines, inside branches on the checks
/// of `outer`.
fn branch(menu: &Menu, index: usize, outer: &[usize]) -> Form {
    let check = &menu.checks[index];
    let margin = "    ".repeat(outer.len());
    let body = body(menu, &[outer, &[index]].concat());
    let mut parts = Vec::new();
    if !check.outcomes.is_empty() {
        parts.push(Form::text(format!("{margin}{}\n", check.script())));
    }
    let conditions = check.conditions();
    parts.extend([heads(&margin, "if", &conditions), body.clone()]);
    // With two outcomes, `else` covers the second.
    if conditions.len() > 2 {
        let elif = vec![Form::text("\n"), heads(&margin, "elif", &conditions), body.clone()];
        parts.push(Form::Row(elif).optional());
    }
    let otherwise = vec![Form::text(format!("\n{margin}else:\n")), body];
    parts.push(Form::Row(otherwise).optional());
    Form::Row(parts)
}

/// Returns the lines that begin a branch, one for each condition.
fn heads(margin: &str, word: &str, conditions: &[String]) -> Form {
    let lines = conditions.iter();
    Form::texts(lines.map(|condition| format!("{margin}{word} {condition}:\n")))
}

/// Returns the form of parallel lanes: each ordered pair of two lanes that have plans.
fn sides(menu: &Menu) -> Form {
    let lanes: Vec<Form> = menu.lanes.iter().map(|lane| lane_form(menu, lane)).collect();
    let all = 0..lanes.len();
    let pairs = all.clone().flat_map(|one| all.clone().map(move |other| (one, other)));
    let pairs = pairs.filter(|(one, other)| one != other);
    let row = |(one, other): (usize, usize)| {
        let head = Form::text("with parallel():");
        Form::Row(vec![head, lanes[one].clone(), lanes[other].clone()])
    };
    Form::Either(pairs.map(row).collect())
}

/// Returns the form of a lane with its plans.
fn lane_form(menu: &Menu, lane: &String) -> Form {
    let head = Form::text(format!("\n    with lane({}):\n", quoted(lane)));
    let fitting = menu.plans.iter().filter(|plan| plan.lane.as_ref() == Some(lane));
    Form::Row(vec![head, orders(&fitting.collect::<Vec<_>>())])
}

/// Returns the possible contents of a lane: a non-empty subset of its plans, in any order.
fn orders<'a>(plans: &[&'a Offered]) -> Form {
    let line = |plan: &Offered| format!("        {}()", plan.name);
    if plans.len() > LISTED {
        return block(Form::texts(plans.iter().map(|plan| line(plan))));
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
            Form::text(lines.join("\n"))
        }));
    }
    Form::Either(all)
}

/// Returns a JSON schema for the answer of a server: the tree of a composition, or a question.
pub(super) fn schema(menu: &Menu) -> Value {
    let plain = |word: &str, things: &[String]| format!("{word}({})", things.join(", "));
    let plans = menu.plans.iter().map(|plan| format!("{}()", plan.name));
    let looks = menu.checks.iter().map(|check| plain(&check.call, &check.things));
    let calls: Vec<String> = plans.chain(looks).collect();
    let conditions = menu.checks.iter().flat_map(|check| {
        if check.outcomes.is_empty() {
            vec![plain(&check.call, &check.things)]
        } else {
            check
                .outcomes
                .iter()
                .map(|(word, things)| plain(word, things))
                .collect()
        }
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
