//! Measures the time from a stop switch to the robot's `stop`, while a step hangs and while an observation hangs.
//!
//! ```sh
//! cargo run --release -p longstep-robot --example stop_latency
//! ```
#![allow(clippy::print_stdout, missing_docs)]

#[cfg(unix)]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    use longstep_robot::process::Command;
    use longstep_robot::{Order, Robot, Scope};
    use std::time::{Duration, SystemTime};

    /// A robot whose steps and observations never end. It answers `stop` with the time at which it received it.
    const ROBOT: &str = r#"
import json, sys, time
for line in sys.stdin:
    now = time.time_ns()
    message = json.loads(line)
    if message["method"] == "stop":
        open(sys.argv[1], "w").write(str(now))
    if message["method"] in ("initialize", "stop"):
        result = {"protocol": 1, "name": "hanging", "capabilities": {"observe": True}}
        print(json.dumps({"jsonrpc": "2.0", "id": message["id"], "result": result}), flush=True)
"#;

    let folder = tempfile::tempdir()?;
    for observes in [false, true] {
        let mut times = Vec::new();
        for number in 0..100 {
            let file = folder.path().join(number.to_string());
            let words = ["python3".into(), "-c".into(), ROBOT.into(), file.display().to_string()];
            let mut robot = Command::new::<String>(words).open()?;
            robot.start(&Order::new(1, "grasp", ["<cup>"]))?;
            let switch = robot.stop_switch();
            let presser = std::thread::spawn(move || {
                std::thread::sleep(Duration::from_millis(20));
                let pressed = SystemTime::now();
                switch.press();
                pressed
            });
            if observes && robot.observe(&Scope::All).is_ok() {
                return Err("the observation did not hang".into());
            }
            let pressed = presser
                .join()
                .map_err(|_| "the switch failed")?
                .duration_since(SystemTime::UNIX_EPOCH)?;
            robot.stop()?;
            let received = Duration::from_nanos(std::fs::read_to_string(&file)?.parse()?);
            times.push(received.saturating_sub(pressed));
        }
        times.sort();
        let what = if observes { "an observation" } else { "a step" };
        println!(
            "{what} hangs: median {:?}, longest {:?} of {}",
            times[50],
            times[99],
            times.len()
        );
        if times[99] > Duration::from_secs(1) {
            return Err("a stop took more than a second".into());
        }
    }
    Ok(())
}

#[cfg(not(unix))]
fn main() {}
