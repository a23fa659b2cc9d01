//! The hash of the texts of a domain.

use sha2::{Digest, Sha256};

/// Returns the hash of the texts that a domain was loaded from.
pub(super) fn content_hash(texts: &[&str]) -> String {
    let mut hash = Sha256::new();
    for text in texts {
        hash.update((text.len() as u64).to_le_bytes());
        hash.update(text.as_bytes());
    }
    hash.finalize()
        .iter()
        .take(8)
        .map(|byte| format!("{byte:02x}"))
        .collect()
}
