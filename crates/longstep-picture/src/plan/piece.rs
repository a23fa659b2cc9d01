//! The parts of a picture of a plan.

use crate::draw::canvas::{Area, Line};
use crate::draw::text::{Font, wrapped};
use crate::draw::theme::Paint;

/// A part of a diagram with its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece {
    pub(super) area: Area,
    pub(super) shape: Shape,
    pub(super) lines: Vec<Line>,
    pub(super) children: Vec<Piece>,
    /// Lines that connect the children.
    pub(super) rails: Vec<Rail>,
    /// The number of the step.
    pub(super) step: Option<usize>,
    /// The text for a pointer over the part.
    pub(super) title: Option<String>,
}

/// A line between parts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Rail {
    pub(super) points: Vec<(f64, f64)>,
    pub(super) paint: Paint,
}

/// The appearance of a part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shape {
    pub(super) paint: Paint,
    pub(super) radius: f64,
    pub(super) edited: bool,
}

impl Shape {
    pub(super) const fn new(paint: Paint, radius: f64) -> Self {
        Self {
            paint,
            radius,
            edited: false,
        }
    }
}

impl Piece {
    pub(super) fn new(area: Area, shape: Shape) -> Self {
        Self {
            area,
            shape,
            lines: Vec::new(),
            children: Vec::new(),
            rails: Vec::new(),
            step: None,
            title: None,
        }
    }

    pub(super) fn shift(&mut self, x: f64, y: f64) {
        self.area.x += x;
        self.area.y += y;
        for line in &mut self.lines {
            line.x += x;
            line.y += y;
        }
        for (dx, dy) in self.rails.iter_mut().flat_map(|rail| &mut rail.points) {
            *dx += x;
            *dy += y;
        }
        self.children.iter_mut().for_each(|child| child.shift(x, y));
    }
}

pub(super) fn area(width: f64, height: f64) -> Area {
    Area {
        x: 0.0,
        y: 0.0,
        width,
        height,
    }
}

pub(super) fn line_at(x: f64, top: f64, text: String, font: Font, paint: Paint) -> Line {
    Line {
        x,
        y: top + font.size + 1.0,
        text,
        font,
        paint,
    }
}

/// Adds a wrapped text; returns the height below it.
pub(super) fn put(
    lines: &mut Vec<Line>,
    (x, top): (f64, f64),
    text: &str,
    font: Font,
    paint: Paint,
    room: f64,
    most: usize,
) -> f64 {
    let mut y = top;
    for line in wrapped(text, font, room, most) {
        lines.push(line_at(x, y, line, font, paint));
        y += font.line_height();
    }
    y
}
