//! The text of a domain that was rewritten.

use crate::domain::sexpr::{Expression, ExpressionKind};

/// Writes a domain that was rewritten.
pub(crate) fn written(expressions: &[Expression]) -> String {
    let mut text = String::new();
    for define in expressions {
        let Some(sections) = define.list() else { continue };
        for (index, section) in sections.iter().enumerate() {
            text.push_str(match index {
                0 => "(",
                1 => " ",
                _ => "\n  ",
            });
            let is_action = section.tail_of(":action").is_some();
            match section.list() {
                Some(items) if is_action => {
                    text.push('(');
                    for (place, item) in items.iter().enumerate() {
                        let is_key = place > 1 && place % 2 == 0;
                        text.push_str(if place == 0 {
                            ""
                        } else if is_key {
                            "\n    "
                        } else {
                            " "
                        });
                        write(item, &mut text);
                    }
                    text.push(')');
                }
                _ => write(section, &mut text),
            }
        }
        text.push_str(")\n");
    }
    text
}

fn write(expression: &Expression, text: &mut String) {
    match &expression.kind {
        ExpressionKind::Word(word) => text.push_str(word),
        ExpressionKind::List(items) => {
            text.push('(');
            for (index, item) in items.iter().enumerate() {
                if index > 0 {
                    text.push(' ');
                }
                write(item, text);
            }
            text.push(')');
        }
    }
}
