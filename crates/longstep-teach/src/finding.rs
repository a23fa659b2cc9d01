//! Findings about a demonstration, as data.

use std::fmt;

use crate::demonstration::Hand;

/// A finding about the demonstration of a step.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Finding {
    /// The number of the step, from 1; none for a finding about a whole recording.
    pub step: Option<usize>,
    /// The step with its arguments; the recording for one about a whole recording.
    pub subject: String,
    /// The finding.
    pub problem: Problem,
}

impl Finding {
    /// Returns true if the values that the finding is about are written all the same.
    pub fn is_doubt(&self) -> bool {
        matches!(
            self.problem,
            Problem::AgainstPrior { .. } | Problem::Uncertain { .. } | Problem::Chain { .. }
        )
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.step {
            Some(step) => write!(f, "step {step} `{}`: {}", self.subject, self.problem),
            None => write!(f, "{}: {}", self.subject, self.problem),
        }
    }
}

/// A problem of a demonstration.
#[derive(Debug, Clone, PartialEq)]
pub enum Problem {
    /// No recording shows the step.
    Missing,
    /// The steps of a recording cannot be told apart.
    Unclear {
        /// The reason.
        reason: String,
    },
    /// Positions are in another frame of reference.
    Reference {
        /// The frame of the recording.
        shown: String,
        /// The expected one.
        expected: String,
    },
    /// Too few frames of the hand.
    TooFew {
        /// The number of frames.
        frames: usize,
    },
    /// The step is shown with the other hand.
    WrongHand {
        /// The hand that moves.
        shown: Hand,
        /// The expected one.
        expected: Hand,
        /// The reason for the expectation.
        because: String,
    },
    /// The demonstrations of two steps are exchanged.
    Swapped {
        /// The number of the other step.
        other: usize,
    },
    /// A step does not start where the one before it ends.
    Chain {
        /// The distance in metres.
        distance: f64,
        /// The number of the step before.
        before: usize,
    },
    /// A gap in the recording.
    Gap {
        /// The time of the last frame before it.
        at: f64,
        /// Its length in seconds.
        seconds: f64,
        /// The longest gap that is allowed, in seconds.
        most: f64,
    },
    /// The hand does not close, or does not open, in a step in which it should.
    NoGrip {
        /// True if the hand should close.
        closes: bool,
    },
    /// The arc is too short for its radius.
    ShortArc {
        /// Its angle in degrees.
        degrees: f64,
        /// The least angle to show.
        least: f64,
    },
    /// The motion is too short for a direction.
    ShortMotion {
        /// Its length in metres.
        metres: f64,
        /// The least length to show.
        least: f64,
    },
    /// The motion has not the shape of the skill.
    Shape {
        /// The shape: `an arc`, `a straight line`, `a plane`.
        shape: &'static str,
        /// The root mean square distance from the best shape, in metres; none if there is none.
        deviation: Option<f64>,
    },
    /// A direction is far from the one that the domain expects.
    Against {
        /// The parameter.
        parameter: String,
        /// The angle in degrees.
        degrees: f64,
    },
    /// The axis is far from the one that the domain expects, which is not used.
    AgainstPrior {
        /// The angle in degrees.
        degrees: f64,
    },
    /// A value is uncertain.
    Uncertain {
        /// The value.
        value: &'static str,
        /// The value and its uncertainty, with the unit.
        amount: String,
        /// The advice.
        advice: &'static str,
    },
    /// The object is elsewhere than the world says.
    Elsewhere {
        /// The object.
        object: String,
        /// The distance in metres.
        distance: f64,
    },
    /// The recording lacks columns.
    Unrecorded {
        /// The parameter.
        parameter: String,
        /// The columns.
        columns: &'static str,
    },
    /// The domain does not say how a demonstration gives the parameter.
    NoFit {
        /// The parameter.
        parameter: String,
    },
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing => f.write_str("no recording shows it; show it"),
            Self::Unclear { reason } => f.write_str(reason),
            Self::Reference { shown, expected } => write!(
                f,
                "positions are in the frame `{shown}`, not in `{expected}`; transform the recording, or pass `--frame {shown}`"
            ),
            Self::TooFew { frames } => write!(f, "only {frames} frames of the hand; show at least 8, at 30 a second"),
            Self::WrongHand {
                shown,
                expected,
                because,
            } => write!(
                f,
                "shown with the {shown} hand, but {because} the {expected} one; show it with the {expected} hand"
            ),
            Self::Swapped { other } => write!(
                f,
                "this recording shows step {other}, and that of step {other} shows this one; exchange them"
            ),
            Self::Chain { distance, before } => write!(
                f,
                "the hand starts {:.0} cm from the end of step {before}; begin where step {before} ends",
                distance * 100.0
            ),
            Self::Gap { at, seconds, most } => write!(
                f,
                "no frames for {seconds:.1} s after {at:.2} s, more than {most:.2} s; show it again in full view"
            ),
            Self::NoGrip { closes: true } => f.write_str("the hand does not close; show the grasp to its end"),
            Self::NoGrip { closes: false } => f.write_str("the hand does not open; begin before the hand opens"),
            Self::ShortArc { degrees, least } => {
                write!(f, "the arc is {degrees:.0} degrees; show at least {least:.0}")
            }
            Self::ShortMotion { metres, least } => write!(
                f,
                "the hand moves {:.1} cm; show at least {:.0} cm",
                metres * 100.0,
                least * 100.0
            ),
            Self::Shape {
                shape,
                deviation: Some(deviation),
            } => write!(
                f,
                "the hand leaves {shape} by {:.1} cm; show it again, without other movements",
                deviation * 100.0
            ),
            Self::Shape { shape, deviation: None } => write!(f, "the hand does not move on {shape}; show it again"),
            Self::Against { parameter, degrees } => write!(
                f,
                "`{parameter}` is {degrees:.0} degrees from the direction that the domain expects; show it again, or correct `prior` in the domain"
            ),
            Self::AgainstPrior { degrees } => write!(
                f,
                "the axis is {degrees:.0} degrees from the one that the domain expects, which is not used; check the axis"
            ),
            Self::Uncertain { value, amount, advice } => write!(f, "the {value} is uncertain, {amount}; {advice}"),
            Self::Elsewhere { object, distance } => write!(
                f,
                "{object} is {:.0} cm from where the world says; correct the world, or show it where it is",
                distance * 100.0
            ),
            Self::Unrecorded { parameter, columns } => write!(
                f,
                "`{parameter}` needs {columns}, which the recording lacks; record them, or add the value to the skills file"
            ),
            Self::NoFit { parameter } => write!(
                f,
                "the domain does not say which `fit` gives `{parameter}`; add the value to the skills file"
            ),
        }
    }
}
