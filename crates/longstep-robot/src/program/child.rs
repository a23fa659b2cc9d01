//! A program that was started: its process group, its pipes, its end.

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{ChildStderr, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use longstep_core::visible;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, Signal, WaitId, WaitIdOptions, kill_process_group, waitid};

use super::CommandLine;

/// The last bytes of standard error that are kept for messages.
const MESSAGES_LIMIT: usize = 4096;

/// The most that one look reads from a pipe. Pipes hold 64 KiB, and at most 1 MiB without privileges, so one look reads
/// everything that was written before it.
const LOOK_LIMIT: usize = 1 << 20;

/// The lowest number of a file that a program inherits. Scripts give lower ones to their own files.
const INHERITED: i32 = 100;

/// Ends the group of a robot's program (its own group) after the end of the input: when the program has ended, or after some seconds.
const GUARD: &str = "trap '' HUP INT QUIT TERM
while read -r line; do :; done
left=$2
while [ \"$left\" -gt 0 ] && kill -0 \"$1\"; do sleep 1; left=$((left - 1)); done
kill -KILL 0";

/// Held while a program is started.
static SPAWN: Mutex<()> = Mutex::new(());

/// A program in a process group of its own, so that its end ends its children, and a Ctrl-C in the terminal does not
/// reach it before this program has told it to stop. Dropping it ends it.
#[derive(Debug)]
pub(crate) struct Child {
    process: std::process::Child,
    input: Option<ChildStdin>,
    output: Option<ChildStdout>,
    errors: Option<ChildStderr>,
    messages: Vec<u8>,
    /// The end of the program; none while it runs.
    ended: Option<String>,
    /// True after the process was reaped: its number may belong to another process from then on.
    reaped: bool,
    /// The process that ends the program if this one is killed.
    guard: Option<std::process::Child>,
}

impl Child {
    /// Starts a program, with handles to wait for what it writes. The program and its children inherit the open file `kept`.
    ///
    /// # Errors
    ///
    /// The program cannot be started, or its pipes cannot be set up. Nothing runs then.
    pub(crate) fn spawn(line: &CommandLine, kept: Option<&File>) -> std::io::Result<(Self, Watched)> {
        let mut command = line.command();
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut process = {
            // A program that another thread starts at the same time must not inherit the file.
            let _alone = SPAWN.lock().unwrap_or_else(PoisonError::into_inner);
            let _inherited = kept.map(inheritable).transpose()?;
            command.process_group(0).spawn()?
        };
        let (input, output, errors) = (process.stdin.take(), process.stdout.take(), process.stderr.take());
        let child = Self {
            process,
            input,
            output,
            errors,
            messages: Vec::new(),
            ended: None,
            reaped: false,
            guard: None,
        };
        child.unblock()?;
        let watched = child.watched()?;
        Ok((child, watched))
    }

    /// Has the program and its children ended by force, if this program ends without ending them: after this time, or as soon as the
    /// program itself has ended. Returns the number of the program's process, and of the one that waits for that.
    ///
    /// # Errors
    ///
    /// The process cannot be started.
    pub(crate) fn guard(&mut self, patience: Duration) -> std::io::Result<(u32, u32)> {
        let process = self.process.id();
        let group = i32::try_from(process).map_err(std::io::Error::other)?;
        let seconds = patience.as_secs_f64().ceil();
        let mut command = Command::new("/bin/sh");
        command.args([
            "-c",
            GUARD,
            "longstep-guard",
            &process.to_string(),
            &seconds.to_string(),
        ]);
        // It never reads more than the end of this pipe, whose other side ends with this program.
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        // As a member of the group, it keeps the number of the group from being given to another one.
        let guard = {
            let _alone = SPAWN.lock().unwrap_or_else(PoisonError::into_inner);
            command.process_group(group).current_dir("/").spawn()
        };
        let guard = guard.map_err(|error| std::io::Error::new(error.kind(), format!("its guard /bin/sh: {error}")))?;
        let number = guard.id();
        self.guard = Some(guard);
        Ok((process, number))
    }

    /// Makes reading and writing return at once.
    fn unblock(&self) -> std::io::Result<()> {
        let pipes = [
            self.input.as_ref().map(AsFd::as_fd),
            self.output.as_ref().map(AsFd::as_fd),
            self.errors.as_ref().map(AsFd::as_fd),
        ];
        for pipe in pipes.into_iter().flatten() {
            rustix::io::ioctl_fionbio(pipe, true)?;
        }
        Ok(())
    }

    fn watched(&self) -> std::io::Result<Watched> {
        let output = self
            .output
            .as_ref()
            .map(|pipe| pipe.as_fd().try_clone_to_owned())
            .transpose()?;
        let errors = self
            .errors
            .as_ref()
            .map(|pipe| pipe.as_fd().try_clone_to_owned())
            .transpose()?;
        Ok(Watched(output.into_iter().chain(errors).collect()))
    }

    /// Appends what the program wrote to its standard output. Returns false at its end.
    pub(crate) fn read(&mut self, bytes: &mut Vec<u8>) -> bool {
        match &mut self.output {
            Some(output) => {
                let is_open = read_available(output, |piece| bytes.extend_from_slice(piece));
                if !is_open {
                    self.output = None;
                }
                is_open
            }
            None => false,
        }
    }

    /// Keeps the last messages of its standard error.
    pub(crate) fn read_messages(&mut self) {
        let messages = &mut self.messages;
        let mut keep = |piece: &[u8]| {
            messages.extend_from_slice(piece);
            let excess = messages.len().saturating_sub(MESSAGES_LIMIT);
            messages.drain(..excess);
        };
        if let Some(errors) = &mut self.errors
            && !read_available(errors, &mut keep)
        {
            self.errors = None;
        }
    }

    /// Returns the last messages for people, whole lines where there are several.
    pub(crate) fn messages(&mut self) -> String {
        self.read_messages();
        let text = String::from_utf8_lossy(&self.messages);
        let whole = match text.split_once('\n') {
            Some((_, rest)) if self.messages.len() == MESSAGES_LIMIT && !rest.is_empty() => rest,
            _ => &text,
        };
        visible::block(whole.trim_end()).into_owned()
    }

    /// Writes the beginning of `bytes` and removes it, as much as the pipe takes.
    ///
    /// # Errors
    ///
    /// The program does not read any more.
    pub(crate) fn write(&mut self, bytes: &mut Vec<u8>) -> std::io::Result<()> {
        while !bytes.is_empty() {
            let Some(input) = &mut self.input else {
                return Err(std::io::ErrorKind::BrokenPipe.into());
            };
            match input.write(bytes) {
                Ok(count) => drop(bytes.drain(..count)),
                Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => return Ok(()),
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Closes its standard input.
    pub(crate) fn close_input(&mut self) {
        self.input = None;
    }

    /// Returns how the program ended; none while it runs. Its process is not reaped, so its group keeps its number.
    pub(crate) fn exit(&mut self) -> Option<&str> {
        if self.ended.is_none() {
            let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
            if let Ok(Some(status)) = waitid(WaitId::Pid(self.pid()), options) {
                self.ended = Some(match (status.exit_status(), status.terminating_signal()) {
                    (Some(code), _) => format!("its program ended with exit code {code}"),
                    (None, Some(signal)) => format!("its program was ended by signal {signal}"),
                    (None, None) => "its program ended".to_owned(),
                });
            }
        }
        self.ended.as_deref()
    }

    /// Sends the program and its children the signal of Ctrl-C, after which they may write the rest and end.
    pub(crate) fn interrupt(&self) {
        self.signal(Signal::INT);
    }

    /// Asks the program and its children to end (SIGTERM). Programs that a shell started in the background do not hear Ctrl-C.
    pub(crate) fn terminate(&self) {
        self.signal(Signal::TERM);
    }

    fn signal(&self, signal: Signal) {
        if !self.reaped {
            // The only error is that the group is gone already.
            let _gone = kill_process_group(self.pid(), signal);
        }
    }

    /// Ends the program with its children, and reaps it.
    pub(crate) fn end(&mut self) {
        if std::mem::replace(&mut self.reaped, true) {
            return;
        }
        (self.input, self.output) = (None, None);
        // The only error is that the group is gone already.
        let _gone = kill_process_group(self.pid(), Signal::KILL);
        if let Some(mut guard) = self.guard.take() {
            // It was in the group.
            let _ended = guard.wait();
        }
        if let Ok(status) = self.process.wait()
            && self.ended.is_none()
        {
            self.ended = Some(format!(
                "its program was ended by signal {}",
                status.signal().unwrap_or_default()
            ));
        }
        self.read_messages();
    }

    fn pid(&self) -> Pid {
        Pid::from_child(&self.process)
    }
}

/// Returns the open file under a number that programs which are started inherit.
fn inheritable(file: &File) -> std::io::Result<OwnedFd> {
    let inherited = rustix::io::fcntl_dupfd_cloexec(file, INHERITED)?;
    rustix::io::fcntl_setfd(&inherited, rustix::io::FdFlags::empty())?;
    Ok(inherited)
}

impl Drop for Child {
    fn drop(&mut self) {
        self.end();
    }
}

/// Calls `use_piece` for everything that can be read at once. Returns false at the end of the pipe.
fn read_available(pipe: &mut impl Read, mut use_piece: impl FnMut(&[u8])) -> bool {
    let mut piece = [0; 16 << 10];
    let mut total = 0;
    while total < LOOK_LIMIT {
        match pipe.read(&mut piece) {
            Ok(0) => return false,
            Ok(count) => {
                use_piece(&piece[..count]);
                total += count;
            }
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => return true,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(_) => return false,
        }
    }
    true
}

/// The pipes that a program writes to.
#[derive(Debug)]
pub(crate) struct Watched(Vec<OwnedFd>);

impl Watched {
    /// Waits until there is something to read, or the time is over.
    pub(crate) fn wait(&self, limit: Duration) {
        let mut pipes: Vec<PollFd<'_>> = self.0.iter().map(|pipe| PollFd::new(pipe, PollFlags::IN)).collect();
        let limit = Timespec {
            tv_sec: limit.as_secs().cast_signed(),
            tv_nsec: limit.subsec_nanos().into(),
        };
        let result = poll(&mut pipes, Some(&limit));
        // A closed pipe is always ready: without a pause, the wait would be a busy loop.
        let is_closed =
            |pipe: &PollFd<'_>| pipe.revents().contains(PollFlags::HUP) && !pipe.revents().contains(PollFlags::IN);
        if result.is_err() || pipes.iter().any(is_closed) {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}
