//! Keys that are never printed.

use std::fmt;

/// A key. Only [`Secret::reveal`] and [`Secret::header`] return it, and only requests use them.
#[derive(Clone)]
pub(super) struct Secret {
    header: &'static str,
    value: String,
}

impl Secret {
    /// A key for a header with this name.
    pub(super) fn new(header: &'static str, value: String) -> Self {
        Self { header, value }
    }

    /// A key for the `Authorization` header.
    pub(super) fn bearer(value: String) -> Self {
        Self::new("authorization", value)
    }

    pub(super) fn reveal(&self) -> &str {
        &self.value
    }

    /// The header with the key: name and value.
    pub(super) fn header(&self) -> (String, String) {
        let value = match self.header {
            "authorization" => format!("Bearer {}", self.value),
            _ => self.value.clone(),
        };
        (self.header.to_owned(), value)
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("[key]")
    }
}
