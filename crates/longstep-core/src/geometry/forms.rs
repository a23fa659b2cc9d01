//! The forms in which detectors and simulators write points, orientations and boxes.

use std::fmt;

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
        struct Written;
        impl<'de> Visitor<'de> for Written {
            type Value = Orientation;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a quaternion: an object with w, x, y and z, or a list of four numbers")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                let Parts { w, x, y, z } = Parts::deserialize(value::MapAccessDeserializer::new(map))?;
                Ok(Orientation::new([w, x, y, z]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<Self::Value, A::Error> {
                Ok(Orientation {
                    parts: Deserialize::deserialize(value::SeqAccessDeserializer::new(sequence))?,
                    is_listed: true,
                })
            }
        }
        deserializer.deserialize_any(Written)
    }
}

/// Reads a point or three lengths: a list, or an object with x, y and z.
pub(super) fn vector<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vector, D::Error> {
    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Axes {
        x: f64,
        y: f64,
        z: f64,
    }
    struct Written;
    impl<'de> Visitor<'de> for Written {
        type Value = Vector;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str("three numbers: a list, or an object with x, y and z")
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
            let Axes { x, y, z } = Axes::deserialize(value::MapAccessDeserializer::new(map))?;
            Ok([x, y, z])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<Self::Value, A::Error> {
            Deserialize::deserialize(value::SeqAccessDeserializer::new(sequence))
        }
    }
    deserializer.deserialize_any(Written)
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
    bbox: BoundingBox,
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
struct BoundingBox {
    center: Pose,
    #[serde(deserialize_with = "vector")]
    size: Vector,
}

#[derive(Deserialize)]
struct Pose {
    #[serde(deserialize_with = "vector")]
    position: Vector,
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
        Detected {
            name: best.map_or_else(|| format!("thing {}", index + 1), |own| own.class_id),
            position: own.bbox.center.position,
            orientation: own.bbox.center.orientation,
            size: own.bbox.size,
        }
    };
    Ok(detections.into_iter().enumerate().map(detected).collect())
}
