//! The board of a run, drawn again and again below what is printed.

use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use longstep_core::execution::{Board, BoardLine, Event, Execution, Mark};
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

fn shown(mark: Mark) -> Line {
    match mark {
        Mark::New => composed!("{:MARK$}", "new".yellow()),
        Mark::UnderWay { tries: 0 | 1 } => composed!("{:MARK$}", "now".bold()),
        Mark::UnderWay { tries } => composed!("{:MARK$}", format!("try {tries}").yellow()),
        Mark::Done => composed!("{:MARK$}", "done".green()),
        Mark::Failed => composed!("{:MARK$}", "failed".red()),
        Mark::Undone => composed!("{:MARK$}", "undone".yellow()),
        Mark::Skipped => composed!("{:MARK$}", "skipped".dimmed()),
        _ => composed!("{:MARK$}", ""),
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
pub(super) struct DrawnBoard {
    steps: Board,
    begun: Instant,
    /// None while a person is asked.
    bar: Option<ProgressBar>,
}

impl DrawnBoard {
    /// Returns a board if lines can be drawn again.
    pub(super) fn new() -> Option<Self> {
        output::can_draw_board().then(|| Self {
            steps: Board::default(),
            begun: Instant::now(),
            bar: None,
        })
    }

    pub(super) fn take(&mut self, execution: &Execution, event: &Event) {
        self.steps.take(execution, event);
    }

    /// Draws the board below what is printed from now on.
    pub(super) fn draw(&mut self) {
        if self.steps.steps().is_empty() {
            return;
        }
        let (width, height) = output::terminal_size();
        let mut lines = vec![composed!("{}", self.fraction().bold())];
        // The last column of a terminal breaks the line.
        lines.extend(self.lines(width.saturating_sub(1), height.saturating_sub(FREE_LINES)));
        let begun = self.begun;
        output::board(self.bar.get_or_insert_with(|| drawn(begun)), &lines);
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
        for line in self.lines(width.saturating_sub(1), usize::MAX) {
            print_line!("{line}");
        }
        if !self.steps.steps().is_empty() {
            let seconds = self.begun.elapsed().as_secs();
            print_line!("{:MARK$}{}", "", format!("{}, {seconds} s", self.fraction()).dimmed());
        }
    }

    /// The steps that are done, of those that are to be done.
    fn fraction(&self) -> String {
        let (done, all) = self.steps.progress();
        if self.steps.is_open_ended() {
            output::counted(done, "step") + " done"
        } else {
            format!("{done} of {} done", output::counted(all, "step"))
        }
    }

    /// The lines for a terminal of a width; of more than `most` those around the first open step.
    fn lines(&self, width: usize, most: usize) -> Vec<Line> {
        let is_open = |place: &BoardLine| match place {
            BoardLine::Step { entry, .. } => self.steps.steps()[*entry].mark.is_open(),
            BoardLine::Beside(cells) => cells
                .iter()
                .flatten()
                .any(|entry| self.steps.steps()[*entry].mark.is_open()),
            _ => false,
        };
        let all = self.steps.lines().len();
        let most = most.max(LEAST_LINES);
        let (from, to) = if all <= most {
            (0, all)
        } else {
            let open = self.steps.lines().iter().position(is_open).unwrap_or(all);
            let from = open.saturating_sub(BEFORE).min(all - most);
            (from, from + most)
        };
        let mut lines = Vec::new();
        if from > 0 {
            lines.push(composed!("{:MARK$}{}", "", format!("{from} more before").dimmed()));
        }
        lines.extend(
            self.steps.lines()[from..to]
                .iter()
                .flat_map(|place| self.line(place, width)),
        );
        if to < all {
            lines.push(composed!("{:MARK$}{}", "", format!("{} more", all - to).dimmed()));
        }
        lines
    }

    fn line(&self, place: &BoardLine, width: usize) -> Vec<Line> {
        let room = width.saturating_sub(MARK);
        match place {
            BoardLine::Step { depth, entry } => {
                let indent = 2 * depth;
                vec![self.cell(*entry, indent, room.saturating_sub(indent))]
            }
            BoardLine::Text { depth, text } => {
                let indent = 2 * depth;
                let text = fitted(text, room.saturating_sub(indent));
                vec![composed!("{:MARK$}{:indent$}{}", "", "", text.dimmed())]
            }
            BoardLine::Heads(names) if is_beside(names.len(), width) => {
                let column = column(names.len(), width);
                let mut line = Line::default();
                for name in names {
                    let name = fitted(name, column - MARK);
                    line.push(format_args!("{:MARK$}", ""));
                    line.push(format_args!("{:1$}", name.bold(), column - MARK));
                }
                vec![line]
            }
            BoardLine::Heads(names) => vec![composed!("{:MARK$}{}", "", fitted(&names.join(" and "), room).dimmed())],
            BoardLine::Beside(cells) if is_beside(cells.len(), width) => {
                let column = column(cells.len(), width);
                let mut line = Line::default();
                for cell in cells {
                    match cell {
                        Some(entry) => {
                            let cell = self.cell(*entry, 0, column - MARK - 1);
                            let filled = fitted(&self.steps.steps()[*entry].text, column - MARK - 1)
                                .chars()
                                .count();
                            let padding = (column - MARK).saturating_sub(filled);
                            line.push(format_args!("{cell}{:padding$}", ""));
                        }
                        None => line.push(format_args!("{:column$}", "")),
                    }
                }
                vec![line]
            }
            BoardLine::Beside(cells) => {
                let cells = cells.iter().flatten();
                cells
                    .map(|entry| self.cell(*entry, 2, room.saturating_sub(2)))
                    .collect()
            }
        }
    }

    fn cell(&self, entry: usize, indent: usize, room: usize) -> Line {
        let entry = &self.steps.steps()[entry];
        let text = fitted(&entry.text, room);
        let mark = shown(entry.mark);
        match entry.mark {
            Mark::UnderWay { .. } => composed!("{mark}{:indent$}{}", "", text.bold()),
            Mark::Waiting | Mark::New => composed!("{mark}{:indent$}{text}", ""),
            _ => composed!("{mark}{:indent$}{}", "", text.dimmed()),
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
