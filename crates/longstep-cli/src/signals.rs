//! Signals: a robot that moves is stopped before anything else.

use std::sync::{Mutex, MutexGuard, PoisonError};

use longstep_robot::StopRequest;

use crate::exit_code::STOPPED;

/// The request of the run under way; none while no robot moves or is being opened.
static UNDER_WAY: Mutex<Option<StopRequest>> = Mutex::new(None);

fn under_way() -> MutexGuard<'static, Option<StopRequest>> {
    UNDER_WAY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// While this lives, signals stop the run of a request.
pub(crate) struct Armed(());

impl Armed {
    pub(crate) fn new(request: &StopRequest) -> Self {
        *under_way() = Some(request.clone());
        Self(())
    }
}

impl Drop for Armed {
    fn drop(&mut self) {
        *under_way() = None;
    }
}

/// Stops the run under way; returns false if there is none, or if it was stopped before.
pub(crate) fn stop_run() -> bool {
    let request = under_way().clone();
    match request.filter(|request| !request.is_requested()) {
        Some(request) => {
            request.stop();
            true
        }
        None => false,
    }
}

/// From now on a signal stops the run under way; a second one, or one without a run, ends the program.
#[cfg(unix)]
pub(crate) fn stop_runs() -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

    watch(&[SIGINT, SIGTERM, SIGHUP], || {
        if !stop_run() {
            std::process::exit(i32::from(STOPPED));
        }
    })
}

/// From now on Ctrl-C stops the run under way; a second one, or one without a run, ends the program.
#[cfg(not(unix))]
pub(crate) fn stop_runs() -> std::io::Result<()> {
    let set = ctrlc::set_handler(move || {
        if !stop_run() {
            std::process::exit(i32::from(STOPPED));
        }
    });
    set.map_err(std::io::Error::other)
}

/// From now on SIGTERM and SIGHUP stop the run under way and end the program. `close` closes an open robot.
#[cfg(unix)]
pub(crate) fn end_with(close: impl Fn() + Send + Clone + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGTERM};

    let ended = std::sync::atomic::AtomicBool::new(false);
    watch(&[SIGTERM, SIGHUP], move || {
        stop_run();
        // A second signal does not wait for a robot that takes its time.
        if ended.swap(true, std::sync::atomic::Ordering::SeqCst) {
            std::process::exit(i32::from(STOPPED));
        }
        let close = close.clone();
        std::thread::spawn(move || {
            close();
            std::process::exit(i32::from(STOPPED));
        });
    })
}

/// Other systems have no such signals.
#[cfg(not(unix))]
pub(crate) fn end_with(_: impl Fn() + Send + Clone + 'static) -> std::io::Result<()> {
    Ok(())
}

/// Returns what completes with the first signal to end; a second one ends the program.
pub(crate) fn ended() -> std::io::Result<impl Future<Output = ()>> {
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::task::{Poll, Waker};

    let waker: Arc<Mutex<Option<Waker>>> = Arc::default();
    let is_ended = Arc::new(AtomicBool::new(false));
    let react = {
        let (waker, is_ended) = (Arc::clone(&waker), Arc::clone(&is_ended));
        move || {
            if is_ended.swap(true, Ordering::SeqCst) {
                std::process::exit(i32::from(STOPPED));
            }
            if let Some(waker) = waker.lock().unwrap_or_else(PoisonError::into_inner).take() {
                waker.wake();
            }
        }
    };
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        watch(&[SIGINT, SIGTERM, SIGHUP], react)?;
    }
    #[cfg(not(unix))]
    ctrlc::set_handler(react).map_err(std::io::Error::other)?;
    Ok(std::future::poll_fn(move |context| {
        *waker.lock().unwrap_or_else(PoisonError::into_inner) = Some(context.waker().clone());
        if is_ended.load(Ordering::SeqCst) {
            Poll::Ready(())
        } else {
            Poll::Pending
        }
    }))
}

#[cfg(unix)]
fn watch(signals: &[std::ffi::c_int], react: impl Fn() + Send + 'static) -> std::io::Result<()> {
    let mut signals = signal_hook::iterator::Signals::new(signals)?;
    std::thread::spawn(move || signals.forever().for_each(|_| react()));
    Ok(())
}
