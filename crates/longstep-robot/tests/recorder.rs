//! Recorders: real programs, good and bad. None of them may hang this program, or outlive its recording.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;
use std::time::{Duration, Instant};

use longstep_robot::CommandLine;
use longstep_robot::recorder::{Recorder, RecorderError, RecorderLimits};

const MOMENT: Duration = Duration::from_secs(1);

fn limits() -> RecorderLimits {
    RecorderLimits::default().with_silence(Duration::from_secs(20))
}

/// Records a shell script until it wrote so many lines.
fn record(script: &str, limits: RecorderLimits, lines: usize) -> Result<String, RecorderError> {
    let mut recorder = Recorder::start(&CommandLine::new(["sh", "-c", script]), limits)?;
    while recorder.look()? < lines {
        recorder.wait(Duration::from_millis(20));
    }
    Ok(String::from_utf8(recorder.finish()?).unwrap())
}

#[test]
fn a_recording_has_the_complete_lines_until_the_end() {
    for (script, expected) in [
        ("printf 'a\\n\\nb\\n'; exec sleep 60", "a\n\nb\n"),
        // A program that is ended in the middle of a line.
        ("printf 'a\\nb\\n1.2'; exec sleep 60", "a\nb\n"),
        // A program with a buffer writes the rest when it ends.
        (
            "trap 'echo c; exit 1' INT TERM; printf 'a\\nb\\n'; while :; do sleep 0.05; done",
            "a\nb\nc\n",
        ),
        // A program that does not hear Ctrl-C, as none does that a shell started in the background.
        ("trap '' INT; printf 'a\\nb\\n'; exec sleep 60", "a\nb\n"),
        // A program that ends with its input.
        ("trap '' INT; printf 'a\\nb\\n'; cat; printf 'c\\n'", "a\nb\nc\n"),
    ] {
        assert_eq!(record(script, limits(), 2).unwrap(), expected, "{script}");
    }
}

#[test]
fn recorders_that_cannot_be_used_are_errors() {
    let ended = |reason: &str, messages: &str| RecorderError::EndedEarly {
        reason: reason.to_owned(),
        messages: messages.to_owned(),
    };
    let silent = limits().with_silence(MOMENT);
    let short = limits().with_duration(MOMENT);
    let small = limits().with_bytes(1 << 20);
    for (script, limits, expected) in [
        (
            "echo a; exit 3",
            limits(),
            ended("its program ended with exit code 3", ""),
        ),
        ("kill -9 $$", limits(), ended("its program was ended by signal 9", "")),
        (
            "echo 'no camera' >&2; exit 1",
            limits(),
            ended("its program ended with exit code 1", "no camera"),
        ),
        ("exec >&-; exec sleep 60", limits(), ended("it closed its output", "")),
        (
            "echo waiting >&2; exec sleep 60",
            silent.clone(),
            RecorderError::Silent {
                limit: MOMENT,
                messages: "waiting".to_owned(),
            },
        ),
        (
            "echo a; exec sleep 60",
            silent,
            RecorderError::Silent {
                limit: MOMENT,
                messages: String::new(),
            },
        ),
        (
            "while :; do echo a; sleep 0.05; done",
            short,
            RecorderError::TooLong { limit: MOMENT },
        ),
        ("exec yes", small, RecorderError::TooLarge { limit: 1 << 20 }),
        (
            "exec cat /dev/zero",
            limits(),
            RecorderError::LongLine { limit: 64 << 10 },
        ),
    ] {
        let begun = Instant::now();
        let error = record(script, limits, usize::MAX).unwrap_err();
        assert_eq!(error, expected, "{script}");
        assert!(!error.hint().is_empty() && begun.elapsed() < Duration::from_secs(20));
    }
    assert_eq!(
        record("exec sleep 60", limits(), 0).unwrap_err(),
        RecorderError::Empty {
            messages: String::new()
        }
    );
    let missing = Recorder::start(&CommandLine::new(["/nowhere/tracker", "a b"]), limits()).unwrap_err();
    assert_eq!(
        missing.to_string(),
        "cannot start the recorder `/nowhere/tracker 'a b'`: No such file or directory (os error 2)"
    );
}

/// Waits until a process is gone.
fn is_gone(process: &str) -> bool {
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(10) {
        let status = std::fs::read_to_string(Path::new("/proc").join(process).join("status"));
        // A process that nobody reaped yet is gone, too.
        if status.map_or(true, |status| status.contains("State:\tZ")) {
            return true;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    false
}

#[test]
#[cfg(target_os = "linux")]
fn no_process_outlives_its_recording() {
    let limits = limits().with_ending(MOMENT);
    // Its own number and that of a child, both deaf to Ctrl-C.
    let deaf = "trap '' INT TERM HUP; sleep 600 & echo $$; echo $!; while :; do sleep 0.1; done";
    // The children are left behind.
    let parent = "sleep 600 & echo $$; echo $!; exec sleep 600";
    for (script, finishes, is_ended) in [(deaf, true, false), (deaf, false, false), (parent, true, true)] {
        let mut recorder = Recorder::start(&CommandLine::new(["sh", "-c", script]), limits.clone()).unwrap();
        while recorder.look().unwrap() < 2 {
            recorder.wait(Duration::from_millis(20));
        }
        let processes = String::from_utf8(recorder.recording().to_vec()).unwrap();
        if finishes {
            assert_eq!(
                recorder.finish().err(),
                (!is_ended).then_some(RecorderError::NotEnded { limit: MOMENT })
            )
        } else {
            drop(recorder)
        }
        for process in processes.lines() {
            assert!(is_gone(process), "{script}: {process}");
        }
    }
}

#[test]
fn the_environment_of_a_recorder_is_set() {
    let command = CommandLine::new(["sh", "-c", "echo $LONGSTEP_STEP; pwd; exec sleep 60"])
        .variable("LONGSTEP_STEP", "3")
        .folder("/");
    let mut recorder = Recorder::start(&command, limits()).unwrap();
    while recorder.look().unwrap() < 2 {
        recorder.wait(Duration::from_millis(20));
    }
    assert_eq!(recorder.finish().unwrap(), b"3\n/\n");
}
