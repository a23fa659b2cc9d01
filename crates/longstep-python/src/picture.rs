//! Pictures of plans, as notebooks show them.

use longstep_core::verify::VerifiedPlan;
use longstep_core::visible;
use longstep_picture::SvgOptions;
use longstep_picture::plan::{Annotations, Diagram, svg};

/// The width of a picture in a notebook, in pixels.
pub(crate) const WIDTH: f64 = 720.0;

/// Draws a plan with the reasons of its steps; every text is escaped.
pub(crate) fn plan(plan: &VerifiedPlan, annotations: &Annotations, width: f64, title: &str) -> String {
    let options = SvgOptions::new(width).with_title(title);
    visible::block(&svg(&Diagram::of(plan, annotations), &options)).into_owned()
}
