//! Opening and watching a model, for the commands that need one.

use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use anyhow::Result;
use longstep::dialogue::Forecast;
use longstep::report::ForecastAnswer;
use longstep_files::cache_directory;
use longstep_llm::{
    ChatModel, ModelError, ModelReference, OpenOptions, Pace, Progress, Sampling, StopFlag, Watch, open,
};

use crate::arguments::ModelArguments;
use crate::progress::Spinner;
use crate::signals;

/// Opens a model, with a spinner on stderr.
pub(crate) fn model(name: &str, arguments: &ModelArguments) -> Result<Box<dyn ChatModel>> {
    let spinner = Spinner::new();
    Ok(opened(name, arguments, None, &mut |progress| {
        spinner.show(&progress);
    })?)
}

/// Opens a model for pictures, with a spinner on stderr: an embedded one with its projector.
///
/// # Errors
///
/// The model cannot be opened, or it is an embedded one without a projector.
pub(crate) fn seeing_model(arguments: &ModelArguments, vision: Option<&Path>) -> Result<Box<dyn ChatModel>> {
    let reference: ModelReference = arguments.name().parse()?;
    if reference.is_embedded() && vision.is_none() {
        return Err(ModelError::no_vision(arguments.name()).into());
    }
    let spinner = Spinner::new();
    Ok(opened(arguments.name(), arguments, vision, &mut |progress| {
        spinner.show(&progress);
    })?)
}

/// Opens a model with a spinner on stderr, on whichever thread.
pub(crate) fn open_with_spinner(arguments: &ModelArguments) -> Result<Box<dyn ChatModel>, ModelError> {
    let spinner = Spinner::new();
    opened(arguments.name(), arguments, None, &mut |progress| {
        spinner.show(&progress)
    })
}

/// Opens a model without a spinner.
pub(crate) fn open_quietly(arguments: &ModelArguments) -> Result<Box<dyn ChatModel>, ModelError> {
    opened(arguments.name(), arguments, None, &mut |_| {})
}

fn opened(
    name: &str,
    arguments: &ModelArguments,
    vision: Option<&Path>,
    progress: &mut dyn FnMut(Progress),
) -> Result<Box<dyn ChatModel>, ModelError> {
    let reference: ModelReference = name.parse()?;
    let mut options = OpenOptions::new(cache_directory()?);
    options.threads = arguments.threads.map(usize::from);
    options.context_tokens = arguments.context;
    options.adapters = arguments.adapters();
    options.vision = vision.map(Path::to_path_buf);
    options.record.clone_from(&arguments.record);
    options.timeout = arguments.timeout;
    options.silence = arguments.silence;
    options.stop = interrupted().clone();
    options.sampling = Sampling::default()
        .with_temperature(arguments.temperature)
        .with_top_p(arguments.top_p)
        .with_seed(arguments.seed)
        .with_reasoning(arguments.reasoning);
    open(&reference, &options, progress)
}

/// Shows the progress of a model. Ctrl-C cancels the call once [`watch_for_interrupts`] has run.
pub(crate) struct Waiting {
    spinner: Spinner,
    /// None if there is no cache folder to remember speeds in.
    pace: Option<Pace>,
    forecast: Option<(Forecast, Option<Duration>)>,
    /// True if the person knows that this call takes long.
    has_warned: bool,
}

/// Shortest time that is announced before a call.
const LONG: Duration = Duration::from_secs(60);

/// The advice for a prompt that is too long or too slow.
const SHORTEN: &str = "use a smaller environment, `--strategy goal`, or a server (`--model openai:NAME`)";

impl Waiting {
    /// Watches the model with this name.
    pub(crate) fn new(model: &str) -> Self {
        Self {
            spinner: Spinner::new(),
            pace: cache_directory().ok().map(|cache| Pace::load(&cache, model)),
            forecast: None,
            has_warned: false,
        }
    }

    /// Returns the forecast of the last request for a whole plan.
    pub(crate) fn forecast(&self) -> Option<ForecastAnswer> {
        let (forecast, time) = self.forecast.as_ref()?;
        Some(forecast.answer(time.map(|time| time.as_secs_f64().round())))
    }

    /// Says before a call what will not fit and what will take long.
    fn foresee(&mut self, forecast: Forecast) {
        let estimate = self.pace.as_ref().and_then(|pace| pace.speed().estimate(&forecast));
        // The first request of an instruction is the one that was foreseen; a correction was part of it.
        if self.forecast.is_none() {
            self.forecast = Some((forecast, estimate));
            if let (false, Some(context)) = (forecast.correction_fits(), forecast.context) {
                self.warn(&format!(
                    "a round of correction may need {} tokens, and the model's context has {context}: a plan that is \
                     not valid may stay uncorrected",
                    forecast.correction
                ));
            }
        }
        self.announce(estimate, "the last run");
    }

    /// Says that a call takes long, once.
    fn announce(&mut self, estimate: Option<Duration>, measured: &str) {
        let (Some((forecast, _)), Some(time)) = (self.forecast, estimate.filter(|time| *time >= LONG)) else {
            return;
        };
        if std::mem::replace(&mut self.has_warned, true) {
            return;
        }
        self.warn(&format!(
            "this takes about {} min: {} tokens to read and about {} to write, at the speed of {measured}",
            time.as_secs().div_ceil(60),
            forecast.prompt,
            forecast.usual_answer
        ));
    }

    fn warn(&self, text: &str) {
        let text = format!("{text}; {SHORTEN}");
        self.spinner.show(&Progress::Warning(text));
    }
}

impl Watch for Waiting {
    fn tell(&mut self, progress: Progress) {
        if let Some(pace) = &mut self.pace {
            pace.observe(&progress);
        }
        if let Progress::Forecast(forecast) = progress {
            return self.foresee(forecast);
        }
        let measured = match (&progress, &self.pace, &self.forecast) {
            (Progress::ReadingPrompt { .. }, Some(pace), Some((forecast, _))) if pace.read_now().is_some() => {
                pace.speed().estimate(forecast)
            }
            _ => None,
        };
        if let (Some(time), Some((_, foreseen))) = (measured, &mut self.forecast) {
            foreseen.get_or_insert(time);
            self.announce(measured, "this prompt");
        }
        self.spinner.show(&progress);
    }

    fn stop(&self) -> bool {
        interrupted().is_set()
    }
}

/// From now on Ctrl-C stops the run of a robot, or cancels the current call, instead of ending the program.
pub(crate) fn watch_for_interrupts() {
    // If no handler can be set, Ctrl-C ends the program; the session is on the disk.
    let _ = ctrlc::set_handler(|| {
        if !signals::stop_run() {
            interrupted().set(true);
        }
    });
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
