//! The end of a log, without the rest of it.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

use crate::store::LONGEST_TAIL;

/// The bytes that are read at a time.
const BLOCK: u64 = 64 << 10;

/// Returns the last whole lines of a file, at most `limit`. What follows the last line break is no whole line.
pub(super) fn lines(file: &mut File, limit: usize) -> io::Result<Vec<String>> {
    let limit = limit.min(LONGEST_TAIL);
    let mut start = file.seek(SeekFrom::End(0))?;
    let mut bytes: Vec<u8> = Vec::new();
    // The line break before the first line that is wanted.
    while start > 0 && breaks(&bytes) <= limit {
        let length = start.min(BLOCK);
        start -= length;
        let mut block = block(file, start, length)?;
        block.append(&mut bytes);
        bytes = block;
    }
    let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |last| last + 1);
    let text = String::from_utf8_lossy(&bytes[..whole]);
    let lines: Vec<&str> = text.lines().collect();
    // The first one is not whole unless the file begins with it, but then there are more than are wanted.
    Ok(lines[lines.len().saturating_sub(limit)..]
        .iter()
        .map(|line| (*line).to_owned())
        .collect())
}

/// Returns the length of the whole lines of a file.
pub(super) fn whole_length(file: &mut File) -> io::Result<u64> {
    let mut end = file.seek(SeekFrom::End(0))?;
    while end > 0 {
        let length = end.min(BLOCK);
        let block = block(file, end - length, length)?;
        if let Some(last) = block.iter().rposition(|byte| *byte == b'\n') {
            return Ok(end - length + last as u64 + 1);
        }
        end -= length;
    }
    Ok(0)
}

fn breaks(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte == b'\n').count()
}

fn block(file: &mut File, start: u64, length: u64) -> io::Result<Vec<u8>> {
    file.seek(SeekFrom::Start(start))?;
    let mut block = Vec::new();
    file.take(length).read_to_end(&mut block)?;
    Ok(block)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn tail_has_the_last_whole_lines() {
        let long = "x".repeat(2 * BLOCK as usize);
        for (text, limit, expected, whole) in [
            (String::new(), 3, vec![], 0),
            ("a\nb\nc\n".to_owned(), 2, vec!["b", "c"], 6),
            ("a\nb\n".to_owned(), 9, vec!["a", "b"], 4),
            ("a\nb\nto".to_owned(), 1, vec!["b"], 4),
            ("torn".to_owned(), 1, vec![], 0),
            ("a\n".to_owned(), 0, vec![], 2),
            (format!("a\n{long}\nb\n"), 2, vec![&long, "b"], long.len() + 5),
            (format!("a\n{long}\n{long}"), 1, vec![&long], long.len() + 3),
        ] {
            let mut file = tempfile::tempfile().unwrap();
            file.write_all(text.as_bytes()).unwrap();
            assert_eq!(lines(&mut file, limit).unwrap(), expected);
            assert_eq!(whole_length(&mut file).unwrap(), whole as u64);
        }
    }
}
