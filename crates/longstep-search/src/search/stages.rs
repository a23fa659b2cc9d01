//! Stages of a goal as facts and operators of a task.
//!
//! Each condition of a stage gets a fact that records that it was achieved in order, and each later stage one that
//! records that it has begun ([`Purpose::stages`](longstep_verify::verify::Purpose::stages) defines when). Operators at no cost set
//! these facts. They are no steps of the plan: each is applied as soon as it is applicable. Events count from the
//! beginning of their stage, so conditions of later stages refer to copies of them.

use rustc_hash::FxHashMap;

use super::GroundAction;
use super::formula::{Formula, Literal};
use super::grounder::{Grounder, StageEvents};
use super::operator::{GroundEffect, Operator};
use longstep_model::model::{ActionId, Fact};
use longstep_verify::verify::Milestone;

impl Grounder<'_> {
    /// Grounds the stages; returns the operators that record progress, in the order in which they apply, and the
    /// condition that all stages are complete.
    ///
    /// Operators that are grounded later have effects on the copies of events.
    pub(crate) fn stages(&mut self, stages: &[Vec<Milestone>]) -> (Vec<Operator>, Formula) {
        let mut marks = Vec::new();
        let mut complete = Formula::TRUE;
        for (index, stage) in stages.iter().enumerate() {
            let begun = (index > 0).then(|| self.extra(false));
            if let Some(begun) = begun {
                let copies = FxHashMap::default();
                self.events.push(StageEvents { begun, copies });
            }
            // The effects of the beginning, and the operators of the stage.
            let (mut begins, mut own) = (Vec::new(), Vec::new());
            let mut all = Vec::new();
            // In the first stage all events of the plan count, so its conditions need no copies.
            self.copying = index > 0;
            for Milestone { wanted, anew } in stage {
                let done = self.extra(false);
                let mut achieved = vec![Formula::literal(done, false)];
                achieved.extend(begun.map(|begun| Formula::literal(begun, true)));
                if *anew {
                    let open = self.extra(false);
                    let not = wanted.condition.clone().complement();
                    begins.push(set(open, self.formula(&not, &mut wanted.bindings.clone())));
                    achieved.push(Formula::literal(open, true));
                }
                achieved.push(self.formula(&wanted.condition, &mut wanted.bindings.clone()));
                own.push(mark(Formula::and(achieved), vec![set(done, Formula::TRUE)]));
                all.push(Formula::literal(done, true));
            }
            self.copying = false;
            if let Some(begun) = begun {
                begins.push(set(begun, Formula::TRUE));
                // Only once: `open` records what is false when the stage begins, not what becomes false later.
                marks.push(mark(Formula::and([Formula::literal(begun, false), complete]), begins));
            }
            marks.extend(own);
            complete = Formula::and(all);
        }
        (marks, complete)
    }

    /// Returns the number of the copy of an event in the stage that is being grounded; none for other facts.
    pub(super) fn copy(&mut self, fact: Fact) -> Option<u32> {
        if !self.copying || !self.domain.words(fact.predicate()).event {
            return None;
        }
        let stage = self.events.len().checked_sub(1)?;
        if let Some(number) = self.events[stage].copies.get(&fact) {
            return Some(*number);
        }
        let number = self.extra(false);
        self.events[stage].copies.insert(fact, number);
        Some(number)
    }

    /// Returns the effects of an effect that adds `fact` on the copies of that event.
    pub(super) fn copied(&self, condition: &Formula, fact: Fact) -> Vec<GroundEffect> {
        let copies = self
            .events
            .iter()
            .filter_map(|stage| Some((stage.begun, *stage.copies.get(&fact)?)));
        // Conditions refer to the state before the step: the step that completes a stage is no event of the next.
        let with_begun = |begun: u32| Formula::and([condition.clone(), Formula::literal(begun, true)]);
        copies.map(|(begun, copy)| set(copy, with_begun(begun))).collect()
    }
}

fn set(fact: u32, condition: Formula) -> GroundEffect {
    GroundEffect {
        condition,
        literal: Literal { fact, holds: true },
        may: false,
    }
}

/// Returns an operator that records progress.
fn mark(precondition: Formula, effects: Vec<GroundEffect>) -> Operator {
    Operator {
        step: GroundAction {
            action: ActionId::new(0),
            arguments: Vec::new(),
        },
        is_mark: true,
        cost: 0,
        tag: 0,
        outcome: None,
        precondition,
        effects,
        numeric: Vec::new(),
    }
}
