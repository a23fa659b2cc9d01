//! Columns: the meaning of the names in tables and objects.
//!
//! A name is one of our own (`t`, `x`, `grip`), or a path of ROS 2 as PlotJuggler and JSON write it (`/hand/pose/position/x`,
//! `header.stamp.sec`). Tables of paths have columns that mean nothing here; a table of our own names has none.

use super::row::{Number, Text};

/// The numbers of our own names.
const NUMBERS: [(&str, Number); 20] = [
    ("x", Number::X),
    ("y", Number::Y),
    ("z", Number::Z),
    ("qx", Number::Qx),
    ("qy", Number::Qy),
    ("qz", Number::Qz),
    ("qw", Number::Qw),
    ("grip", Number::Grip),
    ("elbow_x", Number::ElbowX),
    ("elbow_y", Number::ElbowY),
    ("elbow_z", Number::ElbowZ),
    ("shoulder_x", Number::ShoulderX),
    ("shoulder_y", Number::ShoulderY),
    ("shoulder_z", Number::ShoulderZ),
    ("object_x", Number::ObjectX),
    ("object_y", Number::ObjectY),
    ("object_z", Number::ObjectZ),
    ("step", Number::Step),
    ("t", Number::Time),
    ("time", Number::Time),
];
/// Other names of the time.
const TIMES: [&str; 2] = ["__time", "timestamp"];
/// The last parts of paths that say how far the hand is closed.
const GRIPS: [&str; 4] = ["grip", "closed", "closure", "gripper"];

/// The meaning of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    Number(Number),
    Text(Text),
    /// A part of a pose, behind a prefix of this many bytes.
    Pose {
        number: Number,
        prefix: usize,
    },
    /// A part of a path that means how far the hand is closed.
    PathGrip,
    /// The parts of a time stamp.
    Seconds,
    Nanoseconds,
    /// A column of a path that means nothing here.
    Other,
    /// A name that is none of ours.
    Unknown,
}

/// Returns the meaning of a column.
pub(super) fn meaning(name: &str) -> Meaning {
    let name = name.trim();
    let lower = name.to_ascii_lowercase().replace('.', "/");
    if let Some((_, number)) = NUMBERS.iter().find(|(own, _)| *own == lower) {
        return Meaning::Number(*number);
    }
    match lower.as_str() {
        "hand" => return Meaning::Text(Text::Hand),
        "grasp" => return Meaning::Text(Text::Grasp),
        "frame" | "frame_id" | "header/frame_id" => return Meaning::Text(Text::Frame),
        own if TIMES.contains(&own) => return Meaning::Number(Number::Time),
        _ => {}
    }
    let path = lower.trim_start_matches('/');
    let parts: Vec<&str> = path.split('/').filter(|part| !part.is_empty()).collect();
    let (Some(last), true) = (parts.last(), lower.contains('/')) else {
        return Meaning::Unknown;
    };
    let kind = parts.len().checked_sub(2).map_or("", |index| parts[index]);
    let number = match (kind, *last) {
        ("position" | "translation" | "point", "x" | "0") => Some(Number::X),
        ("position" | "translation" | "point", "y" | "1") => Some(Number::Y),
        ("position" | "translation" | "point", "z" | "2") => Some(Number::Z),
        ("orientation" | "rotation", "x") => Some(Number::Qx),
        ("orientation" | "rotation", "y") => Some(Number::Qy),
        ("orientation" | "rotation", "z") => Some(Number::Qz),
        ("orientation" | "rotation", "w") => Some(Number::Qw),
        _ => None,
    };
    if let Some(number) = number {
        // Every part is as long as before it was in small letters.
        let prefix = lower.len().saturating_sub(kind.len() + 1 + last.len());
        return Meaning::Pose { number, prefix };
    }
    match (parts.as_slice(), kind, *last) {
        (["header", "stamp", "sec"], ..) => Meaning::Seconds,
        (["header", "stamp", "nanosec" | "nsec"], ..) => Meaning::Nanoseconds,
        (_, _, last) if GRIPS.contains(&last) => Meaning::PathGrip,
        _ => Meaning::Other,
    }
}

/// Returns true if the name of a topic says that it is about how far a hand is closed.
pub(super) fn is_grip(topic: &str) -> bool {
    let lower = topic.to_ascii_lowercase();
    GRIPS.iter().any(|own| lower.contains(own))
}

/// Returns the name in front of a part of a pose: `/hand/pose/position/x` has `/hand/pose`.
pub(super) fn prefix(name: &str, length: usize) -> &str {
    let name = name.trim();
    name.get(..length).unwrap_or(name).trim_end_matches(['/', '.'])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_columns_have_one_meaning() {
        for (name, expected) in [
            ("t", Meaning::Number(Number::Time)),
            (" __time ", Meaning::Number(Number::Time)),
            ("X", Meaning::Number(Number::X)),
            ("Hand", Meaning::Text(Text::Hand)),
            ("header.frame_id", Meaning::Text(Text::Frame)),
            ("header/stamp/nanosec", Meaning::Nanoseconds),
            ("/gripper/closed", Meaning::PathGrip),
            ("/joints/elbow", Meaning::Other),
            ("elbow", Meaning::Unknown),
        ] {
            assert_eq!(meaning(name), expected, "{name}");
        }
        for (name, number, before) in [
            ("/hand/pose/position/x", Number::X, "/hand/pose"),
            ("pose.orientation.w", Number::Qw, "pose"),
            ("position/2", Number::Z, ""),
        ] {
            let Meaning::Pose {
                number: found,
                prefix: length,
            } = meaning(name)
            else {
                panic!("{name}");
            };
            assert_eq!((found, prefix(name, length)), (number, before), "{name}");
        }
    }
}
