//! The plane on which a hand moves.

use nalgebra::{Matrix3, Vector3};

use crate::noise;

/// The standard deviation of a normal around its prior, in radians: 5 degrees.
const PRIOR_SPREAD: f64 = 0.087;

/// A plane with standard uncertainties.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Plane {
    /// The normal, of length 1.
    pub normal: Vector3<f64>,
    /// The standard uncertainty of the normal, in radians.
    pub normal_uncertainty: f64,
    /// The length and the width of the area with points, in metres: four standard deviations.
    pub area: (f64, f64),
    /// The root mean square distance of the points from the plane, in metres.
    pub deviation: f64,
}

/// Fits a plane to points by the least squares of their distances. `prior` is a direction that the normal is expected to
/// have; it has the weight of an observation with 5 degrees of uncertainty. The normal points along it; without one it
/// points up, and that of an upright plane towards the person (against y).
///
/// Returns none for fewer than 8 points, and for points in one place.
///
/// ```
/// use longstep_teach::fit_plane;
/// use nalgebra::Vector3;
/// let point = |part: i32| Vector3::new(f64::from(part % 7) * 0.05, f64::from(part / 7) * 0.05, 0.7);
/// let plane = fit_plane(&(0..49).map(point).collect::<Vec<_>>(), None).unwrap();
/// assert!((plane.normal - Vector3::z()).norm() < 1e-9);
/// ```
pub fn fit_plane(points: &[Vector3<f64>], prior: Option<Vector3<f64>>) -> Option<Plane> {
    if points.len() < 8 {
        return None;
    }
    let prior = prior.and_then(|prior| prior.try_normalize(1e-9));
    let count = points.len() as f64;
    let middle = points.iter().sum::<Vector3<f64>>() / count;
    let scatter: Matrix3<f64> = points
        .iter()
        .map(|point| (point - middle) * (point - middle).transpose())
        .sum();
    let eigen = scatter.symmetric_eigen();
    let mut spreads: [f64; 3] = [0, 1, 2].map(|index| eigen.eigenvalues[index].max(0.0));
    spreads.sort_by(f64::total_cmp);
    if spreads[2] <= 1e-12 {
        return None;
    }
    let noise_variance = (spreads[0] / (count - 3.0)).max(1e-12);
    let mut information = scatter / noise_variance;
    if let Some(prior) = prior {
        information += (Matrix3::identity() - prior * prior.transpose()) / (PRIOR_SPREAD * PRIOR_SPREAD);
    }
    let weighed = information.symmetric_eigen();
    let least = weighed.eigenvalues.imin();
    let mut normal: Vector3<f64> = weighed.eigenvectors.column(least).into_owned();
    let side = match prior {
        Some(prior) => normal.dot(&prior),
        None if normal.z.abs() > 0.3 => normal.z,
        None => -normal.y,
    };
    if side < 0.0 {
        normal = -normal;
    }
    let heights: Vec<f64> = points.iter().map(|point| (point - middle).dot(&normal)).collect();
    let inflation = noise::inflation(&heights);
    let variance = |index: usize| 1.0 / (weighed.eigenvalues[index] - weighed.eigenvalues[least]).max(1e-9);
    let across: f64 = (0..3).filter(|index| *index != least).map(variance).sum();
    let square: f64 = heights.iter().map(|height| height * height).sum();
    Some(Plane {
        normal,
        // More than a right angle says nothing more.
        normal_uncertainty: (across * inflation).sqrt().min(std::f64::consts::FRAC_PI_2),
        area: (4.0 * (spreads[2] / count).sqrt(), 4.0 * (spreads[1] / count).sqrt()),
        deviation: (square / (count - 3.0)).sqrt(),
    })
}
