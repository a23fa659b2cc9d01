pub(crate) mod bench;
mod binding;
pub(crate) mod enumerated;
mod plans;
mod trees;
