//! The state of the connection: requests without an answer, timeouts, failures and the stop.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::message::{self, Incoming, LINE_LIMIT, Refusal, broken};
use crate::description::Timeouts;
use crate::error::RobotError;
use crate::order::Order;
use crate::program::{Child, Lines, TooLong};
use crate::robot::{Feedback, Progress};

/// The feedback of an order that is kept until it is polled. Older feedback is dropped.
const FEEDBACK_LIMIT: usize = 64;

/// The time between the end of a program's output and its own end, after which it counts as gone without an exit code.
const CLOSED_LIMIT: Duration = Duration::from_millis(100);

/// The connection to a program. Nothing in it waits.
#[derive(Debug)]
pub(super) struct Link {
    child: Child,
    lines: Lines,
    /// The messages that are not written yet. `begun` is true if a part of the first one is.
    outgoing: VecDeque<Vec<u8>>,
    begun: bool,
    last_id: u64,
    requests: BTreeMap<u64, Request>,
    phase: Phase,
    /// The time at which the output of the program ended.
    closed: Option<Instant>,
    /// The timeouts that the robot declared.
    timeouts: Timeouts,
}

/// A request, and what came for it so far.
#[derive(Debug)]
struct Request {
    kind: Kind,
    deadline: Instant,
    limit: Duration,
    feedback: VecDeque<Feedback>,
    answer: Option<Reply>,
}

#[derive(Debug)]
enum Kind {
    Order { step: usize, outcomes: Vec<String> },
    Other(&'static str),
}

/// The answer to a request.
#[derive(Debug)]
pub(super) enum Reply {
    /// Nothing new.
    Waiting,
    /// Feedback about an order.
    Feedback(Feedback),
    /// The end of an order.
    Order(Progress),
    /// The answer to another request.
    Answer(Result<Value, Refusal>),
}

#[derive(Debug)]
enum Phase {
    /// Orders are accepted.
    Open,
    /// `stop` was sent, for `error`. Ends with the confirmation, the end of the program, or by force.
    Stopping {
        error: RobotError,
        stop: u64,
        deadline: Instant,
    },
    /// `shutdown` was sent. Ends with the end of the program, or by force.
    Closing {
        error: RobotError,
        deadline: Instant,
        stop: Result<(), RobotError>,
    },
    /// The program ended.
    Ended {
        error: RobotError,
        stop: Result<(), RobotError>,
    },
}

impl Link {
    pub(super) fn new(child: Child) -> Self {
        Self {
            child,
            lines: Lines::default(),
            outgoing: VecDeque::new(),
            begun: false,
            last_id: 0,
            requests: BTreeMap::new(),
            phase: Phase::Open,
            closed: None,
            timeouts: Timeouts::default(),
        }
    }

    /// Uses the timeouts that the robot declared, and has the program ended after them if this program is killed. Returns the number
    /// of the program's process, and of the one that waits for that.
    pub(super) fn guard(&mut self, timeouts: &Timeouts) -> std::io::Result<(u32, u32)> {
        self.timeouts = timeouts.clone();
        // The time for a stop, and the time for the end after it.
        self.child.guard(timeouts.stop * 2)
    }

    /// Fails if the robot is stopped, after everything was read that the program wrote until now.
    pub(super) fn check(&mut self) -> Result<(), RobotError> {
        self.tick(Instant::now());
        if self.closed.is_some() {
            self.gone();
        }
        match &self.phase {
            Phase::Open => Ok(()),
            Phase::Stopping { error, .. } | Phase::Closing { error, .. } | Phase::Ended { error, .. } => {
                Err(error.clone())
            }
        }
    }

    /// Returns true if the program ended.
    pub(super) fn is_ended(&self) -> bool {
        matches!(self.phase, Phase::Ended { .. })
    }

    /// Returns the number of orders under way.
    pub(super) fn orders(&self) -> usize {
        let is_order = |request: &&Request| matches!(request.kind, Kind::Order { .. }) && request.answer.is_none();
        self.requests.values().filter(is_order).count()
    }

    /// Sends an order and returns its number.
    pub(super) fn order(&mut self, order: &Order, limit: Duration) -> Result<u64, RobotError> {
        let invalid = |reason: String| RobotError::InvalidOrder {
            step: order.step,
            reason,
        };
        let parameters = serde_json::to_value(order).map_err(|error| invalid(error.to_string()))?;
        let kind = Kind::Order {
            step: order.step,
            outcomes: order.outcomes.clone(),
        };
        let size = parameters.to_string().len();
        if size > LINE_LIMIT {
            return Err(invalid(format!("it has {size} bytes, more than {LINE_LIMIT}")));
        }
        self.send(kind, "perform", &parameters, limit)
    }

    /// Sends a request that is no order and returns its number.
    pub(super) fn request(&mut self, method: &'static str, value: &Value, limit: Duration) -> Result<u64, RobotError> {
        self.send(Kind::Other(method), method, value, limit)
    }

    fn send(&mut self, kind: Kind, method: &str, parameters: &Value, limit: Duration) -> Result<u64, RobotError> {
        self.check()?;
        let id = self.post(method, parameters);
        let request = Request {
            kind,
            deadline: Instant::now() + limit,
            limit,
            feedback: VecDeque::new(),
            answer: None,
        };
        self.requests.insert(id, request);
        self.write();
        Ok(id)
    }

    fn post(&mut self, method: &str, parameters: &Value) -> u64 {
        self.last_id += 1;
        self.outgoing
            .push_back(message::request(self.last_id, method, parameters));
        self.last_id
    }

    /// Returns what came for a request; none if there is no such request. Its end removes it.
    pub(super) fn take(&mut self, id: u64) -> Result<Option<Reply>, RobotError> {
        self.check()?;
        let Some(request) = self.requests.get_mut(&id) else {
            return Ok(None);
        };
        if let Some(feedback) = request.feedback.pop_front() {
            return Ok(Some(Reply::Feedback(feedback)));
        }
        match request.answer.take() {
            Some(answer) => {
                self.requests.remove(&id);
                Ok(Some(answer))
            }
            None => Ok(Some(Reply::Waiting)),
        }
    }

    /// Returns the answer to a request that is no order.
    pub(super) fn take_answer(&mut self, id: u64) -> Result<Option<Result<Value, Refusal>>, RobotError> {
        match self.take(id)? {
            Some(Reply::Answer(answer)) => Ok(Some(answer)),
            _ => Ok(None),
        }
    }

    /// Reads, writes, and enforces timeouts.
    pub(super) fn tick(&mut self, now: Instant) {
        self.child.read_messages();
        self.read(now);
        self.write();
        self.expire(now);
        self.advance(now);
    }

    fn read(&mut self, now: Instant) {
        if self.closed.is_none() && !self.child.read(self.lines.buffer()) {
            self.closed = Some(now);
        }
        loop {
            match self.lines.next(LINE_LIMIT) {
                Ok(None) => return,
                Ok(Some(line)) => self.receive(&line),
                Err(TooLong) => {
                    self.lines.clear();
                    self.fail(broken(format!("it wrote a line longer than {} MiB", LINE_LIMIT >> 20)));
                    return;
                }
            }
        }
    }

    /// Uses a line of the program. After a failure only the confirmation of the stop counts.
    fn receive(&mut self, line: &[u8]) {
        match (&self.phase, message::read(line)) {
            (Phase::Open, Ok(incoming)) => {
                if let Err(error) = self.file(incoming) {
                    self.fail(error);
                }
            }
            (Phase::Open, Err(error)) => drop(self.fail(error)),
            (Phase::Stopping { stop, .. }, Ok(Incoming::Answer(id, answer))) if id == *stop => {
                self.finish(answer.map(drop).map_err(|refusal| refusal.into_error("stop")));
            }
            _ => {}
        }
    }

    fn file(&mut self, incoming: Incoming) -> Result<(), RobotError> {
        match incoming {
            Incoming::Answer(id, answer) => {
                let Some(request) = self.requests.get_mut(&id).filter(|request| request.answer.is_none()) else {
                    return Err(broken(if (1..=self.last_id).contains(&id) {
                        format!("it answered request {id} twice")
                    } else {
                        format!("it answered request {id}, which does not exist")
                    }));
                };
                request.answer = Some(match &request.kind {
                    Kind::Order { step, outcomes } => Reply::Order(message::performed(*step, outcomes, answer)?),
                    Kind::Other(_) => Reply::Answer(answer),
                });
            }
            Incoming::Feedback(id, feedback) => match self.requests.get_mut(&id) {
                Some(request) if matches!(request.kind, Kind::Order { .. }) && request.answer.is_none() => {
                    if request.feedback.len() == FEEDBACK_LIMIT {
                        request.feedback.pop_front();
                    }
                    request.feedback.push_back(feedback);
                }
                _ => {
                    return Err(broken(format!(
                        "it sent feedback for {id}, which is no order under way"
                    )));
                }
            },
        }
        Ok(())
    }

    fn write(&mut self) {
        while let Some(first) = self.outgoing.front_mut() {
            let length = first.len();
            let result = self.child.write(first);
            match (result, first.is_empty()) {
                (Ok(()), true) => {
                    self.outgoing.pop_front();
                    self.begun = false;
                }
                (Ok(()), false) => {
                    self.begun |= first.len() < length;
                    return;
                }
                (Err(_), _) => {
                    // The end of the program, or of its output, says more than a broken pipe.
                    self.outgoing.clear();
                    self.begun = false;
                    self.closed.get_or_insert_with(Instant::now);
                    return;
                }
            }
        }
        if matches!(self.phase, Phase::Closing { .. }) {
            self.child.close_input();
        }
    }

    /// Fails if a request has no answer in time.
    fn expire(&mut self, now: Instant) {
        if !matches!(self.phase, Phase::Open) {
            return;
        }
        let late = self
            .requests
            .values()
            .find(|request| request.answer.is_none() && request.deadline <= now);
        if let Some(request) = late {
            let what = match &request.kind {
                Kind::Order { step, .. } => format!("step {step}"),
                Kind::Other(method) => (*method).to_owned(),
            };
            let limit = request.limit;
            self.fail(RobotError::TimedOut { what, limit });
        }
    }

    /// Moves on to the next phase, if it is time.
    fn advance(&mut self, now: Instant) {
        let has_ended = self.child.exit().is_some();
        match &self.phase {
            Phase::Open => {
                let is_late = self
                    .closed
                    .is_some_and(|closed| now.duration_since(closed) > CLOSED_LIMIT);
                if has_ended || is_late {
                    self.gone();
                }
            }
            Phase::Stopping { deadline, .. } if has_ended || *deadline <= now => {
                let limit = self.timeouts.stop;
                let what = "stop".to_owned();
                let error = if has_ended {
                    self.last_words()
                } else {
                    RobotError::TimedOut { what, limit }
                };
                self.end(Err(error));
            }
            Phase::Closing { deadline, stop, .. } if has_ended || *deadline <= now => {
                let stop = stop.clone();
                self.end(stop);
            }
            _ => {}
        }
    }

    /// Fails because the program ended, or closed its output.
    fn gone(&mut self) {
        if matches!(self.phase, Phase::Open) {
            let error = self.last_words();
            self.fail(error);
        }
    }

    fn last_words(&mut self) -> RobotError {
        let reason = self.child.exit().unwrap_or("it closed its output or input").to_owned();
        let messages = self.child.messages();
        RobotError::Gone { reason, messages }
    }

    /// Stops the robot for this error, if it is not stopped yet, and returns the error that stopped it.
    pub(super) fn fail(&mut self, error: RobotError) -> RobotError {
        match &self.phase {
            Phase::Open => {}
            Phase::Stopping { error, .. } | Phase::Closing { error, .. } | Phase::Ended { error, .. } => {
                return error.clone();
            }
        }
        self.requests.clear();
        self.drop_outgoing();
        let stop = self.post("stop", &json!({}));
        let deadline = Instant::now() + self.timeouts.stop;
        self.phase = Phase::Stopping {
            error: error.clone(),
            stop,
            deadline,
        };
        self.write();
        error
    }

    /// Drops the messages that were not written. A line that was begun is cut: the robot must not perform an order that
    /// is complete only after the stop.
    fn drop_outgoing(&mut self) {
        self.outgoing.clear();
        if std::mem::take(&mut self.begun) {
            self.outgoing.push_back(vec![b'\n']);
        }
    }

    /// Sends `shutdown` after a stop, or at the end.
    fn finish(&mut self, stop: Result<(), RobotError>) {
        let error = match &self.phase {
            Phase::Stopping { error, .. } => error.clone(),
            _ => RobotError::Stopped,
        };
        self.post("shutdown", &json!({}));
        let deadline = Instant::now() + self.timeouts.stop;
        self.phase = Phase::Closing { error, deadline, stop };
        self.write();
    }

    /// Ends the connection: with `stop` if orders are under way, with `shutdown` otherwise.
    pub(super) fn close(&mut self) {
        if matches!(self.phase, Phase::Open) {
            if self.orders() > 0 {
                self.fail(RobotError::Stopped);
            } else {
                self.requests.clear();
                self.finish(Ok(()));
            }
        }
    }

    /// Ends the program without a stop, which nothing waits for.
    pub(super) fn kill(&mut self) {
        self.end(Ok(()));
    }

    /// Ends the program.
    fn end(&mut self, stop: Result<(), RobotError>) {
        let error = match &self.phase {
            Phase::Open => RobotError::Stopped,
            Phase::Stopping { error, .. } | Phase::Closing { error, .. } | Phase::Ended { error, .. } => error.clone(),
        };
        self.child.end();
        self.outgoing.clear();
        self.lines.clear();
        self.phase = Phase::Ended { error, stop };
    }

    /// Returns the result of a stop; none while there is none.
    pub(super) fn stopped(&self) -> Option<Result<(), RobotError>> {
        match &self.phase {
            Phase::Open | Phase::Stopping { .. } => None,
            Phase::Closing { stop, .. } | Phase::Ended { stop, .. } => Some(stop.clone()),
        }
    }
}
