//! Ids of sessions, approvals, runs and campaigns.

use std::fmt;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};

/// The number of random bytes of an id: 128 bits, which nobody guesses.
const LENGTH: usize = 16;

/// Returns random bytes as hexadecimal digits.
///
/// # Errors
///
/// The operating system has no random numbers.
pub(crate) fn random(bytes: usize) -> Result<String, getrandom::Error> {
    let mut random = vec![0; bytes];
    getrandom::fill(&mut random)?;
    Ok(hexadecimal(&random))
}

/// Returns bytes as hexadecimal digits.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns the hash of data as hexadecimal digits, as many as those of an id.
pub(crate) fn hash(data: &Value) -> String {
    hexadecimal(&Sha256::digest(data.to_string())[..LENGTH])
}

/// Returns true for a text that an id may have: it becomes the name of a file.
fn is_id(text: &str) -> bool {
    let is_ours = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    (1..=100).contains(&text.len()) && text.chars().all(is_ours)
}

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(String);

        impl $name {
            /// Returns a new random id.
            pub(crate) fn random() -> Result<Self, getrandom::Error> {
                random(LENGTH).map(Self)
            }

            /// Reads an id; none for a text that is no id: another length, or a character besides letters, digits, `-` and `_`.
            pub fn parse(text: &str) -> Option<Self> {
                is_id(text).then(|| Self(text.to_owned()))
            }

            /// Returns the text.
            pub fn as_str(&self) -> &str {
                &self.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str(&self.0)
            }
        }
    };
}

id!(
    /// The id of a session.
    SessionId
);
id!(
    /// The id of an approval.
    ApprovalId
);
id!(
    /// The id of a run.
    RunId
);

/// The id of a campaign whose units several programs run: a hash of what it depends on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CampaignId(String);

impl CampaignId {
    /// Returns the id of the campaign with a description: equal descriptions mean one campaign.
    pub fn of(description: &Value) -> Self {
        Self(hash(description))
    }
}

impl fmt::Display for CampaignId {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn id_is_a_plain_file_name() {
        for (text, is_id) in [
            ("0af3", true),
            ("kitchen-1", true),
            ("", false),
            ("..", false),
            ("a/b", false),
            ("a b", false),
            ("ключ", false),
        ] {
            assert_eq!(SessionId::parse(text).is_some(), is_id, "{text}");
        }
        assert!(SessionId::parse(&"a".repeat(101)).is_none());
        let (one, other) = (RunId::random().unwrap(), RunId::random().unwrap());
        assert!(one != other && one.as_str().len() == 32 && RunId::parse(one.as_str()).is_some());
    }
}
