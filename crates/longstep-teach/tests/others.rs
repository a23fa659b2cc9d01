//! Recordings as other programs write them: spreadsheets, Motive, PlotJuggler, ROS 2 bags.
#![allow(clippy::panic, clippy::unwrap_used)]

mod bag;

use bag::{Message, bag, pose_stamped, string};
use longstep_teach::{Demonstration, Format, Hand, cut_at_times, step_times};

/// The frames of a recording in short: time, hand, position, grip.
fn frames(recording: &Demonstration) -> Vec<String> {
    let shown = |frame: &longstep_teach::Frame| {
        let place: Vec<String> = frame
            .position
            .iter()
            .map(|part| format!("{}", (part * 1e6).round() / 1e6))
            .collect();
        let grip = frame.grip.map_or_else(String::new, |grip| format!(" {grip}"));
        format!("{:.3} {} {}{grip}", frame.time, frame.hand, place.join(" "))
    };
    recording.frames.iter().map(shown).collect()
}

fn csv(text: &str) -> Demonstration {
    Demonstration::read("demo", Format::Csv, text.as_bytes()).unwrap_or_else(|error| panic!("{text}\n{error}"))
}

fn error(format: Format, bytes: &[u8]) -> String {
    Demonstration::read("demo", format, bytes).unwrap_err().to_string()
}

#[test]
fn tables_of_others_give_the_same_frames() {
    let expected = ["0.000 right 0.1 0.2 0.3 0", "0.100 right 0.4 0.5 0.6 1"];
    for (text, notes) in [
        (
            "t,hand,x,y,z,grip\n0,right,0.1,0.2,0.3,0\n0.1,right,0.4,0.5,0.6,1\n",
            &[][..],
        ),
        (
            "\u{feff}t;hand;x;y;z;grip\r\n0,0;right;0,1;0,2;0,3;0\r\n0,1;right;0,4;0,5;0,6;1\r\n",
            &["numbers have decimal commas"],
        ),
        (
            "sep=;\nt;hand;x;y;z;grip;\n0;right;0.1;0.2;0.3;0;\n0.1;right;0.4;0.5;0.6;1;\n",
            &[],
        ),
        (
            "t\thand\tx\ty\tz\tgrip\n0\tright\t0.1\t0.2\t0.3\t0\n0.1\tright\t0.4\t0.5\t0.6\t1\n",
            &[],
        ),
        (
            "t,hand,x,y,z,grip\n0,right,0.1,0.2,0.3,0\n0.05,right,,,,0\n0.06,right,nan,NaN,nan,\n0.1,right,0.4,0.5,0.6,1\n",
            &["2 rows have no position: gaps"],
        ),
        (
            "Time,X,Y,Z,grip\n0,0.1,0.2,0.3,false\n0.1,0.4,0.5,0.6,true\n",
            &["nothing says which hand it is; read as the right hand"],
        ),
        (
            "__time,/tool/pose/position/x,/tool/pose/position/y,/tool/pose/position/z,/gripper/closed,/load\n\
             1700000000.0,,,,0,0.7\n1700000000.01,0.1,0.2,0.3,,\n1700000000.05,,,,1,\n1700000000.11,0.4,0.5,0.6,,\n",
            &[
                "`/gripper/closed` is read as `grip`",
                "columns that are not read: `/load`",
                "`/tool/pose` is the right hand",
                "times are seconds since the epoch; the first frame is at 0 s",
            ],
        ),
    ] {
        let recording = csv(text);
        assert_eq!(frames(&recording), expected, "{text}");
        assert_eq!(recording.notes, notes, "{text}");
    }
}

#[test]
fn two_hands_in_one_row_are_two_frames() {
    let names = ["left", "right"].map(|hand| ["x", "y", "z"].map(|axis| format!("/{hand}_wrist/position/{axis}")));
    let text = format!("timestamp,{}\n1,0,0,1,2,2,2\n2,0,0,1,,,\n", names.concat().join(","));
    assert_eq!(
        frames(&csv(&text)),
        ["1.000 left 0 0 1", "1.000 right 2 2 2", "2.000 left 0 0 1"]
    );
}

/// A table of Motive with a rigid body, one of its markers, and two frames, of which the second has lost the body.
fn motive(unit: &str, bodies: &str, more: &str) -> String {
    format!(
        "Format Version,1.23,Take Name,reach,Rotation Type,Quaternion,Length Units,{unit},Coordinate Space,Global{more}\n\n\
         ,,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker\n\
         ,,{bodies}\n\
         ,,\"1\",\"1\",\"1\",\"1\",\"1\",\"1\",\"1\",\"1\",\"2\",\"2\",\"2\"\n\
         ,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error,Position,Position,Position\n\
         Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z\n\
         0,0.0,0,0,0,1,100,200,-300,0.1,1,2,3\n1,0.1,,,,,,,,,1,2,3\n2,0.2,0,1,0,0,110,200,-300,0.1,,,\n"
    )
}

#[test]
fn the_heading_of_motive_says_units_and_axes() {
    let right = ["Right Hand"; 8].join(",") + ",Marker 1,Marker 1,Marker 1";
    let left = ["leftHand"; 8].join(",") + ",m,m,m";
    for (text, expected, note) in [
        (
            motive("Millimeters", &right, ""),
            ["0.000 right 0.1 0.3 0.2", "0.200 right 0.11 0.3 0.2"],
            "the heading of Motive says Millimeters; y is up",
        ),
        (
            motive("Centimeters", &left, ""),
            ["0.000 left 1 3 2", "0.200 left 1.1 3 2"],
            "the heading of Motive says Centimeters; y is up",
        ),
        (
            motive("Millimeters", &right, ",Up Axis,Z"),
            ["0.000 right 0.1 0.2 -0.3", "0.200 right 0.11 0.2 -0.3"],
            "the heading of Motive says Millimeters; z is up",
        ),
    ] {
        let recording = csv(&text);
        assert_eq!(frames(&recording), expected);
        assert_eq!(recording.notes[0], note);
        assert!(recording.notes.contains(&"1 row has no position: a gap".to_owned()));
    }
    let turned = csv(&motive("Millimeters", &right, ""));
    assert_eq!(turned.frames[1].orientation, Some([0.0, 0.0, 1.0, 0.0]));
    assert!(
        error(Format::Csv, motive("Feet", &right, "").as_bytes())
            .contains("has the length unit `Feet`; export in meters")
    );
}

#[test]
fn tables_that_are_not_clear_say_what_to_rename() {
    let position = |name: &str| ["x", "y", "z"].map(|axis| format!("/{name}/position/{axis}")).join(",");
    for (text, expected) in [
        (
            "time,hand,px,py,pz\n0,right,1,1,1\n",
            "no column `x`, `y`, `z`; name the columns of the position",
        ),
        (
            "t,hand,x,y,z,elbow\n0,right,1,1,1,1\n",
            "unknown column `elbow`; rename it",
        ),
        ("t,time,x,y,z\n0,0,1,1,1\n", "`t`, `time` mean the same; take one out"),
        ("t,x,y,z\n0,1,2,,\n", "found record with 5 fields"),
        ("t,x,y,z\n0,1,2,\n", "frame 1: `x`, `y` and `z` belong together"),
        ("t,x,y,z\n0,,,\n1,,,\n", "demo: none of its 2 rows has a position"),
        ("t,x,y,z\n0,a,2,3\n", "frame 1: column 2 is `a`, and not a number"),
        (
            &format!("__time,{},{}\n0,0,0,0,1,1,1\n", position("camera"), position("base")),
            "`/camera`, `/base` have positions, and no name says which one is the hand; keep one, or name it `hand`",
        ),
        (
            &format!("__time,{},/a/closed,/b/closed\n0,0,0,0,1,1\n", position("hand")),
            "`/a/closed`, `/b/closed` may all be the grip; rename one to `grip`",
        ),
        (
            &motive("Millimeters", "a,a,a,a,a,a,a,a,m,m,m", "").replace("Position", "Place"),
            "has no columns `Position`",
        ),
        (
            "Format Version,1.23\n\n,,x\n",
            "no line that begins with `Frame` and `Time`",
        ),
    ] {
        let error = error(Format::Csv, text.as_bytes());
        assert!(error.contains(expected), "{text}: {error}");
    }
    let wide: Vec<u8> = "t,x".encode_utf16().flat_map(u16::to_le_bytes).collect();
    let error = error(Format::Csv, &[&[0xff, 0xfe][..], &wide].concat());
    assert_eq!(error, "demo: the text is UTF-16; save it as CSV in UTF-8");
}

/// A tracker that has not seen the hand yet is no mistake for a recorder, which goes on.
#[test]
fn recording_of_gaps_alone_is_marked_as_without_position() {
    let is_without = |text: &str| {
        let error = Demonstration::read("demo", Format::of_lines(text.as_bytes()), text.as_bytes()).unwrap_err();
        error.is_without_position
    };
    assert!(is_without("t,hand,x,y,z\n0,left,,,\n"));
    assert!(is_without("{\"t\": 0, \"hand\": \"left\", \"x\": null}\n"));
    assert!(!is_without("t,hand,x,y,z\n0,left,,,\n1,left,1,,\n"));
}

#[test]
fn times_since_the_epoch_are_cut_at_seconds() {
    for (unit, digits) in [(1.0, ""), (1e9, "000000000")] {
        let row = |time: f64| {
            format!(
                r#"{{"t": {}, "hand": "left", "x": 0, "y": 0, "z": {time}}}"#,
                1.7e9 * unit + time * unit
            )
        };
        let text: Vec<String> = (0..40).map(|part| row(f64::from(part) / 10.0)).collect();
        let recording = Demonstration::read("demo", Format::JsonLines, text.join("\n").as_bytes()).unwrap();
        assert!((recording.frames[10].time - 1.0).abs() < 1e-5);
        for times in ["1:0.95-2.05", "1:1700000000.95-1700000002.05"] {
            let segments = cut_at_times(&recording, &step_times(times).unwrap());
            assert_eq!(segments[0].frames.len(), 11, "{times} {digits}");
        }
    }
}

#[test]
fn messages_of_ros_in_json_are_read() {
    let row = |sec: u32| {
        format!(
            r#"{{"header": {{"stamp": {{"sec": {sec}, "nanosec": 500000000}}, "frame_id": "base"}},
                "pose": {{"position": {{"x": {sec}, "y": 0, "z": 1}}, "orientation": {{"x": 0, "y": 0, "z": 0, "w": 1}}}}}}"#
        )
    };
    let text = format!("[{}, {}]", row(1), row(2));
    let recording = Demonstration::read_hand("demo", Format::Json, text.as_bytes(), Hand::Left).unwrap();
    assert_eq!(frames(&recording), ["1.500 left 1 0 1", "2.500 left 2 0 1"]);
    assert_eq!(recording.reference.as_deref(), Some("base"));
    let lost = text
        .replace(r#""x": 1,"#, r#""x": null,"#)
        .replace(r#""y": 0, "z": 1}"#, r#""y": null, "z": null}"#);
    assert!(error(Format::Json, lost.as_bytes()).contains("belong together"));
}

#[test]
fn bags_of_ros_2_are_read_with_every_compression() {
    let stamp = |part: u64| (1_700_000_000 + part as i32, 250_000_000);
    let at = |part: u64| 1_700_000_000_000_000_000 + part * 1_000_000_000;
    let poses: Vec<Message> = (0..3)
        .map(|part| {
            Message::new(
                "/hand_pose",
                "geometry_msgs/msg/PoseStamped",
                at(part),
                pose_stamped(stamp(part), "world", [0.1, 0.0, part as f64]),
            )
        })
        .collect();
    let mut grips: Vec<Message> = Vec::new();
    for (index, pose) in poses.into_iter().enumerate() {
        let closed = vec![0, 1, 0, 0, u8::from(index > 0)];
        grips.push(Message::new(
            "/gripper/closed",
            "std_msgs/msg/Bool",
            at(index as u64) - 1,
            closed,
        ));
        grips.push(Message::new(
            "/log",
            "rcl_interfaces/msg/Log",
            at(index as u64),
            vec![0, 1, 0, 0, 7],
        ));
        grips.push(pose);
    }
    for compression in [None, Some(mcap::Compression::Zstd), Some(mcap::Compression::Lz4)] {
        let file = bag(&grips, compression);
        let recording = Demonstration::read("demo", Format::Mcap, &file).unwrap();
        assert_eq!(
            frames(&recording),
            [
                "0.000 right 0.1 0 0 0",
                "1.000 right 0.1 0 1 1",
                "2.000 right 0.1 0 2 1"
            ]
        );
        assert_eq!(recording.reference.as_deref(), Some("world"));
        assert!((recording.begins - 1_700_000_000.25).abs() < 1e-5);
        let expected = [
            "channels that are not read: `/log (rcl_interfaces/msg/Log)`",
            "`/hand_pose` is the right hand",
            "times are seconds since the epoch; the first frame is at 0 s",
        ];
        assert_eq!(recording.notes, expected);
    }
}

#[test]
fn every_type_with_a_pose_is_read() {
    let numbers = |big: bool, all: &[f64]| -> Vec<u8> {
        all.iter()
            .flat_map(|own| if big { own.to_be_bytes() } else { own.to_le_bytes() })
            .collect()
    };
    let pose = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0];
    let little = |body: Vec<u8>| [vec![0, 1, 0, 0], body].concat();
    let header = |frame: &str| [7u32.to_le_bytes().to_vec(), 0u32.to_le_bytes().to_vec(), string(frame)].concat();
    // The lengths of the names are such that the numbers of 8 bytes need no filling before them.
    let (frame, child) = (header("world_frame"), string("right_hand_"));
    for (kind, data) in [
        ("geometry_msgs/msg/Pose", little(numbers(false, &pose))),
        ("geometry_msgs/Pose", [vec![0, 0, 0, 0], numbers(true, &pose)].concat()),
        ("geometry_msgs/msg/Point", little(numbers(false, &pose[..3]))),
        (
            "geometry_msgs/msg/PointStamped",
            little([frame.clone(), numbers(false, &pose[..3])].concat()),
        ),
        (
            "geometry_msgs/msg/PoseWithCovarianceStamped",
            little([frame.clone(), numbers(false, &pose), numbers(false, &[0.0; 36])].concat()),
        ),
        (
            "nav_msgs/msg/Odometry",
            little(
                [
                    frame.clone(),
                    child.clone(),
                    numbers(false, &pose),
                    numbers(false, &[0.0; 80]),
                ]
                .concat(),
            ),
        ),
        (
            "geometry_msgs/msg/TransformStamped",
            little([frame.clone(), child.clone(), numbers(false, &pose)].concat()),
        ),
        (
            "tf2_msgs/msg/TFMessage",
            little(
                [
                    1u32.to_le_bytes().to_vec(),
                    header("world"),
                    child.clone(),
                    numbers(false, &pose),
                ]
                .concat(),
            ),
        ),
    ] {
        let file = bag(&[Message::new("/tracker", kind, 7_000_000_000, data)], None);
        let recording =
            Demonstration::read("demo", Format::Mcap, &file).unwrap_or_else(|error| panic!("{kind}: {error}"));
        assert_eq!(frames(&recording), ["7.000 right 1 2 3"], "{kind}");
    }
}

#[test]
fn bags_without_a_hand_say_why() {
    let poses = |topics: &[&str]| -> Vec<Message> {
        let pose = |topic: &&str| {
            Message::new(
                topic,
                "geometry_msgs/msg/PoseStamped",
                1,
                pose_stamped((1, 0), "map", [0.0; 3]),
            )
        };
        topics.iter().map(pose).collect()
    };
    for (messages, expected) in [
        (
            poses(&["/camera", "/base"]),
            "`/camera`, `/base` have positions, and no name says which one is the hand",
        ),
        (
            vec![Message::new("/image", "sensor_msgs/msg/Image", 1, vec![0, 1, 0, 0])],
            "no channel has positions: `/image (sensor_msgs/msg/Image)`; record JSON, or `geometry_msgs/PoseStamped`",
        ),
        (
            vec![Message::new("/hand", "geometry_msgs/msg/Pose", 1, vec![0, 1, 0, 0, 1])],
            "a message of `/hand`: ",
        ),
        (
            vec![Message::new("/hand", "geometry_msgs/msg/Pose", 1, vec![0, 7, 0, 0, 1])],
            "the CDR encoding 7 is not read",
        ),
    ] {
        let error = error(Format::Mcap, &bag(&messages, None));
        assert!(error.contains(expected), "{error}");
    }
    let whole = bag(&poses(&["/hand"]), None);
    assert!(error(Format::Mcap, &whole[..whole.len() / 3]).contains("`mcap recover` mends a file that was cut"));
}

/// Megabytes of zeros that are small when they are packed.
#[test]
fn a_bag_that_unpacks_to_too_much_is_refused() {
    let filler = vec![0; 16 << 20];
    let messages: Vec<Message> = (0..40)
        .map(|_| Message::new("/image", "sensor_msgs/msg/Image", 1, filler.clone()))
        .collect();
    let file = bag(&messages, Some(mcap::Compression::Zstd));
    assert!(file.len() < 4 << 20, "{}", file.len());
    assert!(error(Format::Mcap, &file).contains("more than 512 MiB when it is unpacked"));
}
