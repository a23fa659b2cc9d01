//! Robots that are opened by their reference.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::fs;
use std::path::Path;

use longstep_core::autonomy::Level;
use longstep_core::environment::{self, World};
use longstep_core::{diagnostic::Diagnostics, domain};
use longstep_robot::{OpenError, OpenOptions, Opened, RobotError, RunStart, StopRequest, open};

fn pantry() -> World {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = fs::read_to_string(root.join("examples/environments/pantry.json")).unwrap();
    environment::parse(&domain::shipped("household").unwrap().unwrap(), "pantry.json", &text).unwrap()
}

fn opened(named: &str, request: &StopRequest) -> Result<Opened, OpenError> {
    let folder = tempfile::tempdir().unwrap();
    let options = OpenOptions::default().with_locks(folder.path().to_owned());
    open(&named.parse().unwrap(), &pantry(), &options, request, RunStart::New)
}

#[test]
fn robot_that_is_no_simulation_is_opened_as_a_dry_run() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let request = StopRequest::default();
    let dry = opened(&format!("ros2:{root}/examples/robots/ros2/robot.toml"), &request).unwrap();
    assert!(dry.is_dry && dry.cancelled == 0);
    assert!(!opened("sim", &request).unwrap().is_dry);
}

/// The tables of levels and limits in `robot.toml` come with the robot, and their mistakes are mistakes of the file.
#[test]
fn robot_toml_has_levels_and_limits() {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
    let text = fs::read_to_string(format!("{root}/examples/robots/ros2/robot.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.toml");
    let open = |tables: &str| {
        fs::write(&file, format!("{text}\n{tables}\n")).unwrap();
        opened(&format!("ros2:{}", file.display()), &StopRequest::default())
    };
    let domain = pantry().domain().clone();
    let attach = domain.action_ids().find(|(_, own)| own.name == "attach").unwrap().0;
    let limited = open("[autonomy]\nattach = \"never\"\n[[limit]]\nforbidden = [\"fridge\"]").unwrap();
    assert_eq!(limited.autonomy.level(attach), Level::Never);
    assert_eq!(limited.autonomy.limits().len(), 1);
    assert!(open("").unwrap().autonomy.is_empty());
    for (tables, expected) in [
        ("[autonomy]\natach = \"never\"", "unknown action `atach`"),
        ("[[limit]]\nforbidden = [\"frigde\"]", "unknown place `frigde`"),
    ] {
        let error = open(tables).err().unwrap();
        let OpenError::Configuration(Diagnostics(findings)) = &error else {
            panic!("{error}")
        };
        assert!(
            findings[0].message == expected && findings[0].position.is_some(),
            "{findings:?}"
        );
    }
}

#[test]
fn opening_fails_with_a_reason_and_a_hint() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.toml");
    fs::write(&file, "name = \"arm\"\nurl = \"ws://127.0.0.1:9\"\nallow = [\"fly\"]\n").unwrap();
    let request = StopRequest::default();
    let error = |named: &str| opened(named, &request).err().unwrap();

    let missing = error("ros2:no/such/robot.toml");
    assert!(matches!(missing, OpenError::File(_)), "{missing}");
    assert_eq!(missing.hint(), Some("check the path"));
    let OpenError::Configuration(Diagnostics(findings)) = error(&format!("ros2:{}", file.display())) else {
        panic!("the domain has no action `fly`")
    };
    assert!(findings.iter().any(|own| own.message.contains("fly")), "{findings:?}");
    #[cfg(unix)]
    {
        let gone = error("process:/no/such/program");
        assert!(
            matches!(gone, OpenError::Robot(RobotError::Unreachable { .. })),
            "{gone}"
        );
        assert!(gone.hint().is_some());
    }
}

#[test]
fn request_to_stop_before_the_opening_ends_it() {
    let request = StopRequest::default();
    request.stop();
    let error = opened("sim", &request).err().unwrap();
    assert!(matches!(error, OpenError::Robot(RobotError::Stopped)), "{error}");
}
