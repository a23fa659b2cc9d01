//! A run in a server: what is shown of it, its control, and the answers of people.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::Duration;

use longstep_robot::RunControl;

use super::view::{QuestionView, RunRecord, RunState, RunView};
use crate::feed::{Feed, Happening};
use crate::problem::Problem;

/// The longest wait between two looks at the control of a run.
const LOOK: Duration = Duration::from_millis(20);

/// The most notices that a view keeps.
const NOTICES: usize = 500;

/// Who has paused a run.
#[derive(Debug, Default)]
struct Pauses {
    by_person: bool,
    by_urgent_run: bool,
}

/// A run that is in memory.
pub(crate) struct HostedRun {
    record: RunRecord,
    feed: Arc<Feed>,
    control: RunControl,
    pauses: Mutex<Pauses>,
    view: RwLock<Arc<RunView>>,
    /// The answer to the question of the view.
    answer: Mutex<Option<bool>>,
    answered: Condvar,
}

impl HostedRun {
    pub(crate) fn new(record: RunRecord, feed: Arc<Feed>, state: RunState) -> Self {
        Self {
            view: RwLock::new(Arc::new(RunView::new(record.clone(), state))),
            record,
            feed,
            control: RunControl::default(),
            pauses: Mutex::default(),
            answer: Mutex::default(),
            answered: Condvar::new(),
        }
    }

    pub(crate) fn record(&self) -> &RunRecord {
        &self.record
    }

    pub(crate) fn control(&self) -> &RunControl {
        &self.control
    }

    /// Pauses the run for a person, or lets it go on as far as the person is concerned.
    pub(crate) fn pause(&self, is_paused: bool) {
        self.change_pauses(|pauses| pauses.by_person = is_paused);
    }

    /// Pauses the run for an urgent one, or lets it go on after that.
    pub(super) fn interrupt(&self, is_interrupted: bool) {
        self.change_pauses(|pauses| pauses.by_urgent_run = is_interrupted);
    }

    fn change_pauses(&self, change: impl FnOnce(&mut Pauses)) {
        let mut pauses = self.pauses.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut pauses);
        if pauses.by_person || pauses.by_urgent_run {
            self.control.pause();
        } else {
            self.control.resume();
        }
    }

    /// Returns the last view. Never waits.
    pub(crate) fn view(&self) -> Arc<RunView> {
        Arc::clone(&self.view.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Changes the view, and announces it.
    pub(crate) fn update(&self, change: impl FnOnce(&mut RunView)) {
        let mut shown = self.view.write().unwrap_or_else(PoisonError::into_inner);
        let view = Arc::make_mut(&mut shown);
        change(view);
        let excess = view.notices.len().saturating_sub(NOTICES);
        view.notices.drain(..excess);
        let (event, state) = (view.events, view.state.name());
        drop(shown);
        self.feed.publish(Happening::Run {
            run: self.record.id.clone(),
            session: self.record.session.clone(),
            event,
            state,
        });
    }

    /// Drops what is large in the view of a run that has ended; the log has it.
    pub(crate) fn shorten(&self) {
        let mut shown = self.view.write().unwrap_or_else(PoisonError::into_inner);
        let mut short = RunView::new(self.record.clone(), shown.state);
        (short.dry_run, short.events, short.end) = (shown.dry_run, shown.events, shown.end.clone());
        *shown = Arc::new(short);
    }

    fn answer(&self) -> MutexGuard<'_, Option<bool>> {
        self.answer.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks a question and waits for the answer; none if the run is to stop or to pause.
    pub(crate) fn ask(&self, question: QuestionView) -> Option<bool> {
        *self.answer() = None;
        self.update(|view| {
            view.state = RunState::Asking;
            view.question = Some(question);
        });
        let mut answer = self.answer();
        while answer.is_none() && !self.control.is_stop_requested() && !self.control.is_pause_requested() {
            let waited = self.answered.wait_timeout(answer, LOOK);
            answer = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        let decision = answer.take();
        drop(answer);
        self.update(|view| {
            view.state = RunState::Running;
            view.question = None;
        });
        decision
    }

    /// Answers the question with this id.
    ///
    /// # Errors
    ///
    /// Another question, or none, waits for an answer; or it has one already.
    pub(crate) fn decide(&self, id: &str, yes: bool) -> Result<QuestionView, Problem> {
        let mut answer = self.answer();
        let view = self.view();
        let question = view
            .question
            .as_ref()
            .filter(|question| question.id == id && answer.is_none());
        let Some(question) = question else {
            return Err(Problem::conflict("the run asks something else, or nothing")
                .hint("look at the run again, and answer the question that it shows"));
        };
        *answer = Some(yes);
        self.answered.notify_all();
        Ok(question.clone())
    }

    /// Waits while the run is paused: until it is to go on or to stop, or `is_due` says that something else is to be done.
    pub(crate) fn wait_paused(&self, is_due: impl Fn() -> bool) {
        while self.control.is_pause_requested() && !self.control.is_stop_requested() && !is_due() {
            std::thread::sleep(LOOK);
        }
    }
}
