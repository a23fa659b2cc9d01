//! Recordings of hands as others write them: CSV, JSON, JSON Lines and MCAP.
//!
//! A line of CSV, an object of a JSON list or line, and a message of MCAP are one row. A row becomes a
//! [`Frame`](crate::Frame), if it has a position; otherwise it is a gap.

mod builder;
mod cells;
mod clock;
mod columns;
mod mcap;
mod motive;
mod object;
mod pose;
mod row;
mod side;
mod table;

use builder::Builder;

use crate::demonstration::{Demonstration, Hand};

/// The most bytes of a recording.
pub const BYTES: u64 = 64 << 20;
/// The most frames of a recording: an hour of two hands at 60 Hz.
const FRAMES: usize = 500_000;
/// The longest recording, in seconds.
const LONGEST: f64 = 86_400.0;
/// The letters of a text of the recording in a message.
const LETTERS: usize = 40;

/// The format of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Comma-separated values with a line of names.
    Csv,
    /// A list of objects.
    Json,
    /// An object on each line.
    JsonLines,
    /// A container of messages, of which channels in JSON and channels of ROS 2 with poses are read.
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
#[non_exhaustive]
pub struct ReadError {
    /// The recording, with the place of the mistake.
    pub place: String,
    /// The mistake.
    pub message: String,
    /// True if there is no other mistake than that no row has a position, so that more rows could mend it.
    pub is_without_position: bool,
}

impl Demonstration {
    /// Reads a recording. `source` names it in errors and in the source of values. A recording that does not say which hand it
    /// shows is one of the right hand.
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
        Self::read_hand(source, format, bytes, Hand::Right)
    }

    /// Reads a recording, as [`Demonstration::read`] does, with the hand that it shows if it does not say which.
    ///
    /// # Errors
    ///
    /// Those of [`Demonstration::read`].
    pub fn read_hand(source: &str, format: Format, bytes: &[u8], hand: Hand) -> Result<Self, ReadError> {
        let mut builder = Builder::new(source, hand);
        if bytes.len() as u64 > BYTES {
            return Err(builder.whole_error(format!("more than {} MiB", BYTES >> 20)));
        }
        // Some editors write a byte order mark at the beginning of a text.
        let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
        match format {
            Format::Csv => table::read(bytes, &mut builder)?,
            Format::Json => object::read_list(bytes, &mut builder)?,
            Format::JsonLines => object::read_lines(bytes, &mut builder)?,
            Format::Mcap => mcap::read(bytes, &mut builder)?,
        }
        let recording = builder.finish()?;
        let error = |message: String| ReadError {
            place: source.to_owned(),
            message,
            is_without_position: false,
        };
        let (Some(first), Some(last)) = (recording.frames.first(), recording.frames.last()) else {
            return Err(error("no frames".to_owned()));
        };
        let length = last.time - first.time;
        if length > LONGEST {
            Err(error(format!(
                "the recording lasts {length:.0} s, more than a day; `t` is in seconds"
            )))
        } else {
            Ok(recording)
        }
    }
}

/// The beginning of a text of the recording, for a message.
fn shortened(text: &str) -> String {
    text.chars().take(LETTERS).flat_map(char::escape_default).collect()
}
