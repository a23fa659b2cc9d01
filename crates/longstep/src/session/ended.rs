//! Accepted plans with several possible endings.

use super::{Accepted, Event, OutOfTurn, Session, Stage};
use crate::environment::{Environment, Fact, Voice, World};

/// A possible ending of an accepted plan.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Ended {
    /// Sensing outcomes that distinguish it from the other endings, as sentences.
    pub when: Vec<String>,
    /// The final environment.
    pub environment: Environment,
}

/// A possible final world, with the sensing outcomes that lead to it.
#[derive(Debug, Clone)]
pub(super) struct Left {
    when: Vec<Fact>,
    pub(super) world: World,
}

impl Accepted {
    /// Returns the possible final worlds, at least one. Endings with equal worlds are merged.
    pub(super) fn leaves(&self) -> Vec<Left> {
        let mut all: Vec<Left> = Vec::new();
        for ending in self.plan.endings() {
            let world = self.before.after(ending);
            let same =
                |left: &&mut Left| left.world.environment() == world.environment() && left.world.state == world.state;
            match all.iter_mut().find(same) {
                Some(left) => left.when.retain(|fact| ending.when.contains(fact)),
                None => all.push(Left {
                    when: ending.when.clone(),
                    world,
                }),
            }
        }
        // Sensing outcomes that all endings share distinguish none of them.
        let common: Vec<Fact> = all[0]
            .when
            .iter()
            .copied()
            .filter(|fact| all.iter().all(|left| left.when.contains(fact)))
            .collect();
        for left in &mut all {
            left.when.retain(|fact| !common.contains(fact));
        }
        all
    }
}

impl Session {
    /// Continues after an accepted plan. With one possible final world, the session enters it; with several, it waits
    /// for the ending.
    pub(super) fn carry_on(&mut self, accepted: Accepted) {
        self.extend_pending();
        let mut left = accepted.leaves();
        self.accepted.push(accepted);
        self.stage = match left.len() {
            1 => {
                self.world = left.remove(0).world;
                Stage::Idle
            }
            _ => Stage::Ending(left),
        };
    }

    /// Returns the possible endings of the last accepted plan if it has several, else an empty list. See the example of
    /// [`Session::ended`].
    pub fn endings(&self) -> Vec<Ended> {
        let Stage::Ending(left) = &self.stage else {
            return Vec::new();
        };
        let ended = |left: &Left| Ended {
            when: left
                .when
                .iter()
                .map(|fact| Voice::Person.fact(&self.world, *fact, true))
                .collect(),
            environment: left.world.environment().clone(),
        };
        left.iter().map(ended).collect()
    }

    /// Selects one of [`Session::endings`], from 0. The next instruction starts there.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, Settings};
    /// # let planner = Planner::shipped("household-checks")?;
    /// # let world = planner.world(r#"{"assets": ["<worktop>", "<shelf>", "<trash_bin>"], "objects": ["<cheese>"],
    /// #     "object_states": {"<cheese>": "on_something(<worktop>)"}}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// session.instruct("If the cheese has expired put it in the trash bin, otherwise on the shelf")?;
    /// let goal = "if expired(cheese) then put(cheese, trash bin) else put(cheese, shelf)";
    /// let reply = format!(r#"{{"question": "", "goal": "{goal}", "left_out": []}}"#);
    /// # session.next_request(&mut EstimatedTokens::default())?;
    /// session.supply(&Reply::complete(&reply), 740.0)?;
    /// session.accept()?;
    /// let when: Vec<String> = session.endings().into_iter().flat_map(|ending| ending.when).collect();
    /// assert_eq!(when, ["the cheese is not past its date", "the cheese is past its date"]);
    /// session.ended(1)?;
    /// assert!(session.endings().is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// No ending is open, or the number is too large.
    pub fn ended(&mut self, number: usize) -> Result<(), OutOfTurn> {
        let Stage::Ending(left) = &mut self.stage else {
            return Err(self.out_of_turn("how a plan ended"));
        };
        if number >= left.len() {
            return Err(OutOfTurn {
                what: "that ending",
                state: "knows no such ending of the last plan",
            });
        }
        self.world = left.swap_remove(number).world;
        self.stage = Stage::Idle;
        self.events.push(Event::Ended {
            number,
            environment: Box::new(self.world.environment().clone()),
        });
        Ok(())
    }
}
