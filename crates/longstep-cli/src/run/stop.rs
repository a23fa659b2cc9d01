//! Ctrl-C, SIGTERM and SIGHUP: the robot is stopped before anything else.

use longstep_robot::StopRequest;

use crate::exit_code::STOPPED;

/// From now on a signal stops the robot and the run; a second one ends the program.
#[cfg(unix)]
pub(super) fn on_signals(request: &StopRequest) -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    let mut signals = Signals::new([SIGINT, SIGTERM, SIGHUP])?;
    let request = request.clone();
    std::thread::spawn(move || {
        for _ in signals.forever() {
            if request.is_requested() {
                std::process::exit(i32::from(STOPPED));
            }
            request.stop();
        }
    });
    Ok(())
}

/// From now on Ctrl-C stops the robot and the run; a second one ends the program.
#[cfg(not(unix))]
pub(super) fn on_signals(request: &StopRequest) -> std::io::Result<()> {
    let request = request.clone();
    let set = ctrlc::set_handler(move || {
        if request.is_requested() {
            std::process::exit(i32::from(STOPPED));
        }
        request.stop();
    });
    set.map_err(std::io::Error::other)
}
