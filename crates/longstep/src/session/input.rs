//! The inputs of a session: instructions, answers, feedback and decisions of the person, its model and its settings.

use super::stage::{Stage, Turn};
use super::{Accepted, Event, ModelFacts, OutOfTurn, Session, Settings};
use crate::dialogue::{ConstraintKind, Round, Usage};

impl Session {
    /// Sets the model for the following requests.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, Response, Settings};
    /// # let planner = Planner::shipped("household")?;
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    /// #     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// session.set_model(ModelFacts::new("another", ConstraintKind::Grammar).with_context(8192));
    /// session.set_settings(Settings::default().with_rounds(1));
    /// assert_eq!((session.model().context, session.settings().rounds), (Some(8192), 1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn set_model(&mut self, model: ModelFacts) {
        self.events.push(Event::Model {
            name: model.name.clone(),
            schema: model.kind == ConstraintKind::JsonSchema,
            context: model.context,
        });
        self.model = model;
        // Without a request so far, the new model begins as it would have begun.
        if let Stage::Asking(turn, asking) = &self.stage
            && asking.is_first_of(turn)
        {
            self.stage = Stage::Asking(turn.clone(), self.ask());
        }
    }

    /// Sets the settings for the following inputs. See the example of [`Session::set_model`].
    pub fn set_settings(&mut self, settings: Settings) {
        self.events.push(Event::Settings(settings));
        self.settings = settings;
    }

    /// Starts an instruction. It replaces one that is stuck. See the [example](Self#example).
    ///
    /// # Errors
    ///
    /// Another instruction is in progress.
    pub fn instruct(&mut self, text: &str) -> Result<(), OutOfTurn> {
        match self.stage {
            Stage::Idle | Stage::Stuck(..) => {}
            _ => return Err(self.out_of_turn("an instruction")),
        }
        self.events.push(Event::Instruction { text: text.to_owned() });
        self.world.add_values(text);
        let turn = Turn {
            instruction: text.to_owned(),
            rounds: Vec::new(),
            corrections: 0,
            uncorrected: None,
            usage: Usage::default(),
            model_milliseconds: 0.0,
            proposal: None,
            rereading: None,
            readings: Vec::new(),
        };
        self.stage = Stage::Asking(turn, self.ask());
        Ok(())
    }

    /// Answers the question. See the [example](Self#example).
    ///
    /// # Errors
    ///
    /// No question is open.
    pub fn answer(&mut self, text: &str) -> Result<(), OutOfTurn> {
        let Stage::Question(turn, reply, _) = &self.stage else {
            return Err(self.out_of_turn("an answer"));
        };
        let (mut turn, reply) = (turn.clone(), reply.clone());
        self.events.push(Event::Answer { text: text.to_owned() });
        self.world.add_values(text);
        turn.readings.clear();
        turn.rounds.push(Round {
            reply,
            message: text.to_owned(),
        });
        self.stage = Stage::Asking(turn, self.ask());
        Ok(())
    }

    /// Gives feedback on the proposed plan, or on an instruction that is stuck.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, Response, Settings};
    /// # let planner = Planner::shipped("household")?;
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    /// #     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// # session.instruct("Put the pen on the shelf")?;
    /// # session.next_request(&mut EstimatedTokens::default())?;
    /// # session.supply(&Reply::complete(r#"{"question": "", "goal": "put(pen, shelf)", "left_out": []}"#), 0.0)?;
    /// session.feedback("insert another move_object() to lift the pen higher")?;
    /// session.next_request(&mut EstimatedTokens::default())?;
    /// let reply = r#"{"question": "", "goal": false, "edits": ["insert move_object() after 4"]}"#;
    /// session.supply(&Reply::complete(reply), 740.0)?;
    /// assert_eq!(session.proposal().unwrap().plan.steps().len(), 7);
    /// assert!(session.proposal().unwrap().refused.is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// There is neither a proposed plan nor a stuck instruction.
    pub fn feedback(&mut self, text: &str) -> Result<(), OutOfTurn> {
        self.world.add_values(text);
        let (mut turn, asking) = match &self.stage {
            Stage::Proposed(turn) => {
                let mut turn = turn.clone();
                let asking = self.ask_about(&mut turn, text);
                (turn, asking)
            }
            Stage::Stuck(turn, failure) => {
                let mut turn = turn.clone();
                turn.corrections = 0;
                turn.uncorrected = None;
                turn.rounds.push(Round {
                    reply: self.reply_of(failure),
                    message: text.to_owned(),
                });
                (turn, self.ask())
            }
            _ => return Err(self.out_of_turn("feedback")),
        };
        turn.readings.clear();
        self.events.push(Event::Feedback { text: text.to_owned() });
        self.stage = Stage::Asking(turn, asking);
        Ok(())
    }

    /// Accepts the plan, and answers its question ([`Proposal::question`](super::Proposal::question)) with yes. The next instruction starts in its
    /// final world. If the plan has several endings, [`Session::ended`] must select one first. If it offers a rule
    /// ([`Proposal::offers_rule`](super::Proposal::offers_rule)), the rule is put in force instead. See the [example](Self#example).
    ///
    /// # Errors
    ///
    /// No plan is proposed.
    pub fn accept(&mut self) -> Result<(), OutOfTurn> {
        let Stage::Proposed(turn) = &mut self.stage else {
            return Err(self.out_of_turn("accepting"));
        };
        let Some(proposal) = turn.proposal.take() else {
            return Err(self.out_of_turn("accepting"));
        };
        if proposal.offers_rule() {
            self.keep_rules(&proposal);
            return Ok(());
        }
        let instruction = std::mem::take(&mut turn.instruction);
        let accepted = Accepted {
            before: self.world.clone(),
            instruction,
            plan: proposal.plan,
            goal: proposal.goal,
            not_in_plan: proposal.answer.plan.not_in_plan,
        };
        self.events.push(Event::Accept {
            number: self.accepted.len(),
            instruction: accepted.instruction.clone(),
            goal: accepted.goal_texts(),
            steps: accepted.steps(&self.domain),
            plan: Box::new(accepted.file()),
        });
        self.carry_on(accepted);
        Ok(())
    }

    /// Cancels the current activity: feedback, after which the plan is proposed again, or else the instruction.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, Response, Settings};
    /// # let planner = Planner::shipped("household")?;
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    /// #     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// session.instruct("Put the pen on the shelf")?;
    /// session.cancel()?;
    /// assert!(matches!(session.response(), Response::Ready));
    /// assert!(session.cancel().is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// There is nothing to cancel.
    pub fn cancel(&mut self) -> Result<(), OutOfTurn> {
        self.stage = match std::mem::replace(&mut self.stage, Stage::Idle) {
            stage @ (Stage::Idle | Stage::Ending(_)) => {
                self.stage = stage;
                return Err(self.out_of_turn("cancelling"));
            }
            Stage::Asking(mut turn, _) | Stage::Question(mut turn, ..) if turn.proposal.is_some() => {
                turn.end_rereading();
                Stage::Proposed(turn)
            }
            _ => Stage::Idle,
        };
        self.events.push(Event::Cancel);
        Ok(())
    }

    /// Reverts the last accepted plan and returns its number. What was observed since stays as it was observed. See the
    /// [example](Self#example).
    ///
    /// # Errors
    ///
    /// An instruction is in progress, or there is no accepted plan.
    pub fn undo(&mut self) -> Result<usize, OutOfTurn> {
        if !matches!(self.stage, Stage::Idle | Stage::Stuck(..) | Stage::Ending(_)) {
            return Err(self.out_of_turn("undoing"));
        }
        let Some(last) = self.accepted.pop() else {
            return Err(OutOfTurn {
                what: "undoing",
                state: "has no accepted plan",
            });
        };
        // Rules that were given or lifted since stay as they are.
        let rules = self.world.prohibitions().to_vec();
        self.world = last.before;
        self.world.set_prohibitions(rules);
        self.stage = Stage::Idle;
        self.observe_again();
        let number = self.accepted.len();
        self.events.push(Event::Undo { number });
        Ok(number)
    }
}
