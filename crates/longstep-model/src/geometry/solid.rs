//! Boxes in space: rotation, faces, footprints and shares of volume.

use super::forms::Vector;
use super::scene::Body;
use crate::effort;

type Point = [f64; 2];

/// Points along each edge at which the shared volume of two boxes is sampled.
const SAMPLES: usize = 8;
/// The least share of the vertical in an axis of a box that has a top face: 15 degrees of tilt.
const LEVEL: f64 = 0.966;

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn between(from: Vector, to: Vector) -> Vector {
    [to[0] - from[0], to[1] - from[1], to[2] - from[2]]
}

/// A box with its axes in the frame of the scene.
#[derive(Debug, Clone)]
pub(super) struct Solid {
    pub(super) centre: Vector,
    axes: [Vector; 3],
    half: Vector,
    /// The extent along the axes of the scene.
    pub(super) low: Vector,
    pub(super) high: Vector,
    /// The axis that is vertical up to the tolerance of tilt.
    upright: Option<usize>,
}

impl Solid {
    pub(super) fn of(body: &Body) -> Self {
        let [w, x, y, z] = body.orientation.parts;
        let axes = [
            [
                1.0 - 2.0 * (y * y + z * z),
                2.0 * (x * y + w * z),
                2.0 * (x * z - w * y),
            ],
            [
                2.0 * (x * y - w * z),
                1.0 - 2.0 * (x * x + z * z),
                2.0 * (y * z + w * x),
            ],
            [
                2.0 * (x * z + w * y),
                2.0 * (y * z - w * x),
                1.0 - 2.0 * (x * x + y * y),
            ],
        ];
        let half = body.size.map(|edge| edge / 2.0);
        let centre = body.position;
        let reach = |axis: usize| (0..3).map(|own| axes[own][axis].abs() * half[own]).sum::<f64>();
        let extent = [reach(0), reach(1), reach(2)];
        let upright = (0..3).find(|own| axes[*own][2].abs() >= LEVEL);
        Self {
            centre,
            axes,
            half,
            low: [centre[0] - extent[0], centre[1] - extent[1], centre[2] - extent[2]],
            high: [centre[0] + extent[0], centre[1] + extent[1], centre[2] + extent[2]],
            upright,
        }
    }

    pub(super) fn volume(&self) -> f64 {
        8.0 * self.half[0] * self.half[1] * self.half[2]
    }

    /// Returns true if the extents of both boxes, grown by a margin, meet.
    pub(super) fn is_near(&self, other: &Self, margin: f64) -> bool {
        (0..3).all(|axis| self.low[axis] <= other.high[axis] + margin && other.low[axis] <= self.high[axis] + margin)
    }

    /// Returns true if a point is in the box, grown by a margin.
    pub(super) fn contains(&self, point: Vector, margin: f64) -> bool {
        let way = between(self.centre, point);
        (0..3).all(|axis| dot(way, self.axes[axis]).abs() <= self.half[axis] + margin)
    }

    pub(super) fn distance_to_centre(&self, point: Vector) -> f64 {
        let way = between(self.centre, point);
        dot(way, way).sqrt()
    }

    fn point(&self, shares: Vector) -> Vector {
        let mut point = self.centre;
        for (axis, share) in shares.into_iter().enumerate() {
            for (coordinate, direction) in point.iter_mut().zip(self.axes[axis]) {
                *coordinate += direction * self.half[axis] * share;
            }
        }
        point
    }

    /// Returns the share of the volume of this box that is in the other one, from sample points.
    pub(super) fn share_in(&self, other: &Self) -> f64 {
        if !self.is_near(other, 0.0) || !effort::spend(SAMPLES.pow(3) / 4) {
            return 0.0;
        }
        let at = |index: usize| (2 * index + 1) as f64 / SAMPLES as f64 - 1.0;
        let indices = 0..SAMPLES;
        let all = indices.clone().flat_map(|x| (0..SAMPLES).map(move |y| (x, y)));
        let all = all.flat_map(|(x, y)| (0..SAMPLES).map(move |z| [at(x), at(y), at(z)]));
        let inside = all.filter(|shares| other.contains(self.point(*shares), 0.0)).count();
        inside as f64 / SAMPLES.pow(3) as f64
    }

    /// Returns the depth to which two boxes are in each other, along the axis of a face along which it is least; at most
    /// 0 if a face separates them.
    pub(super) fn depth(&self, other: &Self) -> f64 {
        let way = between(self.centre, other.centre);
        let radius = |solid: &Self, axis: Vector| -> f64 {
            (0..3)
                .map(|own| dot(solid.axes[own], axis).abs() * solid.half[own])
                .sum()
        };
        let axes = self.axes.iter().chain(&other.axes);
        let depths = axes.map(|axis| radius(self, *axis) + radius(other, *axis) - dot(way, *axis).abs());
        depths.fold(f64::INFINITY, f64::min)
    }

    /// Returns the corners of the shadow on the floor, counter-clockwise.
    pub(super) fn footprint(&self) -> Vec<Point> {
        let signs = [-1.0, 1.0];
        let corners = signs.iter().flat_map(|x| signs.iter().map(move |y| (*x, *y)));
        let corners = corners.flat_map(|(x, y)| signs.iter().map(move |z| [x, y, *z]));
        let mut points: Vec<Point> = corners.map(|shares| self.point(shares)).map(|p| [p[0], p[1]]).collect();
        hull(&mut points)
    }

    /// Returns the corners of the top face seen from above, and the vertical distance from it to a height at a place;
    /// none for a tilted box.
    pub(super) fn top(&self) -> Option<Top> {
        let upright = self.upright?;
        let up = self.axes[upright].map(|part| part * self.axes[upright][2].signum());
        let [a, b] = match upright {
            0 => [1, 2],
            1 => [0, 2],
            _ => [0, 1],
        };
        let mut corners: Vec<Point> = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .into_iter()
            .map(|(x, y)| {
                let mut shares = [0.0; 3];
                (shares[a], shares[b]) = (x, y);
                shares[upright] = self.axes[upright][2].signum();
                self.point(shares)
            })
            .map(|corner| [corner[0], corner[1]])
            .collect();
        let mut middle = self.centre;
        for (coordinate, part) in middle.iter_mut().zip(up) {
            *coordinate += part * self.half[upright];
        }
        Some(Top {
            corners: hull(&mut corners),
            middle,
            up,
        })
    }
}

/// The top face of a box.
pub(super) struct Top {
    corners: Vec<Point>,
    middle: Vector,
    up: Vector,
}

impl Top {
    /// Returns the height of a box's lowest point above the face, and the share of the box's footprint over it.
    pub(super) fn under(&self, solid: &Solid) -> (f64, f64) {
        let [x, y, _] = between(self.middle, solid.centre);
        let height = self.middle[2] - (self.up[0] * x + self.up[1] * y) / self.up[2];
        let footprint = solid.footprint();
        let whole = area(&footprint);
        let share = if whole > 0.0 {
            area(&clipped(&footprint, &self.corners)) / whole
        } else {
            0.0
        };
        (solid.low[2] - height, share.clamp(0.0, 1.0))
    }
}

/// The contact of a box with the side of another one.
pub(super) struct SideContact {
    /// The distance between the faces; negative if one is in the other.
    pub(super) gap: f64,
    /// The share of the smaller box's height and width that faces the other one.
    pub(super) share: f64,
}

/// Returns the contact of a box with the side of another one that is nearest to it.
pub(super) fn side_contact(solid: &Solid, other: &Solid) -> Option<SideContact> {
    let way = between(other.centre, solid.centre);
    let reach = |axis: usize| -> f64 {
        (0..3)
            .map(|own| dot(solid.axes[own], other.axes[axis]).abs() * solid.half[own])
            .sum()
    };
    let offset: Vec<f64> = (0..3).map(|axis| dot(way, other.axes[axis])).collect();
    let gap = |axis: usize| offset[axis].abs() - other.half[axis] - reach(axis);
    let sides = (0..3).filter(|axis| other.upright != Some(*axis));
    let axis = sides.max_by(|a, b| gap(*a).total_cmp(&gap(*b)))?;
    let overlap = |own: usize| {
        let (low, high) = (offset[own] - reach(own), offset[own] + reach(own));
        let common = high.min(other.half[own]) - low.max(-other.half[own]);
        (common / (high - low)).clamp(0.0, 1.0)
    };
    let share = (0..3).filter(|own| *own != axis).map(overlap).product();
    Some(SideContact { gap: gap(axis), share })
}

/// Returns the least distance between two boxes seen from above; 0 if their footprints meet.
pub(super) fn gap_from_above(a: &Solid, b: &Solid) -> f64 {
    let (one, other) = (a.footprint(), b.footprint());
    if area(&clipped(&one, &other)) > 0.0 {
        return 0.0;
    }
    let to_edges = |points: &[Point], polygon: &[Point]| {
        let edges = || polygon.iter().zip(polygon.iter().cycle().skip(1));
        let pairs = points.iter().flat_map(|point| edges().map(move |edge| (point, edge)));
        pairs
            .map(|(point, (from, to))| distance(*point, *from, *to))
            .fold(f64::INFINITY, f64::min)
    };
    to_edges(&one, &other).min(to_edges(&other, &one))
}

fn distance(point: Point, from: Point, to: Point) -> f64 {
    let (edge, way) = (
        [to[0] - from[0], to[1] - from[1]],
        [point[0] - from[0], point[1] - from[1]],
    );
    let length = edge[0] * edge[0] + edge[1] * edge[1];
    let at = if length > 0.0 {
        ((way[0] * edge[0] + way[1] * edge[1]) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (way[0] - edge[0] * at).hypot(way[1] - edge[1] * at)
}

fn cross(o: Point, a: Point, b: Point) -> f64 {
    (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
}

/// The convex hull, counter-clockwise (monotone chain).
fn hull(points: &mut [Point]) -> Vec<Point> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |points: &mut dyn Iterator<Item = Point>| {
        let mut chain: Vec<Point> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..] {
                if cross(a, b, point) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut all = half(&mut points.iter().copied());
    all.extend(half(&mut points.iter().rev().copied()));
    all
}

fn area(polygon: &[Point]) -> f64 {
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    edges.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>() / 2.0
}

/// The part of a convex polygon within another one (Sutherland and Hodgman).
fn clipped(polygon: &[Point], by: &[Point]) -> Vec<Point> {
    let mut rest = polygon.to_vec();
    for (from, to) in by.iter().zip(by.iter().cycle().skip(1)) {
        let before = std::mem::take(&mut rest);
        for (a, b) in before.iter().zip(before.iter().cycle().skip(1)) {
            let (inside_a, inside_b) = (cross(*from, *to, *a), cross(*from, *to, *b));
            if inside_a >= 0.0 {
                rest.push(*a);
            }
            if (inside_a > 0.0 && inside_b < 0.0) || (inside_a < 0.0 && inside_b > 0.0) {
                let at = inside_a / (inside_a - inside_b);
                rest.push([a[0] + (b[0] - a[0]) * at, a[1] + (b[1] - a[1]) * at]);
            }
        }
    }
    rest
}
