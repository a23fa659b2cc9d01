//! What a prompt is made of, for a person.

use super::{Counting, PartCost};

/// What the parts of a prompt cost, in the order in which they are said.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Explanation {
    /// A line for each part that costs something.
    pub parts: Vec<PartShare>,
    /// Tokens of all parts.
    pub total: u64,
    /// Tokens that there is room for, if that is known.
    pub room: Option<u64>,
    /// How the tokens were counted.
    pub counting: Counting,
}

/// A part of a prompt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartShare {
    /// Its name.
    pub name: &'static str,
    /// What it costs.
    pub tokens: u64,
    /// Of the whole prompt, in tenths of a percent.
    pub per_mille: u64,
}

/// Works out what each part of a prompt has of the whole.
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
    /// The total in one line: of how many tokens, and how they were counted.
    pub fn summary(&self) -> String {
        let of = self.room.map_or(String::new(), |room| format!(" of {room}"));
        match &self.counting {
            Counting::Exact(by) => format!("{}{of} tokens, counted by {by}", self.total),
            Counting::Estimate(how) => format!("about {}{of} tokens, estimated: {how}", self.total),
        }
    }
}
