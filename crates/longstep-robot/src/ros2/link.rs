//! The state of the connection to a bridge: goals, calls, topics, timeouts, failures.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::echo::Echo;
use super::mapping::{GoalEnd, Mapping};
use super::stopping::{Ended, StopFacts, Stopping};
use crate::error::RobotError;
use crate::order::Order;
use crate::robot::{Feedback, Progress};
use crate::rosbridge::message::{self, Goal, Incoming, broken};
use crate::rosbridge::{Connection, Lost, Read};

/// The feedback of an order that is kept until it is polled. Older feedback is dropped.
const FEEDBACK_LIMIT: usize = 64;
/// The most messages of one look. More of them are a flood.
const LOOK_LIMIT: usize = 20_000;
/// The type of the heartbeat.
const HEARTBEAT: &str = "std_msgs/msg/UInt64";
/// The type of the topic on which a server says which goals it has.
const STATUS: &str = "action_msgs/msg/GoalStatusArray";

/// The connection to a bridge. Nothing in it waits, but a reconnection after a failure.
#[derive(Debug)]
pub(super) struct Link {
    pub(super) mapping: Arc<Mapping>,
    pub(super) connection: Option<Connection>,
    phase: Phase,
    /// The beginning of all identifiers of this run.
    prefix: String,
    last: u64,
    orders: BTreeMap<u64, Running>,
    /// The calls and subscriptions that wait for an answer, and their answers.
    calls: BTreeMap<String, Option<Answer>>,
    topics: BTreeMap<String, Topic>,
    /// The goals that each server has listed last.
    goals: BTreeMap<String, BTreeSet<String>>,
    /// The time of the last message of the bridge.
    heard: Instant,
    pinged: Instant,
    /// The time at which the next order may be sent.
    next_order: Instant,
    next_beat: Instant,
    echo: Echo,
}

#[derive(Debug)]
enum Phase {
    Open,
    Stopping(Stopping),
    Stopped(Ended),
}

/// An answer to a call, or a complaint about a subscription.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Answer {
    pub(super) is_success: bool,
    pub(super) values: Value,
}

/// A subscribed topic.
#[derive(Debug)]
struct Topic {
    latest: Option<(Instant, Value)>,
    /// The complaint of the bridge about the subscription.
    refusal: Option<String>,
    subscription: String,
}

/// An order, and what came for it so far.
#[derive(Debug)]
struct Running {
    order: Order,
    goal: Goal,
    id: String,
    limit: Duration,
    state: Sent,
    /// The last heartbeat before the goal.
    mark: Option<u64>,
    feedback: VecDeque<Feedback>,
    end: Option<Progress>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sent {
    /// Waits for its turn.
    No,
    At(Instant),
    /// There was a sign that the server accepted the goal.
    Accepted(Instant),
}

impl Link {
    pub(super) fn new(mapping: Arc<Mapping>, connection: Connection) -> Self {
        let now = Instant::now();
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        let mut link = Self {
            mapping,
            connection: Some(connection),
            phase: Phase::Open,
            prefix: format!(
                "longstep-{}-{}",
                std::process::id(),
                since.unwrap_or_default().as_nanos()
            ),
            last: 0,
            orders: BTreeMap::new(),
            calls: BTreeMap::new(),
            topics: BTreeMap::new(),
            goals: BTreeMap::new(),
            heard: now,
            pinged: now,
            next_order: now,
            next_beat: now,
            echo: Echo::default(),
        };
        if let Some(heartbeat) = link.mapping.configuration.heartbeat.clone() {
            let id = link.next_id();
            link.send(&message::advertise(&id, &heartbeat.topic, HEARTBEAT, false));
            let id = link.next_id();
            link.send(&message::subscribe(&id, &heartbeat.topic, HEARTBEAT));
        }
        link
    }

    /// Returns a new identifier.
    pub(super) fn next_id(&mut self) -> String {
        self.last += 1;
        format!("{}-{}", self.prefix, self.last)
    }

    /// Fails if the robot is stopped, after everything was read that the bridge sent until now.
    pub(super) fn check(&mut self) -> Result<(), RobotError> {
        self.tick(Instant::now());
        match &self.phase {
            Phase::Open => Ok(()),
            Phase::Stopping(Stopping { error, .. }) | Phase::Stopped(Ended { error, .. }) => Err(error.clone()),
        }
    }

    /// Returns true if there is nothing left to do.
    pub(super) fn is_ended(&self) -> bool {
        matches!(self.phase, Phase::Stopped(_))
    }

    /// Returns a handle to wait for what the bridge sends.
    pub(super) fn watched(&self) -> Option<TcpStream> {
        self.connection.as_ref().and_then(Connection::watched)
    }

    /// Sends a message; a connection that breaks is a failure.
    pub(super) fn send(&mut self, message: &Value) {
        if let Some(connection) = &mut self.connection
            && let Err(lost) = connection.send(message)
        {
            self.lose(lost);
        }
    }

    /// Closes a connection that cannot be used any more.
    fn lose(&mut self, lost: Lost) {
        self.connection = None;
        self.fail(match lost {
            Lost::Closed(reason) => RobotError::Gone {
                reason,
                messages: String::new(),
            },
            Lost::Broken(reason) => broken(reason),
        });
    }

    // --- orders ---------------------------------------------------------------------------------------------------

    /// Returns the number of orders that have not ended.
    pub(super) fn orders(&self) -> usize {
        self.orders.values().filter(|own| own.end.is_none()).count()
    }

    /// Takes an order, which is sent when its turn comes.
    pub(super) fn order(&mut self, order: &Order, goal: Goal, limit: Duration) -> Result<u64, RobotError> {
        self.check()?;
        let id = self.next_id();
        let running = Running {
            order: order.clone(),
            goal,
            id,
            limit,
            state: Sent::No,
            mark: None,
            feedback: VecDeque::new(),
            end: None,
        };
        let number = self.last;
        self.orders.insert(number, running);
        self.send_orders(Instant::now());
        Ok(number)
    }

    /// Sends the orders whose turn has come.
    fn send_orders(&mut self, now: Instant) {
        while self.next_order <= now && matches!(self.phase, Phase::Open) {
            let Some(running) = self.orders.values_mut().find(|own| own.state == Sent::No) else {
                return;
            };
            running.state = Sent::At(now);
            running.mark = self.echo.mark();
            let message = message::send_goal(&running.id, &running.goal);
            self.next_order = now + self.mapping.configuration.interval;
            self.send(&message);
        }
    }

    /// Returns what came for an order; none if there is no such order. Its end removes it.
    pub(super) fn take(&mut self, number: u64) -> Result<Option<Progress>, RobotError> {
        self.check()?;
        let Some(running) = self.orders.get_mut(&number) else {
            return Ok(None);
        };
        if let Some(feedback) = running.feedback.pop_front() {
            return Ok(Some(Progress::Running(Some(feedback))));
        }
        match running.end.take() {
            Some(end) => {
                self.orders.remove(&number);
                Ok(Some(end))
            }
            None => Ok(Some(Progress::Running(None))),
        }
    }

    // --- calls and topics -----------------------------------------------------------------------------------------

    /// Sends a request whose answer [`Link::take_answer`] returns.
    pub(super) fn request(&mut self, message: impl FnOnce(&str) -> Value) -> Result<String, RobotError> {
        self.check()?;
        let id = self.next_id();
        self.calls.insert(id.clone(), None);
        self.send(&message(&id));
        Ok(id)
    }

    /// Returns the answer to a request; none while there is none.
    pub(super) fn take_answer(&mut self, id: &str) -> Result<Option<Answer>, RobotError> {
        self.check()?;
        match self.calls.get(id) {
            Some(Some(_)) => Ok(self.calls.remove(id).flatten()),
            _ => Ok(None),
        }
    }

    /// Forgets a request, whose answer may still come.
    pub(super) fn forget(&mut self, id: &str) {
        // It stays known, so that a late answer breaks nothing.
        self.calls.insert(id.to_owned(), None);
    }

    /// Subscribes a topic, once.
    pub(super) fn subscribe(&mut self, topic: &str, kind: &str) -> Result<(), RobotError> {
        self.check()?;
        if self.topics.contains_key(topic) {
            return Ok(());
        }
        let id = self.next_id();
        self.send(&message::subscribe(&id, topic, kind));
        let state = Topic {
            latest: None,
            refusal: None,
            subscription: id,
        };
        self.topics.insert(topic.to_owned(), state);
        Ok(())
    }

    /// Subscribes the topic on which a server lists its goals.
    pub(super) fn subscribe_status(&mut self, server: &str) -> Result<(), RobotError> {
        self.subscribe(&status_topic(server), STATUS)
    }

    /// Returns the last message of a topic that came after a moment.
    pub(super) fn latest(&mut self, topic: &str, after: Option<Instant>) -> Result<Option<Value>, RobotError> {
        self.check()?;
        let Some(state) = self.topics.get(topic) else {
            return Ok(None);
        };
        if let Some(reason) = &state.refusal {
            return Err(RobotError::Refused {
                method: format!("subscribe {topic}"),
                reason: reason.clone(),
            });
        }
        let latest = state
            .latest
            .as_ref()
            .filter(|(at, _)| after.is_none_or(|after| *at >= after));
        Ok(latest.map(|(_, message)| message.clone()))
    }

    // --- time -----------------------------------------------------------------------------------------------------

    /// Reads, writes, and enforces timeouts.
    pub(super) fn tick(&mut self, now: Instant) {
        self.read(now);
        match self.phase {
            Phase::Open => {
                self.keep_alive(now);
                self.expire(now);
                self.send_orders(now);
            }
            Phase::Stopping(_) => self.advance_stop(now),
            Phase::Stopped(_) => {}
        }
    }

    fn read(&mut self, now: Instant) {
        for _ in 0..LOOK_LIMIT {
            let Some(connection) = &mut self.connection else {
                return;
            };
            let flushed = if connection.is_behind() {
                connection.flush()
            } else {
                Ok(())
            };
            match flushed.and_then(|()| connection.read()) {
                Ok(Read::Nothing) => return,
                Ok(Read::Alive) => self.heard = now,
                Ok(Read::Text(text)) => {
                    self.heard = now;
                    self.receive(&text, now);
                }
                Err(lost) => return self.lose(lost),
            }
        }
        self.fail(broken(format!(
            "the bridge sent more than {LOOK_LIMIT} messages at once"
        )));
    }

    /// Uses a message of the bridge. After a failure only the end of goals counts.
    fn receive(&mut self, text: &str, now: Instant) {
        let incoming = message::read(text);
        match (&mut self.phase, incoming) {
            (Phase::Open, incoming) => {
                if let Err(error) = incoming.and_then(|incoming| self.file(incoming, now)) {
                    self.fail(error);
                }
            }
            (Phase::Stopping(stopping), Ok(incoming)) => stopping.file(&incoming),
            _ => {}
        }
    }

    fn file(&mut self, incoming: Incoming, now: Instant) -> Result<(), RobotError> {
        match incoming {
            Incoming::Feedback { id, values } => {
                let mapping = Arc::clone(&self.mapping);
                // Feedback may come after the result, which ROS 2 does not order.
                let Some(running) = self.running(&id).filter(|own| own.end.is_none()) else {
                    return self.known(&id, "feedback");
                };
                running.accept();
                if running.feedback.len() == FEEDBACK_LIMIT {
                    running.feedback.pop_front();
                }
                let feedback = mapping.feedback(&running.order, values);
                running.feedback.push_back(feedback);
            }
            Incoming::Result { id, status, values } => {
                let mapping = Arc::clone(&self.mapping);
                let mark = self.running(&id).and_then(|own| own.mark);
                let kept = self.echo.kept_back(mark);
                let Some(running) = self.running(&id).filter(|own| own.end.is_none()) else {
                    return Err(broken(format!(
                        "the bridge sent a result for `{id}`, which is no goal under way"
                    )));
                };
                let mut end = mapping.end(&running.order, &GoalEnd { status, values });
                let is_success = matches!(end, Ok(Progress::Done { .. }));
                if let Some(kept) = kept.filter(|_| !is_success) {
                    let step = running.order.step;
                    let reason =
                        format!("step {step} ended without success, and {kept} heartbeats before it did not come back");
                    end = Err(RobotError::Blocked { reason });
                }
                // The goal itself has ended, whatever follows: it is not cancelled.
                running.end = Some(end.clone().unwrap_or(Progress::Running(None)));
                end?;
            }
            Incoming::Response { id, is_success, values } => {
                if let Some(answer) = self.calls.get_mut(&id) {
                    *answer = Some(Answer { is_success, values });
                }
            }
            Incoming::Published { topic, message } => {
                self.list_goals(&topic, &message);
                let heartbeat = self.mapping.configuration.heartbeat.as_ref();
                if heartbeat.is_some_and(|heartbeat| heartbeat.topic == topic) {
                    self.echo.receive(&message);
                }
                if let Some(state) = self.topics.get_mut(&topic) {
                    state.latest = Some((now, message));
                }
            }
            Incoming::Status { id, is_error, text } => self.file_status(id.as_deref(), is_error, text)?,
            Incoming::Called { .. } | Incoming::Other => {}
        }
        Ok(())
    }

    /// Uses a remark of the bridge about a request.
    fn file_status(&mut self, id: Option<&str>, is_error: bool, text: String) -> Result<(), RobotError> {
        let Some(id) = id.filter(|_| is_error) else {
            return Ok(());
        };
        if let Some(running) = self.running(id).filter(|own| own.end.is_none()) {
            let step = running.order.step;
            running.end = Some(Progress::Running(None));
            return Err(RobotError::Rejected { step, reason: text });
        }
        if let Some(topic) = self.topics.values_mut().find(|own| own.subscription == id) {
            topic.refusal = Some(text);
        } else if let Some(answer) = self.calls.get_mut(id) {
            *answer = Some(Answer {
                is_success: false,
                values: json!(text),
            });
        } else if id.starts_with(&self.prefix) {
            return Err(broken(format!("the bridge refused a message: {text}")));
        }
        Ok(())
    }

    fn running(&mut self, id: &str) -> Option<&mut Running> {
        self.orders.values_mut().find(|own| own.id == id)
    }

    /// Fails for a message about a goal that was never sent.
    fn known(&self, id: &str, kind: &str) -> Result<(), RobotError> {
        if id.starts_with(&self.prefix) {
            Ok(())
        } else {
            Err(broken(format!(
                "the bridge sent {kind} for `{id}`, which is no goal of this run"
            )))
        }
    }

    /// Notes the goals that a server lists: a new one is a sign that it accepted ours.
    fn list_goals(&mut self, topic: &str, message: &Value) {
        let Some(server) = topic.strip_suffix("/_action/status") else {
            return;
        };
        let listed = message.get("status_list").and_then(Value::as_array);
        let id_of = |entry: &Value| entry.pointer("/goal_info/goal_id/uuid").map(Value::to_string);
        let listed: BTreeSet<String> = listed.into_iter().flatten().filter_map(id_of).collect();
        let known = self.goals.insert(server.to_owned(), listed.clone()).unwrap_or_default();
        let waiting = self.orders.values_mut();
        let waiting = waiting.filter(|own| own.goal.server == server && matches!(own.state, Sent::At(_)));
        for (running, _) in waiting.zip(listed.difference(&known)) {
            running.accept();
        }
    }

    /// Sends heartbeats, and fails if the bridge gives no sign of life.
    fn keep_alive(&mut self, now: Instant) {
        let limits = &self.mapping.configuration.limits;
        let silence = limits.silence;
        if now.duration_since(self.heard) > silence {
            self.connection = None;
            self.fail(RobotError::Gone {
                reason: format!("the bridge gave no sign of life for {} s", silence.as_secs_f64()),
                messages: String::new(),
            });
            return;
        }
        let pause = silence / 4;
        if now.duration_since(self.heard) > pause && now.duration_since(self.pinged) > pause {
            self.pinged = now;
            if let Some(connection) = &mut self.connection
                && let Err(lost) = connection.ping()
            {
                return self.lose(lost);
            }
        }
        if let Some(heartbeat) = &self.mapping.configuration.heartbeat
            && self.next_beat <= now
        {
            self.next_beat = now + heartbeat.period;
            let beat = message::publish(&heartbeat.topic, &json!({"data": self.echo.next()}));
            self.send(&beat);
        }
    }

    /// Fails if a goal is neither accepted nor done in time.
    fn expire(&mut self, now: Instant) {
        let accept = self.mapping.configuration.limits.accept;
        let lists = |server: &str| {
            let topic = self.topics.get(&status_topic(server));
            topic.is_some_and(|own| own.refusal.is_none())
        };
        let late = self.orders.values().filter(|own| own.end.is_none()).find_map(|own| {
            let step = own.order.step;
            match own.state {
                Sent::At(at) if now.duration_since(at) > accept.min(own.limit) && lists(&own.goal.server) => {
                    let what = format!(
                        "step {step}: `{}` gave no sign that it accepted the goal",
                        own.goal.server
                    );
                    Some((what, accept.min(own.limit)))
                }
                Sent::At(at) | Sent::Accepted(at) if now.duration_since(at) > own.limit => {
                    Some((format!("step {step}"), own.limit))
                }
                _ => None,
            }
        });
        if let Some((what, limit)) = late {
            self.fail(RobotError::TimedOut { what, limit });
        }
    }

    // --- the end --------------------------------------------------------------------------------------------------

    /// Stops the robot for this error, if it is not stopped yet, and returns the error that stopped it.
    pub(super) fn fail(&mut self, error: RobotError) -> RobotError {
        match &self.phase {
            Phase::Open => {}
            Phase::Stopping(Stopping { error, .. }) | Phase::Stopped(Ended { error, .. }) => return error.clone(),
        }
        // An order that is only partly sent must not become whole.
        if self.connection.as_ref().is_some_and(Connection::is_behind) {
            self.connection = None;
        }
        let under_way = self
            .orders
            .values()
            .filter(|own| own.end.is_none() && own.state != Sent::No);
        let goals: BTreeMap<String, String> = under_way.map(|own| (own.id.clone(), own.goal.server.clone())).collect();
        self.orders.clear();
        let configuration = &self.mapping.configuration;
        let limits = StopFacts {
            stop: configuration.limits.stop,
            has_service: configuration.stop.is_some() && !goals.is_empty(),
            is_connected: self.connection.is_some(),
        };
        self.phase = Phase::Stopping(Stopping::new(error.clone(), goals, &self.prefix, limits));
        self.advance_stop(Instant::now());
        error
    }

    /// Does what the stop needs now.
    fn advance_stop(&mut self, now: Instant) {
        let Phase::Stopping(stopping) = &mut self.phase else {
            return;
        };
        if let Some(ended) = stopping.advance(&mut self.connection, &self.mapping.configuration, now) {
            if let Some(mut connection) = self.connection.take() {
                connection.close();
            }
            self.phase = Phase::Stopped(ended);
        }
    }

    /// Returns the result of a stop; none while there is none.
    pub(super) fn stopped(&self) -> Option<Result<(), RobotError>> {
        match &self.phase {
            Phase::Stopped(Ended { stop, .. }) => Some(stop.clone()),
            _ => None,
        }
    }
}

impl Running {
    fn accept(&mut self) {
        if let Sent::At(at) = self.state {
            self.state = Sent::Accepted(at);
        }
    }
}

/// The topic on which a server lists its goals.
pub(super) fn status_topic(server: &str) -> String {
    format!("{server}/_action/status")
}
