//! Pictures in the formats of the servers: the whole request of `longstep see`, and the ways in which a reply ends.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::path::Path;
use std::process::Command;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use common::look::{SHELF, reply};
use common::{Answer, Ran, Server, longstep, root, run};
use serde_json::{Value, json};

const KEY: &str = "a-key-of-the-test";

/// A server that sees: its reference, and the variables of its address and its key.
struct Vendor {
    name: &'static str,
    address: &'static str,
    key: &'static str,
}

const ANTHROPIC: Vendor = Vendor {
    name: "anthropic",
    address: "ANTHROPIC_BASE_URL",
    key: "ANTHROPIC_API_KEY",
};
const GEMINI: Vendor = Vendor {
    name: "gemini",
    address: "GOOGLE_GEMINI_BASE_URL",
    key: "GEMINI_API_KEY",
};
const OPENAI: Vendor = Vendor {
    name: "openai",
    address: "OPENAI_BASE_URL",
    key: "OPENAI_API_KEY",
};

impl Vendor {
    fn command(&self, home: &Path, server: &Server) -> Command {
        let address = match self.name {
            "openai" => server.address(),
            _ => server.base(),
        };
        let mut command = longstep(home);
        command.env(self.address, address).env(self.key, KEY);
        command.args(["see", "--model", &format!("{}:recorded", self.name)]);
        command
    }

    fn see(&self, home: &Path, answer: Answer, arguments: &[&str]) -> (Ran, Server) {
        // A reply that cannot be read is asked for once more.
        let server = Server::giving(vec![answer.clone(), answer]);
        let ran = run(self.command(home, &server).args(arguments), "");
        (ran, server)
    }

    /// The pictures of a request in the vendor's own format: their media types and their content.
    fn pictures(&self, body: &Value) -> Vec<(String, Vec<u8>)> {
        let messages = if self.name == "gemini" { "contents" } else { "messages" };
        let parts = if self.name == "gemini" { "parts" } else { "content" };
        let last = body[messages].as_array().unwrap().last().unwrap();
        assert_eq!(last["role"], "user");
        let parts = last[parts]
            .as_array()
            .unwrap()
            .iter()
            .filter(|part| part["text"].is_null());
        let picture = |part: &Value| {
            let (media_type, data) = match self.name {
                "anthropic" => {
                    assert_eq!(
                        (&part["type"], &part["source"]["type"]),
                        (&json!("image"), &json!("base64"))
                    );
                    (part["source"]["media_type"].clone(), part["source"]["data"].clone())
                }
                "gemini" => (
                    part["inlineData"]["mimeType"].clone(),
                    part["inlineData"]["data"].clone(),
                ),
                _ => {
                    assert_eq!(part["type"], "image_url");
                    let url = part["image_url"]["url"]
                        .as_str()
                        .unwrap()
                        .strip_prefix("data:")
                        .unwrap();
                    let (media_type, data) = url.split_once(";base64,").unwrap();
                    (json!(media_type), json!(data))
                }
            };
            let bytes = STANDARD.decode(data.as_str().unwrap()).unwrap();
            (media_type.as_str().unwrap().to_owned(), bytes)
        };
        parts.map(picture).collect()
    }
}

#[test]
fn a_picture_is_sent_byte_by_byte_in_the_format_of_the_server() {
    let home = tempfile::tempdir().unwrap();
    let picture = STANDARD.encode(std::fs::read(root().join(SHELF)).unwrap());
    for (vendor, line, headers) in [
        (
            ANTHROPIC,
            "POST /v1/messages HTTP/1.1",
            &["x-api-key: a-key-of-the-test", "anthropic-version: 2023-06-01"][..],
        ),
        (
            GEMINI,
            "POST /v1beta/models/recorded:streamGenerateContent?alt=sse HTTP/1.1",
            &["x-goog-api-key: a-key-of-the-test"],
        ),
    ] {
        let (ran, server) = vendor.see(home.path(), reply("good"), &[SHELF, "--json", "--yes"]);
        assert_eq!(ran.code, 0, "{}: {}", vendor.name, ran.stderr);
        let (head, body) = (&server.heads()[0], &server.texts()[0]);
        assert_eq!(head.lines().next(), Some(line));
        for header in headers {
            assert!(head.lines().any(|line| line.eq_ignore_ascii_case(header)), "{head}");
        }
        assert!(
            !body.contains(KEY) && !head.to_lowercase().contains("authorization"),
            "{head}"
        );
        assert_eq!(body.matches(&picture).count(), 1);
        insta::assert_snapshot!(
            format!("request_{}", vendor.name),
            body.replace(&picture, "{examples/see/shelf.png}")
        );
        let report: Value = serde_json::from_str(&ran.stdout).unwrap();
        assert_eq!(
            report["environment"]["object_states"],
            json!({"<juice>": "on_something(<shelf_bottom>)", "<spam>": "on_something(<table>)"})
        );
    }
}

#[test]
fn several_pictures_keep_their_order_and_their_types() {
    let home = tempfile::tempdir().unwrap();
    let files = [
        ("a.png", "image/png", &b"\x89PNG\r\n\x1a\n..."[..]),
        ("b.jpg", "image/jpeg", b"\xff\xd8\xff\xe0..."),
        ("c.webp", "image/webp", b"RIFF\x04\x00\x00\x00WEBP..."),
    ];
    let paths = files.map(|(name, _, bytes)| {
        let path = home.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path.to_str().unwrap().to_owned()
    });
    let words = ["--words", "The spam is on the table.", "--json"];
    let arguments = [&paths.each_ref().map(String::as_str)[..], &words].concat();
    for vendor in [OPENAI, ANTHROPIC, GEMINI] {
        let (ran, server) = vendor.see(home.path(), reply("good"), &arguments);
        assert_eq!(ran.code, 13, "{}: {}", vendor.name, ran.stderr);
        let expected = files.map(|(_, media_type, bytes)| (media_type.to_owned(), bytes.to_vec()));
        assert_eq!(vendor.pictures(&server.bodies()[0]), expected, "{}", vendor.name);
        assert!(
            server.texts()[0].contains("The spam is on the table."),
            "{}",
            vendor.name
        );
    }
}

#[test]
fn replies_that_cannot_be_used_are_the_same_errors_for_all_servers() {
    let home = tempfile::tempdir().unwrap();
    for (name, code, expected) in [
        ("contradictory", 10, ""),
        ("cut_off", 20, "the model's answer was cut off"),
        ("refusing", 40, "the model refused to answer"),
        ("nonsense", 40, "the model's answer cannot be read"),
    ] {
        for vendor in [OPENAI, ANTHROPIC, GEMINI] {
            let (ran, _) = vendor.see(home.path(), reply(name), &[SHELF, "--yes"]);
            assert_eq!(ran.code, code, "{} {name}: {}", vendor.name, ran.stderr);
            assert!(ran.stderr.contains(expected), "{} {name}: {}", vendor.name, ran.stderr);
        }
    }
}
