//! Significance of the difference between two runs.

/// The exact two-sided p value of McNemar's test: the probability of a split at least as uneven as this one among the
/// attempts with different results, if both directions are equally likely. 1 without such attempts.
///
/// (Q. McNemar, *Note on the sampling error of the difference between correlated proportions or percentages*,
/// Psychometrika 12, 1947; here with the exact binomial distribution.)
///
/// ```
/// # use longstep_eval::compare::mcnemar;
/// assert!((mcnemar(1, 9) - 0.021484375).abs() < 1e-12);
/// ```
pub fn mcnemar(one_way: usize, other_way: usize) -> f64 {
    let all = one_way + other_way;
    // With logarithms, because 0.5 to the power of thousands underflows.
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
    fn mcnemar_returns_known_exact_p_values() {
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
    fn mcnemar_stays_finite_for_thousands_of_attempts() {
        assert!(mcnemar(2_000, 2_600) < 1e-15);
        assert!(mcnemar(2_000, 2_600) > 0.0);
        assert!((mcnemar(5_000, 5_000) - 1.0).abs() < 1e-12);
    }
}
