//! The stop of a robot in Python: from any thread, once.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};
use std::time::Duration;

use longstep_robot::StopSwitch;
use pyo3::prelude::*;

use crate::failure::Failure;
use crate::interpreter::attach;

/// The longest wait between two looks for Ctrl-C.
const WAIT: Duration = Duration::from_millis(50);

/// The exceptions of a run: the one that ends it, and that of the robot's `stop`.
#[derive(Default)]
struct Exceptions {
    first: Option<PyErr>,
    of_stop: Option<PyErr>,
}

/// The exceptions of a run, kept until it has ended.
#[derive(Clone, Default)]
pub(crate) struct Raised(Arc<Mutex<Exceptions>>);

impl Raised {
    fn exceptions(&self) -> MutexGuard<'_, Exceptions> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps an exception that ends the run, unless there is one already.
    pub(crate) fn keep(&self, error: PyErr) {
        let mut exceptions = self.exceptions();
        // Another one is dropped after the lock, because that can run code in Python.
        if exceptions.first.is_none() {
            exceptions.first = Some(error);
        }
    }

    /// Keeps the exception of the robot's `stop`.
    fn keep_of_stop(&self, error: PyErr) {
        self.exceptions().of_stop = Some(error);
    }

    /// Returns true if an exception ends the run.
    pub(crate) fn is_kept(&self) -> bool {
        self.exceptions().first.is_some()
    }

    /// Takes the exception of the run. That of `stop` comes with the earlier one as its context, as from a `finally`; a run
    /// that stopped without one has the reason as the context.
    pub(crate) fn take(&self, py: Python<'_>, reason: Option<&str>) -> PyResult<Option<PyErr>> {
        let Exceptions { first, of_stop } = std::mem::take(&mut *self.exceptions());
        let Some(of_stop) = of_stop else { return Ok(first) };
        let earlier = first.or_else(|| reason.map(|reason| Failure::failed(reason).into()));
        if let Some(earlier) = earlier {
            add_context(py, &of_stop, &earlier)?;
        }
        Ok(Some(of_stop))
    }
}

/// Adds an earlier exception at the end of the contexts of a later one.
fn add_context(py: Python<'_>, later: &PyErr, earlier: &PyErr) -> PyResult<()> {
    let mut last = later.value(py).clone().into_any();
    loop {
        if last.is(earlier.value(py)) {
            return Ok(());
        }
        let context = last.getattr("__context__")?;
        if context.is_none() {
            return last.setattr("__context__", earlier.value(py));
        }
        last = context;
    }
}

/// How far the stop has come.
enum Stage {
    /// Nothing has stopped the robot.
    Ready(Py<PyAny>),
    /// A thread is in the robot's `stop`.
    Calling(ThreadId),
    /// The robot has stopped, or the reason why not.
    Stopped(Result<(), String>),
    /// The run has ended, and nothing stops the robot for it any more.
    Over,
}

/// The stop of a robot. Any thread can ask for it; the robot's method `stop` is called by the first one.
pub(crate) struct Stopping {
    stage: Mutex<Stage>,
    changed: Condvar,
    raised: Raised,
}

impl Stopping {
    pub(crate) fn new(robot: Py<PyAny>, raised: Raised) -> Arc<Self> {
        Arc::new(Self {
            stage: Mutex::new(Stage::Ready(robot)),
            changed: Condvar::new(),
            raised,
        })
    }

    /// Returns a switch that calls `stop` in the thread that presses it.
    pub(crate) fn switch(self: &Arc<Self>) -> StopSwitch {
        let own = Arc::clone(self);
        StopSwitch::new(move || own.call())
    }

    /// Returns true from the first request to stop on.
    pub(crate) fn is_requested(&self) -> bool {
        !matches!(*self.stage(), Stage::Ready(_))
    }

    /// Stops the robot if nothing has, and waits until its `stop` has returned, in whichever thread. Returns at once within
    /// `stop` itself.
    ///
    /// # Errors
    ///
    /// The exception of `stop` as a text.
    pub(crate) fn confirm(&self) -> Result<(), String> {
        self.call();
        let mut stage = self.stage();
        loop {
            match &*stage {
                Stage::Stopped(result) => return result.clone(),
                Stage::Calling(thread) if *thread != thread::current().id() => {}
                Stage::Ready(_) | Stage::Calling(_) | Stage::Over => return Ok(()),
            }
            let (waited, _) = self
                .changed
                .wait_timeout(stage, WAIT)
                .unwrap_or_else(PoisonError::into_inner);
            drop(waited);
            if let Err(error) = attach(|py| py.check_signals()) {
                self.raised.keep(error);
                return Err("the wait for its stop was interrupted".to_owned());
            }
            stage = self.stage();
        }
    }

    /// Ends the run: the robot stays as it is from here on.
    pub(crate) fn end(&self) {
        loop {
            let before = {
                let mut stage = self.stage();
                match &*stage {
                    Stage::Ready(_) => Some(std::mem::replace(&mut *stage, Stage::Over)),
                    Stage::Stopped(_) | Stage::Over => return,
                    Stage::Calling(_) => None,
                }
            };
            // Another thread is in `stop`: its exception is one of this run. Ctrl-C ends the wait.
            if before.is_some() || self.confirm().is_err() {
                return;
            }
        }
    }

    fn stage(&self) -> MutexGuard<'_, Stage> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Calls the robot's `stop`, unless it was called.
    fn call(&self) {
        let robot = {
            let mut stage = self.stage();
            match &*stage {
                Stage::Ready(_) => {}
                _ => return,
            }
            match std::mem::replace(&mut *stage, Stage::Calling(thread::current().id())) {
                Stage::Ready(robot) => robot,
                _ => return,
            }
        };
        let result = attach(|py| {
            let stopped = robot.bind(py).call_method0("stop").map(|_| ());
            stopped.map_err(|error| {
                let text = error.to_string();
                self.raised.keep_of_stop(error);
                text
            })
        });
        *self.stage() = Stage::Stopped(result);
        self.changed.notify_all();
    }
}
