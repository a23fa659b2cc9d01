//! Lines from bytes.

/// Bytes that were read, and the place of the next line in them.
#[derive(Debug, Default)]
pub(crate) struct Lines {
    bytes: Vec<u8>,
    /// The beginning of the next line.
    start: usize,
    /// The end of the bytes that were searched for the line's end.
    searched: usize,
}

/// A line without an end within the limit.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct TooLong;

impl Lines {
    /// The buffer for further bytes.
    pub(crate) fn buffer(&mut self) -> &mut Vec<u8> {
        &mut self.bytes
    }

    /// Returns the next complete line of at most `limit` bytes, without its end; none if there is none.
    pub(crate) fn next(&mut self, limit: usize) -> Result<Option<Vec<u8>>, TooLong> {
        let end = self.bytes[self.searched..].iter().position(|byte| *byte == b'\n');
        let end = end.map(|end| end + self.searched);
        if end.unwrap_or(self.bytes.len()) - self.start > limit {
            return Err(TooLong);
        }
        if let Some(end) = end {
            let line = self.bytes[self.start..end].to_vec();
            (self.start, self.searched) = (end + 1, end + 1);
            return Ok(Some(line));
        }
        // Complete lines go only here, so that many short ones are not moved for each of them.
        self.bytes.drain(..self.start);
        (self.start, self.searched) = (0, self.bytes.len());
        Ok(None)
    }

    /// Drops everything.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: usize = 100;

    #[test]
    fn lines_are_complete_and_bounded() {
        let mut lines = Lines::default();
        lines.buffer().extend(b"one\n\ntw");
        assert_eq!(lines.next(LIMIT), Ok(Some(b"one".to_vec())));
        assert_eq!(lines.next(LIMIT), Ok(Some(Vec::new())));
        assert_eq!(lines.next(LIMIT), Ok(None));
        lines.buffer().extend(b"o\n");
        assert_eq!(lines.next(LIMIT), Ok(Some(b"two".to_vec())));
        lines.buffer().extend(vec![b'x'; LIMIT]);
        assert_eq!(lines.next(LIMIT), Ok(None));
        lines.buffer().push(b'x');
        assert_eq!(lines.next(LIMIT), Err(TooLong));
    }
}
