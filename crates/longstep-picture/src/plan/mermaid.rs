//! A diagram as a Mermaid flowchart.

use std::fmt::Write as _;

use super::Diagram;
use super::flowchart::{Flowchart, Shape, Shown};

/// Writes a plan as a Mermaid flowchart: steps with their changes and reasons, branches as questions, lanes as groups.
///
/// Texts are in quotes, and characters with a meaning in Mermaid, Markdown or HTML are entities.
///
/// ```
/// use longstep_core::{domain, environment, plan, verify};
/// use longstep_picture::plan::{Annotations, Diagram, mermaid};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// let plan = verify::check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// let chart = mermaid(&Diagram::of(&plan, &Annotations::default()));
/// assert!(chart.starts_with("flowchart TD\n"));
/// assert!(chart.contains("1#46; move the hand to the pen"));
/// ```
pub fn mermaid(diagram: &Diagram) -> String {
    let chart = Flowchart::of(diagram);
    let mut text = String::from("flowchart TD\n");
    for (lane, shapes) in chart.groups() {
        let indent = if let Some((lane, name)) = lane {
            let _ = writeln!(text, "  subgraph lane{lane}[\"{}\"]", escaped(name));
            "    "
        } else {
            "  "
        };
        shapes.for_each(|(number, shown)| shape(number, shown, indent, &mut text));
        if lane.is_some() {
            text.push_str("  end\n");
        }
    }
    for arrow in &chart.arrows {
        let line = if arrow.is_remark { "-.-" } else { "-->" };
        let label = match &*arrow.label {
            "" => String::new(),
            label => format!("|\"{}\"|", escaped(label)),
        };
        let _ = writeln!(text, "  n{} {line}{label} n{}", arrow.from, arrow.to);
    }
    text
}

/// Returns true if a page with Mermaid refuses the chart until its limits are raised: `maxTextSize`, by default 50,000
/// characters, and `maxEdges`, by default 500 arrows.
///
/// ```
/// use longstep_picture::plan::exceeds_defaults_of_mermaid;
/// assert!(!exceeds_defaults_of_mermaid("flowchart TD\n  n0 --> n1\n"));
/// assert!(exceeds_defaults_of_mermaid(&"  n0 --> n1\n".repeat(501)));
/// ```
pub fn exceeds_defaults_of_mermaid(chart: &str) -> bool {
    let is_arrow = |line: &&str| {
        let rest = line.strip_prefix("  n").unwrap_or_default();
        rest.trim_start_matches(|c: char| c.is_ascii_digit()).starts_with(" -")
    };
    chart.encode_utf16().count() > 50_000 || chart.lines().filter(is_arrow).count() > 500
}

fn shape(number: usize, shown: &Shown, indent: &str, text: &mut String) {
    let (open, close) = match shown.shape {
        Shape::Terminal => ("([", "])"),
        Shape::Step => ("[", "]"),
        Shape::Sensing => ("(", ")"),
        Shape::Question => ("{", "}"),
        Shape::Bar => ("[[", "]]"),
        Shape::Remark => (">", "]"),
    };
    let lines: Vec<String> = shown.lines.iter().map(|line| escaped(line)).collect();
    let _ = writeln!(text, "{indent}n{number}{open}\"{}\"{close}", lines.join("<br/>"));
}

/// A character without a width, which ends a name.
const WORD_JOINER: &str = "#8288;";

/// Writes characters that mean something to Mermaid as numbers.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    // A number and a full stop at the beginning would be a list.
    let number = text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    for (at, character) in text.char_indices() {
        let is_plain = character.is_alphanumeric()
            || matches!(
                character,
                ' ' | ',' | ':' | '\'' | '-' | '/' | '?' | '!' | '_' | '(' | ')'
            )
            || (character == '.' && at != number);
        if is_plain {
            escaped.push(character);
        } else {
            let _ = write!(escaped, "#{};", u32::from(character));
        }
        // These would become a picture, a line break and a formula, also as numbers.
        let rest = &text[at + character.len_utf8()..];
        if [(':', "fa-"), ('\\', "n"), ('$', "$")]
            .iter()
            .any(|(own, next)| *own == character && rest.starts_with(next))
        {
            escaped.push_str(WORD_JOINER);
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_mean_nothing_to_mermaid() {
        for (text, expected) in [
            ("1. take the pen", "1#46; take the pen"),
            ("take 1.5 of it: now", "take 1.5 of it: now"),
            ("fa:fa-ban", "fa:#8288;fa-ban"),
            ("say \"end\"]", "say #34;end#34;#93;"),
            ("<b>`*x*`#1;", "#60;b#62;#96;#42;x#42;#96;#35;1#59;"),
            ("ключ \u{1f600}", "ключ #128512;"),
            ("C:\\new", "C:#92;#8288;new"),
            ("$$x$$", "#36;#8288;#36;x#36;#8288;#36;"),
        ] {
            assert_eq!(escaped(text), expected);
        }
    }
}
