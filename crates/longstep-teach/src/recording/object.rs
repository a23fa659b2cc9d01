//! Objects: JSON lists, JSON Lines, and the JSON messages of MCAP.

use serde::de::{DeserializeSeed, SeqAccess, Visitor};
use serde_json::{Map, Value};

use super::ReadError;
use super::builder::Builder;
use super::columns::{Meaning, meaning, prefix};
use super::row::{Number, Row};
use super::shortened;
use super::side::listed;

/// A JSON value in a row.
enum Cell<'a> {
    Number(f64),
    Text(&'a str),
    Empty,
}

pub(super) fn read_list(bytes: &[u8], builder: &mut Builder) -> Result<(), ReadError> {
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

pub(super) fn read_lines(bytes: &[u8], builder: &mut Builder) -> Result<(), ReadError> {
    let lines = bytes.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    for line in lines.filter(|line| !line.is_empty()) {
        let object: Map<String, Value> =
            serde_json::from_slice(line).map_err(|error| builder.error(format!("expected an object: {error}")))?;
        add(&object, "", None, builder)?;
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
        while let Some(object) = rows.next_element::<Map<String, Value>>()? {
            if let Err(mistake) = add(&object, "", None, self.0) {
                *self.1 = Some(mistake);
                return Err(serde::de::Error::custom("stopped"));
            }
        }
        Ok(())
    }
}

/// Adds an object: a row of our own columns, or a message with a pose, which belongs to its topic.
pub(super) fn add(
    object: &Map<String, Value>,
    topic: &str,
    logged: Option<f64>,
    builder: &mut Builder,
) -> Result<(), ReadError> {
    let mut cells = Vec::new();
    flatten(object, "", &mut cells);
    let mut row = Row::default();
    let mut poses: Vec<(&str, Row)> = Vec::new();
    let (mut unknown, mut known) = (Vec::new(), 0);
    let mut stamp = [None, None];
    for (name, cell) in &cells {
        let number = || number(name, cell, builder);
        match meaning(name) {
            Meaning::Number(column) => {
                known += 1;
                number()?.into_iter().for_each(|value| row.set(column, value));
            }
            Meaning::Text(column) => {
                known += 1;
                match cell {
                    Cell::Text(text) => row.set_text(column, text),
                    Cell::Empty => {}
                    Cell::Number(_) => return Err(builder.error(format!("{} is not a text", listed(&[name])))),
                }
            }
            Meaning::Pose {
                number: column,
                prefix: length,
            } => {
                let value = number()?;
                let own = prefix(name, length);
                let place = poses.iter().position(|(other, _)| *other == own).unwrap_or_else(|| {
                    poses.push((own, Row::default()));
                    poses.len() - 1
                });
                value.into_iter().for_each(|value| poses[place].1.set(column, value));
            }
            Meaning::PathGrip => number()?.into_iter().for_each(|value| row.set(Number::Grip, value)),
            Meaning::Seconds => stamp[0] = number()?,
            Meaning::Nanoseconds => stamp[1] = number()?,
            Meaning::Other | Meaning::Unknown => unknown.push(name.as_str()),
        }
    }
    if let ([Some(seconds), nanoseconds], None) = (stamp, row.number(Number::Time)) {
        row.set(Number::Time, seconds + nanoseconds.unwrap_or(0.0) / 1e9);
    }
    if poses.is_empty() {
        if !unknown.is_empty() {
            let message = format!(
                "unknown column {}; rename it to one of the columns of a recording, or take it out",
                listed(&unknown)
            );
            return Err(builder.error(message));
        }
        if known == 0 {
            return Err(builder.error("no position; a frame has `t`, `x`, `y` and `z`"));
        }
        return builder.add(&row, logged);
    }
    let child = object.get("child_frame_id").and_then(Value::as_str).unwrap_or_default();
    for (prefix, pose) in poses {
        let mut own = row.clone();
        own.take_pose(&pose);
        let name = [topic, child, prefix]
            .into_iter()
            .filter(|part| !part.is_empty())
            .collect::<Vec<_>>()
            .join(" ");
        builder.add_named(&name, own, logged)?;
    }
    Ok(())
}

fn number(name: &str, cell: &Cell<'_>, builder: &Builder) -> Result<Option<f64>, ReadError> {
    match cell {
        Cell::Number(number) => Ok(Some(*number)),
        Cell::Empty => Ok(None),
        Cell::Text(text) => match text.trim().parse() {
            Ok(number) => Ok(Some(number)),
            Err(_) => Err(builder.error(format!(
                "`{}` is `{}`, and not a number",
                shortened(name),
                shortened(text)
            ))),
        },
    }
}

/// Lists the values of an object with the paths to them, as deep as JSON was read.
fn flatten<'a>(object: &'a Map<String, Value>, before: &str, cells: &mut Vec<(String, Cell<'a>)>) {
    for (key, value) in object {
        let path = if before.is_empty() {
            key.clone()
        } else {
            format!("{before}/{key}")
        };
        flatten_value(value, path, cells);
    }
}

fn flatten_value<'a>(value: &'a Value, path: String, cells: &mut Vec<(String, Cell<'a>)>) {
    match value {
        Value::Object(inner) => flatten(inner, &path, cells),
        Value::Array(list) => {
            for (index, inner) in list.iter().enumerate() {
                flatten_value(inner, format!("{path}/{index}"), cells);
            }
        }
        Value::Number(number) => cells.push((path, number.as_f64().map_or(Cell::Empty, Cell::Number))),
        Value::Bool(is_true) => cells.push((path, Cell::Number(f64::from(u8::from(*is_true))))),
        Value::String(text) => cells.push((path, Cell::Text(text))),
        Value::Null => cells.push((path, Cell::Empty)),
    }
}
