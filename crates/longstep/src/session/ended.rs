//! How a plan came out that can end in several ways.

use super::{Accepted, Event, OutOfTurn, Session, Stage};
use crate::environment::{Environment, Fact, Voice, World};
use crate::model::Domain;

/// A way in which an accepted plan may have ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Ended {
    /// What sensing told then, as sentences: at least what tells it from the other ways.
    pub when: Vec<String>,
    /// The environment that it left.
    pub environment: Environment,
}

/// A world that a plan may have left, and what sensing told where it did.
#[derive(Debug, Clone)]
pub(super) struct Left {
    when: Vec<Fact>,
    pub(super) world: World,
}

impl Accepted {
    /// The worlds that the next instruction may begin in, at least one. Endings that leave the same world are one.
    pub(super) fn leaves(&self, domain: &Domain) -> Vec<Left> {
        let mut all: Vec<Left> = Vec::new();
        for ending in self.plan.endings() {
            let world = self.before.after(domain, ending);
            let same =
                |left: &&mut Left| left.world.environment == world.environment && left.world.state == world.state;
            match all.iter_mut().find(same) {
                Some(left) => left.when.retain(|fact| ending.when.contains(fact)),
                None => all.push(Left {
                    when: ending.when.clone(),
                    world,
                }),
            }
        }
        // What sensing told on all of them tells none from another.
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
    /// Goes on from an accepted plan, as far as it is known how it ends.
    pub(super) fn carry_on(&mut self, accepted: Accepted) {
        let mut left = accepted.leaves(&self.domain);
        self.accepted.push(accepted);
        self.stage = match left.len() {
            1 => {
                self.world = left.remove(0).world;
                Stage::Idle
            }
            _ => Stage::Ending(left),
        };
    }

    /// In which ways the plan that was accepted last may have ended, where the session cannot know which; else none.
    pub fn endings(&self) -> Vec<Ended> {
        let Stage::Ending(left) = &self.stage else {
            return Vec::new();
        };
        let told = |left: &Left| Ended {
            when: left
                .when
                .iter()
                .map(|fact| Voice::Person.fact(&self.domain, &self.world, *fact, true))
                .collect(),
            environment: left.world.environment.clone(),
        };
        left.iter().map(told).collect()
    }

    /// Takes which of [`Session::endings`] came about, from 0: the next instruction begins there.
    ///
    /// # Errors
    ///
    /// When it is known how the last plan ended, or when it cannot have ended so.
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
            environment: Box::new(self.world.environment.clone()),
        });
        Ok(())
    }
}
