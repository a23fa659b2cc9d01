//! The relations between the boxes of a scene, with the measures behind them.

use super::scene::{Body, Kind, Scene};
use super::solid::{SideContact, Solid, gap_from_above, side_contact};
use crate::effort;

/// A relation between two boxes, or of one box, with its reason.
#[derive(Debug, Clone)]
pub(super) struct Related {
    pub(super) subject: usize,
    pub(super) relation: Found,
    pub(super) reason: String,
}

/// The relation of a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Found {
    On(usize),
    Inside(usize),
    NextTo(usize),
    Held { hand: usize },
    Open,
    Closed,
}

/// A box that fits no world, or several.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct SceneFinding {
    /// The kind.
    pub kind: SceneFindingKind,
    /// The names of the boxes.
    pub names: Vec<String>,
    /// The finding as a sentence, with the measures.
    pub text: String,
}

/// The kind of a [`SceneFinding`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum SceneFindingKind {
    /// A box is above the floor, and nothing carries it.
    Floating,
    /// A box rests on two others, neither of which carries the other.
    TwoSupports,
    /// A box is in two others, neither of which is in the other.
    TwoContainers,
    /// Two boxes are partly in each other.
    Cut,
}

/// The relations of a scene and its findings.
#[derive(Debug, Default)]
pub(super) struct Relations {
    pub(super) related: Vec<Related>,
    pub(super) findings: Vec<SceneFinding>,
}

/// A box that another one may rest on.
#[derive(Debug, Clone, Copy)]
struct Supporter {
    place: usize,
    gap: f64,
    share: f64,
}

/// A box that another one is in.
#[derive(Debug, Clone, Copy)]
struct Container {
    place: usize,
    share: f64,
}

/// The place of a box.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Place {
    On(usize),
    Inside(usize),
}

pub(super) fn relations(scene: &Scene) -> Relations {
    let mut finder = Finder::new(scene);
    finder.hold();
    for subject in 0..scene.boxes.len() {
        finder.place(subject);
    }
    for (index, body) in scene.boxes.iter().enumerate() {
        finder.joint(index, body);
    }
    finder.neighbours();
    finder.cuts();
    finder.floating();
    finder.relations
}

struct Finder<'a> {
    scene: &'a Scene,
    solids: Vec<Solid>,
    /// The box of which each box is a part, through all levels.
    wholes: Vec<usize>,
    containers: Vec<Vec<Container>>,
    supports: Vec<Vec<Supporter>>,
    places: Vec<Option<Place>>,
    held: Vec<bool>,
    /// The height of the lowest point of the scene.
    floor: f64,
    relations: Relations,
}

impl<'a> Finder<'a> {
    fn new(scene: &'a Scene) -> Self {
        let solids: Vec<Solid> = scene.boxes.iter().map(Solid::of).collect();
        let mut finder = Self {
            scene,
            wholes: wholes(&scene.boxes),
            containers: vec![Vec::new(); solids.len()],
            supports: vec![Vec::new(); solids.len()],
            places: vec![None; solids.len()],
            held: vec![false; solids.len()],
            floor: solids.iter().map(|solid| solid.low[2]).fold(f64::INFINITY, f64::min),
            relations: Relations::default(),
            solids,
        };
        finder.compare();
        finder
    }

    fn name(&self, index: usize) -> &'a str {
        &self.scene.boxes[index].name
    }

    /// Returns true if both boxes are parts of one thing, or one is a part of the other.
    fn is_one_thing(&self, a: usize, b: usize) -> bool {
        self.wholes[a] == self.wholes[b]
    }

    fn is_part(&self, index: usize) -> bool {
        self.wholes[index] != index
    }

    /// Finds the possible containers and supports of every box.
    fn compare(&mut self) {
        let tolerances = self.scene.tolerances;
        for subject in 0..self.solids.len() {
            for place in 0..self.solids.len() {
                let (solid, other) = (&self.solids[subject], &self.solids[place]);
                if subject == place || self.is_one_thing(subject, place) || !solid.is_near(other, tolerances.contact) {
                    continue;
                }
                if !effort::spend(16) {
                    return;
                }
                if !self.scene.boxes[place].solid && solid.volume() < other.volume() {
                    let share = solid.share_in(other);
                    if share >= tolerances.containment {
                        self.containers[subject].push(Container { place, share });
                        continue;
                    }
                }
                // Sheets that are thinner than the tolerance touch from both sides: the higher one rests on the other.
                let Some(top) = other.top().filter(|_| solid.centre[2] > other.centre[2]) else {
                    continue;
                };
                let (gap, share) = top.under(solid);
                if gap.abs() <= tolerances.contact && share >= tolerances.overlap {
                    self.supports[subject].push(Supporter { place, gap, share });
                }
            }
        }
    }

    fn is_within(&self, index: usize, container: usize) -> bool {
        let directly = self.containers[index].iter().any(|own| own.place == container);
        directly || self.is_one_thing(index, container)
    }

    /// Finds the place of a box. A box on a shelf in a cupboard is on the shelf; a box in a bin that stands on the same
    /// table is in the bin.
    fn place(&mut self, subject: usize) {
        if self.is_part(subject) {
            return;
        }
        let container = self.container(subject);
        let support = self.support(subject, container);
        let name = self.name(subject);
        let (relation, place, reason) = match (support, container) {
            (Some(support), _) => {
                let other = self.name(support.place);
                let (gap, share) = (height(support.gap), percent(support.share));
                let reason = format!(
                    "{name} is on {other}: its lowest point is {gap} the top of {other}, and {share} of it is over {other}"
                );
                (Found::On(support.place), Place::On(support.place), reason)
            }
            (None, Some(container)) => {
                let other = self.name(container.place);
                let reason = format!(
                    "{name} is in {other}: {} of its volume is in {other}",
                    percent(container.share)
                );
                (Found::Inside(container.place), Place::Inside(container.place), reason)
            }
            (None, None) => {
                let Some((place, contact)) = self.attached(subject) else {
                    return;
                };
                let other = self.name(place);
                let reason = format!(
                    "{name} is on the side of {other}: nothing is below it, the gap between their faces is {}, and {} of \
                     it faces {other}",
                    millimetres(contact.gap),
                    percent(contact.share)
                );
                (Found::On(place), Place::On(place), reason)
            }
        };
        self.places[subject] = Some(place);
        self.relate(subject, relation, reason);
    }

    fn relate(&mut self, subject: usize, relation: Found, reason: String) {
        self.relations.related.push(Related {
            subject,
            relation,
            reason,
        });
    }

    fn report(&mut self, kind: SceneFindingKind, boxes: &[usize], text: String) {
        let names = boxes.iter().map(|index| self.name(*index).to_owned()).collect();
        self.relations.findings.push(SceneFinding { kind, names, text });
    }

    /// Returns the smallest container of a box.
    fn container(&mut self, subject: usize) -> Option<Container> {
        let volume = |container: &&Container| self.solids[container.place].volume();
        let all = &self.containers[subject];
        let smallest = *all.iter().min_by(|a, b| volume(a).total_cmp(&volume(b)))?;
        let stranger = all
            .iter()
            .copied()
            .find(|other| other.place != smallest.place && !self.is_within(smallest.place, other.place));
        if let Some(other) = stranger {
            let (name, first, second) = (self.name(subject), self.name(smallest.place), self.name(other.place));
            let text = format!(
                "{name} is in {first} and in {second}: {} and {} of its volume; {first} is assumed",
                percent(smallest.share),
                percent(other.share)
            );
            self.report(
                SceneFindingKind::TwoContainers,
                &[subject, smallest.place, other.place],
                text,
            );
        }
        Some(smallest)
    }

    /// Returns the box on which a box rests. With a container only what is in the container too counts.
    fn support(&mut self, subject: usize, container: Option<Container>) -> Option<Supporter> {
        let within =
            |support: &&Supporter| container.is_none_or(|container| self.is_within(support.place, container.place));
        let fitting: Vec<Supporter> = self.supports[subject].iter().filter(within).copied().collect();
        let carries = |lower: &Supporter, upper: &Supporter| {
            self.supports[upper.place].iter().any(|own| own.place == lower.place)
        };
        let is_upper = |support: &&Supporter| !fitting.iter().any(|upper| carries(support, upper));
        let mut uppers: Vec<Supporter> = fitting.iter().filter(is_upper).copied().collect();
        uppers.sort_by(|a, b| b.share.total_cmp(&a.share));
        if let [first, second, ..] = uppers[..]
            && !self.is_one_thing(first.place, second.place)
        {
            let (name, one, other) = (self.name(subject), self.name(first.place), self.name(second.place));
            let text = format!(
                "{name} rests on {one} and on {other}: {} and {} of it; {one} is assumed",
                percent(first.share),
                percent(second.share)
            );
            self.report(
                SceneFindingKind::TwoSupports,
                &[subject, first.place, second.place],
                text,
            );
        }
        uppers.first().copied()
    }

    /// Returns the larger box to whose side a box is attached that nothing carries.
    fn attached(&self, subject: usize) -> Option<(usize, SideContact)> {
        let solid = &self.solids[subject];
        let is_free = self.scene.boxes[subject].kind != Some(Kind::Asset) && !self.held[subject];
        if !is_free || !self.is_above_floor(subject) {
            return None;
        }
        let tolerances = self.scene.tolerances;
        let is_other = |other: &usize| {
            !self.is_one_thing(subject, *other)
                && solid.volume() < self.solids[*other].volume()
                && solid.is_near(&self.solids[*other], tolerances.contact)
        };
        let contacts = (0..self.solids.len()).filter(is_other);
        let contacts = contacts.filter_map(|other| Some((other, side_contact(solid, &self.solids[other])?)));
        contacts
            .filter(|(_, contact)| contact.gap.abs() <= tolerances.contact && contact.share >= tolerances.overlap)
            .max_by(|(_, a), (_, b)| a.share.total_cmp(&b.share))
    }

    fn is_above_floor(&self, index: usize) -> bool {
        self.solids[index].low[2] > self.floor + self.scene.tolerances.contact
    }

    /// Finds what the closed hands hold: the box at the hand with the nearest centre.
    fn hold(&mut self) {
        let margin = self.scene.tolerances.grasp;
        for (index, hand) in self.scene.hands.iter().enumerate().filter(|(_, hand)| hand.closed) {
            let distance = |body: &usize| self.solids[*body].distance_to_centre(hand.position);
            let at = (0..self.solids.len()).filter(|body| self.solids[*body].contains(hand.position, margin));
            let Some(held) = at.min_by(|a, b| distance(a).total_cmp(&distance(b))) else {
                continue;
            };
            let reason = format!(
                "{} is held: {} is closed, {} from its centre",
                self.name(held),
                hand.name,
                millimetres(distance(&held))
            );
            self.held[held] = true;
            self.relate(held, Found::Held { hand: index }, reason);
        }
    }

    fn joint(&mut self, index: usize, body: &Body) {
        let name = &body.name;
        let (open, reason) = match (body.open, body.joint) {
            (Some(open), _) => (open, "the scene says so".to_owned()),
            (None, Some(joint)) => {
                let way = (joint.position - joint.closed).abs();
                let reason = format!("its joint is at {:.3}, {way:.3} from closed", joint.position);
                (way > self.scene.tolerances.joint, reason)
            }
            (None, None) => return,
        };
        let (relation, word) = if open {
            (Found::Open, "open")
        } else {
            (Found::Closed, "closed")
        };
        self.relate(index, relation, format!("{name} is {word}: {reason}"));
    }

    /// Finds boxes of one place that are close together, at heights that overlap.
    fn neighbours(&mut self) {
        let most = self.scene.tolerances.neighbour;
        for one in 0..self.solids.len() {
            for other in one + 1..self.solids.len() {
                let (a, b) = (&self.solids[one], &self.solids[other]);
                let is_alone = self.is_part(one) || self.is_part(other) || self.held[one] || self.held[other];
                let nested = self.is_within(one, other) || self.is_within(other, one);
                let is_beside = a.high[2].min(b.high[2]) - a.low[2].max(b.low[2]) > self.scene.tolerances.contact;
                if is_alone || nested || self.places[one] != self.places[other] || !is_beside || !a.is_near(b, most) {
                    continue;
                }
                if !effort::spend(16) {
                    return;
                }
                let gap = gap_from_above(a, b);
                // Boxes that are in each other are reported, and no neighbours.
                if gap > most || a.depth(b) > self.scene.tolerances.contact {
                    continue;
                }
                for (subject, neighbour) in [(one, other), (other, one)] {
                    let reason = format!(
                        "{} is next to {}: the gap between them is {}",
                        self.name(subject),
                        self.name(neighbour),
                        millimetres(gap)
                    );
                    self.relate(subject, Found::NextTo(neighbour), reason);
                }
            }
        }
    }

    /// Reports boxes that are partly in each other.
    fn cuts(&mut self) {
        for one in 0..self.solids.len() {
            for other in one + 1..self.solids.len() {
                let (a, b) = (&self.solids[one], &self.solids[other]);
                let nested = self.is_within(one, other) || self.is_within(other, one);
                if nested || !a.is_near(b, 0.0) {
                    continue;
                }
                if !effort::spend(16) {
                    return;
                }
                let depth = a.depth(b);
                let share = a.share_in(b).max(b.share_in(a));
                if depth > self.scene.tolerances.contact && share > 0.0 {
                    let text = format!(
                        "{} and {} are in each other: {} deep, {} of the volume of one of them",
                        self.name(one),
                        self.name(other),
                        millimetres(depth),
                        percent(share)
                    );
                    self.report(SceneFindingKind::Cut, &[one, other], text);
                }
            }
        }
    }

    /// Reports boxes that nothing carries.
    fn floating(&mut self) {
        for (index, body) in self.scene.boxes.iter().enumerate() {
            let is_carried = self.places[index].is_some() || self.held[index] || self.is_part(index);
            let may_float = match body.kind {
                Some(Kind::Asset) => true,
                Some(Kind::Object) => false,
                None => !self.is_above_floor(index),
            };
            if is_carried || may_float {
                continue;
            }
            let above = millimetres(self.solids[index].low[2] - self.floor);
            let contact = millimetres(self.scene.tolerances.contact);
            let text = format!(
                "{} is on nothing: it is {above} above the lowest point of the scene, and no box is within {contact} of it",
                body.name
            );
            self.report(SceneFindingKind::Floating, &[index], text);
        }
    }
}

/// Returns the outermost whole of each box. A circle of parts ends at the box in which it begins.
fn wholes(boxes: &[Body]) -> Vec<usize> {
    let by_name: rustc_hash::FxHashMap<&str, usize> = boxes
        .iter()
        .enumerate()
        .map(|(index, body)| (body.name.as_str(), index))
        .collect();
    let parent = |index: usize| by_name.get(boxes[index].part_of.as_deref()?).copied();
    let whole = |index: usize| {
        let mut at = index;
        for _ in 0..boxes.len() {
            match parent(at) {
                Some(next) if next != index => at = next,
                _ => break,
            }
        }
        at
    };
    (0..boxes.len()).map(whole).collect()
}

fn height(gap: f64) -> String {
    let side = if gap < 0.0 { "below" } else { "above" };
    format!("{} {side}", millimetres(gap.abs()))
}

fn millimetres(metres: f64) -> String {
    format!("{:.0} mm", metres * 1000.0)
}

fn percent(share: f64) -> String {
    format!("{:.0} %", share * 100.0)
}
