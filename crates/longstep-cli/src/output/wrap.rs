//! Texts in lines of a width.

/// Wraps a text at `width` characters between words. Lines after the first are indented; a longer word has a line of its own.
pub(crate) fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let Some(last) = lines.last_mut() else { break };
        let indented = last.chars().count() + word.chars().count();
        match last.is_empty() || indented < width {
            true if last.is_empty() => last.push_str(word),
            true => last.extend([" ", word]),
            false => lines.push(format!("  {word}")),
        }
    }
    lines
}
