//! Colours for light and dark pages.
//!
//! Each paint is a class with its light colours as attributes, for viewers without CSS variables, and a rule in the
//! stylesheet. A page overrides a colour by its variable, for example `--longstep-ink`.

use std::fmt::Write as _;

/// Font families, sans-serif.
pub(crate) const FONTS: &str = "system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', 'Noto Sans', sans-serif";

/// A colour with its variable: light and dark.
struct Colour {
    name: &'static str,
    light: &'static str,
    dark: &'static str,
}

/// All colours. Text has a contrast of at least 4.5 to every fill below it, and outlines one of 3.
const COLOURS: [Colour; 13] = [
    colour("paper", "#ffffff", "#14181d"),
    colour("ink", "#1b1f24", "#e8ebee"),
    colour("muted", "#57606a", "#a9b3bd"),
    colour("line", "#7d8894", "#87939f"),
    colour("place", "#f1f4f7", "#1e242b"),
    colour("place-inner", "#fbfcfd", "#272e36"),
    colour("object", "#ffffff", "#323a43"),
    colour("robot", "#e4eefb", "#16283f"),
    colour("robot-line", "#2f66b0", "#7fabe3"),
    colour("change", "#a8430b", "#ffb27a"),
    colour("change-fill", "#fff1e7", "#3b2617"),
    colour("branch", "#5b3fa8", "#bda6ff"),
    colour("branch-fill", "#f1edfb", "#2a2240"),
];

const fn colour(name: &'static str, light: &'static str, dark: &'static str) -> Colour {
    Colour { name, light, dark }
}

/// How an element is painted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Paint {
    class: &'static str,
    fill: Option<&'static str>,
    stroke: Option<&'static str>,
    stroke_width: f64,
    dash: &'static str,
}

const fn filled(class: &'static str, fill: &'static str) -> Paint {
    Paint {
        class,
        fill: Some(fill),
        stroke: None,
        stroke_width: 0.0,
        dash: "",
    }
}

const fn outlined(class: &'static str, fill: &'static str, stroke: &'static str, stroke_width: f64) -> Paint {
    Paint {
        stroke: Some(stroke),
        stroke_width,
        ..filled(class, fill)
    }
}

const fn stroked(class: &'static str, stroke: &'static str, stroke_width: f64) -> Paint {
    Paint {
        fill: None,
        stroke: Some(stroke),
        stroke_width,
        ..filled(class, "")
    }
}

pub(crate) const PAPER: Paint = filled("ls-paper", "paper");
pub(crate) const INK: Paint = filled("ls-ink", "ink");
pub(crate) const MUTED: Paint = filled("ls-muted", "muted");
pub(crate) const CHANGE_INK: Paint = filled("ls-change-ink", "change");
pub(crate) const BRANCH_INK: Paint = filled("ls-branch-ink", "branch");
pub(crate) const MARK: Paint = outlined("ls-mark", "change", "paper", 1.5);
pub(crate) const MARK_LINE: Paint = stroked("ls-mark-line", "paper", 1.8);
pub(crate) const PLACE: Paint = outlined("ls-place", "place", "line", 1.0);
pub(crate) const PLACE_INNER: Paint = outlined("ls-place-inner", "place-inner", "line", 1.0);
pub(crate) const OBJECT: Paint = outlined("ls-object", "object", "line", 1.0);
pub(crate) const ROBOT: Paint = outlined("ls-robot", "robot", "robot-line", 1.5);
pub(crate) const ICON: Paint = stroked("ls-icon", "robot-line", 1.5);
pub(crate) const CHANGED: Paint = Paint {
    dash: "7 4",
    ..stroked("ls-changed", "change", 3.0)
};

pub(crate) const ROBOT_INK: Paint = filled("ls-robot-ink", "robot-line");
pub(crate) const CARD: Paint = outlined("ls-card", "place-inner", "line", 1.0);
pub(crate) const SENSING: Paint = outlined("ls-sensing", "place-inner", "branch", 1.5);
pub(crate) const CONDITION: Paint = outlined("ls-condition", "branch-fill", "branch", 1.5);
pub(crate) const SIDE: Paint = outlined("ls-side", "paper", "branch", 1.0);
pub(crate) const LOOP: Paint = Paint {
    dash: "2 4",
    ..outlined("ls-loop", "paper", "branch", 1.5)
};
pub(crate) const LANES: Paint = outlined("ls-lanes", "paper", "robot-line", 1.0);
pub(crate) const LANE_HEAD: Paint = filled("ls-lane-head", "robot");
pub(crate) const MEETING: Paint = filled("ls-meeting", "place");
pub(crate) const RAIL: Paint = stroked("ls-rail", "line", 1.5);
pub(crate) const BRANCH_RAIL: Paint = stroked("ls-branch-rail", "branch", 1.5);

const PAINTS: [Paint; 24] = [
    PAPER,
    INK,
    MUTED,
    CHANGE_INK,
    BRANCH_INK,
    MARK,
    MARK_LINE,
    PLACE,
    PLACE_INNER,
    OBJECT,
    ROBOT,
    ICON,
    CHANGED,
    ROBOT_INK,
    CARD,
    SENSING,
    CONDITION,
    SIDE,
    LOOP,
    LANES,
    LANE_HEAD,
    MEETING,
    RAIL,
    BRANCH_RAIL,
];

impl Paint {
    /// Writes the class and the light colours as attributes, with a space before them.
    pub(crate) fn attributes(self) -> String {
        let light = |name: &str| {
            let found = COLOURS.iter().find(|colour| colour.name == name);
            found.map_or("none", |colour| colour.light)
        };
        let mut out = format!(" class=\"{}\"", self.class);
        let _ = write!(out, " fill=\"{}\"", self.fill.map_or("none", light));
        if let Some(stroke) = self.stroke {
            let _ = write!(
                out,
                " stroke=\"{}\" stroke-width=\"{}\"",
                light(stroke),
                self.stroke_width
            );
        }
        if !self.dash.is_empty() {
            let _ = write!(out, " stroke-dasharray=\"{}\"", self.dash);
        }
        out
    }
}

/// Returns the rules of all pictures: light colours, dark ones where the reader prefers them, and the variables by which
/// a page overrides both.
///
/// A page that shows many pictures includes it once, and leaves it out of each picture with
/// [`SvgOptions::without_style`](crate::SvgOptions::without_style).
pub fn stylesheet() -> String {
    let mut out = String::new();
    let variables = |out: &mut String, dark: bool| {
        out.push_str(".ls-picture{");
        for colour in &COLOURS {
            let value = if dark { colour.dark } else { colour.light };
            let _ = write!(out, "--ls-{0}:var(--longstep-{0},{value});", colour.name);
        }
        out.push('}');
    };
    variables(&mut out, false);
    out.push_str("@media (prefers-color-scheme:dark){");
    variables(&mut out, true);
    out.push('}');
    for paint in &PAINTS {
        let _ = write!(out, ".{}{{", paint.class);
        if let Some(fill) = paint.fill {
            let _ = write!(out, "fill:var(--ls-{fill});");
        }
        if let Some(stroke) = paint.stroke {
            let _ = write!(out, "stroke:var(--ls-{stroke});");
        }
        out.push('}');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paints_use_known_colours_and_have_distinct_classes() {
        for (index, paint) in PAINTS.iter().enumerate() {
            for name in paint.fill.iter().chain(&paint.stroke) {
                assert!(COLOURS.iter().any(|colour| colour.name == *name), "{name}");
            }
            assert!(
                PAINTS[..index].iter().all(|other| other.class != paint.class),
                "{}",
                paint.class
            );
        }
    }

    /// Relative luminance of WCAG 2.
    fn luminance(hex: &str) -> f64 {
        let channel = |at: usize| {
            let value = f64::from(u8::from_str_radix(&hex[at..at + 2], 16).unwrap()) / 255.0;
            if value <= 0.04045 {
                value / 12.92
            } else {
                ((value + 0.055) / 1.055).powf(2.4)
            }
        };
        0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5)
    }

    #[test]
    fn text_and_outlines_have_the_contrast_of_wcag() {
        let fills = [
            "paper",
            "place",
            "place-inner",
            "object",
            "robot",
            "change-fill",
            "branch-fill",
        ];
        let table = [
            ("ink", 4.5),
            ("muted", 4.5),
            ("change", 4.5),
            ("branch", 4.5),
            ("line", 3.0),
            ("robot-line", 3.0),
        ];
        for dark in [false, true] {
            let value = |name: &str| {
                let colour = COLOURS.iter().find(|colour| colour.name == name).unwrap();
                luminance(if dark { colour.dark } else { colour.light })
            };
            for (name, least) in table {
                for fill in fills {
                    let (one, other) = (value(name), value(fill));
                    let contrast = (one.max(other) + 0.05) / (one.min(other) + 0.05);
                    assert!(contrast >= least, "{name} on {fill}, dark {dark}: {contrast:.2}");
                }
            }
        }
    }
}
