//! A demonstration: the recorded motion of one or two hands.

use std::fmt;

use nalgebra::Vector3;

/// A hand of the person who demonstrates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Hand {
    /// The left hand.
    Left,
    /// The right hand.
    Right,
}

impl Hand {
    /// The name in recordings and skill values.
    pub fn name(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }

    /// Returns the hand of that name, in any case.
    ///
    /// ```
    /// use longstep_teach::Hand;
    /// assert_eq!(Hand::named("Left"), Some(Hand::Left));
    /// assert_eq!(Hand::named("third"), None);
    /// ```
    pub fn named(name: &str) -> Option<Self> {
        let is = |own: &Self| own.name().eq_ignore_ascii_case(name.trim());
        [Self::Left, Self::Right].into_iter().find(is)
    }
}

impl fmt::Display for Hand {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A hand at one moment. Positions are in metres: x to the right, y forward, z up.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// The time in seconds.
    pub time: f64,
    /// The hand.
    pub hand: Hand,
    /// The position of the hand.
    pub position: Vector3<f64>,
    /// The orientation of the hand as a quaternion (x, y, z, w) of length 1.
    pub orientation: Option<[f64; 4]>,
    /// The closure of the hand, from 0 (open) to 1 (closed).
    pub grip: Option<f64>,
    /// The position of the elbow.
    pub elbow: Option<Vector3<f64>>,
    /// The position of the shoulder.
    pub shoulder: Option<Vector3<f64>>,
    /// The position of the manipulated object.
    pub object: Option<Vector3<f64>>,
    /// The kind of grasp.
    pub grasp: Option<String>,
    /// The number of the step that is shown, from 1.
    pub step: Option<usize>,
}

/// A recording of one or two hands.
#[derive(Debug, Clone, PartialEq)]
pub struct Demonstration {
    /// The name of the recording, for the source of values.
    pub source: String,
    /// The frame of reference that the recording names; none if it names none.
    pub reference: Option<String>,
    /// The seconds since the epoch at the time 0; 0 for a recording that counts from its own beginning.
    pub begins: f64,
    /// The assumptions with which the recording was read, and what of it was not read.
    pub notes: Vec<String>,
    /// The frames, in order of time.
    pub frames: Vec<Frame>,
}

impl Demonstration {
    /// Returns the time of the first and the last frame; none without frames.
    pub fn span(&self) -> Option<(f64, f64)> {
        Some((self.frames.first()?.time, self.frames.last()?.time))
    }

    /// Returns the frames of a hand from one time to another, both included.
    pub fn between(&self, hand: Hand, from: f64, to: f64) -> Vec<&Frame> {
        let is = |frame: &&Frame| frame.hand == hand && frame.time >= from && frame.time <= to;
        self.frames.iter().filter(is).collect()
    }

    /// Returns the hands of the recording.
    pub fn hands(&self) -> Vec<Hand> {
        let shown = |hand: &Hand| self.frames.iter().any(|frame| frame.hand == *hand);
        [Hand::Left, Hand::Right].into_iter().filter(shown).collect()
    }
}
