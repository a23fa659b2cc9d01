//! Domains with sensing actions or actors request plans as trees; others keep lists.

use serde_json::{Value, json};

use super::requests::check_strict;
use crate::dialogue::{EstimatedTokens, Role, broken_parts, direct_request, direct_schema, fixed_parts};
use crate::domain::{Domain, load, shipped, shipped_files};
use crate::environment::World;
use crate::plan::{self, Node};
use longstep_core::testing;

fn larder(domain: &Domain) -> World {
    let text = json!({"assets": ["<bench>", "<scrap_bin>"], "objects": ["<cream>"],
        "object_states": {"<cream>": "on_something(<bench>)"}});
    testing::world_of(domain, &text)
}

fn prompt_and_schema(domain: &Domain) -> String {
    let mut counter = EstimatedTokens::default();
    let request = direct_request(domain, &larder(domain), "Bin it", &[], &[], None, &mut counter);
    let request = request.unwrap().request;
    let texts: Vec<&str> = request.messages.iter().map(|message| message.text.as_str()).collect();
    texts.join("\n") + &direct_schema(&larder(domain)).to_string()
}

/// Returns which of the tree keywords occur in a domain's prompt and schema.
#[track_caller]
fn check(domain: &str, expected: &[&str]) {
    let text = prompt_and_schema(&shipped(domain).unwrap().unwrap());
    let words = [
        "task_tree",
        "task_sequence",
        "\"if\"",
        "\"while\"",
        "\"parallel\"",
        "Tells which is so",
        "Every call names",
    ];
    let found: Vec<&str> = words.into_iter().filter(|word| text.contains(word)).collect();
    assert_eq!(found, expected, "{domain}");
}

#[test]
fn prompt_describes_only_plan_forms_of_the_domain() {
    check("household", &["task_sequence"]);
    let checks = ["task_tree", "\"if\"", "\"while\"", "Tells which is so"];
    check("household-checks", &checks);
    check("household-dual", &["task_tree", "\"parallel\"", "Every call names"]);
}

#[test]
fn the_schema_of_a_tree_is_strict_and_refers_to_nothing_above_it() {
    for name in ["household-checks", "household-dual"] {
        let domain = shipped(name).unwrap().unwrap();
        let schema = direct_schema(&larder(&domain));
        check_strict(&schema);
        let definitions = schema["$defs"].as_object().unwrap();
        for level in 0..=2 {
            let node = definitions[&format!("node{level}")].to_string();
            let upwards = (0..=level).any(|above| node.contains(&format!("node{above}\"")));
            assert!(!upwards, "{node}");
        }
        let branches = definitions["node0"]["anyOf"].as_array().unwrap().len();
        assert_eq!(branches, if name == "household-checks" { 3 } else { 2 });
    }
    let domain = shipped("household-checks").unwrap().unwrap();
    let schema = direct_schema(&larder(&domain));
    let conditions = &schema["$defs"]["asked"]["properties"]["call"]["enum"];
    for expected in ["check_best_by_date()", "expired(<cream>)", "dirty(<bench>)"] {
        assert!(
            conditions.as_array().unwrap().contains(&Value::from(expected)),
            "{expected}: {conditions}"
        );
    }
}

#[test]
fn an_example_branches_and_its_answer_fits_the_schema() {
    let domain = shipped("household-checks").unwrap().unwrap();
    let parts = fixed_parts(&domain).unwrap();
    let answers = parts[4]
        .messages
        .iter()
        .filter(|message| message.role == Role::Assistant);
    let mut branching = 0;
    for answer in answers {
        let value: Value = serde_json::from_str(&answer.text).unwrap();
        let keys: Vec<&String> = value["task_cohesion"].as_object().unwrap().keys().collect();
        assert_eq!(keys, ["task_tree", "object_name", "object_names"]);
        let written = plan::read(&answer.text).unwrap().file.task_cohesion.written().unwrap();
        branching += usize::from(written.body.iter().any(|node| matches!(node, Node::If { .. })));
        assert!(!answer.text.contains("implicit") && !answer.text.contains("remark"));
    }
    assert_eq!(branching, 1);
}

/// Returns the findings for a household with checks whose only example has this script.
#[track_caller]
fn check_script(script: &str, expected: &str) {
    let text = format!(
        "[[example]]\ninstruction = \"Bin the cream if it is past its date\"\nscript = '''\n{script}\n'''\n\
         [example.environment]\nassets = [\"<bench>\", \"<scrap_bin>\"]\nobjects = [\"<cream>\"]\n\
         [example.environment.object_states]\n\"<cream>\" = \"on_something(<bench>)\"\n"
    );
    let mut files = shipped_files("household-checks").unwrap();
    files.overlay("mine/", [("plans.toml".to_owned(), text)]).unwrap();
    let found: Vec<String> = broken_parts(&load(&files).unwrap())
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(found.join("\n"), expected);
}

const TAKE: &str = "move_hand(to=\"<cream>\")\ngrasp_object(item=\"<cream>\")\n\
    detach_from_plane(item=\"<cream>\", from=\"<bench>\")\n";

#[test]
fn a_script_is_verified_where_it_is_an_example() {
    let branch = "if check_best_by_date(item=\"<cream>\"):\n    move_object(to=\"<bench>\")\n    attach_to_plane()\n    release_object()\n\
        else:\n    move_object(to=\"<scrap_bin>\")\n    release_object()";
    check_script(&format!("{TAKE}{branch}"), "");
    check_script(
        &format!("{TAKE}x = 1"),
        "mine/plans.toml:3:10: line 4, column 3: this is an assignment, which no plan has (ask in the condition itself, as \
         in `if not check_date():`)",
    );
}
