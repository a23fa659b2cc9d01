//! Announcements of steps, after which there is time for a stop or a pause.

use super::{Event, Execution, ExecutionError, Need, StepOrder};

/// A step that was announced.
#[derive(Debug, Clone)]
pub(super) struct Announcement {
    order: StepOrder,
    /// True if the time between the announcement and the step is over.
    is_over: bool,
}

impl Execution {
    /// Announces a step, unless it waits already.
    pub(super) fn announce(&mut self, order: StepOrder) -> Need {
        let is_known = self.announcement.as_ref().is_some_and(|own| own.order == order);
        if !is_known {
            let after = self.settings.autonomy.announcement();
            self.events.push(Event::announced(&self.world, &order, after));
            self.announcement = Some(Announcement {
                order: order.clone(),
                is_over: false,
            });
        }
        Need::Announce(order)
    }

    /// Returns true if a step was announced, and the time until its order is over.
    pub(super) fn was_announced(&self, order: &StepOrder) -> bool {
        self.announcement
            .as_ref()
            .is_some_and(|own| own.is_over && own.order == *order)
    }

    /// Records that the time between the announcement of a step and its order is over. If the world has changed meanwhile, the
    /// step is not ordered because of that.
    ///
    /// ```
    /// # use longstep_core::environment::{self, Observation};
    /// # use longstep_core::execution::{Aim, Approval, Event, Execution, ExecutionError, Need, Settings};
    /// # use longstep_core::{domain, plan, verify::check_file};
    /// # let household = domain::shipped("household").unwrap().unwrap();
    /// # let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    /// # let world = environment::parse(&household, "env.json", text).unwrap();
    /// # let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
    /// # let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
    /// # let seen: Observation = serde_json::from_str(r#"{"states": {"<pen>": "on_something(<desk>)"}}"#).unwrap();
    /// use longstep_core::autonomy::Autonomy;
    /// let autonomy = Autonomy::parse(&household, None, "autonomy.toml", "[autonomy]\ndefault = \"announce\"").unwrap();
    /// let settings = Settings::default().with_approval(Approval::Never).with_autonomy(autonomy);
    /// let mut execution = Execution::new(&plan, &Aim::Endings, settings).unwrap();
    /// execution.observed(&seen).unwrap();
    /// let Need::Announce(order) = execution.next_need() else { panic!() };
    /// assert!(matches!(execution.take_events().last(), Some(Event::Announced { seconds, .. }) if *seconds == 3.0));
    /// // Three seconds pass, in which a person may press stop.
    /// execution.announced(order.number).unwrap();
    /// assert!(matches!(execution.next_need(), Need::Perform(_)));
    /// assert_eq!(execution.announced(order.number), Err(ExecutionError::UnknownOrder(order.number)));
    /// ```
    ///
    /// # Errors
    ///
    /// An order that was not announced, or is ordered already.
    pub fn announced(&mut self, number: u64) -> Result<(), ExecutionError> {
        match &mut self.announcement {
            Some(own) if own.order.number == number => {
                own.is_over = true;
                Ok(())
            }
            _ => Err(ExecutionError::UnknownOrder(number)),
        }
    }
}
