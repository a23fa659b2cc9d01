//! The straight motion of a hand: displacement, approach and retreat.

use nalgebra::{Matrix3, Vector3};

use crate::noise;

/// A straight motion with standard uncertainties.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Line {
    /// The direction from the first to the last point, of length 1.
    pub direction: Vector3<f64>,
    /// The standard uncertainty of the direction, in radians.
    pub direction_uncertainty: f64,
    /// The way from the first to the last point along the direction, in metres.
    pub length: f64,
    /// The standard uncertainty of each coordinate of the displacement, in metres.
    pub displacement_uncertainty: f64,
    /// The root mean square distance of the points from the line, in metres.
    pub deviation: f64,
}

impl Line {
    /// The displacement from the first to the last point.
    pub fn displacement(&self) -> Vector3<f64> {
        self.direction * self.length
    }
}

/// Fits a straight line to points in their order by the least squares of their distances. Returns none for fewer than 5
/// points, and for points in one place.
///
/// ```
/// use longstep_teach::fit_line;
/// use nalgebra::Vector3;
/// let points: Vec<_> = (0..=30).map(|part| Vector3::new(0.0, f64::from(part) * -0.01, 0.4)).collect();
/// let line = fit_line(&points).unwrap();
/// assert!((line.displacement() - Vector3::new(0.0, -0.3, 0.0)).norm() < 1e-9);
/// ```
pub fn fit_line(points: &[Vector3<f64>]) -> Option<Line> {
    if points.len() < 5 {
        return None;
    }
    let count = points.len() as f64;
    let middle = points.iter().sum::<Vector3<f64>>() / count;
    let scatter: Matrix3<f64> = points
        .iter()
        .map(|point| (point - middle) * (point - middle).transpose())
        .sum();
    let eigen = scatter.symmetric_eigen();
    let along = eigen.eigenvalues.imax();
    let spread = eigen.eigenvalues[along];
    if spread <= 1e-12 {
        return None;
    }
    let way = points[points.len() - 1] - points[0];
    let mut direction: Vector3<f64> = eigen.eigenvectors.column(along).into_owned();
    if direction.dot(&way) < 0.0 {
        direction = -direction;
    }
    let off = |point: &Vector3<f64>| (point - middle) - direction * (point - middle).dot(&direction);
    let square: f64 = points.iter().map(|point| off(point).norm_squared()).sum();
    let variance = square / (2.0 * count - 4.0);
    let (one, other) = crate::circle::across(direction);
    let side = |across: Vector3<f64>| points.iter().map(|point| off(point).dot(&across)).collect::<Vec<_>>();
    let inflation = noise::inflation(&side(one)).max(noise::inflation(&side(other)));
    let direction_variance = 2.0 * variance * inflation / spread;
    let (first, last) = (
        noise::end(points.iter(), variance.sqrt())?,
        noise::end(points.iter().rev(), variance.sqrt())?,
    );
    let length = (last.position - first.position).dot(&direction);
    let ends = first.uncertainty.powi(2) + last.uncertainty.powi(2);
    Some(Line {
        direction,
        direction_uncertainty: direction_variance.sqrt(),
        length,
        displacement_uncertainty: ((ends + length * length * direction_variance) / 3.0).sqrt(),
        deviation: variance.sqrt(),
    })
}
