//! Recordings from CSV, JSON, JSON Lines and MCAP.
//!
//! All have the same columns: a line of CSV, an object of a JSON list or line, and a JSON message of MCAP are one [`Frame`].

use nalgebra::Vector3;
use serde::Deserialize;
use serde::de::{DeserializeSeed, SeqAccess, Visitor};

use crate::demonstration::{Demonstration, Frame, Hand};

/// The most bytes of a recording.
pub const BYTES: u64 = 64 << 20;
/// The most frames of a recording: an hour of two hands at 60 Hz.
const FRAMES: usize = 500_000;
/// The most characters of a text in a recording.
const CHARACTERS: usize = 100;
/// The farthest coordinate, in metres. Larger ones are millimetres.
const FARTHEST: f64 = 50.0;
/// The longest recording, in seconds.
const LONGEST: f64 = 86_400.0;
/// The most steps of a plan that a recording can name.
const STEPS: u32 = 100_000;

/// The format of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Comma-separated values with a line of names.
    Csv,
    /// A list of objects.
    Json,
    /// An object on each line.
    JsonLines,
    /// A container of messages, of which the JSON channels are read.
    Mcap,
}

impl Format {
    /// Returns the format of a file by the ending of its name.
    ///
    /// ```
    /// use longstep_teach::Format;
    /// assert_eq!(Format::of_name("open.CSV"), Some(Format::Csv));
    /// assert_eq!(Format::of_name("open.bag"), None);
    /// ```
    pub fn of_name(name: &str) -> Option<Self> {
        let (_, ending) = name.rsplit_once('.')?;
        match ending.to_ascii_lowercase().as_str() {
            "csv" => Some(Self::Csv),
            "json" => Some(Self::Json),
            "jsonl" => Some(Self::JsonLines),
            "mcap" => Some(Self::Mcap),
            _ => None,
        }
    }

    /// Returns the format of a text that is written line by line: JSON Lines if it begins with an object, else CSV.
    ///
    /// ```
    /// use longstep_teach::Format;
    /// assert_eq!(Format::of_lines(b"{\"t\": 0}\n"), Format::JsonLines);
    /// assert_eq!(Format::of_lines(b"t,hand,x,y,z\n"), Format::Csv);
    /// ```
    pub fn of_lines(text: &[u8]) -> Self {
        match text.trim_ascii_start().first() {
            Some(b'{') => Self::JsonLines,
            _ => Self::Csv,
        }
    }

    /// Returns the ending of the names of such files, without the dot.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Json => "json",
            Self::JsonLines => "jsonl",
            Self::Mcap => "mcap",
        }
    }
}

/// Reason why a recording cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {message}")]
pub struct ReadError {
    /// The recording, with the place of the mistake.
    pub place: String,
    /// The mistake.
    pub message: String,
}

/// The columns of a frame.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    t: Option<f64>,
    hand: Option<String>,
    x: f64,
    y: f64,
    z: f64,
    qx: Option<f64>,
    qy: Option<f64>,
    qz: Option<f64>,
    qw: Option<f64>,
    grip: Option<f64>,
    elbow_x: Option<f64>,
    elbow_y: Option<f64>,
    elbow_z: Option<f64>,
    shoulder_x: Option<f64>,
    shoulder_y: Option<f64>,
    shoulder_z: Option<f64>,
    object_x: Option<f64>,
    object_y: Option<f64>,
    object_z: Option<f64>,
    grasp: Option<String>,
    step: Option<u32>,
    frame: Option<String>,
}

impl Demonstration {
    /// Reads a recording. `source` names it in errors and in the source of values.
    ///
    /// ```
    /// use longstep_teach::{Demonstration, Format};
    /// let text = "t,hand,x,y,z\n0,right,0,0,0.8\n0.033,right,0.01,0,0.8\n";
    /// let recording = Demonstration::read("reach.csv", Format::Csv, text.as_bytes())?;
    /// assert_eq!(recording.frames.len(), 2);
    ///
    /// let error = Demonstration::read("reach.csv", Format::Csv, b"t,hand,x,y,z\n0,right,0,0,800\n").unwrap_err();
    /// assert_eq!(error.to_string(), "reach.csv, frame 1: `z` is 800, farther than 50 m; positions are in metres");
    /// # Ok::<(), longstep_teach::ReadError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// The first mistake with its place: text that is not of the format, unknown columns, numbers that are not finite or
    /// out of range, times that do not increase, more than 500,000 frames or 64 MiB.
    pub fn read(source: &str, format: Format, bytes: &[u8]) -> Result<Self, ReadError> {
        let error = |message: String| ReadError {
            place: source.to_owned(),
            message,
        };
        if bytes.len() as u64 > BYTES {
            return Err(error(format!("more than {} MiB", BYTES >> 20)));
        }
        let mut builder = Builder {
            recording: Self {
                source: source.to_owned(),
                reference: None,
                frames: Vec::new(),
            },
            last: [f64::NEG_INFINITY; 2],
        };
        // Some editors write a byte order mark at the beginning of a text.
        let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
        match format {
            Format::Csv => read_csv(bytes, &mut builder)?,
            Format::Json => read_json(bytes, &mut builder)?,
            Format::JsonLines => read_json_lines(bytes, &mut builder)?,
            Format::Mcap => read_mcap(bytes, &mut builder)?,
        }
        let mut recording = builder.recording;
        let Some(first) = recording.frames.iter().map(|frame| frame.time).reduce(f64::min) else {
            return Err(error("no frames".to_owned()));
        };
        if let Some(late) = recording.frames.iter().find(|frame| frame.time - first > LONGEST) {
            return Err(error(format!(
                "the recording lasts {:.0} s, more than a day; `t` is in seconds",
                late.time - first
            )));
        }
        recording.frames.sort_by(|one, other| one.time.total_cmp(&other.time));
        Ok(recording)
    }
}

fn read_csv(bytes: &[u8], builder: &mut Builder) -> Result<(), ReadError> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(bytes);
    for row in reader.deserialize() {
        let row = row.map_err(|error| builder.error(csv_message(&error)))?;
        builder.add(row, None)?;
    }
    Ok(())
}

/// The message of an error, without the place, which is counted in frames for all formats.
fn csv_message(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Deserialize { err, .. } => err.to_string(),
        _ => error.to_string(),
    }
}

fn read_json(bytes: &[u8], builder: &mut Builder) -> Result<(), ReadError> {
    let mut found = None;
    let mut reader = serde_json::Deserializer::from_slice(bytes);
    let read = Rows(builder, &mut found)
        .deserialize(&mut reader)
        .and_then(|()| reader.end());
    match (found, read) {
        (Some(mistake), _) => Err(mistake),
        (None, Err(error)) => Err(builder.error(format!("expected a list of frames: {error}"))),
        (None, Ok(())) => Ok(()),
    }
}

fn read_json_lines(bytes: &[u8], builder: &mut Builder) -> Result<(), ReadError> {
    let lines = bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    for line in lines.filter(|line| !line.is_empty()) {
        let row =
            serde_json::from_slice(line).map_err(|error| builder.error(format!("expected an object: {error}")))?;
        builder.add(row, None)?;
    }
    Ok(())
}

/// The rows of a JSON list, added while they are read: a list that is too long is not read to its end.
struct Rows<'b>(&'b mut Builder, &'b mut Option<ReadError>);

impl<'de> DeserializeSeed<'de> for Rows<'_> {
    type Value = ();

    fn deserialize<D: serde::Deserializer<'de>>(self, reader: D) -> Result<(), D::Error> {
        reader.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Rows<'_> {
    type Value = ();

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("a list")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut rows: A) -> Result<(), A::Error> {
        while let Some(row) = rows.next_element()? {
            if let Err(mistake) = self.0.add(row, None) {
                *self.1 = Some(mistake);
                return Err(serde::de::Error::custom("stopped"));
            }
        }
        Ok(())
    }
}

fn read_mcap(bytes: &[u8], builder: &mut Builder) -> Result<(), ReadError> {
    let unreadable = |builder: &Builder, error: mcap::McapError| match error {
        mcap::McapError::UnsupportedCompression(name) => builder.error(format!(
            "chunks are compressed with {name}, which is not read; record without compression"
        )),
        error => builder.error(format!("not an MCAP file: {error}")),
    };
    let records = mcap::read::LinearReader::new(bytes).map_err(|error| unreadable(builder, error))?;
    for record in records {
        let record = record.map_err(|error| unreadable(builder, error))?;
        if let mcap::records::Record::Chunk { header, data } = record
            && header.compression.is_empty()
            && !is_filled_by_records(&data)
        {
            return Err(builder.error("not an MCAP file: a record is longer than its chunk".to_owned()));
        }
    }
    let stream = mcap::MessageStream::new(bytes).map_err(|error| unreadable(builder, error))?;
    for message in stream {
        let message = message.map_err(|error| unreadable(builder, error))?;
        if message.channel.message_encoding != "json" {
            continue;
        }
        let row = serde_json::from_slice(&message.data)
            .map_err(|error| builder.error(format!("a message of `{}`: {error}", message.channel.topic)))?;
        builder.add(row, Some(message.log_time as f64 / 1e9))?;
    }
    Ok(())
}

/// Returns true if the records in a chunk end where it ends. The crate subtracts their lengths without looking (0.26).
fn is_filled_by_records(mut chunk: &[u8]) -> bool {
    const OPCODE: usize = 1;
    while let Some((length, rest)) = chunk.get(OPCODE..).and_then(<[u8]>::split_first_chunk) {
        let rest = usize::try_from(u64::from_le_bytes(*length)).map_or(None, |length| rest.get(length..));
        let Some(rest) = rest else { return false };
        chunk = rest;
    }
    chunk.is_empty()
}

struct Builder {
    recording: Demonstration,
    /// The last time of each hand.
    last: [f64; 2],
}

impl Builder {
    /// The error of the frame that is read next.
    fn error(&self, message: String) -> ReadError {
        ReadError {
            place: format!("{}, frame {}", self.recording.source, self.recording.frames.len() + 1),
            message,
        }
    }

    /// Adds a frame; `logged` is the time of a message, for rows without a time.
    fn add(&mut self, row: Row, logged: Option<f64>) -> Result<(), ReadError> {
        if self.recording.frames.len() >= FRAMES {
            return Err(self.error(format!("more than {FRAMES} frames")));
        }
        let frame = frame(&row, logged).map_err(|message| self.error(message))?;
        let last = &mut self.last[usize::from(frame.hand == Hand::Right)];
        if frame.time <= *last {
            let message = format!(
                "`t` is {} after {} of the {} hand; times increase",
                frame.time, last, frame.hand
            );
            return Err(self.error(message));
        }
        *last = frame.time;
        match (&self.recording.reference, row.frame) {
            (Some(own), Some(other)) if *own != other => {
                return Err(self.error(format!("`frame` is `{other}` after `{own}`; a recording has one")));
            }
            (None, Some(other)) => self.recording.reference = Some(text("frame", &other).map_err(|m| self.error(m))?),
            _ => {}
        }
        self.recording.frames.push(frame);
        Ok(())
    }
}

fn frame(row: &Row, logged: Option<f64>) -> Result<Frame, String> {
    let time = row.t.or(logged).ok_or("`t` is missing")?;
    if !time.is_finite() {
        return Err(format!("`t` is {time}"));
    }
    let hand = row.hand.as_deref().ok_or("`hand` is missing")?;
    let hand = Hand::named(hand).ok_or_else(|| format!("`hand` is `{}`; it is `left` or `right`", shortened(hand)))?;
    let grip = row.grip.map(|grip| match (0.0..=1.0).contains(&grip) {
        true => Ok(grip),
        false => Err(format!("`grip` is {grip}; it is from 0 (open) to 1 (closed)")),
    });
    let step = row.step.map(|step| match (1..=STEPS).contains(&step) {
        true => Ok(step as usize),
        false => Err(format!("`step` is {step}; steps are counted from 1")),
    });
    let optional = |names, parts: [Option<f64>; 3]| point(names, parts);
    Ok(Frame {
        time,
        hand,
        position: Vector3::new(
            coordinate("x", row.x)?,
            coordinate("y", row.y)?,
            coordinate("z", row.z)?,
        ),
        orientation: orientation([row.qx, row.qy, row.qz, row.qw])?,
        grip: grip.transpose()?,
        elbow: optional(
            ["elbow_x", "elbow_y", "elbow_z"],
            [row.elbow_x, row.elbow_y, row.elbow_z],
        )?,
        shoulder: optional(
            ["shoulder_x", "shoulder_y", "shoulder_z"],
            [row.shoulder_x, row.shoulder_y, row.shoulder_z],
        )?,
        object: optional(
            ["object_x", "object_y", "object_z"],
            [row.object_x, row.object_y, row.object_z],
        )?,
        grasp: row
            .grasp
            .as_deref()
            .filter(|own| !own.is_empty())
            .map(|own| text("grasp", own))
            .transpose()?,
        step: step.transpose()?,
    })
}

fn coordinate(name: &str, value: f64) -> Result<f64, String> {
    if !value.is_finite() {
        return Err(format!("`{name}` is {value}"));
    }
    match value.abs() <= FARTHEST {
        true => Ok(value),
        false => Err(format!(
            "`{name}` is {value}, farther than {FARTHEST} m; positions are in metres"
        )),
    }
}

fn point(names: [&str; 3], parts: [Option<f64>; 3]) -> Result<Option<Vector3<f64>>, String> {
    match parts {
        [None, None, None] => Ok(None),
        [Some(x), Some(y), Some(z)] => Ok(Some(Vector3::new(
            coordinate(names[0], x)?,
            coordinate(names[1], y)?,
            coordinate(names[2], z)?,
        ))),
        _ => Err(format!(
            "`{}`, `{}` and `{}` belong together",
            names[0], names[1], names[2]
        )),
    }
}

fn orientation(parts: [Option<f64>; 4]) -> Result<Option<[f64; 4]>, String> {
    match parts {
        [None, None, None, None] => Ok(None),
        [Some(x), Some(y), Some(z), Some(w)] => {
            let length = [x, y, z, w].iter().map(|part| part * part).sum::<f64>().sqrt();
            match (length - 1.0).abs() < 0.01 {
                true => Ok(Some([x, y, z, w])),
                false => Err(format!("the quaternion has the length {length}, not 1")),
            }
        }
        _ => Err("`qx`, `qy`, `qz` and `qw` belong together".to_owned()),
    }
}

fn text(name: &str, value: &str) -> Result<String, String> {
    let is_plain = value.chars().all(|c| c.is_alphanumeric() || "_-./ ".contains(c));
    match is_plain && value.chars().count() <= CHARACTERS {
        true => Ok(value.to_owned()),
        false => Err(format!(
            "`{name}` is `{}`; it has at most {CHARACTERS} letters, digits and `_-./`",
            shortened(value)
        )),
    }
}

/// The beginning of a text of the recording, for a message.
fn shortened(text: &str) -> String {
    text.chars().take(20).flat_map(char::escape_default).collect()
}
