//! A diagram in the language of Graphviz.

use std::fmt::Write as _;

use super::Diagram;
use super::flowchart::{Flowchart, Shape, Shown};

/// Writes a plan as a graph for Graphviz: steps with their changes and reasons, branches as questions, lanes as clusters.
///
/// ```
/// use longstep_core::{domain, environment, plan, verify};
/// use longstep_picture::plan::{Annotations, Diagram, dot};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// let plan = verify::check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// assert!(dot(&Diagram::of(&plan, &Annotations::default())).starts_with("digraph plan {\n"));
/// ```
pub fn dot(diagram: &Diagram) -> String {
    let chart = Flowchart::of(diagram);
    let mut text = String::from(
        "digraph plan {\n  node [fontname=\"Helvetica\", fontsize=11, shape=box, style=rounded];\n  \
         edge [fontname=\"Helvetica\", fontsize=10];\n",
    );
    for (lane, shapes) in chart.groups() {
        let indent = if let Some((lane, name)) = lane {
            let _ = writeln!(text, "  subgraph cluster_{lane} {{\n    label={};", quoted(name));
            "    "
        } else {
            "  "
        };
        shapes.for_each(|(number, shown)| shape(number, shown, indent, &mut text));
        if lane.is_some() {
            text.push_str("  }\n");
        }
    }
    for arrow in &chart.arrows {
        let mut attributes = Vec::new();
        if !arrow.label.is_empty() {
            attributes.push(format!("label={}", quoted(&arrow.label)));
        }
        if arrow.is_remark {
            attributes.push("style=dotted, arrowhead=none".to_owned());
        }
        let attributes = match &attributes[..] {
            [] => String::new(),
            attributes => format!(" [{}]", attributes.join(", ")),
        };
        let _ = writeln!(text, "  n{} -> n{}{attributes};", arrow.from, arrow.to);
    }
    text.push_str("}\n");
    text
}

fn shape(number: usize, shown: &Shown, indent: &str, text: &mut String) {
    let form = match shown.shape {
        Shape::Step => "",
        Shape::Terminal => ", shape=oval",
        Shape::Sensing => ", style=\"rounded,dashed\"",
        Shape::Question => ", shape=diamond, style=\"\"",
        Shape::Bar => ", shape=box, style=filled, fillcolor=gray90, height=0.2",
        Shape::Remark => ", shape=note, style=\"\"",
    };
    let label = quoted(&shown.lines.join("\n"));
    let _ = writeln!(text, "{indent}n{number} [label={label}{form}];");
}

/// Writes a text in quotes. A backslash begins an escape there.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for character in text.chars() {
        match character {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            '\n' => quoted.push_str("\\n"),
            // Graphviz reads the entities of HTML in labels.
            '&' => quoted.push_str("&amp;"),
            _ => quoted.push(character),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_mean_nothing_to_graphviz() {
        for (text, expected) in [
            ("say \"end\"]", "\"say \\\"end\\\"]\""),
            ("a\\N\nb", "\"a\\\\N\\nb\""),
            ("&lt;<b>", "\"&amp;lt;<b>\""),
        ] {
            assert_eq!(quoted(text), expected);
        }
    }
}
