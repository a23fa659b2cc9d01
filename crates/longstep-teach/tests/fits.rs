//! The fits of random motions with 5 mm of noise at 30 Hz: the bounds of docs/guide/teaching.md.
#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod person;

use longstep_teach::{fit_arc, fit_line, fit_plane, noise};
use nalgebra::{Rotation3, Unit, Vector3};
use person::{Random, eased};

const NOISE: f64 = 0.005;

fn direction(random: &mut Random) -> Vector3<f64> {
    random.vector().normalize()
}

fn noisy(random: &mut Random, point: Vector3<f64>) -> Vector3<f64> {
    point + random.vector() * NOISE
}

/// The angle between two directions, in degrees.
fn between(one: Vector3<f64>, other: Vector3<f64>) -> f64 {
    one.dot(&other).clamp(-1.0, 1.0).acos().to_degrees()
}

/// Errors of one value over many motions, with their claimed standard uncertainties.
#[derive(Default)]
struct Errors(Vec<(f64, f64)>);

impl Errors {
    fn add(&mut self, error: f64, uncertainty: f64) {
        self.0.push((error, uncertainty));
    }

    fn quantile(&self, share: f64) -> f64 {
        let mut sorted: Vec<f64> = self.0.iter().map(|(error, _)| error.abs()).collect();
        sorted.sort_by(f64::total_cmp);
        sorted[((sorted.len() - 1) as f64 * share) as usize]
    }

    fn mean(&self) -> f64 {
        self.0.iter().map(|(error, _)| error).sum::<f64>() / self.0.len() as f64
    }

    /// The share of errors within two claimed uncertainties.
    fn covered(&self) -> f64 {
        let inside = self
            .0
            .iter()
            .filter(|(error, uncertainty)| error.abs() <= 2.0 * uncertainty);
        inside.count() as f64 / self.0.len() as f64
    }

    /// Prints a row of the table, and checks its bound on 95 in 100 motions and its claims.
    #[track_caller]
    fn check(&self, name: &str, bound: f64) {
        let (median, most, covered) = (self.quantile(0.5), self.quantile(0.95), self.covered());
        println!(
            "{name:32} median {median:.4}, 95 % {most:.4} (bound {bound}), within two uncertainties {:.1} %",
            covered * 100.0
        );
        assert!(most <= bound, "{name}: {most} > {bound}");
        assert!(covered >= 0.9, "{name}: only {covered} within two uncertainties");
    }
}

/// A random arc: axis, centre, radius, and points.
struct Turn {
    axis: Vector3<f64>,
    centre: Vector3<f64>,
    radius: f64,
    angle: f64,
    points: Vec<Vector3<f64>>,
}

fn turn(random: &mut Random, radius: f64, degrees: f64, axis: Vector3<f64>) -> Turn {
    let centre = random.vector() * 0.5;
    let start = axis.cross(&direction(random)).normalize() * radius;
    let frames = (random.uniform(2.0, 4.0) * 30.0) as usize;
    let angle = degrees.to_radians();
    let point = |part: usize| {
        let turned = eased(part as f64 / (frames - 1) as f64) * angle;
        centre + Rotation3::from_axis_angle(&Unit::new_normalize(axis), turned) * start
    };
    let points = (0..frames).map(point).collect::<Vec<_>>();
    let points = points.into_iter().map(|point| noisy(random, point)).collect();
    Turn {
        axis,
        centre,
        radius,
        angle,
        points,
    }
}

fn check_turns(prior: bool, bounds: [f64; 4]) {
    let mut random = Random(7);
    let [mut axes, mut centres, mut radii, mut angles] = [(); 4].map(|()| Errors::default());
    for _ in 0..400 {
        let (radius, degrees) = (random.uniform(0.2, 0.6), random.uniform(60.0, 120.0));
        let axis = direction(&mut random);
        let shown = turn(&mut random, radius, degrees, axis);
        // The domain's axis is a few degrees off.
        let prior = prior.then(|| (shown.axis + random.vector() * 0.03).normalize());
        let arc = fit_arc(&shown.points, prior).unwrap();
        assert_eq!(arc.against_prior, None);
        axes.add(between(arc.axis, shown.axis), arc.axis_uncertainty.to_degrees());
        centres.add((arc.centre - shown.centre).norm(), arc.centre_uncertainty * 3f64.sqrt());
        radii.add(
            (arc.radius - shown.radius) / shown.radius,
            arc.radius_uncertainty / shown.radius,
        );
        angles.add(
            (arc.angle - shown.angle).to_degrees(),
            arc.angle_uncertainty.to_degrees(),
        );
    }
    let name = |value: &str| format!("{value}, {}", if prior { "with a prior" } else { "no prior" });
    axes.check(&name("axis (degrees)"), bounds[0]);
    centres.check(&name("centre (m)"), bounds[1]);
    radii.check(&name("radius (share)"), bounds[2]);
    angles.check(&name("angle (degrees)"), bounds[3]);
}

#[test]
fn turns_are_found_without_a_prior() {
    check_turns(false, [3.0, 0.02, 0.05, 4.0]);
}

#[test]
fn turns_are_found_with_a_prior() {
    check_turns(true, [3.0, 0.02, 0.05, 4.0]);
}

#[test]
fn the_radius_of_a_short_arc_is_unbiased() {
    for prior in [false, true] {
        let mut random = Random(11);
        let mut radii = Errors::default();
        for _ in 0..400 {
            let shown = turn(&mut random, 0.4, 45.0, Vector3::z());
            let arc = fit_arc(&shown.points, prior.then(Vector3::z)).unwrap();
            radii.add(arc.radius - 0.4, arc.radius_uncertainty);
        }
        println!(
            "radius of 0.4 m from 45 degrees, prior {prior}: mean {:.4}",
            0.4 + radii.mean()
        );
        radii.check("radius of 45 degrees (m)", 0.05);
        // An algebraic fit is 77 mm short.
        assert!(radii.mean().abs() < 0.005, "{}", radii.mean());
    }
}

#[test]
fn a_prior_that_contradicts_the_arc_is_not_used() {
    let mut random = Random(3);
    let shown = turn(&mut random, 0.4, 90.0, Vector3::x());
    let arc = fit_arc(&shown.points, Some(Vector3::z())).unwrap();
    assert!((80.0..100.0).contains(&arc.against_prior.unwrap().to_degrees()));
    assert!(between(arc.axis, Vector3::x()) < 4.0);
    // The other direction of the same axis is the same hinge.
    let arc = fit_arc(&shown.points, Some(-Vector3::x())).unwrap();
    assert_eq!(arc.against_prior, None);
    assert!(
        (arc.angle.to_degrees() + 90.0).abs() < 5.0,
        "{}",
        arc.angle.to_degrees()
    );
}

#[test]
fn a_full_turn_and_more_is_counted() {
    let mut random = Random(5);
    let shown = turn(&mut random, 0.2, 500.0, Vector3::z());
    let arc = fit_arc(&shown.points, Some(Vector3::z())).unwrap();
    assert!(
        (arc.angle.to_degrees() - 500.0).abs() < 5.0,
        "{}",
        arc.angle.to_degrees()
    );
}

#[test]
fn slides_are_found() {
    let mut random = Random(13);
    let [mut directions, mut displacements, mut noises] = [(); 3].map(|()| Errors::default());
    for _ in 0..400 {
        let (start, direction) = (random.vector() * 0.5, direction(&mut random));
        let (length, frames) = (random.uniform(0.1, 0.5), random.uniform(45.0, 120.0) as usize);
        let point = |part: usize| start + direction * (length * eased(part as f64 / (frames - 1) as f64));
        let points: Vec<_> = (0..frames).map(point).collect();
        let points: Vec<_> = points.into_iter().map(|point| noisy(&mut random, point)).collect();
        let line = fit_line(&points).unwrap();
        directions.add(
            between(line.direction, direction),
            line.direction_uncertainty.to_degrees(),
        );
        displacements.add(
            (line.displacement() - direction * length).norm(),
            line.displacement_uncertainty * 3f64.sqrt(),
        );
        noises.add((noise(&points) - NOISE) / NOISE, 0.15);
    }
    directions.check("direction of a slide (degrees)", 1.5);
    displacements.check("displacement (m)", 0.016);
    noises.check("noise of the recording (share)", 0.3);
}

#[test]
fn wiped_planes_are_found() {
    for prior in [false, true] {
        let mut random = Random(17);
        let mut normals = Errors::default();
        for _ in 0..400 {
            let normal = direction(&mut random);
            let along = normal.cross(&direction(&mut random)).normalize();
            let aside = normal.cross(&along);
            let (middle, long, wide) = (
                random.vector() * 0.5,
                random.uniform(0.1, 0.3),
                random.uniform(0.05, 0.15),
            );
            // To and fro, and slowly aside.
            let point = |part: usize| {
                let share = part as f64 / 119.0;
                middle + along * (long * (share * 40.0).sin()) + aside * (wide * (2.0 * share - 1.0))
            };
            let points: Vec<_> = (0..120).map(point).collect();
            let points: Vec<_> = points.into_iter().map(|point| noisy(&mut random, point)).collect();
            let expected = prior.then(|| (normal + random.vector() * 0.03).normalize());
            let plane = fit_plane(&points, expected).unwrap();
            let error = between(plane.normal, normal).min(180.0 - between(plane.normal, normal));
            normals.add(error, plane.normal_uncertainty.to_degrees());
        }
        normals.check(&format!("normal of a plane, prior {prior} (degrees)"), 1.5);
    }
}

#[test]
fn motions_without_a_shape_have_no_fit() {
    let still = vec![Vector3::new(0.1, 0.2, 0.3); 60];
    assert_eq!(fit_arc(&still, None), None);
    assert_eq!(fit_line(&still), None);
    assert_eq!(fit_plane(&still, None), None);
    let straight: Vec<_> = (0..60)
        .map(|part| Vector3::new(f64::from(part) * 0.01, 0.0, 0.0))
        .collect();
    assert_eq!(fit_arc(&straight, None), None);
    assert_eq!(fit_arc(&straight, Some(Vector3::z())), None);
    assert_eq!(fit_arc(&straight[..5], None), None);
}
