//! Robots behind a program: real programs in Python, good and bad.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::{Path, PathBuf};
use std::time::Duration;

use longstep_robot::process::{Command, Process};
use longstep_robot::{Handle, Order, Progress, Robot, RobotError, Scope};

/// Starts the robot with a fault, and returns it with the file of what it receives.
fn faulty(fault: &str, folder: &tempfile::TempDir) -> (Result<Process, RobotError>, PathBuf) {
    let log = folder.path().join("received");
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/robots/faulty.py");
    let words = [program.to_str().unwrap(), fault, log.to_str().unwrap()].map(str::to_owned);
    let words = std::iter::once("python3".to_owned()).chain(words);
    (Command::new(words).startup(Duration::from_secs(10)).open(), log)
}

fn order(step: usize) -> Order {
    Order::new(step, "grasp", ["<cup>"])
}

/// Polls an order until its end.
fn finish(robot: &mut Process, handle: Handle) -> Result<Progress, RobotError> {
    loop {
        match robot.poll(handle)? {
            Progress::Running(_) => robot.wait(Duration::from_millis(50)),
            progress => return Ok(progress),
        }
    }
}

/// Performs a step, then tries further ones, and returns the first error.
fn first_error(robot: &mut Process) -> RobotError {
    let result = robot.start(&order(1)).and_then(|handle| finish(robot, handle));
    match result {
        Err(error) => error,
        // A second message may be on its way while the first one is used. The robot waits after it, so that observing
        // reads it at the latest.
        Ok(_) => robot.observe(&Scope::All).unwrap_err(),
    }
}

fn received(log: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(log).unwrap();
    text.lines().map(str::to_owned).collect()
}

#[track_caller]
fn check_failure(fault: &str, expected: &str) {
    let folder = tempfile::tempdir().unwrap();
    let (robot, log) = faulty(fault, &folder);
    let mut robot = robot.unwrap();
    let error = first_error(&mut robot);
    assert!(error.is_final(), "{error}");
    assert_eq!(error.to_string(), expected, "{fault}");
    // The same error again, whatever is tried.
    assert_eq!(robot.start(&order(2)).unwrap_err(), error);
    assert_eq!(robot.poll(Handle::new(2)).unwrap_err(), error);
    assert_eq!(robot.observe(&Scope::All).unwrap_err(), error);
    let stopped = robot.stop();
    assert_eq!(robot.stop(), stopped);
    drop(robot);
    let orders = received(&log).iter().filter(|method| *method == "perform").count();
    assert_eq!(orders, 1, "{fault}");
}

#[test]
fn exit_of_the_robot_process_is_reported() {
    check_failure(
        "dies",
        "the robot is gone: its program ended with exit code 3; its last messages:\nthe gripper is on fire",
    );
    check_failure("is killed", "the robot is gone: its program was ended by signal 9");
    check_failure("closes its output", "the robot is gone: it closed its output or input");
}

#[test]
fn a_robot_that_hangs_times_out() {
    check_failure("hangs", "the robot did not answer within 2 s: step 1");
    check_failure(
        "writes lines without end",
        "the robot did not answer within 2 s: step 1",
    );
}

#[test]
fn a_robot_that_answers_nonsense_breaks_the_protocol() {
    let broken = |reason: &str| format!("the robot broke the protocol: {reason}");
    for (fault, reason) in [
        ("writes text", "it wrote a line that is not JSON: `moving...`"),
        ("answers twice", "it answered request 2 twice"),
        ("answers another request", "it answered request 9, which does not exist"),
        (
            "reports after the end",
            "it sent feedback for 2, which is no order under way",
        ),
        (
            "does not understand",
            "it answered `perform` with error -32601: no such method",
        ),
        (
            "senses without order",
            "its answer to step 1 does not fit (`(expired <milk>)` is no outcome of the order)",
        ),
        (
            "sends a request",
            "it wrote a message that is neither an answer nor `feedback`: \
             `{\"jsonrpc\": \"2.0\", \"id\": 1, \"method\": \"perform\", \"params\": {}}`",
        ),
        ("writes a line without end", "it wrote a line longer than 1 MiB"),
    ] {
        check_failure(fault, &broken(reason));
    }
}

#[test]
fn standard_error_may_be_flooded() {
    let folder = tempfile::tempdir().unwrap();
    let mut robot = faulty("floods standard error", &folder).0.unwrap();
    let RobotError::Gone { reason, messages } = first_error(&mut robot) else {
        panic!("not gone");
    };
    assert_eq!(reason, "its program ended with exit code 4");
    assert!(messages.ends_with("the last line"), "{messages}");
    assert!(messages.len() <= 4096);
}

#[test]
fn a_failed_step_leaves_the_robot_usable() {
    let folder = tempfile::tempdir().unwrap();
    let mut robot = faulty("slips", &folder).0.unwrap();
    for step in 1..=2 {
        let handle = robot.start(&order(step)).unwrap();
        assert_eq!(robot.start(&order(9)), Err(RobotError::Busy { limit: 1 }));
        // The robot fails the order only now, so that the second one met a busy robot.
        robot.observe(&Scope::All).unwrap();
        let reason = "the can slipped".to_owned();
        assert_eq!(finish(&mut robot, handle), Ok(Progress::Failed { reason }));
        assert_eq!(robot.poll(handle), Err(RobotError::UnknownHandle(handle)));
    }
    let seen = robot.observe(&Scope::Entities(vec!["<cup>".to_owned()])).unwrap();
    assert_eq!(seen.of_entity("<cup>"), Some(&["on_something(<table>)".to_owned()][..]));
}

#[test]
fn only_the_newest_feedback_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut robot = faulty("reports much", &folder).0.unwrap();
    let handle = robot.start(&order(1)).unwrap();
    // The answer comes last, so that all feedback was read when an observation is back.
    robot.observe(&Scope::All).unwrap();
    let mut texts = Vec::new();
    while let Progress::Running(feedback) = robot.poll(handle).unwrap() {
        texts.extend(feedback.and_then(|feedback| feedback.text));
    }
    let expected: Vec<String> = (36..100).map(|count| count.to_string()).collect();
    assert_eq!(texts, expected);
}

#[test]
fn observations_are_checked() {
    let observe = |fault| {
        let folder = tempfile::tempdir().unwrap();
        let mut robot = faulty(fault, &folder).0.unwrap();
        let error = robot.observe(&Scope::All).unwrap_err();
        (error.to_string(), error.is_final())
    };
    let refused = "the robot refused `observe`: the camera is covered";
    assert_eq!(observe("cannot see"), (refused.to_owned(), false));
    let late = "the robot did not answer within 1 s: observe";
    assert_eq!(observe("does not observe"), (late.to_owned(), true));
    let (error, is_final) = observe("observes nonsense");
    assert!(
        is_final && error.contains("its answer to `observe` does not fit"),
        "{error}"
    );
}

#[test]
fn a_robot_that_does_not_begin_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let version = faulty("speaks version 2", &folder).0.unwrap_err().to_string();
    assert_eq!(
        version,
        "the robot speaks protocol version 2, but version 1 is required"
    );
    let limit = Duration::from_millis(300);
    let silent = Command::parse("sleep 1000").unwrap().startup(limit).open().unwrap_err();
    let what = "initialize".to_owned();
    assert_eq!(silent, RobotError::TimedOut { what, limit });
    let missing = Command::parse("no-such-program-for-robots")
        .unwrap()
        .open()
        .unwrap_err();
    assert!(matches!(missing, RobotError::Unreachable { .. }), "{missing}");
    let short = Command::parse("true").unwrap().open().unwrap_err();
    assert_eq!(
        short.to_string(),
        "the robot is gone: its program ended with exit code 0"
    );
}

#[test]
fn a_stop_is_confirmed_and_final() {
    let folder = tempfile::tempdir().unwrap();
    let (robot, log) = faulty("none", &folder);
    let mut robot = robot.unwrap();
    let handle = robot.start(&order(1)).unwrap();
    finish(&mut robot, handle).unwrap();
    assert_eq!((robot.stop(), robot.stop()), (Ok(()), Ok(())));
    assert_eq!(robot.start(&order(2)), Err(RobotError::Stopped));
    robot.stop_switch().press();
    drop(robot);
    assert_eq!(received(&log), ["initialize", "perform", "stop", "shutdown"]);
}

#[test]
fn a_stop_that_is_not_confirmed_ends_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let (robot, log) = faulty("ignores stop", &folder);
    let mut robot = robot.unwrap();
    robot.start(&order(1)).unwrap();
    let limit = Duration::from_secs(1);
    let what = "stop".to_owned();
    assert_eq!(robot.stop(), Err(RobotError::TimedOut { what, limit }));
    drop(robot);
    assert_eq!(received(&log), ["initialize", "perform", "stop"]);
}

#[test]
fn stop_switch_works_while_another_thread_waits() {
    let folder = tempfile::tempdir().unwrap();
    let (robot, log) = faulty("stop while it observes", &folder);
    let mut robot = robot.unwrap();
    let switch = robot.stop_switch();
    let handle = robot.start(&order(1)).unwrap();
    finish(&mut robot, handle).unwrap();
    let presser = std::thread::spawn(move || switch.press());
    // Either the observation was first, or it is not made any more.
    let error = loop {
        if let Err(error) = robot.observe(&Scope::All) {
            break error;
        }
    };
    assert_eq!(error, RobotError::Stopped);
    presser.join().unwrap();
    drop(robot);
    assert_eq!(received(&log).iter().filter(|method| *method == "stop").count(), 1);
}

/// Returns true if a process runs, or waits to be reaped by a process other than this one.
fn is_running(pid: &str) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    !matches!(
        status.rsplit(") ").next().and_then(|rest| rest.chars().next()),
        None | Some('Z' | 'X')
    )
}

#[cfg(target_os = "linux")]
#[test]
fn children_end_with_the_program() {
    for fault in ["hangs with children", "leaves a child"] {
        let folder = tempfile::tempdir().unwrap();
        let (robot, log) = faulty(fault, &folder);
        let mut robot = robot.unwrap();
        let handle = robot.start(&order(1)).unwrap();
        finish(&mut robot, handle).unwrap_err();
        let _unconfirmed = robot.stop();
        drop(robot);
        let lines = received(&log);
        let child = lines.iter().find(|line| line.parse::<u32>().is_ok()).unwrap();
        // The signal is sent; the system ends the process a moment later.
        let mut looks = 0;
        while is_running(child) && looks < 1000 {
            std::thread::sleep(Duration::from_millis(5));
            looks += 1;
        }
        assert!(!is_running(child), "{fault}");
    }
}
