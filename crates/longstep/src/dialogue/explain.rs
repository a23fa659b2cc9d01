//! Token counts of a prompt by part, for people.

use super::{Counting, PartCost};

/// Token counts of a prompt, in prompt order.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Explanation {
    /// Parts with at least one token.
    pub parts: Vec<PartShare>,
    /// Tokens of all parts.
    pub total: u64,
    /// Token budget, if known.
    pub room: Option<u64>,
    /// Method of counting.
    pub counting: Counting,
}

/// The share of one part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct PartShare {
    /// Name of the part.
    pub name: &'static str,
    /// Tokens of the part.
    pub tokens: u64,
    /// Share of the whole prompt, in tenths of a percent.
    pub per_mille: u64,
}

/// Computes the share of each part.
///
/// ```
/// use longstep::dialogue::{Counting, PartCost, explain};
/// let costs = [PartCost { name: "role", tokens: 30 }, PartCost { name: "query", tokens: 90 }];
/// let explanation = explain(&costs, Some(4000), Counting::Exact("a tokenizer".to_owned()));
/// assert_eq!((explanation.total, explanation.parts[1].per_mille), (120, 750));
/// assert_eq!(explanation.summary(), "120 of 4000 tokens, counted by a tokenizer");
/// ```
pub fn explain(costs: &[PartCost], room: Option<u64>, counting: Counting) -> Explanation {
    let total = costs.iter().map(|cost| cost.tokens).sum::<u64>();
    let share = |cost: &PartCost| PartShare {
        name: cost.name,
        tokens: cost.tokens,
        per_mille: (cost.tokens * 1000 + total / 2) / total.max(1),
    };
    Explanation {
        parts: costs.iter().filter(|cost| cost.tokens > 0).map(share).collect(),
        total,
        room,
        counting,
    }
}

impl Explanation {
    /// Returns one line with the total, the budget and the method of counting.
    pub fn summary(&self) -> String {
        let of = self.room.map_or(String::new(), |room| format!(" of {room}"));
        match &self.counting {
            Counting::Exact(by) => format!("{}{of} tokens, counted by {by}", self.total),
            Counting::Estimate(how) => format!("about {}{of} tokens, estimated: {how}", self.total),
        }
    }
}
