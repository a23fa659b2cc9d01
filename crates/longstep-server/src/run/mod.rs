//! Runs: plans that a robot carries out after a person approved them.

mod hosted;
mod queue;
mod robots;
mod view;
mod watch;
mod work;

pub(crate) use hosted::{HostedRun, Rights};
pub(crate) use queue::Queues;
pub use robots::{Body, OpenRobot, RobotEntry};
pub use view::{EndView, QuestionView, RunRecord, RunState, RunView};
pub(crate) use work::{Start, Task};
