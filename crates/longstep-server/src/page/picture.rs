//! Pictures of scenes: of a world, and before and after each step of a plan.


use longstep_core::model::{State, Voice, World};
use longstep_core::verify::VerifiedPlan;
use maud::{Markup, html};

/// Returns the rules for pictures.
pub(super) fn stylesheet() -> String {
    String::new()
}

/// A step with the states before and after it.
pub(super) struct Moment {
    pub(super) step: Option<usize>,
    pub(super) text: String,
    pub(super) way: Vec<String>,
    pub(super) outcome: Option<String>,
    pub(super) changes: Vec<String>,
    before: State,
    after: State,
}

/// Returns the moments of a plan: the beginning, then the steps in reading order.
pub(super) fn moments(plan: &VerifiedPlan) -> Vec<Moment> {
    let world = plan.world();
    let mut found = vec![Moment {
        step: None,
        text: String::new(),
        way: Vec::new(),
        outcome: None,
        changes: Vec::new(),
        before: world.state.clone(),
        after: world.state.clone(),
    }];
    for ending in plan.endings() {
        let mut state = world.state.clone();
        for (id, changes) in ending.trace.steps() {
            let before = state.clone();
            for change in changes {
                state.set(change.fact, change.holds);
            }
            if found.iter().all(|own| own.step != Some(id.index())) {
                found.push(Moment {
                    step: Some(id.index()),
                    text: plan.plan().step(id).explanation.clone(),
                    way: Vec::new(),
                    outcome: None,
                    changes: changes.iter().map(|own| Voice::Person.fact(world, own.fact, own.holds)).collect(),
                    before,
                    after: state.clone(),
                });
            }
        }
    }
    found.sort_by_key(|own| own.step);
    found
}

impl Moment {
    pub(super) fn before(&self, world: &World) -> Markup {
        drawn(world, &self.before)
    }

    pub(super) fn after(&self, world: &World) -> Markup {
        drawn(world, &self.after)
    }
}

/// Draws a world.
pub(super) fn of_world(world: &World) -> Markup {
    drawn(world, &world.state)
}

fn drawn(world: &World, _state: &State) -> Markup {
    html! { pre { (format!("{:?}", world.environment())) } }
}
