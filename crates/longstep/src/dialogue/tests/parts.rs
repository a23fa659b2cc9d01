//! The fixed parts: complete, replaceable, and checked.

use crate::dialogue::{Message, PartName, PromptError, Role, broken_parts, fixed_parts};
use crate::domain::{Domain, Files, load, shipped, shipped_files, shipped_names, starter};
use crate::plan;

fn household(file: &str, text: &str) -> Domain {
    let mut files = shipped_files("household").unwrap();
    files.overlay("mine/", [(file.to_owned(), text.to_owned())]).unwrap();
    load(&files).unwrap()
}

/// Compares the findings for a household with this text in `file` of `prompt/`.
#[track_caller]
fn check(file: &str, text: &str, expected: &str) {
    let domain = household(file, text);
    let found: Vec<String> = broken_parts(&domain).iter().map(ToString::to_string).collect();
    assert_eq!(found.join("\n"), expected);
    if !expected.is_empty() && file != "query.md" {
        assert!(matches!(fixed_parts(&domain), Err(PromptError::Broken(_))));
    }
}

#[test]
fn shipped_domains_have_all_prompt_parts() {
    for name in shipped_names() {
        let domain = shipped(name).unwrap().unwrap();
        let parts = fixed_parts(&domain).unwrap();
        let names: Vec<PartName> = parts.iter().map(|part| part.name).collect();
        assert_eq!(names, PartName::ALL);
        let messages: Vec<&Message> = parts.iter().flat_map(|part| &part.messages).collect();
        assert_eq!(messages[0].role, Role::System);
        for pair in messages[1..].chunks(2) {
            assert_eq!((pair[0].role, pair[1].role), (Role::User, Role::Assistant));
        }
        assert!((6..=10).contains(&parts[4].messages.len()), "three to five examples");
        assert_eq!(fixed_parts(&domain).unwrap(), parts, "the same every time");
    }
}

#[test]
fn prompt_describes_actions_states_and_rules_of_the_domain() {
    let domain = shipped("virtualhome").unwrap().unwrap();
    let parts = fixed_parts(&domain).unwrap();
    let actions = &parts[1].messages[0].text;
    for action in &domain.actions {
        assert_eq!(
            actions.matches(&format!("\n- {}(", action.call)).count(),
            1,
            "{}",
            action.call
        );
        assert!(actions.contains(&action.means));
    }
    let environment = &parts[2].messages[0].text;
    for state in &domain.states {
        assert!(environment.contains(&state.means));
    }
    assert!(
        parts[3].messages[0]
            .text
            .contains("must be closed again after something was put into it")
    );
}

#[test]
fn example_answers_in_prompts_can_be_read() {
    for name in shipped_names() {
        let domain = shipped(name).unwrap().unwrap();
        let parts = fixed_parts(&domain).unwrap();
        let answers = parts[4]
            .messages
            .iter()
            .filter(|message| message.role == Role::Assistant);
        let mut questions = 0;
        for answer in answers {
            let draft = plan::read(&answer.text).unwrap();
            questions += usize::from(!draft.file.question.is_empty());
            let steps = &draft.file.task_cohesion;
            let written = steps.written().unwrap();
            assert_eq!(written.steps.is_empty(), !draft.file.question.is_empty());
            assert!(written.steps.iter().all(|step| !step.explanation.is_empty()));
        }
        assert_eq!(questions, 1);
    }
}

#[test]
fn custom_prompt_file_replaces_only_its_own_part() {
    let domain = household("role.md", "You work for {{ name }}.");
    let (ours, theirs) = (
        fixed_parts(&domain).unwrap(),
        fixed_parts(&shipped("household").unwrap().unwrap()).unwrap(),
    );
    assert_eq!(ours[0].messages[0].text, "You work for household.");
    assert_eq!(ours[1..], theirs[1..]);
}

#[test]
fn broken_templates_are_told_with_file_and_line() {
    check("role.md", "You are {{ name }}.", "");
    check(
        "role.md",
        "You are\n{{ nobody }}.",
        "mine/role.md:2:1: `nobody` is undefined",
    );
    check(
        "format.md",
        "a\n\n{% for %}",
        "mine/format.md:3:1: unexpected end of block, expected in",
    );
    check(
        "query.md",
        "{{ environment }} {{ instructon }}",
        "mine/query.md:1:1: `instructon` is undefined",
    );
    check(
        "query.md",
        "Do this: {{ instruction }}",
        "mine/query.md: the query does not show `environment`\n  hint: write `{{environment}}` where it belongs",
    );
}

const SCENE: &str = "[example.environment]\nassets = [\"<sill>\", \"<crate>\"]\nobjects = [\"<pear>\"]\n\
                     [example.environment.object_states]\n\"<pear>\" = \"on_something(<sill>)\"\n";

#[test]
fn prompt_example_errors_name_file_and_line() {
    let example = |more: &str| format!("[[example]]\ninstruction = \"Move the pear\"\n{more}\n{SCENE}");
    check("plans.toml", "", "");
    check("plans.toml", &example("goal = \"put(pear, crate)\""), "");
    check("plans.toml", &example("question = \"Where to?\""), "");
    check(
        "plans.toml",
        &example(""),
        "mine/plans.toml:2:15: an example has one of `goal`, `script`, `reply` and `question`",
    );
    check(
        "plans.toml",
        &example("goal = \"put(pear, basin)\""),
        "mine/plans.toml:3:8: `basin` in `put(pear, basin)` is nothing in the environment",
    );
    check(
        "plans.toml",
        &example("goal = \"put(pear, sill)\""),
        "mine/plans.toml:3:8: the goal of this example holds already",
    );
    check(
        "plans.toml",
        &example("gaol = \"put(pear, sill)\""),
        "mine/plans.toml:3:1: unknown field `gaol`, expected one of `instruction`, `environment`, `goal`, `script`, `reply`, \
         `question`, `summary`",
    );
    let pear = "move_hand(), grasp_object(), detach_from_plane(), move_object(), attach_to_plane()";
    let reply = |calls: &str| {
        let calls: Vec<String> = calls.split(", ").map(|call| format!("\"{call}\"")).collect();
        let after =
            r#"{"assets": [], "objects": ["<pear>"], "object_states": {"<pear>": "inside_something(<crate>)"}}"#;
        example(&format!(
            "reply = '''{{\"task_cohesion\": {{\"task_sequence\": [{}], \"step_instructions\": [], \
             \"object_name\": \"<pear>\"}}, \"environment_after\": {after}}}'''",
            calls.join(", ")
        ))
    };
    check("plans.toml", &reply(&format!("{pear}, release_object()")), "");
    check(
        "plans.toml",
        &reply(pear),
        "mine/plans.toml:3:9: at the end: the pear must be released",
    );
}

#[test]
fn starter_domain_has_valid_prompt_parts() {
    let domain = load(&Files::from_texts("porter/", starter("porter"))).unwrap();
    assert_eq!(broken_parts(&domain), []);
}

#[test]
fn domain_load_rejects_unknown_prompt_files() {
    let mut files = shipped_files("household").unwrap();
    files.parts.insert("roles.md".to_owned(), String::new());
    let findings = load(&files).unwrap_err().to_string();
    assert_eq!(
        findings,
        "domains/household/prompt/roles.md: nothing reads a file `roles.md`\n  hint: did you mean `role.md`?"
    );
}
