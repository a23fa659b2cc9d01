//! The board of a run: the steps of the plan in force with their states, and what happened to earlier ones.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Effect, Event, Execution};
use longstep_search::schedule::{Row as TimetableRow, timetable};
use longstep_verify::plan::{Lane, Node, OutlineLine, StepId, outline};

/// The state of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Mark {
    /// It is not begun.
    Waiting,
    /// A step of a change of the plan, not begun.
    New,
    /// A robot performs it, for the `tries`-th time.
    UnderWay {
        /// The number of times that it was begun.
        tries: u32,
    },
    /// It is done.
    Done,
    /// The robot could not do it.
    Failed,
    /// The world no longer shows its effect: it is done again.
    Undone,
    /// It is needless now.
    Skipped,
}

impl Mark {
    /// Returns true for a step that is neither done nor given up.
    pub fn is_open(self) -> bool {
        matches!(self, Self::Waiting | Self::New | Self::UnderWay { .. })
    }
}

/// A step on a board.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct BoardStep {
    /// Its number in the plan in force, from 0; none for a step of an earlier plan.
    pub step: Option<usize>,
    /// The action with all its arguments, as events name it.
    pub call: String,
    /// The step for a person.
    pub text: String,
    /// Its state.
    pub mark: Mark,
    #[serde(skip)]
    tries: u32,
}

/// A line of a board. Entries are indices of [`Board::steps`].
///
/// Exhaustive on purpose: whoever draws a board has to draw every line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BoardLine {
    /// A step within so many branches and loops.
    Step {
        /// The number of branches and loops around it.
        depth: usize,
        /// The step.
        entry: usize,
    },
    /// A header such as `else`.
    Text {
        /// The number of branches and loops around it.
        depth: usize,
        /// The header.
        text: String,
    },
    /// The names of the lanes that are beside each other below.
    Heads(Vec<String>),
    /// Steps at the same time, one for each lane.
    Beside(Vec<Option<usize>>),
}

/// The steps of a run with their states.
///
/// ```
/// use longstep_core::execution::{Aim, Approval, Board, Execution, Mark, Need, Settings};
/// # use longstep_core::environment::Observation;
/// # use longstep_core::{domain, environment, plan, verify::check_file};
/// # let household = domain::shipped("household").unwrap().unwrap();
/// # let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// # let world = environment::parse(&household, "env.json", text).unwrap();
/// # let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// # let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// # let seen: Observation = serde_json::from_str(r#"{"states": {"<pen>": "on_something(<desk>)"}}"#).unwrap();
/// let settings = Settings::default().with_approval(Approval::Never);
/// let mut execution = Execution::new(&plan, &Aim::Endings, settings).unwrap();
/// let mut board = Board::default();
/// assert!(matches!(execution.next_need(), Need::Observe));
/// execution.observed(&seen).unwrap();
/// let Need::Perform(order) = execution.next_need() else { panic!() };
/// for event in execution.take_events() {
///     board.take(&execution, &event);
/// }
/// assert_eq!((board.steps().len(), board.steps()[0].mark), (3, Mark::UnderWay { tries: 1 }));
/// # drop(order);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Board {
    entries: Vec<BoardStep>,
    places: Vec<BoardLine>,
    /// The entries of the orders under way.
    orders: BTreeMap<u64, usize>,
    /// True if the number of steps that will be done depends on branches or loops.
    is_open_ended: bool,
    /// True if the plan in force is not the one of the entries any more.
    is_stale: bool,
    is_changed: bool,
}

impl Board {
    /// Returns a board with the steps of the plan in force.
    pub fn of(execution: &Execution) -> Self {
        let mut board = Self::default();
        board.rebuild(execution);
        board
    }

    /// Returns the steps.
    pub fn steps(&self) -> &[BoardStep] {
        &self.entries
    }

    /// Returns the lines, in order.
    pub fn lines(&self) -> &[BoardLine] {
        &self.places
    }

    /// Returns true if the number of steps that will be done depends on branches or loops.
    pub fn is_open_ended(&self) -> bool {
        self.is_open_ended
    }

    /// Returns the numbers of steps that are done, and of steps that are to be done.
    pub fn progress(&self) -> (usize, usize) {
        let marks = self.entries.iter().map(|entry| entry.mark);
        let done = marks.clone().filter(|mark| matches!(mark, Mark::Done | Mark::Skipped));
        let done = done.count();
        let all = marks.filter(|mark| !matches!(mark, Mark::Undone | Mark::Failed));
        (done, all.count())
    }

    /// Takes the steps of the plan in force; what has happened to earlier ones stays above them.
    fn rebuild(&mut self, execution: &Execution) {
        let kept: Vec<BoardStep> = self
            .entries
            .drain(..)
            .filter(|entry| !matches!(entry.mark, Mark::Waiting | Mark::New))
            .map(|entry| BoardStep { step: None, ..entry })
            .collect();
        self.places = (0..kept.len())
            .map(|entry| BoardLine::Step { depth: 0, entry })
            .collect();
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
        let mut lines = outline(world, plan).into_iter().peekable();
        while let Some(line) = lines.next() {
            if let Some(step) = line.step {
                let entry = self.entry(execution, step, line.explanation, mark);
                let depth = line.depth;
                self.places.push(BoardLine::Step { depth, entry });
                continue;
            }
            let lanes = match line.depth {
                0 if line.text == "at the same time" => parallel.next(),
                _ => None,
            };
            let Some(lanes) = lanes else {
                let OutlineLine { depth, text, .. } = line;
                self.places.push(BoardLine::Text { depth, text });
                continue;
            };
            let names = lanes.iter().map(|lane| world.entity(lane.actor).name.clone());
            self.places.push(BoardLine::Heads(names.collect()));
            let first = self.entries.len();
            while let Some(inner) = lines.next_if(|inner| inner.depth > 0) {
                if let Some(step) = inner.step {
                    self.entry(execution, step, inner.explanation, mark);
                }
            }
            self.beside(lanes, first);
        }
    }

    /// Places the steps of lanes, whose entries begin at `first`, beside each other.
    fn beside(&mut self, lanes: &[Lane], first: usize) {
        let entries = &self.entries[first..];
        let entry = |id: StepId| entries.iter().position(|entry| entry.step == Some(id.index()));
        let rows = timetable(lanes).into_iter().filter_map(|row| match row {
            TimetableRow::Unit(steps) => Some(steps),
            _ => None,
        });
        let rows: Vec<BoardLine> = rows
            .map(|steps| BoardLine::Beside(steps.iter().map(|id| Some(first + entry((*id)?)?)).collect()))
            .collect();
        self.places.extend(rows);
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
    pub fn take(&mut self, execution: &Execution, event: &Event) {
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
}
