//! The thread of a face: the connection to the bridge, requests and publications.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::{Duration, Instant};

use longstep_robot::rosbridge::{self, Connection, Incoming, Lost, Read, wait_for};
use serde_json::Value;

use super::publication::Publication;
use super::rate::Bucket;
use super::topic::{ReplyTo, Topics};
use super::{RosOptions, Shared, request, service};
use crate::hub::Hub;
use crate::problem::{Problem, ProblemKind};

/// The longest wait for a message of the bridge.
const TICK: Duration = Duration::from_millis(20);

/// The most messages of one look. The others wait until the server has answered and published.
const LOOK: usize = 256;

/// The most requests that are worked on at a time.
const WORKERS: usize = 8;

/// The requests that may come at once, and those in a second after that.
const REQUESTS: (u32, f64) = (10, 5.0);

/// Refusals that may come at once, and those in a second after that: what is beyond is a flood, and is not answered.
const REFUSALS: (u32, f64) = (20, 20.0);

/// The pause after the first failure; each further one is twice as long, up to the longest.
const PAUSE: Duration = Duration::from_millis(250);
const LONGEST_PAUSE: Duration = Duration::from_secs(10);

/// The time after which a connection counts as good, so that the pauses begin anew.
const GOOD: Duration = Duration::from_secs(2);

/// The answer to a request.
struct Answered {
    to: ReplyTo,
    text: String,
}

/// The connection of a face, and what it works on.
pub(super) struct Bridge {
    hub: Arc<Hub>,
    options: Arc<RosOptions>,
    shared: Arc<Shared>,
    topics: Topics,
    publication: Publication,
    requests: Bucket,
    refusals: Bucket,
    workers: Arc<AtomicUsize>,
    answer: mpsc::Sender<Answered>,
    answers: mpsc::Receiver<Answered>,
}

impl Bridge {
    pub(super) fn new(hub: Arc<Hub>, options: RosOptions, shared: Arc<Shared>) -> Self {
        let now = Instant::now();
        let (answer, answers) = mpsc::channel();
        Self {
            topics: Topics::new(&options.serving),
            publication: Publication::new(&hub, now),
            hub,
            options: Arc::new(options),
            shared,
            requests: Bucket::new(REQUESTS.0, REQUESTS.1, now),
            refusals: Bucket::new(REFUSALS.0, REFUSALS.1, now),
            workers: Arc::default(),
            answer,
            answers,
        }
    }

    /// Connects, serves, and connects again, until the face ends.
    pub(super) fn run(mut self) {
        let mut pause = PAUSE;
        let mut is_announced = false;
        while !self.shared.is_ended() {
            match Connection::open(&self.options.address, self.options.connect) {
                Ok(connection) => {
                    self.notify("connected");
                    is_announced = false;
                    let begun = Instant::now();
                    let reason = self.connected(connection);
                    if begun.elapsed() >= GOOD {
                        pause = PAUSE;
                    }
                    if let Some(reason) = reason {
                        self.notify(&format!("the connection is lost: {reason}"));
                    }
                }
                // Said once, not with every attempt.
                Err(reason) if !std::mem::replace(&mut is_announced, true) => {
                    self.notify(&format!("no connection: {reason}; it is tried again"));
                }
                Err(_) => {}
            }
            self.sleep(pause);
            pause = (pause * 2).min(LONGEST_PAUSE);
        }
    }

    fn notify(&self, text: &str) {
        (self.options.notice)(&format!("ROS 2 at {}: {text}", self.options.address));
    }

    /// Waits, at most until the face ends.
    fn sleep(&self, time: Duration) {
        let until = Instant::now() + time;
        while !self.shared.is_ended() && Instant::now() < until {
            thread::sleep(TICK);
        }
    }

    /// Serves a connection to its end. Returns the reason; none if the face has ended.
    fn connected(&mut self, mut connection: Connection) -> Option<Lost> {
        self.shared.connections.fetch_add(1, Ordering::SeqCst);
        let result = self.serve(&mut connection);
        self.shared.is_connected.store(false, Ordering::SeqCst);
        connection.close();
        result.err()
    }

    fn serve(&mut self, connection: &mut Connection) -> Result<(), Lost> {
        for message in self.topics.greeting() {
            connection.send(&message)?;
        }
        for (shown, text) in self.publication.latest() {
            connection.send(&self.topics.publication(shown, text))?;
        }
        self.shared.is_connected.store(true, Ordering::SeqCst);
        let mut heard = Instant::now();
        let mut pinged = heard;
        while !self.shared.is_ended() {
            if let Some(stream) = connection.watched() {
                wait_for(&stream, TICK);
            }
            if self.read(connection)? {
                heard = Instant::now();
            }
            self.write(connection)?;
            let silence = self.options.silence;
            if heard.elapsed() > silence {
                let reason = format!("the bridge gave no sign of life for {} s", silence.as_secs_f64());
                return Err(Lost::Closed(reason));
            }
            if heard.elapsed() > silence / 4 && pinged.elapsed() > silence / 4 {
                pinged = Instant::now();
                connection.ping()?;
            }
        }
        Ok(())
    }

    /// Reads what is there, with a bound. Returns true if there was something.
    fn read(&mut self, connection: &mut Connection) -> Result<bool, Lost> {
        for count in 0..LOOK {
            match connection.read()? {
                Read::Nothing => return Ok(count > 0),
                Read::Alive => {}
                Read::Text(text) => self.receive(&text),
            }
        }
        Ok(true)
    }

    /// Takes the request in a message of the bridge. Other messages are ignored.
    fn receive(&mut self, text: &str) {
        match rosbridge::read(text) {
            Ok(Incoming::Published { topic, message }) => {
                if let Some(asked) = self.topics.asked_on(&topic) {
                    self.take(ReplyTo::Topic(asked), text_in(&message, "data"));
                }
            }
            Ok(Incoming::Called { id, service, arguments }) => {
                if let Some(asked) = self.topics.asked_of(&service) {
                    self.take(ReplyTo::Call { asked, id }, text_in(&arguments, "request"));
                }
            }
            Ok(Incoming::Status {
                is_error: true, text, ..
            }) if self.refusals.take(Instant::now()) => {
                self.notify(&format!("the bridge refused a message: {text}"));
            }
            _ => {}
        }
    }

    /// Begins the work on a request, or refuses it.
    fn take(&mut self, to: ReplyTo, text: String) {
        let now = Instant::now();
        if !self.requests.take(now) {
            return self.refuse(to, &text, now, "too many requests in a short time");
        }
        if self.workers.fetch_add(1, Ordering::SeqCst) >= WORKERS {
            self.workers.fetch_sub(1, Ordering::SeqCst);
            return self.refuse(to, &text, now, "too many requests at a time");
        }
        let place = Place(Arc::clone(&self.workers));
        let (hub, options, shared) = (
            Arc::clone(&self.hub),
            Arc::clone(&self.options),
            Arc::clone(&self.shared),
        );
        let answer = self.answer.clone();
        let begun = thread::Builder::new().name("ros2-request".to_owned()).spawn(move || {
            let result = service::done(&hub, &options, &shared, to.asked(), &text);
            let text = request::answer(request::id_of(&text), result);
            // A face that has ended answers nobody.
            drop(answer.send(Answered { to, text }));
            drop(place);
        });
        if let Err(error) = begun {
            self.notify(&format!("a request is dropped: {error}"));
        }
    }

    fn refuse(&mut self, to: ReplyTo, request: &str, now: Instant, why: &str) {
        if !self.refusals.take(now) {
            return;
        }
        let problem = Problem::new(ProblemKind::Busy, why).hint("wait a moment, and ask again");
        let text = request::answer(request::id_of(request), Err(problem));
        // This thread has the other end.
        drop(self.answer.send(Answered { to, text }));
    }

    /// Sends answers and publications, unless the bridge does not read them.
    fn write(&mut self, connection: &mut Connection) -> Result<(), Lost> {
        if connection.is_behind() {
            connection.flush()?;
        }
        while !connection.is_behind() {
            let Ok(answered) = self.answers.try_recv() else { break };
            connection.send(&self.topics.answer(&answered.to, &answered.text))?;
        }
        if connection.is_behind() {
            return Ok(());
        }
        for (shown, text) in self.publication.due(&self.hub, Instant::now()) {
            connection.send(&self.topics.publication(shown, &text))?;
        }
        Ok(())
    }
}

/// A place among the workers, which is free again when the work ends, however it does.
struct Place(Arc<AtomicUsize>);

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

fn text_in(fields: &Value, name: &str) -> String {
    fields.get(name).and_then(Value::as_str).unwrap_or_default().to_owned()
}
