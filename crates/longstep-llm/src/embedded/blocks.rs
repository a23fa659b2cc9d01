//! The blocks of tokens in which a prompt is computed.
//!
//! Rounding depends on how many tokens are computed together, and where two continuations are almost equally likely, it
//! decides the answer. To make an answer independent of the cache, a prompt is cut into blocks that depend on the
//! prompt alone, and only whole blocks with the same boundaries are reused from the cache.

/// Tokens of a block in the fixed part, which is computed once. Larger blocks need more memory and are hardly faster.
pub(super) const LARGE: usize = 256;

/// Tokens of a block between the fixed part and the last line, where a scene stands. Where a scene differs from the one
/// before, half a block on average is computed again.
const SMALL: usize = 16;

/// The blocks of a prompt.
pub(super) struct Blocks {
    ends: Vec<usize>,
    /// True if a picture follows the last block.
    is_followed: bool,
}

impl Blocks {
    /// Cuts a prompt of `total` tokens, of which the first `fixed` are fixed, and the first `shared` stand before the last
    /// line: an instruction of its own.
    pub(super) fn of(total: usize, fixed: usize, shared: usize) -> Self {
        let fixed = fixed.min(total);
        let shared = shared.clamp(fixed, total);
        let mut ends: Vec<usize> = (LARGE..fixed).step_by(LARGE).collect();
        ends.push(fixed);
        ends.extend((fixed + SMALL..shared).step_by(SMALL));
        ends.push(shared);
        ends.extend((shared + LARGE..total).step_by(LARGE));
        ends.push(total);
        ends.dedup();
        ends.retain(|end| *end > 0);
        Self {
            ends,
            is_followed: false,
        }
    }

    /// Returns the blocks with a picture behind the last one.
    pub(super) fn followed(self) -> Self {
        Self {
            is_followed: true,
            ..self
        }
    }

    /// Returns how many tokens can be reused from a cache that holds the first `known` tokens of the prompt and was
    /// computed in blocks that end at `ours`. All only if a picture follows: otherwise the last block is computed to get the
    /// logits of the next token.
    pub(super) fn reusable(&self, ours: &[usize], known: usize) -> usize {
        let reused = if self.is_followed {
            self.ends.len()
        } else {
            self.ends.len().saturating_sub(1)
        };
        ours.iter()
            .zip(self.ends.iter().take(reused))
            .take_while(|(our, their)| our == their && **our <= known)
            .last()
            .map_or(0, |(end, _)| *end)
    }

    /// Returns the end of the block that holds the token at this place.
    pub(super) fn next(&self, start: usize) -> Option<usize> {
        self.ends.iter().copied().find(|end| *end > start)
    }

    pub(super) fn into_ends(self) -> Vec<usize> {
        self.ends
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(total: usize, fixed: usize, shared: usize) -> Vec<usize> {
        Blocks::of(total, fixed, shared).into_ends()
    }

    #[test]
    fn blocks_cover_the_prompt() {
        for (total, fixed, shared, expected) in [
            (1, 0, 0, &[1][..]),
            (70, 0, 70, &[16, 32, 48, 64, 70]),
            (64, 0, 64, &[16, 32, 48, 64]),
            (70, 0, 0, &[70]),
            (600, 530, 580, &[256, 512, 530, 546, 562, 578, 580, 600]),
            (600, 530, 530, &[256, 512, 530, 600]),
            (900, 530, 531, &[256, 512, 530, 531, 787, 900]),
            (512, 512, 512, &[256, 512]),
            (10, 20, 30, &[10]),
        ] {
            assert_eq!(ends(total, fixed, shared), expected, "{total} {fixed} {shared}");
        }
    }

    #[test]
    fn the_next_block_begins_where_the_last_one_ended() {
        let blocks = Blocks::of(600, 530, 580);
        let mut start = 0;
        let mut met = Vec::new();
        while let Some(end) = blocks.next(start) {
            met.push(end);
            start = end;
        }
        assert_eq!(met, blocks.into_ends());
    }

    #[test]
    fn reusable_blocks_end_at_the_same_boundaries() {
        let planned = Blocks::of(600, 530, 580);
        let whole = ends(600, 530, 580);
        for (ours, known, expected) in [
            (vec![], 0, 0),
            (whole.clone(), 600, 580),
            (whole.clone(), 579, 578),
            // The scene of the cache ends in the middle of a planned block.
            (ends(585, 530, 570), 570, 562),
            (ends(570, 300, 300), 570, 256),
        ] {
            assert_eq!(planned.reusable(&ours, known), expected, "{ours:?} {known}");
        }
        assert_eq!(Blocks::of(70, 0, 0).reusable(&whole, 70), 0);
        assert_eq!(Blocks::of(70, 70, 70).reusable(&[70], 70), 0);
        assert_eq!(Blocks::of(70, 70, 70).followed().reusable(&[70], 70), 70);
    }
}
