//! Standing rules of a session: prohibitions that bind every later plan.

use super::stage::Stage;
use super::{Event, OutOfTurn, Proposal, Session};
use crate::goal::{self, GoalError};
use longstep_core::environment::Prohibition;

/// The reason why a standing rule was not put in force or lifted.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RuleError {
    /// The text is no rule of this world.
    #[error(transparent)]
    Rule(#[from] GoalError),
    /// An instruction is in progress.
    #[error(transparent)]
    OutOfTurn(#[from] OutOfTurn),
    /// The rule is in force already.
    #[error("the rule `{0}` is in force already")]
    Known(String),
    /// No rule has this number.
    #[error("there is no rule {0}")]
    Unknown(usize),
}

impl RuleError {
    /// Returns the error for a log with this rule.
    pub(super) fn in_a_log(self) -> OutOfTurn {
        match self {
            Self::OutOfTurn(error) => error,
            _ => OutOfTurn {
                what: "a rule",
                state: "is in a world that does not have it",
            },
        }
    }
}

impl Session {
    /// Puts a rule in force for all later plans: `never opened(fridge)`, `always closed(door)`, `untouched(vase)`.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, RuleError, Settings};
    /// # let planner = Planner::shipped("household")?;
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    /// #     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// session.add_rule("untouched(pen)")?;
    /// assert_eq!(session.rules()[0].written, "untouched(<pen>)");
    /// assert!(matches!(session.add_rule("untouched(pen)"), Err(RuleError::Known(_))));
    /// assert_eq!(session.lift_rule(0)?, "untouched(<pen>)");
    /// assert_eq!(session.lift_rule(0), Err(RuleError::Unknown(0)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// The text is no constraint of the goal language, the rule is in force already, or an instruction is in progress.
    pub fn add_rule(&mut self, text: &str) -> Result<(), RuleError> {
        self.between_instructions("a rule")?;
        self.world.add_values(text);
        let rules = goal::rules(&self.world, text)?;
        for rule in &rules {
            if self.rules().iter().any(|known| known.written == rule.written) {
                return Err(RuleError::Known(rule.written.clone()));
            }
        }
        let text = rules
            .iter()
            .map(|rule| rule.written.as_str())
            .collect::<Vec<_>>()
            .join(" & ");
        self.world = self.world.with_prohibitions(rules);
        self.events.push(Event::Rule { text });
        Ok(())
    }

    /// Lifts the rule with this number, counted from 0 in the order of [`Session::rules`]; returns its text. See
    /// the example of [`Session::add_rule`].
    ///
    /// # Errors
    ///
    /// There is no such rule, or an instruction is in progress.
    pub fn lift_rule(&mut self, number: usize) -> Result<String, RuleError> {
        self.between_instructions("lifting a rule")?;
        let mut rules = self.rules().to_vec();
        if number >= rules.len() {
            return Err(RuleError::Unknown(number));
        }
        let lifted = rules.remove(number).written;
        self.world.set_prohibitions(rules);
        self.events.push(Event::Lifted { number });
        Ok(lifted)
    }

    /// Returns the rules in force, in the order in which they were given. See the example of [`Session::add_rule`].
    pub fn rules(&self) -> &[Prohibition] {
        self.world.prohibitions()
    }

    /// Ends the instruction, and puts the constraints of a plan that offers them in force. A rule that is in force
    /// already stays.
    pub(super) fn keep_rules(&mut self, proposal: &Proposal) {
        self.stage = Stage::Idle;
        self.events.push(Event::Cancel);
        let goal = proposal.goal.iter();
        let texts: Vec<String> = goal.flat_map(|goal| goal.exact(&self.world)).collect();
        for text in texts {
            // The session is between instructions, and the text was written for this world.
            let _ = self.add_rule(&text);
        }
    }

    fn between_instructions(&self, what: &'static str) -> Result<(), OutOfTurn> {
        match self.stage {
            Stage::Idle | Stage::Stuck(..) => Ok(()),
            _ => Err(self.out_of_turn(what)),
        }
    }
}
