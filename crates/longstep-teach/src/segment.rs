//! Segments: the part of a recording that shows a step.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::demonstration::{Demonstration, Frame, Hand};
use crate::finding::{Finding, Problem};
use crate::request::Request;

/// A hand is closed above this share.
pub(crate) const CLOSED: f64 = 0.5;
/// A hand that is slower than this, in metres a second, rests.
const RESTS: f64 = 0.05;
/// The shortest rest between two steps, in seconds.
const PAUSE: f64 = 0.2;
/// The time before and after a moment from which its speed is measured, in seconds.
const WINDOW: f64 = 0.3;
/// The part of a grasp or release after the hand begins to close and before it is open, in seconds.
const GRIPPING: f64 = 0.2;
/// A pause between steps is at least this many times as long as one within a step.
const CLEARLY: f64 = 1.3;

/// The part of a recording that shows a step.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Segment {
    /// The number of the step, from 1.
    pub step: usize,
    /// The recording.
    pub source: String,
    /// The frame of reference that the recording names.
    pub reference: Option<String>,
    /// The frames of both hands, in order of time.
    pub frames: Vec<Frame>,
}

impl Segment {
    /// Returns a recording as the segment of one step.
    pub fn whole(recording: &Demonstration, step: usize) -> Self {
        Self::of(recording, step, f64::NEG_INFINITY, f64::INFINITY)
    }

    fn of(recording: &Demonstration, step: usize, from: f64, to: f64) -> Self {
        let is = |frame: &&Frame| frame.time >= from && frame.time <= to;
        Self {
            step,
            source: recording.source.clone(),
            reference: recording.reference.clone(),
            frames: recording.frames.iter().filter(is).cloned().collect(),
        }
    }
}

/// The time of a step in a recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepTime {
    /// The number of the step, from 1.
    pub step: usize,
    /// The first moment, in seconds.
    pub from: f64,
    /// The last moment, in seconds.
    pub to: f64,
}

/// Reads times of steps: `1:0-2.4,2:2.4-3.1`.
///
/// ```
/// use longstep_teach::step_times;
/// assert_eq!(step_times("1:0-2.4, 3:2.4-3").unwrap()[1].from, 2.4);
/// assert!(step_times("1:3-2").unwrap_err().starts_with("`1:3-2` is no time of a step"));
/// ```
///
/// # Errors
///
/// A sentence with the first part that is no time of a step.
pub fn step_times(text: &str) -> Result<Vec<StepTime>, String> {
    let time = |part: &str| {
        let (step, times) = part.trim().split_once(':')?;
        let (from, to) = times.split_once('-')?;
        let (step, from, to): (usize, f64, f64) = (
            step.trim().parse().ok()?,
            from.trim().parse().ok()?,
            to.trim().parse().ok()?,
        );
        (step >= 1 && from.is_finite() && to.is_finite() && from < to).then_some(StepTime { step, from, to })
    };
    text.split(',')
        .map(|part| {
            time(part).ok_or_else(|| format!("`{}` is no time of a step; write STEP:FROM-TO in seconds", part.trim()))
        })
        .collect()
}

/// Cuts a recording at given times. A recording that counts since the epoch begins at 0; times since the epoch are read, too.
pub fn cut_at_times(recording: &Demonstration, times: &[StepTime]) -> Vec<Segment> {
    let segment = |time: &StepTime| {
        let is_since_epoch = recording.begins > 0.0 && time.from >= recording.begins / 2.0;
        let begins = if is_since_epoch { recording.begins } else { 0.0 };
        Segment::of(recording, time.step, time.from - begins, time.to - begins)
    };
    times.iter().map(segment).collect()
}

/// Assigns one recording to each step that is taught, or to each step of the plan, in order.
///
/// # Errors
///
/// The finding that there are more or fewer recordings.
pub fn one_each(recordings: &[Demonstration], requests: &[Request]) -> Result<Vec<Segment>, Finding> {
    let taught: Vec<usize> = taught(requests).map(Request::number).collect();
    let steps = match recordings.len() {
        count if count == taught.len() => taught,
        count if count == requests.len() => requests.iter().map(Request::number).collect(),
        count => {
            let reason = format!("{count} recordings for {} steps; give one for each step", taught.len());
            let subject = recordings.first().map_or(String::new(), |own| own.source.clone());
            return Err(unclear(subject, reason));
        }
    };
    let segments = recordings.iter().zip(steps);
    Ok(segments
        .map(|(recording, step)| Segment::whole(recording, step))
        .collect())
}

/// Cuts a recording where it says: at the column `step`, or where the hand grasps, releases and rests.
///
/// # Errors
///
/// The finding why the steps cannot be told apart.
pub fn cut(recording: &Demonstration, requests: &[Request]) -> Result<Vec<Segment>, Finding> {
    if recording.frames.iter().any(|frame| frame.step.is_some()) {
        let mut segments = cut_by_column(recording);
        if let Some(other) = segments.pop_if(|last| last.step > requests.len()) {
            let reason = format!(
                "it shows step {}, and the plan has {}; record this plan",
                other.step,
                requests.len()
            );
            return Err(unclear(recording.source.clone(), reason));
        }
        return Ok(segments);
    }
    if let [only] = &taught(requests).collect::<Vec<_>>()[..] {
        let all = Segment::of(recording, only.number(), f64::NEG_INFINITY, f64::INFINITY);
        return Ok(vec![all]);
    }
    cut_by_grip(recording, requests).map_err(|reason| {
        let advice = "give `--segments`, a column `step`, or one recording a step";
        unclear(recording.source.clone(), format!("{reason}; {advice}"))
    })
}

fn unclear(subject: String, reason: String) -> Finding {
    Finding {
        step: None,
        subject,
        problem: Problem::Unclear { reason },
    }
}

fn taught(requests: &[Request]) -> impl Iterator<Item = &Request> {
    requests.iter().filter(|request| !request.parameters.is_empty())
}

/// Cuts at the column `step`. Of a step that is shown several times, the last time counts.
fn cut_by_column(recording: &Demonstration) -> Vec<Segment> {
    let mut segments: BTreeMap<usize, Segment> = BTreeMap::new();
    let mut before = None;
    for frame in &recording.frames {
        if let Some(step) = frame.step {
            if before != Some(step) {
                segments.insert(step, Segment::of(recording, step, f64::INFINITY, f64::INFINITY));
            }
            if let Some(segment) = segments.get_mut(&step) {
                segment.frames.push(frame.clone());
            }
        }
        before = frame.step.or(before);
    }
    segments.into_values().collect()
}

/// A moment at which the hand closes or opens.
struct Grip {
    time: f64,
    closes: bool,
}

fn grips(recording: &Demonstration, hand: Hand) -> Vec<Grip> {
    let mut grips = Vec::new();
    let mut before: Option<bool> = None;
    for frame in recording.frames.iter().filter(|frame| frame.hand == hand) {
        let Some(closed) = frame.grip.map(|grip| grip > CLOSED) else {
            continue;
        };
        if before.is_some_and(|before| before != closed) {
            grips.push(Grip {
                time: frame.time,
                closes: closed,
            });
        }
        before = Some(closed);
    }
    grips
}

fn cut_by_grip(recording: &Demonstration, requests: &[Request]) -> Result<Vec<Segment>, String> {
    let hands = recording.hands();
    let mut gripping = hands.iter().map(|hand| (*hand, grips(recording, *hand)));
    let with = gripping.by_ref().filter(|(_, grips)| !grips.is_empty());
    let (hand, grips) = match &with.collect::<Vec<_>>()[..] {
        [] => return Err("the recording has no column `grip` with a grasp or a release".to_owned()),
        [_, _, ..] => return Err("both hands grasp".to_owned()),
        [(hand, own)] => (
            *hand,
            own.iter().map(|grip| (grip.time, grip.closes)).collect::<Vec<_>>(),
        ),
    };
    let anchors: Vec<(usize, bool)> = requests
        .iter()
        .enumerate()
        .filter(|(_, request)| request.closes() || request.opens())
        .map(|(index, request)| (index, request.closes()))
        .collect();
    let kinds = |closes: &[bool]| {
        closes
            .iter()
            .map(|own| if *own { "grasp" } else { "release" })
            .collect::<Vec<_>>()
            .join(", ")
    };
    let (planned, shown): (Vec<bool>, Vec<bool>) = (
        anchors.iter().map(|own| own.1).collect(),
        grips.iter().map(|own| own.1).collect(),
    );
    if planned != shown {
        return Err(format!(
            "the plan has {}, and the recording shows {}",
            kinds(&planned),
            kinds(&shown)
        ));
    }
    let (begin, end) = recording.span().ok_or("no frames")?;
    let path: Vec<&Frame> = recording.between(hand, begin, end);
    let rests = rests(&path);
    // Between two grips: the first step, its time, and the steps until the next grip.
    let (mut first, mut from) = (0, begin);
    let mut segments = Vec::new();
    let ends = anchors
        .iter()
        .zip(&grips)
        .map(|((index, closes), (time, _))| match closes {
            true => (index + 1, (time + GRIPPING).min(end)),
            false => (*index, (time - GRIPPING).max(begin)),
        });
    for (next, to) in ends.chain([(requests.len(), end)]) {
        if next == first {
            // A release follows a grasp at once.
            from = to;
            continue;
        }
        let times = moments(&rests, from, to, next - first)
            .map_err(|reason| format!("steps {} to {next}: {reason}", first + 1))?;
        for (offset, time) in times.windows(2).enumerate() {
            segments.push(Segment::of(recording, first + offset + 1, time[0], time[1]));
        }
        (first, from) = (next, to);
    }
    Ok(segments)
}

/// Returns the times at which `steps` steps begin, and the end: they part where the hand rests longest.
fn moments(rests: &[(f64, f64)], from: f64, to: f64, steps: usize) -> Result<Vec<f64>, String> {
    let inside = |(begin, end): &&(f64, f64)| *begin > from + GRIPPING && *end < to - GRIPPING;
    let mut rests: Vec<(f64, f64)> = rests.iter().filter(inside).copied().collect();
    let length = |rest: &(f64, f64)| rest.1 - rest.0;
    rests.sort_by(|one, other| length(other).total_cmp(&length(one)));
    let needed = steps - 1;
    if rests.len() < needed {
        return Err(format!(
            "the hand rests {} times between {from:.1} and {to:.1} s, and {needed} rests part them",
            rests.len()
        ));
    }
    if needed > 0
        && rests
            .get(needed)
            .is_some_and(|next| length(next) * CLEARLY > length(&rests[needed - 1]))
    {
        return Err(format!(
            "the hand rests more than {needed} times between {from:.1} and {to:.1} s"
        ));
    }
    let mut times: Vec<f64> = rests[..needed].iter().map(|(begin, end)| (begin + end) / 2.0).collect();
    times.extend([from, to]);
    times.sort_by(f64::total_cmp);
    Ok(times)
}

/// Returns the rests of a hand, from one time to another.
fn rests(path: &[&Frame]) -> Vec<(f64, f64)> {
    let mut rests: Vec<(f64, f64)> = Vec::new();
    let mut since: Option<f64> = None;
    // Both sums move on with the frame, so that a long recording takes linear time.
    let (mut low, mut high) = (0, 0);
    let mut sums = vec![Vector3::zeros()];
    for frame in path {
        sums.push(sums[sums.len() - 1] + frame.position);
    }
    for (index, frame) in path.iter().enumerate() {
        while path[low].time < frame.time - WINDOW {
            low += 1;
        }
        while high < path.len() && path[high].time <= frame.time + WINDOW {
            high += 1;
        }
        let mean = |from: usize, to: usize| (sums[to] - sums[from]) / (to - from).max(1) as f64;
        let (before, after) = (mean(low, index + 1), mean(index, high));
        let rest = (after - before).norm() / WINDOW < RESTS;
        match (rest, since) {
            (true, None) => since = Some(frame.time),
            (false, Some(begin)) => {
                if frame.time - begin >= PAUSE {
                    rests.push((begin, frame.time));
                }
                since = None;
            }
            _ => {}
        }
    }
    if let (Some(begin), Some(last)) = (since, path.last()) {
        rests.push((begin, last.time));
    }
    rests
}
