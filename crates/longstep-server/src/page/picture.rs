//! Pictures of scenes: of a world, and before and after each step of a plan.

use longstep_core::environment::World;
use longstep_core::model::State;
use longstep_core::verify::VerifiedPlan;
use longstep_picture::scene::{self, Changes, Scene};
use longstep_picture::{Frame, SvgOptions};
use maud::{Markup, PreEscaped};

/// The width in which a picture is drawn that has a place for itself: that of a phone. Wider places show it larger.
const WIDTH: f64 = 360.0;

/// The width of each of two pictures beside each other.
const HALF: f64 = 280.0;

/// Returns the rules for pictures.
pub(super) fn stylesheet() -> String {
    longstep_picture::stylesheet()
}

/// A step of a plan with the scene around it.
pub(super) struct Moment {
    /// The step with its states.
    pub(super) frame: Frame,
    /// The changes of the step, in words.
    pub(super) changes: Vec<String>,
}

/// Returns the moments of a plan: the beginning, then the steps in reading order.
pub(super) fn moments(plan: &VerifiedPlan) -> Vec<Moment> {
    let frames = longstep_picture::frames(plan).into_iter();
    let moment = |frame: Frame| Moment {
        changes: words(plan.world(), &frame.changes),
        frame,
    };
    frames.map(moment).collect()
}

impl Moment {
    /// Draws the scene before the step.
    pub(super) fn before(&self, world: &World) -> Markup {
        draw(
            world,
            self.frame.before(),
            &Changes::default(),
            ("before", HALF),
            "Scene before the step",
        )
    }

    /// Draws the scene after the step, with its changes marked.
    pub(super) fn after(&self, world: &World) -> Markup {
        draw(
            world,
            self.frame.after(),
            &self.frame.changes,
            ("after", HALF),
            "Scene after the step",
        )
    }
}

/// Draws a world.
pub(super) fn of_world(world: &World) -> Markup {
    draw(world, &world.state, &Changes::default(), ("known", WIDTH), "The scene")
}

/// Draws a world, with the changes since an earlier state of it marked.
pub(super) fn since(world: &World, earlier: &World) -> Markup {
    let changes = difference(world, &earlier.state, &world.state);
    draw(
        world,
        &world.state,
        &changes,
        ("known", WIDTH),
        "The scene as it is known now",
    )
}

/// Describes the difference between two states of a world.
pub(super) fn changes_between(world: &World, before: &State, after: &State) -> Vec<String> {
    words(world, &difference(world, before, after))
}

fn difference(world: &World, before: &State, after: &State) -> Changes {
    Scene::difference(&Scene::of(world, before), &Scene::of(world, after))
}

fn draw(world: &World, state: &State, changes: &Changes, (prefix, width): (&str, f64), title: &str) -> Markup {
    let options = SvgOptions::new(width)
        .with_prefix(prefix)
        .with_title(title)
        .without_style();
    PreEscaped(scene::svg(&Scene::of(world, state), changes, &options))
}

/// Writes changes as short sentences.
fn words(world: &World, changes: &Changes) -> Vec<String> {
    // What is no entity is the robot itself.
    let name = |id: &String| {
        world
            .find(id)
            .map_or_else(|| "robot".to_owned(), |own| world.entity(own).name.clone())
    };
    let mut words = Vec::new();
    for moved in &changes.moved {
        let from = moved
            .from
            .as_ref()
            .map(|id| format!(" (before: {})", name(id)))
            .unwrap_or_default();
        let to = match (&moved.to, moved.relation) {
            (Some(to), Some(relation)) => format!("{} {}", relation.word(), name(to)),
            _ => "lifted".to_owned(),
        };
        words.push(format!("{}: {to}{from}", name(&moved.id)));
    }
    for change in &changes.states {
        let gained = change.gained.iter().map(|text| format!("now {text}"));
        let lost = change.lost.iter().map(|text| format!("no longer {text}"));
        let texts: Vec<String> = gained.chain(lost).chain(change.happened.iter().cloned()).collect();
        words.push(format!("{}: {}", name(&change.id), texts.join(", ")));
    }
    words.extend(changes.appeared.iter().map(|id| format!("{}: new", name(id))));
    words.extend(changes.gone.iter().map(|id| format!("{}: gone", name(id))));
    words.extend(changes.now.iter().map(|text| format!("now: {text}")));
    words.extend(changes.no_longer.iter().map(|text| format!("no longer: {text}")));
    words
}
