//! Rows: the numbers and texts of one frame, as they are written, and the frame that they mean.

use nalgebra::Vector3;

use super::shortened;
use crate::demonstration::{Frame, Hand};

/// The most characters of a text in a recording.
const CHARACTERS: usize = 100;
/// The farthest coordinate, in metres. Larger ones are millimetres.
const FARTHEST: f64 = 50.0;
/// The most steps of a plan that a recording can name.
const STEPS: f64 = 100_000.0;

/// A number of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    Time,
    X,
    Y,
    Z,
    Qx,
    Qy,
    Qz,
    Qw,
    Grip,
    ElbowX,
    ElbowY,
    ElbowZ,
    ShoulderX,
    ShoulderY,
    ShoulderZ,
    ObjectX,
    ObjectY,
    ObjectZ,
    Step,
}

/// The number of numbers.
const NUMBERS: usize = Number::Step as usize + 1;

/// A text of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Text {
    Hand,
    Grasp,
    Frame,
}

/// A row of a table, an object, or a message.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Row {
    numbers: [Option<f64>; NUMBERS],
    texts: [Option<String>; 3],
}

impl Row {
    pub(super) fn number(&self, number: Number) -> Option<f64> {
        self.numbers[number as usize]
    }

    pub(super) fn set(&mut self, number: Number, value: f64) {
        self.numbers[number as usize] = Some(value);
    }

    /// Takes the position and the orientation of another row.
    pub(super) fn take_pose(&mut self, other: &Self) {
        let pose = Number::X as usize..=Number::Qw as usize;
        self.numbers[pose.clone()].copy_from_slice(&other.numbers[pose]);
    }

    pub(super) fn set_all<const N: usize>(&mut self, numbers: [Number; N], values: [f64; N]) {
        for (number, value) in numbers.into_iter().zip(values) {
            self.set(number, value);
        }
    }

    pub(super) fn text(&self, text: Text) -> Option<&str> {
        self.texts[text as usize].as_deref()
    }

    /// Sets a text; an empty one means none.
    pub(super) fn set_text(&mut self, text: Text, value: &str) {
        self.texts[text as usize] = Some(value.to_owned()).filter(|own| !own.is_empty());
    }

    /// Returns true if the row says nothing about where the hand is: a tracker has lost it.
    pub(super) fn is_gap(&self) -> bool {
        let is_lost = |number| self.number(number).is_none_or(f64::is_nan);
        [Number::X, Number::Y, Number::Z].into_iter().all(is_lost)
    }

    /// Returns the hand that the row names.
    pub(super) fn hand(&self) -> Result<Option<Hand>, String> {
        let named = |name: &str| {
            Hand::named(name).ok_or_else(|| format!("`hand` is `{}`; it is `left` or `right`", shortened(name)))
        };
        self.text(Text::Hand).map(named).transpose()
    }

    /// Returns the frame of reference that the row names.
    pub(super) fn reference(&self) -> Result<Option<String>, String> {
        self.text(Text::Frame).map(|own| plain("frame", own)).transpose()
    }

    /// Returns how far the hand is closed.
    pub(super) fn grip(&self) -> Result<Option<f64>, String> {
        match self.number(Number::Grip) {
            Some(grip) if !(0.0..=1.0).contains(&grip) => {
                Err(format!("`grip` is {grip}; it is from 0 (open) to 1 (closed)"))
            }
            grip => Ok(grip),
        }
    }

    /// Returns the frame of a row that is no gap.
    pub(super) fn frame(&self, time: f64, hand: Hand) -> Result<Frame, String> {
        use Number::{ElbowX, ElbowY, ElbowZ, ObjectX, ObjectY, ObjectZ, ShoulderX, ShoulderY, ShoulderZ, X, Y, Z};
        let position = self.point(["x", "y", "z"], [X, Y, Z])?;
        Ok(Frame {
            time,
            hand,
            position: position.ok_or("the position is missing")?,
            orientation: self.orientation()?,
            grip: self.grip()?,
            elbow: self.point(["elbow_x", "elbow_y", "elbow_z"], [ElbowX, ElbowY, ElbowZ])?,
            shoulder: self.point(
                ["shoulder_x", "shoulder_y", "shoulder_z"],
                [ShoulderX, ShoulderY, ShoulderZ],
            )?,
            object: self.point(["object_x", "object_y", "object_z"], [ObjectX, ObjectY, ObjectZ])?,
            grasp: self.text(Text::Grasp).map(|own| plain("grasp", own)).transpose()?,
            step: self.step()?,
        })
    }

    fn step(&self) -> Result<Option<usize>, String> {
        match self.number(Number::Step) {
            Some(step) if !((1.0..=STEPS).contains(&step) && step.fract() == 0.0) => {
                Err(format!("`step` is {step}; steps are counted from 1"))
            }
            step => Ok(step.map(|step| step as usize)),
        }
    }

    fn point(&self, names: [&str; 3], numbers: [Number; 3]) -> Result<Option<Vector3<f64>>, String> {
        match numbers.map(|number| self.number(number)) {
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

    fn orientation(&self) -> Result<Option<[f64; 4]>, String> {
        match [Number::Qx, Number::Qy, Number::Qz, Number::Qw].map(|number| self.number(number)) {
            [None, None, None, None] => Ok(None),
            [Some(x), Some(y), Some(z), Some(w)] => {
                let length = [x, y, z, w].iter().map(|part| part * part).sum::<f64>().sqrt();
                if (length - 1.0).abs() < 0.01 {
                    Ok(Some([x, y, z, w]))
                } else {
                    Err(format!("the quaternion has the length {length}, not 1"))
                }
            }
            _ => Err("`qx`, `qy`, `qz` and `qw` belong together".to_owned()),
        }
    }
}

fn coordinate(name: &str, value: f64) -> Result<f64, String> {
    if !value.is_finite() {
        return Err(format!("`{name}` is {value}"));
    }
    if value.abs() <= FARTHEST {
        Ok(value)
    } else {
        Err(format!(
            "`{name}` is {value}, farther than {FARTHEST} m; positions are in metres"
        ))
    }
}

fn plain(name: &str, value: &str) -> Result<String, String> {
    let is_plain = value.chars().all(|c| c.is_alphanumeric() || "_-./ ".contains(c));
    if is_plain && value.chars().count() <= CHARACTERS {
        Ok(value.to_owned())
    } else {
        Err(format!(
            "`{name}` is `{}`; it has at most {CHARACTERS} letters, digits and `_-./`",
            shortened(value)
        ))
    }
}
