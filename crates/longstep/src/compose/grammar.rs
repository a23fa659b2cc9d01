//! What a model may write: a grammar for the script, and a JSON schema for the tree.

use serde_json::{Value, json};

use super::asked::Check;
use super::menu::Menu;
use crate::goal::{QUESTION, quoted};
use crate::prompt::{TreeForms, closed, tree_schema};

/// Plans, branches and the like in one block at most: what is longer is a model that cannot stop.
const MOST: usize = 8;

/// How deep branches may stand in each other.
pub(super) const DEPTH: usize = 2;

/// A grammar in llguidance's Lark dialect for the script of a composition, or a question.
///
/// Every line is written out with its indentation, so that nothing but the stored plans, the checks and the lanes that
/// there are can be said. A check and the branch on what it told are one piece.
pub(super) fn grammar(menu: &Menu) -> String {
    let question = format!("question: {} /[A-Za-z][A-Za-z0-9 ,'-]{{8,120}}\\?/\n", quoted(QUESTION));
    if menu.plans.is_empty() {
        return format!("start: question\n{question}");
    }
    let mut text = format!("start: question | block0\n{question}");
    for depth in 0..=DEPTH {
        let branches = depth < DEPTH && !menu.checks.is_empty();
        let lanes = depth == 0 && !menu.lanes.is_empty();
        let mut items = vec![format!("plan{depth}")];
        items.extend(branches.then(|| format!("branch{depth}")));
        items.extend(lanes.then(|| "sides".to_owned()));
        text.push_str(&format!(
            "block{depth}: item{depth} (\"\\n\" item{depth}){{0,{}}}\nitem{depth}: {}\n",
            MOST - 1,
            items.join(" | ")
        ));
        let margin = "    ".repeat(depth);
        let calls = menu.plans.iter().map(|plan| quoted(&format!("{margin}{}()", plan.name)));
        text.push_str(&format!("plan{depth}: {}\n", any(calls)));
        if branches {
            let heads = menu.checks.iter().map(|check| head(check, &margin));
            let otherwise = quoted(&format!("\n{margin}else:\n"));
            text.push_str(&format!(
                "branch{depth}: head{depth} \":\\n\" block{inner} ({otherwise} block{inner})?\nhead{depth}: {}\n",
                any(heads),
                inner = depth + 1,
            ));
        }
    }
    if !menu.lanes.is_empty() {
        text.push_str(&sides(menu));
    }
    text
}

fn any(alternatives: impl Iterator<Item = String>) -> String {
    alternatives.collect::<Vec<_>>().join("\n  | ")
}

/// The check in one line, and the beginning of the branch on it in the next.
fn head(check: &Check, margin: &str) -> String {
    let lines = conditions(check).into_iter().map(|(before, condition)| {
        let before = before.map_or(String::new(), |call| format!("{margin}{call}\n"));
        (before, format!("{margin}if {condition}"))
    });
    let (before, conditions): (Vec<String>, Vec<String>) = lines.unzip();
    let conditions = conditions.iter().map(|condition| quoted(condition));
    match before[0].is_empty() {
        true => format!("({})", any(conditions)),
        false => format!("{} ({})", quoted(&before[0]), any(conditions)),
    }
}

/// The conditions that a check can decide, each with the call that comes before it.
fn conditions(check: &Check) -> Vec<(Option<String>, String)> {
    let call = script_call(&check.call, &check.things);
    if check.outcomes.is_empty() {
        return vec![(None, call.clone()), (None, format!("not {call}"))];
    }
    let asked = check.outcomes.iter().map(|(word, things)| script_call(word, things));
    asked.map(|condition| (Some(call.clone()), condition)).collect()
}

/// `check_date("spam")`
pub(super) fn script_call(word: &str, things: &[String]) -> String {
    let things: Vec<String> = things.iter().map(|thing| quoted(thing)).collect();
    format!("{word}({})", things.join(", "))
}

fn sides(menu: &Menu) -> String {
    let lane = |lane: &String| {
        let fitting = menu.plans.iter().filter(|plan| plan.lane.as_ref() == Some(lane));
        let calls: Vec<String> = fitting.map(|plan| quoted(&format!("        {}()", plan.name))).collect();
        let line = calls.join(" | ");
        format!(
            "{} ({line}) (\"\\n\" ({line})){{0,{}}}",
            quoted(&format!("\n    with lane({}):\n", quoted(lane))),
            MOST - 1
        )
    };
    let lanes: Vec<String> = menu.lanes.iter().map(lane).collect();
    // Any two of them, in the order of the world.
    let pairs = (0..lanes.len()).flat_map(|one| (one + 1..lanes.len()).map(move |other| (one, other)));
    let pairs = pairs.map(|(one, other)| format!("\"with parallel():\" {} {}", lanes[one], lanes[other]));
    format!("sides: {}\n", any(pairs))
}

/// A JSON schema for a whole answer of a server: the tree of the composition, or a question.
pub(super) fn schema(menu: &Menu) -> Value {
    let plain = |word: &str, things: &[String]| format!("{word}({})", things.join(", "));
    let plans = menu.plans.iter().map(|plan| format!("{}()", plan.name));
    let looks = menu.checks.iter().map(|check| plain(&check.call, &check.things));
    let calls: Vec<String> = plans.chain(looks).collect();
    let asked = menu.checks.iter().flat_map(|check| match check.outcomes.is_empty() {
        true => vec![plain(&check.call, &check.things)],
        false => check.outcomes.iter().map(|(word, things)| plain(word, things)).collect(),
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
