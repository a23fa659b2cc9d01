//! Sampling of the next token.

use llama_cpp_2::token::LlamaToken;
use longstep::dialogue::Likelihood;

use crate::Sampling;

/// Samples among the allowed tokens. Every answer starts from the seed, so that it does not depend on earlier requests.
pub(super) struct Sampler {
    temperature: f64,
    top_p: f64,
    seed: u64,
    state: u64,
}

impl Sampler {
    pub(super) fn new(sampling: &Sampling) -> Self {
        let seed = sampling.seed.unwrap_or_default();
        Self {
            temperature: sampling.temperature,
            top_p: sampling.top_p.unwrap_or(1.0),
            seed,
            state: seed,
        }
    }

    /// Resets the random state for a new answer.
    pub(super) fn begin(&mut self) {
        self.state = self.seed;
    }

    /// Samples one of the tokens that `each` yields, by their logits; `None` if it yields none.
    pub(super) fn choose(&mut self, logits: &[f32], each: impl FnOnce(&mut dyn FnMut(usize))) -> Option<usize> {
        if self.temperature > 0.0 {
            return self.sample(logits, each);
        }
        let mut best: Option<(usize, f32)> = None;
        each(&mut |index| {
            if let Some(&logit) = logits.get(index)
                && best.is_none_or(|(_, most)| logit > most)
            {
                best = Some((index, logit));
            }
        });
        best.map(|(index, _)| index)
    }

    fn sample(&mut self, logits: &[f32], each: impl FnOnce(&mut dyn FnMut(usize))) -> Option<usize> {
        let mut weighed: Vec<(usize, f64)> = Vec::new();
        each(&mut |index| {
            if let Some(&logit) = logits.get(index) {
                weighed.push((index, f64::from(logit)));
            }
        });
        // Most likely first; equally likely tokens in order of their number, so that a seed always gives the same
        // answer.
        weighed.sort_by(|left, right| right.1.total_cmp(&left.1).then(left.0.cmp(&right.0)));
        let most = weighed.first()?.1;
        for (_, weight) in &mut weighed {
            *weight = ((*weight - most) / self.temperature).exp();
        }
        let total: f64 = weighed.iter().map(|(_, weight)| weight).sum();
        let enough = total * self.top_p.clamp(0.0, 1.0);
        let mut kept = 0.0;
        let count = weighed.iter().take_while(|(_, weight)| {
            let wanted = kept < enough;
            kept += if wanted { weight } else { &0.0 };
            wanted
        });
        // At least the most likely token, even for `top_p` 0.
        let count = count.count().max(1);
        weighed.truncate(count);
        let total: f64 = weighed.iter().map(|(_, weight)| weight).sum();
        let mut left = self.random() * total;
        let last = weighed.last()?.0;
        let hit = weighed.into_iter().find(|(_, weight)| {
            left -= weight;
            left < 0.0
        });
        Some(hit.map_or(last, |(index, _)| index))
    }

    /// A number in [0, 1) by SplitMix64, which accepts any seed.
    fn random(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.state;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        (bits >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOGITS: [f32; 4] = [1.0, 3.0, 2.0, -50.0];

    fn drawn(sampling: &Sampling, allowed: &[usize]) -> [u32; 4] {
        let mut sampler = Sampler::new(sampling);
        let mut counts = [0; 4];
        for _ in 0..10_000 {
            let chosen = sampler.choose(&LOGITS, |consider| allowed.iter().copied().for_each(consider));
            counts[chosen.unwrap()] += 1;
        }
        counts
    }

    #[test]
    fn tokens_are_drawn_as_often_as_they_are_likely() {
        let with = |temperature: f64, top_p: Option<f64>| Sampling {
            temperature,
            top_p,
            seed: Some(7),
            ..Sampling::default()
        };
        assert_eq!(drawn(&with(0.0, None), &[0, 1, 2, 3]), [0, 10_000, 0, 0]);
        assert_eq!(drawn(&with(0.0, None), &[0, 2, 3]), [0, 0, 10_000, 0]);
        // The weights e^0, e^-1 and e^-2 divided by their sum: 0.665, 0.245, 0.090.
        let [zero, one, two, three] = drawn(&with(1.0, None), &[0, 1, 2, 3]);
        assert!((800..1000).contains(&zero) && (6500..6800).contains(&one) && (2300..2600).contains(&two));
        assert_eq!(three, 0);
        assert_eq!(drawn(&with(1.0, Some(0.9)), &[0, 1, 2, 3])[0], 0);
        assert_eq!(drawn(&with(1.0, Some(0.0)), &[0, 1, 2, 3]), [0, 10_000, 0, 0]);
        assert_eq!(drawn(&with(1.0, None), &[3]), [0, 0, 0, 10_000]);
    }

    #[test]
    fn the_same_seed_draws_the_same() {
        let draw = |seed: Option<u64>| {
            let mut sampler = Sampler::new(&Sampling {
                temperature: 2.0,
                seed,
                ..Sampling::default()
            });
            let mut one = || sampler.choose(&LOGITS, |consider| (0..4).for_each(consider));
            (0..50).map(|_| one()).collect::<Vec<_>>()
        };
        assert_eq!(draw(Some(3)), draw(Some(3)));
        assert_ne!(draw(Some(3)), draw(Some(4)));
        assert_eq!(draw(None), draw(Some(0)));
        assert_eq!(Sampler::new(&Sampling::default()).choose(&LOGITS, |_| {}), None);
    }
}

/// The log-probability of the tokens over the whole vocabulary, which a grammar does not change.
#[derive(Clone, Default)]
pub(super) struct Score {
    text: f64,
    forced: f64,
}

impl Score {
    /// Counts a sampled token.
    pub(super) fn count(&mut self, logits: &[f32], chosen: Option<usize>) {
        let logit = chosen.and_then(|index| logits.get(index));
        self.text += logit.map_or(0.0, |logit| f64::from(*logit) - log_sum(logits));
    }

    /// Counts a token that the grammar forces.
    pub(super) fn force(&mut self, logits: &[f32], token: LlamaToken) {
        let logit = usize::try_from(token.0).ok().and_then(|index| logits.get(index));
        self.forced += logit.map_or(0.0, |logit| f64::from(*logit) - log_sum(logits));
    }

    /// Returns the likelihood of all tokens so far, in nats.
    pub(super) fn total(&self) -> f64 {
        self.text + self.forced
    }

    /// Returns the likelihood, rounded so that it is the same on most machines.
    pub(super) fn likelihood(&self) -> Likelihood {
        #[expect(clippy::cast_possible_truncation, reason = "far from the bounds")]
        let rounded = |score: f64| (score * 1000.0).round() as i64;
        Likelihood {
            text: rounded(self.text),
            ahead: None,
            is_trained: false,
        }
    }
}

/// Returns the logarithm of the sum of the exponentials.
fn log_sum(logits: &[f32]) -> f64 {
    let most = logits.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let sum: f32 = logits.iter().map(|logit| (logit - most).exp()).sum();
    f64::from(most) + f64::from(sum).ln()
}
