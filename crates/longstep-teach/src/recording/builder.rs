//! The frames of a recording, while it is read.

use rustc_hash::FxHashMap;

use super::clock::Clock;
use super::row::{Number, Row};
use super::side::{hands_among, listed, side_of};
use super::{FRAMES, ReadError};
use crate::demonstration::{Demonstration, Hand};

/// A row that belongs to a name: a topic, a rigid body, a group of columns.
struct Named {
    /// The index of the name; none for a row without a position, which is about every hand.
    name: usize,
    row: Row,
    logged: Option<f64>,
}

pub(super) struct Builder {
    recording: Demonstration,
    clock: Clock,
    /// The last time of each hand.
    last: [f64; 2],
    /// The last closure of each hand that came without a position.
    held: [Option<f64>; 2],
    /// The rows that wait until all names are known.
    named: Vec<Named>,
    names: Vec<String>,
    numbers: FxHashMap<String, usize>,
    /// The rows without a position.
    gaps: usize,
    /// The hand of rows that name none.
    fallback: Hand,
    is_assumed: bool,
}

impl Builder {
    pub(super) fn new(source: &str, fallback: Hand) -> Self {
        Self {
            recording: Demonstration {
                source: source.to_owned(),
                reference: None,
                begins: 0.0,
                notes: Vec::new(),
                frames: Vec::new(),
            },
            clock: Clock::default(),
            last: [f64::NEG_INFINITY; 2],
            held: [None; 2],
            named: Vec::new(),
            names: Vec::new(),
            numbers: FxHashMap::default(),
            gaps: 0,
            fallback,
            is_assumed: false,
        }
    }

    /// Adds what a person should know about how the recording was read, once.
    pub(super) fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.recording.notes.contains(&note) {
            self.recording.notes.push(note);
        }
    }

    /// The error of the frame that is read next.
    pub(super) fn error(&self, message: impl Into<String>) -> ReadError {
        let number = self.recording.frames.len() + self.gaps + self.named.len() + 1;
        ReadError {
            place: format!("{}, frame {number}", self.recording.source),
            message: message.into(),
            is_without_position: false,
        }
    }

    /// The error of the whole recording.
    pub(super) fn whole_error(&self, message: impl Into<String>) -> ReadError {
        ReadError {
            place: self.recording.source.clone(),
            message: message.into(),
            is_without_position: false,
        }
    }

    fn count(&self) -> Result<(), ReadError> {
        if self.recording.frames.len() + self.named.len() >= FRAMES {
            Err(self.error(format!("more than {FRAMES} frames")))
        } else {
            Ok(())
        }
    }

    /// Adds a row of a name, which counts if the name turns out to be a hand.
    pub(super) fn add_named(&mut self, name: &str, row: Row, logged: Option<f64>) -> Result<(), ReadError> {
        self.count()?;
        let name = match self.numbers.get(name) {
            Some(number) => *number,
            None => {
                self.numbers.insert(name.to_owned(), self.names.len());
                self.names.push(name.to_owned());
                self.names.len() - 1
            }
        };
        self.named.push(Named { name, row, logged });
        Ok(())
    }

    /// Adds the rows of the names that are hands.
    fn add_hands(&mut self) -> Result<(), ReadError> {
        let named = std::mem::take(&mut self.named);
        // A name without any position says at most how far a hand is closed.
        let mut has_position = vec![false; self.names.len()];
        for own in &named {
            has_position[own.name] |= !own.row.is_gap();
        }
        let names = std::mem::take(&mut self.names);
        let placed: Vec<usize> = (0..names.len()).filter(|index| has_position[*index]).collect();
        let written: Vec<&str> = placed.iter().map(|index| names[*index].as_str()).collect();
        if written.is_empty() {
            return Ok(());
        }
        let chosen = hands_among(&written, self.fallback).map_err(|message| self.whole_error(message))?;
        let hands: FxHashMap<usize, Hand> = chosen.iter().map(|(index, hand)| (placed[*index], *hand)).collect();
        let others: Vec<&str> = placed
            .iter()
            .filter(|index| !hands.contains_key(index))
            .map(|index| names[*index].as_str())
            .collect();
        for (index, hand) in &chosen {
            let origin = match written[*index] {
                "" => continue,
                name => name,
            };
            self.note(format!("{} is the {hand} hand", listed(&[origin])));
        }
        if !others.is_empty() {
            self.note(format!("{} are not read", listed(&others)));
        }
        for Named { name, row, logged } in named {
            match hands.get(&name) {
                Some(hand) => self.add_as(*hand, &row, logged, false)?,
                None if has_position[name] => {}
                None => {
                    let side = side_of(&names[name]);
                    let grip = row.grip().map_err(|message| self.error(message))?;
                    for hand in hands.values().filter(|hand| side.is_none_or(|side| side == **hand)) {
                        self.hold(*hand, grip);
                    }
                }
            }
        }
        Ok(())
    }

    /// Adds a row of our own columns; `logged` is the time of a message, for rows without a time.
    pub(super) fn add(&mut self, row: &Row, logged: Option<f64>) -> Result<(), ReadError> {
        let hand = row.hand().map_err(|message| self.error(message))?;
        if hand.is_none() && !row.is_gap() {
            self.is_assumed = true;
        }
        self.add_as(hand.unwrap_or(self.fallback), row, logged, true)
    }

    fn hold(&mut self, hand: Hand, grip: Option<f64>) {
        let held = &mut self.held[usize::from(hand == Hand::Right)];
        *held = grip.or(*held);
    }

    /// Adds a row of a hand. In a table that is not our own, a sensor of the gripper writes rows between those of the tracker,
    /// which are no gaps.
    fn add_as(&mut self, hand: Hand, row: &Row, logged: Option<f64>, is_own: bool) -> Result<(), ReadError> {
        if row.is_gap() {
            let grip = row.grip().map_err(|message| self.error(message))?;
            self.gaps += usize::from(is_own || grip.is_none());
            self.hold(hand, grip);
            return Ok(());
        }
        self.count()?;
        let written = row.number(Number::Time).or(logged);
        let written = written.ok_or_else(|| self.error("`t` is missing"))?;
        if !written.is_finite() {
            return Err(self.error(format!("`t` is {written}")));
        }
        let time = self.clock.seconds(written);
        let side = usize::from(hand == Hand::Right);
        let mut frame = row.frame(time, hand).map_err(|message| self.error(message))?;
        frame.grip = frame.grip.or(self.held[side]);
        if time <= self.last[side] {
            let message = format!(
                "`t` is {time} after {} of the {hand} hand; times increase",
                self.last[side]
            );
            return Err(self.error(message));
        }
        self.last[side] = time;
        let reference = row.reference().map_err(|message| self.error(message))?;
        match (&self.recording.reference, reference) {
            (Some(own), Some(other)) if *own != other => {
                return Err(self.error(format!("`frame` is `{other}` after `{own}`; a recording has one")));
            }
            (None, Some(other)) => self.recording.reference = Some(other),
            _ => {}
        }
        self.recording.frames.push(frame);
        Ok(())
    }

    /// Returns the recording, with its frames in order.
    pub(super) fn finish(mut self) -> Result<Demonstration, ReadError> {
        self.add_hands()?;
        if self.recording.frames.is_empty() && self.gaps > 0 {
            let error = self.whole_error(format!("none of its {} rows has a position", self.gaps));
            return Err(ReadError {
                is_without_position: true,
                ..error
            });
        }
        if self.is_assumed {
            let hand = self.fallback;
            self.note(format!("nothing says which hand it is; read as the {hand} hand"));
        }
        match self.gaps {
            0 => {}
            1 => self.note("1 row has no position: a gap"),
            gaps => self.note(format!("{gaps} rows have no position: gaps")),
        }
        if let Some(note) = self.clock.note() {
            self.note(note);
        }
        let mut recording = self.recording;
        recording.begins = self.clock.begins();
        recording.frames.sort_by(|one, other| one.time.total_cmp(&other.time));
        Ok(recording)
    }
}
