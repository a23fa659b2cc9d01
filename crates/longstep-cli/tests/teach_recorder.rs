//! `longstep teach --recorder`: a lesson with a program that records, good ones and bad ones. No hand tracker is there: the
//! recorder plays a recording (`examples/teach/play.py`).
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use common::drawer::{ENV, GOAL, recording};
use common::talk::Talk;
use common::{longstep, root, run};
use tempfile::TempDir;

/// A folder with the plan that opens a drawer.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        let bench = Self(TempDir::new().unwrap());
        fs::write(bench.path("env.json"), ENV).unwrap();
        let mut solve = longstep(bench.0.path());
        solve
            .args(["solve", "--goal", GOAL, "--env"])
            .arg(bench.path("env.json"));
        let solved = run(solve.arg("--save").arg(bench.path("plan.json")), "");
        assert_eq!(solved.code, 0, "{}", solved.stderr);
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn teach(&self, more: &[&str]) -> Command {
        let mut command = longstep(self.0.path());
        command.arg("teach").arg(self.path("plan.json")).args(more);
        command.arg("-o").arg(self.path("skills.json"));
        command
    }

    /// A recorder that is a shell script, in which `$folder` is the folder.
    fn script(&self, text: &str) -> String {
        assert!(!text.contains('\''), "{text}");
        format!("sh -c 'folder={}; {text}'", self.0.path().display())
    }

    /// Waits until a recorder wrote a file, and removes it.
    fn wait_for(&self, name: &str) -> String {
        let begun = Instant::now();
        loop {
            if let Ok(text) = fs::read_to_string(self.path(name)) {
                fs::remove_file(self.path(name)).unwrap();
                return text;
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "no {name}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn recordings(&self) -> Vec<String> {
        let entries = fs::read_dir(self.0.path()).unwrap();
        let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|name| name.contains(".step-")).collect();
        names.sort();
        names
    }
}

/// Asserts that a process ends.
#[track_caller]
fn assert_ends(process: &str) {
    let begun = Instant::now();
    while Command::new("kill")
        .args(["-0", process.trim()])
        .stderr(Stdio::null())
        .status()
        .unwrap()
        .success()
    {
        assert!(begun.elapsed() < Duration::from_secs(20), "{process} runs");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn each_step_is_recorded_saved_and_fitted() {
    let bench = Bench::new();
    fs::write(bench.path("demo.csv"), recording(&[1, 2, 3, 4], 1.0, true)).unwrap();
    fs::write(bench.path("short.csv"), recording(&[3], 0.05, true)).unwrap();
    // The third step is shown badly first, the fourth is written as JSON Lines.
    let player = root().join("examples/teach/play.py");
    let recorder = bench.script(&format!(
        "file=demo; json=; \
         if [ $LONGSTEP_STEP = 3 ] && [ ! -e $folder/again ]; then touch $folder/again; file=short; fi; \
         if [ $LONGSTEP_STEP = 4 ]; then json=--json; fi; \
         python3 {} $folder/$file.csv --speed 20 --once $json; touch $folder/shown; exec sleep 600",
        player.display()
    ));
    let mut talk = Talk::start(&mut bench.teach(&["--recorder", &recorder]));
    for (question, answer) in [
        ("Show step 1: move the hand to the drawer handle", "Saved "),
        ("Show step 2: grasp the drawer handle", "Saved "),
        (
            "Show step 3: slide the drawer handle to open",
            "the hand moves 1.2 cm; show at least 3 cm\nShow step 3 again.",
        ),
        ("Show step 3: slide the drawer handle to open", "Saved "),
        ("Show step 4: release the drawer handle", "Saved "),
    ] {
        talk.until(&format!("{question}\nPress Enter to begin.\n"));
        talk.say("");
        talk.until("Recording. Show the step, then press Enter to end.\n");
        bench.wait_for("shown");
        talk.say("");
        talk.until("Recorded 45 frames in 1.5 s.\n");
        talk.until(answer);
    }
    let (code, text, results) = talk.finish();
    assert_eq!(code, 0, "{text}");
    let files = [
        "skills.step-1.csv",
        "skills.step-2.csv",
        "skills.step-3.csv",
        "skills.step-4.jsonl",
    ];
    assert_eq!(bench.recordings(), files);
    for file in files {
        let mode = fs::metadata(bench.path(file)).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600, "{file}");
    }
    let third = fs::read_to_string(bench.path(files[2])).unwrap();
    let played = recording(&[1, 2, 3, 4], 1.0, true);
    let own = |line: &&str| line.ends_with(",3") || line.starts_with("t,");
    assert_eq!(
        third,
        played
            .lines()
            .filter(own)
            .map(|line| format!("{line}\n"))
            .collect::<String>()
    );

    // The hint repeats the lesson, with the same values from the same files.
    let taught = fs::read_to_string(bench.path("skills.json")).unwrap();
    assert!(
        taught.contains("skills.step-3.csv, 3.03 to 4.50 s, right hand"),
        "{taught}"
    );
    let (_, hint) = results.split_once("`--demo ").unwrap();
    let files: Vec<&str> = hint.split_once('`').unwrap().0.split(' ').collect();
    fs::remove_file(bench.path("skills.json")).unwrap();
    let ran = run(&mut bench.teach(&[&["--demo"], &files[..]].concat()), "");
    assert_eq!(ran.code, 0, "{}{}", ran.stdout, ran.stderr);
    assert_eq!(fs::read_to_string(bench.path("skills.json")).unwrap(), taught);
}

/// The beginning of a good recording, in a shell.
const FRAME: &str = "printf \"t,hand,x,y,z\\n0,right,0,0,1\\n\"";

#[test]
fn a_recorder_that_cannot_be_used_is_an_error_and_the_step_is_asked_for_again() {
    let bench = Bench::new();
    let script = |text: &str| bench.script(text);
    let hint = "hint: ";
    for (recorder, enters, expected) in [
        (
            "/nowhere/tracker".to_owned(),
            1,
            "error: cannot start the recorder `/nowhere/tracker`: No such file",
        ),
        (
            script("echo no camera >&2; echo give up >&2; exit 4"),
            1,
            "The last messages of the recorder:\n  | no camera\n  | give up\n\
             error: the recorder stopped before the step was shown: its program ended with exit code 4\n",
        ),
        (
            script("exec >&-; exec sleep 600"),
            1,
            "was shown: it closed its output\n",
        ),
        (
            script("echo opening camera 0; echo ready; exec sleep 600"),
            1,
            "error: the recorder: no column `x`, `y`, `z`; name the columns",
        ),
        (
            script("echo {}; exec sleep 600"),
            1,
            "error: the recorder, frame 1: no position; a frame has",
        ),
        (script("exec cat /dev/urandom"), 1, "error: the recorder"),
        (script("exec yes"), 1, "error: the recorder: no column `x`, `z`; "),
        (
            script("exec cat /dev/zero"),
            1,
            "error: the recorder wrote a line longer than 65536 bytes",
        ),
        (script("exec sleep 600"), 1, "error: the recorder wrote nothing for 1 s"),
        (script("exec sleep 600"), 2, "error: the recorder wrote nothing\n"),
        (
            script("echo t,hand,x,y,z; touch $folder/written; exec sleep 600"),
            2,
            "error: the recorder: no frames",
        ),
        (
            script(&format!("{FRAME}; exit 0")),
            1,
            "its program ended with exit code 0",
        ),
        (
            script(&format!("{FRAME}; exec sleep 600")),
            1,
            "error: the recorder wrote nothing for 1 s",
        ),
        (
            script(&format!(
                "trap \"echo bye; exit\" INT TERM; {FRAME}; while :; do sleep 0.1; done"
            )),
            2,
            "error: the recorder, frame 2: ",
        ),
        (
            script(&format!("trap \"\" INT TERM; {FRAME}; while :; do sleep 0.1; done")),
            2,
            "error: the recorder did not end within 5 s after Ctrl-C (SIGINT) and SIGTERM; it was killed with its children",
        ),
        (
            script(&format!("{FRAME}; exec sleep 600")),
            2,
            "missing: step 1 `move_hand(<drawer_handle>)`: only 1 frames",
        ),
    ] {
        let silence = if expected.contains("for 1 s") { "1" } else { "60" };
        let mut talk = Talk::start(&mut bench.teach(&["--recorder", &recorder, "--silence", silence]));
        talk.until("Press Enter to begin.\n");
        talk.say("");
        if enters == 2 {
            let begins = recorder.contains("printf");
            talk.until(if begins { "Recording." } else { "Starting the recorder" });
            if recorder.contains("written") {
                bench.wait_for("written");
            }
            talk.say("");
        }
        talk.until(expected);
        if expected.contains("error:") {
            talk.until(hint);
        }
        talk.until("Show step 1: move the hand");
        talk.say("quit");
        let (code, text, _) = talk.finish();
        assert_eq!(code, 10, "{recorder}: {text}");
        assert_eq!(bench.recordings(), [""; 0], "{recorder}");
    }
}

#[test]
fn a_recording_can_be_discarded() {
    let bench = Bench::new();
    let recorder = bench.script(&format!(
        "echo $$ > $folder/process.new; mv $folder/process.new $folder/process; \
             {FRAME}; exec sleep 600"
    ));
    let mut talk = Talk::start(&mut bench.teach(&["--recorder", &recorder]));
    for (question, answer) in [
        ("Show step 1", "skip"),
        ("Show step 2", "back"),
        ("Show step 1", "skip"),
    ] {
        talk.until(question);
        talk.say("");
        talk.until("Recording.");
        talk.say(answer);
        talk.until("The recording is discarded.\n");
        assert_ends(&bench.wait_for("process"));
    }
    // The end of the input ends the lesson, and a recorder with it.
    talk.until("Show step 2");
    talk.say("");
    talk.until("Recording.");
    let process = bench.wait_for("process");
    let (code, text, _) = talk.finish();
    assert_eq!(code, 10, "{text}");
    assert_ends(&process);
    assert_eq!(bench.recordings(), [""; 0]);
}

#[test]
fn a_signal_ends_the_recorder_too() {
    for signal in ["INT", "TERM", "HUP"] {
        let bench = Bench::new();
        let recorder = bench.script(&format!(
            "echo $$ > $folder/process.new; mv $folder/process.new $folder/process; \
             {FRAME}; sleep 600"
        ));
        let mut talk = Talk::start(&mut bench.teach(&["--recorder", &recorder]));
        talk.until("Press Enter to begin.");
        talk.say("");
        talk.until("Recording.");
        let process = bench.wait_for("process");
        let sent = Command::new("kill")
            .args(["-s", signal, &talk.id().to_string()])
            .status();
        assert!(sent.unwrap().success());
        talk.until("error: stopped by a signal\nhint: the recordings of the steps before are saved");
        let (code, text, _) = talk.finish();
        assert_eq!(code, 50, "{text}");
        assert_ends(&process);
    }
}

#[test]
fn options_that_do_not_fit_are_errors() {
    let bench = Bench::new();
    for (more, code, expected) in [
        (
            &["--recorder", "python3 'x"][..],
            30,
            "--recorder `python3 'x`: a quote or a backslash at its end",
        ),
        (
            &["--recorder", " "],
            30,
            "it names no program\nhint: for example `--recorder \"python3 tracker.py\"`",
        ),
        (&["--recorder", "x", "--demo", "y.csv"], 2, "cannot be used with"),
        (&["--recorder", "x", "--json"], 2, "cannot be used with"),
        (&["--silence", "3"], 2, "--recorder <COMMAND>"),
        (&["--recorder", "x", "--silence", "0"], 2, "must be above 0"),
    ] {
        let ran = run(&mut bench.teach(more), "");
        assert!(ran.stderr.contains(expected), "{more:?}: {}", ran.stderr);
        assert_eq!(ran.code, code, "{more:?}: {}", ran.stderr);
    }
}
