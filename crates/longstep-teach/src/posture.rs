//! Directions of the upper and the lower arm: the 26 directions of the paper, three rings of eight and two poles.

use nalgebra::Vector3;

/// The directions around the body, from x (right) to y (forward), with their names.
const AROUND: [(&str, f64, f64); 8] = [
    ("right", 1.0, 0.0),
    ("rightforward", 1.0, 1.0),
    ("forward", 0.0, 1.0),
    ("leftforward", -1.0, 1.0),
    ("left", -1.0, 0.0),
    ("leftback", -1.0, -1.0),
    ("back", 0.0, -1.0),
    ("rightback", 1.0, -1.0),
];
/// The rings with their names, and the angle over the horizon in degrees.
const RINGS: [(&str, f64); 3] = [("low", -45.0), ("middle", 0.0), ("high", 45.0)];

/// Returns the 26 directions with their names.
pub fn directions() -> Vec<(String, Vector3<f64>)> {
    let ring = |(ring, degrees): (&str, f64)| {
        let (up, out) = degrees.to_radians().sin_cos();
        let direction = |(name, x, y): (&str, f64, f64)| {
            let flat = Vector3::new(x, y, 0.0).normalize() * out;
            (format!("{name}_{ring}"), flat + Vector3::new(0.0, 0.0, up))
        };
        AROUND.map(direction)
    };
    let poles = [("place_low", -Vector3::z()), ("place_high", Vector3::z())];
    let poles = poles.map(|(name, direction)| (name.to_owned(), direction));
    RINGS.into_iter().flat_map(ring).chain(poles).collect()
}

/// Returns the name of the direction that is nearest to a vector, and the angle to it in radians; none for a vector
/// without length.
///
/// ```
/// use longstep_teach::posture;
/// use nalgebra::Vector3;
/// assert_eq!(posture(Vector3::new(0.05, 0.1, -0.9)).unwrap().0, "place_low");
/// assert_eq!(posture(Vector3::new(0.2, 0.25, 0.0)).unwrap().0, "rightforward_middle");
/// ```
pub fn posture(vector: Vector3<f64>) -> Option<(String, f64)> {
    let vector = vector.try_normalize(1e-6)?;
    let nearest = directions()
        .into_iter()
        .max_by(|(_, one), (_, other)| one.dot(&vector).total_cmp(&other.dot(&vector)));
    nearest.map(|(name, direction)| (name, direction.dot(&vector).min(1.0).acos()))
}
