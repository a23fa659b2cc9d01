//! Texts of a domain in comments and literals, without characters that end them or that hide code from a reader.

use longstep_model::visible;

/// Columns of a comment.
const WIDTH: usize = 100;

/// Returns a text as lines of a comment, none of which is empty or ends in a backslash.
pub(super) fn lines(text: &str) -> Vec<String> {
    let text = visible::line(text.trim()).replace("*/", "* /").replace("/*", "/ *");
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.last_mut().map_or(0, |line| line.chars().count());
        if last > 0 && last + 1 + word.chars().count() > WIDTH {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    // A backslash would join the next line to the comment.
    for line in &mut lines {
        if line.ends_with('\\') {
            line.push('.');
        }
    }
    lines.retain(|line| !line.is_empty());
    lines
}

/// Returns a text as a literal of C++ and Python.
pub(super) fn literal(text: &str) -> String {
    let mut literal = String::from("\"");
    for character in visible::line(text).chars() {
        if matches!(character, '"' | '\\') {
            literal.push('\\');
        }
        literal.push(character);
    }
    literal.push('"');
    literal
}
