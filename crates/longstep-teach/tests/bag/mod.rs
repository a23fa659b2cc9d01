//! MCAP files with messages of ROS 2.

#![allow(dead_code)]

use std::collections::BTreeMap;

pub(crate) struct Message {
    topic: String,
    kind: String,
    time: u64,
    data: Vec<u8>,
}

impl Message {
    pub(crate) fn new(topic: &str, kind: &str, time: u64, data: Vec<u8>) -> Self {
        Self {
            topic: topic.to_owned(),
            kind: kind.to_owned(),
            time,
            data,
        }
    }
}

/// Writes a bag, with a channel for each topic.
pub(crate) fn bag(messages: &[Message], compression: Option<mcap::Compression>) -> Vec<u8> {
    let mut file = std::io::Cursor::new(Vec::new());
    let mut writer = mcap::WriteOptions::new()
        .compression(compression)
        .create(&mut file)
        .unwrap();
    let mut channels = BTreeMap::new();
    for message in messages {
        let channel_id = *channels.entry(&message.topic).or_insert_with(|| {
            let schema = writer.add_schema(&message.kind, "ros2msg", b"").unwrap();
            writer
                .add_channel(schema, &message.topic, "cdr", &BTreeMap::new())
                .unwrap()
        });
        let header = mcap::records::MessageHeader {
            channel_id,
            sequence: 0,
            log_time: message.time,
            publish_time: message.time,
        };
        writer.write_to_known_channel(&header, &message.data).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    file.into_inner()
}

/// Returns a text in CDR: its length, its letters, a zero, and as many more as fill four bytes.
pub(crate) fn string(text: &str) -> Vec<u8> {
    let mut bytes = (text.len() as u32 + 1).to_le_bytes().to_vec();
    bytes.extend(text.as_bytes());
    bytes.push(0);
    bytes.resize(bytes.len().next_multiple_of(4), 0);
    bytes
}

/// Returns a `PoseStamped` that is not turned.
pub(crate) fn pose_stamped((sec, nanosec): (i32, u32), frame: &str, position: [f64; 3]) -> Vec<u8> {
    let mut body = [sec.to_le_bytes(), nanosec.to_le_bytes()].concat();
    body.extend(string(frame));
    body.resize(body.len().next_multiple_of(8), 0);
    body.extend(
        [position.to_vec(), vec![0.0, 0.0, 0.0, 1.0]]
            .concat()
            .into_iter()
            .flat_map(f64::to_le_bytes),
    );
    [vec![0, 1, 0, 0], body].concat()
}
