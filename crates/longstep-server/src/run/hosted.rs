//! A run in a server: what is shown of it, its control, and the answers of people.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::{Duration, Instant};

use longstep_robot::RunControl;

use super::view::{EndView, QuestionView, RunRecord, RunState, RunView};
use crate::feed::{Feed, Happening};
use crate::hosted::Held;
use crate::problem::Problem;
use crate::store::{LogName, OwnedLog, StoreError};

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

/// The rights that a run needs until it ends.
#[derive(Clone)]
pub(crate) struct Rights {
    /// To add to its log.
    pub(crate) log: Arc<dyn OwnedLog>,
    /// To move its robot.
    pub(crate) robot: Arc<dyn OwnedLog>,
    /// To change its session.
    pub(crate) session: Held,
}

/// A run that is in memory.
pub(crate) struct HostedRun {
    record: RunRecord,
    feed: Arc<Feed>,
    /// The time since which it is in memory.
    since: Instant,
    /// The epoch of its log, when this server owned it or read it.
    epoch: u64,
    /// True for a run that another server carries out.
    is_elsewhere: bool,
    /// None before and after the run.
    rights: Mutex<Option<Rights>>,
    /// True if a right was lost during the run: its log may go on elsewhere.
    is_lost: AtomicBool,
    control: RunControl,
    pauses: Mutex<Pauses>,
    view: RwLock<Arc<RunView>>,
    /// The answer to the question of the view.
    answer: Mutex<Option<bool>>,
    answered: Condvar,
}

impl HostedRun {
    /// Takes a run that this server is to carry out.
    pub(crate) fn begin(record: RunRecord, feed: Arc<Feed>, rights: Rights) -> Self {
        let view = RunView::new(record.clone(), RunState::Queued);
        Self {
            epoch: rights.log.epoch(),
            rights: Mutex::new(Some(rights)),
            ..Self::new(record, feed, view)
        }
    }

    /// Takes a run that has ended, or that another server carries out.
    pub(crate) fn shown(record: RunRecord, feed: Arc<Feed>, epoch: u64, state: RunState, end: Option<EndView>) -> Self {
        let view = RunView {
            end,
            ..RunView::new(record.clone(), state)
        };
        Self {
            epoch,
            is_elsewhere: !state.is_ended(),
            ..Self::new(record, feed, view)
        }
    }

    fn new(record: RunRecord, feed: Arc<Feed>, view: RunView) -> Self {
        Self {
            view: RwLock::new(Arc::new(view)),
            record,
            feed,
            since: Instant::now(),
            epoch: 0,
            is_elsewhere: false,
            rights: Mutex::default(),
            is_lost: AtomicBool::new(false),
            control: RunControl::default(),
            pauses: Mutex::default(),
            answer: Mutex::default(),
            answered: Condvar::new(),
        }
    }

    /// Returns the time since which it is in memory.
    pub(crate) fn since(&self) -> Instant {
        self.since
    }

    /// Returns the epoch of its log.
    pub(crate) fn epoch(&self) -> u64 {
        self.epoch
    }

    /// Returns true if another server carries it out.
    pub(crate) fn is_elsewhere(&self) -> bool {
        self.is_elsewhere
    }

    /// Returns the rights of the run.
    ///
    /// # Errors
    ///
    /// It has ended.
    pub(crate) fn rights(&self) -> Result<Rights, StoreError> {
        let rights = self.rights.lock().unwrap_or_else(PoisonError::into_inner);
        let lost = || StoreError::Lost(LogName::Run(self.record.id.clone()).words());
        rights.clone().ok_or_else(lost)
    }

    /// Gives the rights of the run back.
    pub(crate) fn give_back(&self) {
        self.is_lost();
        let rights = self.rights.lock().unwrap_or_else(PoisonError::into_inner).take();
        drop(rights);
    }

    /// Returns true if this server has lost a right that the run needs. Never waits for the store.
    pub(crate) fn is_lost(&self) -> bool {
        let rights = self.rights.lock().unwrap_or_else(PoisonError::into_inner);
        let is_lost = |rights: &Rights| rights.log.is_lost() || rights.robot.is_lost() || rights.session.is_lost();
        if rights.as_ref().is_some_and(is_lost) {
            self.is_lost.store(true, Ordering::SeqCst);
        }
        self.is_lost.load(Ordering::SeqCst)
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
