//! A step as a recording shows it: what fits work on, and what they give.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use serde_json::Value;

use crate::demonstration::{Frame, Hand};
use crate::finding::{Finding, Problem};
use crate::noise::End;
use crate::request::Request;
use crate::segment::Segment;

/// The expectations that demonstrations are compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct Expectations {
    /// The hand that demonstrates; none for any.
    pub hand: Option<Hand>,
    /// The frame of reference.
    pub reference: String,
    /// The positions of objects, by identifier, in metres.
    pub objects: BTreeMap<String, [f64; 3]>,
}

impl Default for Expectations {
    fn default() -> Self {
        Self {
            hand: None,
            reference: "world".to_owned(),
            objects: BTreeMap::new(),
        }
    }
}

/// A value of a skill parameter from a demonstration.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TaughtValue {
    /// The parameter.
    pub parameter: String,
    /// The value in the form of its type.
    pub value: Value,
    /// The standard uncertainty: of each coordinate of a position or displacement in metres, of a direction in radians. None
    /// for texts and paths.
    pub uncertainty: Option<f64>,
    /// The unit of the uncertainty.
    pub unit: Option<&'static str>,
    /// The recording, the time and the hand.
    pub source: String,
}

/// A segment of a step, with the hand that shows it.
pub(crate) struct Shown<'a> {
    pub(crate) request: &'a Request,
    pub(crate) segment: &'a Segment,
    pub(crate) hand: Hand,
    pub(crate) frames: Vec<&'a Frame>,
    pub(crate) points: Vec<Vector3<f64>>,
    pub(crate) noise: f64,
    pub(crate) first: End,
    pub(crate) last: End,
}

/// The findings about one step.
pub(crate) struct Report<'a> {
    pub(crate) request: &'a Request,
    pub(crate) findings: &'a mut Vec<Finding>,
}

impl Report<'_> {
    /// Adds a finding of the step, unless it is there: axis, centre and radius share one.
    pub(crate) fn add(&mut self, problem: Problem) {
        let finding = Finding {
            step: Some(self.request.number()),
            subject: self.request.call.clone(),
            problem,
        };
        if !self.findings.contains(&finding) {
            self.findings.push(finding);
        }
    }
}
