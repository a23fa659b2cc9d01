//! The blocks in which a prompt is computed.
//!
//! Rounding differs with how many tokens are computed together, and where two continuations are
//! nearly as likely, that decides the answer. So that a request gets the same answer whatever
//! was in the cache before, its prompt is cut into blocks that depend on the prompt alone, and
//! from the cache only whole blocks of the same cut are taken.

/// Tokens of a block in the fixed part, which is read once. More needs more memory and is
/// hardly faster.
pub(super) const LARGE: usize = 256;

/// Tokens of a block behind the fixed part. Half of one is computed in vain where a prompt
/// departs from the one before.
const SMALL: usize = 16;

/// Where the blocks of a prompt of `total` tokens end, of which the first `fixed` are fixed.
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

/// How many tokens can be taken from a cache that holds the first `known` tokens of the prompt
/// and was computed in blocks of `ours`. Never all: the last block is computed, for the engine
/// to say what comes next.
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
        // The cache was cut at its own end in the middle of a block of ours.
        assert_eq!(reusable(&ends(570, 530), &planned, 570), 562);
        assert_eq!(reusable(&ends(570, 300), &planned, 570), 256);
        assert_eq!(reusable(&planned, &ends(70, 0), 70), 0);
    }
}
