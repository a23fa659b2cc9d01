//! The forms in which detectors and simulators write points, orientations and boxes.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{MapAccess, SeqAccess, Visitor, value};
use serde::{Deserialize, Deserializer};

/// A point or direction in metres, with z upwards.
pub(super) type Vector = [f64; 3];

/// The order of the numbers in a quaternion that is written as a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum QuaternionOrder {
    /// Scalar first, as in MuJoCo.
    Wxyz,
    /// Scalar last, as in ROS.
    Xyzw,
}

/// An orientation: a unit quaternion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orientation {
    /// In the order w, x, y, z, once a list was put in order.
    pub(super) parts: [f64; 4],
    /// True for a list, whose order the scene has to say.
    pub(super) is_listed: bool,
}

impl Default for Orientation {
    fn default() -> Self {
        Self::new([1.0, 0.0, 0.0, 0.0])
    }
}

impl Orientation {
    /// Creates an orientation from w, x, y, z.
    pub fn new(parts: [f64; 4]) -> Self {
        Self {
            parts,
            is_listed: false,
        }
    }

    /// Puts a list in the order w, x, y, z.
    pub(super) fn ordered(self, order: Option<QuaternionOrder>) -> Self {
        let [first, second, third, last] = self.parts;
        match order {
            Some(QuaternionOrder::Xyzw) if self.is_listed => Self::new([last, first, second, third]),
            _ => Self::new(self.parts),
        }
    }
}

impl<'de> Deserialize<'de> for Orientation {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(deny_unknown_fields)]
        struct Parts {
            w: f64,
            x: f64,
            y: f64,
            z: f64,
        }
        impl From<Parts> for [f64; 4] {
            fn from(Parts { w, x, y, z }: Parts) -> Self {
                [w, x, y, z]
            }
        }
        let expected = "a quaternion: an object with w, x, y and z, or a list of four numbers";
        let (parts, is_listed) = numbers::<D, Parts, 4>(deserializer, expected)?;
        Ok(Self { parts, is_listed })
    }
}

/// Reads a point or three lengths: a list, or an object with x, y and z.
pub(super) fn vector<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vector, D::Error> {
    let expected = "three numbers: a list, or an object with x, y and z";
    numbers::<D, Axes, 3>(deserializer, expected).map(|(vector, _)| vector)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Axes {
    x: f64,
    y: f64,
    z: f64,
}

impl From<Axes> for Vector {
    fn from(Axes { x, y, z }: Axes) -> Self {
        [x, y, z]
    }
}

/// Reads numbers that are a list, or an object `O` with a name for each. Returns true for a list.
fn numbers<'de, D, O, const N: usize>(deserializer: D, expected: &'static str) -> Result<([f64; N], bool), D::Error>
where
    D: Deserializer<'de>,
    O: Deserialize<'de> + Into<[f64; N]>,
    [f64; N]: Deserialize<'de>,
{
    struct Written<O, const N: usize>(&'static str, PhantomData<O>);
    impl<'de, O, const N: usize> Visitor<'de> for Written<O, N>
    where
        O: Deserialize<'de> + Into<[f64; N]>,
        [f64; N]: Deserialize<'de>,
    {
        type Value = ([f64; N], bool);

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str(self.0)
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
            Ok((O::deserialize(value::MapAccessDeserializer::new(map))?.into(), false))
        }

        fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<Self::Value, A::Error> {
            Ok((
                Deserialize::deserialize(value::SeqAccessDeserializer::new(sequence))?,
                true,
            ))
        }
    }
    deserializer.deserialize_any(Written::<O, N>(expected, PhantomData))
}

/// A box as `bbox` writes it: its centre, with or without an orientation, and its size.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Volume {
    #[serde(alias = "centre")]
    center: Center,
    #[serde(alias = "dimensions", deserialize_with = "vector")]
    size: Vector,
    #[serde(default)]
    orientation: Option<Orientation>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Center {
    Pose(Pose),
    Point(#[serde(deserialize_with = "vector")] Vector),
}

impl Volume {
    /// Returns the position, the orientation, if there is one, and the size.
    pub(super) fn parts(self) -> (Vector, Option<Orientation>, Vector) {
        match self.center {
            Center::Pose(Pose { position, orientation }) => (position, Some(orientation), self.size),
            Center::Point(position) => (position, self.orientation, self.size),
        }
    }
}

/// Returns true if a text has boxes of a picture: corners or a list of four numbers, in pixels.
pub(super) fn is_picture(text: &str) -> bool {
    let compact: String = text.split_whitespace().collect();
    [
        "\"x1\"",
        "\"xmin\"",
        "\"x_min\"",
        "xyxy",
        "xywh",
        "\"bbox\":[",
        "\"box\":[",
        "box_2d",
    ]
    .iter()
    .any(|sign| compact.contains(sign))
}

/// `vision_msgs/Detection3DArray` as JSON.
#[derive(Deserialize)]
struct Detections {
    detections: Vec<Detection>,
}

#[derive(Deserialize)]
struct Detection {
    #[serde(default)]
    results: Vec<Hypothesis>,
    bbox: Volume,
}

#[derive(Deserialize)]
struct Hypothesis {
    hypothesis: Class,
}

#[derive(Deserialize)]
struct Class {
    class_id: String,
    #[serde(default)]
    score: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Pose {
    #[serde(deserialize_with = "vector")]
    position: Vector,
    #[serde(default)]
    orientation: Orientation,
}

/// A detected box.
pub(super) struct Detected {
    pub(super) name: String,
    pub(super) position: Vector,
    pub(super) orientation: Orientation,
    pub(super) size: Vector,
}

/// Reads the boxes of `vision_msgs/Detection3DArray`, each with the class of its best hypothesis.
pub(super) fn detections(text: &str) -> Result<Vec<Detected>, serde_json::Error> {
    let Detections { detections } = serde_json::from_str(text)?;
    let detected = |(index, own): (usize, Detection)| {
        let classes = own.results.into_iter().map(|own| own.hypothesis);
        let best = classes.max_by(|one, other| one.score.total_cmp(&other.score));
        let (position, orientation, size) = own.bbox.parts();
        Detected {
            name: best.map_or_else(|| format!("thing {}", index + 1), |own| own.class_id),
            position,
            orientation: orientation.unwrap_or_default(),
            size,
        }
    };
    Ok(detections.into_iter().enumerate().map(detected).collect())
}
