//! The runs that wait for a robot, and the thread that drives it.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use longstep_robot::{Driven, Opened, drive};

use super::hosted::HostedRun;
use super::view::RunState;
use super::work::{Begun, Task};
use crate::problem::{Problem, ProblemKind};
use crate::store::{LogName, OwnedLog, StoreError};

/// The most runs that wait for one robot.
const WAITING: usize = 16;

/// A robot, or the simulation of one session.
pub(crate) type BodyKey = String;

/// The robots of a server, each with the runs that wait for it.
#[derive(Clone, Default)]
pub(crate) struct Queues {
    bodies: Arc<Mutex<HashMap<BodyKey, Queue>>>,
}

/// The runs of one robot.
#[derive(Default)]
struct Queue {
    /// The right to move the robot, until it has none of the runs any more.
    robot: Option<Arc<dyn OwnedLog>>,
    waiting: VecDeque<Task>,
    /// The run that the robot carries out, with those that it interrupted below it.
    under_way: Vec<Arc<HostedRun>>,
}

impl Queues {
    fn bodies(&self) -> MutexGuard<'_, HashMap<BodyKey, Queue>> {
        self.bodies.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns true if no robot has a run.
    pub(crate) fn is_idle(&self) -> bool {
        self.bodies().is_empty()
    }

    /// Returns the right to move a robot: that of its queue, or a new one.
    ///
    /// # Errors
    ///
    /// Another server moves the robot.
    pub(crate) fn right(
        &self,
        body: &BodyKey,
        own: impl FnOnce() -> Result<Box<dyn OwnedLog>, StoreError>,
    ) -> Result<Arc<dyn OwnedLog>, StoreError> {
        // A queue that ends gives its right back under this lock.
        let bodies = self.bodies();
        match bodies.get(body).and_then(|queue| queue.robot.as_ref()) {
            Some(robot) if robot.is_lost() => Err(StoreError::Lost(LogName::Robot(body.clone()).words())),
            Some(robot) => Ok(Arc::clone(robot)),
            None => Ok(own()?.into()),
        }
    }

    /// Adds a run. An urgent one is the next, and pauses the run under way.
    ///
    /// # Errors
    ///
    /// Too many runs wait for the robot.
    pub(crate) fn add(&self, body: &BodyKey, task: Task) -> Result<(), Problem> {
        let mut bodies = self.bodies();
        let is_idle = !bodies.contains_key(body);
        let rights = task.run().rights()?;
        let queue = bodies.entry(body.clone()).or_default();
        queue.robot = Some(rights.robot);
        if queue.waiting.len() >= WAITING {
            return Err(Problem::new(
                ProblemKind::Busy,
                format!("{WAITING} runs wait for the robot already"),
            ));
        }
        if task.run().record().urgent {
            let before = queue.waiting.iter().take_while(|own| own.run().record().urgent).count();
            queue.waiting.insert(before, task);
            if let Some(run) = queue.under_way.last().filter(|run| !run.record().urgent) {
                run.interrupt(true);
            }
        } else {
            queue.waiting.push_back(task);
        }
        drop(bodies);
        if is_idle {
            let (queues, body) = (self.clone(), body.clone());
            thread::spawn(move || queues.serve(&body));
        }
        Ok(())
    }

    /// Carries out the runs of a robot until none waits.
    fn serve(&self, body: &BodyKey) {
        while let Some(task) = self.next(body, |_| true) {
            self.carry_out(body, task, None);
        }
    }

    /// Takes the next run that fits. A robot without one has no queue any more.
    fn next(&self, body: &BodyKey, fits: impl Fn(&Task) -> bool) -> Option<Task> {
        let mut bodies = self.bodies();
        let queue = bodies.get_mut(body)?;
        match queue.waiting.pop_front() {
            Some(task) if fits(&task) => {
                queue.under_way.push(Arc::clone(task.run()));
                Some(task)
            }
            Some(task) => {
                queue.waiting.push_front(task);
                None
            }
            None => {
                if queue.under_way.is_empty() {
                    drop(bodies.remove(body));
                }
                None
            }
        }
    }

    fn left(&self, body: &BodyKey) {
        if let Some(queue) = self.bodies().get_mut(body) {
            queue.under_way.pop();
        }
    }

    /// Returns true if an urgent run waits.
    fn is_urgent(&self, body: &BodyKey) -> bool {
        let bodies = self.bodies();
        let next = bodies.get(body).and_then(|queue| queue.waiting.front());
        next.is_some_and(|task| task.run().record().urgent)
    }

    /// Carries out a run, on the robot of the run that it interrupts or on its own.
    fn carry_out(&self, body: &BodyKey, task: Task, robot: Option<&mut Opened>) {
        let run = Arc::clone(task.run());
        if run.control().is_stop_requested() {
            task.end_unbegun("stopped before it began");
        } else {
            match robot {
                Some(opened) => self.begin(body, &task, opened),
                None => match task.open() {
                    Ok(mut opened) => {
                        self.begin(body, &task, &mut opened);
                        // Ends the program of a robot behind one.
                        let _ = opened.robot.stop();
                    }
                    Err(problem) => task.end_unbegun(&problem.message),
                },
            }
        }
        self.left(body);
    }

    fn begin(&self, body: &BodyKey, task: &Task, opened: &mut Opened) {
        opened.robot.begin_plan(task.world());
        match task.begin(opened) {
            Ok(begun) => self.drive(body, task, begun, opened),
            Err(problem) => task.end_unbegun(&problem.message),
        }
    }

    /// Drives an execution to its end. While it is paused, urgent runs use its robot.
    fn drive(&self, body: &BodyKey, task: &Task, mut begun: Begun, opened: &mut Opened) {
        let run = task.run();
        let mut watcher = task.watcher(&begun);
        loop {
            match drive(&mut begun.execution, opened.robot.as_mut(), &mut watcher, run.control()) {
                Driven::Paused => {
                    run.update(|view| view.state = RunState::Paused);
                    run.wait_paused(|| self.is_urgent(body));
                    self.interrupt(body, opened, run);
                }
                Driven::Done => return task.end(&begun, None),
                Driven::Stopped(stop) => return task.end(&begun, Some(&stop)),
            }
        }
    }

    /// Carries out the urgent runs that wait, on the robot of a run that is paused.
    fn interrupt(&self, body: &BodyKey, opened: &mut Opened, run: &HostedRun) {
        while let Some(task) = self.next(body, |task| task.run().record().urgent) {
            run.update(|view| view.state = RunState::Paused);
            let urgent = Arc::clone(task.run());
            self.carry_out(body, task, Some(&mut *opened));
            // A stop of the urgent run has stopped the robot of both.
            if urgent.view().state == RunState::Stopped
                && let Some(again) = opened.robot.revived()
            {
                opened.robot = again;
            }
            run.control().stop_request().attach(opened.robot.stop_switch());
        }
        run.interrupt(false);
    }
}
