//! Goals that an interrupted run left under way: they outlive Longstep and the bridge.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use longstep_core::model::Domain;
use serde_json::Value;

use super::configuration::Configuration;
use super::link::{Answer, Link, status_topic};
use super::stopping::{AGAIN, has_no_active_goal, has_nothing_to_cancel};
use super::{LISTING, Ros2, TICK, message};
use crate::error::RobotError;

impl Ros2 {
    /// Connects as [`Ros2::connect`] does, for a run that goes on after orders of it were left under way: goals of its servers are
    /// cancelled, and have ended, before this returns. [`Ros2::cancelled`] is their number.
    ///
    /// # Errors
    ///
    /// Those of [`Ros2::connect`]; [`RobotError::UnderWay`] for a goal that does not end within the timeout for stops, and for a
    /// server of which that cannot be found out.
    pub fn reconnect(configuration: Configuration, domain: &Domain) -> Result<Self, RobotError> {
        let mut robot = Self::find(configuration, domain)?;
        robot.cancelled = robot.end_goals()?;
        Ok(robot)
    }

    /// The number of goals that an interrupted run had left under way, and that were cancelled.
    pub fn cancelled(&self) -> usize {
        self.cancelled
    }

    /// Cancels the goals of all servers and waits for their end; returns their number.
    fn end_goals(&self) -> Result<usize, RobotError> {
        let limit = self.mapping.configuration.limits.stop;
        let begun = Instant::now();
        let servers = self.mapping.configuration.servers();
        let mut servers: Vec<Server<'_>> = servers.into_keys().map(Server::new).collect();
        let mut link = self.lock();
        loop {
            for server in &mut servers {
                server.advance(&mut link, begun, limit)?;
            }
            let Some(late) = servers.iter().find(|own| !own.has_ended) else {
                return Ok(servers.iter().map(|own| own.cancelled.len()).sum());
            };
            if begun.elapsed() >= LISTING + limit {
                let error = late.error(limit);
                return Err(link.fail(error));
            }
            link = self.shared.pause(link, TICK);
        }
    }
}

/// An action server whose goals are ended.
struct Server<'a> {
    name: &'a str,
    has_ended: bool,
    /// The call that cancels its goals, and waits for an answer.
    call: Option<String>,
    next: Instant,
    /// The goals whose cancellation it accepted.
    cancelled: BTreeSet<String>,
    /// The last answer accepted no cancellation although there is a goal.
    is_refused: bool,
}

impl<'a> Server<'a> {
    fn new(name: &'a str) -> Self {
        Self {
            name,
            has_ended: false,
            call: None,
            next: Instant::now(),
            cancelled: BTreeSet::new(),
            is_refused: false,
        }
    }

    /// Uses what came, and does what is due.
    fn advance(&mut self, link: &mut Link, begun: Instant, limit: Duration) -> Result<(), RobotError> {
        if self.has_ended {
            return Ok(());
        }
        let list = match link.latest(&status_topic(self.name), None) {
            Err(RobotError::Refused { .. }) => None,
            list => list?,
        };
        // A server that had goals lists them at once.
        if list.is_none() && begun.elapsed() < LISTING {
            return Ok(());
        }
        if list.as_ref().is_some_and(has_no_active_goal) {
            self.has_ended = true;
            return Ok(());
        }
        if let Some(call) = &self.call
            && let Some(answer) = link.take_answer(call)?
        {
            self.call = None;
            self.file(&answer, list.is_some());
        }
        if !self.has_ended && self.call.is_none() && self.next <= Instant::now() {
            let ask = |id: &str| message::cancel_call(id, self.name, None, limit.as_secs_f64());
            self.call = Some(link.request(ask)?);
            self.next = Instant::now() + AGAIN;
        }
        Ok(())
    }

    /// Uses the answer to a call that cancels all goals.
    fn file(&mut self, answer: &Answer, is_listed: bool) {
        let goals = answer.values.get("goals_canceling").and_then(Value::as_array);
        let ids = goals
            .into_iter()
            .flatten()
            .filter_map(|goal| goal.pointer("/goal_id/uuid"));
        self.cancelled.extend(ids.map(Value::to_string));
        let has_none = answer.is_success && has_nothing_to_cancel(&answer.values);
        // A goal that is being cancelled cannot be cancelled again: only the list shows its end.
        self.has_ended = has_none && !is_listed && self.cancelled.is_empty();
        // Servers answer that there is nothing to cancel also where they accepted no cancellation.
        self.is_refused = self.cancelled.is_empty() && (is_listed || !has_none);
    }

    /// The reason why the goals of the server have not ended, as far as that is known.
    fn error(&self, limit: Duration) -> RobotError {
        let seconds = limit.as_secs_f64();
        let reason = if self.is_refused {
            "an interrupted run left it, and the server does not accept its cancellation".to_owned()
        } else if self.cancelled.is_empty() {
            format!("an interrupted run left it, and the server did not answer its cancellation within {seconds} s")
        } else {
            format!("an interrupted run left it, and it did not end within {seconds} s after its cancellation")
        };
        let server = self.name.to_owned();
        RobotError::UnderWay { server, reason }
    }
}
