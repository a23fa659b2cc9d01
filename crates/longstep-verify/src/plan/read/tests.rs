//! One-line summaries of replies: the parsed content and the leniencies, or the error.

use super::*;

/// Summarizes the steps, explanations and kinds of leniencies, or the error.
fn summary(reply: &str) -> String {
    match read(reply) {
        Ok(Draft { file, leniencies }) => {
            let cohesion = &file.task_cohesion;
            let texts = [&cohesion.task_sequence[..], &cohesion.step_instructions].concat();
            let kinds: Vec<String> = leniencies
                .iter()
                .map(|leniency| match &leniency.path {
                    Some(path) => format!("{:?}({path})", leniency.kind),
                    None if leniency.times > 1 => format!("{:?}*{}", leniency.kind, leniency.times),
                    None => format!("{:?}", leniency.kind),
                })
                .collect();
            let question = if file.question.is_empty() { "" } else { "? " };
            format!("{question}{} [{}]", texts.join("; "), kinds.join(" "))
        }
        Err(unreadable) => unreadable.to_string(),
    }
}

#[track_caller]
fn check(reply: &str, expected: &str) {
    assert_eq!(summary(reply), expected, "{reply}");
}

/// Checks a plan with a single explanation, written as the literal `text`.
#[track_caller]
fn check_text(text: &str, expected: &str) {
    let reply = format!(r#"{{"task_cohesion": {{"task_sequence": [], "step_instructions": [{text}]}}}}"#);
    check(&reply, expected);
}

const PLAN: &str = r#"{"task_cohesion": {"task_sequence": ["a()", "b()"], "step_instructions": ["A", "B"]}}"#;
const OTHER: &str = r#"{"task_cohesion": {"task_sequence": ["c()"], "step_instructions": ["C"]}}"#;

#[test]
fn strict_json_needs_no_leniency() {
    check(PLAN, "a(); b(); A; B []");
    check(&format!("\n {PLAN} \r\n"), "a(); b(); A; B []");
    check_text(
        r#""\" \\ \/ \b\f\n\r\t \u00e9 \ud83e\udd16 // # /* ' {""#,
        "\" \\ / \u{8}\u{c}\n\r\t é 🤖 // # /* ' { []",
    );
}

#[test]
fn reader_lists_text_and_wrappers_around_the_plan() {
    check(&format!("```json\n{PLAN}\n```"), "a(); b(); A; B [CodeFence*2]");
    check(&format!("```\n{PLAN}"), "a(); b(); A; B [CodeFence]");
    check(
        &format!("Sure, here's it:\n```python\n{PLAN}\n```\nEnjoy!"),
        "a(); b(); A; B [Prose*2 CodeFence*2]",
    );
    check(&format!("plan = {PLAN}"), "a(); b(); A; B [Assignment]");
    check(
        &format!("```python\nimport json\nplan: dict = {PLAN}\n```"),
        "a(); b(); A; B [CodeFence*2 Prose Assignment]",
    );
    check(&format!("\u{feff}{PLAN}"), "a(); b(); A; B [OddSpace]");
    check(&format!("[{PLAN}]"), "a(); b(); A; B [Wrapped([0])]");
    check(
        &format!("The {{object}} is {{}}. {PLAN}"),
        "a(); b(); A; B [Prose*2 OtherObject]",
    );
    check(
        &format!("f'{{x!r}}' {{'a', 'b'}} {{the robot's}}\n{PLAN}"),
        "a(); b(); A; B [Prose]",
    );
    check(&format!("{{'s and\n{PLAN}"), "a(); b(); A; B [Prose]");
    check(
        &format!(r#"{{"environment": {{"assets": [], "objects": ["<question>"]}}}} {PLAN}"#),
        "a(); b(); A; B [OtherObject]",
    );
    check(&format!("{PLAN}\n{PLAN}"), "a(); b(); A; B [RepeatedPlan]");
    check(&format!(r#"{{"output": {PLAN}}}"#), "a(); b(); A; B [Wrapped(output)]");
}

#[test]
fn python_is_read_as_python() {
    check(
        "{'task_cohesion': {'task_sequence': ('a()', 'b()',), 'step_instructions': ('A',), 'x': True}, 'question': None}",
        "a(); b(); A [SingleQuotes*8 Tuple*2 ExtraKey(task_cohesion.x) PythonWord*2 Null(question)]",
    );
}

#[test]
fn reader_accepts_each_style_of_quotation() {
    check_text("'say \"no\"'", "say \"no\" [SingleQuotes]");
    check_text("'the robot's hand'", "the robot's hand [SingleQuotes Apostrophe]");
    check_text(
        "'both robots' hands', 'theirs', are'",
        "line 1, column 95: `are` is not in quotes",
    );
    check_text(r"'the robot\'s hand'", "the robot's hand [SingleQuotes Escape]");
    check_text("'', ''", ";  [SingleQuotes*2]");
    check_text(
        "'a' # it's }\n, 'b' // it's ]\n, /* ' */ 'c'",
        "a; b; c [SingleQuotes*3 Comment*3]",
    );
    check_text("\"\"\"a\n\"b\" 'c'\"\"\"", "a\n\"b\" 'c' [TripleQuotes]");
    check_text("'''a'b''c'''", "a'b''c [TripleQuotes]");
    check_text("'a'\n\"b\" 'c'", "abc [SingleQuotes*2 JoinedTexts*2]");
    check_text("(\"a\"\n\"b\")", "ab [Parentheses JoinedTexts]");
    check_text(
        "“a \"b\"”, ‘the robot’s’",
        "a \"b\"; the robot’s [TypographicQuotes*2 Apostrophe]",
    );
    check_text("\"a\nb\tc\"", "a\nb\tc [RawControl*2]");
    check_text(
        r#""move\_hand \x41 \U0001F916 a\
b""#,
        "move_hand A 🤖 ab [Escape*4]",
    );
    check_text("\"a\",", "a [TrailingComma]");
    check_text("\u{a0}\"a\"", "a [OddSpace]");
}

#[test]
fn keys_are_read_by_their_names() {
    check(
        "{task_cohesion: {task_sequence: []}, }",
        " [UnquotedKey*2 MissingKey(task_cohesion.step_instructions) TrailingComma]",
    );
    check(
        r#"{"task_sequence": ["a()"], "step_instructions": [], "question": ""}"#,
        "a() [Flattened]",
    );
    check(
        r#"{"task_cohesion": {"task_sequence": [], "step_instructions": [], "why": {"a": [1, -0.5e+3]}}, "user_feedback": ""}"#,
        " [ExtraKey(task_cohesion.why) ExtraKey(user_feedback)]",
    );
    check(r#"{"question": "Which cup?"}"#, "?  [MissingKey(task_cohesion)]");
    check(
        r#"{"task_cohesion": null, "environment_after": null, "question": "Which cup?"}"#,
        "?  [Null(task_cohesion) Null(environment_after)]",
    );
    check(
        &PLAN.replace(
            "}}",
            r#"}, "environment_after": {"environment": {"assets": [], "rooms": []}}}"#,
        ),
        "a(); b(); A; B [Wrapped(environment_after.environment) ExtraKey(environment_after.environment.rooms)]",
    );
    check(
        &PLAN.replace("}}", r#"}, "question": "", "question": ""}"#),
        "a(); b(); A; B [RepeatedKey(question)]",
    );
}

#[test]
fn leniencies_are_told_in_the_order_of_the_text() {
    let draft = read("\n{'question': 'Why?',\n 'x': None,}").unwrap();
    let messages: Vec<String> = draft.leniencies.iter().map(Leniency::message).collect();
    let expected = [
        "line 2, column 1: `task_cohesion` is missing and was taken as empty",
        "line 2, column 2: a text stands in single quotes (3 times)",
        "line 3, column 2: `x` is no key of a plan and was ignored",
        "line 3, column 7: a value is written the Python way",
        "line 3, column 12: a comma follows the last item",
    ];
    assert_eq!(messages, expected);
}

#[test]
fn wrong_shapes_are_told_with_path_and_place() {
    let wrong = |text: &str| format!(r#"{{"task_cohesion": {{"task_sequence": {text}, "step_instructions": []}}}}"#);
    check(
        &wrong("[\"a()\",\n 3]"),
        "line 2, column 2: `task_cohesion.task_sequence[1]` should be a text in quotes, but is a number",
    );
    check(
        &wrong("\"a()\""),
        "line 1, column 37: `task_cohesion.task_sequence` should be a list of texts, but is a text",
    );
    check(
        &wrong("null"),
        "line 1, column 37: `task_cohesion.task_sequence` should be a list of steps, but is null",
    );
    check(
        r#"{"task_cohesion": {"step_instructions": []}}"#,
        "line 1, column 19: `task_cohesion.task_sequence` should be a list of steps, but is missing",
    );
    check(
        r#"{"task_cohesion": []}"#,
        "line 1, column 19: `task_cohesion` should be an object, but is a list",
    );
    check(
        &PLAN.replace("}}", r#", "object_name": ["<a>"]}}"#),
        "line 1, column 101: `task_cohesion.object_name` should be a text in quotes, but is a list",
    );
    check(
        &PLAN.replace("}}", r#"}, "environment_after": {"object_states": {"<a>": [true]}}}"#),
        "line 1, column 135: `environment_after.object_states.<a>[0]` should be a text in quotes, but is true or false",
    );
    check(
        &PLAN.replace(
            "}}",
            r#"}, "environment_after": {"object_states": {"<a>": "b", "<a>": ["b"]}}}"#,
        ),
        "line 1, column 139: `environment_after.object_states.<a>` is given again with another value than at line 1, column 127",
    );
    check(
        &PLAN.replace("}}", r#"}, "question": "", "question": "Why?"}"#),
        "line 1, column 103: `question` is given again with another value than at line 1, column 87",
    );
}

#[test]
fn reader_never_completes_a_truncated_reply() {
    let cut = |end: &str| format!("line {end}; the object that begins at line 1, column 1 does not end");
    for text in [
        "\"a",
        "'a",
        "'''a''",
        "[1",
        "{\"a\"",
        "tru",
        "-1",
        "\"\\u00",
        "/* a",
        "// a",
        "\"\\ud83e\\",
        "(",
        "...",
    ] {
        let reply = format!("{{\"task_cohesion\": {text}");
        let summary = summary(&reply);
        let expected = if text == "..." {
            "`...` stands for something that was left out"
        } else {
            "breaks off"
        };
        assert!(summary.contains(expected), "{reply}: {summary}");
    }
    check(&PLAN[..40], &cut("1, column 41: the reply breaks off"));
    check(
        &format!("{}\n```\nSorry.", &PLAN[..39]),
        &cut("1, column 40: the reply breaks off"),
    );
    check(
        &format!("{}\n```\n\"Sorry.\"", &PLAN[..42]),
        &cut("2, column 1: the reply breaks off"),
    );
    assert!(matches!(
        read(&format!("{PLAN}\n{}", &OTHER[..50])),
        Err(Unreadable::CutOff { .. })
    ));
}

#[test]
fn reader_names_the_reason_a_reply_has_no_single_plan() {
    check("", "the text is empty");
    check(" \u{feff}\r\n", "the text is empty");
    check("```json\n```", "the text is empty");
    check(
        "I can't do\n that.",
        "the reply is prose, with no plan in it: \"I can't do that.\"",
    );
    check(
        "Which {object}?",
        "the reply is prose, with no plan in it: \"Which {object}?\"",
    );
    check("[1, 2]", "the reply is prose, with no plan in it: \"[1, 2]\"");
    check(
        r#"See {"python_code": "a()", "question": ""}"#,
        "line 1, column 5: the reply holds an object but no plan",
    );
    check(
        &format!("{PLAN} or {OTHER} or {PLAN}"),
        "the reply holds 3 plans that are not the same, at line 1, column 1 and line 1, column 90",
    );
}

#[test]
fn reader_rejects_a_malformed_object_entirely() {
    check(
        r#"{"a" 1, "task_cohesion": {"task_sequence": [], "step_instructions": []}}"#,
        "line 1, column 6: expected `:` after the key",
    );
    check(
        r#"{ , "task_cohesion": {"task_sequence": [], "step_instructions": []}}"#,
        "line 1, column 3: expected a key, found `,`",
    );
    check(
        r#"{"task_cohesion" {"task_sequence": []}}"#,
        "line 1, column 18: expected `:` after the key",
    );
    check(
        &PLAN.replace("\"a()\"", "a()"),
        "line 1, column 38: `a` is not in quotes",
    );
    check(
        &PLAN.replace("\"a()\"", "\"say \"a\"\""),
        "line 1, column 44: expected `,` or `]`, found `a`",
    );
    check(
        &PLAN.replace("\"a()\",", "\"a()\",,"),
        "line 1, column 44: expected a value, found `,`",
    );
    check(
        &PLAN.replace("\"a()\"", "012"),
        "line 1, column 38: `012` is not a number",
    );
    check(
        &PLAN.replace("\"a()\"", "..."),
        "line 1, column 38: `...` stands for something that was left out",
    );
    check_text(r#""\d""#, "line 1, column 64: `\\d` is no escape");
    check_text(
        r#""\ud83e""#,
        "line 1, column 70: half a character: a second `\\u` must follow",
    );
    check_text(r#""\udc00""#, "line 1, column 70: `\\u` names no character");
}

#[test]
fn hostile_texts_are_refused_in_time() {
    // A single quadratic scan among these would take minutes.
    check(
        &" ".repeat((1 << 20) + 1),
        "the reply has 1048577 bytes; at most 1048576 are read",
    );
    let nested = format!(r#"{{"task_cohesion": {}"#, "[".repeat(150));
    check(&nested, "line 1, column 138: brackets are nested more than 120 deep");
    for part in [
        "{",
        "'",
        "{'",
        "{\"",
        "{a:",
        "{a:'",
        "{a:'b}",
        "{a:'} ",
        "{'''",
        "{#",
        "{a:1}",
        "{\u{feff}",
        "```",
        "/*{",
        "{a:\"\\",
        "{}\n",
        "{a ",
        "x=",
        "'\n",
        "{a:'' ",
        "{a:[],",
        "- ",
        "- a: ",
        "- a: {",
        "- - ",
        "- [",
        "a:\n- ",
        "- &a b\n",
        "? a\n",
        "1. a: ",
        "1. a((: ",
        "1. a(\n",
        "| a( |",
        "[A] <a> (",
        "```\na(\n```\n",
        "```\n- a(\n```\n",
        "<think>",
        "<think></think>",
        "</think>",
        "<think></think></think>",
    ] {
        let times = (1 << 18) / part.len();
        for end in ["", " @", "}", "'", "' @"] {
            let text = format!("{}{end}", part.repeat(times - 2));
            assert!(read(&text).is_err());
            let inside = format!("{{\"task_cohesion\": \"{}{end}", part.repeat(times - 12));
            assert!(read(&inside).is_err());
        }
    }
    let extra: String = (0..60_000).map(|n| format!("\"{n}\": 0,")).collect();
    let reply = PLAN.replacen('{', &format!("{{{extra}"), 1);
    assert_eq!(read(&reply).unwrap().leniencies.len(), 60_000);
}

#[test]
fn trees_and_scripts_are_found_in_replies() {
    // A sequential plan becomes a list of steps in every notation.
    check(r#"{"python_script": "a() # A\nb() # B"}"#, "a(); b(); A; B []");
    check("a() # A\nb() # B", "a(); b(); A; B []");
    check(
        "Sure:\n```python\n# now\na() # A\n```\nDone.",
        "a(); A [Prose*2 CodeFence*2 Comment]",
    );
    check(r#"{"python_script": "a() # A\n    b() # B\n  "}"#, "a(); b(); A; B []");
    let tree = |reply: &str| {
        let draft = read(reply).unwrap();
        (
            super::super::script::write(&draft.file.task_cohesion.task_tree.unwrap()),
            draft.leniencies.len(),
        )
    };
    let branch = ("if a():\n    b()\n".to_owned(), 0);
    assert_eq!(tree("if a():\n  b()\n"), branch);
    assert_eq!(tree(r#"{"python_script": "\n    if a():\n        b()\n    "}"#), branch);
    assert_eq!(
        tree(r#"{"task_cohesion": {"task_tree": [{"if": {"call": "a()"}, "then": [{"call": "b()"}]}]}}"#),
        branch
    );
    assert_eq!(
        tree("{'task_tree': ({'if': {'call': 'a()'}, 'then': [{'call': 'b()'}]},)}").0,
        branch.0
    );
    for (reply, message) in [
        (
            "```python\na()\n",
            "line 3, column 1: the reply breaks off; the object that begins at line 1, column 1 does not end",
        ),
        (
            "```\na()\n```\nor\n```\nb()\n```",
            "the reply holds 2 plans that are not the same, at line 2, column 1 and line 6, column 1",
        ),
        (
            "Look:\n```python\nx = a()\n```",
            "line 3, column 3: this is an assignment, which no plan has",
        ),
        (
            r#"{"python_script": "a()\nx = 1"}"#,
            "line 1, column 19: in `python_script`, line 2, column 3: this is an assignment, which no plan has",
        ),
        (
            r#"{"task_cohesion": {"task_tree": [{"if": {"call": "a()"}, "do": []}]}}"#,
            "line 1, column 33: `task_cohesion.task_tree[0]` has no `then`",
        ),
        (
            r#"{"task_cohesion": {"task_tree": [], "task_sequence": ["a()"]}}"#,
            "line 1, column 54: `task_cohesion.task_sequence` should be left out beside `task_tree`, but is a list",
        ),
        (
            "If you like, I can do it:",
            "the reply is prose, with no plan in it: \"If you like, I can do it:\"",
        ),
    ] {
        assert_eq!(read(reply).unwrap_err().to_string(), message, "{reply}");
    }
}

/// Steps in every notation other than the paper's, with the notation that is named.
#[test]
fn reader_names_the_notation_of_each_plan() {
    const STEPS: &str = "Walk(<desk>); Put(<pen>, <desk>)";
    for (notation, texts) in [
        (
            "a numbered list",
            &[
                "1. Walk(<desk>)\n2. Put(<pen>, <desk>)",
                "Here is the plan:\n\n1) **Walk(<desk>)** - go there\n\n2) `Put(<pen>, <desk>)`: put it down\n\nEnjoy!",
                "Step 1: Walk(<desk>)\nStep 2: Put(<pen>, <desk>).",
                "**Step 1:** Walk(<desk>)\n   go there\n**Step 2:** Put(<pen>, <desk>)",
                "1. Go to the desk: `Walk(<desk>)`\n2. Put the pen there \u{2013} Put(<pen>, <desk>)",
                "(1) Walk(\"<desk>\")\n(2) Put('<pen>', '<desk>')",
            ][..],
        ),
        (
            "a list of calls",
            &[
                "- Walk(<desk>)\n- Put(<pen>, <desk>) # there",
                "* `Walk(<desk>)`\n* `Put(<pen>, <desk>)`",
                "- [ ] Walk(<desk>)\n- [x] Put(<pen>, <desk>)",
            ],
        ),
        (
            "calls on lines of their own",
            &[
                "Plan:\nWalk(<desk>)\nPut(<pen>, <desk>)",
                "Walk(<desk>) -> Put(<pen>, <desk>)",
                "[Walk(<desk>), Put(<pen>, <desk>)]",
                "```\n[Walk(<desk>); Put(<pen>, <desk>)]\n```",
                "Thought: the desk is far.\nAction: Walk(<desk>)\nObservation: there.\nAction: Put(<pen>, <desk>)",
            ],
        ),
        (
            "a Markdown table",
            &[
                "| # | call | why |\n|---|:---|---|\n| 1 | Walk(<desk>) | to be there |\n| 2 | `Put(<pen>, <desk>)` | |",
            ],
        ),
        (
            "a VirtualHome script",
            &[
                "[WALK] <desk>\n[PUT] <pen> <desk>",
                "Tidy up\nPut the pen away.\n\n\n[WALK] <desk>\n[Put] <pen> <desk> [0]",
            ],
        ),
        (
            "a list of steps",
            &[
                r#"["Walk(<desk>)", "Put(<pen>, <desk>)"]"#,
                r#"plan = [("Walk", "<desk>"), ("Put", "<pen>", "<desk>")]"#,
                r#"{"steps": ["1. Walk(<desk>)", "2. Put(<pen>, <desk>)"], "note": "- Fly(<desk>)"}"#,
                r#"{"plan": [{"action": "Walk", "args": ["<desk>"]}, {"action": "Put", "args": ["<pen>", "<desk>"]}]}"#,
                r#"{"result": {"plan": [{"step": 1, "call": "Walk(<desk>)"}, {"step": 2, "call": "Put(<pen>, <desk>)"}]}}"#,
                r#"{"plan": [{"Walk": "<desk>"}, {"Put": ["<pen>", "<desk>"]}]}"#,
                r#"{"plan": ["(Walk <desk>)", "(Put <pen> <desk>)"]}"#,
                r#"{"plan": ["[WALK] <desk>", "[PUT] <pen> <desk>"], "environment": {"assets": [], "objects": ["a()"]}}"#
                    .replace("WALK", "Walk").replace("PUT", "Put").leak(),
                r#"{"name": "run", "arguments": "{\"plan\": [\"Walk(<desk>)\", \"Put(<pen>, <desk>)\"]}"}"#,
            ],
        ),
        (
            "objects of one step each",
            &[
                "{\"call\": \"Walk(<desk>)\"}\n{\"call\": \"Put(<pen>, <desk>)\"}",
                r#"<tool_call>{"name": "Walk", "arguments": ["<desk>"]}</tool_call>
<tool_call>{"name": "Put", "arguments": ["<pen>", "<desk>"]}</tool_call>"#,
            ],
        ),
        (
            "YAML",
            &[
                "```yaml\nplan:\n  - call: Walk(<desk>)\n    why: far\n  - call: Put(<pen>, <desk>)\n```",
                "---\nsteps:\n- call: Walk(<desk>)\n- call: Put(<pen>, <desk>)\n---\n",
                "steps:\n- Walk: <desk>\n- Put: [<pen>, <desk>]\n",
                "task_cohesion:\n  task_sequence:\n  - Walk(<desk>)\n  - Put(<pen>, <desk>)\n  step_instructions: []\nquestion: \"\"",
            ],
        ),
    ] {
        for text in texts {
            let draft = read(text).unwrap_or_else(|error| panic!("{text}: {error}"));
            let written = draft.file.task_cohesion.written().unwrap();
            let calls: Vec<String> = written.steps.iter().map(|step| step.call.to_string()).collect();
            let upper = calls.join("; ").replace("WALK", "Walk").replace("PUT", "Put");
            assert_eq!(upper, STEPS, "{text}");
            let named = draft.leniencies.iter().find_map(|leniency| match leniency.kind {
                LeniencyKind::Notation(name) => Some(name),
                _ => None,
            });
            let is_yaml = notation == "YAML" && text.contains("- Walk(");
            assert!(named == Some(notation) || is_yaml, "{text}: {named:?}");
        }
    }
}

#[test]
fn tool_calls_have_a_plan_or_steps_in_their_arguments() {
    let inner = r#"{\"task_cohesion\": {\"task_sequence\": [\"a()\"]}}"#;
    check(
        &format!(
            r#"{{"choices": [{{"message": {{"content": null, "tool_calls": [{{"type": "function", "function": {{"name": "plan", "arguments": "{inner}"}}}}]}}}}]}}"#
        ),
        "a() [Wrapped(choices[0].message.tool_calls[0].function.arguments)]",
    );
    let named = |reply: &str| {
        let draft = read(reply).unwrap_or_else(|error| panic!("{reply}: {error}"));
        let written = draft.file.task_cohesion.written().unwrap();
        let step = |step: &WrittenStep| format!("{} {:?}", step.call, step.implicit);
        written.steps.iter().map(step).collect::<Vec<_>>().join("; ")
    };
    for reply in [
        r#"{"message": {"tool_calls": [{"function": {"name": "Grab", "arguments": {"item": "cup"}}}, {"function": {"name": "Open", "arguments": "{\"thing\": \"box\"}"}}]}}"#,
        r#"{"content": [{"type": "text", "text": "Now."}, {"type": "tool_use", "id": "1", "name": "Grab", "input": {"item": "cup"}}, {"type": "tool_use", "id": "2", "name": "Open", "input": {"thing": "box"}}]}"#,
        r#"{"candidates": [{"content": {"parts": [{"functionCall": {"name": "Grab", "args": {"item": "cup"}}}, {"functionCall": {"name": "Open", "args": {"thing": "box"}}}]}}]}"#,
        r#"[{"action": "Grab", "item": "cup", "reason": "first"}, {"action": "Open", "thing": "box"}]"#,
        "[Grab(item=\"cup\"), Open(thing=\"box\")]",
    ] {
        let expected = "Grab() [(\"item\", \"cup\")]; Open() [(\"thing\", \"box\")]";
        assert_eq!(named(reply), expected, "{reply}");
    }
}

#[test]
fn steps_that_no_tree_can_have_are_refused() {
    // A step with a parameter's name needs a tree, and so all steps of its plan must be able to stand in one.
    for (bad, fault) in [
        ("if(<cup>)", "has a name that no script can write"),
        ("Open(<b\u{0}x>)", "has an argument that is no name"),
    ] {
        let message = format!("line 1, column 1: a step of this plan, `{bad}`, {fault}");
        check(&format!("1. {bad}\n2. Grab(item = cup)"), &message);
        check(&format!("1. Grab(item = cup)\n2. {bad}"), &message);
    }
}

#[test]
fn virtualhome_entities_have_the_numbers_of_their_nodes() {
    for line in [
        "[GRAB] <soap> (1.1002)",
        "[GRAB] <soap> (1002) [0]",
        "<char0> [GRAB] <soap> (1002)",
    ] {
        check(line, "GRAB(<soap_1002>) [Notation(\"a VirtualHome script\")]");
    }
    check(
        "<char0> [walk] <pot> (3)\n<char1> [walk] <pot> (3)",
        "line 2, column 1: this line is for another character, and a plan is read for one",
    );
    check(
        "[WALK] <pot> (3)\n[GRAB] <pot> (x)",
        "line 2, column 1: this is no step, unlike what is listed beside it: \"[GRAB] <pot> (x)\"",
    );
}

#[test]
fn reader_finds_plans_inside_string_values() {
    check(&format!("{PLAN:?}"), "a(); b(); A; B [Quoted]");
    check(
        &format!("{:?}", "1. a()\n2. b()"),
        "a(); b() [Notation(\"a numbered list\") Quoted]",
    );
    check(
        r#"{"message": {"content": "1. a()\n2. b()"}}"#,
        "a(); b() [Wrapped(message.content) Notation(\"a numbered list\")]",
    );
    check(
        r#"{"message": {"content": "{\"task_sequence\": [\"a()"}}"#,
        "line 1, column 25: in `message.content`, line 1, column 24: the reply breaks off; the object that begins at line 1, column 1 does not end",
    );
}

#[test]
fn reader_skips_the_thoughts_of_a_model() {
    check(&format!("<think>{OTHER}</think>\n{PLAN}"), "a(); b(); A; B [Thoughts]");
    check(&format!("So {OTHER}?</think>{PLAN}"), "a(); b(); A; B [Thoughts]");
    check(
        &format!("<|channel|>analysis<|message|>{OTHER}<|end|><|channel|>final<|message|>{PLAN}"),
        "a(); b(); A; B [Thoughts]",
    );
    check(&format!("<think></think>{PLAN}"), "a(); b(); A; B [Thoughts]");
    check(
        &format!("<think>{PLAN}"),
        "the reply has thoughts only, and no answer behind them",
    );
}

#[test]
fn reader_rejects_replies_with_two_readings() {
    check(
        "1. Open(<box>)\n2. Grab(<cup>)\n```json\n{\"plan\": [\"Grab(<cup>)\"]}\n```",
        "the reply can be read in two ways that are not the same: as JSON at line 4, column 1, and as a list of calls at line 1, column 1",
    );
    check(
        "1. Grab(<cup>)\n\n1. Open(<box>)\n2. Grab(<cup>)",
        "the reply holds 2 plans that are not the same, at line 1, column 1 and line 3, column 1",
    );
    check(
        "1. Open(<box>)\n2. take the cup\n3. Close(<box>)",
        "line 2, column 1: this is no step, unlike what is listed beside it: \"2. take the cup\"",
    );
    check(
        "```\n1. Open(<box>)\n2. Gra",
        "line 3, column 1: this is no step, unlike what is listed beside it: \"2. Gra\"",
    );
    check(
        "```\n1. Open(<box>)\n",
        "line 3, column 1: the reply breaks off; the object that begins at line 1, column 1 does not end",
    );
    // Goals, states and remarks are no steps.
    for text in [
        r#"{"goals": ["put(<cup>, <desk>)"]}"#,
        r#"{"environment": {"object_states": {"<cup>": ["on(<desk>)"]}, "objects": ["<cup>"]}}"#,
        "Open(<box>) is needed first.",
        "The plan `Grab(<cup>)` fails.",
        "- Never: Open(<box>)",
        "a: &a [\"Open(<box>)\"]\nplan: *a",
    ] {
        assert!(read(text).is_err(), "{text}");
    }
    check(
        "<plan><step>Grab</step></plan>",
        "this is XML, which is not read as a plan",
    );
}

/// Nothing that may be a step is left out without a word.
#[test]
fn reader_never_drops_a_step_silently() {
    const WHOLE: &str = "Walk(<desk>); Grab(<pen>)";
    let steps = |reply: &str| read(reply).map(|draft| draft.file.task_cohesion.task_sequence.join("; "));
    for end in [
        "<|im_end|>",
        "<|return|>",
        "</s>",
        "</answer>",
        "!",
        " \u{2705}",
        ".",
        "<br>",
        " (done)",
        " # now",
    ] {
        for (begin, mark) in [("Sure! Here it is:\n\n", ""), ("", "- "), ("", "1. "), ("> ", "")] {
            let reply = format!("{begin}{mark}Walk(<desk>)\n{}Grab(<pen>){end}", mark.replace('1', "2"));
            assert_eq!(steps(&reply).as_deref(), Ok(WHOLE), "{reply}");
        }
    }
    for (reply, error) in [
        (
            "Sure!\nWalk(<desk>)\nGrab(<pe",
            "line 3, column 1: `Grab(<pe` stands outside of the steps",
        ),
        (
            "So:\nWalk(<desk>)\nThen Grab(<pen>)",
            "line 3, column 6: `Grab(<pen>)` stands outside",
        ),
        ("So:\nWalk(<desk>)\nClose <desk>", "line 3, column 1: this is no step"),
        ("So:\nWalk(<desk>)\n... and so on", "line 3, column 1: this is no step"),
        (
            "Walk('<desk>')\n# ... as before\nGrab('<pen>')",
            "line 2, column 1: this is no step",
        ),
        (
            "- Walk(<desk>) (and then Grab(<pen>))\n- Grab(<pen>)\n\nWait, the second is Grab(<cup>).",
            "line 4, column 21: `Grab(<cup>)`",
        ),
        (
            "1. Walk(<desk>)\n2. Grab(<pen>) - no, rather Grab(<cup>)",
            "line 1, column 1: `Grab(<cup>)`",
        ),
        (
            "Plan A:\n- Walk(<desk>)\n- Grab(<pen>)\n\nPlan B:\n- Grab(<cup>)",
            "the reply holds 2 plans",
        ),
        (
            "plan:\n- Walk(<desk>)\n---\nplan:\n- Grab(<pen>)",
            "the reply holds 2 plans",
        ),
        (r#"{"plan": ["a()"], "next_steps": ["b()"]}"#, "the reply holds 2 plans"),
        (
            r#"{"rejected_plan": ["a()"]}"#,
            "line 1, column 1: the reply holds an object but no plan",
        ),
        (
            r#"{"choices": [{"finish_reason": "length", "message": {"content": "1. a()\n2. b()"}}]}"#,
            "line 1, column 32: the server says",
        ),
        (
            r#"[{"action": "a", "args": [], "enabled": false}]"#,
            "line 1, column 41: `enabled` changes",
        ),
        (
            r#"[{"action": "a", "args": [], "repeat": 3}]"#,
            "line 1, column 40: `repeat` changes",
        ),
        (
            r#"[{"call": "a()", "after": ["b()"]}]"#,
            "line 1, column 27: there are steps in a step",
        ),
        (
            r#"[{"step": 2, "call": "a()"}, {"step": 1, "call": "b()"}]"#,
            "line 1, column 39: `step` is 1",
        ),
        (
            "Action: Walk\nAction Input: desk\nAction: Grab",
            "line 3, column 1: this is no step",
        ),
        (
            "action,object\nWalk,desk\nGrab,pen,now",
            "line 3, column 1: this is no step",
        ),
        (
            "<tool_call>{\"name\": \"a\", \"arguments\": {}}</tool_call>\n<tool_call>{\"na",
            "line 2, column 16: the reply breaks off",
        ),
    ] {
        let message = read(reply).unwrap_err().to_string();
        assert!(message.starts_with(error), "{reply}: {message}");
    }
    // Calls that the plan has, and words with an ending in brackets, may stand around it.
    for around in ["I go there, so that Grab(<pen>) works.", "These are my step(s):"] {
        assert_eq!(
            steps(&format!("{around}\n- Walk(<desk>)\n- Grab(<pen>)")).as_deref(),
            Ok(WHOLE)
        );
        assert_eq!(
            steps(&format!("- Walk(<desk>)\n- Grab(<pen>)\n\n{around}")).as_deref(),
            Ok(WHOLE)
        );
    }
    for reply in [
        "Reach it:\nWalk(<desk>)\nTake it:\nGrab(<pen>)",
        "robot.Walk(<desk>)\nrobot.Grab(<pen>)",
        "Voici le plan : Walk(<desk>) \u{2192} Grab(<pen>). C'est tout.",
        "<plan>\n<step>Walk(<desk>)</step>\n<step n=\"2\">Grab(<pen>)</step>\n</plan>",
        "[TOOL_CALLS] [{\"name\": \"Walk\", \"arguments\": [\"<desk>\"]}, {\"name\": \"Grab\", \"arguments\": [\"<pen>\"]}]</s>",
        "Thought: far.\nAction: Walk\nAction Input: <desk>\nObservation: ok\nAction: Grab\nAction Input: [\"<pen>\"]\nFinal Answer: done.",
        "| Step | Action | Object | Reason |\n|---|---|---|---|\n| 1 | Walk | <desk> | far |\n| 2 | Grab | <pen> | |",
        "```csv\nstep,action,object\n1,Walk,<desk>\n2,Grab,<pen>\n```",
        r#"{"step_1": "Walk(<desk>)", "step_2": "Grab(<pen>)"}"#,
        r#"{"taskPlan": {"actionSequence": [{"actionName": "Walk", "actionParameters": ["<desk>"]}, {"actionName": "Grab", "actionParameters": ["<pen>"], "repeat": 1}]}}"#,
    ] {
        assert_eq!(steps(reply).as_deref(), Ok(WHOLE), "{reply}");
    }
}
