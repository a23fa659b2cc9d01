use super::*;
use longstep::domain::{load, shipped_files, shipped_names, starter};
use longstep_core::testing;

fn starter_files() -> Files {
    Files::from_texts("", starter("porter"))
}

fn greenhouse_files() -> Files {
    let plans = include_str!("../../../../examples/greenhouse/prompt/plans.toml");
    Files {
        pddl: include_str!("../../../../examples/greenhouse/domain.pddl").to_owned(),
        words: include_str!("../../../../examples/greenhouse/domain.toml").to_owned(),
        goal_prompt: include_str!("../../../../examples/greenhouse/prompt/goal.md").to_owned(),
        examples: include_str!("../../../../examples/greenhouse/prompt/examples.toml").to_owned(),
        parts: [("plans.toml".to_owned(), plans.to_owned())].into(),
        feedback: include_str!("../../../../examples/greenhouse/prompt/feedback.toml").to_owned(),
        ..Files::default()
    }
}

/// A change to a file of the starter domain: file, old text, new text.
type Change = (&'static str, &'static str, String);

fn pddl(from: &'static str, to: &str) -> Change {
    ("domain.pddl", from, to.to_owned())
}

fn toml(from: &'static str, to: &str) -> Change {
    ("domain.toml", from, to.to_owned())
}

/// Compares the findings for the changed starter domain: position, lint, names.
#[track_caller]
fn check(changes: impl IntoIterator<Item = Change>, expected: &[&str]) {
    let mut files = starter_files();
    // The examples of plans and of feedback are valid only for the unchanged domain.
    files.parts.clear();
    files.feedback.clear();
    for (file, from, to) in changes {
        let text = match file {
            "domain.pddl" => &mut files.pddl,
            "domain.toml" => &mut files.words,
            _ => &mut files.examples,
        };
        assert!(text.contains(from), "{file} has no `{from}`");
        *text = text.replacen(from, &to, 1);
    }
    let domain = load(&files).unwrap_or_else(|findings| panic!("{findings}"));
    let found = lint(&domain, &files);
    let short = |finding: &Finding| {
        let Diagnostic { file, position, .. } = &finding.diagnostic;
        let place = position.unwrap();
        let (lint, of) = (finding.lint.name(), finding.of.join(" "));
        format!("{file}:{}:{} {lint} {of}", place.line, place.column)
    };
    let shown: Vec<String> = found.iter().map(ToString::to_string).collect();
    let found: Vec<String> = found.iter().map(short).collect();
    assert_eq!(found, expected, "\n{}", shown.join("\n"));
}

/// Adds the fact `winged` and an action with this precondition and effect.
fn fly(rest: &str) -> [Change; 3] {
    [
        pddl(
            "(robot-at ?station - station)\n",
            "(robot-at ?station - station) (winged)\n",
        ),
        pddl(
            "(:action drive",
            &format!("(:action fly :parameters (?to - station)\n{rest})\n(:action drive"),
        ),
        toml(
            "[[rule]]",
            r#"
[[predicate]]
name = "winged"
says = "the robot has wings"
denies = "the robot has no wings"

[[action]]
name = "fly"
call = "fly(?to)"
says = "fly to {to}"
means = "Fly to a station."

[[rule]]"#,
        ),
    ]
}

/// Adds a fact about parcels with this state word; `more` extends its vocabulary entry.
fn heavy(word: &str, more: &str) -> [Change; 2] {
    let text = r#"
[[predicate]]
name = "heavy"
says = "{parcel} is heavy"
denies = "{parcel} is light"
MORE

[[state]]
word = "WORD"
fact = "(heavy ?self)"
means = "It weighs much."

[[rule]]"#;
    [
        pddl(
            "(carrying ?parcel - parcel))\n",
            "(carrying ?parcel - parcel) (heavy ?parcel - parcel))\n",
        ),
        toml("[[rule]]", &text.replace("WORD", word).replace("MORE", more)),
    ]
}

/// Changes the condition of the starter's goal.
fn goal(condition: &str) -> Change {
    let text = format!("condition = \"{condition}\"\nsubject");
    toml("condition = \"(at ?parcel ?station)\"\nsubject", &text)
}

/// Adds a goal.
fn another_goal(form: &str, parameters: &str, condition: &str) -> Change {
    let text = format!(
        "[[goal]]\nform = \"{form}\"\nparameters = \"{parameters}\"\ncondition = \"{condition}\"\n\
         says = \"this is so: {form}\"\nmeans = \"another wish\"\n\n# Everyday names"
    );
    toml("# Everyday names", &text)
}

#[test]
fn our_own_domains_are_clean() {
    let shipped = shipped_names().into_iter().filter_map(shipped_files);
    for files in shipped.chain([greenhouse_files(), starter_files()]) {
        let domain = load(&files).unwrap_or_else(|findings| panic!("{findings}"));
        let found: Vec<String> = lint(&domain, &files).iter().map(ToString::to_string).collect();
        assert_eq!(found, Vec::<String>::new());
    }
}

#[test]
fn every_lint_is_in_the_documentation() {
    let documentation = include_str!("../../../../docs/reference/domains.md");
    for lint in Lint::ALL {
        assert!(documentation.contains(&format!("`{}`", lint.name())), "{lint:?}");
    }
}

#[test]
fn lint_reports_actions_that_are_never_applicable() {
    // No effect makes it true.
    check(
        fly(":precondition (winged) :effect (robot-at ?to)"),
        &["domain.pddl:18:15 never-applicable fly"],
    );
    // Only an effect of this action makes it true.
    check(
        fly(":precondition (winged) :effect (and (winged) (robot-at ?to))"),
        &["domain.pddl:18:15 never-applicable fly"],
    );
    // A fact and its negation.
    check(
        [pddl("(and (robot-at ?to)", "(and (robot-at ?to) (not (robot-at ?to))")],
        &["domain.pddl:31:24 never-applicable drop"],
    );
    // A fact and its universal negation.
    check(
        [pddl(
            "(and (robot-at ?from)",
            "(and (carrying ?parcel) (robot-at ?from)",
        )],
        &["domain.pddl:25:24 never-applicable pick"],
    );
    // Inside `or` and `exists`.
    check(
        [pddl(
            "(not (robot-at ?to))",
            "(or (not (= ?to ?to)) (exists (?p - parcel) (and (carrying ?p) (not (carrying ?p)))))",
        )],
        &["domain.pddl:19:28 never-applicable drive"],
    );
    // Two terms that can never be equal.
    check(
        [pddl("(not (robot-at ?to))", "(exists (?p - parcel) (= ?p ?to))")],
        &["domain.pddl:19:41 never-applicable drive"],
    );
    // A type below neither list of an environment. One below a list is inhabited: an environment's `types` may name it.
    check(
        [
            pddl("(:types station", "(:types dock - thing station"),
            pddl("(?to - station)", "(?to - station ?d - dock)"),
        ],
        &["domain.pddl:18:37 never-applicable drive"],
    );
    // An effect that never happens.
    check(
        [pddl(
            "(and (at ?parcel ?to)",
            "(and (when (not (carrying ?parcel)) (robot-at ?to)) (at ?parcel ?to)",
        )],
        &["domain.pddl:32:29 never-applicable drop robot-at"],
    );
}

#[test]
fn lint_accepts_preconditions_that_can_hold() {
    for precondition in [
        // Two variables in one slot.
        "(and (exists (?p - parcel) (carrying ?p)) (exists (?p - parcel) (not (carrying ?p))))",
        "(or (not (robot-at ?to)) (robot-at ?to))",
        // A `forall` that excludes the object itself.
        "(exists (?p - parcel) (and (carrying ?p) (forall (?o - parcel) (imply (not (= ?o ?p)) (not (carrying ?o))))))",
        // Another argument.
        "(exists (?s - station) (and (robot-at ?s) (not (robot-at ?to))))",
    ] {
        check([pddl("(not (robot-at ?to))", precondition)], &[]);
    }
}

#[test]
fn lint_reports_goals_rules_and_facts_that_never_hold() {
    let unreachable = &["domain.toml:75:14 unreachable-goal bring({parcel}, {station})"];
    check(
        [goal("(and (at ?parcel ?station) (not (at ?parcel ?station)))")],
        unreachable,
    );
    // No action works towards it.
    check([goal("(initially (at ?parcel ?station))")], unreachable);
    check(
        [goal("(at ?parcel ?station)\"\noffered = \"(not (= ?parcel ?parcel))")],
        &["domain.toml:76:12 unreachable-goal bring({parcel}, {station})"],
    );
    let grounded = || fly(":precondition (not (winged)) :effect (robot-at ?to)");
    check(grounded(), &["domain.pddl:14:36 never-true winged"]);
    let harmless = toml(
        "(not (carrying ?parcel)))\"",
        "(not (and (winged) (carrying ?parcel))))\"",
    );
    check(
        grounded().into_iter().chain([harmless]),
        &["domain.toml:80:14 vacuous-rule deliver"],
    );
    // An event in the initial state.
    check(
        [
            toml("short = \"on the robot\"", "event = true"),
            goal("(and (at ?parcel ?station) (initially (carrying ?parcel)))"),
        ],
        &["domain.toml:75:14 unreachable-goal bring({parcel}, {station})"],
    );
}

#[test]
fn lint_reports_conflicting_facts_and_one_way_states() {
    check(
        [pddl("(at ?parcel ?to) (not (carrying ?parcel))", "(at ?parcel ?to)")],
        &["domain.pddl:29:12 conflicting-facts drop carrying"],
    );
    check(
        fly(":precondition (and (not (winged)) (not (robot-at ?to))) :effect (and (winged) (robot-at ?to))"),
        &["domain.pddl:14:36 one-way-state winged"],
    );
    // A permanent effect on one object is common.
    let once = pddl("(robot-at ?from) (at", "(robot-at ?from) (not (heavy ?parcel)) (at");
    let heavier = pddl(
        "(and (carrying ?parcel) (not",
        "(and (carrying ?parcel) (heavy ?parcel) (not",
    );
    check(heavy("heavy()", "").into_iter().chain([once, heavier]), &[]);
}

#[test]
fn lint_reports_unused_and_useless_declarations() {
    check(
        fly(":precondition (not (robot-at ?to)) :effect (and (winged) (robot-at ?to))"),
        &["domain.pddl:18:49 unread-effect winged"],
    );
    check(
        fly(":precondition (robot-at ?to) :effect (winged)"),
        &["domain.pddl:17:12 useless-action fly"],
    );
    check(
        fly(":precondition (robot-at ?to)"),
        &[
            "domain.pddl:14:36 unused-predicate winged",
            "domain.pddl:17:12 useless-action fly",
        ],
    );
    check(
        [pddl(
            "(and (at ?parcel ?to)",
            "(and (at ?parcel ?to) (not (at ?parcel ?to))",
        )],
        &["domain.pddl:32:18 contradictory-effect drop at"],
    );
    check(heavy("heavy()", ""), &["domain.toml:73:9 dead-state heavy"]);
    check(heavy("heavy()", "short = \"heavy\""), &[]);
    check(
        [pddl("(:types station", "(:types dock - station station")],
        &["domain.pddl:10:11 unused-type dock"],
    );
}

#[test]
fn lint_reports_the_confusable_names_of_the_paper() {
    let mut files = shipped_files("virtualhome").unwrap();
    files.words = files.words.replacen("of = [\"Put\", \"PutIn\"]", "of = []", 1);
    let domain = load(&files).unwrap();
    let found = lint(&domain, &files);
    let message = found[0].to_string();
    assert!(message.starts_with("domains/virtualhome/domain.toml:"), "{message}");
    assert_eq!(
        message[message.find('[').unwrap()..],
        *"[confusable-names] the actions `Put` and `PutIn` take the same things, \
         and a model will confuse their names\n  hint: say in each name what only that one is for: as in `PutPlace` \
         and `PutContainer`"
    );
    assert_eq!((found.len(), found[1].lint), (2, Lint::StaleAcceptance));
}

#[test]
fn lint_reports_confusable_names_of_actions_and_states() {
    check(
        [toml("call = \"pick(", "call = \"drop_off(")],
        &["domain.toml:60:9 confusable-names drop_off drop"],
    );
    // The arguments have other types.
    check([toml("call = \"pick(", "call = \"drive_off(")], &[]);
    check(
        heavy("carried_with_care()", "short = \"heavy\""),
        &["domain.toml:73:9 confusable-names carried carried_with_care"],
    );
    // Two words for one fact.
    check(
        [
            toml("word = \"carried()\"", "word = \"at_last(<station>)\""),
            toml("fact = \"(carrying ?self)\"", "fact = \"(at ?self ?station)\""),
        ],
        &[],
    );
    check(
        [another_goal(
            "swap({parcel}, {parcels})",
            "?parcel - parcel ?parcels - parcel",
            "(and (carrying ?parcel) (not (carrying ?parcels)))",
        )],
        &[
            "domain.toml:82:9 missing-example swap({parcel}, {parcels})",
            "domain.toml:83:15 confusable-names parcel parcels",
        ],
    );
}

#[test]
fn lint_reports_missing_and_ambiguous_explanations() {
    let unexplained = &["domain.toml:47:9 missing-explanation drive"];
    check([toml("Drive to another station.", " ")], unexplained);
    check([toml("Drive to another station.", "Drive.")], unexplained);
    check(
        [toml("drive to {to}", "")],
        &["domain.toml:49:9 missing-explanation drive"],
    );
    check(
        [toml("drive to {to}", "drive")],
        &["domain.toml:49:9 unnamed-parameter drive to"],
    );
    // The entry that holds the text implies the first argument.
    check(
        [toml("short = \"at {station}\"", "short = \"somewhere\"")],
        &["domain.toml:16:10 unnamed-parameter at station"],
    );
    check(
        [toml("The robot carries the parcel.", "The robot is at this station")],
        &["domain.toml:41:9 same-explanation robot_here carried"],
    );
    check(
        [toml("set down {parcel} at {to}", "pick up {parcel} at {to}")],
        &["domain.toml:61:9 same-explanation pick drop"],
    );
    check(
        heavy("heavy()", "short = \"on the robot\""),
        &["domain.toml:70:10 same-explanation carrying heavy"],
    );
    check(
        [toml("the robot does not carry {parcel}", "the robot carries {parcel}")],
        &["domain.toml:26:11 same-explanation carrying"],
    );
}

#[test]
fn lint_reports_forms_without_an_example() {
    check(
        [another_goal(
            "loaded({parcel})",
            "?parcel - parcel",
            "(carrying ?parcel)",
        )],
        &["domain.toml:82:9 missing-example loaded({parcel})"],
    );
    let answer = "question: I see no trumpet here. Which thing do you mean?";
    check(
        [("prompt/examples.toml", answer, "bring(letter, hangar)".to_owned())],
        &["prompt/examples.toml:1:1 missing-example question"],
    );
}

#[test]
fn lint_reports_lexicon_names_that_match_nothing() {
    for (entry, expected) in [
        ("box = [\"crate\"]", ""),
        ("tube_a = [\"first tube\"]", ""),
        ("Box = [\"crate\"]", "unmatched-name Box"),
        ("box_2 = [\"crate\"]", "unmatched-name box_2"),
        ("\"<box>\" = [\"crate\"]", "unmatched-name <box>"),
        ("box = []", "unmatched-name box"),
        ("box = [\"crate\", \"...\"]", "unmatched-name box ..."),
    ] {
        let mut files = starter_files();
        let line = files.words.lines().position(|line| line == "[lexicon]").unwrap();
        let lines = files.words.lines().take(line + 1).chain([entry]);
        files.words = lines.collect::<Vec<_>>().join("\n");
        let domain = load(&files).unwrap_or_else(|findings| panic!("{findings}"));
        let found = lint(&domain, &files);
        let found: Vec<String> = found
            .iter()
            .map(|own| format!("{} {}", own.lint.name(), own.of.join(" ")))
            .collect();
        assert_eq!(found.join("; "), expected, "{entry}");
        let json = "{\"environment\": {\"assets\": [\"<desk_1>\"], \"objects\": [\"<box_3>\"]}}";
        let world = testing::world_of(&domain, json);
        let found = lint_environment(&world, &files, "e.json", json);
        let idle = found.iter().any(|own| own.lint == Lint::IdleName);
        assert_eq!(idle, !entry.starts_with("box ="), "{entry}");
    }
}

#[test]
fn lint_respects_acceptances_and_reports_stale_ones() {
    let accept = |lint: &str, of: &str, why: &str| {
        let text = format!("[[accept]]\nlint = \"{lint}\"\nof = [{of}]\nwhy = \"{why}\"\n\n[[rule]]");
        toml("[[rule]]", &text)
    };
    let renamed = || toml("call = \"pick(", "call = \"drop_off(");
    let both = "\"drop\", \"drop_off\"";
    check([renamed(), accept("confusable-names", both, "They say so.")], &[]);
    check(
        [renamed(), accept("confusable-names", both, " ")],
        &["domain.toml:68:8 stale-acceptance drop drop_off"],
    );
    let stale = &["domain.toml:66:9 stale-acceptance drop drop_off"];
    check([accept("confusable-names", both, "They say so.")], stale);
    check([accept("confusing-names", both, "They say so.")], stale);
}
