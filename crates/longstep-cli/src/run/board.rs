//! The board of a run: the steps of the plan with their states, drawn again and again below what is printed.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use longstep_core::execution::{Effect, Event, Execution};
use longstep_core::plan::{Node, StepId, outline};
use longstep_core::schedule::{Row as TimetableRow, timetable};
use longstep_core::visible;

use crate::output::{self, Line, Style, composed, print_line};

/// Characters for the state of a step, and the space after it.
const MARK: usize = 8;
/// The least characters for a step beside another one.
const COLUMN: usize = 24;
/// Lines of the terminal that the board leaves free.
const FREE_LINES: usize = 6;
/// The fewest lines of steps.
const LEAST_LINES: usize = 3;
/// Steps before the first open one that are still shown.
const BEFORE: usize = 2;

/// The state of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mark {
    Waiting,
    /// A step of a change of the plan, not begun.
    New,
    UnderWay {
        tries: u32,
    },
    Done,
    Failed,
    /// The world no longer shows its effect: it is done again.
    Undone,
    /// It is needless now.
    Skipped,
}

impl Mark {
    fn shown(self) -> Line {
        match self {
            Self::Waiting => composed!("{:MARK$}", ""),
            Self::New => composed!("{:MARK$}", "new".yellow()),
            Self::UnderWay { tries: 0 | 1 } => composed!("{:MARK$}", "now".bold()),
            Self::UnderWay { tries } => composed!("{:MARK$}", format!("try {tries}").yellow()),
            Self::Done => composed!("{:MARK$}", "done".green()),
            Self::Failed => composed!("{:MARK$}", "failed".red()),
            Self::Undone => composed!("{:MARK$}", "undone".yellow()),
            Self::Skipped => composed!("{:MARK$}", "skipped".dimmed()),
        }
    }

    /// Returns true for a step that is neither done nor given up.
    fn is_open(self) -> bool {
        matches!(self, Self::Waiting | Self::New | Self::UnderWay { .. })
    }
}

/// A step of the plan.
#[derive(Debug, Clone)]
struct BoardStep {
    /// Its number in the plan in force, from 0; none for a step of an earlier plan.
    step: Option<usize>,
    /// The action with all its arguments, as events name it.
    call: String,
    text: String,
    mark: Mark,
    tries: u32,
}

/// A line of the board.
#[derive(Debug, Clone)]
enum Place {
    /// A step, with the branches and loops around it.
    Step { depth: usize, entry: usize },
    /// A header such as `else`.
    Text { depth: usize, text: String },
    /// The names of the lanes that are beside each other below.
    Heads(Vec<String>),
    /// Steps at the same time, one for each lane.
    Beside(Vec<Option<usize>>),
}

/// The steps of a run.
#[derive(Debug, Default)]
struct Steps {
    entries: Vec<BoardStep>,
    places: Vec<Place>,
    /// The entries of the orders under way.
    orders: BTreeMap<u64, usize>,
    /// True if the number of steps that will be done depends on branches or loops.
    is_open_ended: bool,
    /// True if the plan in force is not the one of the entries any more.
    is_stale: bool,
    is_changed: bool,
}

impl Steps {
    /// Takes the steps of the plan in force; what has happened to earlier ones stays above them.
    fn rebuild(&mut self, execution: &Execution) {
        let kept: Vec<BoardStep> = self
            .entries
            .drain(..)
            .filter(|entry| !matches!(entry.mark, Mark::Waiting | Mark::New))
            .map(|entry| BoardStep { step: None, ..entry })
            .collect();
        self.places = (0..kept.len()).map(|entry| Place::Step { depth: 0, entry }).collect();
        self.entries = kept;
        self.orders.clear();
        let mark = if std::mem::take(&mut self.is_changed) {
            Mark::New
        } else {
            Mark::Waiting
        };
        self.append(execution, mark);
        self.is_stale = false;
    }

    fn append(&mut self, execution: &Execution, mark: Mark) {
        let (world, plan) = (execution.plan().world(), execution.plan().plan());
        let mut parallel = plan.body().iter().filter_map(|node| match node {
            Node::Parallel { lanes } => Some(lanes),
            _ => None,
        });
        self.is_open_ended = plan
            .body()
            .iter()
            .any(|node| !matches!(node, Node::Step(_) | Node::Parallel { .. } | Node::Remark(_)));
        let lines = outline(world, plan);
        let mut lines = lines.into_iter().peekable();
        while let Some(line) = lines.next() {
            let Some(step) = line.step else {
                let lanes = match line.depth {
                    0 if line.text == "at the same time" => parallel.next(),
                    _ => None,
                };
                let Some(lanes) = lanes else {
                    self.places.push(Place::Text {
                        depth: line.depth,
                        text: line.text,
                    });
                    continue;
                };
                let names = lanes.iter().map(|lane| world.entity(lane.actor).name.clone());
                self.places.push(Place::Heads(names.collect()));
                let first = self.entries.len();
                while let Some(inner) = lines.next_if(|inner| inner.depth > 0) {
                    if let Some(step) = inner.step {
                        self.entry(execution, step, inner.explanation, mark);
                    }
                }
                let place = |entries: &[BoardStep], step: usize| {
                    let found = entries[first..].iter().position(|entry| entry.step == Some(step));
                    found.map(|index| first + index)
                };
                for row in timetable(lanes) {
                    if let TimetableRow::Unit(steps) = row {
                        let cells = steps.iter().map(|id| place(&self.entries, (*id)?.index()));
                        self.places.push(Place::Beside(cells.collect()));
                    }
                }
                continue;
            };
            let entry = self.entry(execution, step, line.explanation, mark);
            self.places.push(Place::Step {
                depth: line.depth,
                entry,
            });
        }
    }

    fn entry(&mut self, execution: &Execution, step: usize, text: String, mark: Mark) -> usize {
        let plan = execution.plan();
        let (world, own) = (plan.world(), plan.plan().step(StepId::new(step)));
        let arguments = own
            .arguments
            .iter()
            .map(|entity| world.entity(*entity).identifier.as_str());
        let arguments: Vec<&str> = arguments.collect();
        self.entries.push(BoardStep {
            step: Some(step),
            call: format!("{}({})", world.domain().action(own.action).name, arguments.join(", ")),
            text,
            mark,
            tries: 0,
        });
        self.entries.len() - 1
    }

    /// Takes an event of the execution.
    fn take(&mut self, execution: &Execution, event: &Event) {
        match event {
            Event::Ordered { order, step, .. } => {
                if self.is_stale || self.entries.is_empty() {
                    self.rebuild(execution);
                }
                self.begin(*order, step.saturating_sub(1));
            }
            Event::Performed { order, .. } | Event::Found { order } | Event::Judged { order, done: true } => {
                self.mark(*order, Mark::Done);
            }
            Event::Failed { order, .. } | Event::Judged { order, done: false } => self.mark(*order, Mark::Failed),
            Event::Assessed { effect, steps, .. } => self.assess(*effect, steps),
            Event::Changed { .. } => (self.is_stale, self.is_changed) = (true, true),
            _ => {}
        }
    }

    fn begin(&mut self, order: u64, step: usize) {
        let Some(index) = self.entries.iter().position(|entry| entry.step == Some(step)) else {
            return;
        };
        // A run that was resumed has done the steps before this one.
        if self.orders.is_empty() && !self.is_open_ended {
            let earlier = self.entries[..index].iter_mut();
            for entry in earlier.filter(|entry| entry.mark == Mark::Waiting && entry.step.is_some_and(|own| own < step))
            {
                entry.mark = Mark::Done;
            }
        }
        let entry = &mut self.entries[index];
        entry.tries += 1;
        entry.mark = Mark::UnderWay { tries: entry.tries };
        self.orders.insert(order, index);
    }

    fn mark(&mut self, order: u64, mark: Mark) {
        if let Some(entry) = self.orders.get(&order).and_then(|index| self.entries.get_mut(*index)) {
            entry.mark = mark;
        }
    }

    fn assess(&mut self, effect: Effect, steps: &[String]) {
        let (from, to) = match effect {
            Effect::Helpful => (None, Mark::Skipped),
            Effect::Undone => (Some(Mark::Done), Mark::Undone),
            Effect::Harmless | Effect::Harmful => return,
        };
        self.is_stale = true;
        for text in steps {
            let fits = |entry: &&mut BoardStep| {
                let is_from = match from {
                    Some(mark) => entry.mark == mark,
                    None => entry.mark.is_open(),
                };
                is_from && entry.call == *text
            };
            let mut entries: Box<dyn Iterator<Item = &mut BoardStep>> = match from {
                Some(_) => Box::new(self.entries.iter_mut().rev()),
                None => Box::new(self.entries.iter_mut()),
            };
            if let Some(entry) = entries.find(fits) {
                entry.mark = to;
            }
        }
    }

    /// The steps that are done, of those that are to be done.
    fn fraction(&self) -> String {
        let marks = self.entries.iter().map(|entry| entry.mark);
        let done = marks
            .clone()
            .filter(|mark| matches!(mark, Mark::Done | Mark::Skipped))
            .count();
        let all = marks
            .filter(|mark| !matches!(mark, Mark::Undone | Mark::Failed))
            .count();
        if self.is_open_ended {
            output::counted(done, "step") + " done"
        } else {
            format!("{done} of {} done", output::counted(all, "step"))
        }
    }

    /// The lines for a terminal of a width; of more than `most` those around the first open step.
    fn lines(&self, width: usize, most: usize) -> Vec<Line> {
        let is_open = |place: &Place| match place {
            Place::Step { entry, .. } => self.entries[*entry].mark.is_open(),
            Place::Beside(cells) => cells.iter().flatten().any(|entry| self.entries[*entry].mark.is_open()),
            _ => false,
        };
        let all = self.places.len();
        let most = most.max(LEAST_LINES);
        let (from, to) = if all <= most {
            (0, all)
        } else {
            let open = self.places.iter().position(is_open).unwrap_or(all);
            let from = open.saturating_sub(BEFORE).min(all - most);
            (from, from + most)
        };
        let mut lines = Vec::new();
        if from > 0 {
            lines.push(composed!("{:MARK$}{}", "", format!("{from} more before").dimmed()));
        }
        lines.extend(self.places[from..to].iter().flat_map(|place| self.line(place, width)));
        if to < all {
            lines.push(composed!("{:MARK$}{}", "", format!("{} more", all - to).dimmed()));
        }
        lines
    }

    fn line(&self, place: &Place, width: usize) -> Vec<Line> {
        let room = width.saturating_sub(MARK);
        match place {
            Place::Step { depth, entry } => {
                let indent = 2 * depth;
                vec![self.cell(*entry, indent, room.saturating_sub(indent))]
            }
            Place::Text { depth, text } => {
                let indent = 2 * depth;
                let text = fitted(text, room.saturating_sub(indent));
                vec![composed!("{:MARK$}{:indent$}{}", "", "", text.dimmed())]
            }
            Place::Heads(names) if is_beside(names.len(), width) => {
                let column = column(names.len(), width);
                let mut line = Line::default();
                for name in names {
                    let name = fitted(name, column - MARK);
                    line.push(format_args!("{:MARK$}", ""));
                    line.push(format_args!("{:1$}", name.bold(), column - MARK));
                }
                vec![line]
            }
            Place::Heads(names) => vec![composed!("{:MARK$}{}", "", fitted(&names.join(" and "), room).dimmed())],
            Place::Beside(cells) if is_beside(cells.len(), width) => {
                let column = column(cells.len(), width);
                let mut line = Line::default();
                for cell in cells {
                    match cell {
                        Some(entry) => {
                            let cell = self.cell(*entry, 0, column - MARK - 1);
                            let filled = fitted(&self.entries[*entry].text, column - MARK - 1).chars().count();
                            let padding = (column - MARK).saturating_sub(filled);
                            line.push(format_args!("{cell}{:padding$}", ""));
                        }
                        None => line.push(format_args!("{:column$}", "")),
                    }
                }
                vec![line]
            }
            Place::Beside(cells) => {
                let cells = cells.iter().flatten();
                cells
                    .map(|entry| self.cell(*entry, 2, room.saturating_sub(2)))
                    .collect()
            }
        }
    }

    fn cell(&self, entry: usize, indent: usize, room: usize) -> Line {
        let entry = &self.entries[entry];
        let text = fitted(&entry.text, room);
        let mark = entry.mark.shown();
        match entry.mark {
            Mark::UnderWay { .. } => composed!("{mark}{:indent$}{}", "", text.bold()),
            Mark::Waiting | Mark::New => composed!("{mark}{:indent$}{text}", ""),
            _ => composed!("{mark}{:indent$}{}", "", text.dimmed()),
        }
    }
}

/// The characters for each of several lanes.
fn column(lanes: usize, width: usize) -> usize {
    width / lanes.max(1)
}

/// Returns true if lanes fit beside each other.
fn is_beside(lanes: usize, width: usize) -> bool {
    column(lanes, width) >= MARK + COLUMN
}

/// Cuts a text to a number of characters.
fn fitted(text: &str, room: usize) -> String {
    let text = visible::line(text);
    match text.char_indices().nth(room) {
        None => text.into_owned(),
        Some(_) => text.chars().take(room.saturating_sub(1)).chain(['…']).collect(),
    }
}

/// The board of a run in a terminal.
pub(super) struct Board {
    steps: Steps,
    begun: Instant,
    /// None while a person is asked.
    bar: Option<ProgressBar>,
}

impl Board {
    /// Returns a board if lines can be drawn again.
    pub(super) fn new() -> Option<Self> {
        output::can_draw_board().then(|| Self {
            steps: Steps::default(),
            begun: Instant::now(),
            bar: None,
        })
    }

    pub(super) fn take(&mut self, execution: &Execution, event: &Event) {
        self.steps.take(execution, event);
    }

    /// Draws the board below what is printed from now on.
    pub(super) fn draw(&mut self) {
        if self.steps.entries.is_empty() {
            return;
        }
        let begun = self.begun;
        let bar = self.bar.get_or_insert_with(|| drawn(begun));
        let (width, height) = output::terminal_size();
        let mut lines = vec![composed!("{}", self.steps.fraction().bold())];
        // The last column of a terminal breaks the line.
        lines.extend(
            self.steps
                .lines(width.saturating_sub(1), height.saturating_sub(FREE_LINES)),
        );
        output::board(bar, &lines);
    }

    /// Removes the board from the terminal, while a person is asked.
    pub(super) fn pause(&mut self) {
        if let Some(bar) = self.bar.take() {
            output::end_progress(&bar);
        }
    }

    /// Ends the board: all its steps are printed.
    pub(super) fn end(&mut self) {
        self.pause();
        let (width, _) = output::terminal_size();
        for line in self.steps.lines(width.saturating_sub(1), usize::MAX) {
            print_line!("{line}");
        }
        if !self.steps.entries.is_empty() {
            let seconds = self.begun.elapsed().as_secs();
            print_line!(
                "{:MARK$}{}",
                "",
                format!("{}, {seconds} s", self.steps.fraction()).dimmed()
            );
        }
    }
}

fn drawn(begun: Instant) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed_time}{msg}") {
        let elapsed = move |_: &ProgressState, text: &mut dyn std::fmt::Write| {
            // Writing to a line never fails.
            let _ = write!(text, "{:>4} s ", begun.elapsed().as_secs());
        };
        bar.set_style(style.with_key("elapsed_time", elapsed));
    }
    output::begin_progress(&bar);
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}
