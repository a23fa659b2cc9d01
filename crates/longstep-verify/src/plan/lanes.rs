//! Order of the steps of lanes, without simulation.

use std::collections::VecDeque;

use super::{Lane, LaneItem, StepId};

/// The remaining items of lanes, remarks left out.
pub struct Remaining<'l>(Vec<VecDeque<&'l LaneItem>>);

impl<'l> Remaining<'l> {
    /// Begins with all items of the lanes.
    pub fn of<A>(lanes: &'l [Lane<A>]) -> Self {
        Self(lanes.iter().map(|lane| lane.acts().collect()).collect())
    }

    /// Removes the next step of each lane; none for a lane that waits or is done.
    pub fn next_steps(&mut self) -> Vec<Option<StepId>> {
        self.0.iter_mut().map(next_step).collect()
    }

    /// Removes the synchronisation point that lanes pass next; returns its name and the indexes of the lanes.
    ///
    /// It is the first one that has been reached by every lane in which it is still ahead. In a deadlock, which
    /// verification reports, it is that of the first waiting lane.
    pub fn next_sync(&mut self) -> Option<(&'l str, Vec<usize>)> {
        let fronts = || self.0.iter().filter_map(|lane| lane.front());
        let waiting = || fronts().filter_map(|item| item.sync());
        let is = |item: &LaneItem, name: &str| item.sync() == Some(name);
        let met = |name: &&str| {
            let mut expecting = self.0.iter().filter(|lane| lane.iter().any(|item| is(item, name)));
            expecting.all(|lane| lane.front().is_some_and(|item| is(item, name)))
        };
        let is_stuck = || fronts().all(|item| item.sync().is_some());
        let name = waiting()
            .find(met)
            .or_else(|| waiting().next().filter(|_| is_stuck()))?;
        let passes = |lane: &usize| self.0[*lane].front().is_some_and(|item| is(item, name));
        let lanes: Vec<usize> = (0..self.0.len()).filter(passes).collect();
        for lane in &lanes {
            self.0[*lane].pop_front();
        }
        Some((name, lanes))
    }
}

fn next_step(lane: &mut VecDeque<&LaneItem>) -> Option<StepId> {
    let step = lane.front()?.step()?;
    lane.pop_front();
    Some(step)
}

/// Returns the steps of lanes in one order that their synchronisation points allow: each lane runs until it waits.
pub fn sequence<A>(lanes: &[Lane<A>]) -> Vec<StepId> {
    let mut remaining = Remaining::of(lanes);
    let mut order = Vec::new();
    loop {
        for lane in &mut remaining.0 {
            order.extend(std::iter::from_fn(|| next_step(lane)));
        }
        if remaining.next_sync().is_none() {
            return order;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(lanes: &[&str], expected: &[usize]) {
        let item = |text: &str| match text.parse() {
            Ok(step) => LaneItem::Step(StepId::new(step)),
            Err(_) => LaneItem::Sync(text.to_owned()),
        };
        let lane = |items: &&str| Lane {
            actor: (),
            items: items.split(' ').map(item).collect(),
        };
        let lanes: Vec<Lane<()>> = lanes.iter().map(lane).collect();
        let steps = sequence(&lanes).into_iter().map(StepId::index);
        assert_eq!(steps.collect::<Vec<_>>(), expected);
    }

    #[test]
    fn lanes_run_until_a_synchronization_point() {
        check(&["0 1", "2"], &[0, 1, 2]);
        check(&["0 x 1", "2 x 3"], &[0, 2, 1, 3]);
        // The third lane waits for the second one, which waits for the first one.
        check(&["0 x 1", "2 x 3 y", "y 4"], &[0, 2, 1, 3, 4]);
        check(&["x 0 y", "y 1 x"], &[0, 1]);
    }
}
