//! Scenes side by side: one, and those that it may become.

use longstep_core::environment::fact_text;
use longstep_core::verify::{Ending, VerifiedPlan};

use super::change::Changes;
use super::draw::Drawing;
use super::layout::{GAP, Layout, NAME, needs_captions};
use super::{Scene, change};
use crate::draw::SvgOptions;
use crate::draw::canvas::{Canvas, Line};
use crate::draw::text::wrapped;
use crate::draw::theme;

/// The least width of a scene that has another one beside it.
const LEAST: f64 = 240.0;

/// Lines of a heading.
const HEADING_LINES: usize = 3;

/// Draws the world before a plan beside each one that the plan can end in.
///
/// ```
/// use longstep_core::{domain, environment, plan, verify::check_file};
/// use longstep_picture::{SvgOptions, scene};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// let svg = scene::before_and_after(&plan, &SvgOptions::new(900.0));
/// assert!(svg.contains("Before the plan") && svg.contains("After the plan"));
/// ```
pub fn before_and_after(plan: &VerifiedPlan, options: &SvgOptions) -> String {
    let world = plan.world();
    let after = |ending: &Ending| {
        let outcomes: Vec<String> = ending.when.iter().map(|fact| fact_text(world, *fact, true)).collect();
        let heading = match outcomes.as_slice() {
            [] => "After the plan".to_owned(),
            outcomes => format!("After the plan, if {}", outcomes.join(" and ")),
        };
        (heading, Scene::of(world, &ending.after))
    };
    let afters: Vec<(String, Scene)> = plan.endings().iter().map(after).collect();
    let before = Scene::of(world, &world.state);
    comparison(("Before the plan", &before), &afters, options)
}

/// Draws a scene, and beside it each of those that it may become, with a heading and its differences marked as by
/// [`svg`](super::svg()). Two scenes have room beside each other, unless the picture is narrow.
///
/// ```
/// use longstep_core::{domain, environment};
/// use longstep_picture::SvgOptions;
/// use longstep_picture::scene::{self, Scene};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let world = environment::parse(&household, "env.json", r#"{"assets": ["<desk>"], "objects": ["<pen>"]}"#).unwrap();
/// let before = Scene::of(&world, &world.state);
/// let after = [("After".to_owned(), before.clone())];
/// let svg = scene::comparison(("Before", &before), &after, &SvgOptions::new(900.0));
/// assert_eq!(svg.matches("data-id=\"&lt;desk&gt;\"").count(), 2);
/// ```
pub fn comparison(before: (&str, &Scene), afters: &[(String, Scene)], options: &SvgOptions) -> String {
    let (heading, first) = before;
    let differences: Vec<Changes> = afters
        .iter()
        .map(|(_, after)| change::difference(first, after))
        .collect();
    let none = Changes::default();
    let later = afters.iter().zip(&differences);
    let panes: Vec<(&str, Drawing<'_>)> = std::iter::once((heading, first, &none))
        .chain(later.map(|((heading, scene), changes)| (heading.as_str(), scene, changes)))
        .map(|(heading, scene, changes)| (heading, Drawing { scene, changes }))
        .collect();
    let width = (options.width / 2.0).floor();
    let (columns, width) = if width < LEAST { (1, options.width) } else { (2, width) };
    let captions = panes.iter().any(|(_, drawing)| needs_captions(drawing.scene));
    let mut canvas = Canvas::default();
    let mut top = 0.0;
    for row in panes.chunks(columns) {
        let bottoms = row.iter().enumerate().map(|(column, (heading, drawing))| {
            #[expect(clippy::cast_precision_loss, reason = "there are two columns")]
            let left = column as f64 * width;
            pane(&mut canvas, heading, drawing, captions, (left, top), width)
        });
        top = bottoms.fold(top, f64::max);
    }
    let title = if options.title.is_empty() {
        "Scenes"
    } else {
        &options.title
    };
    let descriptions = panes
        .iter()
        .map(|(heading, drawing)| format!("{heading}: {}", drawing.description()));
    let description = descriptions.collect::<Vec<_>>().join(" ");
    canvas.finish(options, (options.width, top), title, &description)
}

/// Draws a heading and a scene below it. Returns the end of the scene.
fn pane(
    canvas: &mut Canvas,
    heading: &str,
    drawing: &Drawing<'_>,
    captions: bool,
    (left, top): (f64, f64),
    width: f64,
) -> f64 {
    let mut below = top + GAP;
    for text in wrapped(heading, NAME, width - 2.0 * GAP, HEADING_LINES) {
        below += NAME.line_height();
        canvas.text(&Line {
            x: left + GAP,
            y: below - 4.0,
            text,
            font: NAME,
            paint: theme::INK,
        });
    }
    let layout = Layout::new(drawing.scene, drawing.changes, width).with_captions(captions);
    let mut whole = layout.whole();
    let height = whole.area.height;
    whole.shift(left, below);
    drawing.whole(canvas, &whole);
    below + height
}
