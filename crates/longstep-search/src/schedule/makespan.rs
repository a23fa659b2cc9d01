//! The makespan of plans.

use std::fmt;

use longstep_verify::plan::lanes::Remaining;
use longstep_verify::plan::{Lane, Node, Plan, StepId, Test, tree};

/// The makespan of a plan, in units of time: every step takes one unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Makespan {
    /// The exact makespan.
    Exact(u64),
    /// The makespan with one iteration of every loop whose number of iterations is unknown; each further one adds to
    /// it.
    AtLeast(u64),
}

impl Makespan {
    const NOTHING: Self = Self::Exact(0);

    /// Returns the number of units.
    pub fn units(self) -> u64 {
        match self {
            Self::Exact(units) | Self::AtLeast(units) => units,
        }
    }

    fn with(self, other: Self, units: impl Fn(u64, u64) -> u64) -> Self {
        let units = units(self.units(), other.units());
        match (self, other) {
            (Self::Exact(_), Self::Exact(_)) => Self::Exact(units),
            _ => Self::AtLeast(units),
        }
    }

    fn then(self, other: Self) -> Self {
        self.with(other, u64::saturating_add)
    }

    fn longer(self, other: Self) -> Self {
        self.with(other, u64::max)
    }
}

impl fmt::Display for Makespan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = if self.units() == 1 { "" } else { "s" };
        match self {
            Self::Exact(units) => write!(f, "{units} unit{plural}"),
            Self::AtLeast(units) => write!(f, "at least {units} unit{plural}"),
        }
    }
}

/// Returns the makespan of a plan in the worst case: lanes run in parallel and wait at synchronisation points, the
/// longer of two branches counts, and sensing is a step like any other.
///
/// ```
/// use longstep_search::schedule::{Makespan, makespan};
/// use longstep_verify::plan::Plan;
/// assert_eq!(makespan(&Plan::default()), Makespan::Exact(0));
/// ```
pub fn makespan(plan: &Plan) -> Makespan {
    let nodes = tree::fold(plan.body(), &|node, [first, second]| match node {
        Node::Step(_) => Makespan::Exact(1),
        Node::If { condition, .. } => of_test(condition).then(in_turn(first).longer(in_turn(second))),
        Node::While { condition, .. } => {
            let turn = of_test(condition).then(in_turn(first)).then(of_test(condition));
            Makespan::AtLeast(turn.units())
        }
        Node::Repeat { times, .. } => in_turn(first).with(Makespan::Exact(u64::from(*times)), u64::saturating_mul),
        Node::Parallel { lanes } => Makespan::Exact(of_lanes(lanes)),
        Node::Remark(_) => Makespan::NOTHING,
    });
    in_turn(nodes)
}

fn in_turn(parts: Vec<Makespan>) -> Makespan {
    parts.into_iter().fold(Makespan::NOTHING, Makespan::then)
}

fn of_test(test: &Test) -> Makespan {
    Makespan::Exact(test.steps().count() as u64)
}

fn of_lanes(lanes: &[Lane]) -> u64 {
    let units = timetable(lanes).into_iter().filter(|row| matches!(row, Row::Unit(_)));
    units.count() as u64
}

/// A row of a [`timetable`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Row {
    /// One unit of time: the step of each lane; none for a lane that waits or is done.
    Unit(Vec<Option<StepId>>),
    /// A synchronisation point that lanes pass.
    Sync {
        /// The name of the synchronisation point.
        name: String,
        /// The indexes of the lanes.
        lanes: Vec<usize>,
    },
}

/// Returns the timetable of lanes in which each step takes one unit and starts as early as possible. In a deadlock,
/// which verification reports, the first waiting lane continues.
///
/// ```
/// use longstep_search::schedule::{Row, timetable};
/// use longstep_verify::plan::{Lane, LaneItem, StepId};
/// use longstep_model::environment::EntityId;
/// let step = |number| LaneItem::Step(StepId::new(number));
/// let lane = |actor, items| Lane { actor: EntityId::new(actor), items };
/// let sync = || LaneItem::Sync("handed over".to_owned());
/// let rows = timetable(&[lane(0, vec![step(0), sync()]), lane(1, vec![sync(), step(1)])]);
/// assert_eq!(rows.len(), 3);
/// assert_eq!(rows[2], Row::Unit(vec![None, Some(StepId::new(1))]));
/// ```
pub fn timetable(lanes: &[Lane]) -> Vec<Row> {
    let mut remaining = Remaining::of(lanes);
    let mut rows = Vec::new();
    loop {
        while let Some((name, lanes)) = remaining.next_sync() {
            let name = name.to_owned();
            rows.push(Row::Sync { name, lanes });
        }
        let steps = remaining.next_steps();
        if steps.iter().all(Option::is_none) {
            return rows;
        }
        rows.push(Row::Unit(steps));
    }
}
