//! Opening and watching a model, for the commands that need one.

use std::sync::OnceLock;

use anyhow::Result;
use longstep_llm::{
    ChatModel, ModelError, ModelReference, OpenOptions, Progress, Sampling, StopFlag, Watch, cache_directory, open,
};

use crate::arguments::ModelArguments;
use crate::progress::Spinner;

/// Opens a model, with a spinner on stderr.
pub(crate) fn model(name: &str, arguments: &ModelArguments) -> Result<Box<dyn ChatModel>> {
    let spinner = Spinner::new();
    Ok(opened(name, arguments, &mut |progress| spinner.show(&progress))?)
}

/// Opens a model without a spinner.
pub(crate) fn open_quietly(arguments: &ModelArguments) -> Result<Box<dyn ChatModel>, ModelError> {
    opened(&arguments.model, arguments, &mut |_| {})
}

fn opened(
    name: &str,
    arguments: &ModelArguments,
    progress: &mut dyn FnMut(Progress),
) -> Result<Box<dyn ChatModel>, ModelError> {
    let reference: ModelReference = name.parse()?;
    let mut options = OpenOptions::new(cache_directory()?);
    options.threads = arguments.threads.map(usize::from);
    options.context_tokens = arguments.context;
    options.record.clone_from(&arguments.record);
    options.timeout = arguments.timeout;
    options.silence = arguments.silence;
    options.stop = interrupted().clone();
    options.sampling = Sampling {
        temperature: arguments.temperature,
        top_p: arguments.top_p,
        seed: arguments.seed,
    };
    open(&reference, &options, progress)
}

/// Shows the progress of a model. Ctrl-C cancels the call once [`watch_for_interrupts`] has run.
pub(crate) struct Waiting {
    spinner: Spinner,
}

impl Waiting {
    pub(crate) fn new() -> Self {
        Self {
            spinner: Spinner::new(),
        }
    }
}

impl Watch for Waiting {
    fn tell(&mut self, progress: Progress) {
        self.spinner.show(&progress);
    }

    fn stop(&self) -> bool {
        interrupted().is_set()
    }
}

/// From now on Ctrl-C cancels the current call instead of ending the program.
pub(crate) fn watch_for_interrupts() {
    // If no handler can be set, Ctrl-C ends the program; the session is on the disk.
    let _ = ctrlc::set_handler(|| interrupted().set(true));
}

/// Returns true if Ctrl-C was pressed since the last call.
pub(crate) fn take_interrupt() -> bool {
    let pressed = interrupted().is_set();
    interrupted().set(false);
    pressed
}

/// The flag that Ctrl-C sets.
pub(crate) fn interrupted() -> &'static StopFlag {
    static INTERRUPTED: OnceLock<StopFlag> = OnceLock::new();
    INTERRUPTED.get_or_init(StopFlag::default)
}
