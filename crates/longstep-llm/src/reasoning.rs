//! The limit of a model's reasoning.

use std::str::FromStr;

/// How much a model on a server may reason before its answer. The tokens are added to the limit of every answer, because
/// servers count reasoning as a part of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reasoning {
    /// No reasoning, where the model can do without.
    Off,
    /// Little: 1,024 tokens.
    Low,
    /// 4,096 tokens.
    Medium,
    /// Much: 16,384 tokens.
    High,
    /// So many tokens.
    Tokens(u32),
}

impl Reasoning {
    /// Largest number of tokens.
    pub const MOST: u32 = 1_000_000;

    /// The tokens that are added to the limit of an answer.
    #[must_use]
    pub fn tokens(self) -> u32 {
        match self {
            Self::Off => 0,
            Self::Low => 1024,
            Self::Medium => 4096,
            Self::High => 16_384,
            Self::Tokens(tokens) => tokens.min(Self::MOST),
        }
    }

    /// The name of the effort in requests; none for a number of tokens.
    pub(crate) fn effort(self) -> Option<&'static str> {
        match self {
            Self::Off => Some("none"),
            Self::Low => Some("low"),
            Self::Medium => Some("medium"),
            Self::High => Some("high"),
            Self::Tokens(_) => None,
        }
    }
}

impl FromStr for Reasoning {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text {
            "off" => Self::Off,
            "low" => Self::Low,
            "medium" => Self::Medium,
            "high" => Self::High,
            number => match number.parse() {
                Ok(tokens @ 1..=Self::MOST) => Self::Tokens(tokens),
                _ => {
                    return Err(format!(
                        "must be off, low, medium, high or a number of tokens, at most {}",
                        Self::MOST
                    ));
                }
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasoning_parses_from_a_word_or_a_token_limit() {
        for (text, expected) in [
            ("off", Some(Reasoning::Off)),
            ("high", Some(Reasoning::High)),
            ("2000", Some(Reasoning::Tokens(2000))),
            ("0", None),
            ("1000001", None),
            ("-1", None),
            ("much", None),
            ("", None),
        ] {
            assert_eq!(text.parse().ok(), expected, "{text}");
        }
    }
}
