//! The layout of a diagram: a column of cards, with the sides of branches and the lanes beside each other where there is
//! room.

use super::card::{DETAIL, DETAIL_LINES, TEXT_LINES, card};
use super::piece::{Piece, Rail, Shape, area, line_at, put};
use super::{Diagram, DiagramNode, LaneRow, StepNode};
use crate::draw::canvas::{Area, Line};
use crate::draw::text::{Font, fitted, wrapped};
use crate::draw::theme::{self, Paint};

const HEAD: Font = Font::bold(13.0);

/// Space around the whole.
const MARGIN: f64 = 8.0;
/// Space between parts, where rails run.
const SPACE: f64 = 14.0;
/// Space between columns.
const COLUMN_SPACE: f64 = 12.0;
/// Distance of a rail from the left border of a part.
const RAIL: f64 = 20.0;
/// Greatest width of a card.
const CARD_WIDTH: f64 = 1400.0;
/// Least width of a side of a branch beside the other one, and of a lane beside another one.
const SIDE_WIDTH: f64 = 220.0;
const LANE_WIDTH: f64 = 130.0;
/// Share of the width for a side without steps.
const EMPTY_SHARE: f64 = 0.28;
/// Least width of a picture, and what each level of nesting takes of it.
const LEAST_WIDTH: f64 = 180.0;
const LEVEL_WIDTH: f64 = 14.0;

/// Lays out a diagram in a width. The area is that of the whole picture; it is wider than asked for where the parts are too
/// deep inside each other, and the picture is scaled down then.
pub(super) fn whole(diagram: &Diagram, full: f64) -> Piece {
    let full = full.max(LEAST_WIDTH + LEVEL_WIDTH * depth(&diagram.nodes) as f64);
    let mut column = Column::new(MARGIN, MARGIN, full - 2.0 * MARGIN);
    column.nodes(&diagram.nodes);
    if diagram.nodes.is_empty() {
        column.note("There is nothing to do.", theme::MUTED);
    }
    for text in &diagram.left_out {
        column.note(&format!("left out: {text}"), theme::CHANGE_INK);
    }
    for text in &diagram.assumptions {
        column.note(&format!("assumed: {text}"), theme::MUTED);
    }
    let mut piece = Piece::new(Area::default(), Shape::new(theme::PAPER, 0.0));
    column.fill(&mut piece, MARGIN);
    piece.area.width = full;
    piece
}

/// Returns the number of frames around the innermost part.
fn depth(nodes: &[DiagramNode]) -> usize {
    let deep = |node: &DiagramNode| match node {
        DiagramNode::Step(_) | DiagramNode::Remark { .. } => 0,
        DiagramNode::Branch { then, other, .. } => 1 + depth(then).max(depth(other)),
        DiagramNode::Loop { body, .. } | DiagramNode::Repeat { body, .. } => 1 + depth(body),
        DiagramNode::Lanes { .. } => 1,
    };
    nodes.iter().map(deep).max().unwrap_or(0)
}

/// Parts that are added from top to bottom.
struct Column {
    left: f64,
    width: f64,
    y: f64,
    children: Vec<Piece>,
    lines: Vec<Line>,
    rails: Vec<Rail>,
    /// The points from which the rails to the next part begin.
    exits: Vec<(f64, f64)>,
}

impl Column {
    fn new(left: f64, top: f64, width: f64) -> Self {
        Self {
            left,
            width,
            y: top,
            children: Vec::new(),
            lines: Vec::new(),
            rails: Vec::new(),
            exits: Vec::new(),
        }
    }

    /// Moves the content into a piece, with space below it.
    fn fill(self, piece: &mut Piece, below: f64) {
        piece.children = self.children;
        piece.rails = self.rails;
        piece.lines.extend(self.lines);
        piece.area.height = self.y + below;
    }

    fn nodes(&mut self, nodes: &[DiagramNode]) {
        nodes.iter().for_each(|node| self.node(node));
    }

    fn node(&mut self, node: &DiagramNode) {
        match node {
            DiagramNode::Step(step) => self.step(step),
            DiagramNode::Remark { text } => self.note(text, theme::MUTED),
            DiagramNode::Branch {
                condition,
                otherwise,
                sensing,
                then,
                other,
            } => {
                sensing.iter().for_each(|step| self.step(step));
                self.condition(&format!("If {condition}"));
                self.sides([("yes".to_owned(), then), (format!("no: {otherwise}"), other)]);
            }
            DiagramNode::Loop {
                condition,
                sensing,
                body,
            } => self.frame(theme::LOOP, &format!("Again as long as {condition}"), |inner| {
                sensing.iter().for_each(|step| inner.step(step));
                inner.nodes(body);
            }),
            DiagramNode::Repeat { times, body } => {
                let plural = if *times == 1 { "" } else { "s" };
                self.frame(theme::LOOP, &format!("{times} time{plural}"), |inner| inner.nodes(body));
            }
            DiagramNode::Lanes { lanes, rows } => self.lanes(lanes, rows),
        }
    }

    /// Adds a part below the others, with the rails to it.
    fn push(&mut self, mut piece: Piece) {
        let indent = self.left - piece.area.x;
        piece.shift(indent, self.y - piece.area.y);
        self.connect((piece.area.x + RAIL.min(piece.area.width / 2.0), piece.area.y));
        self.exits = vec![(piece.area.x + RAIL.min(piece.area.width / 2.0), piece.area.bottom())];
        self.y = piece.area.bottom() + SPACE;
        self.children.push(piece);
    }

    /// Draws the rails from the open exits to an entry.
    fn connect(&mut self, entry: (f64, f64)) {
        for exit in std::mem::take(&mut self.exits) {
            let middle = entry.1 - SPACE / 2.0;
            let mut points = vec![exit];
            if (exit.0 - entry.0).abs() > 0.5 {
                points.extend([(exit.0, middle), (entry.0, middle)]);
            }
            points.push(entry);
            self.rails.push(Rail {
                points,
                paint: theme::RAIL,
            });
        }
    }

    /// Adds a text without a border.
    fn note(&mut self, text: &str, paint: Paint) {
        if !self.children.is_empty() {
            self.exits.clear();
        }
        for line in wrapped(text, DETAIL, self.width, TEXT_LINES) {
            self.lines.push(line_at(self.left, self.y, line, DETAIL, paint));
            self.y += DETAIL.line_height();
        }
        self.y += SPACE / 2.0;
    }

    fn step(&mut self, step: &StepNode) {
        for text in &step.left_out {
            self.note(&format!("left out: {text}"), theme::CHANGE_INK);
        }
        self.push(card(step, self.width.min(CARD_WIDTH), true));
    }

    fn condition(&mut self, text: &str) {
        let width = self.width.min(CARD_WIDTH);
        let mut piece = Piece::new(area(width, 0.0), Shape::new(theme::CONDITION, 14.0));
        let bottom = put(
            &mut piece.lines,
            (14.0, 6.0),
            text,
            HEAD,
            theme::INK,
            width - 28.0,
            TEXT_LINES,
        );
        piece.area.height = bottom + 6.0;
        piece.title = Some(text.to_owned());
        self.push(piece);
    }

    /// Adds the sides of a branch: beside each other, or below each other where there is no room.
    fn sides(&mut self, sides: [(String, &Vec<DiagramNode>); 2]) {
        let widths = self.side_widths([sides[0].1.is_empty(), sides[1].1.is_empty()]);
        let beside = widths.is_some();
        let indent = if beside { 0.0 } else { padding(self.width) };
        let widths = widths.unwrap_or([self.width - indent; 2]);
        let from = self.exits.first().copied().unwrap_or((self.left, self.y));
        // Below each other, one rail along the left border leads to both.
        let (rail_x, mut begin) = (self.left + indent / 2.0, from.1);
        let (mut x, mut exits, mut tallest) = (self.left + indent, Vec::new(), 0.0_f64);
        for ((label, nodes), width) in sides.into_iter().zip(widths) {
            let mut piece = side(&label, nodes, width);
            piece.shift(x, self.y);
            let rail = if beside {
                let (centre, middle) = (x + RAIL, self.y - SPACE / 2.0);
                vec![from, (from.0, middle), (centre, middle), (centre, self.y)]
            } else {
                let entry = piece.area.y + MARGIN;
                vec![
                    (rail_x, std::mem::replace(&mut begin, entry)),
                    (rail_x, entry),
                    (x, entry),
                ]
            };
            self.rails.push(Rail {
                points: rail,
                paint: theme::BRANCH_RAIL,
            });
            exits.push((x + RAIL, piece.area.bottom()));
            tallest = tallest.max(piece.area.height);
            if beside {
                x += width + COLUMN_SPACE;
            } else {
                self.y = piece.area.bottom() + SPACE;
            }
            self.children.push(piece);
        }
        if beside {
            self.y += tallest + SPACE;
            self.exits = exits;
        } else {
            // The rail runs along the left border.
            self.exits = exits.split_off(1);
        }
    }

    /// Returns the widths of both sides of a branch; none if they do not fit beside each other.
    fn side_widths(&self, empty: [bool; 2]) -> Option<[f64; 2]> {
        let room = self.width - COLUMN_SPACE;
        let first = match empty {
            [true, false] => room * EMPTY_SHARE,
            [false, true] => room * (1.0 - EMPTY_SHARE),
            _ => room / 2.0,
        };
        let fits = |width: f64, empty: bool| width >= if empty { SIDE_WIDTH / 2.0 } else { SIDE_WIDTH };
        (fits(first, empty[0]) && fits(room - first, empty[1])).then_some([first, room - first])
    }

    /// Adds a frame with a heading.
    fn frame(&mut self, paint: Paint, heading: &str, content: impl FnOnce(&mut Column)) {
        let piece = framed(paint, (heading, theme::BRANCH_INK), self.width, content);
        self.push(piece);
    }

    fn lanes(&mut self, names: &[String], rows: &[LaneRow]) {
        let count = names.len().max(1) as f64;
        let pad = padding(self.width);
        let lane = (self.width - 2.0 * pad - COLUMN_SPACE * (count - 1.0)) / count;
        let heading = ("At the same time", theme::ROBOT_INK);
        let piece = framed(theme::LANES, heading, self.width, |inner| {
            if lane >= LANE_WIDTH {
                inner.lane_columns(names, rows, lane);
            } else {
                inner.lane_list(names, rows);
            }
        });
        self.push(piece);
    }

    /// Adds lanes beside each other, a row for each unit of time.
    fn lane_columns(&mut self, names: &[String], rows: &[LaneRow], lane: f64) {
        let left = self.left;
        let x = |number: usize| left + number as f64 * (lane + COLUMN_SPACE);
        let heads = names.iter().enumerate();
        let heads = heads.map(|(number, name)| (number, lane_head(name, lane))).collect();
        self.row(heads, x);
        for row in rows {
            match row {
                LaneRow::Unit { cells } => {
                    let cards = cells.iter().enumerate();
                    let cards = cards.filter_map(|(number, cell)| Some((number, card(cell.as_ref()?, lane, false))));
                    self.row(cards.collect(), x);
                }
                LaneRow::Sync { name, lanes } => {
                    let (Some(first), Some(last)) = (lanes.first(), lanes.last()) else {
                        continue;
                    };
                    let bar = meeting(name, names, lanes, x(*last) + lane - x(*first));
                    self.row(vec![(*first, bar)], x);
                }
                LaneRow::Remark { lane: number, text } => {
                    for line in wrapped(text, DETAIL, lane, TEXT_LINES) {
                        self.lines.push(line_at(x(*number), self.y, line, DETAIL, theme::MUTED));
                        self.y += DETAIL.line_height();
                    }
                    self.y += SPACE / 2.0;
                }
            }
        }
        // As below other parts.
        self.y += SPACE / 2.0;
    }

    /// Adds pieces at the height of the column, each at the place of its lane.
    fn row(&mut self, pieces: Vec<(usize, Piece)>, x: impl Fn(usize) -> f64) {
        let tallest = pieces.iter().map(|(_, piece)| piece.area.height).fold(0.0, f64::max);
        for (lane, mut piece) in pieces {
            piece.shift(x(lane), self.y);
            self.children.push(piece);
        }
        if tallest > 0.0 {
            self.y += tallest + SPACE / 2.0;
        }
    }

    /// Adds lanes below each other, unit by unit, where there is no room for columns.
    fn lane_list(&mut self, names: &[String], rows: &[LaneRow]) {
        for row in rows {
            let mut steps = Vec::new();
            match row {
                LaneRow::Unit { cells } => {
                    let cells = cells.iter().enumerate();
                    steps.extend(cells.filter_map(|(lane, cell)| Some((lane, cell.as_ref()?))));
                }
                LaneRow::Sync { name, lanes } => {
                    let bar = meeting(name, names, lanes, self.width);
                    self.push(bar);
                    self.exits.clear();
                }
                LaneRow::Remark { text, .. } => self.note(text, theme::MUTED),
            }
            for (lane, step) in steps {
                let named = StepNode {
                    lane: names.get(lane).cloned(),
                    ..step.clone()
                };
                self.push(card(&named, self.width, true));
                self.exits.clear();
            }
        }
    }
}

/// Returns the space between the border of a frame and its content: less in narrow frames, which are deep inside others.
fn padding(width: f64) -> f64 {
    match width {
        _ if width > 260.0 => 10.0,
        _ if width > 180.0 => 5.0,
        _ => 1.0,
    }
}

/// Lays out a frame with a heading.
fn framed(paint: Paint, heading: (&str, Paint), width: f64, content: impl FnOnce(&mut Column)) -> Piece {
    let pad = padding(width);
    let mut piece = Piece::new(area(width, 0.0), Shape::new(paint, 8.0));
    let (text, ink) = heading;
    let top = put(
        &mut piece.lines,
        (pad, 5.0),
        text,
        HEAD,
        ink,
        width - 2.0 * pad,
        DETAIL_LINES,
    );
    let mut column = Column::new(pad, top + 4.0, width - 2.0 * pad);
    content(&mut column);
    if !column.children.is_empty() || !column.lines.is_empty() {
        column.y -= SPACE / 2.0;
    }
    column.fill(&mut piece, 4.0);
    piece
}

/// Lays out one side of a branch.
fn side(label: &str, nodes: &[DiagramNode], width: f64) -> Piece {
    let content = |inner: &mut Column| {
        inner.nodes(nodes);
        if nodes.is_empty() {
            inner.note("nothing to do", theme::MUTED);
        }
    };
    framed(theme::SIDE, (label, theme::BRANCH_INK), width, content)
}

fn lane_head(name: &str, width: f64) -> Piece {
    let mut piece = Piece::new(area(width, HEAD.line_height() + 8.0), Shape::new(theme::LANE_HEAD, 6.0));
    piece
        .lines
        .push(line_at(8.0, 4.0, fitted(name, HEAD, width - 16.0), HEAD, theme::INK));
    piece.title = Some(name.to_owned());
    piece
}

/// Lays out the bar at which lanes wait for each other.
fn meeting(name: &str, names: &[String], lanes: &[usize], width: f64) -> Piece {
    let who: Vec<&str> = lanes
        .iter()
        .filter_map(|lane| names.get(*lane).map(String::as_str))
        .collect();
    let text = format!("wait for each other: {name}");
    let mut piece = Piece::new(area(width, DETAIL.line_height() + 6.0), Shape::new(theme::MEETING, 3.0));
    piece.lines.push(line_at(
        8.0,
        3.0,
        fitted(&text, DETAIL, width - 16.0),
        DETAIL,
        theme::ROBOT_INK,
    ));
    piece.title = Some(format!("{text} ({})", who.join(", ")));
    piece
}
