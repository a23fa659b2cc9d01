//! The noise of a recording.

use nalgebra::Vector3;

/// Returns the standard deviation of each coordinate of a recorded path, from its second differences, in metres. A hand's
/// acceleration adds about a millimetre at 30 Hz. Zero for fewer than 8 points.
///
/// ```
/// use longstep_teach::noise;
/// use nalgebra::Vector3;
/// let straight: Vec<_> = (0..30).map(|part| Vector3::new(f64::from(part) * 0.01, 0.0, 0.0)).collect();
/// assert!(noise(&straight) < 1e-9);
/// ```
pub fn noise(points: &[Vector3<f64>]) -> f64 {
    if points.len() < 8 {
        return 0.0;
    }
    let second = |window: &[Vector3<f64>]| (window[0] - 2.0 * window[1] + window[2]).norm_squared();
    let mut squares: Vec<f64> = points.windows(3).map(second).collect();
    // The median, so that a few fast movements do not count. Of three squared normal numbers it is 0.789 of the mean.
    squares.sort_by(f64::total_cmp);
    let median = squares[squares.len() / 2] / 0.789;
    (median / 18.0).sqrt()
}

/// Returns the factor by which the variance of a fit grows because its residuals hang together: that of a process in
/// which each residual keeps a part of the last one.
pub(crate) fn inflation(residuals: &[f64]) -> f64 {
    let square: f64 = residuals.iter().map(|own| own * own).sum();
    let product: f64 = residuals.windows(2).map(|pair| pair[0] * pair[1]).sum();
    if square <= 0.0 {
        return 1.0;
    }
    let kept = (product / square).clamp(0.0, 0.95);
    (1.0 + kept) / (1.0 - kept)
}

/// The most frames at the end of a path that are taken together: a third of a second at 30 Hz.
const RESTING: usize = 10;

/// An end of a path: the mean of the frames in which the hand rests there.
pub(crate) struct End {
    pub(crate) position: Vector3<f64>,
    /// The standard uncertainty of each coordinate.
    pub(crate) uncertainty: f64,
    /// The number of frames.
    pub(crate) frames: usize,
}

/// Returns an end of a path, given from that end on. One frame is as uncertain as the noise; frames that do not differ
/// more than by noise are one place.
pub(crate) fn end<'a>(mut points: impl Iterator<Item = &'a Vector3<f64>>, noise: f64) -> Option<End> {
    let mut position = *points.next()?;
    let mut frames = 1;
    for point in points.take(RESTING - 1) {
        if (point - position).norm() > 2.5 * noise {
            break;
        }
        frames += 1;
        position += (point - position) / frames as f64;
    }
    Some(End {
        position,
        // A hand that moves slowly is as near, too, so more frames count no more.
        uncertainty: noise / (frames as f64).sqrt().min(1.4),
        frames,
    })
}
