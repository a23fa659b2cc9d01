//! The arc of a hand: axis, centre and radius by geometric least squares.
//!
//! An algebraic fit minimises a polynomial and shrinks on short arcs: for 45 degrees of a circle of 0.4 m with 5 mm of
//! noise it finds 0.32 m. So it is only the start of a fit of the distances themselves.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use crate::noise;

/// The standard deviation of an axis around its prior, in radians: 5 degrees.
const PRIOR_SPREAD: f64 = 0.087;
/// A larger circle is a straight line, in metres.
const LARGEST: f64 = 10.0;
/// A smaller circle is a hand that turns in place, in metres.
const SMALLEST: f64 = 0.005;
/// The most iterations of the fit.
const ITERATIONS: usize = 100;

/// An arc with standard uncertainties.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Arc {
    /// The axis of rotation, of length 1. The hand turns around it as a right-handed screw by `angle`.
    pub axis: Vector3<f64>,
    /// The standard uncertainty of the axis, in radians.
    pub axis_uncertainty: f64,
    /// The centre: the point of the axis in the plane of the arc.
    pub centre: Vector3<f64>,
    /// The standard uncertainty of each coordinate of the centre, in metres.
    pub centre_uncertainty: f64,
    /// The radius in metres.
    pub radius: f64,
    /// The standard uncertainty of the radius, in metres.
    pub radius_uncertainty: f64,
    /// The angle from the first to the last point, in radians; negative against the axis.
    pub angle: f64,
    /// The standard uncertainty of the angle, in radians.
    pub angle_uncertainty: f64,
    /// The largest angle between two points, in radians.
    pub extent: f64,
    /// The root mean square distance of the points from the arc, in metres.
    pub deviation: f64,
    /// The angle between the prior axis and the axis without it, in radians, if the two contradict each other. The prior
    /// is not used then.
    pub against_prior: Option<f64>,
}

/// Fits an arc to points in their order. `prior` is a direction that the axis is expected to have or to oppose; it has
/// the weight of an observation with 5 degrees of uncertainty. The axis points along it; without one, it points so that the
/// angle is positive.
///
/// Returns none for fewer than 8 points, and for points on a straight line or in one place.
///
/// ```
/// use longstep_teach::fit_arc;
/// use nalgebra::Vector3;
/// let turn = |part: i32| (f64::from(part) * 0.02).sin_cos();
/// let points: Vec<_> = (0..60).map(|part| Vector3::new(turn(part).1, turn(part).0, 0.5) * 0.4).collect();
/// let arc = fit_arc(&points, None).unwrap();
/// assert!((arc.radius - 0.4).abs() < 1e-6 && (arc.axis - Vector3::z()).norm() < 1e-6);
/// assert!((arc.angle - 59.0 * 0.02).abs() < 1e-6);
/// ```
pub fn fit_arc(points: &[Vector3<f64>], prior: Option<Vector3<f64>>) -> Option<Arc> {
    if points.len() < 8 {
        return None;
    }
    let prior = prior.and_then(|prior| prior.try_normalize(1e-9));
    let free = fit(points, None);
    let (circle, against_prior) = match (prior, free) {
        (None, free) => (free?, None),
        (Some(prior), None) => (fit(points, Some(prior))?, None),
        (Some(prior), Some(free)) => {
            let between = free.axis.dot(&prior).abs().min(1.0).acos();
            let spread = (free.variance(3) + free.variance(4) + PRIOR_SPREAD * PRIOR_SPREAD).sqrt();
            if between > 3.0 * spread {
                (free, Some(between))
            } else {
                // A free fit of a short arc can be far off; then the prior is the better start.
                (fit(points, Some(prior)).unwrap_or(free), None)
            }
        }
    };
    Some(circle.oriented(points, prior, against_prior))
}

/// A circle in space with the covariance of centre (0 to 2), axis (3, 4: two rotations) and radius (5).
#[derive(Debug, Clone)]
struct Circle {
    centre: Vector3<f64>,
    axis: Vector3<f64>,
    radius: f64,
    covariance: Matrix6<f64>,
    deviation: f64,
}

impl Circle {
    fn variance(&self, index: usize) -> f64 {
        self.covariance[(index, index)].max(0.0)
    }

    /// Adds the direction of the turn.
    fn oriented(mut self, points: &[Vector3<f64>], prior: Option<Vector3<f64>>, against_prior: Option<f64>) -> Arc {
        let angles = self.angles(points);
        let (first, end) = (
            noise::end(points.iter(), self.deviation),
            noise::end(points.iter().rev(), self.deviation),
        );
        let frames = |end: &Option<noise::End>| end.as_ref().map_or(1, |end| end.frames);
        let mean = |angles: &[f64]| angles.iter().sum::<f64>() / angles.len().max(1) as f64;
        let last = mean(&angles[angles.len() - frames(&end)..]) - mean(&angles[..frames(&first)]);
        let backward = match prior.filter(|_| against_prior.is_none()) {
            Some(prior) => self.axis.dot(&prior) < 0.0,
            None => last < 0.0,
        };
        let sign = if backward { -1.0 } else { 1.0 };
        self.axis *= sign;
        let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
        let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let radius_uncertainty = self.variance(5).sqrt();
        let uncertainty = |end: Option<noise::End>| end.map_or(self.deviation, |end| end.uncertainty);
        let ends = uncertainty(first).hypot(uncertainty(end)) / self.radius;
        let scale = last * radius_uncertainty / self.radius;
        Arc {
            axis: self.axis,
            axis_uncertainty: (self.variance(3) + self.variance(4)).sqrt(),
            centre: self.centre,
            centre_uncertainty: ((self.variance(0) + self.variance(1) + self.variance(2)) / 3.0).sqrt(),
            radius: self.radius,
            radius_uncertainty,
            angle: last * sign,
            angle_uncertainty: ends.hypot(scale),
            extent: high - low,
            deviation: self.deviation,
            against_prior,
        }
    }

    /// The angles of the points around the axis, from that of the first one, counted on over full turns.
    fn angles(&self, points: &[Vector3<f64>]) -> Vec<f64> {
        let (one, other) = across(self.axis);
        let (mut angles, mut turned, mut before) = (Vec::with_capacity(points.len()), 0.0, None);
        for point in points {
            let from = point - self.centre;
            let now = from.dot(&other).atan2(from.dot(&one));
            if let Some(before) = before {
                let step: f64 = now - before;
                turned += step - std::f64::consts::TAU * (step / std::f64::consts::TAU).round();
            }
            before = Some(now);
            angles.push(turned);
        }
        angles
    }
}

/// Two directions that form a right-handed frame with the axis.
pub(crate) fn across(axis: Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let thinnest = axis.iamin();
    let one = axis.cross(&Vector3::ith(thinnest, 1.0)).normalize();
    (one, axis.cross(&one))
}

fn fit(points: &[Vector3<f64>], prior: Option<Vector3<f64>>) -> Option<Circle> {
    let start = algebraic(points, prior)?;
    // The weight of the prior depends on the noise, which the first fit finds.
    let noise = cost(points, &start, None).0.sqrt().max(1e-4);
    let (circle, _) = refined(points, start, prior.map(|prior| (prior, noise / PRIOR_SPREAD)))?;
    let noise = circle.deviation.max(1e-6);
    let (circle, is_settled) = refined(points, circle, prior.map(|prior| (prior, noise / PRIOR_SPREAD)))?;
    let is_arc = is_settled && (SMALLEST..LARGEST).contains(&circle.radius);
    is_arc.then_some(circle)
}

/// The start of the fit: the plane of the points, or across the prior, and an algebraic circle in it.
fn algebraic(points: &[Vector3<f64>], prior: Option<Vector3<f64>>) -> Option<Circle> {
    let count = points.len() as f64;
    let middle = points.iter().sum::<Vector3<f64>>() / count;
    let axis = match prior {
        Some(prior) => prior,
        None => {
            let scatter: Matrix3<f64> = points
                .iter()
                .map(|point| (point - middle) * (point - middle).transpose())
                .sum();
            let eigen = scatter.symmetric_eigen();
            eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned()
        }
    };
    let (one, other) = across(axis);
    let flat = |point: &Vector3<f64>| {
        let from = point - middle;
        (from.dot(&one), from.dot(&other))
    };
    // x² + y² = a x + b y + c
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for point in points {
        let (x, y) = flat(point);
        let row = Vector3::new(x, y, 1.0);
        normal += row * row.transpose();
        right += row * (x * x + y * y);
    }
    let solution = normal.cholesky()?.solve(&right);
    let (x, y) = (solution.x / 2.0, solution.y / 2.0);
    let radius = (solution.z + x * x + y * y).sqrt();
    radius.is_finite().then(|| Circle {
        centre: middle + one * x + other * y,
        axis,
        radius: radius.min(LARGEST),
        covariance: Matrix6::zeros(),
        deviation: 0.0,
    })
}

/// A prior axis with the weight of its two residuals.
type Weighted = (Vector3<f64>, f64);

/// Returns the mean square distance of the points, and the cost: the sum of squares with that of the prior.
fn cost(points: &[Vector3<f64>], circle: &Circle, prior: Option<Weighted>) -> (f64, f64) {
    let square = |point: &Vector3<f64>| {
        let from = point - circle.centre;
        let height = from.dot(&circle.axis);
        let out = (from - circle.axis * height).norm() - circle.radius;
        height * height + out * out
    };
    let sum: f64 = points.iter().map(square).sum();
    let tilt = prior.map_or(0.0, |(prior, weight)| {
        weight * weight * (1.0 - circle.axis.dot(&prior).powi(2)).max(0.0)
    });
    (sum / points.len() as f64, sum + tilt)
}

/// Improves a circle by the method of Levenberg and Marquardt. Returns it with true if it settled.
fn refined(points: &[Vector3<f64>], mut circle: Circle, prior: Option<Weighted>) -> Option<(Circle, bool)> {
    let mut best = cost(points, &circle, prior).1;
    let (mut damping, mut is_settled) = (1e-3, false);
    for _ in 0..ITERATIONS {
        let (normal, gradient) = linearised(points, &circle, prior);
        let mut damped = normal;
        for index in 0..6 {
            damped[(index, index)] += damping * normal[(index, index)].max(1e-12);
        }
        let Some(step) = damped.cholesky().map(|factor| factor.solve(&-gradient)) else {
            damping *= 10.0;
            continue;
        };
        let next = circle.moved(&step)?;
        let now = cost(points, &next, prior).1;
        if now <= best {
            is_settled = best - now <= 1e-10 * best.max(1e-18);
            (circle, best) = (next, now);
            damping = (damping / 10.0).max(1e-12);
        } else {
            is_settled = step.norm() < 1e-9;
            damping *= 10.0;
        }
        if is_settled || damping > 1e12 {
            is_settled = true;
            break;
        }
    }
    circle.finish(points, prior)?;
    Some((circle, is_settled))
}

impl Circle {
    fn moved(&self, step: &Vector6<f64>) -> Option<Self> {
        let (one, other) = across(self.axis);
        let axis = (self.axis + one * step[3] + other * step[4]).try_normalize(1e-9)?;
        let radius = self.radius + step[5];
        (radius.is_finite() && radius > 0.0 && radius < 100.0 * LARGEST).then(|| Self {
            centre: self.centre + step.fixed_rows::<3>(0),
            axis,
            radius,
            covariance: Matrix6::zeros(),
            deviation: 0.0,
        })
    }

    /// Sets the deviation and the covariance.
    fn finish(&mut self, points: &[Vector3<f64>], prior: Option<Weighted>) -> Option<()> {
        let (normal, _) = linearised(points, self, prior);
        let mean = cost(points, self, None).0;
        let (height, out) = residuals(points, self).into_iter().unzip::<f64, f64, Vec<_>, Vec<_>>();
        // A tracker's errors hang together from frame to frame, so that frames count less than their number.
        let inflation = noise::inflation(&height).max(noise::inflation(&out));
        let freedom = (2 * points.len()) as f64 - 6.0;
        let variance = mean * points.len() as f64 / freedom;
        self.deviation = variance.sqrt();
        self.covariance = normal.try_inverse()? * variance * inflation;
        Some(())
    }
}

fn residuals(points: &[Vector3<f64>], circle: &Circle) -> Vec<(f64, f64)> {
    let of = |point: &Vector3<f64>| {
        let from = point - circle.centre;
        let height = from.dot(&circle.axis);
        (height, (from - circle.axis * height).norm() - circle.radius)
    };
    points.iter().map(of).collect()
}

/// Returns the matrix of the normal equations and the gradient.
fn linearised(points: &[Vector3<f64>], circle: &Circle, prior: Option<Weighted>) -> (Matrix6<f64>, Vector6<f64>) {
    let (one, other) = across(circle.axis);
    let (mut normal, mut gradient) = (Matrix6::zeros(), Vector6::zeros());
    let mut add = |row: Vector6<f64>, residual: f64| {
        normal += row * row.transpose();
        gradient += row * residual;
    };
    for point in points {
        let from = point - circle.centre;
        let height = from.dot(&circle.axis);
        let flat = from - circle.axis * height;
        let distance = flat.norm().max(1e-9);
        let out = flat / distance;
        let axis = circle.axis;
        add(
            Vector6::new(-axis.x, -axis.y, -axis.z, from.dot(&one), from.dot(&other), 0.0),
            height,
        );
        add(
            Vector6::new(
                -out.x,
                -out.y,
                -out.z,
                -height * out.dot(&one),
                -height * out.dot(&other),
                -1.0,
            ),
            distance - circle.radius,
        );
    }
    if let Some((prior, weight)) = prior {
        let (first, second) = across(prior);
        for direction in [first, second] {
            add(
                Vector6::new(
                    0.0,
                    0.0,
                    0.0,
                    weight * one.dot(&direction),
                    weight * other.dot(&direction),
                    0.0,
                ),
                weight * circle.axis.dot(&direction),
            );
        }
    }
    (normal, gradient)
}
