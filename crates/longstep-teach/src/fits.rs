//! The values of one step: each parameter from the segment that shows it.

use std::collections::BTreeMap;

use longstep_model::model::{SkillFit, SkillParameter};
use nalgebra::Vector3;
use serde_json::{Value, json};

use crate::circle::{Arc, fit_arc};
use crate::demonstration::Frame;
use crate::finding::Problem;
use crate::line::{Line, fit_line};
use crate::plane::{Plane, fit_plane};
use crate::posture::posture;
use crate::segment::CLOSED;
use crate::shown::{Expectations, Report, Shown, TaughtValue};

/// An arc that is shorter, in degrees, and whose radius is more uncertain than this share is too short.
const ARC: f64 = 45.0;
const ARC_RADIUS: f64 = 0.05;
/// The share of the radius, and the angle of a direction in radians, above which a value is uncertain.
const UNCERTAIN_RADIUS: f64 = 0.15;
const UNCERTAIN_DIRECTION: f64 = 0.175;
/// The least length of a motion with a direction, in metres.
const MOTION: f64 = 0.03;
/// The length of an approach and of a retreat, in metres.
const APPROACH: f64 = 0.1;
/// The farthest that a hand leaves the shape of its skill, in metres, plus twice the noise.
const SHAPE: f64 = 0.03;
/// The farthest that a direction is from the expected one, in degrees.
const AGAINST: f64 = 60.0;
/// The farthest that an object is from where the world says, in metres.
const ELSEWHERE: f64 = 0.1;
/// The most points of a path.
const POINTS: usize = 10_000;

/// The shapes of a segment, each fitted once.
pub(crate) struct Fits<'a> {
    shown: &'a Shown<'a>,
    /// The end of the step before, where this one starts.
    start: Option<&'a Shown<'a>>,
    arc: Option<Result<Arc, Problem>>,
    line: Option<Result<Line, Problem>>,
}

impl<'a> Fits<'a> {
    pub(crate) fn new(shown: &'a Shown<'a>, start: Option<&'a Shown<'a>>) -> Self {
        Self {
            shown,
            start,
            arc: None,
            line: None,
        }
    }

    /// Returns the value of a parameter, or reports why there is none.
    pub(crate) fn value(
        &mut self,
        parameter: &SkillParameter,
        expectations: &Expectations,
        report: &mut Report<'_>,
    ) -> Option<TaughtValue> {
        let name = || parameter.name.clone();
        let Some(fit) = parameter.fit else {
            report.add(Problem::NoFit { parameter: name() });
            return None;
        };
        let unrecorded = |columns: &'static str| Problem::Unrecorded {
            parameter: parameter.name.clone(),
            columns,
        };
        let prior = parameter.prior.map(Vector3::from);
        let found: Result<Fitted, Problem> = match fit {
            SkillFit::FirstPosition => Ok(self.first_position()),
            SkillFit::LastPosition => {
                let last = &self.shown.last;
                Ok(Fitted::point(last.position, last.uncertainty))
            }
            SkillFit::Path => Ok(Fitted::path(&self.shown.points)),
            SkillFit::ObjectPosition => self.object_position(expectations),
            SkillFit::Hand => Ok(Fitted::text(self.shown.hand.name())),
            SkillFit::Grasp => self
                .grasp()
                .map(Fitted::text)
                .ok_or_else(|| unrecorded("a column `grasp`")),
            SkillFit::Approach => self.approach().and_then(|line| direction_of(&line)),
            SkillFit::Retreat => self.retreat().and_then(|line| direction_of(&line)),
            SkillFit::Displacement => self
                .line()
                .map(|line| Fitted::point(line.displacement(), line.displacement_uncertainty)),
            SkillFit::Axis | SkillFit::Centre | SkillFit::Radius | SkillFit::Angle => {
                self.arc(report).map(|arc| of_arc(fit, &arc))
            }
            SkillFit::Normal => self
                .plane(prior, report)
                .map(|plane| Fitted::direction(plane.normal, plane.normal_uncertainty)),
            SkillFit::UpperArmFirst => self
                .arm(true, true)
                .ok_or_else(|| unrecorded("columns of elbow and shoulder")),
            SkillFit::UpperArmLast => self
                .arm(true, false)
                .ok_or_else(|| unrecorded("columns of elbow and shoulder")),
            SkillFit::LowerArmFirst => self.arm(false, true).ok_or_else(|| unrecorded("columns of the elbow")),
            SkillFit::LowerArmLast => self.arm(false, false).ok_or_else(|| unrecorded("columns of the elbow")),
        };
        let against = |fitted: &Fitted| {
            // The prior of an axis was weighed with the arc.
            let prior = prior.filter(|_| fit != SkillFit::Axis)?;
            let degrees = fitted.vector?.angle(&prior).to_degrees();
            (degrees > AGAINST).then(|| Problem::Against {
                parameter: name(),
                degrees,
            })
        };
        match found.and_then(|fitted| against(&fitted).map_or(Ok(fitted), Err)) {
            Ok(fitted) => Some(TaughtValue {
                parameter: name(),
                value: fitted.value,
                uncertainty: fitted.uncertainty.map(rounded),
                unit: fitted.unit,
                source: self.source(),
            }),
            Err(problem) => {
                report.add(problem);
                None
            }
        }
    }

    fn source(&self) -> String {
        let (first, last) = (
            self.shown.frames[0].time,
            self.shown.frames[self.shown.frames.len() - 1].time,
        );
        format!(
            "{}, {first:.2} to {last:.2} s, {} hand",
            self.shown.segment.source, self.shown.hand
        )
    }

    /// The first position. A step starts where the one before it ends, so both are seen twice.
    fn first_position(&self) -> Fitted {
        let own = &self.shown.first;
        match self.start.map(|start| &start.last) {
            Some(end) => Fitted::point(
                (own.position + end.position) / 2.0,
                own.uncertainty.hypot(end.uncertainty) / 2.0,
            ),
            None => Fitted::point(own.position, own.uncertainty),
        }
    }

    /// The moment at which the hand closes, or opens: the place in the frames.
    fn grip(&self, closes: bool) -> Option<usize> {
        let closed = |frame: &&Frame| frame.grip.map(|grip| grip > CLOSED);
        let frames = &self.shown.frames;
        (1..frames.len())
            .find(|place| closed(&frames[place - 1]) == Some(!closes) && closed(&frames[*place]) == Some(closes))
    }

    fn object_position(&self, expectations: &Expectations) -> Result<Fitted, Problem> {
        let shown = self.shown;
        let seen: Vec<Vector3<f64>> = shown.frames.iter().filter_map(|frame| frame.object).collect();
        let position = match seen.len() {
            // Without a recogniser of objects, the object is where the hand closes.
            0 => Fitted::point(
                shown.points[self.grip(true).unwrap_or(shown.points.len() - 1)],
                shown.noise,
            ),
            count => {
                let mean = seen.iter().sum::<Vector3<f64>>() / count as f64;
                let square: f64 = seen.iter().map(|point| (point - mean).norm_squared()).sum();
                Fitted::point(mean, (square / 3.0).sqrt() / count as f64)
            }
        };
        let expected = shown
            .request
            .object
            .as_ref()
            .and_then(|object| Some((object, expectations.objects.get(object)?)));
        if let (Some((object, expected)), Some(found)) = (expected, position.vector) {
            let distance = (found - Vector3::from(*expected)).norm();
            if distance > ELSEWHERE {
                return Err(Problem::Elsewhere {
                    object: object.clone(),
                    distance,
                });
            }
        }
        Ok(position)
    }

    /// The kind of grasp that most frames name.
    fn grasp(&self) -> Option<&str> {
        let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
        for name in self.shown.frames.iter().filter_map(|frame| frame.grasp.as_deref()) {
            *counts.entry(name).or_default() += 1;
        }
        counts.into_iter().max_by_key(|(_, count)| *count).map(|(name, _)| name)
    }

    fn approach(&self) -> Result<Line, Problem> {
        let points = &self.shown.points;
        let end = self.grip(true).unwrap_or(points.len() - 1);
        let far = |place: &usize| (points[*place] - points[end]).norm() > APPROACH;
        let begin = (0..end).rev().find(far).unwrap_or(0);
        straight(&points[begin..=end], self.shown.noise)
    }

    fn retreat(&self) -> Result<Line, Problem> {
        let points = &self.shown.points;
        let begin = self.grip(false).unwrap_or(0);
        let far = |place: &usize| (points[*place] - points[begin]).norm() > APPROACH;
        let end = (begin..points.len()).find(far).unwrap_or(points.len() - 1);
        straight(&points[begin..=end], self.shown.noise)
    }

    fn line(&mut self) -> Result<Line, Problem> {
        let fit = || straight(&self.shown.points, self.shown.noise);
        self.line.get_or_insert_with(fit).clone()
    }

    fn arc(&mut self, report: &mut Report<'_>) -> Result<Arc, Problem> {
        if self.arc.is_none() {
            self.arc = Some(self.fit_arc(report));
        }
        self.arc.clone().unwrap_or(Err(Problem::Missing))
    }

    fn fit_arc(&self, report: &mut Report<'_>) -> Result<Arc, Problem> {
        let parameters = &self.shown.request.parameters;
        let prior = parameters
            .iter()
            .find(|own| own.fit == Some(SkillFit::Axis))
            .and_then(|own| own.prior);
        let shape = |deviation| Problem::Shape {
            shape: "an arc",
            deviation,
        };
        let arc = fit_arc(&self.shown.points, prior.map(Vector3::from)).ok_or(shape(None))?;
        if arc.deviation > SHAPE + 2.0 * self.shown.noise {
            return Err(shape(Some(arc.deviation)));
        }
        let (degrees, share) = (arc.extent.to_degrees(), arc.radius_uncertainty / arc.radius);
        if degrees < ARC && share > ARC_RADIUS {
            return Err(Problem::ShortArc { degrees, least: ARC });
        }
        if share > UNCERTAIN_RADIUS {
            report.add(Problem::Uncertain {
                value: "radius",
                amount: format!("{:.2} ± {:.2} m", arc.radius, arc.radius_uncertainty),
                advice: "show a longer arc",
            });
        }
        if let Some(between) = arc.against_prior {
            report.add(Problem::AgainstPrior {
                degrees: between.to_degrees(),
            });
        }
        Ok(arc)
    }

    fn plane(&self, prior: Option<Vector3<f64>>, report: &mut Report<'_>) -> Result<Plane, Problem> {
        let shape = |deviation| Problem::Shape {
            shape: "a plane",
            deviation,
        };
        let plane = fit_plane(&self.shown.points, prior).ok_or(shape(None))?;
        if plane.area.0 < MOTION + 4.0 * self.shown.noise {
            return Err(Problem::ShortMotion {
                metres: plane.area.0,
                least: MOTION,
            });
        }
        if plane.deviation > SHAPE + 2.0 * self.shown.noise {
            return Err(shape(Some(plane.deviation)));
        }
        if plane.normal_uncertainty > UNCERTAIN_DIRECTION {
            report.add(Problem::Uncertain {
                value: "normal",
                amount: format!(
                    "± {:.0} degrees from an area of {:.0} by {:.0} cm",
                    plane.normal_uncertainty.to_degrees(),
                    plane.area.0 * 100.0,
                    plane.area.1 * 100.0
                ),
                advice: "wipe in two directions",
            });
        }
        Ok(plane)
    }

    /// The direction of a part of the arm at the first or the last frame.
    fn arm(&self, upper: bool, first: bool) -> Option<Fitted> {
        let part = |frame: &&Frame| {
            if upper {
                Some(frame.elbow? - frame.shoulder?)
            } else {
                Some(frame.position - frame.elbow?)
            }
        };
        let frames = &self.shown.frames;
        let vector = if first {
            frames.first().and_then(part)
        } else {
            frames.last().and_then(part)
        };
        posture(vector?).map(|(name, _)| Fitted::text(&name))
    }
}

fn straight(points: &[Vector3<f64>], noise: f64) -> Result<Line, Problem> {
    let way = match (points.first(), points.last()) {
        (Some(first), Some(last)) => (last - first).norm(),
        _ => 0.0,
    };
    let short = Problem::ShortMotion {
        metres: way,
        least: MOTION,
    };
    let line = fit_line(points).ok_or(short.clone())?;
    if line.length < MOTION {
        return Err(short);
    }
    if line.deviation > SHAPE + 2.0 * noise {
        Err(Problem::Shape {
            shape: "a straight line",
            deviation: Some(line.deviation),
        })
    } else {
        Ok(line)
    }
}

fn direction_of(line: &Line) -> Result<Fitted, Problem> {
    Ok(Fitted::direction(line.direction, line.direction_uncertainty))
}

fn of_arc(fit: SkillFit, arc: &Arc) -> Fitted {
    match fit {
        SkillFit::Axis => Fitted::direction(arc.axis, arc.axis_uncertainty),
        SkillFit::Centre => Fitted::point(arc.centre, arc.centre_uncertainty),
        SkillFit::Radius => Fitted::number(arc.radius, arc.radius_uncertainty, "m"),
        _ => Fitted::number(arc.angle, arc.angle_uncertainty, "rad"),
    }
}

/// A fitted value.
struct Fitted {
    value: Value,
    /// The position, displacement or direction.
    vector: Option<Vector3<f64>>,
    uncertainty: Option<f64>,
    unit: Option<&'static str>,
}

impl Fitted {
    fn point(point: Vector3<f64>, uncertainty: f64) -> Self {
        Self {
            value: coordinates(&point),
            vector: Some(point),
            uncertainty: Some(uncertainty),
            unit: Some("m"),
        }
    }

    fn direction(direction: Vector3<f64>, uncertainty: f64) -> Self {
        Self {
            unit: Some("rad"),
            ..Self::point(direction, uncertainty)
        }
    }

    fn number(value: f64, uncertainty: f64, unit: &'static str) -> Self {
        Self {
            value: json!(rounded(value)),
            vector: None,
            uncertainty: Some(uncertainty),
            unit: Some(unit),
        }
    }

    fn text(text: &str) -> Self {
        Self {
            value: json!(text),
            vector: None,
            uncertainty: None,
            unit: None,
        }
    }

    /// The positions; of a long path every second one, every third one, and so on, with the last.
    fn path(points: &[Vector3<f64>]) -> Self {
        let each = points.len().div_ceil(POINTS - 1).max(1);
        let mut kept: Vec<Value> = points.iter().step_by(each).map(coordinates).collect();
        if let Some(last) = points.last().filter(|_| !(points.len() - 1).is_multiple_of(each)) {
            kept.push(coordinates(last));
        }
        Self {
            value: Value::Array(kept),
            vector: None,
            uncertainty: None,
            unit: None,
        }
    }
}

fn coordinates(point: &Vector3<f64>) -> Value {
    json!([rounded(point.x), rounded(point.y), rounded(point.z)])
}

/// Six decimals: micrometres, which no demonstration shows.
fn rounded(value: f64) -> f64 {
    let rounded = (value * 1e6).round() / 1e6;
    // No negative zero in a file for people.
    rounded + 0.0
}
