use super::*;
use longstep_model::domain::{self, Files};
use longstep_search::testing;

const PDDL: &str = "(define (domain ovens) (:requirements :typing) (:types oven temperature duration)
  (:predicates (hot ?o - oven ?t - temperature) (baked ?o - oven ?d - duration))
  (:action heat :parameters (?o - oven ?t - temperature) :precondition () :effect (hot ?o ?t))
  (:action bake :parameters (?o - oven ?d - duration) :precondition () :effect (baked ?o ?d)))";

const WORDS: &str = r#"name = "ovens"
about = "A robot that heats ovens."

[environment]
assets = "oven"
objects = "oven"

[value.temperature]
unit = "degC"

[value.duration]
unit = "s"
units = { min = 60 }

[[predicate]]
name = "hot"
says = "{o} is at {t}"
denies = "{o} is not at {t}"

[[predicate]]
name = "baked"
says = "{o} baked for {d}"
denies = "{o} did not bake for {d}"

[[action]]
name = "heat"
call = "heat(?o, ?t)"
says = "heat {o} to {t}"
means = "heats an oven"
skill = [{ name = "speed", type = "number", unit = "s", from = "robot" },
         { name = "push", type = "vector", unit = "m", from = "robot" },
         { name = "grip", type = "grasp", from = "robot" }]

[[action]]
name = "bake"
call = "bake(?o, ?d)"
says = "bake in {o} for {d}"
means = "bakes"
skill = [{ name = "speed", type = "number", unit = "s", from = "robot" }]

[[goal]]
form = "hot({o}, {t})"
parameters = "?o - oven ?t - temperature"
condition = "(hot ?o ?t)"
subject = "o"
says = "{o} is at {t}"
means = "an oven has a temperature"
"#;

/// A domain with values, and skill parameters in the units of one of them.
pub(crate) fn ovens() -> World {
    let files = Files {
        pddl: PDDL.to_owned(),
        words: WORDS.to_owned(),
        ..Files::default()
    };
    let domain = domain::load(&files).unwrap_or_else(|findings| panic!("{findings}"));
    testing::world_of(&domain, r#"{"assets": ["<big_oven>", "<small_oven>"]}"#)
}

fn parsed(world: &World, text: &str) -> Result<Autonomy, String> {
    Autonomy::parse(world.domain(), Some(world), "a.toml", text).map_err(|findings| findings.to_string())
}

#[track_caller]
fn read(world: &World, text: &str) -> Autonomy {
    parsed(world, text).unwrap()
}

fn action(world: &World, name: &str) -> ActionId {
    let found = world.domain().action_ids().find(|(_, own)| own.name == name);
    found.unwrap().0
}

#[test]
fn autonomy_file_errors_name_their_place_and_the_nearest_name() {
    let world = ovens();
    for (text, expected) in [
        (
            "[autonomy]\nheat = \"never\"\nbaek = \"free\"",
            "a.toml:3:1: unknown action `baek`\n  hint: did you mean `bake`?",
        ),
        (
            "[autonomy]\nheat = \"allways\"",
            "a.toml:2:8: expected a level: `free`, `announce`, `approve` or `never`",
        ),
        (
            "[autonomy]\nheat = 3",
            "a.toml:2:8: expected a level: `free`, `announce`, `approve` or `never`",
        ),
        (
            "[autonomy]\nannounce_s = -1",
            "a.toml:2:14: `announce_s` is a number of seconds from 0 to 3600",
        ),
        (
            "[autonomy]\nannounce_s = \"3\"",
            "a.toml:2:14: `announce_s` is a number of seconds from 0 to 3600",
        ),
        (
            "[autonomi]",
            "a.toml:1:2: unknown field `autonomi`, expected `autonomy` or `limit`",
        ),
        (
            "[[limit]]\nparameter = \"sped\"\nmax = 1",
            "a.toml:2:13: unknown skill parameter `sped`\n  hint: did you mean `speed`?",
        ),
        (
            "[[limit]]\nparameter = \"push\"\naction = \"bake\"\nmax = 1",
            "a.toml:2:13: unknown skill parameter `push`\n  hint: write one of `speed`",
        ),
        (
            "[[limit]]\nparameter = \"grip\"\nmax = 1",
            "a.toml:2:13: `grip` of `heat` is a grasp, which has no range\n  hint: a limit is for an angle, a force, a number, or \
             the length of a vector",
        ),
        (
            "[[limit]]\nparameter = \"push\"\nmax = \"1 feet\"",
            "a.toml:3:7: unknown unit `feet`\n  hint: write one of `m`",
        ),
        (
            "[[limit]]\nvalue = \"duration\"\nmax = \"1 mn\"",
            "a.toml:3:7: unknown unit `mn`\n  hint: did you mean `min`?",
        ),
        (
            "[[limit]]\nvalue = \"durations\"\nmax = 1",
            "a.toml:2:9: unknown type of values `durations`\n  hint: did you mean `duration`?",
        ),
        (
            "[[limit]]\nvalue = \"duration\"\naction = \"heat\"\nmax = 1",
            "a.toml:2:9: `heat` has no argument of the type `duration`",
        ),
        (
            "[[limit]]\nvalue = \"duration\"\nmax = \"1.0000001 s\"",
            "a.toml:3:7: expected a number with at most six places after the point, and its unit, such as \"0.25 m/s\"",
        ),
        (
            "[[limit]]\nvalue = \"duration\"",
            "a.toml:1:1: a limit of a number has `min`, `max` or both",
        ),
        (
            "[[limit]]\nvalue = \"duration\"\nmin = \"2 min\"\nmax = \"100 s\"",
            "a.toml:1:1: `min` is greater than `max`",
        ),
        (
            "[[limit]]\nforbidden = [\"big ovn\"]",
            "a.toml:2:14: unknown place `big ovn`\n  hint: did you mean `big oven`?",
        ),
        ("[[limit]]\nforbidden = []", "a.toml:1:1: `forbidden` lists no place"),
        (
            "[[limit]]\nforbidden = [\"big oven\"]\nmax = 3",
            "a.toml:1:1: `forbidden` has no range",
        ),
        (
            "[[limit]]\nforbidden = [\"big oven\"]\nvalue = \"duration\"",
            "a.toml:1:1: a limit has one of `parameter`, `value` and `forbidden`",
        ),
        (
            "[[limit]]\nmax = 3",
            "a.toml:1:1: a limit has one of `parameter`, `value` and `forbidden`",
        ),
    ] {
        assert_eq!(parsed(&world, text).unwrap_err(), expected, "{text}");
    }
}

const WHOLE: &str = r#"[autonomy]
default = "announce"
announce_s = 0.5
heat = "approve"

[[limit]]
parameter = "speed"
max = "0.5 min"
says = "people walk here"

[[limit]]
value = "temperature"
min = 5
max = "80 degC"
action = "heat"

[[limit]]
forbidden = ["big oven"]
"#;

#[test]
fn autonomy_is_read_again_from_its_value() {
    let world = ovens();
    let autonomy = read(&world, WHOLE);
    assert_eq!(autonomy.level(action(&world, "heat")), Level::Approve);
    assert_eq!(autonomy.level(action(&world, "bake")), Level::Announce);
    assert_eq!(autonomy.announcement(), Duration::from_millis(500));
    // `speed` is a parameter of both actions.
    assert_eq!(autonomy.limits().len(), 4);
    let again = Autonomy::from_value(world.domain(), &autonomy.to_value(world.domain())).unwrap();
    assert_eq!(again, autonomy);
    assert_eq!(Autonomy::default().to_value(world.domain()), Value::Null);
    assert_eq!(
        Autonomy::from_value(world.domain(), &Value::Null).unwrap(),
        Autonomy::default()
    );
}

#[test]
fn limits_refuse_values_and_places_in_any_unit() {
    let mut world = ovens();
    world.add_values("hot(big oven, 80 degC) hot(big oven, 81 degC) hot(big oven, 4 degC)");
    let autonomy = read(&world, WHOLE);
    let refusal = |name: &str, arguments: [&str; 2], skills: Value| {
        let arguments = arguments.map(|own| world.exactly(own).unwrap());
        let skills = skills.as_object().cloned().unwrap_or_default();
        let refusal = autonomy.refusal(&world, action(&world, name), &arguments, &skills);
        refusal.map(|own| own.to_string()).unwrap_or_default()
    };
    let small = |temperature: &'static str| ["<small_oven>", temperature];
    assert_eq!(refusal("heat", small("80 degC"), json!({})), "");
    assert_eq!(
        refusal("heat", small("81 degC"), json!({})),
        "`temperature` is 81 degC, and the limit is 5 degC to 80 degC"
    );
    assert_eq!(
        refusal("heat", small("4 degC"), json!({})),
        "`temperature` is 4 degC, and the limit is 5 degC to 80 degC"
    );
    assert_eq!(refusal("heat", small("80 degC"), json!({ "speed": 30 })), "");
    assert_eq!(
        refusal("heat", small("80 degC"), json!({ "speed": 30.000_001 })),
        "`speed` is 30.000001 s, and the limit is at most 0.5 min (people walk here)"
    );
    assert_eq!(
        refusal("heat", ["<big_oven>", "80 degC"], json!({})),
        "the big oven is forbidden"
    );
    // The prohibitions of a search forbid what is refused, apart from skill values.
    let limited = world.with_prohibitions(autonomy.prohibitions(&world));
    for (oven, temperature, is_forbidden) in [
        ("<small_oven>", "80 degC", false),
        ("<small_oven>", "81 degC", true),
        ("<small_oven>", "4 degC", true),
        ("<big_oven>", "80 degC", true),
    ] {
        let arguments = [oven, temperature].map(|own| limited.exactly(own).unwrap());
        let forbidden = limited.forbids(action(&limited, "heat"), &arguments);
        assert_eq!(forbidden.is_some(), is_forbidden, "{oven} {temperature}");
    }
}

#[test]
fn limit_of_a_vector_is_one_of_its_length() {
    let world = ovens();
    let autonomy = read(&world, "[[limit]]\nparameter = \"push\"\nmax = 0.5");
    let refusal = |push: Value| {
        let skills = json!({ "push": push });
        autonomy.refusal(&world, action(&world, "heat"), &[], skills.as_object().unwrap())
    };
    assert_eq!(refusal(json!([0.3, 0.4, 0])), None);
    assert_eq!(
        refusal(json!([0.3, 0.4, 0.1])).unwrap().kind,
        RefusalKind::Range {
            name: "push".to_owned(),
            value: "0.5099019513592785 m".to_owned(),
            range: "at most 0.5 m".to_owned(),
        }
    );
}

#[test]
fn goal_values_are_refused_by_limits_for_every_action() {
    let world = ovens();
    let refused = |limit: &str| {
        let autonomy = read(&world, limit);
        let refused = autonomy.refused_values(world.domain(), "hot(big oven, 90 degC)");
        refused.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    assert_eq!(
        refused("[[limit]]\nvalue = \"temperature\"\nmax = 80"),
        ["`temperature` is 90 degC, and the limit is at most 80 degC"]
    );
    assert!(refused("[[limit]]\nvalue = \"temperature\"\nmax = 80\naction = \"heat\"").is_empty());
    assert!(refused("[[limit]]\nvalue = \"temperature\"\nmax = 90").is_empty());
}

#[test]
fn two_files_together_are_as_strict_as_each_of_them() {
    let world = ovens();
    let one = read(&world, WHOLE);
    let other = read(
        &world,
        "[autonomy]\nbake = \"never\"\n[[limit]]\nvalue = \"duration\"\nmax = \"1 min\"\n[[limit]]\nforbidden = [\"big oven\"]",
    );
    let both = one.and(&other);
    let level = |name: &str| both.level(action(&world, name));
    assert_eq!((level("heat"), level("bake")), (Level::Approve, Level::Never));
    assert_eq!(
        (both.limits().len(), both.announcement()),
        (5, Duration::from_millis(500))
    );
    assert!(both.is_as_strict_as(&one) && both.is_as_strict_as(&other));
    assert!(!one.is_as_strict_as(&other) && !other.is_as_strict_as(&one));
    assert!(one.is_as_strict_as(&Autonomy::default()) && !Autonomy::default().is_as_strict_as(&one));
    let alone = both.without_people();
    let level = |name: &str| alone.level(action(&world, name));
    assert_eq!((level("heat"), level("bake")), (Level::Free, Level::Never));
    assert_eq!(alone.limits().len(), 5);
}

#[test]
fn tables_are_read_within_a_file_of_other_tables() {
    let world = ovens();
    let text = "name = \"arm\"\n[autonomy]\nheat = \"never\"\n[timeouts]\nstop = 1\n";
    let within = |text: &str| Autonomy::parse_within(world.domain(), None, "robot.toml", text);
    assert_eq!(within(text).unwrap().level(action(&world, "heat")), Level::Never);
    assert!(within("name = \"arm\"").unwrap().is_empty());
    let wrong = within("name = \"arm\"\n[autonomy]\nhaet = \"never\"")
        .unwrap_err()
        .to_string();
    assert!(wrong.starts_with("robot.toml:3:1: unknown action `haet`"), "{wrong}");
}
