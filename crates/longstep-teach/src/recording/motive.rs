//! Tables of OptiTrack's Motive: a heading of several lines, a group of columns for each rigid body or marker.

use super::ReadError;
use super::builder::Builder;
use super::cells::{cell, lines};
use super::row::{Number, Row};
use super::side::listed;

/// The most lines of a heading.
const HEADING: usize = 12;

/// Returns true if a table begins with the heading of Motive.
pub(super) fn is_heading(line: &[u8]) -> bool {
    line.trim_ascii_start()
        .to_ascii_lowercase()
        .starts_with(b"format version")
}

/// The heading of a table.
struct Heading {
    /// The metres of a unit.
    metres: f64,
    is_z_up: bool,
    time: usize,
    bodies: Vec<Body>,
}

/// The columns of a rigid body, a bone or a marker.
struct Body {
    name: String,
    position: [Option<usize>; 3],
    rotation: [Option<usize>; 4],
}

pub(super) fn read(bytes: &[u8], separator: u8, builder: &mut Builder) -> Result<(), ReadError> {
    let mut reader = lines(bytes, separator, false);
    let mut written: Vec<Vec<String>> = Vec::new();
    let mut line = csv::ByteRecord::new();
    loop {
        let is_read = reader
            .read_byte_record(&mut line)
            .map_err(|error| builder.whole_error(error.to_string()))?;
        if !is_read || written.len() == HEADING {
            return Err(builder.whole_error("the heading of Motive has no line that begins with `Frame` and `Time`"));
        }
        let cells: Vec<String> = line
            .iter()
            .map(|cell| String::from_utf8_lossy(cell).into_owned())
            .collect();
        let is_last = cells
            .get(1)
            .is_some_and(|cell| cell.to_ascii_lowercase().starts_with("time"));
        written.push(cells);
        if is_last {
            break;
        }
    }
    let heading = Heading::read(&written).map_err(|message| builder.whole_error(message))?;
    let up = if heading.is_z_up { "z" } else { "y" };
    let unit = written_unit(&written[0]).unwrap_or_default();
    builder.note(format!("the heading of Motive says {unit}; {up} is up"));
    while reader
        .read_byte_record(&mut line)
        .map_err(|error| builder.error(error.to_string()))?
    {
        let time = cell(&line, heading.time, builder)?;
        for body in &heading.bodies {
            let row = heading.row(body, time, &line, builder)?;
            builder.add_named(&body.name, row, None)?;
        }
    }
    Ok(())
}

/// Returns the value behind a key of the first line.
fn value<'a>(first: &'a [String], key: &str) -> Option<&'a str> {
    let place = first.iter().position(|cell| cell.eq_ignore_ascii_case(key))?;
    first
        .get(place + 1)
        .map(String::as_str)
        .filter(|value| !value.is_empty())
}

fn written_unit(first: &[String]) -> Option<&str> {
    value(first, "Length Units")
}

impl Heading {
    fn read(written: &[Vec<String>]) -> Result<Self, String> {
        let first = written.first().map_or(&[][..], Vec::as_slice);
        let unit =
            written_unit(first).ok_or("the heading of Motive has no `Length Units`; export it with its heading")?;
        let metres = match unit.to_ascii_lowercase().as_str() {
            "meters" | "metres" | "m" => 1.0,
            "centimeters" | "centimetres" | "cm" => 0.01,
            "millimeters" | "millimetres" | "mm" => 0.001,
            _ => {
                return Err(format!(
                    "the heading of Motive has the length unit {}; export in meters, centimeters or millimeters",
                    listed(&[unit])
                ));
            }
        };
        // Motive's axes have y up, unless the export says another one.
        let is_axis = |cell: &&String| {
            let cell = cell.to_ascii_lowercase();
            cell.contains("up axis") || cell.contains("axis convention")
        };
        let axis = first.iter().find(is_axis).and_then(|key| value(first, key));
        let is_z_up = axis.is_some_and(|axis| axis.to_ascii_lowercase().starts_with('z'));
        let [_, names @ .., properties, axes] = written else {
            return Err("the heading of Motive is too short".to_owned());
        };
        let bodies = bodies(names, properties, axes);
        if bodies.is_empty() {
            Err("the heading of Motive has no columns `Position`; export positions".to_owned())
        } else {
            Ok(Self {
                metres,
                is_z_up,
                time: 1,
                bodies,
            })
        }
    }

    fn row(
        &self,
        body: &Body,
        time: Option<f64>,
        line: &csv::ByteRecord,
        builder: &mut Builder,
    ) -> Result<Row, ReadError> {
        let mut read = |column: Option<usize>| column.map_or(Ok(None), |index| cell(line, index, builder));
        let [x, y, z] = body.position;
        let [qx, qy, qz, qw] = body.rotation;
        let position = [read(x)?, read(y)?, read(z)?];
        let rotation = [read(qx)?, read(qy)?, read(qz)?, read(qw)?];
        let mut row = Row::default();
        if let Some(time) = time {
            row.set(Number::Time, time);
        }
        if let [Some(x), Some(y), Some(z)] = position {
            let position = self.turned([x, y, z]).map(|part| part * self.metres);
            row.set_all([Number::X, Number::Y, Number::Z], position);
            if let [Some(x), Some(y), Some(z), Some(w)] = rotation {
                row.set_all([Number::Qx, Number::Qy, Number::Qz], self.turned([x, y, z]));
                row.set(Number::Qw, w);
            }
        }
        Ok(row)
    }

    /// Turns a vector so that z is up and y forward.
    fn turned(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        if self.is_z_up { [x, y, z] } else { [x, -z, y] }
    }
}

/// Returns what has positions: rigid bodies, or else bones and markers.
fn bodies(names: &[Vec<String>], properties: &[String], axes: &[String]) -> Vec<Body> {
    let kinds = names.iter().find(|line| line.iter().any(|cell| is_kind(cell)));
    let labels = names
        .iter()
        .find(|line| line.iter().any(|cell| cell.eq_ignore_ascii_case("name")));
    // The line `Name` has the names themselves in some versions, without the word.
    let labels = labels.or_else(|| {
        let place = names.iter().position(|line| line.iter().any(|cell| is_kind(cell)))?;
        names.get(place + 1)
    });
    let text = |line: Option<&Vec<String>>, column: usize| {
        line.and_then(|line| line.get(column))
            .map_or("", String::as_str)
            .to_owned()
    };
    let mut found: Vec<(String, Body)> = Vec::new();
    for (column, axis) in axes.iter().enumerate().skip(2) {
        let (kind, name) = (text(kinds, column), text(labels, column));
        let place = found.iter().position(|(own, body)| *own == kind && body.name == name);
        let place = place.unwrap_or_else(|| {
            let (position, rotation) = ([None; 3], [None; 4]);
            found.push((
                kind,
                Body {
                    name,
                    position,
                    rotation,
                },
            ));
            found.len() - 1
        });
        let body = &mut found[place].1;
        let property = properties.get(column).map_or("", String::as_str);
        let axis = ["x", "y", "z", "w"]
            .iter()
            .position(|own| axis.eq_ignore_ascii_case(own));
        match (property.to_ascii_lowercase().as_str(), axis) {
            ("position", Some(axis @ 0..3)) => body.position[axis] = Some(column),
            ("rotation", Some(axis)) => body.rotation[axis] = Some(column),
            _ => {}
        }
    }
    found.retain(|(_, body)| body.position.iter().all(Option::is_some));
    let has_bodies = found.iter().any(|(kind, _)| kind.eq_ignore_ascii_case("rigid body"));
    let is_wanted = |kind: &str| kind.eq_ignore_ascii_case("rigid body") || !has_bodies;
    found
        .into_iter()
        .filter(|(kind, _)| is_wanted(kind))
        .map(|(_, body)| body)
        .collect()
}

fn is_kind(cell: &str) -> bool {
    ["rigid body", "marker", "bone", "rigid body marker"]
        .iter()
        .any(|kind| cell.eq_ignore_ascii_case(kind))
}
