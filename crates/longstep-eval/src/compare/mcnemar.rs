//! Whether a difference between two runs may be chance.

/// The exact two-sided p value of McNemar's test: how likely it is that of all attempts that came out differently, the
/// split is at least as uneven as here, if either way is as likely as the other. 1 if none came out differently.
///
/// (Q. McNemar, *Note on the sampling error of the difference between correlated proportions or percentages*,
/// Psychometrika 12, 1947; here with the binomial distribution itself, not its approximation.)
///
/// ```
/// # use longstep_eval::compare::mcnemar;
/// assert!((mcnemar(1, 9) - 0.021484375).abs() < 1e-12);
/// ```
pub fn mcnemar(one_way: usize, other_way: usize) -> f64 {
    let all = one_way + other_way;
    // With logarithms, since a half to the power of thousands is no number of a computer's any more.
    let mut log = all as f64 * 0.5_f64.ln();
    let mut tail = 0.0;
    for few in 0..=one_way.min(other_way) {
        tail += log.exp();
        log += ((all - few) as f64 / (few + 1) as f64).ln();
    }
    (2.0 * tail).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::mcnemar;

    #[test]
    fn known_values() {
        let known = [
            ((0, 0), 1.0),
            ((1, 9), 0.021_484_375),
            ((9, 1), 0.021_484_375),
            ((0, 5), 0.062_5),
            ((3, 3), 1.0),
            ((2, 8), 0.109_375),
            ((0, 1), 1.0),
        ];
        for ((one_way, other_way), p) in known {
            let found = mcnemar(one_way, other_way);
            assert!((found - p).abs() < 1e-12, "{one_way}, {other_way}: {found}");
        }
    }

    #[test]
    fn many_attempts_are_no_trouble() {
        assert!(mcnemar(2_000, 2_600) < 1e-15);
        assert!(mcnemar(2_000, 2_600) > 0.0);
        assert!((mcnemar(5_000, 5_000) - 1.0).abs() < 1e-12);
    }
}
