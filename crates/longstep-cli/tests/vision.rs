//! `longstep see` with an embedded model that sees: set LONGSTEP_TEST_VISION to the folder that `tools/vision/tiny.sh` prints,
//! build with the feature `vision`, and run with `--include-ignored`. The models have random weights, so what they see is senseless.
#![cfg(feature = "vision")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod common;

use std::path::Path;

use common::{Ran, longstep, run};
use serde_json::Value;

/// A language model, and a projector for it.
const PAIRS: [(&str, &str); 3] = [("model", "mlp"), ("model", "tiles"), ("mrope", "sizes")];

fn file(name: &str) -> String {
    let folder = std::env::var("LONGSTEP_TEST_VISION");
    let folder = folder.expect("LONGSTEP_TEST_VISION must be the folder that tools/vision/tiny.sh prints");
    format!("{folder}/{name}.gguf")
}

/// Looks at a picture of the examples. A model of random weights comes to an end when it is sampled.
fn see(home: &Path, pair: (&str, &str), picture: &str, more: &[&str]) -> Ran {
    let picture = format!("examples/see/{picture}.png");
    let mut command = longstep(home);
    command.args(["see", &picture, "--model", &file(pair.0), "--vision", &file(pair.1)]);
    command.args([
        "--context",
        "32768",
        "--temperature",
        "1",
        "--seed",
        "5",
        "--threads",
        "1",
    ]);
    run(command.args(["--json", "--yes"]).args(more), "")
}

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn an_embedded_model_answers_about_a_picture_in_the_form_of_the_domain() {
    let home = tempfile::tempdir().unwrap();
    for pair in PAIRS {
        let first = see(home.path(), pair, "shelf", &[]);
        // Random statements mostly contradict the domain.
        assert!(
            [0, 10].contains(&first.code),
            "{pair:?}: {} {}",
            first.code,
            first.stderr
        );
        let report: Value = serde_json::from_str(&first.stdout).unwrap();
        assert!(report["environment"]["assets"].is_array(), "{}", first.stdout);
        let again = see(home.path(), pair, "shelf", &[]);
        assert_eq!(first.stdout, again.stdout, "{pair:?}");
        let other = see(home.path(), pair, "window", &[]);
        assert_ne!(first.stdout, other.stdout, "{pair:?}");
    }
}

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn a_recording_replays_without_the_model() {
    let home = tempfile::tempdir().unwrap();
    let tape = home.path().join("tape.jsonl");
    let tape = tape.to_str().unwrap();
    let recorded = see(home.path(), PAIRS[0], "shelf", &["--record", tape]);
    let replay = |picture: &str| {
        let model = format!("replay:{tape}");
        let picture = format!("examples/see/{picture}.png");
        let mut command = longstep(home.path());
        run(
            command.args(["see", &picture, "--model", &model, "--json", "--yes"]),
            "",
        )
    };
    assert_eq!(replay("shelf").stdout, recorded.stdout);
    let other = replay("window");
    assert!(
        other.stderr.contains("has no answer to this request"),
        "{}",
        other.stderr
    );
}

#[test]
#[ignore = "needs LONGSTEP_TEST_VISION"]
fn see_rejects_models_without_a_matching_projector() {
    let home = tempfile::tempdir().unwrap();
    let (model, wide) = (file("model"), file("wide"));
    for (arguments, message, hint) in [
        (
            &["--model", &model][..],
            "does not see pictures without its projector",
            "--vision FILE",
        ),
        (
            &["--model", &model, "--vision", &wide],
            "it makes embeddings of 128 numbers, and the model takes 64",
            "published with the model",
        ),
        (
            &["--model", &model, "--vision", "missing.gguf"],
            "missing.gguf is no projector for the model",
            "published with the model",
        ),
        (
            &["--model", "replay:tape.jsonl", "--vision", &wide],
            "a projector is for an embedded model",
            "",
        ),
    ] {
        let mut command = longstep(home.path());
        let ran = run(command.args(["see", "examples/see/shelf.png"]).args(arguments), "");
        assert!(
            ran.code == 30 || ran.code == 40,
            "{arguments:?}: {} {}",
            ran.code,
            ran.stderr
        );
        assert!(ran.stderr.contains(message), "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(hint), "{arguments:?}: {}", ran.stderr);
    }
}
