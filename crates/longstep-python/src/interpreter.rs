//! Leaving the interpreter and entering it again, also while the program ends.
//!
//! CPython ends a daemon thread that enters the interpreter of a program that has ended, by unwinding its stack. The frames of
//! this module cannot be unwound so: the process would abort. So the end of the program stops all runs first, waits a bounded
//! time for the calls that can call back into Python, and then lets no thread enter the interpreter any more: such a thread
//! sleeps until the process is gone. A thread that is inside a function in Python at that moment, for example in a model's,
//! enters without asking here, and the process aborts if it wakes up before it is gone.

use std::cell::Cell;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};
use std::time::Duration;

use pyo3::prelude::*;
use pyo3::types::{PyCFunction, PyDict, PyTuple};

use crate::active;

/// The longest wait for calls at the end of the program.
const LIMIT: Duration = Duration::from_secs(5);

/// The end of the program, and the calls that it waits for.
struct Exit {
    /// The process with the hook; a forked child begins anew.
    process: u32,
    /// The thread that ends the program, from the beginning of the hook on.
    thread: Option<ThreadId>,
    /// True when no other thread may enter the interpreter any more.
    is_closed: bool,
    /// Calls that can call back into Python.
    calls: usize,
    /// Threads that are about to enter the interpreter.
    entering: usize,
}

static EXIT: Mutex<Exit> = Mutex::new(Exit {
    process: 0,
    thread: None,
    is_closed: false,
    calls: 0,
    entering: 0,
});

static CHANGED: Condvar = Condvar::new();

thread_local! {
    /// True while this thread has left the interpreter within [`detach`].
    static IS_DETACHED: Cell<bool> = const { Cell::new(false) };
}

/// The place of a thread inside or outside the interpreter; the place before comes back when this is dropped.
struct Inside {
    was_detached: bool,
}

impl Inside {
    fn set(is_detached: bool) -> Self {
        Self {
            was_detached: IS_DETACHED.replace(is_detached),
        }
    }
}

impl Drop for Inside {
    fn drop(&mut self) {
        IS_DETACHED.set(self.was_detached);
    }
}

fn exit() -> MutexGuard<'static, Exit> {
    EXIT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Works without the interpreter, and enters it again.
pub(crate) fn detach<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> T {
    register(py);
    let result = py.detach(|| {
        let inside = Inside::set(true);
        let result = work();
        drop(inside);
        enter();
        result
    });
    entered();
    result
}

/// Enters the interpreter, from a thread that may have left it.
pub(crate) fn attach<T>(work: impl FnOnce(Python<'_>) -> T) -> T {
    let inside = Inside::set(false);
    if inside.was_detached {
        enter();
    }
    Python::attach(|py| {
        if inside.was_detached {
            entered();
        }
        work(py)
    })
}

/// Announces that this thread enters the interpreter; sleeps for good if the interpreter has ended.
fn enter() {
    let mut exit = exit();
    if exit.is_closed && exit.thread != Some(thread::current().id()) {
        drop(exit);
        sleep();
    }
    exit.entering += 1;
}

fn entered() {
    let mut exit = exit();
    exit.entering = exit.entering.saturating_sub(1);
    drop(exit);
    CHANGED.notify_all();
}

/// Sleeps until the process is gone.
fn sleep() -> ! {
    loop {
        thread::park();
    }
}

/// A call that can call back into Python. The end of the program waits for it.
pub(crate) struct Call(());

impl Call {
    /// Begins a call; sleeps for good if the program ends.
    pub(crate) fn begin(py: Python<'_>) -> Self {
        register(py);
        let mut exit = exit();
        if exit.thread.is_some_and(|thread| thread != thread::current().id()) {
            drop(exit);
            py.detach(|| sleep());
        }
        exit.calls += 1;
        Self(())
    }
}

impl Drop for Call {
    fn drop(&mut self) {
        let mut exit = exit();
        exit.calls = exit.calls.saturating_sub(1);
        drop(exit);
        CHANGED.notify_all();
    }
}

/// Registers the hook for the end of the program, once for a process.
fn register(py: Python<'_>) {
    let process = std::process::id();
    {
        let mut exit = exit();
        if exit.process == process {
            return;
        }
        *exit = Exit {
            process,
            thread: None,
            is_closed: false,
            calls: 0,
            entering: 0,
        };
    }
    // Without the hook, runs work, and only the end of a program with daemon threads is as it would be without it.
    drop(registered(py));
}

fn registered(py: Python<'_>) -> PyResult<()> {
    let hook = |arguments: &Bound<'_, PyTuple>, _: Option<&Bound<'_, PyDict>>| end(arguments.py());
    let hook = PyCFunction::new_closure(py, None, None, hook)?;
    py.import("atexit")?.call_method1("register", (hook,))?;
    Ok(())
}

/// Stops all runs, and closes the interpreter to other threads.
fn end(py: Python<'_>) {
    {
        let mut exit = exit();
        if exit.process != std::process::id() {
            return;
        }
        exit.thread = Some(thread::current().id());
    }
    detach(py, active::stop_all);
    py.detach(|| {
        let waited = CHANGED.wait_timeout_while(exit(), LIMIT, |exit| exit.calls > 0);
        let (mut exit, _) = waited.unwrap_or_else(PoisonError::into_inner);
        exit.is_closed = true;
        // Those that have asked before get the interpreter while this thread is out of it.
        drop(CHANGED.wait_while(exit, |exit| exit.entering > 0));
    });
}
