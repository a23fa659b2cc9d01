//! `longstep see` with scenes of boxes, and with pictures and a server that gives stored replies (`tests/see/*.json`).
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::look::{SHELF, reply};
use common::{Answer, Ran, Server, longstep, root, run};
use serde_json::{Value, json};

fn says(text: &str) -> Answer {
    Answer::Says(text.to_owned())
}

/// Looks at the picture of the shelf, with these replies and this input.
fn see(home: &Path, replies: Vec<Answer>, arguments: &[&str], input: &str) -> (Ran, Server) {
    let server = Server::giving(replies);
    let mut command = longstep(home);
    command
        .args(["see", SHELF, "--model", &server.reference()])
        .args(arguments);
    (run(&mut command, input), server)
}

#[test]
fn the_boxes_of_the_simulated_scenes_give_back_their_environments() {
    let home = tempfile::tempdir().unwrap();
    for scene in ["drawer", "fridge", "shelf", "table", "window"] {
        let boxes = format!("examples/see/{scene}.boxes.json");
        let file = home.path().join("env.json");
        let ran = run(longstep(home.path()).args(["see", &boxes, "-o"]).arg(&file), "");
        assert_eq!(ran.code, 0, "{scene}: {}{}", ran.stdout, ran.stderr);
        let seen: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
        let made = root().join(format!("crates/longstep-eval/suites/household/scenes/{scene}.json"));
        let made: Value = serde_json::from_str(&std::fs::read_to_string(made).unwrap()).unwrap();
        let made = &made["environment"];
        assert_eq!((&seen["assets"], &seen["objects"]), (&made["assets"], &made["objects"]));
        assert_eq!(seen["object_states"], made["object_states"], "{scene}");
    }
}

#[test]
fn a_scene_that_fits_no_world_is_saved_only_when_confirmed() {
    let home = tempfile::tempdir().unwrap();
    let boxes = home.path().join("boxes.json");
    let text = r#"{"boxes": [{"name": "<table>", "position": [0, 0, 0.4], "size": [1, 1, 0.8]},
        {"name": "<cup>", "position": [0, 0, 1.5], "size": [0.1, 0.1, 0.1]}]}"#;
    std::fs::write(&boxes, text).unwrap();
    let file = home.path().join("env.json");
    for (options, input, code) in [
        (&[][..], "", 13),
        (&[], "no\n", 13),
        (&["--json"], "", 13),
        (&[], "yes\n", 0),
        (&["--yes"], "", 0),
    ] {
        let _ = std::fs::remove_file(&file);
        let mut command = longstep(home.path());
        let ran = run(command.arg("see").arg(&boxes).arg("-o").arg(&file).args(options), input);
        assert_eq!(
            (ran.code, file.exists()),
            (code, code == 0),
            "{options:?}: {}",
            ran.stderr
        );
        assert!(
            ran.stdout.contains("<cup> is on nothing: it is 1450 mm above"),
            "{}",
            ran.stdout
        );
    }
}

#[test]
fn a_picture_is_sent_byte_by_byte_and_the_reply_becomes_an_environment() {
    let home = tempfile::tempdir().unwrap();
    let (ran, server) = see(home.path(), vec![reply("good")], &["--json", "--yes"], "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let picture = STANDARD.encode(std::fs::read(root().join(SHELF)).unwrap());
    let body = &server.texts()[0];
    assert_eq!(body.matches(&picture).count(), 1);
    insta::assert_snapshot!("see_request", body.replace(&picture, "{examples/see/shelf.png}"));
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(
        report["environment"]["assets"],
        json!(["<table>", "<shelf_bottom>", "<shelf_top>", "<trash_bin>"])
    );
    assert_eq!(
        report["environment"]["object_states"],
        json!({"<juice>": "on_something(<shelf_bottom>)", "<spam>": "on_something(<table>)"})
    );
    assert_eq!(report["unsure"], json!(["whether the trash bin is empty"]));
    assert_eq!(report["contradictions"], json!([]));
}

#[test]
fn see_resolves_or_omits_unknown_names_and_lists_each_change() {
    let home = tempfile::tempdir().unwrap();
    let (ran, _) = see(home.path(), vec![reply("lenient")], &["--json"], "");
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(
        report["environment"]["object_states"],
        json!({"<juice>": "on_something(<shelf_bottom>)", "<spam>": "on_something(<table>)"})
    );
    assert_eq!(
        report["read_as"],
        json!([
            "`table` is listed twice; the first one counts",
            "`juise` is read as `juice`",
            "`on_somthing` is read as `on_something`",
            "`spam` is in neither list; it is added to the objects",
            "`juice: flying()` is no state of this domain; it is left out",
            "`table: on_something(table)` is no state of this domain; it is left out",
            "`juice: on_something(a, b)` is no state of this domain; it is left out",
        ])
    );
}

#[test]
fn a_contradictory_reply_is_shown_and_never_saved() {
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("env.json");
    let output = file.to_str().unwrap();
    let (ran, _) = see(home.path(), vec![reply("contradictory")], &["--yes", "-o", output], "");
    assert_eq!(ran.code, 10);
    for part in [
        "<juice> cannot be on <table> and inside <fridge>",
        "<fridge> cannot be open and closed",
    ] {
        assert!(ran.stdout.contains(part), "{}", ran.stdout);
    }
    assert!(!file.exists());
    // A person says how it is; what contradicts that gives way.
    let replies = vec![
        reply("contradictory"),
        says("The juice is in the fridge."),
        says("The fridge is open."),
    ];
    let input = "the juice is in the fridge\nthe fridge is open\nyes\n";
    let (ran, _) = see(home.path(), replies, &["-o", output], input);
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    let saved: Value = serde_json::from_str(&std::fs::read_to_string(&file).unwrap()).unwrap();
    assert_eq!(saved["object_states"], json!({"<juice>": "inside_something(<fridge>)"}));
    assert_eq!(saved["asset_states"], json!({"<fridge>": "open()"}));
}

#[test]
fn see_applies_corrections_in_words() {
    let home = tempfile::tempdir().unwrap();
    let replies = vec![
        reply("good"),
        says("The juice is on the shelf_top."),
        says("The knife is on the table. There is no spam."),
    ];
    let corrections = [
        "--correct",
        "the juice is on the upper shelf",
        "--correct",
        "a knife is on the table, no spam",
    ];
    let (ran, server) = see(
        home.path(),
        replies,
        &[&corrections[..], &["--json", "--yes"]].concat(),
        "",
    );
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(
        report["environment"]["object_states"],
        json!({"<juice>": "on_something(<shelf_top>)", "<knife>": "on_something(<table>)"})
    );
    let asked = server.bodies()[1]["messages"].as_array().unwrap().last().unwrap()["content"].clone();
    assert!(
        asked.as_str().unwrap().ends_with("\n\nthe juice is on the upper shelf"),
        "{asked}"
    );
}

#[test]
fn replies_that_cannot_be_used_are_errors() {
    let home = tempfile::tempdir().unwrap();
    let many: Vec<String> = (0..1000).map(|index| format!("thing {index}")).collect();
    let deep = format!("{}{}", r#"{"assets": "#, "[".repeat(100_000));
    for (reply, code, part) in [
        (reply("cut_off"), 20, "the model's answer was cut off"),
        (reply("refusing"), 40, "the model refused to answer"),
        (reply("nonsense"), 40, "the model's answer cannot be read"),
        (
            says(&json!({"assets": many, "objects": [], "states": []}).to_string()),
            40,
            "more than 40 names",
        ),
        (says(&deep), 40, "the model's answer cannot be read"),
        (
            says(r#"{"assets": [1], "objects": {}}"#),
            40,
            "the model's answer cannot be read",
        ),
    ] {
        let (ran, _) = see(home.path(), vec![reply.clone(), reply], &["--yes"], "");
        assert_eq!(ran.code, code, "{}", ran.stderr);
        assert!(ran.stderr.contains(part), "{}", ran.stderr);
    }
    // Control characters and empty names do not reach the environment.
    let reply = json!({"assets": ["", "<>", "\u{1b}[31mtable"], "objects": ["\u{202e}cup"], "states": []});
    let (ran, _) = see(home.path(), vec![says(&reply.to_string())], &["--json"], "");
    let report: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(report["environment"]["assets"], json!(["<31mtable>"]));
    assert_eq!(report["environment"]["objects"], json!(["<cup>"]));
}

#[test]
fn see_rejects_files_that_are_not_scenes_or_pictures() {
    let home = tempfile::tempdir().unwrap();
    let file = |name: &str, bytes: &[u8]| {
        let path = home.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let gif = file("a.gif", b"GIF89a...");
    let empty = file("empty.json", b"");
    let broken = file("broken.json", b"{\"boxes\": [");
    let scene = file("scene.json", br#"{"boxes": []}"#);
    let large = file("large.png", &[&b"\x89PNG\r\n\x1a\n"[..], &vec![0; 20 << 20]].concat());
    let folder = home.path().to_str().unwrap();
    for (arguments, part) in [
        (&[gif.as_str()][..], "not a PNG, JPEG or WebP picture"),
        (&[&empty], "not a PNG, JPEG or WebP picture"),
        (&[&broken], "broken.json:1:11: EOF while parsing a list"),
        (&[&large], "larger than 20 MiB"),
        (&[folder], "is a folder, not a file"),
        (&["missing.json"], "missing.json"),
        (&[&scene, SHELF], "a scene file stands alone"),
        (&[&scene, &scene], "a scene file stands alone"),
        (&[&scene, "--words", "a table"], "a scene file stands alone"),
        (
            &[&scene, "--correct", "no"],
            "`--correct` is for what a model wrote down",
        ),
        (&["--words", "  "], "the description is empty"),
        (&[], "required"),
    ] {
        let ran = run(longstep(home.path()).arg("see").args(arguments), "");
        assert!(
            ran.code == 30 || ran.code == 2,
            "{arguments:?}: {} {}",
            ran.code,
            ran.stderr
        );
        assert!(ran.stderr.contains(part), "{arguments:?}: {}", ran.stderr);
    }
}

/// The build with the feature `vision` has tests of its own (`vision.rs`).
#[cfg(not(feature = "vision"))]
#[test]
fn a_build_without_embedded_vision_says_what_to_do() {
    let home = tempfile::tempdir().unwrap();
    for arguments in [
        &[][..],
        &["--model", "weights.gguf"],
        &["--model", "weights.gguf", "--vision", "eyes.gguf"],
    ] {
        let ran = run(longstep(home.path()).args(["see", SHELF]).args(arguments), "");
        assert_eq!(ran.code, 30, "{arguments:?}: {}", ran.stderr);
        assert!(
            ran.stderr.contains("this build has no embedded vision"),
            "{}",
            ran.stderr
        );
        assert!(ran.stderr.contains("--features vision"), "{}", ran.stderr);
    }
}

#[test]
fn see_lists_changes_against_the_world_of_a_session() {
    let home = tempfile::tempdir().unwrap();
    let session = home.path().join("kitchen");
    let server = Server::giving(Vec::new());
    let mut chat = longstep(home.path());
    chat.args([
        "chat",
        "--env",
        "crates/longstep-eval/suites/household/scenes/fridge.json",
        "--model",
        &server.reference(),
        "--session",
    ]);
    let ran = run(chat.arg(&session), "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let boxes = std::fs::read_to_string(root().join("examples/see/fridge.boxes.json")).unwrap();
    let mut scene: Value = serde_json::from_str(&boxes).unwrap();
    for body in scene["boxes"].as_array_mut().unwrap() {
        match body["name"].as_str().unwrap() {
            "<juice>" => {
                body["position"] = json!([0.5, -1.0, 0.06]);
                body["size"] = json!([0.06, 0.06, 0.12]);
            }
            "<fridge_handle>" => body["joint"]["position"] = json!(1.2),
            _ => {}
        }
    }
    let cup = json!({"name": "<cup>", "kind": "object", "position": [0.7, -1.0, 0.05], "size": [0.1, 0.1, 0.1]});
    scene["boxes"].as_array_mut().unwrap().push(cup);
    let file = home.path().join("later.json");
    std::fs::write(&file, scene.to_string()).unwrap();
    let look = |options: &[&str], input: &str| {
        let mut command = longstep(home.path());
        command
            .arg("see")
            .arg(&file)
            .arg("--update")
            .arg(&session)
            .args(options);
        run(&mut command, input)
    };
    let changes = [
        "the fridge handle is not closed any more",
        "the juice is not in the fridge any more",
        "the fridge handle is open",
        "the juice is on the floor",
    ];
    // Without agreement nothing is stored, so that the changes are there again.
    for (options, input, code) in [(&[][..], "", 13), (&[], "no\n", 13), (&[], "yes\n", 0)] {
        let ran = look(options, input);
        assert_eq!(ran.code, code, "{}{}", ran.stdout, ran.stderr);
        for change in changes {
            assert!(ran.stdout.contains(change), "{change}: {}", ran.stdout);
        }
        assert!(ran.stdout.contains("<cup>"), "{}", ran.stdout);
    }
    let again = look(&["--json", "--yes"], "");
    let report: Value = serde_json::from_str(&again.stdout).unwrap();
    assert_eq!(
        (&report["changes"], &report["unknown"]),
        (&json!([]), &json!(["<cup>"]))
    );
    assert_eq!(report["stored"], json!(true));
    let ran = run(
        longstep(home.path()).args(["see", "--words", "x", "--update", "nowhere"]),
        "",
    );
    assert_eq!(ran.code, 30, "{}", ran.stderr);
}
