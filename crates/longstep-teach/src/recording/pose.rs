//! Messages of ROS 2 with a pose or a grip, in CDR.

use byteorder::{BigEndian, LittleEndian};
use cdr_encoding::from_bytes;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::row::{Number, Row, Text};

#[derive(Deserialize)]
struct Stamp {
    sec: i32,
    nanosec: u32,
}

#[derive(Deserialize)]
struct Header {
    stamp: Stamp,
    frame_id: String,
}

#[derive(Deserialize)]
struct Vector {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Deserialize)]
struct Quaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

#[derive(Deserialize)]
struct Pose {
    position: Vector,
    orientation: Quaternion,
}

/// `PoseStamped`; `PoseWithCovarianceStamped` begins in the same way.
#[derive(Deserialize)]
struct PoseStamped {
    header: Header,
    pose: Pose,
}

/// The beginning of `nav_msgs/Odometry`.
#[derive(Deserialize)]
struct Odometry {
    header: Header,
    _child_frame_id: String,
    pose: Pose,
}

#[derive(Deserialize)]
struct PointStamped {
    header: Header,
    point: Vector,
}

/// `TransformStamped`: its transform has the form of a pose.
#[derive(Deserialize)]
struct TransformStamped {
    header: Header,
    child_frame_id: String,
    transform: Pose,
}

/// A row of a message, with what it adds to the name of its topic.
pub(super) type Sighted = (String, Row);

/// The reader of a type of messages.
pub(super) type Reader = fn(&[u8]) -> Result<Vec<Sighted>, String>;

/// Returns the reader of the messages of a channel; none for messages that say nothing about a hand.
pub(super) fn reader(topic: &str, kind: &str) -> Option<Reader> {
    let kind = kind.replace("/msg/", "/");
    let is_grip = super::columns::is_grip(topic);
    Some(match kind.as_str() {
        "geometry_msgs/PoseStamped" | "geometry_msgs/PoseWithCovarianceStamped" => |data| {
            let PoseStamped { header, pose } = message(data)?;
            Ok(vec![(
                String::new(),
                row(Some(&header), &pose.position, Some(&pose.orientation)),
            )])
        },
        "geometry_msgs/Pose" => |data| {
            let Pose { position, orientation } = message(data)?;
            Ok(vec![(String::new(), row(None, &position, Some(&orientation)))])
        },
        "nav_msgs/Odometry" => |data| {
            let Odometry { header, pose, .. } = message(data)?;
            Ok(vec![(
                String::new(),
                row(Some(&header), &pose.position, Some(&pose.orientation)),
            )])
        },
        "geometry_msgs/PointStamped" => |data| {
            let PointStamped { header, point } = message(data)?;
            Ok(vec![(String::new(), row(Some(&header), &point, None))])
        },
        "geometry_msgs/Point" => |data| Ok(vec![(String::new(), row(None, &message(data)?, None))]),
        "geometry_msgs/TransformStamped" => |data| Ok(vec![transform(message(data)?)]),
        "tf2_msgs/TFMessage" => |data| {
            let transforms: Vec<TransformStamped> = message(data)?;
            Ok(transforms.into_iter().map(transform).collect())
        },
        "std_msgs/Float64" if is_grip => |data| Ok(vec![grip(message::<f64>(data)?)]),
        "std_msgs/Float32" if is_grip => |data| Ok(vec![grip(f64::from(message::<f32>(data)?))]),
        "std_msgs/Bool" if is_grip => |data| Ok(vec![grip(f64::from(u8::from(message::<bool>(data)?)))]),
        _ => return None,
    })
}

fn transform(own: TransformStamped) -> Sighted {
    let pose = &own.transform;
    let row = row(Some(&own.header), &pose.position, Some(&pose.orientation));
    (own.child_frame_id, row)
}

fn row(header: Option<&Header>, position: &Vector, orientation: Option<&Quaternion>) -> Row {
    let mut row = Row::default();
    row.set_all([Number::X, Number::Y, Number::Z], [position.x, position.y, position.z]);
    if let Some(Quaternion { x, y, z, w }) = orientation {
        row.set_all([Number::Qx, Number::Qy, Number::Qz, Number::Qw], [*x, *y, *z, *w]);
    }
    if let Some(Header { stamp, frame_id }) = header {
        row.set_text(Text::Frame, frame_id);
        // A stamp that nobody set is 0.
        if stamp.sec != 0 || stamp.nanosec != 0 {
            row.set(Number::Time, f64::from(stamp.sec) + f64::from(stamp.nanosec) / 1e9);
        }
    }
    row
}

fn grip(value: f64) -> Sighted {
    let mut row = Row::default();
    row.set(Number::Grip, value);
    (String::new(), row)
}

/// Reads a message in CDR: four bytes say the order of bytes.
fn message<T: DeserializeOwned>(data: &[u8]) -> Result<T, String> {
    let (head, body) = data.split_first_chunk::<4>().ok_or("it has no CDR head")?;
    let read = match head[1] {
        0 => from_bytes::<T, BigEndian>(body),
        1 => from_bytes::<T, LittleEndian>(body),
        kind => return Err(format!("the CDR encoding {kind} is not read")),
    };
    read.map(|(message, _)| message).map_err(|error| error.to_string())
}
