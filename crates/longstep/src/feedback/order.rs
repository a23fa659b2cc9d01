//! Another reading of words about the steps, for when the first one cannot be had.
//!
//! "Open the fridge first" may insert a step or move one that the plan has. A model writes one of the two.

use super::StepWish;
use super::amend::{Amendment, unrepaired};
use super::reference::References;
use crate::environment::World;
use crate::model::plain_words;
use crate::plan::{Plan, Step};
use crate::verify::Purpose;
use longstep_core::model::Domain;

const EARLIER: [&str; 5] = ["first", "earlier", "sooner", "before", "beforehand"];
const LATER: [&str; 7] = ["later", "after", "afterwards", "last", "finally", "end", "then"];

/// Reads the insertion of a step that the plan has already as a wish about the order of its steps: the step, or the
/// steps around it that handle the same entity, are moved to where the words say. Repair is not tried: it could make
/// any order possible by doing the step twice.
pub(crate) fn reordered(
    world: &World,
    plan: &Plan,
    words: &str,
    wishes: &[StepWish],
    purpose: &Purpose,
) -> Option<Amendment> {
    let domain = world.domain();
    let [StepWish::Insert { action, arguments, .. }] = wishes else {
        return None;
    };
    let order = Order::of(world, plan, words);
    if !order.is_given() {
        return None;
    }
    let shown = &domain.action(*action).explicit;
    let is_meant = |step: &Step| {
        step.action == *action
            && shown
                .iter()
                .all(|parameter| arguments[*parameter] == Some(step.arguments[*parameter]))
    };
    let steps = plan.steps();
    for at in (0..steps.len()).filter(|at| is_meant(&steps[*at])) {
        for (begin, end) in blocks(domain, steps, at) {
            for before in order.places(begin, end, steps.len()) {
                let moved: Vec<StepWish> = (begin..end).map(|step| StepWish::Move { step, before }).collect();
                if let Some(amendment) = unrepaired(world, plan, &moved, purpose) {
                    return Some(amendment);
                }
            }
        }
    }
    None
}

/// Runs of consecutive steps around one that all handle the same entity, the shortest first.
fn blocks(domain: &Domain, steps: &[Step], at: usize) -> Vec<(usize, usize)> {
    let object = steps[at].object(domain).or(steps[at].arguments.first().copied());
    let handles = |step: &Step| object.is_some_and(|object| step.arguments.contains(&object));
    let before = steps[..at].iter().rev().take_while(|step| handles(step)).count();
    let after = steps[at + 1..].iter().take_while(|step| handles(step)).count();
    let begins = at - before..=at;
    let mut blocks: Vec<(usize, usize)> = begins
        .flat_map(|begin| (at + 1..=at + 1 + after).map(move |end| (begin, end)))
        .collect();
    blocks.sort_by_key(|(begin, end)| end - begin);
    blocks
}

/// The order of steps that words ask for.
struct Order {
    /// Places that they name.
    places: Vec<usize>,
    earlier: bool,
    later: bool,
}

impl Order {
    fn of(world: &World, plan: &Plan, words: &str) -> Self {
        let references = References::of(world, plan, words);
        let tokens = plain_words(words);
        let has = |list: &[&str]| tokens.iter().any(|token| list.contains(&token.as_str()));
        Self {
            places: references.places,
            earlier: has(&EARLIER),
            later: has(&LATER),
        }
    }

    fn is_given(&self) -> bool {
        !self.places.is_empty() || self.earlier != self.later
    }

    /// The places to which steps `begin..end` of `length` can be moved.
    fn places(&self, begin: usize, end: usize, length: usize) -> Vec<usize> {
        let changes = |place: &usize| !(begin..=end).contains(place);
        match (self.places.is_empty(), self.later) {
            (false, _) => self.places.iter().copied().filter(changes).collect(),
            (true, false) => (0..begin).collect(),
            (true, true) => (end + 1..=length).rev().collect(),
        }
    }
}
