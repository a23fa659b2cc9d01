//! The preconditions of a step as condition leaves.

use super::element::Element;
use super::write::{NUMBERS, TEST, WriteError, Writer};
use crate::plan::StepId;
use longstep_model::environment::Voice;
use longstep_model::model::{Bindings, Condition, EntityId, Slot, TypeId, ground, static_value};

/// The most leaves before one step.
const MOST: usize = 2_000;

/// A condition in one world: known in all its states, or to be checked.
enum Check {
    Known(bool),
    Open(Element),
}

/// Why a check cannot be written.
enum Stop {
    /// The preconditions are too many.
    TooMany,
    Other(WriteError),
}

impl From<WriteError> for Stop {
    fn from(error: WriteError) -> Self {
        Self::Other(error)
    }
}

impl Writer<'_> {
    /// Returns the checks before a step; empty if its preconditions hold in every state.
    pub(super) fn guard(&mut self, id: StepId) -> Result<Vec<Element>, WriteError> {
        let world = self.world;
        let step = self.plan.step(id);
        let condition = &world.domain().action(step.action).precondition;
        let mut bindings = step.arguments.clone();
        let mut left = MOST;
        let mut checks = Vec::new();
        for part in condition.conjuncts() {
            let check = self.check(part, &mut bindings, &mut left).map_err(|stop| match stop {
                Stop::TooMany => WriteError::Guard {
                    step: id.index() + 1,
                    call: step.call(world).to_string(),
                    limit: MOST,
                },
                Stop::Other(error) => error,
            })?;
            match check {
                Check::Known(true) => {}
                Check::Known(false) => checks.push(Element::new("AlwaysFailure")),
                Check::Open(check) => checks.push(check),
            }
        }
        Ok(checks)
    }

    fn check(&mut self, condition: &Condition, bindings: &mut Bindings, left: &mut usize) -> Result<Check, Stop> {
        if let Some(value) = static_value(self.world, condition, bindings) {
            return Ok(Check::Known(value));
        }
        let Some(fewer) = left.checked_sub(1) else {
            return Err(Stop::TooMany);
        };
        *left = fewer;
        match condition {
            Condition::And(parts) => {
                self.several(parts.iter().map(|part| (part, None)).collect(), true, bindings, left)
            }
            Condition::Or(parts) => {
                self.several(parts.iter().map(|part| (part, None)).collect(), false, bindings, left)
            }
            Condition::Forall(slot, kind, inner) => self.quantified((*slot, *kind), inner, true, bindings, left),
            Condition::Exists(slot, kind, inner) => self.quantified((*slot, *kind), inner, false, bindings, left),
            Condition::Atom { atom, holds, .. } => {
                let leaf = self.fact(ground(atom, bindings))?;
                let check = if *holds {
                    leaf
                } else {
                    Element::new("Inverter").holding([leaf])
                };
                Ok(Check::Open(check))
            }
            // Its value is known.
            Condition::Equal { .. } => Ok(Check::Known(true)),
            Condition::Number(test) => {
                self.numbers = true;
                let text = Voice::Person.requirement(self.world, &test.ground(self.world, bindings));
                Ok(Check::Open(Element::new(NUMBERS).with(TEST, text)))
            }
        }
    }

    fn quantified(
        &mut self,
        (slot, kind): (Slot, TypeId),
        inner: &Condition,
        is_all: bool,
        bindings: &mut Bindings,
        left: &mut usize,
    ) -> Result<Check, Stop> {
        let entities = self.world.of_kind(kind);
        let parts = entities.iter().map(|entity| (inner, Some((slot, *entity)))).collect();
        self.several(parts, is_all, bindings, left)
    }

    /// Joins conditions, each with an entity for a slot: all of them, or one of them.
    fn several(
        &mut self,
        parts: Vec<(&Condition, Option<(Slot, EntityId)>)>,
        is_all: bool,
        bindings: &mut Bindings,
        left: &mut usize,
    ) -> Result<Check, Stop> {
        let mut open = Vec::new();
        for (part, bound) in parts {
            let length = bindings.len();
            if let Some((slot, entity)) = bound {
                if bindings.len() <= slot {
                    bindings.resize(slot + 1, entity);
                }
                bindings[slot] = entity;
            }
            let check = self.check(part, bindings, left)?;
            bindings.truncate(length);
            match check {
                Check::Known(value) if value != is_all => return Ok(Check::Known(value)),
                Check::Known(_) => {}
                Check::Open(element) => open.push(element),
            }
        }
        Ok(match open.len() {
            0 => Check::Known(is_all),
            1 => Check::Open(open.remove(0)),
            _ => Check::Open(Element::new(if is_all { "Sequence" } else { "Fallback" }).holding(open)),
        })
    }
}
