//! Reader of lanes.

use roxmltree::Node as Xml;

use super::part::{LanePart, Part};
use super::read::Reader;
use super::xml::{Fault, Scope, children, fault, no_conditions};
use super::{ACTOR, SYNC};

impl<'d, 'x: 'd> Reader<'d, 'x> {
    /// Reads lanes, and the nodes behind them that go on with the same lanes.
    pub(super) fn parallel<'n>(
        &mut self,
        node: Xml<'d, 'x>,
        mut behind: &'n [Xml<'d, 'x>],
        scope: &Scope,
        parts: &mut Vec<Part>,
    ) -> Result<&'n [Xml<'d, 'x>], Fault> {
        let mut lanes: Vec<(String, Vec<LanePart>)> = Vec::new();
        self.lanes(node, &mut lanes, scope)?;
        while let [next, rest @ ..] = behind
            && next.has_tag_name("Parallel")
            && let Some(name) = next.attribute(SYNC)
        {
            lanes
                .iter_mut()
                .for_each(|(_, items)| items.push(LanePart::Sync(name.to_owned())));
            self.lanes(*next, &mut lanes, scope)?;
            behind = rest;
        }
        self.flags.clear();
        parts.push(Part::Parallel(lanes));
        Ok(behind)
    }

    fn lanes(
        &mut self,
        node: Xml<'d, 'x>,
        lanes: &mut Vec<(String, Vec<LanePart>)>,
        scope: &Scope,
    ) -> Result<(), Fault> {
        no_conditions(node)?;
        let counts = ["success_count", "failure_count"].map(|name| node.attribute(name));
        if !matches!(counts, [None | Some("-1"), None | Some("1")]) {
            return fault(
                node,
                "lanes must all succeed, and end when one fails",
                "set success_count=\"-1\" failure_count=\"1\"",
            );
        }
        let is_first = lanes.is_empty();
        for child in children(node).into_iter().filter(|child| !child.is_comment()) {
            let Some(actor) = child.attribute(ACTOR) else {
                return fault(
                    child,
                    "a lane does not say whose it is",
                    "write <Sequence _actor=\"HAND\"> around its steps",
                );
            };
            let place = lanes.iter().position(|(other, _)| other == actor);
            let place = match place {
                Some(place) if !is_first => place,
                None if is_first => {
                    lanes.push((actor.to_owned(), Vec::new()));
                    lanes.len() - 1
                }
                _ => {
                    return fault(
                        child,
                        format!("the lane of `{actor}` is not one of those before"),
                        "keep the same lanes",
                    );
                }
            };
            for item in children(child) {
                if let (Some(name), true) = (item.attribute(SYNC), item.has_tag_name("Sequence")) {
                    lanes[place].1.push(LanePart::Sync(name.to_owned()));
                    continue;
                }
                for part in self.settled(&[item], scope)? {
                    lanes[place].1.push(match part {
                        Part::Step(step) => LanePart::Step(step),
                        Part::Remark(text) => LanePart::Remark(text),
                        _ => return fault(item, "a lane has steps only", "put branches and loops around the lanes"),
                    });
                }
            }
        }
        Ok(())
    }
}
