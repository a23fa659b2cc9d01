//! A lesson: the values that the demonstrations of a plan's steps give, with findings.

use nalgebra::Vector3;

use crate::demonstration::{Frame, Hand};
use crate::finding::{Finding, Problem};
use crate::fits::Fits;
use crate::noise::{end, noise};
use crate::request::Request;
use crate::segment::{CLOSED, Segment};
use crate::shown::{Expectations, Report, Shown, TaughtValue};

/// The fewest frames of a segment.
const FRAMES: usize = 8;
/// The longest time without a frame, in seconds; or this many times the usual time between frames.
const GAP: f64 = 0.25;
const GAP_FRAMES: f64 = 5.0;
/// A step starts at most this far from the end of the step before, in metres, plus four times the noise.
const CHAIN: f64 = 0.05;

/// The values of a step.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TaughtStep {
    /// The number of the step, from 1.
    pub step: usize,
    /// The values, in the order of the parameters.
    pub values: Vec<TaughtValue>,
}

/// The values that demonstrations give, with findings.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Lesson {
    /// The steps with values, in order.
    pub steps: Vec<TaughtStep>,
    /// The findings, in order of steps.
    pub findings: Vec<Finding>,
}

impl Lesson {
    /// Returns true if every parameter has a value.
    pub fn is_complete(&self) -> bool {
        self.findings.iter().all(Finding::is_doubt)
    }
}

/// Fits the parameters of steps to the segments that show them.
///
/// Each finding names the step, what was seen, and what to do. A value with a finding that is no doubt is left out.
pub fn learn(requests: &[Request], segments: &[Segment], expectations: &Expectations) -> Lesson {
    let mut lesson = Lesson::default();
    let shown: Vec<Option<Shown<'_>>> = requests.iter().map(|request| shown(request, segments)).collect();
    let swapped = swapped(&shown);
    let mut holding = None;
    let mut before: Option<&Shown<'_>> = None;
    for (request, own) in requests.iter().zip(&shown) {
        let mut report = Report {
            request,
            findings: &mut lesson.findings,
        };
        let Some(own) = own else {
            if !request.parameters.is_empty() {
                report.add(Problem::Missing);
            }
            before = None;
            continue;
        };
        let expected = expected_hand(request, expectations, holding);
        holding = match (request.closes(), request.opens()) {
            (true, _) => Some((own.hand, request.number())),
            (_, true) => None,
            _ => holding,
        };
        let other = swapped.and_then(|(one, other)| match request.number() {
            number if number == one => Some(other),
            number if number == other => Some(one),
            _ => None,
        });
        let chained = before.filter(|before| before.hand == own.hand);
        before = Some(own);
        if let Some(other) = other {
            report.add(Problem::Swapped { other });
            continue;
        }
        if request.parameters.is_empty() || !is_usable(own, expectations, expected, &mut report) {
            continue;
        }
        let chained = chained.filter(|before| {
            let distance = distance(before, own);
            let is_near = distance <= reach(before, own);
            if !is_near && swapped.is_none() {
                let before = before.request.number();
                report.add(Problem::Chain { distance, before });
            }
            is_near
        });
        let mut fits = Fits::new(own, chained);
        let values = request
            .parameters
            .iter()
            .filter_map(|parameter| fits.value(parameter, expectations, &mut report));
        let step = TaughtStep {
            step: request.number(),
            values: values.collect(),
        };
        lesson.steps.push(step);
    }
    lesson
}

/// Returns the segment of a step with the hand that moves farther in it; none if no recording shows it.
fn shown<'a>(request: &'a Request, segments: &'a [Segment]) -> Option<Shown<'a>> {
    let segment = segments.iter().rev().find(|segment| segment.step == request.number())?;
    let of = |hand: Hand| -> Vec<&Frame> { segment.frames.iter().filter(|frame| frame.hand == hand).collect() };
    let hands = [Hand::Left, Hand::Right].map(|hand| (hand, of(hand)));
    let (hand, frames) = hands
        .into_iter()
        .filter(|(_, frames)| !frames.is_empty())
        .max_by(|(_, one), (_, other)| extent(one).total_cmp(&extent(other)))?;
    let points: Vec<Vector3<f64>> = frames.iter().map(|frame| frame.position).collect();
    let noise = noise(&points).max(1e-4);
    Some(Shown {
        request,
        segment,
        hand,
        first: end(points.iter(), noise)?,
        last: end(points.iter().rev(), noise)?,
        frames,
        points,
        noise,
    })
}

/// The largest distance of a hand from its first position, plus a millimetre for each change of its grip.
fn extent(frames: &[&Frame]) -> f64 {
    let Some(first) = frames.first() else { return 0.0 };
    let way = frames
        .iter()
        .map(|frame| (frame.position - first.position).norm())
        .fold(0.0, f64::max);
    let closed = |frame: &&&Frame| frame.grip.is_some_and(|grip| grip > CLOSED);
    let grips = frames
        .windows(2)
        .filter(|pair| closed(&&pair[0]) != closed(&&pair[1]))
        .count();
    // A hand that grips acts, however little it moves.
    way + grips as f64
}

/// Returns the expected hand with the reason.
fn expected_hand(
    request: &Request,
    expectations: &Expectations,
    holding: Option<(Hand, usize)>,
) -> Option<(Hand, String)> {
    let of_plan = request.hand.map(|hand| (hand, "the plan uses".to_owned()));
    let of_person = expectations
        .hand
        .map(|hand| (hand, "the demonstration is with".to_owned()));
    let of_grasp = holding.map(|(hand, step)| (hand, format!("step {step} grasped with")));
    of_plan.or(of_person).or(of_grasp)
}

/// Reports why a segment cannot be fitted at all.
fn is_usable(
    own: &Shown<'_>,
    expectations: &Expectations,
    expected: Option<(Hand, String)>,
    report: &mut Report<'_>,
) -> bool {
    let reference = own.segment.reference.as_ref();
    if let Some(shown) = reference.filter(|shown| **shown != expectations.reference) {
        let (shown, expected) = (shown.clone(), expectations.reference.clone());
        report.add(Problem::Reference { shown, expected });
        return false;
    }
    if let Some((expected, because)) = expected.filter(|(expected, _)| *expected != own.hand) {
        let shown = own.hand;
        report.add(Problem::WrongHand {
            shown,
            expected,
            because,
        });
        return false;
    }
    if own.frames.len() < FRAMES {
        report.add(Problem::TooFew {
            frames: own.frames.len(),
        });
        return false;
    }
    let (gap, most) = gap(&own.frames);
    if let Some((at, seconds)) = gap {
        report.add(Problem::Gap { at, seconds, most });
        return false;
    }
    let grips: Vec<bool> = own
        .frames
        .iter()
        .filter_map(|frame| frame.grip)
        .map(|grip| grip > CLOSED)
        .collect();
    let (Some(first), Some(last)) = (grips.first(), grips.last()) else {
        return true;
    };
    if own.request.closes() && !last {
        report.add(Problem::NoGrip { closes: true });
        return false;
    }
    if own.request.opens() && (!first || *last) {
        report.add(Problem::NoGrip { closes: false });
        return false;
    }
    true
}

/// Returns the first gap as its begin and its length; and the longest time that is no gap.
fn gap(frames: &[&Frame]) -> (Option<(f64, f64)>, f64) {
    let mut steps: Vec<f64> = frames.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
    let found = steps.clone();
    steps.sort_by(f64::total_cmp);
    let most = (GAP_FRAMES * steps.get(steps.len() / 2).copied().unwrap_or(0.0)).max(GAP);
    let place = found.iter().position(|step| *step > most);
    (place.map(|place| (frames[place].time, found[place])), most)
}

/// The distance between the end of a step and the start of the next.
fn distance(before: &Shown<'_>, own: &Shown<'_>) -> f64 {
    (own.first.position - before.last.position).norm()
}

fn reach(before: &Shown<'_>, own: &Shown<'_>) -> f64 {
    CHAIN + 4.0 * before.noise.max(own.noise)
}

/// Returns the two steps whose segments are exchanged: the chain of steps is broken, and whole if they are exchanged back.
fn swapped(shown: &[Option<Shown<'_>>]) -> Option<(usize, usize)> {
    /// The most steps for which exchanges are tried.
    const STEPS: usize = 60;
    let breaks = |order: &[usize]| {
        let broken = |pair: &[usize]| match (&shown[pair[0]], &shown[pair[1]]) {
            (Some(one), Some(other)) if one.hand == other.hand => distance(one, other) > reach(one, other),
            _ => false,
        };
        order.windows(2).filter(|pair| broken(pair)).count()
    };
    let mut order: Vec<usize> = (0..shown.len()).collect();
    if order.len() > STEPS || breaks(&order) == 0 {
        return None;
    }
    let mut found = None;
    for one in 0..order.len() {
        for other in one + 1..order.len() {
            if shown[one].is_none() || shown[other].is_none() {
                continue;
            }
            order.swap(one, other);
            if breaks(&order) == 0 && found.replace((one + 1, other + 1)).is_some() {
                return None;
            }
            order.swap(one, other);
        }
    }
    found
}
