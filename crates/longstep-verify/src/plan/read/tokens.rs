//! Control tokens of models around an answer: `<|im_end|>`, `</s>`, `[TOOL_CALLS]`.

use std::ops::Range;

/// The brackets of control tokens that hold a name.
const BRACKETS: [(&str, &str); 2] = [("<|", "|>"), ("<\u{ff5c}", "\u{ff5c}>")];

/// The longest name in such brackets, in bytes.
const LONGEST: usize = 60;

/// Control tokens without such brackets.
const WHOLE: [&str; 9] = [
    "</s>",
    "<s>",
    "<eos>",
    "<bos>",
    "<start_of_turn>",
    "<end_of_turn>",
    "[INST]",
    "[/INST]",
    "[TOOL_CALLS]",
];

/// Returns the control tokens of a reply.
pub(super) fn ranges(text: &str) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for (open, close) in BRACKETS {
        for (start, _) in text.match_indices(open) {
            let inside = start + open.len();
            let named = &text.as_bytes()[inside..text.len().min(inside + LONGEST)];
            let end = named.windows(close.len()).position(|part| part == close.as_bytes());
            if let Some(end) = end.filter(|end| !named[..*end].iter().any(|byte| matches!(byte, b'\n' | b'<' | b'>'))) {
                found.push(start..inside + end + close.len());
            }
        }
    }
    for token in WHOLE {
        found.extend(text.match_indices(token).map(|(start, _)| start..start + token.len()));
    }
    found
}
