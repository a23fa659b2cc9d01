//! Tables: CSV with a line of names, as trackers, spreadsheets and PlotJuggler write it.

use super::builder::Builder;
use super::cells::{cell, lines};
use super::columns::{Meaning, meaning, prefix};
use super::row::{Number, Row, Text};
use super::side::listed;
use super::{ReadError, motive};

/// Reads a table.
pub(super) fn read(bytes: &[u8], builder: &mut Builder) -> Result<(), ReadError> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(builder.whole_error("the text is UTF-16; save it as CSV in UTF-8"));
    }
    let (first, rest) = first_line(bytes);
    // A spreadsheet may say which separator it wrote.
    if let Some([separator]) = first.strip_prefix(b"sep=") {
        return read_columns(rest, *separator, builder);
    }
    let separator = separator(first);
    if motive::is_heading(first) {
        motive::read(bytes, separator, builder)
    } else {
        read_columns(bytes, separator, builder)
    }
}

fn first_line(bytes: &[u8]) -> (&[u8], &[u8]) {
    let end = bytes.iter().position(|byte| *byte == b'\n').unwrap_or(bytes.len());
    let (line, rest) = bytes.split_at(end);
    (line.trim_ascii(), rest.get(1..).unwrap_or_default())
}

/// Returns the separator that a line of names has most often.
fn separator(line: &[u8]) -> u8 {
    let count = |own: &u8| line.iter().filter(|byte| *byte == own).count();
    let most = [b'\t', b';', b','].into_iter().max_by_key(count);
    most.unwrap_or(b',')
}

/// The columns of a table, by their meaning.
#[derive(Default)]
struct Columns {
    numbers: Vec<(usize, Number)>,
    texts: Vec<(usize, Text)>,
    /// The columns of poses, by the name in front of them.
    poses: Vec<(String, Vec<(usize, Number)>)>,
}

impl Columns {
    fn read(names: &csv::ByteRecord, builder: &mut Builder) -> Result<Self, ReadError> {
        let mut own = Self::default();
        let (mut grips, mut others, mut unknown) = (Vec::new(), Vec::new(), Vec::new());
        let names: Vec<String> = names
            .iter()
            .map(|name| String::from_utf8_lossy(name).into_owned())
            .collect();
        for (index, name) in names.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
            match meaning(name) {
                Meaning::Number(number) => own.numbers.push((index, number)),
                Meaning::Text(text) => own.texts.push((index, text)),
                Meaning::Pose { number, prefix: length } => own.add_pose(prefix(name, length), index, number),
                Meaning::PathGrip => grips.push((index, name.as_str())),
                Meaning::Other | Meaning::Seconds | Meaning::Nanoseconds => others.push(name.as_str()),
                Meaning::Unknown => unknown.push(name.as_str()),
            }
        }
        own.poses
            .retain(|(_, columns)| columns.iter().any(|(_, number)| *number == Number::X));
        if own.poses.is_empty() {
            own.check_own(&names, &unknown)
                .map_err(|message| builder.whole_error(message))?
        } else {
            others.extend(unknown)
        }
        own.add_grip(&grips, builder)?;
        own.check_twice(&names)
            .map_err(|message| builder.whole_error(message))?;
        if !others.is_empty() {
            builder.note(format!("columns that are not read: {}", listed(&others)));
        }
        Ok(own)
    }

    fn add_pose(&mut self, prefix: &str, index: usize, number: Number) {
        match self.poses.iter_mut().find(|(own, _)| own == prefix) {
            Some((_, columns)) => columns.push((index, number)),
            None => self.poses.push((prefix.to_owned(), vec![(index, number)])),
        }
    }

    /// Fails for a table whose names are ours, if one is not, or the position is missing.
    fn check_own(&self, names: &[String], unknown: &[&str]) -> Result<(), String> {
        let has = |number| self.numbers.iter().any(|(_, own)| *own == number);
        let missing: Vec<&str> = [("x", Number::X), ("y", Number::Y), ("z", Number::Z)]
            .into_iter()
            .filter(|(_, number)| !has(*number))
            .map(|(name, _)| name)
            .collect();
        if !missing.is_empty() {
            let all: Vec<&str> = names.iter().map(String::as_str).collect();
            return Err(format!(
                "no column {}; name the columns of the position, in metres, `x`, `y` and `z`, and that of the time `t` (there are {})",
                listed(&missing),
                listed(&all)
            ));
        }
        if unknown.is_empty() {
            Ok(())
        } else {
            Err(format!(
                "unknown column {}; rename it to one of the columns of a recording, or take it out",
                listed(unknown)
            ))
        }
    }

    /// Adds the column of the grip in a table of paths.
    fn add_grip(&mut self, grips: &[(usize, &str)], builder: &mut Builder) -> Result<(), ReadError> {
        if self.numbers.iter().any(|(_, number)| *number == Number::Grip) {
            return Ok(());
        }
        match grips {
            [] => Ok(()),
            [(index, name)] => {
                self.numbers.push((*index, Number::Grip));
                builder.note(format!("{} is read as `grip`", listed(&[name])));
                Ok(())
            }
            several => {
                let names: Vec<&str> = several.iter().map(|(_, name)| *name).collect();
                let message = format!("{} may all be the grip; rename one to `grip`", listed(&names));
                Err(builder.whole_error(message))
            }
        }
    }

    fn check_twice(&self, names: &[String]) -> Result<(), String> {
        let groups = self.poses.iter().map(|(_, columns)| columns).chain([&self.numbers]);
        for columns in groups {
            for (place, (index, number)) in columns.iter().enumerate() {
                if let Some((other, _)) = columns[..place].iter().find(|(_, own)| own == number) {
                    let both = [names[*other].as_str(), names[*index].as_str()];
                    return Err(format!("{} mean the same; take one out, or rename it", listed(&both)));
                }
            }
        }
        Ok(())
    }

    fn row(&self, line: &csv::ByteRecord, builder: &mut Builder) -> Result<Row, ReadError> {
        let mut row = Row::default();
        fill(&mut row, &self.numbers, line, builder)?;
        for (index, text) in &self.texts {
            row.set_text(*text, &String::from_utf8_lossy(line.get(*index).unwrap_or_default()));
        }
        Ok(row)
    }
}

fn fill(
    row: &mut Row,
    columns: &[(usize, Number)],
    line: &csv::ByteRecord,
    builder: &mut Builder,
) -> Result<(), ReadError> {
    for (index, number) in columns {
        if let Some(value) = cell(line, *index, builder)? {
            row.set(*number, value);
        }
    }
    Ok(())
}

fn read_columns(bytes: &[u8], separator: u8, builder: &mut Builder) -> Result<(), ReadError> {
    let mut reader = lines(bytes, separator, true);
    let names = reader
        .byte_headers()
        .map_err(|error| builder.whole_error(error.to_string()))?
        .clone();
    if names.iter().all(<[u8]>::is_empty) {
        return Ok(());
    }
    let columns = Columns::read(&names, builder)?;
    let mut line = csv::ByteRecord::new();
    while reader
        .read_byte_record(&mut line)
        .map_err(|error| builder.error(error.to_string()))?
    {
        let row = columns.row(&line, builder)?;
        if columns.poses.is_empty() {
            builder.add(&row, None)?;
            continue;
        }
        for (name, pose) in &columns.poses {
            let mut row = row.clone();
            fill(&mut row, pose, &line, builder)?;
            builder.add_named(name, row, None)?;
        }
    }
    Ok(())
}
