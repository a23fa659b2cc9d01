//! A scene as SVG.

use super::change::{Changes, Moved, StateChange};
use super::layout::{Block, ICON, Layout};
use super::{Role, Scene, SceneBox};
use crate::draw::SvgOptions;
use crate::draw::canvas::{Area, Canvas};
use crate::draw::theme::{self, Paint};

/// Names in the description of a picture.
const DESCRIBED: usize = 12;

/// Draws a scene as nested boxes, and marks the changed ones with a dashed outline and a sign: an arrow for a move, a star
/// for a state. The height follows from the content.
///
/// A box has its identifier as `data-id`, and a title with everything that the scene says of it.
///
/// ```
/// use longstep_core::{domain, environment};
/// use longstep_picture::SvgOptions;
/// use longstep_picture::scene::{self, Changes, Scene};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let world = environment::parse(&household, "env.json", r#"{"assets": ["<desk>"], "objects": ["<pen>"]}"#).unwrap();
/// let svg = scene::svg(&Scene::of(&world, &world.state), &Changes::default(), &SvgOptions::new(360.0));
/// assert!(svg.starts_with("<svg") && svg.contains("data-id=\"&lt;desk&gt;\""));
/// ```
pub fn svg(scene: &Scene, changes: &Changes, options: &SvgOptions) -> String {
    let whole = Layout::new(scene, changes, options.width).whole();
    let drawing = Drawing { scene, changes };
    let mut canvas = Canvas::default();
    drawing.whole(&mut canvas, &whole);
    let title = if options.title.is_empty() {
        "Scene"
    } else {
        &options.title
    };
    canvas.finish(
        options,
        (options.width, whole.area.height),
        title,
        &drawing.description(),
    )
}

pub(super) struct Drawing<'s> {
    pub(super) scene: &'s Scene,
    pub(super) changes: &'s Changes,
}

impl Drawing<'_> {
    /// Draws a scene that is laid out.
    pub(super) fn whole(&self, canvas: &mut Canvas, whole: &Block) {
        whole.labels.iter().for_each(|line| canvas.text(line));
        for child in &whole.children {
            self.block(canvas, child, 0);
        }
    }

    fn block(&self, canvas: &mut Canvas, block: &Block, depth: usize) {
        let Some(own) = block.index.map(|index| &self.scene.boxes[index]) else {
            return;
        };
        let moved = self.changes.moved.iter().find(|moved| moved.id == own.id);
        let state = self.changes.states.iter().find(|change| change.id == own.id);
        let is_new = self.changes.appeared.contains(&own.id);
        canvas.begin("ls-box", &[("id", &own.id)]);
        canvas.title(&self.full_text(own, moved, state));
        let (paint, radius) = appearance(own.role, depth);
        canvas.rect(block.area, radius, paint);
        if block.icon {
            icon(canvas, own.role, block);
        }
        block.labels.iter().for_each(|line| canvas.text(line));
        for child in &block.children {
            self.block(canvas, child, depth + 1);
        }
        let sign = match (moved, state) {
            (Some(_), _) => Some(Sign::Moved),
            (None, Some(_)) => Some(Sign::State),
            (None, None) if is_new => Some(Sign::New),
            (None, None) => None,
        };
        if let Some(sign) = sign {
            canvas.rect(block.area, radius, theme::CHANGED);
            mark(canvas, block.area, sign);
        }
        canvas.end();
    }

    /// Returns everything that the scene says of a box.
    fn full_text(&self, own: &SceneBox, moved: Option<&Moved>, state: Option<&StateChange>) -> String {
        let mut parts = vec![own.name.clone()];
        if let (Some(around), Some(relation)) = (own.within, own.relation) {
            parts.push(format!("{} {}", relation.word(), self.scene.boxes[around].name));
        }
        if let Some(moved) = moved {
            let from = moved.from.as_ref().and_then(|id| self.scene.find(id));
            parts.push(from.map_or_else(|| "moved".to_owned(), |from| format!("moved from {}", from.name)));
        }
        parts.extend(own.states.iter().map(|state| state.text.clone()));
        for change in state.into_iter() {
            parts.extend(change.gained.iter().map(|text| format!("now {text}")));
            parts.extend(change.lost.iter().map(|text| format!("no longer {text}")));
            parts.extend(change.happened.iter().cloned());
        }
        parts.join("; ")
    }

    /// Describes the scene for readers who do not see it: the content of the first places, and the changes.
    pub(super) fn description(&self) -> String {
        let boxes = &self.scene.boxes;
        let content = |around: usize| -> Vec<String> {
            let inside = boxes.iter().filter(|own| own.within == Some(around));
            inside.map(|own| own.name.clone()).collect()
        };
        let filled = (0..boxes.len()).map(|index| (index, content(index)));
        let filled = filled.filter(|(_, names)| !names.is_empty());
        let places = filled.map(|(index, names)| said(&boxes[index].name, names));
        let name = |id: &String| self.scene.find(id).map_or_else(|| id.clone(), |own| own.name.clone());
        let changes = self.changes;
        let told = [
            ("Moved", changes.moved.iter().map(|moved| name(&moved.id)).collect()),
            (
                "Changed",
                changes.states.iter().map(|change| name(&change.id)).collect(),
            ),
            ("New", changes.appeared.iter().map(name).collect()),
            ("Gone", changes.gone.iter().map(name).collect()),
            ("Now", changes.now.clone()),
            ("No longer", changes.no_longer.clone()),
        ];
        let told = told
            .into_iter()
            .filter(|(_, names): &(_, Vec<String>)| !names.is_empty());
        let sentences: Vec<String> = std::iter::once(format!("{} boxes.", boxes.len()))
            .chain(told.map(|(word, names)| said(word, names)))
            .chain(places.take(DESCRIBED))
            .collect();
        sentences.join(" ")
    }
}

/// Writes a list of names as a sentence, the first [`DESCRIBED`] of them.
fn said(word: &str, names: Vec<String>) -> String {
    let more = names.len().saturating_sub(DESCRIBED);
    let suffix = if more > 0 {
        format!(" and {more} more")
    } else {
        String::new()
    };
    format!("{word}: {}{suffix}.", names[..names.len() - more].join(", "))
}

/// Returns the paint and the radius of the corners.
fn appearance(role: Role, depth: usize) -> (Paint, f64) {
    match role {
        Role::Place if depth.is_multiple_of(2) => (theme::PLACE, 4.0),
        Role::Place => (theme::PLACE_INNER, 4.0),
        Role::Object | Role::Constant => (theme::OBJECT, 10.0),
        Role::Robot | Role::Actor => (theme::ROBOT, 4.0),
    }
}

/// Draws a robot's head, or a gripper.
fn icon(canvas: &mut Canvas, role: Role, block: &Block) {
    let Some(name) = block.labels.first() else { return };
    let at = (name.x - ICON, name.y - 11.0);
    if role == Role::Robot {
        let head = [(1.0, 3.0), (13.0, 3.0), (13.0, 12.0), (1.0, 12.0), (1.0, 3.0)];
        canvas.line(&head, at, theme::ICON);
        canvas.line(&[(7.0, 3.0), (7.0, 0.0)], at, theme::ICON);
        canvas.line(&[(4.5, 6.5), (4.5, 8.5)], at, theme::ICON);
        canvas.line(&[(9.5, 6.5), (9.5, 8.5)], at, theme::ICON);
    } else {
        let fingers = [(2.0, 0.0), (2.0, 5.0), (12.0, 5.0), (12.0, 0.0)];
        canvas.line(&fingers, at, theme::ICON);
        canvas.line(&[(7.0, 5.0), (7.0, 12.0)], at, theme::ICON);
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Sign {
    Moved,
    State,
    New,
}

/// Draws the sign of a change on the right upper corner.
fn mark(canvas: &mut Canvas, area: Area, sign: Sign) {
    let centre = (area.right() - 4.0, area.y + 4.0);
    canvas.circle(centre, 8.0, theme::MARK);
    match sign {
        Sign::Moved => {
            canvas.line(&[(-4.0, 0.0), (4.0, 0.0)], centre, theme::MARK_LINE);
            canvas.line(&[(1.0, -3.0), (4.0, 0.0), (1.0, 3.0)], centre, theme::MARK_LINE);
        }
        Sign::State => {
            canvas.line(&[(0.0, -4.0), (0.0, 4.0)], centre, theme::MARK_LINE);
            canvas.line(&[(-3.5, -2.0), (3.5, 2.0)], centre, theme::MARK_LINE);
            canvas.line(&[(-3.5, 2.0), (3.5, -2.0)], centre, theme::MARK_LINE);
        }
        Sign::New => {
            canvas.line(&[(0.0, -4.0), (0.0, 4.0)], centre, theme::MARK_LINE);
            canvas.line(&[(-4.0, 0.0), (4.0, 0.0)], centre, theme::MARK_LINE);
        }
    }
}
