//! The blocks of tokens in which a prompt is computed.
//!
//! Rounding depends on how many tokens are computed together, and where two continuations are almost equally likely, it
//! decides the answer. To make an answer independent of the cache, a prompt is cut into blocks that depend on the
//! prompt alone, and only whole blocks with the same boundaries are reused from the cache.

/// Tokens of a block in the fixed part, which is computed once. Larger blocks need more memory and are hardly faster.
pub(super) const LARGE: usize = 256;

/// Tokens of a block behind the fixed part. Where a prompt differs from the one before, half a block on average is
/// computed again.
const SMALL: usize = 16;

/// The ends of the blocks of a prompt of `total` tokens, of which the first `fixed` are fixed.
pub(super) fn ends(total: usize, fixed: usize) -> Vec<usize> {
    let fixed = fixed.min(total);
    let mut ends: Vec<usize> = (LARGE..fixed).step_by(LARGE).collect();
    if fixed > 0 && fixed < total {
        ends.push(fixed);
    }
    ends.extend((fixed + SMALL..total).step_by(SMALL));
    ends.push(total);
    ends
}

/// Returns how many tokens can be reused from a cache that holds the first `known` tokens of the prompt and was
/// computed in blocks that end at `ours`. Never all: the last block is computed to get the logits of the next token.
pub(super) fn reusable(ours: &[usize], planned: &[usize], known: usize) -> usize {
    let before_last = planned.split_last().map_or(&[][..], |(_, rest)| rest);
    ours.iter()
        .zip(before_last)
        .take_while(|(our, their)| our == their && **our <= known)
        .last()
        .map_or(0, |(end, _)| *end)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_the_prompt() {
        assert_eq!(ends(1, 0), [1]);
        assert_eq!(ends(70, 0), [16, 32, 48, 64, 70]);
        assert_eq!(ends(64, 0), [16, 32, 48, 64]);
        assert_eq!(ends(600, 530), [256, 512, 530, 546, 562, 578, 594, 600]);
        assert_eq!(ends(512, 512), [256, 512]);
        assert_eq!(ends(10, 20), [10]);
    }

    #[test]
    fn only_blocks_of_the_same_cut_are_taken() {
        let planned = ends(600, 530);
        assert_eq!(reusable(&[], &planned, 0), 0);
        assert_eq!(reusable(&planned, &planned, 600), 594);
        assert_eq!(reusable(&planned, &planned, 593), 578);
        // The cache ends in the middle of a planned block.
        assert_eq!(reusable(&ends(570, 530), &planned, 570), 562);
        assert_eq!(reusable(&ends(570, 300), &planned, 570), 256);
        assert_eq!(reusable(&planned, &ends(70, 0), 70), 0);
    }
}
