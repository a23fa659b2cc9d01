//! A drawer that is opened: its environment, its goal, and recordings of a hand that shows the plan.

use std::fmt::Write as _;

/// A closed drawer.
pub const ENV: &str = r#"{"assets": ["<floor>", "<drawer>"], "asset_states": {"<drawer>": "on_something(<floor>)"},
    "objects": ["<drawer_handle>"], "object_states": {"<drawer_handle>": "closed()"}}"#;
/// Its plan has four steps: move the hand, grasp, slide, release.
pub const GOAL: &str = "opened(drawer)";

/// Parts of a recording of the plan: the step, and the end of the hand's way in it with its grip.
const WAY: [(usize, [f64; 3], u8); 4] = [
    (1, [0.0, -0.3, 0.5], 0),
    (2, [0.0, -0.1, 0.5], 1),
    (3, [0.0, -0.35, 0.5], 1),
    (4, [0.0, -0.5, 0.6], 0),
];

/// A recording of some steps at 30 Hz. The slide is `slide` of its way.
pub fn recording(steps: &[usize], slide: f64, with_step: bool) -> String {
    let mut text = "t,hand,x,y,z,grip,grasp,elbow_x,elbow_y,elbow_z,shoulder_x,shoulder_y,shoulder_z".to_owned();
    text.push_str(if with_step { ",step" } else { "" });
    let (mut time, mut at, mut before) = (0.0, [0.2, -1.0, 0.9], 0);
    for (step, end, grip) in WAY {
        let end = [0, 1, 2].map(|axis| {
            if step == 3 {
                at[axis] + (end[axis] - at[axis]) * slide
            } else {
                end[axis]
            }
        });
        for frame in 1..=45 {
            let share = (f64::from(frame.min(40)) - 3.0).max(0.0) / 37.0;
            let [x, y, z] = [0, 1, 2].map(|axis| at[axis] + (end[axis] - at[axis]) * share);
            // The hand closes at the end of a step, and opens at its beginning.
            let closed = if grip > before {
                u8::from(frame > 41)
            } else if grip < before {
                u8::from(frame < 3)
            } else {
                grip
            };
            time += 1.0 / 30.0;
            if steps.contains(&step) {
                write!(
                    text,
                    "\n{time:.4},right,{x},{y},{z},{closed},hook,{x},{},{z},{x},{},{}",
                    y - 0.25,
                    y - 0.25,
                    z + 0.3
                )
                .unwrap();
                text.push_str(&if with_step { format!(",{step}") } else { String::new() });
            }
        }
        (at, before) = (end, grip);
    }
    text
}
