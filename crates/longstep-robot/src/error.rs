//! Errors of robots.

use std::time::Duration;

use crate::order::Handle;

/// An error of a robot. A step that failed is no error: see [`Progress::Failed`](crate::Progress::Failed).
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// The robot cannot be started or reached.
    #[error("cannot start the robot `{robot}`: {reason}")]
    Unreachable {
        /// The robot, as the user named it.
        robot: String,
        /// The error of the operating system or of the connection.
        reason: String,
    },
    /// The robot speaks another version of the protocol.
    #[error("the robot speaks protocol version {found}, but version {expected} is required")]
    Incompatible {
        /// The version of this program.
        expected: u64,
        /// The version of the robot.
        found: String,
    },
    /// The robot has no such action. Nothing was sent.
    #[error("the robot cannot perform `{action}`")]
    Unsupported {
        /// The name of the action.
        action: String,
    },
    /// The robot performs as many orders as it can. Nothing was sent.
    #[error("the robot is busy: it performs at most {limit} orders at the same time")]
    Busy {
        /// [`Description::parallel`](crate::Description::parallel).
        limit: usize,
    },
    /// An order cannot be written as a message. Nothing was sent.
    #[error("step {step} cannot be sent: {reason}")]
    InvalidOrder {
        /// The number of the step.
        step: usize,
        /// The reason.
        reason: String,
    },
    /// No order with this handle is under way: it was never started, or its end was reported already.
    #[error("no order {} is under way", .0.number())]
    UnknownHandle(Handle),
    /// The robot has no observations. Nothing was sent.
    #[error("the robot does not observe")]
    NoObservation,
    /// The robot is gone: its program ended, or its connection closed.
    #[error("the robot is gone: {reason}{}", last_words(.messages))]
    Gone {
        /// How it ended.
        reason: String,
        /// The last lines that it wrote to its standard error; empty if there are none.
        messages: String,
    },
    /// The robot did not answer in time.
    #[error("the robot did not answer within {} s: {what}", .limit.as_secs_f64())]
    TimedOut {
        /// The unanswered request: `step 4`, `observe`.
        what: String,
        /// The timeout.
        limit: Duration,
    },
    /// The robot broke the protocol: it sent what is no message, or a message that nothing asked for.
    #[error("the robot broke the protocol: {reason}")]
    Protocol {
        /// The message, shortened, and the expected form.
        reason: String,
    },
    /// The robot refused a request that is not a step.
    #[error("the robot refused `{method}`: {reason}")]
    Refused {
        /// The request.
        method: String,
        /// The robot's message.
        reason: String,
    },
    /// The robot refused a step before it moved: the goal was rejected, or it does not fit the server.
    #[error("the robot rejected step {step}: {reason}")]
    Rejected {
        /// The number of the step.
        step: usize,
        /// The robot's message.
        reason: String,
    },
    /// A step ended in a way after which the robot is not to go on: somebody else cancelled it, for example.
    #[error("step {step} was {how} by the robot: {reason}")]
    GoalEnded {
        /// The number of the step.
        step: usize,
        /// `aborted` or `cancelled`.
        how: &'static str,
        /// The robot's message.
        reason: String,
    },
    /// A part of the robot does not answer. Nothing was sent.
    #[error("no {kind} `{name}` answers: {reason}")]
    Missing {
        /// `action server`, `service` or `topic`.
        kind: &'static str,
        /// Its name.
        name: String,
        /// The message of the bridge, or how long it was silent.
        reason: String,
    },
    /// A part of the robot has another interface. Nothing was sent.
    #[error("`{name}` does not have the type `{expected}`: {reason}")]
    WrongType {
        /// The server.
        name: String,
        /// The type in the configuration.
        expected: String,
        /// The message of the bridge.
        reason: String,
    },
    /// The bridge passes no message on while a goal is under way: no heartbeat reaches the robot, and no cancellation.
    #[error("the bridge passes nothing on while a goal is under way: {reason}")]
    Blocked {
        /// The sign of it: a parameter of the bridge, or heartbeats that did not come back.
        reason: String,
    },
    /// Another program drives the robot. Nothing was sent.
    #[error("another program drives the robot `{robot}`")]
    InUse {
        /// The robot, or the part of it.
        robot: String,
    },
    /// The program of an earlier run, whose Longstep ended without a stop, still drives the robot. Nothing was sent.
    #[error("the robot `{robot}` is still driven by the program of an earlier run: {program}")]
    Abandoned {
        /// The robot, or the part of it.
        robot: String,
        /// The processes of the program, and its command.
        program: String,
    },
    /// A goal that this run did not send is under way at a part of the robot. Nothing was sent, or the goal did not end after it
    /// was cancelled.
    #[error("`{server}` has a goal under way: {reason}")]
    UnderWay {
        /// The action server.
        server: String,
        /// Where it may come from, or why it did not end.
        reason: String,
    },
    /// The robot was stopped, so that nothing more is sent to it.
    #[error("the robot was stopped")]
    Stopped,
}

fn last_words(messages: &str) -> String {
    match messages {
        "" => String::new(),
        lines => format!("; its last messages:\n{lines}"),
    }
}

impl RobotError {
    /// Returns true if the robot is stopped and accepts nothing more. After other errors it is as it was before the
    /// call.
    pub fn is_final(&self) -> bool {
        !matches!(
            self,
            Self::Unsupported { .. }
                | Self::Busy { .. }
                | Self::InvalidOrder { .. }
                | Self::UnknownHandle(_)
                | Self::NoObservation
                | Self::Refused { .. }
        )
    }

    /// Returns the next step for the user, if there is one.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Unreachable { robot, .. } if robot.starts_with("ws://") => {
                Some("start the bridge (rosbridge_server), and check `url` in robot.toml")
            }
            Self::Unreachable { .. } => Some("check the command or the address, and that the robot's program runs"),
            Self::Incompatible { .. } => Some("update the robot's program or longstep"),
            Self::Unsupported { .. } => Some("plan without this action, or add it to the robot's program"),
            Self::TimedOut { .. } => {
                Some("if it takes that long, raise `timeouts` in robot.toml or in the robot's `initialize`")
            }
            Self::Rejected { .. } | Self::WrongType { .. } => {
                Some("`longstep robot check robot.toml` compares it with the servers")
            }
            Self::Missing { .. } => {
                Some("start it, correct its name in robot.toml, or wait longer with `connect` in its `[timeouts]`")
            }
            Self::Abandoned { .. } => Some(
                "its input has ended, and it is killed after twice its timeout for stops; wait, or end it with `kill -9 NUMBER`, then \
                 try again",
            ),
            Self::Blocked { .. } => Some(
                "start rosbridge with `send_action_goals_in_new_thread:=true`, for example `ros2 launch rosbridge_server \
                 rosbridge_websocket_launch.xml send_action_goals_in_new_thread:=true`",
            ),
            Self::UnderWay { .. } => Some("wait until it has ended, or end it at the robot, then try again"),
            Self::InUse { .. } => Some("wait for the other run to end, or stop it"),
            Self::Protocol { .. } => Some("docs/guide/robots.md describes the messages of a robot"),
            _ => None,
        }
    }
}
