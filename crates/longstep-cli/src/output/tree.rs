//! Trees with lines between a parent and its children.

use longstep_core::visible;

use super::{Line, Style, composed, wrapped};

/// The narrowest column for texts; deeper trees are wider than the terminal.
const NARROWEST: usize = 16;

/// The style of a text in a tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tone {
    Plain,
    Bold,
    Dimmed,
    Red,
    Green,
    Yellow,
    Cyan,
}

/// A node of a tree: a text with a mark before it, notes below it, and children.
#[derive(Debug, Clone)]
pub(crate) struct Item {
    pub(crate) mark: String,
    pub(crate) tone: Tone,
    pub(crate) text: String,
    pub(crate) notes: Vec<(Tone, String)>,
    pub(crate) children: Vec<Item>,
}

impl Item {
    pub(crate) fn new(tone: Tone, text: impl Into<String>) -> Self {
        Self {
            mark: String::new(),
            tone,
            text: text.into(),
            notes: Vec::new(),
            children: Vec::new(),
        }
    }

    /// Sets the children.
    pub(crate) fn over(self, children: Vec<Item>) -> Self {
        Self { children, ..self }
    }
}

/// The characters of the lines: before a child, before the last child, beside further children, and beside none.
struct Signs {
    child: &'static str,
    last: &'static str,
    beside: &'static str,
    below: &'static str,
}

const UNICODE: Signs = Signs {
    child: "├─ ",
    last: "└─ ",
    beside: "│  ",
    below: "   ",
};

const ASCII: Signs = Signs {
    child: "|- ",
    last: "`- ",
    beside: "|  ",
    below: "   ",
};

/// Returns the lines of a tree below a line of its own, wrapped at a width.
pub(crate) fn tree(items: &[Item], width: Option<usize>, is_unicode: bool) -> Vec<Line> {
    let signs = if is_unicode { &UNICODE } else { &ASCII };
    let mut lines = Vec::new();
    draw(items, "", width, signs, &mut lines);
    lines
}

fn draw(items: &[Item], prefix: &str, width: Option<usize>, signs: &Signs, lines: &mut Vec<Line>) {
    for (place, item) in items.iter().enumerate() {
        let is_last = place + 1 == items.len();
        let (sign, below) = if is_last {
            (signs.last, signs.below)
        } else {
            (signs.child, signs.beside)
        };
        let inside = format!("{prefix}{below}");
        let indent = item.mark.chars().count() + usize::from(!item.mark.is_empty());
        let used = inside.chars().count() + indent;
        let column = width.map_or(usize::MAX, |width| width.saturating_sub(used).max(NARROWEST));
        for (row, text) in wrapped(&visible::line(&item.text), column).into_iter().enumerate() {
            let mut line = if row == 0 {
                composed!("{}{:indent$}", format!("{prefix}{sign}").dimmed(), item.mark.dimmed())
            } else {
                composed!("{}{:indent$}", inside.dimmed(), "")
            };
            push(&mut line, item.tone, &text);
            lines.push(line);
        }
        let beside = if item.children.is_empty() { "" } else { signs.beside };
        for (tone, note) in &item.notes {
            let column = column.saturating_sub(beside.chars().count()).max(NARROWEST);
            for text in wrapped(&visible::line(note), column) {
                let mut line = composed!("{}{:indent$}", format!("{inside}{beside}").dimmed(), "");
                push(&mut line, *tone, &text);
                lines.push(line);
            }
        }
        draw(&item.children, &inside, width, signs, lines);
    }
}

fn push(line: &mut Line, tone: Tone, text: &str) {
    match tone {
        Tone::Plain => line.push(format_args!("{text}")),
        Tone::Bold => line.push(format_args!("{}", text.bold())),
        Tone::Dimmed => line.push(format_args!("{}", text.dimmed())),
        Tone::Red => line.push(format_args!("{}", text.red())),
        Tone::Green => line.push(format_args!("{}", text.green())),
        Tone::Yellow => line.push(format_args!("{}", text.yellow())),
        Tone::Cyan => line.push(format_args!("{}", text.cyan())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(width: Option<usize>, is_unicode: bool) -> Vec<String> {
        let mut step = Item::new(Tone::Plain, "move the hand to the yoghurt on the shelf");
        step.mark = "1.".to_owned();
        step.notes = vec![(Tone::Plain, "the hand is at the yoghurt".to_owned())];
        let branch = Item::new(Tone::Plain, "if a").over(vec![step.clone()]);
        let lines = tree(&[branch, step], width, is_unicode);
        let plain = |line: &Line| anstream::adapter::strip_str(&line.shown()).to_string();
        lines.iter().map(plain).collect()
    }

    #[test]
    fn tree_has_lines_between_parents_and_children() {
        let expected = [
            "├─ if a",
            "│  └─ 1. move the hand to the yoghurt on the shelf",
            "│        the hand is at the yoghurt",
            "└─ 1. move the hand to the yoghurt on the shelf",
            "      the hand is at the yoghurt",
        ];
        assert_eq!(drawn(None, true), expected);
        let ascii = drawn(None, false);
        assert_eq!(ascii[1], "|  `- 1. move the hand to the yoghurt on the shelf");
        assert!(ascii.iter().all(|line| line.is_ascii()));
    }

    #[test]
    fn narrow_tree_wraps_below_its_text() {
        let lines = drawn(Some(40), true);
        assert_eq!(
            lines[1..3],
            ["│  └─ 1. move the hand to the yoghurt on", "│          the shelf"]
        );
        assert!(lines.iter().all(|line| line.chars().count() <= 40), "{lines:#?}");
    }
}
