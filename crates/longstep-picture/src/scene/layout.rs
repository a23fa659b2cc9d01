//! The layout of a scene: boxes that wrap within the box around them.

use std::ops::Range;

use super::change::{Changes, StateChange};
use super::schema::Relation;
use super::{Role, Scene, SceneBox};
use crate::draw::canvas::{Area, Line};
use crate::draw::text::{Font, fitted, width, wrapped};
use crate::draw::theme::{self, Paint};

/// Font of names.
pub(super) const NAME: Font = Font::bold(14.0);
/// Font of states.
pub(super) const STATE: Font = Font::regular(12.0);
/// Space between boxes, and around the whole.
pub(super) const GAP: f64 = 8.0;
/// Width of the sign of robots and hands.
pub(super) const ICON: f64 = 20.0;
/// Greatest width of a line of text in a box.
const TEXT_WIDTH: f64 = 220.0;
/// Least width inside a box for other boxes.
const LEAST_INSIDE: f64 = 36.0;
/// Lines of a name, and of states.
const NAME_LINES: usize = 2;
const STATE_LINES: usize = 3;
/// Ratio of width to height that boxes with content tend to.
const ASPECT: f64 = 2.4;
/// Greatest factor by which a place grows to fill its row.
const GROWTH: f64 = 2.5;

/// A box with its place in the picture, and everything in it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Block {
    /// Index of the box in the scene; none for the whole picture.
    pub(super) index: Option<usize>,
    pub(super) area: Area,
    pub(super) icon: bool,
    /// True if it may be taller than its content.
    stretches: bool,
    pub(super) labels: Vec<Line>,
    pub(super) children: Vec<Block>,
    /// Number of boxes inside that have no room.
    pub(super) left_out: usize,
}

impl Block {
    /// Moves the block with its content.
    pub(super) fn shift(&mut self, x: f64, y: f64) {
        self.area.x += x;
        self.area.y += y;
        for label in &mut self.labels {
            label.x += x;
            label.y += y;
        }
        for child in &mut self.children {
            child.shift(x, y);
        }
    }
}

/// Returns true if things are both on and in others, so that pictures say which.
pub(super) fn needs_captions(scene: &Scene) -> bool {
    let has = |relation| scene.boxes.iter().any(|own| own.relation == Some(relation));
    has(Relation::On) && has(Relation::In)
}

fn only_events(change: &StateChange) -> bool {
    change.gained.is_empty() && change.lost.is_empty()
}

/// A scene that is laid out.
pub(super) struct Layout<'s> {
    scene: &'s Scene,
    children: Vec<Vec<usize>>,
    /// Number of boxes inside each box, at any depth.
    inside: Vec<usize>,
    states: Vec<Option<&'s StateChange>>,
    /// True if things are both on and in others, so that pictures say which.
    captions: bool,
    /// True if events are the only change.
    shows_events: bool,
    /// Boxes that changed their place.
    moved: Vec<bool>,
    /// Statements about no entity, and whether each is new.
    statements: Vec<(String, bool)>,
    /// Width of the picture.
    full: f64,
}

impl<'s> Layout<'s> {
    pub(super) fn new(scene: &'s Scene, changes: &'s Changes, full: f64) -> Self {
        let count = scene.boxes.len();
        let (mut children, mut inside) = (vec![Vec::new(); count], vec![0; count]);
        for (index, own) in scene.boxes.iter().enumerate().rev() {
            if let Some(around) = own.within {
                children[around].insert(0, index);
                inside[around] += inside[index] + 1;
            }
        }
        let mut states = vec![None; count];
        for change in &changes.states {
            if let Some(index) = scene.boxes.iter().position(|own| own.id == change.id) {
                states[index] = Some(change);
            }
        }
        let is_moved = |own: &SceneBox| changes.moved.iter().any(|moved| moved.id == own.id);
        let statements = scene.statements.iter();
        Self {
            scene,
            children,
            inside,
            states,
            captions: needs_captions(scene),
            shows_events: changes.moved.is_empty() && changes.states.iter().all(only_events),
            moved: scene.boxes.iter().map(is_moved).collect(),
            statements: statements
                .map(|text| (text.clone(), changes.now.contains(text)))
                .collect(),
            full,
        }
    }

    /// Sets whether boxes say what is on and what is in them, as a scene beside this one does.
    pub(super) fn with_captions(self, captions: bool) -> Self {
        Self { captions, ..self }
    }

    /// Lays the whole scene out in a width: the robot, then places, then boxes without a place.
    pub(super) fn whole(&self) -> Block {
        let inner = self.full - 2.0 * GAP;
        let mut page = Page::new(GAP, GAP);
        page.tokens(&self.statements, inner);
        page.space(!self.statements.is_empty());
        let (robots, rest): (Vec<usize>, Vec<usize>) = self.roots().partition(|index| self.is_robot(*index));
        let (loose, places): (Vec<usize>, Vec<usize>) = rest.into_iter().partition(|index| self.is_loose(*index));
        page.rows(self.blocks(&robots, inner, 0), inner);
        page.rows(self.filled(&places, inner), inner);
        if !(loose.is_empty() || robots.is_empty() && places.is_empty()) {
            page.label(fitted("without a place", STATE, inner), STATE, theme::MUTED);
        }
        page.rows(self.blocks(&loose, inner, 0), inner);
        page.into_block(None, self.full, GAP)
    }

    fn roots(&self) -> impl Iterator<Item = usize> {
        let boxes = 0..self.scene.boxes.len();
        boxes.filter(|index| self.scene.boxes[*index].within.is_none() && self.is_shown(*index))
    }

    fn blocks(&self, boxes: &[usize], most: f64, depth: usize) -> Vec<Block> {
        let boxes = boxes.iter();
        boxes
            .map(|index| self.block(*index, most, depth, Flow::Compact))
            .collect()
    }

    /// Lays places out so that they fill their rows.
    fn filled(&self, boxes: &[usize], most: f64) -> Vec<Block> {
        let mut blocks = self.blocks(boxes, most, 0);
        for row in rows_of(&blocks, most) {
            let gaps = GAP * (row.len() - 1) as f64;
            let natural: f64 = blocks[row.clone()].iter().map(|block| block.area.width).sum();
            let factor = ((most - gaps) / natural).min(GROWTH);
            for place in row {
                let width = blocks[place].area.width * factor;
                blocks[place] = self.block(boxes[place], width, 0, Flow::Wide);
                blocks[place].area.width = width;
            }
        }
        blocks
    }

    /// Returns false for constants that are no more than values: colours, numbers of doors.
    fn is_shown(&self, index: usize) -> bool {
        let own = &self.scene.boxes[index];
        own.role != Role::Constant || self.inside[index] > 0 || !own.states.is_empty() || self.states[index].is_some()
    }

    fn is_loose(&self, index: usize) -> bool {
        matches!(self.scene.boxes[index].role, Role::Object | Role::Constant)
    }

    fn is_robot(&self, index: usize) -> bool {
        matches!(self.scene.boxes[index].role, Role::Robot | Role::Actor)
    }

    /// Lays a box out within a width.
    fn block(&self, index: usize, most: f64, depth: usize, flow: Flow) -> Block {
        let own = &self.scene.boxes[index];
        let pad = self.padding(depth);
        let inner = most - 2.0 * pad;
        let icon = if self.is_robot(index) && inner > 3.0 * ICON {
            ICON
        } else {
            0.0
        };
        let mut page = Page::new(pad, (pad - 2.0).max(1.0));
        let room = inner.min(TEXT_WIDTH);
        for line in wrapped(&own.name, NAME, room - icon, NAME_LINES) {
            page.label_at(icon, line, NAME, theme::INK);
        }
        page.tokens(&self.tokens(index), room);
        let mut left_out = 0;
        if self.inside[index] > 0 {
            page.space(true);
            if inner < LEAST_INSIDE {
                left_out = self.inside[index];
                let text = format!("{left_out} inside");
                page.label(fitted(&text, STATE, inner), STATE, theme::MUTED);
            } else {
                self.content(&mut page, index, inner, depth, flow);
            }
        }
        let mut block = page.into_block(Some(index), most, pad);
        block.icon = icon > 0.0;
        block.stretches = own.role == Role::Place;
        block.left_out = left_out;
        block
    }

    /// Adds the boxes inside a box: by relation, places first.
    fn content(&self, page: &mut Page, index: usize, inner: f64, depth: usize, flow: Flow) {
        let children = &self.children[index];
        let is_place = |index: &usize| self.scene.boxes[*index].role == Role::Place;
        let is_room =
            children.iter().any(is_place) && children.iter().all(|child| self.relation(*child) == Some(Relation::In));
        for group in children.chunk_by(|one, other| self.relation(*one) == self.relation(*other)) {
            let caption = match self.relation(group[0]) {
                Some(Relation::On) if self.captions => Some("on it"),
                Some(Relation::In) if self.captions && !is_room => Some("inside"),
                Some(Relation::Held) => Some("holds"),
                _ => None,
            };
            if let Some(caption) = caption {
                page.label(fitted(caption, STATE, inner), STATE, theme::MUTED);
            }
            let (places, others): (Vec<usize>, Vec<usize>) = group.iter().partition(|child| is_place(child));
            for part in [places, others] {
                let blocks = self.blocks(&part, inner, depth + 1);
                let limit = match flow {
                    Flow::Wide => inner,
                    Flow::Compact => compact_width(&blocks, page.width(), inner),
                };
                page.rows(blocks, limit);
            }
        }
    }

    /// Returns the space between the border of a box and its content: less for boxes that are deep inside others.
    fn padding(&self, depth: usize) -> f64 {
        match depth as f64 * 80.0 {
            used if used <= self.full => GAP,
            used if used <= 2.0 * self.full => 5.0,
            _ => 2.0,
        }
    }

    fn relation(&self, index: usize) -> Option<Relation> {
        self.scene.boxes[index].relation
    }

    /// Returns the states of a box as texts, and whether each is new.
    fn tokens(&self, index: usize) -> Vec<(String, bool)> {
        let change = self.states[index];
        let is_new = |text: &String| change.is_some_and(|change| change.gained.contains(text));
        let own = self.scene.boxes[index].states.iter().map(|state| {
            let suffix = if state.assumed { " (assumed)" } else { "" };
            (format!("{}{suffix}", state.text), is_new(&state.text))
        });
        let happened = change.filter(|own| self.shows_events || (only_events(own) && !self.moved[index]));
        let happened = happened.into_iter().flat_map(|change| &change.happened);
        own.chain(happened.map(|event| (event.clone(), true))).collect()
    }
}

/// Width that the content of a box tends to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Flow {
    /// About the ratio [`ASPECT`].
    Compact,
    /// All there is.
    Wide,
}

/// Returns the ranges of boxes that share a row.
fn rows_of(blocks: &[Block], limit: f64) -> Vec<Range<usize>> {
    let (mut rows, mut from, mut used) = (Vec::new(), 0, 0.0);
    for (index, block) in blocks.iter().enumerate() {
        let own = block.area.width;
        if index > from && used + GAP + own > limit + 0.01 {
            rows.push(from..index);
            (from, used) = (index, own);
        } else {
            used += own + if index > from { GAP } else { 0.0 };
        }
    }
    if from < blocks.len() {
        rows.push(from..blocks.len());
    }
    rows
}

/// Returns a width in which boxes have about the ratio [`ASPECT`] together, at least that of the content above them.
fn compact_width(blocks: &[Block], least: f64, most: f64) -> f64 {
    let widest = blocks.iter().map(|block| block.area.width).fold(0.0, f64::max);
    let total: f64 = blocks
        .iter()
        .map(|block| (block.area.width + GAP) * (block.area.height + GAP))
        .sum();
    (total * ASPECT).sqrt().max(widest).max(least).min(most)
}

/// Content that is added from top to bottom.
struct Page {
    left: f64,
    y: f64,
    /// The right end of the widest content.
    right: f64,
    labels: Vec<Line>,
    children: Vec<Block>,
}

impl Page {
    fn new(left: f64, top: f64) -> Self {
        Self {
            left,
            y: top,
            right: left,
            labels: Vec::new(),
            children: Vec::new(),
        }
    }

    fn space(&mut self, wanted: bool) {
        if wanted {
            self.y += 4.0;
        }
    }

    fn label(&mut self, text: String, font: Font, paint: Paint) {
        self.label_at(0.0, text, font, paint);
    }

    /// Adds a line of text with an indentation.
    fn label_at(&mut self, indent: f64, text: String, font: Font, paint: Paint) {
        self.put(self.left + indent, text, font, paint);
        self.y += font.line_height();
    }

    /// Adds a text at the current line.
    fn put(&mut self, x: f64, text: String, font: Font, paint: Paint) {
        self.right = self.right.max(x + width(&text, font));
        self.labels.push(Line {
            x,
            y: self.y + font.size + 1.0,
            text,
            font,
            paint,
        });
    }

    /// Adds short texts one after another, in at most [`STATE_LINES`] lines; a text longer than a line is broken.
    fn tokens(&mut self, tokens: &[(String, bool)], room: f64) {
        let (mut x, mut lines) = (0.0, 1);
        for (number, (text, new)) in tokens.iter().enumerate() {
            let paint = if *new { theme::CHANGE_INK } else { theme::MUTED };
            let font = if *new { Font { bold: true, ..STATE } } else { STATE };
            let is_last = number + 1 == tokens.len();
            let separator = if is_last { "" } else { " ·" };
            let whole = format!("{text}{separator}");
            if x > 0.0 && x + width(&whole, font) > room {
                if lines == STATE_LINES {
                    self.count_left_out(tokens.len() - number, room);
                    break;
                }
                (x, lines) = (0.0, lines + 1);
                self.y += STATE.line_height();
            }
            let parts = wrapped(&whole, font, room, STATE_LINES + 1 - lines);
            for (part, text) in parts.into_iter().enumerate() {
                if part > 0 {
                    (x, lines) = (0.0, lines + 1);
                    self.y += STATE.line_height();
                }
                let advance = width(&text, font) + width(" ", font);
                self.put(self.left + x, text, font, paint);
                x += advance;
            }
        }
        if !tokens.is_empty() {
            self.y += STATE.line_height();
        }
    }

    /// Adds the number of texts that are left out to the last line, which is shortened to make room for it.
    fn count_left_out(&mut self, mut left_out: usize, room: f64) {
        let right = self.left + room;
        let space = width(" ", STATE);
        loop {
            let count = format!("+{left_out}");
            let needed = space + width(&count, STATE);
            let Some(last) = self.labels.last_mut() else { return };
            let rest = right - last.x - needed;
            if rest >= width("…", last.font) {
                last.text = fitted(&last.text, last.font, rest);
                let x = last.x + width(&last.text, last.font) + space;
                return self.put(x, count, STATE, theme::MUTED);
            }
            if last.x <= self.left {
                last.text = fitted(&count, last.font, room);
                return;
            }
            self.labels.pop();
            left_out += 1;
        }
    }

    /// Returns the width of the content.
    fn width(&self) -> f64 {
        self.right - self.left
    }

    /// Adds boxes in rows. The places of a row get the same height.
    fn rows(&mut self, blocks: Vec<Block>, limit: f64) {
        let rows = rows_of(&blocks, limit);
        let mut blocks = blocks.into_iter();
        for row in rows {
            self.row(blocks.by_ref().take(row.len()).collect());
        }
    }

    fn row(&mut self, row: Vec<Block>) {
        let tallest = row.iter().map(|block| block.area.height).fold(0.0, f64::max);
        let mut x = self.left;
        for mut block in row {
            block.shift(x, self.y);
            if block.stretches {
                block.area.height = tallest;
            }
            x = block.area.right() + GAP;
            self.right = self.right.max(block.area.right());
            self.children.push(block);
        }
        self.y += tallest + GAP;
    }

    /// Returns the content with a border; the width is that of the content, at most `most`.
    fn into_block(mut self, index: Option<usize>, most: f64, pad: f64) -> Block {
        if !self.children.is_empty() && self.labels.iter().all(|label| label.y < self.y - GAP) {
            // The last row has its gap below it already.
            self.y -= GAP;
        }
        Block {
            index,
            area: Area {
                x: 0.0,
                y: 0.0,
                width: (self.right + pad).ceil().min(most),
                height: self.y + pad,
            },
            icon: false,
            stretches: false,
            labels: self.labels,
            children: self.children,
            left_out: 0,
        }
    }
}
