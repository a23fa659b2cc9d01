//! Runs as MCAP files, for Foxglove, Lichtblick and the tools of this format.
//!
//! A recording is a function of the log of a run: the same log gives the same bytes. Its messages are JSON, each topic has
//! a schema, and the times are those of the log. Nothing is compressed.

mod channel;
mod message;

use std::collections::BTreeMap;
use std::io::{Cursor, Seek, Write};

use jiff::Timestamp;
use longstep_core::execution::Event;
use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions, Writer};
use sha2::{Digest, Sha256};

use crate::run_log::{RunHeader, TimedEvent};
use channel::Channel;
use message::Messages;

/// The name of the metadata of a recording.
const METADATA: &str = "longstep";

/// The time between two events of a log that kept no times, in nanoseconds.
const STEP: u64 = 1_000_000;

/// A recording that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("the recording cannot be written: {0}")]
pub struct RecordingError(#[from] McapError);

/// A run as an MCAP file.
///
/// The topics are `/longstep/plan`, `/longstep/step`, `/longstep/observation`, `/longstep/assessment`, `/longstep/world`,
/// `/longstep/run` and, for the log panel of a viewer, `/longstep/log`. The metadata `longstep` has the versions, the robot,
/// the domain and the hash of the plan.
///
/// ```
/// use longstep_robot::RunLog;
/// use longstep_robot::mcap::Recording;
/// let log = r#"{"longstep_run": 1, "robot": "sim", "domain": "household"}
/// {"event": "ordered", "order": 1, "step": 1, "call": "grasp(<cup>)", "explanation": "grasp the cup", "at": "2026-05-04T10:00:00Z"}
/// {"event": "performed", "order": 1, "at": "2026-05-04T10:00:02.5Z"}
/// "#;
/// let (header, events) = RunLog::parse_timed("run.jsonl".as_ref(), log)?;
/// let bytes = Recording::new(&header, &events).with("instruction", "Grasp the cup").to_bytes()?;
/// let messages = mcap::MessageStream::new(&bytes)?.collect::<Result<Vec<_>, _>>()?;
/// let step = messages.iter().rfind(|message| message.channel.topic == "/longstep/step").unwrap();
/// assert_eq!(step.log_time, 1_777_888_802_500_000_000);
/// let step: serde_json::Value = serde_json::from_slice(&step.data)?;
/// assert_eq!((step["state"].as_str(), step["seconds"].as_f64()), (Some("performed"), Some(2.5)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Recording<'r> {
    events: &'r [TimedEvent],
    metadata: BTreeMap<String, String>,
}

impl<'r> Recording<'r> {
    /// Creates the recording of a log.
    pub fn new(header: &RunHeader, events: &'r [TimedEvent]) -> Self {
        let mut metadata: BTreeMap<String, String> = BTreeMap::new();
        let mut add = |name: &str, value: String| drop(metadata.insert(name.to_owned(), value));
        add("longstep_version", env!("CARGO_PKG_VERSION").to_owned());
        add("log_version", header.longstep_run.to_string());
        add("robot", header.robot.clone());
        add("domain", header.domain.clone());
        add("dry_run", header.dry_run.to_string());
        let is_timed = events.iter().all(|own| own.at.is_some());
        add("times", if is_timed { "recorded" } else { "made up" }.to_owned());
        if let Some(Event::Began { format, plan, goal, .. }) = events.first().map(|own| &own.event) {
            add("event_format", format.to_string());
            add("plan_sha256", sha256(&plan.to_string()));
            goal.iter().for_each(|goal| add("goal", goal.clone()));
        }
        Self { events, metadata }
    }

    /// Adds a value to the metadata.
    #[must_use]
    pub fn with(mut self, name: &str, value: impl Into<String>) -> Self {
        self.metadata.insert(name.to_owned(), value.into());
        self
    }

    /// Returns the file. Takes time and memory in proportion to the log.
    ///
    /// # Errors
    ///
    /// A message is too large for the format.
    pub fn to_bytes(&self) -> Result<Vec<u8>, RecordingError> {
        let mut file = Cursor::new(Vec::new());
        self.write(&mut file)?;
        Ok(file.into_inner())
    }

    /// Writes the file.
    ///
    /// # Errors
    ///
    /// The file cannot be written, or a message is too large for the format.
    pub fn write(&self, file: &mut (impl Write + Seek)) -> Result<(), RecordingError> {
        let options = WriteOptions::new()
            .compression(None)
            .library(concat!("longstep ", env!("CARGO_PKG_VERSION")));
        let mut writer = Writer::with_options(file, options)?;
        let mut ids = BTreeMap::new();
        for channel in Channel::ALL {
            let schema = writer.add_schema(channel.schema_name(), "jsonschema", channel.schema().as_bytes())?;
            let id = writer.add_channel(schema, channel.topic(), "json", &BTreeMap::new())?;
            ids.insert(channel, (id, 0));
        }
        writer.write_metadata(&Metadata {
            name: METADATA.to_owned(),
            metadata: self.metadata.clone(),
        })?;
        let mut messages = Messages::default();
        let mut log_time = 0;
        for (index, own) in self.events.iter().enumerate() {
            // A clock may be set back: viewers need times in order.
            log_time = nanoseconds(own.at).unwrap_or(log_time + STEP).max(log_time);
            for (channel, message) in messages.of(index, log_time, &own.event) {
                let Some((id, sequence)) = ids.get_mut(&channel) else {
                    continue;
                };
                let header = MessageHeader {
                    channel_id: *id,
                    sequence: *sequence,
                    log_time,
                    publish_time: nanoseconds(own.at).unwrap_or(log_time),
                };
                *sequence = sequence.wrapping_add(1);
                writer.write_to_known_channel(&header, message.to_string().as_bytes())?;
            }
        }
        writer.finish()?;
        Ok(())
    }
}

/// Returns a time as nanoseconds since 1970; none for one before that.
fn nanoseconds(at: Option<Timestamp>) -> Option<u64> {
    u64::try_from(at?.as_nanosecond()).ok()
}

fn sha256(text: &str) -> String {
    let bytes = Sha256::digest(text.as_bytes());
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
