//! Recordings with hostile bytes: refused with a place, never a panic.
#![allow(clippy::unwrap_used)]

mod bag;
mod person;

use std::borrow::Cow;
use std::collections::BTreeMap;

use bag::{Message, bag, pose_stamped};
use longstep_teach::{Demonstration, Expectations, Format, cut, learn};
use person::{ALL, CALLS, csv, plan, shown, world};
use proptest::prelude::*;

/// An MCAP file with a JSON message a row.
fn mcap_of(rows: &[String], compression: Option<mcap::Compression>) -> Vec<u8> {
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new()
        .compression(compression)
        .create(&mut file)
        .unwrap();
    let channel = writer.add_channel(0, "hands", "json", &BTreeMap::new()).unwrap();
    let other = writer.add_channel(0, "camera", "cdr", &BTreeMap::new()).unwrap();
    for (index, row) in rows.iter().enumerate() {
        for (channel_id, data) in [(channel, row.as_bytes()), (other, &[0, 1, 2][..])] {
            let time = index as u64 * 33_000_000;
            let header = mcap::records::MessageHeader {
                channel_id,
                sequence: 0,
                log_time: time,
                publish_time: time,
            };
            writer.write_to_known_channel(&header, data).unwrap();
        }
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

const ROW: &str = r#"{"hand": "right", "x": 0.1, "y": 0.2, "z": 0.3, "grip": 1}"#;

#[test]
fn all_formats_give_the_same_frames() {
    let rows: Vec<String> = (0..3)
        .map(|part| format!(r#"{{"t": 0.{part}, "hand": "right", "x": {part}, "y": 0, "z": 1}}"#))
        .collect();
    let json = format!("[{}]", rows.join(","));
    let text = "t,hand,x,y,z\n0.0,right,0,0,1\n0.1,right,1,0,1\n0.2,right,2,0,1\n";
    let of = |format, bytes: &[u8]| Demonstration::read("demo", format, bytes).unwrap();
    let expected = of(Format::Csv, text.as_bytes());
    assert_eq!(of(Format::Json, json.as_bytes()), expected);
    let lines = rows.join("\r\n\n");
    assert_eq!(of(Format::JsonLines, lines.as_bytes()), expected);
    let packed = of(Format::Mcap, &mcap_of(&rows, None));
    assert_eq!(packed.frames, expected.frames);
    assert_eq!(packed.notes, ["channels that are not read: `camera (cdr)`"]);
    // Without `t`, the time of the message counts.
    let logged = of(Format::Mcap, &mcap_of(&[ROW.to_owned(), ROW.to_owned()], None));
    assert_eq!(logged.frames[1].time, 0.033);
}

#[test]
fn mistakes_have_a_place_and_a_reason() {
    let long = "x".repeat(300);
    for (format, text, expected) in [
        (Format::Csv, "", "demo: no frames"),
        (Format::Csv, "t,hand,x,y,z\n", "demo: no frames"),
        (
            Format::Csv,
            "t,hand,x,y\n0,left,0,0\n",
            "demo: no column `z`; name the columns of the position",
        ),
        (
            Format::Csv,
            "t,hand,x,y,z,elbow\n0,left,0,0,0,1\n",
            "demo: unknown column `elbow`; rename it",
        ),
        (
            Format::Csv,
            "t,hand,x,y,z\n0,left,0,0,0\n0,left,0,0,0\n",
            "frame 2: `t` is 0 after 0 of the left hand; times increase",
        ),
        (Format::Csv, "t,hand,x,y,z\n0,left,NaN,0,0\n", "frame 1: `x` is NaN"),
        (Format::Csv, "t,hand,x,y,z\ninf,left,0,0,0\n", "frame 1: `t` is inf"),
        (
            Format::Csv,
            "t,hand,x,y,z\n0,third,0,0,0\n",
            "`hand` is `third`; it is `left` or `right`",
        ),
        (
            Format::Csv,
            "t,hand,x,y,z\n0,left,400,0,0\n",
            "`x` is 400, farther than 50 m; positions are in metres",
        ),
        (
            Format::Csv,
            "t,hand,x,y,z,grip\n0,left,0,0,0,2\n",
            "`grip` is 2; it is from 0 (open) to 1 (closed)",
        ),
        (
            Format::Csv,
            "t,hand,x,y,z,qx,qy,qz,qw\n0,left,0,0,0,1,1,0,0\n",
            "the quaternion has the length 1.414",
        ),
        (
            Format::Csv,
            "t,hand,x,y,z,elbow_x\n0,left,0,0,0,1\n",
            "`elbow_x`, `elbow_y` and `elbow_z` belong together",
        ),
        (
            Format::Csv,
            "t,hand,x,y,z,step\n0,left,0,0,0,0\n",
            "`step` is 0; steps are counted from 1",
        ),
        (
            Format::Csv,
            "t,hand,x,y,z\n0,left,0,0,0\n90000,left,0,0,0\n",
            "lasts 90000 s, more than a day",
        ),
        (
            Format::Csv,
            "t,hand,x,y,z,frame\n0,left,0,0,0,a\n1,left,0,0,0,b\n",
            "`frame` is `b` after `a`",
        ),
        (
            Format::Csv,
            &format!("t,hand,x,y,z,grasp\n0,left,0,0,0,{long}\n"),
            "has at most 100 letters",
        ),
        (Format::Json, "{}", "expected a list of frames"),
        (
            Format::Json,
            r#"[{"t": 0, "hand": "left", "x": 0, "y": 0, "z": 1e999}]"#,
            "number out of range",
        ),
        (Format::Json, "[", "expected a list of frames: EOF"),
        (Format::JsonLines, "", "demo: no frames"),
        (Format::JsonLines, "[]\n", "frame 1: expected an object: invalid type"),
        (
            Format::JsonLines,
            "{\"t\": 0, \"hand\": \"left\", \"x\": 0, \"y\": 0, \"z\": 0}\n{\"t\": 1, \"hand\"",
            "frame 2: expected an object: EOF",
        ),
        (
            Format::JsonLines,
            "{\"t\": 0, \"hand\": \"left\", \"x\": 0, \"y\": 0, \"z\": 0} {}",
            "frame 1: expected an object: trailing characters",
        ),
        (Format::Mcap, "mcap", "not an MCAP file"),
    ] {
        let error = Demonstration::read("demo", format, text.as_bytes())
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
    let other = mcap_of(&["{}".to_owned()], None);
    let error = Demonstration::read("demo", Format::Mcap, &other)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("a message of `hands`: no position; a frame has"),
        "{error}"
    );
}

#[test]
fn too_many_frames_are_refused_before_they_are_all_read() {
    let rows: String = (0..500_001).map(|part| format!("{part},left,0,0,0\n")).collect();
    let text = format!("t,hand,x,y,z\n{rows}");
    let error = Demonstration::read("demo", Format::Csv, text.as_bytes())
        .unwrap_err()
        .to_string();
    assert_eq!(error, "demo, frame 500001: more than 500000 frames");
    let large = vec![b' '; (64 << 20) + 1];
    let error = Demonstration::read("demo", Format::Json, &large)
        .unwrap_err()
        .to_string();
    assert_eq!(error, "demo: more than 64 MiB");
}

fn formats() -> impl Strategy<Value = Format> {
    prop_oneof![
        Just(Format::Csv),
        Just(Format::Json),
        Just(Format::JsonLines),
        Just(Format::Mcap)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn random_bytes_never_panic(format in formats(), bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        let _ = Demonstration::read("demo", format, &bytes);
    }

    #[test]
    fn damaged_recordings_never_panic(
        format in formats(),
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        length in any::<prop::sample::Index>(),
    ) {
        let rows: Vec<String> = (0..4).map(|_| ROW.to_owned()).collect();
        let mut bytes: Cow<'_, [u8]> = match format {
            Format::Csv => Cow::Borrowed(b"t,hand,x,y,z,grip,step\n0,left,0,0,0,1,1\n0.1,left,0,0,1,1,2\n0.2,right,0,0,0,0,2\n"),
            Format::Json => Cow::Owned(format!("[{}]", rows.join(",")).into_bytes()),
            Format::JsonLines => Cow::Owned(rows.join("\n").into_bytes()),
            Format::Mcap => {
                let pose = pose_stamped((1, 0), "map", [0.1, 0.2, 0.3]);
                let poses = [1, 2].map(|time| Message::new("/hand", "geometry_msgs/msg/PoseStamped", time, pose.clone()));
                let compressions = [None, Some(mcap::Compression::Zstd), Some(mcap::Compression::Lz4)];
                let compression = compressions[usize::from(changes[0].1) % 3];
                Cow::Owned(match changes.len() % 2 {
                    0 => mcap_of(&rows, compression),
                    _ => bag(&poses, compression),
                })
            }
        };
        for (place, byte) in &changes {
            let place = place.index(bytes.len());
            bytes.to_mut()[place] = *byte;
        }
        let kept = length.index(bytes.len() * 4).min(bytes.len());
        let _ = Demonstration::read("demo", format, &bytes[..kept]);
    }

    /// Every part of a recording, with any columns, ends in values or findings.
    #[test]
    fn parts_of_recordings_end_in_values_or_findings(keep in proptest::collection::vec(any::<bool>(), 97), step in any::<bool>()) {
        let world = world();
        let requests = plan(&world, &CALLS[..6]);
        let mut lines = shown(0.005).lines;
        let mut place = 0;
        lines.retain(|_| {
            place += 1;
            keep[place * 7 / 50 % keep.len()]
        });
        let text = csv(&lines, person::Columns { step, ..ALL });
        if let Ok(recording) = Demonstration::read("demo", Format::Csv, text.as_bytes())
            && let Ok(segments) = cut(&recording, &requests)
        {
            let lesson = learn(&requests, &segments, &Expectations::default());
            prop_assert!(!lesson.steps.is_empty() || !lesson.findings.is_empty());
        }
    }
}
