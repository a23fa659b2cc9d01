//! MCAP files: records, chunks, and the messages of channels in JSON and CDR.

use std::borrow::Cow;
use std::io::Read;
use std::sync::Arc;

use mcap::records::Record;
use rustc_hash::FxHashMap;

use super::ReadError;
use super::builder::Builder;
use super::object;
use super::pose::{Reader, reader};
use super::side::listed;

/// The most bytes of all chunks of a recording, when they are unpacked.
const UNPACKED: u64 = 512 << 20;

/// Decoding of the messages of a channel.
#[derive(Clone, Copy)]
enum Reading {
    Json,
    Cdr(Reader),
    Nothing,
}

struct Messages<'b> {
    builder: &'b mut Builder,
    channels: mcap::read::ChannelAccumulator<'static>,
    readings: FxHashMap<u16, (String, Reading)>,
    /// The channels of which nothing is read, with their types.
    others: Vec<String>,
    /// The bytes that chunks may still have.
    left: u64,
}

pub(super) fn read(bytes: &[u8], builder: &mut Builder) -> Result<(), ReadError> {
    let Some(bytes) = bytes.strip_prefix(mcap::MAGIC) else {
        return Err(builder.whole_error("not an MCAP file: it does not begin with `MCAP`"));
    };
    let mut messages = Messages {
        builder,
        channels: mcap::read::ChannelAccumulator::default(),
        readings: FxHashMap::default(),
        others: Vec::new(),
        left: UNPACKED,
    };
    messages.read(bytes, true)?;
    let others: Vec<&str> = messages.others.iter().map(String::as_str).collect();
    let has_read = messages
        .readings
        .values()
        .any(|(_, reading)| !matches!(reading, Reading::Nothing));
    if !others.is_empty() && !has_read {
        let message = format!(
            "no channel has positions: {}; record JSON, or `geometry_msgs/PoseStamped` and its like",
            listed(&others)
        );
        return Err(messages.builder.whole_error(message));
    }
    if !others.is_empty() {
        let note = format!("channels that are not read: {}", listed(&others));
        messages.builder.note(note);
    }
    Ok(())
}

impl Messages<'_> {
    fn error(&self, error: impl std::fmt::Display) -> ReadError {
        self.builder.whole_error(format!("not an MCAP file: {error}"))
    }

    /// Reads records up to the end of the data, or of a chunk.
    fn read(&mut self, mut bytes: &[u8], is_outside: bool) -> Result<(), ReadError> {
        while let Some((opcode, rest)) = bytes.split_first() {
            let record = rest
                .split_first_chunk()
                .and_then(|(length, rest)| rest.split_at_checked(usize::try_from(u64::from_le_bytes(*length)).ok()?));
            let Some((body, rest)) = record else {
                let end = if is_outside { "the file" } else { "its chunk" };
                return Err(self.error(format!(
                    "a record is longer than {end}; `mcap recover` mends a file that was cut"
                )));
            };
            bytes = rest;
            match mcap::parse_record(*opcode, body).map_err(|error| self.error(error))? {
                Record::Chunk { header, data } if is_outside => {
                    let unpacked = self.unpack(&header, &data)?;
                    self.read(&unpacked, false)?;
                }
                Record::Schema { header, data } => {
                    let data = Cow::Owned(data.into_owned());
                    self.channels
                        .add_schema(header, data)
                        .map_err(|error| self.error(error))?;
                }
                Record::Channel(channel) => self.add_channel(channel)?,
                Record::Message { header, data } => self.add_message(&header, &data)?,
                Record::DataEnd(_) if is_outside => return Ok(()),
                _ => {}
            }
        }
        if is_outside {
            Err(self.error("it ends without its last record; `mcap recover` mends a file that was cut"))
        } else {
            Ok(())
        }
    }

    fn unpack<'d>(&mut self, header: &mcap::records::ChunkHeader, data: &'d [u8]) -> Result<Cow<'d, [u8]>, ReadError> {
        let unpacked = match header.compression.as_str() {
            "" => Cow::Borrowed(data),
            "zstd" => {
                let decoder = ruzstd::decoding::StreamingDecoder::new(data).map_err(|error| self.error(error))?;
                Cow::Owned(self.read_all(decoder)?)
            }
            "lz4" => Cow::Owned(self.read_all(lz4_flex::frame::FrameDecoder::new(data))?),
            other => {
                let message = format!(
                    "chunks are compressed with {}; record with zstd, lz4 or without",
                    listed(&[other])
                );
                return Err(self.builder.whole_error(message));
            }
        };
        if unpacked.len() as u64 != header.uncompressed_size {
            return Err(self.error("a chunk has another size than its head says"));
        }
        Ok(unpacked)
    }

    fn read_all(&mut self, reader: impl Read) -> Result<Vec<u8>, ReadError> {
        let mut unpacked = Vec::new();
        let read = reader
            .take(self.left + 1)
            .read_to_end(&mut unpacked)
            .map_err(|error| self.error(error))? as u64;
        if read > self.left {
            let most = UNPACKED >> 20;
            return Err(self.builder.whole_error(format!(
                "more than {most} MiB when it is unpacked; record the hand alone"
            )));
        }
        self.left -= read;
        Ok(unpacked)
    }

    fn add_channel(&mut self, channel: mcap::records::Channel) -> Result<(), ReadError> {
        let id = channel.id;
        self.channels.add_channel(channel).map_err(|error| self.error(error))?;
        let Some(channel) = self.channels.get(id).filter(|_| !self.readings.contains_key(&id)) else {
            return Ok(());
        };
        let reading = reading(&channel);
        if matches!(reading, Reading::Nothing) {
            let kind = channel
                .schema
                .as_ref()
                .map_or(channel.message_encoding.as_str(), |own| own.name.as_str());
            self.others.push(format!("{} ({kind})", channel.topic));
        }
        self.readings.insert(id, (channel.topic.clone(), reading));
        Ok(())
    }

    fn add_message(&mut self, header: &mcap::records::MessageHeader, data: &[u8]) -> Result<(), ReadError> {
        let Some((topic, reading)) = self.readings.get(&header.channel_id) else {
            return Err(self.error(format!(
                "a message of the channel {}, which is not there",
                header.channel_id
            )));
        };
        let logged = Some(header.log_time as f64 / 1e9);
        let of_topic = |builder: &Builder, error: String| {
            builder.error(format!("a message of {}: {error}", listed(&[topic.as_str()])))
        };
        match reading {
            Reading::Nothing => Ok(()),
            Reading::Json => {
                let object = serde_json::from_slice(data).map_err(|error| of_topic(self.builder, error.to_string()))?;
                object::add(&object, topic, logged, self.builder).map_err(|error| of_topic(self.builder, error.message))
            }
            Reading::Cdr(read) => {
                for (child, row) in read(data).map_err(|error| of_topic(self.builder, error))? {
                    let name = if child.is_empty() { topic.clone() } else { child };
                    self.builder.add_named(&name, row, logged)?;
                }
                Ok(())
            }
        }
    }
}

fn reading(channel: &Arc<mcap::Channel<'_>>) -> Reading {
    match channel.message_encoding.as_str() {
        "json" => Reading::Json,
        "cdr" => {
            let kind = channel.schema.as_ref().map_or("", |own| own.name.as_str());
            reader(&channel.topic, kind).map_or(Reading::Nothing, Reading::Cdr)
        }
        _ => Reading::Nothing,
    }
}
