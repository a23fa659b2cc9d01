//! Drafts in, edits out.
